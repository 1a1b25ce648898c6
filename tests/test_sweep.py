"""Running a study: the same bits however it runs, and nothing lost or done twice."""

import json
import math
import os
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_study import small_study

import scara_drake as sd
from scara_drake import metrics
from scara_drake.cli.main import main
from scara_drake.common.blocks import whole_blocks
from scara_drake.simulation import many
from scara_drake.simulation.many import Failed, each_run, whole_recording
from scara_drake.studies import backends, store
from scara_drake.studies.parameters import Range, Values
from scara_drake.studies.runs import Runs
from scara_drake.studies.store import Row, Store
from scara_drake.studies.study import load_study


@pytest.fixture(scope="module")
def uninterrupted():
    return sd.sweep(small_study(), jobs=1)


def rows_of(journal):
    """The rows of a journal: numbers, in the order in which they were kept."""
    with open(journal, "rb") as file:
        file.read(len(store.MAGIC))
        return [json.loads(b.content)[0] for b in whole_blocks(file) if b.kind == store.DONE]


def test_the_figures_are_those_of_each_run_by_itself(uninterrupted):
    runs = Runs(small_study())
    assert dict(uninterrupted.sizes) == {"payload": 3, "controller": 2, "seed": 2}
    assert uninterrupted.run.values.ravel().tolist() == list(range(12))
    for number in (0, 7, 11):
        recording = sd.simulate(runs.scenario(number))
        place = {name: uninterrupted[name].dtype.type(value) if name == "payload" else value
                 for name, value in runs.values(number).items() if name == "payload"}  # fmt: skip
        kind = type(runs.scenario(number).controller).__name__
        row = uninterrupted.sel(place, method=None).sel(controller=kind, seed=runs.seed(number))
        assert int(row.run) == number
        error = float(metrics.rmse(metrics.tool_error(recording)))
        assert float(row.tool_error_rms) == error
        assert bool(row.followed) == metrics.verdict(recording).good
        assert str(row.engine.values) == recording.attrs["engine"]
    assert not uninterrupted.failed.any()
    assert set(uninterrupted.ended_by.values.ravel()) == {"duration"}
    assert uninterrupted.payload.attrs["units"] == "kg"
    assert uninterrupted.tool_error_rms.attrs["units"] == "m"


def test_threads_give_the_bits_of_one(uninterrupted):
    assert sd.sweep(small_study(), jobs=3).identical(uninterrupted)


# The store.


@pytest.mark.parametrize("kept", [1, 7])
def test_a_study_that_was_killed_goes_on_to_the_same_bits_and_does_nothing_twice(
    kept, uninterrupted, tmp_path, monkeypatch
):
    path = tmp_path / "study.nc"
    script = Path(__file__).with_name("kill_study.py")
    ended = subprocess.run([sys.executable, str(script), str(path), str(kept)], check=False)
    assert ended.returncode == -signal.SIGKILL
    before = rows_of(path.with_suffix(".journal"))
    assert len(before) == kept
    assert not path.exists()
    done, add = [], Store.add

    def noted(self, number, row):
        add(self, number, row)
        done.append(number)
        if len(self.rows) == 12:
            assert rows_of(self.journal) == [*before, *done]

    monkeypatch.setattr(Store, "add", noted)
    result = sd.sweep(small_study(), path, jobs=1)
    assert result.identical(uninterrupted)
    assert sorted([*before, *done]) == list(range(12))
    assert [each.name for each in tmp_path.iterdir()] == ["study.nc"]
    # And once more: it is all there.
    monkeypatch.setattr(many, "run", lambda *arguments, **more: pytest.fail("run again"))
    assert sd.sweep(small_study(), path).identical(uninterrupted)


@pytest.fixture
def description():
    return json.dumps({"study": "some", "size": 3})


def row(number):
    return Row((0.1 * number, math.nan), "duration", "second: it is none", "compiled")


def filled(path, description, count=3):
    with Store(path, description) as kept:
        for number in range(count):
            kept.add(number, row(number))
    return path.with_suffix(".journal")


def same(first, second):
    return repr(first) == repr(second)  # NaN is not equal to itself


@pytest.mark.filterwarnings("ignore:.*no whole run")
def test_a_store_cut_at_any_byte_has_the_rows_before_it_and_goes_on(tmp_path, description):
    whole = filled(tmp_path / "whole.nc", description).read_bytes()
    ends = [len(filled(tmp_path / f"{n}.nc", description, n).read_bytes()) for n in (1, 2)]
    path = tmp_path / "cut.nc"
    for size in range(len(whole)):
        path.with_suffix(".journal").write_bytes(whole[:size])
        with Store(path, description) as kept:
            assert sorted(kept.rows) == list(range(sum(size >= end for end in ends)))
            assert all(same(kept.rows[number], row(number)) for number in kept.rows)
            for number in range(len(kept.rows), 3):
                kept.add(number, row(number))
        assert path.with_suffix(".journal").read_bytes() == whole


def test_a_damaged_row_and_what_follows_it_is_run_again(tmp_path, description):
    journal = filled(tmp_path / "study.nc", description)
    content = bytearray(journal.read_bytes())
    content[-len(content) // 4] ^= 1
    journal.write_bytes(content)
    with (
        pytest.warns(UserWarning, match="no whole run"),
        Store(tmp_path / "study.nc", description) as kept,
    ):
        assert sorted(kept.rows) in ([0], [0, 1])


@pytest.mark.parametrize("content", [b"", b"notes of mine", store.MAGIC + b"x" * 300])
def test_a_file_that_is_no_store_is_refused_and_left_alone(tmp_path, content, description):
    for suffix in (".journal", ".nc"):
        path = tmp_path / f"notes{suffix}"
        path.write_bytes(content)
        if content or suffix == ".nc":
            with pytest.raises(ValueError, match="store: "):
                Store(tmp_path / "notes.nc", description)
            assert path.read_bytes() == content
        path.unlink()


def test_a_store_of_another_study_is_refused_and_left_alone(tmp_path, uninterrupted, capsys):
    study = tmp_path / "study.yaml"
    study.write_text(
        "scenario: joint_sine\nduration: 0.05\nrepeats: 2\nmetrics: [energy]\nname: mine\n"
    )
    path = tmp_path / "study.nc"
    assert main(["sweep", str(study), "--store", str(path), "--jobs", "1"]) == 0
    said = capsys.readouterr()
    assert "mine: 2 runs" in said.out
    assert "energy" in said.out
    before = path.read_bytes()
    study.write_text(study.read_text().replace("0.05", "0.04"))
    assert main(["sweep", str(study), "--store", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"scara-drake: store: '{path}' is of another study")
    assert said.count("\n") == 1
    assert path.read_bytes() == before
    journal = filled(tmp_path / "begun.nc", "another")
    before = journal.read_bytes()
    with pytest.raises(ValueError, match="of another study"):
        sd.sweep(load_study(study), tmp_path / "begun.nc")
    assert journal.read_bytes() == before


def test_one_process_at_a_time_writes_a_store(tmp_path, description):
    with (
        Store(tmp_path / "study.nc", description),
        pytest.raises(ValueError, match="allowed one that no other run is writing"),
    ):
        Store(tmp_path / "study.nc", description)
    assert not list(tmp_path.iterdir())


# Failures.


def test_a_run_that_fails_is_told_and_loses_no_other(tmp_path):
    # The thin layer bears the first gain, and chatters with the second.
    study = small_study(
        parameters=[
            Range(["controller.rho"], "rho", 50.0, 300.0, 2),
            Values(["controller.phi"], "phi", [1.0, 0.4]),
        ],
        overrides={"controller.rho": 50.0},
        repeats=1,
    )
    runs = Runs(study)
    refused = []
    for number in range(4):
        try:
            runs.scenario(number)
        except ValueError:
            refused.append(number)
    assert refused == [3]
    result = sd.sweep(study, tmp_path / "study.nc", jobs=1)
    np.testing.assert_array_equal(np.flatnonzero(result.failed), refused)
    np.testing.assert_array_equal(np.isnan(result.energy), result.failed)
    for text in result.ended_by.values[result.failed.values]:
        assert text.startswith("error: controller")
    assert sd.sweep(study, tmp_path / "study.nc").identical(result)


def test_a_figure_that_a_run_does_not_have_is_nan_and_says_why():
    result = sd.sweep(small_study(metrics=["energy", "stable", "contact_share"]), jobs=1)
    assert result.stable.isnull().all()
    assert result.energy.notnull().all()
    assert not result.failed.any()
    (said,) = set(result.missing.values.ravel())
    assert said == (
        "stable: the operator is no !Master; contact_share: the scenario has no surface"
    )


# Many runs.


def scenarios(count=4, **overrides):
    return [
        sd.load_scenario("joint_sine", {"duration": 0.05, "seed": seed, **overrides})
        for seed in range(count)
    ]


def test_many_recordings_are_those_of_one_after_the_other():
    todo = scenarios()
    alone = [sd.simulate(scenario) for scenario in todo]
    for jobs in (1, 3):
        together = sd.simulate_many(todo, jobs=jobs)
        assert [one.identical(other) for one, other in zip(alone, together, strict=True)] == [
            True
        ] * 4


def test_a_figure_is_kept_as_the_runs_end_and_no_more_are_taken_ahead():
    taken = []

    def numbered():
        for number, scenario in enumerate(scenarios(6)):
            taken.append(number)
            yield 10 + number, scenario

    found = {}
    for number, result in each_run(numbered(), lambda scenario, recording: scenario.seed, jobs=2):
        found[number] = result
        assert len(taken) - len(found) <= 2
    assert found == {10 + seed: seed for seed in range(6)}


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_run_that_breaks_off_does_not_lose_the_others(jobs, monkeypatch):
    todo, run = scenarios(2), many.run
    todo.insert(1, replace(todo[0], name="breaks"))

    def breaks(scenario, *arguments, **more):
        if scenario.name == "breaks":
            raise RuntimeError("it broke")
        return run(scenario, *arguments, **more)

    monkeypatch.setattr(many, "run", breaks)
    with pytest.warns(UserWarning, match="run 1: it broke"):
        found = sd.simulate_many(todo, jobs=jobs, engine="auto")
    assert [each.attrs["ended_by"] for each in found] == ["duration", "error: it broke", "duration"]
    assert found[0].q_measured.size > 0
    assert not found[1].data_vars


def test_what_the_engine_cannot_run_goes_to_drake_with_the_same_bits():
    todo = scenarios(2, **{"controller": "!InverseDynamics {}"})
    alone = [sd.simulate(scenario) for scenario in todo]
    assert {each.attrs["engine"] for each in alone} == {"drake"}
    for one, other in zip(alone, sd.simulate_many(todo, jobs=2), strict=True):
        assert one.identical(other)
    results = dict(each_run(enumerate(todo), whole_recording, jobs=1, engine="compiled"))
    assert all(isinstance(result, Failed) for result in results.values())


def die(scenario, recording):
    """A figure whose process ends, for one of the seeds."""
    if scenario.seed == 1:
        os._exit(3)
    return scenario.seed


@pytest.mark.slow
def test_a_process_that_ends_loses_its_own_run_alone():
    found = dict(each_run(enumerate(scenarios(3)), die, jobs=2, engine="drake"))
    assert found[1] == Failed("its process ended")
    assert (found[0], found[2]) == (0, 2)


def test_bad_scenarios_and_jobs_are_refused_before_anything_runs(monkeypatch):
    monkeypatch.setattr(many, "run", lambda *arguments, **more: pytest.fail("it ran"))
    todo = scenarios(2)
    todo[1].duration = -1.0
    with pytest.raises(ValueError, match="duration: -1"):
        sd.simulate_many(todo)
    with pytest.raises(ValueError, match="jobs: 0, allowed 1 to"):
        sd.simulate_many(scenarios(1), jobs=0)
    with pytest.raises(ValueError, match="engine: 'fast', allowed auto"):
        sd.simulate_many(scenarios(1), engine="fast")


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_interrupt_ends_a_study_and_keeps_what_was_run(jobs, uninterrupted, tmp_path):
    path = tmp_path / "study.nc"
    add = Store.add

    def add_and_interrupt(self, number, row):
        add(self, number, row)
        if len(self.rows) == 5:
            threading.Timer(0.0, os.kill, (os.getpid(), signal.SIGINT)).start()
            threading.Event().wait(5.0)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Store, "add", add_and_interrupt)
        with pytest.raises(KeyboardInterrupt):
            sd.sweep(small_study(), path, jobs=jobs)
    assert len(rows_of(path.with_suffix(".journal"))) == 5
    assert sd.sweep(small_study(), path, jobs=jobs).identical(uninterrupted)


# Clusters.


CLUSTERS = [("dask", "distributed"), ("ray", "ray")]


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "module"), CLUSTERS)
def test_two_workers_of_a_cluster_give_the_bits_of_one_process(backend, module, uninterrupted):
    pytest.importorskip(module, reason=f"the extra '{backend}' is not installed")
    assert sd.sweep(small_study(), jobs=2, backend=backend).identical(uninterrupted)


@pytest.mark.parametrize("backend", ["dask", "ray"])
def test_a_backend_that_is_not_installed_is_refused(backend, monkeypatch, tmp_path):
    def missing(name):
        raise ModuleNotFoundError(f"No module named '{name}'")

    monkeypatch.setattr(backends, "import_module", missing)
    with pytest.raises(
        ValueError, match=f"backend: '{backend}', allowed with the extra '{backend}'"
    ):
        sd.sweep(small_study(), tmp_path / "study.nc", backend=backend)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("backend", "module"), CLUSTERS)
@pytest.mark.parametrize("address", ["127.0.0.1:1", "nobody.invalid:8786", "tcp://127.0.0.1:1"])
def test_an_address_that_nobody_answers_is_refused(backend, module, address, tmp_path, monkeypatch):
    pytest.importorskip(module, reason=f"the extra '{backend}' is not installed")
    monkeypatch.setattr(backends, "ANSWER", 1.0)
    with pytest.raises(
        ValueError, match=f"address: '{address}', allowed one that answers"
    ) as error:
        sd.sweep(small_study(), tmp_path / "study.nc", backend=backend, address=address)
    assert "\n" not in str(error.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("backend", "module"), CLUSTERS)
@pytest.mark.parametrize("says", [b"", b"SSH-2.0-OpenSSH_9.6\r\n", b"HTTP/1.1 400 Bad Request\r\n"])
def test_a_server_that_is_no_cluster_is_refused(backend, module, says, tmp_path, monkeypatch):
    pytest.importorskip(module, reason=f"the extra '{backend}' is not installed")
    monkeypatch.setattr(backends, "ANSWER", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(10.0)

        def answer():
            connection, _ = server.accept()
            with connection, suppress(OSError):
                connection.sendall(says)
                while connection.recv(100):
                    pass

        threading.Thread(target=answer, daemon=True).start()
        address = f"127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(ValueError, match=f"address: '{address}', allowed one that answers"):
            sd.sweep(small_study(), tmp_path / "study.nc", backend=backend, address=address)
    assert not list(tmp_path.iterdir())


def test_a_scheduler_at_an_address_runs_a_study(uninterrupted):
    distributed = pytest.importorskip("distributed", reason="the extra 'dask' is not installed")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        dashboard_address=None,
        silence_logs=50,
    ) as cluster:
        address = cluster.scheduler_address
        result = sd.sweep(small_study(), backend="dask", address=address)
    assert result.identical(uninterrupted)


# The picture.


def test_the_command_draws_a_picture(tmp_path, capsys):
    study = tmp_path / "study.yaml"
    study.write_text(
        "scenario: joint_sine\nduration: 0.05\nmetrics: [energy, stable]\nparameters:\n"
        "  - !Range {paths: robot.payload_mass, name: payload, high: 5.0, count: 2}\n"
    )
    out = ["--store", str(tmp_path / "a.nc"), "--picture", str(tmp_path / "deep" / "a.png")]
    assert main(["sweep", str(study), "--jobs", "1", *out]) == 0
    said = capsys.readouterr().out
    assert "Without a figure: stable: the operator is no !Master" in said
    assert (tmp_path / "deep" / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert isinstance(xr.open_dataset(tmp_path / "a.nc"), xr.Dataset)
    assert main(["sweep", str(study), "--store", "a.txt"]) == 2


def test_a_parameter_of_words_is_a_coordinate_of_words(tmp_path):
    delays = Values(["channel.up"], "link", ["!ConstantDelay {delay: 0.01}", "!SineDelay {}"])
    study = small_study(
        scenario="teleoperation", parameters=[delays], repeats=1, metrics=["followed"]
    )
    result = sd.sweep(study, tmp_path / "a.nc", jobs=1)
    assert result.link.values.tolist() == ["ConstantDelay delay 0.01", "SineDelay"]
    assert sd.sweep(study, tmp_path / "a.nc").identical(result)

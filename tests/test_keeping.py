"""What is recorded is kept, whatever ends a run, and one run never harms another's files."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from journalled import journalled
from pydrake.systems.framework import LeafSystem

import scara_drake as sd
from scara_drake.cli.main import main
from scara_drake.common.claimed_file import claim
from scara_drake.display.controls import StopButton
from scara_drake.recordings.files import open_recording, save_journal
from scara_drake.recordings.journal import Journal, survey
from scara_drake.simulation.interrupt import ENDING, DeferredInterrupt

# By Drake, so that a run is still under way when it is met.
LINE = [sys.executable, "-m", "scara_drake", "run", "joint_sine", "--no-realtime", "--no-meshcat"]
LINE += ["--engine", "drake"]


def start(record: Path, duration: float, **options: Any) -> subprocess.Popen[str]:
    command = [*LINE, "--set", f"duration={duration}", "--record", str(record)]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, **pipes, **options)


def wait_for(path: Path, size: int = 100_000) -> None:
    deadline = time.monotonic() + 120.0
    while not path.exists() or path.stat().st_size < size:
        assert time.monotonic() < deadline
        time.sleep(0.02)


# Names.


def test_a_claimed_file_is_nobody_else_s_until_it_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.journal"
    file, left_behind = claim(path)
    assert left_behind is None
    with pytest.raises(ValueError, match="allowed one that no other run is writing"):
        claim(path)
    file.write(b"first")
    file.close()
    file, left_behind = claim(path)
    assert left_behind is not None
    assert left_behind.read_bytes() == b"first"
    file.write(b"second")
    file.close()
    file, again = claim(path)
    file.close()
    assert again is not None
    assert len({left_behind, again, path}) == 3
    assert (left_behind.read_bytes(), again.read_bytes()) == (b"first", b"second")


def test_of_many_that_claim_at_once_one_gets_it_and_nothing_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    path.write_bytes(b"left")
    got: list[Any] = []
    barrier = threading.Barrier(8)

    def work() -> None:
        barrier.wait()
        try:
            got.append(claim(path))
        except ValueError:
            return

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(got) <= 1  # none, where each met another that was looking
    kept = [file for file in tmp_path.iterdir() if file.read_bytes() == b"left"]
    assert len(kept) == 1
    for file, _ in got:
        file.close()


def test_a_journal_without_samples_is_not_left(tmp_path: Path) -> None:
    with Journal(tmp_path / "a.journal") as journal:
        journal.begin({}, 1)
        assert journal.path.exists()
    assert list(tmp_path.iterdir()) == []


# Two runs.


def test_a_second_run_to_the_same_file_is_refused_at_its_start(tmp_path: Path) -> None:
    record = tmp_path / "run.nc"
    first = start(record, 600.0)
    wait_for(tmp_path / "run.journal", 1)
    second = start(record, 1.0)
    _, errors = second.communicate(timeout=120)
    assert second.returncode == 2
    assert errors.count("\n") == 1
    assert "run.journal', allowed one that no other run is writing" in errors
    first.send_signal(signal.SIGINT)
    first.communicate(timeout=120)
    assert first.returncode == 0
    data = sd.load_recording(record)
    assert data.attrs["ended_by"] == "interrupt"
    np.testing.assert_allclose(data.time, 1e-3 * np.arange(data.time.size), rtol=0, atol=1e-12)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_a_killed_run_leaves_a_journal_that_every_command_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = tmp_path / "run.nc"
    first = start(record, 600.0)
    wait_for(tmp_path / "run.journal")
    first.kill()
    first.communicate()
    whole = (tmp_path / "run.journal").read_bytes()
    again = [*LINE[3:], "--record", str(record), "--set"]
    assert main([*again, "duration=0.2"]) == 0
    said = capsys.readouterr().err
    (kept,) = tmp_path.glob("run.*.journal")
    assert f"Left by a run that was cut off: {kept}" in said
    assert "Overwrites" not in said
    assert main([*again, "duration=0.1"]) == 0
    said = capsys.readouterr().err
    assert f"Left by a run that was cut off: {kept}" in said
    assert f"Overwrites: {record}" in said
    assert kept.read_bytes() == whole

    data = sd.load_recording(kept)
    assert data.attrs["ended_by"] == "cut off"
    assert data.attrs["ended_at"] == float(data.time[-1])
    assert main(["recover", str(kept)]) == 0
    assert "ended by: cut off" in capsys.readouterr().out
    assert sd.load_recording(kept.with_suffix(".nc")).identical(data)
    assert main(["recover", str(kept)]) == 2  # nothing is written over
    assert main(["recover", str(record), "--output", str(tmp_path / "x.nc")]) == 2
    with pytest.raises(SystemExit) as ended:
        main(["replay", str(kept), "--html", str(tmp_path / "page.txt")])
    assert ended.value.code == 2
    assert capsys.readouterr().err.endswith("allowed a file that ends in .html\n")


# What ends a run.


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_run_as_an_interrupt_does(tmp_path: Path, number: signal.Signals) -> None:
    process = start(tmp_path / "run.nc", 600.0)
    wait_for(tmp_path / "run.journal")
    process.send_signal(number)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 128 + number
    assert "Traceback" not in errors
    data = sd.load_recording(tmp_path / "run.nc")
    assert data.attrs["ended_by"] == f"signal {number.name}"
    assert abs(data.attrs["ended_at"] - float(data.time[-1])) < 1e-3 + 1e-9
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_a_recording_may_be_judged_before_it_is_sealed(tmp_path: Path) -> None:
    journal, record = tmp_path / "run.journal", tmp_path / "run.nc"
    whole = journalled(sd.load_scenario("joint_sine", {"duration": 0.2}), journal).recording
    save_journal(journal, record, lambda data: {"verdict": f"{data.sizes['time']} samples"})
    loaded = sd.load_recording(record)
    assert loaded.attrs["verdict"] == "201 samples"
    assert loaded.equals(whole)


@pytest.mark.parametrize("first", ENDING)
def test_a_signal_while_it_is_saved_waits_and_a_second_one_keeps_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, first: signal.Signals
) -> None:
    journal, record = tmp_path / "run.journal", tmp_path / "run.nc"
    journalled(sd.load_scenario("joint_sine", {"duration": 0.3}), journal)
    seal, sent = sys.modules["scara_drake.recordings.files"].seal, 1

    def slow_seal(path: Path) -> None:
        for _ in range(sent):
            os.kill(os.getpid(), first)
            time.sleep(0.05)
        seal(path)

    monkeypatch.setattr(sys.modules["scara_drake.recordings.files"], "seal", slow_seal)
    with DeferredInterrupt(*ENDING) as signals:
        save_journal(journal, record)
    assert signals.signal == first
    assert sd.load_recording(record).sizes["time"] == 301
    record.unlink()
    sent = 2
    expected = KeyboardInterrupt if first == signal.SIGINT else SystemExit
    with pytest.raises(expected), DeferredInterrupt(*ENDING):
        save_journal(journal, record)
    assert [path.name for path in tmp_path.iterdir()] == ["run.journal"]


def test_a_signal_that_is_ignored_stays_so(monkeypatch: pytest.MonkeyPatch) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with DeferredInterrupt(*ENDING) as signals:
            os.kill(os.getpid(), signal.SIGHUP)
            time.sleep(0.05)
            assert not signals.pressed
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_whole_run_says_that_it_is_one() -> None:
    data = sd.simulate(sd.load_scenario("joint_sine", {"duration": 0.25}))
    assert (data.attrs["ended_by"], data.attrs["ended_at"]) == ("duration", 0.25)


def test_the_stop_button_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(StopButton, "pressed", lambda self: True)
    data = sd.simulate(sd.load_scenario("joint_sine", {"duration": 3.0}), engine="drake")
    assert data.attrs["ended_by"] == "stop button"
    assert 0.1 <= data.attrs["ended_at"] < 0.11


@dataclass
class Failing:
    """A controller that fails after a while."""

    def make_system(self, period: float) -> LeafSystem:
        return FailingSystem()


class FailingSystem(LeafSystem):
    def __init__(self) -> None:
        super().__init__()
        self.DeclareVectorInputPort("state", 12)
        self.DeclareVectorInputPort("state_desired", 12)
        self.DeclareVectorOutputPort("actuation", 6, self.calc)

    def calc(self, context: Any, output: Any) -> None:
        if context.get_time() > 0.35:
            raise ZeroDivisionError("the user's own mistake")
        output.SetFromVector(np.zeros(6))


def test_what_a_failing_run_recorded_is_kept_and_named() -> None:
    scenario = sd.load_scenario("joint_sine", {"duration": 2.0})
    scenario.controller = Failing()
    with pytest.raises(ZeroDivisionError, match="own mistake") as failed:
        sd.simulate(scenario)
    (note,) = failed.value.__notes__
    journal = Path(note.removeprefix("what was recorded is in "))
    data = sd.load_recording(journal)
    assert data.attrs["ended_by"] == "error: the user's own mistake"
    assert 0.34 < float(data.time[-1]) <= 0.36
    journal.unlink()
    journal.parent.rmdir()


# No space.

FULL = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), -1))
sys.modules["pydrake"] = None
from scara_drake.recordings.files import save_journal
try:
    save_journal(sys.argv[2], sys.argv[3])
except OSError as error:
    assert "\\n" not in str(error)
    sys.exit(3)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="this system has no limit of size")
def test_where_there_is_no_space_for_a_recording_nothing_is_left_of_it(tmp_path: Path) -> None:
    journal, record = tmp_path / "run.journal", tmp_path / "run.nc"
    journalled(sd.load_scenario("joint_sine", {"duration": 1.0}), journal)
    save_journal(journal, record)
    size = record.stat().st_size
    record.unlink()
    for share in (0.0, 0.9, 1.0 - 20 / size):
        line = [sys.executable, "-c", FULL, str(int(share * size)), str(journal), str(record)]
        result = subprocess.run(line, capture_output=True, text=True)
        assert (result.returncode, result.stderr) == (3, ""), share
        assert [path.name for path in tmp_path.iterdir()] == ["run.journal"]
    assert survey(journal).lost == 0


def test_a_journal_that_finds_no_space_ends_with_a_whole_block(tmp_path: Path) -> None:
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        with Journal(tmp_path / "a.journal") as journal:
            journal.begin({}, 10)
            resource.setrlimit(resource.RLIMIT_FSIZE, (5000, limits[1]))
            for block in range(5):
                journal.append(np.arange(10.0) + 10 * block, np.zeros((10, 10)))
            with pytest.raises(OSError, match="too large"):
                journal.append(np.arange(10.0) + 50, np.zeros((10, 10)))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    contents = survey(tmp_path / "a.journal")
    assert (contents.samples, contents.lost) == (50, 0)


PEAK = """
import resource, sys
sys.modules["pydrake"] = None
from scara_drake.recordings.files import save_journal
save_journal(sys.argv[1], sys.argv[2])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
save_journal(sys.argv[3], sys.argv[4])
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""


@pytest.mark.slow
def test_a_recording_is_made_piece_by_piece(tmp_path: Path) -> None:
    """The memory that it takes does not grow with the journal."""
    short, long = tmp_path / "short.journal", tmp_path / "long.journal"
    journalled(sd.load_scenario("joint_sine", {"duration": 10.0}), short)
    contents = survey(short)
    with Journal(long) as journal:
        journal.begin(contents.description, contents.width)
        for lap in range(8):
            for times, values in contents.read(1000):
                journal.append(times + 10.001 * lap, values)
    files = [str(path) for file in (short, long) for path in (file, file.with_suffix(".nc"))]
    result = subprocess.run(
        [sys.executable, "-c", PEAK, *files], capture_output=True, text=True, check=True
    )
    assert float(result.stdout) < 8.0, "[MB], of 25"
    with open_recording(long.with_suffix(".nc")) as data:
        assert data.sizes["time"] == 8 * 10_001
        first, last = data.q_measured[:10_001].values, data.q_measured[-10_001:].values
        np.testing.assert_array_equal(first, last)


def test_a_run_in_memory_is_the_one_in_a_journal(tmp_path: Path) -> None:
    scenario = sd.load_scenario("mast_step", {"duration": 0.25})
    for engine in ("drake", "compiled"):
        kept = journalled(scenario, tmp_path / f"{engine}.journal", engine).recording
        assert sd.simulate(scenario, engine=engine).identical(kept)

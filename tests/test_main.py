import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from scara_drake import joints, load_recording
from scara_drake.cli import show
from scara_drake.cli.main import main
from scara_drake.scenario import scenario_names


def run_line(capsys, *arguments):
    """Run the command line; return its status, output and errors."""
    status = main(list(arguments))
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_run_leaves_a_recording_and_a_summary(capsys, tmp_path):
    record = tmp_path / "out" / "sine.nc"
    status, out, _ = run_line(
        capsys, "run", "joint_sine", "--set", "duration=1.5", "--no-realtime", "--no-meshcat",
        "--record", str(record),
    )  # fmt: skip
    assert status == 0
    dataset = load_recording(record)
    assert dataset.sizes["time"] == 1501
    assert json.loads(dataset.attrs["versions"])["scara-drake"]
    settled = dataset.sel(time=slice(1.0, None))
    error = np.abs(settled.q_desired - settled.q_measured).max("time")
    assert f"{1e3 * float(error[1]):.3f} mrad" in out
    assert "real-time factor" in out
    assert [path.name for path in record.parent.iterdir()] == ["sine.nc"]


def test_run_writes_a_page(capsys, tmp_path):
    page = tmp_path / "page.html"
    status, _, _ = run_line(
        capsys, "run", "teleoperation", "--set", "duration=0.2", "--no-realtime",
        "--record", str(tmp_path / "run.nc"), "--html", str(page),
    )  # fmt: skip
    assert status == 0
    text = page.read_text()
    assert "http://" not in text.split("<script", maxsplit=1)[0]
    assert len(text) > 1_000_000


BAD = [
    (["run", "nope"], "scenario: 'nope', allowed bilateral, free_motion"),
    (["run", "joint_sine", "--set", "controler.phi=1"], "controler: unknown field"),
    (["run", "joint_sine", "--set", "controller.k=-1"], "controller.k[0]: -1.0, allowed 0 or more"),
    (["run", "joint_sine", "--set", "controller.k=.nan"], "controller.k[0]: nan, allowed 0 or"),
    (["run", "joint_sine", "--set", "phi"], "--set: 'phi', allowed KEY=VALUE"),
    (["run", "joint_sine", "--set", "operator.base=[1,0,0,0,0,0]"], "operator.base: d1 = 1 m"),
    (["run", "teleoperation", "--set", "channel.up.delay=7"], "channel.up"),
    (["run", "teleoperation", "--set", "operator.trace=no.csv"], "no.csv"),
    (["run", "joint_sine", "--record", "out.csv"], "--record: 'out.csv', allowed a file that ends"),
    (["run", "joint_sine", "--no-meshcat", "--html", "a.html"], "--html: needs the scene"),
    (["run", "teleoperation", "--set", "operator.device=joystick"], "joystick"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD)
def test_bad_input_is_one_line_status_two_and_no_file(
    capsys, tmp_path, monkeypatch, arguments, message
):
    monkeypatch.chdir(tmp_path)
    status, _, err = run_line(capsys, *arguments, "--no-realtime")
    assert status == 2
    assert err.count("\n") == 1
    assert message in err
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_bad_trace_file(capsys, tmp_path):
    for text, message in (
        ("time,x,y\n0,0,0\n", "z"),
        ("time,x,y,z,mast_axis,mast_hat\n0,0,nan,0,0,0\n", "nan"),
    ):
        (tmp_path / "trace.csv").write_text(text)
        status, _, err = run_line(
            capsys, "run", "teleoperation", "--no-realtime", "--no-meshcat",
            "--set", f"operator.trace={tmp_path / 'trace.csv'}",
            "--record", str(tmp_path / "run.nc"),
        )  # fmt: skip
        assert status == 2
        assert err.count("\n") == 1
        assert message in err
        assert not (tmp_path / "run.nc").exists()


def test_a_failed_run_is_status_one_and_keeps_the_journal(capsys, tmp_path, monkeypatch):
    target = sys.modules["scara_drake.simulation.steppers"]
    original = target.drain
    calls = []

    def fail(diagram, context):
        calls.append(0)
        if len(calls) == 4:
            raise RuntimeError("the solver gave up")
        return original(diagram, context)

    monkeypatch.setattr(target, "drain", fail)
    status, _, err = run_line(
        capsys, "run", "mast_step", "--no-realtime", "--no-meshcat", "--engine", "drake",
        "--record", str(tmp_path / "run.nc"),
    )  # fmt: skip
    assert status == 1
    assert "the solver gave up" in err
    assert not (tmp_path / "run.nc").exists()
    assert load_recording(tmp_path / "run.journal").sizes["time"] > 200


def test_an_interrupt_ends_the_run_cleanly_and_saves(tmp_path):
    record = tmp_path / "run.nc"
    process = subprocess.Popen(
        [sys.executable, "-m", "scara_drake", "run", "mast_step", "--no-meshcat",
         "--set", "duration=600", "--record", str(record)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    journal = tmp_path / "run.journal"
    while time.monotonic() < deadline:
        if journal.exists() and journal.stat().st_size > 100_000:
            break
        time.sleep(0.1)
    os.kill(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 0, out
    assert "Stopped early" in out
    assert load_recording(record).sizes["time"] > 100
    assert not (tmp_path / "run.journal").exists()


def test_diagrams_lists_and_draws(capsys, tmp_path):
    status, out, _ = run_line(capsys, "diagrams")
    assert status == 0
    for name in scenario_names():
        assert name in out


def test_show_opens_the_model_with_a_slider_for_each_joint(capsys, monkeypatch):
    meshcat = Meshcat()
    monkeypatch.setattr(show, "start_meshcat", lambda host, port: meshcat)
    status, out, _ = run_line(capsys, "show", "--once")
    assert status == 0
    assert meshcat.web_url() in out
    assert set(joints.JOINT_NAMES) <= set(meshcat.GetSliderNames())
    np.testing.assert_allclose(
        [meshcat.GetSliderValue(name) for name in joints.JOINT_NAMES], joints.HOME, atol=0.01
    )
    assert meshcat.HasPath("/drake/illustration/scara6/link_4")


def test_a_traceback_is_shown_on_request():
    with pytest.raises(ValueError, match="allowed bilateral, free_motion"):
        main(["--traceback", "run", "nope"])


def test_replay_refuses_what_is_no_recording(capsys, tmp_path):
    with pytest.raises(SystemExit) as ended:
        main(["replay", str(tmp_path / "none.nc")])
    assert ended.value.code == 2
    assert "allowed a file that exists" in capsys.readouterr().err

import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from kinds import of_kind

from scara_drake import load_scenario
from scara_drake.cli import tune as tune_command
from scara_drake.cli.main import main
from scara_drake.common.files import write_whole
from scara_drake.common.resources import resource
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.trace import load_trace
from scara_drake.scenario import check_scenario, dump_scenario

QUICK = ["tune", "joint_sine", "--duration", "0.05"]


@pytest.fixture(autouse=True)
def inside_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def run_line(capsys, *arguments):
    """Run the command line; return its status, output and errors."""
    status = main(list(arguments))
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def numbers(line):
    return [float(word) for word in re.findall(r"-?[\d.]+(?:e[-+]\d+)?", line)]


def test_the_result_is_a_scenario_that_runs(capsys):
    status, out, _ = run_line(
        capsys, *QUICK, "--trials", "4", "--set", "robot.payload_mass=20", "--seed", "2"
    )
    assert status == 0
    assert "Scenario: runs/joint_sine_tuned.yaml" in out
    (cost,) = [numbers(line) for line in out.splitlines() if line.split()[:1] == ["cost"]]
    assert cost[0] == 1.1
    assert cost[1] <= cost[0]
    assert list(Path("runs").iterdir()) == [Path("runs/joint_sine_tuned.yaml")]
    tuned = load_scenario("runs/joint_sine_tuned.yaml")
    start = load_scenario("joint_sine")
    assert (tuned.name, tuned.duration) == ("joint_sine_tuned", start.duration)
    assert tuned.robot.payload_mass == 20.0
    assert tuned.operator == start.operator
    check_scenario(tuned)
    status, _, err = run_line(
        capsys, "run", "runs/joint_sine_tuned.yaml", "--set", "duration=0.05", "--no-realtime",
        "--no-meshcat",
    )  # fmt: skip
    assert (status, Path("runs/joint_sine_tuned.nc").is_file()) == (0, True), err


def test_the_tables_show_the_figures_before_and_after(capsys):
    _, out, _ = run_line(capsys, *QUICK, "--trials", "4", "--tracking", "itae")
    for what in ("d1 ITAE", "theta6 ITAE", "d1 effort variation", "mm s", "mrad s", "N m"):
        assert what in out
    tuned = load_scenario("runs/joint_sine_tuned.yaml")
    gains = of_kind(IntegralSlidingMode, tuned.controller)
    for gain in (*gains.c, *gains.phi):
        assert f"{gain:.4g}" in out


def test_help_states_the_cost(capsys):
    with pytest.raises(SystemExit):
        main(["tune", "--help"])
    out = capsys.readouterr().out
    assert "J = mean((E + e) / (E0 + e)) + W mean((V + v) / (V0 + v))" in out


BAD = [
    (["tune", "nope"], "scenario: 'nope', allowed bilateral, free_motion"),
    ([*QUICK, "--set", "controller.k"], "--set: 'controller.k', allowed KEY=VALUE"),
    ([*QUICK, "--set", "controller.k=-1"], "controller.k[0]: -1.0, allowed 0 or more"),
    ([*QUICK, "--set", "controller.phi=0.001"], "controller: chatters"),
    ([*QUICK, "--trials", "0"], "trials: 0, allowed 1 to"),
    ([*QUICK, "--seed", "-3"], "seed: -3, allowed 0 to"),
    (["tune", "joint_sine", "--duration", "nan"], "duration: nan, allowed 0.001 to 86400"),
    ([*QUICK, "--tracking", "mae"], "tracking: 'mae', allowed rmse, itae"),
    ([*QUICK, "--effort-weight", "-1"], "effort_weight: -1.0, allowed 0 to"),
    ([*QUICK, "--jobs", "0"], "jobs: 0, allowed 1 to 64"),
    ([*QUICK, "--output", "gains.json"], "--output: 'gains.json', allowed a file that ends"),
    ([*QUICK, "--study", "study.nc"], "study: 'study.nc', allowed a file that ends in .db"),
    (["tune", "teleoperation", "--set", "operator.device=auto"], "operator.device: 'auto'"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD)
def test_bad_input_is_one_line_and_writes_nothing(capsys, arguments, message):
    status, out, err = run_line(capsys, *arguments)
    assert status == 2
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
    assert not list(Path().iterdir())


def test_without_its_extra(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    for name in ("cli.tune", "tuning.search", "tuning.space"):
        monkeypatch.delitem(sys.modules, f"scara_drake.{name}", raising=False)
    status, _, err = run_line(capsys, *QUICK)
    assert status == 2
    assert "allowed with the extra 'tune' installed" in err
    assert err.count("\n") == 1


# Where the trace is.


def assert_same_trace(path, expected):
    found = load_trace(of_kind(Joystick, load_scenario(path).operator).trace_path())
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_a_trace_beside_the_scenario_is_found_from_anywhere(capsys, monkeypatch):
    folder = Path("mine")
    folder.mkdir()
    shutil.copy(resource("diagrams", "teleoperation.yaml"), folder / "press.yaml")
    lines = resource("diagrams", "operator_trace.csv").read_text().splitlines()
    (folder / "operator_trace.csv").write_text("\n".join(lines[:40]) + "\n")
    expected = load_trace(folder / "operator_trace.csv")
    status, _, err = run_line(
        capsys, "tune", "mine/press.yaml", "--duration", "0.02", "--trials", "1", "--output",
        "elsewhere/press.yaml",
    )  # fmt: skip
    assert status == 0, err
    output = Path("elsewhere/press.yaml").resolve()
    assert_same_trace(output, expected)
    Path("other").mkdir()
    monkeypatch.chdir("other")
    assert_same_trace(output, expected)


def test_a_shipped_trace_keeps_its_name_unless_another_has_it():
    shipped = load_scenario("teleoperation")
    moved = tune_command.with_files_from(shipped, Path("runs"))
    assert of_kind(Joystick, moved.operator).trace == "operator_trace.csv"
    Path("runs").mkdir()
    Path("runs/operator_trace.csv").write_text("time,x,y,z,mast_axis,mast_hat\n0,1,0,0,0,0\n")
    kept = tune_command.with_files_from(shipped, Path("runs"))
    write_whole("runs/out.yaml", dump_scenario(kept))
    assert_same_trace("runs/out.yaml", load_trace(resource("diagrams", "operator_trace.csv")))
    assert of_kind(Joystick, shipped.operator).trace == "operator_trace.csv"


# Interrupted and killed.


def test_a_write_that_fails_leaves_the_file_before_it(monkeypatch):
    path = Path("best.yaml")
    path.write_text("before")

    def fail(*arguments):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_whole(path, dump_scenario(load_scenario("joint_sine")))
    assert path.read_text() == "before"
    assert list(Path().iterdir()) == [path]


def counted(study):
    """Return the number of trials that a study has finished."""
    try:
        with sqlite3.connect(f"file:{study}?mode=ro", uri=True) as file:
            query = "SELECT count(*) FROM trials WHERE state = 'COMPLETE'"
            return file.execute(query).fetchone()[0]
    except sqlite3.OperationalError:
        return 0  # not there yet


def start_and_send(sent, *arguments):
    """Run the command until it has three trials, send a signal; return its status and output."""
    process = subprocess.Popen(
        [sys.executable, "-m", "scara_drake", *arguments, "--study", "study.db"],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    deadline = time.monotonic() + 120
    while counted("study.db") < 3 and time.monotonic() < deadline:
        time.sleep(0.02)
    os.kill(process.pid, sent)
    out, _ = process.communicate(timeout=60)
    return process.returncode, out


def test_an_interrupt_writes_the_best_so_far():
    status, out = start_and_send(signal.SIGINT, *QUICK, "--trials", "100000")
    assert status == 0, out
    assert "Stopped early" in out
    assert "Traceback" not in out
    load_scenario("runs/joint_sine_tuned.yaml")


def test_a_kill_leaves_a_study_that_goes_on(capsys):
    status, _ = start_and_send(signal.SIGKILL, *QUICK, "--trials", "100000")
    assert status == -signal.SIGKILL
    assert not Path("runs").exists()
    done = counted("study.db")
    wanted = str(done + 2)
    arguments = [*QUICK, "--trials", wanted]
    status, out, err = run_line(capsys, *arguments, "--study", "study.db")
    assert status == 0, err
    assert f"{wanted} trials" in out
    assert counted("study.db") == done + 2
    assert run_line(capsys, *arguments, "--output", "at_once.yaml")[0] == 0
    killed, at_once = load_scenario("runs/joint_sine_tuned.yaml"), load_scenario("at_once.yaml")
    assert killed.controller == at_once.controller

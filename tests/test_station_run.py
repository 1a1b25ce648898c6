"""A run under the hands of a page: who moves the arm, and that it is held when he is gone."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from station_rig import Page, serving, wait_until

from scara_drake.cli.main import main
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.samples import Samples
from scara_drake.safety import State
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import Live, run_into
from scara_drake.station.station import Station

AT_REST = 5e-3  # [m/s]
FAR = 0.02  # [m]


def lent(station: Station, duration: float) -> Scenario:
    scenario = load_scenario("free_motion", {"duration": duration})
    operator: Any = scenario.operator
    operator.lend(station.device)
    return scenario


def drive(page: Page, begun: threading.Event) -> None:
    """Engage, push the stick until the tool has gone some way, and go."""
    page.takes()
    begun.set()
    while page.hears("telemetry")["t"] < 0.1:
        page.moves(0, 0, 0, 0, 0)
    engage, start = False, None
    while True:
        told = page.hears("telemetry")
        tool = np.array(told["tool"][:3])
        start = tool if start is None else start
        if np.linalg.norm(tool - start) > FAR:
            return
        # A machine that is busy may be silent for so long that the arm holds: then anew.
        engage = told["operator"]["state"] == State.ACTIVE or not engage
        page.moves(0.8 * engage, 0, 0, 0, 0, engage=engage)


def test_the_page_moves_the_arm_and_closing_it_holds_the_arm() -> None:
    samples, begun = Samples(), threading.Event()
    with serving(scenario="free_motion") as station:

        def sit_at_it() -> None:
            with Page(station.address) as page:
                drive(page, begun)

        thread = threading.Thread(target=sit_at_it)
        thread.start()
        begun.wait()
        assert station.has_page()
        run_into(samples, lent(station, 6.0), Live(1.0, station=station))
        thread.join()
    recording = samples.recording()
    assert recording.attrs["device"] == station.device.name
    connected = recording.device_connected.values > 0.5
    last = int(np.flatnonzero(connected)[-1])
    assert last < connected.size - 1000, "the page did not get so far in time"
    tool = forward_kinematics(recording.q_measured.values)[:, :3, 3]
    speed = np.linalg.norm(np.gradient(tool, 1e-3, axis=0), axis=1)
    assert speed[: last + 1].max() > AT_REST
    assert speed[last + 1000 :].max() < AT_REST
    if "operator_state" in recording:
        assert int(recording.operator_state[-1]) == State.HOLD


def test_a_server_that_stands_still_does_not_stop_a_run() -> None:
    samples = Samples()
    with serving(scenario="free_motion") as station:
        os.kill(station._process.pid, signal.SIGSTOP)
        try:
            ended = run_into(samples, lent(station, 0.3), Live(station=station))
        finally:
            os.kill(station._process.pid, signal.SIGCONT)
    assert ended.ended_by == "duration"
    assert samples.recording().time[-1] == pytest.approx(0.3)


def test_a_scenario_of_a_station_runs_in_a_station_only() -> None:
    scenario = load_scenario("free_motion", {"operator.device": "station", "duration": 0.1})
    with pytest.raises(ValueError, match=r"^operator.device: .*station.*, allowed with"):
        run_into(Samples(), scenario)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["joint_sine"], r"operator: 'JointMotion', allowed Joystick"),
        (["free_motion", "--port", "70000"], r"port: 70000, allowed 1 to 65535"),
        (["free_motion", "--tls-cert", "a.pem"], r"tls: one file, allowed both"),
        (["free_motion", "--tls-cert", "a", "--tls-key", "b"], r"tls: 'a', 'b', allowed a cert"),
        (["free_motion", "--record", "x.csv"], r"--record: 'x.csv', allowed"),
    ],
)
def test_bad_input_is_one_line(
    arguments: list[str],
    words: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["station", *arguments, "--no-browser"]) == 2
    out = capsys.readouterr().err
    assert out.count("\n") == 1
    assert re.search(words, out)
    assert list(tmp_path.rglob("*.nc")) == []


@pytest.mark.slow  # a program of its own, which compiles for a minute the first time
def test_the_command_runs_until_it_is_ended(tmp_path: Path) -> None:
    record = tmp_path / "run.nc"
    command = [sys.executable, "-m", "scara_drake", "station", "free_motion", "--no-browser"]
    program = subprocess.Popen(
        [*command, "--record", str(record)], stdout=subprocess.PIPE, text=True
    )
    assert program.stdout is not None
    line = next(line for line in program.stdout if line.startswith("Station: "))
    assert "(this machine only)" in line
    with Page(line.split()[1]) as page:
        while page.hears("telemetry")["t"] < 0.2:
            pass
        program.send_signal(signal.SIGTERM)
        assert str(record) in page.hears("ended")["files"]
    out, _ = program.communicate()
    assert program.returncode == 128 + signal.SIGTERM
    assert "Verdict" in out
    wait_until(record.is_file)

"""The station for minutes in real time, with a page that steers and falls silent now and then.

``python benchmarks/station_soak.py --minutes 10`` prints how late the ticks were, how much the
memory grew, and how long after each silence the arm was held. The page that steers is a process of
its own; with chromium installed a browser looks on too. The run asks for real-time priority.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

SILENCE, EVERY = 1.0, 30.0  # how long and how often the page says nothing [s]
PERIOD = 0.02  # between what it says [s]
MISSED = 0.5  # of silence, and the robot still active [s]
CHROMIUM = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", "--window-size=640,400")  # fmt: skip


def steer(address: str, duration: float, pid: int) -> None:
    """Steer as a page does, and print how much memory the run had every five seconds [kB]."""
    from websockets.sync.client import connect

    with connect(f"ws{address.removeprefix('http')}ws", max_size=None, compression=None) as page:
        page.send(json.dumps({"type": "control", "action": "take"}))
        start, seen, held = time.monotonic(), list[int](), 0.0
        while (t := time.monotonic() - start) < duration:
            silent = t % EVERY > EVERY - SILENCE
            held = 0.0 if silent else held + PERIOD
            if not silent:
                axes = [0.3 * np.sin(t), 0.2 * np.sin(1.3 * t), 0.0, 0.0, 0.0]
                engage = {"engage": held > 0.5}
                page.send(
                    json.dumps({"type": "input", "axes": axes, "buttons": engage, "device": "soak"})
                )
            while True:
                try:
                    told = page.recv(PERIOD / 2)
                except TimeoutError:
                    break
                if isinstance(told, bytes):
                    drawn = int.from_bytes(told[:4], "little")
                    page.send(json.dumps({"type": "drawn", "frame": drawn}))
                if time.monotonic() - start > t + PERIOD:
                    break
            if len(seen) <= t / 5.0:
                seen.append(_memory(pid))
    print(json.dumps(seen))


def _memory(pid: int) -> int:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmRSS")))


def reactions(recording: xr.Dataset) -> tuple[list[float], int]:
    """Ages of the device at which its supervisor stopped it [s]; how often the robot went on."""
    from scara_drake.safety import State

    active = recording.operator_state.values == State.ACTIVE
    age, robot = recording.device_age.values, recording.robot_state.values
    stops = np.flatnonzero(active[:-1] & ~active[1:]) + 1
    told = [float(age[stop]) for stop in stops if age[stop] > 2.0 * PERIOD]
    silent = age > MISSED
    missed = silent & (robot == State.ACTIVE)
    return told, int(np.count_nonzero(np.diff(missed.astype(int)) > 0))


def main() -> None:
    """Run it and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--scenario", default="free_motion")
    parser.add_argument("--no-browser", action="store_true", help="nobody looks on")
    parser.add_argument("--steer", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.steer:
        address, duration, pid = options.steer
        steer(address, float(duration), int(pid))
        return
    for name, value in soak(options).items():
        print(f"{name:38s} {value}")


def soak(options: argparse.Namespace) -> dict[str, str]:
    """Return the rows of the table."""
    from scara_drake.cli.kernels import compile_kernels
    from scara_drake.cli.summary import timing_words
    from scara_drake.recordings.files import load_recording
    from scara_drake.recordings.journal import Journal
    from scara_drake.scenario import load_scenario
    from scara_drake.simulation.run import Live, run_into
    from scara_drake.station.place import Place
    from scara_drake.station.station import Station

    duration = 60.0 * options.minutes
    scenario = load_scenario(options.scenario, {"duration": duration})
    compile_kernels(scenario)
    folder = Path(tempfile.mkdtemp())
    station, others = Station(scenario, Place("127.0.0.1", 0)), list[subprocess.Popen[Any]]()
    try:
        operator: Any = scenario.operator
        operator.lend(station.device)
        command = [
            sys.executable,
            __file__,
            "--steer",
            station.address,
            str(duration),
            str(os.getpid()),
        ]
        page = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        others.append(page)
        browser = None if options.no_browser else shutil.which("chromium")
        if browser:
            others.append(
                subprocess.Popen(
                    [browser, *CHROMIUM, f"--user-data-dir={folder / 'browser'}", station.address],
                    stderr=subprocess.DEVNULL,
                )
            )
        while not station.has_page():
            time.sleep(0.05)
        with Journal(folder / "soak.journal") as journal:
            live = Live(1.0, priority=True, station=station)
            ended = run_into(journal, scenario, live)
            recording = load_recording(journal.path)
        memory = json.loads(page.communicate(timeout=60.0)[0].splitlines()[-1])
    finally:
        for other in others:
            other.terminate()
        station.close()
    told, missed = reactions(recording)
    early, late = np.median(memory[1 : 3 + len(memory) // 10]), np.median(memory[-3:])
    assert ended.timing is not None
    return {
        "simulated": f"{ended.simulated:.0f} s, real-time factor {ended.real_time_factor:.3f}",
        "browser": "chromium looks on" if browser else "none",
        "lateness": timing_words(ended.timing),
        "memory": f"{early / 1024:.0f} to {late / 1024:.0f} MB, {late / early - 1.0:+.1%}",
        "stops after a silence": str(len(told)),
        "age of the device at the stop": ", ".join(
            f"{name} {1e3 * value:.0f} ms"
            for name, value in (("median", np.median(told)), ("largest", max(told)))
        )
        if told
        else "none",
        "silences that the robot did not stop at": str(missed),
    }


if __name__ == "__main__":
    main()

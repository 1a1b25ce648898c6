"""The command `scara-drake station`: run a scenario under the hands of whoever opens its page."""

from __future__ import annotations

import argparse
import sys
import time
import webbrowser
from importlib.util import find_spec
from typing import Any

from rich.console import Console

from scara_drake.cli.parser import STATION_DURATION
from scara_drake.cli.recorded import (
    end_by_signal,
    recording_to,
    run_and_tell,
    status_of,
    what_to_run,
)
from scara_drake.metrics import Verdict
from scara_drake.operator.joystick import LENT
from scara_drake.scenario import Scenario
from scara_drake.simulation.kernels import compile_kernels
from scara_drake.simulation.run import Live
from scara_drake.station.place import LOOPBACK, Place
from scara_drake.station.station import Station

REALTIME = 1.0
LOOK = 0.05  # whether a page is open [s]
for _name in ("starlette", "uvicorn", "websockets", "meshcat"):  # which the server's process needs
    if find_spec(_name) is None:
        raise ModuleNotFoundError(f"No module named '{_name}'", name=_name)


def run(options: argparse.Namespace, console: Console) -> int:
    """Serve the station of a scenario, simulate it in real time, record it, print the summary.

    The run begins when somebody opens the page.

    Returns:
        The exit status, as of `scara-drake run`.

    Raises:
        ValueError: bad input; one line.
        RuntimeError: the run failed; says where what was recorded is kept.
        OSError: nobody can listen there, or a file cannot be written.
    """
    scenario, record = what_to_run(options)
    if options.duration is None and scenario.task is None:
        scenario.duration = STATION_DURATION
    place = Place(options.host, options.port, options.tls_cert, options.tls_key)
    operator: Any = scenario.operator
    if not hasattr(operator, "lend"):
        kind = type(operator).__name__
        raise ValueError(f"operator: '{kind}', allowed Joystick for a station")
    operator.device = LENT  # so that what is compiled is what runs, its supervisor too
    with recording_to(record, scenario, console) as (journal, signals):
        compile_kernels(scenario)
        station = Station(scenario, place)
        try:
            _say_where(console, station, place, options.no_browser)
            operator.lend(station.device)
            while not station.has_page():
                signals.raise_if_pressed()
                time.sleep(LOOK)
            live = Live(REALTIME, priority=True, station=station)
            verdict = run_and_tell(console, scenario, live, record, journal, signals)
            station.end(verdict.good, _lines(scenario, verdict), [str(record)])
        finally:
            station.close()
    end_by_signal(signals)
    return status_of(verdict)


def _say_where(console: Console, station: Station, place: Place, quiet: bool) -> None:
    """Say where the page is, and open it."""
    told = "this machine only" if place.is_local else "whoever has this address can take control"
    console.print(f"Station: {station.address} ({told})", soft_wrap=True, highlight=False)
    if not place.is_local and place.tls_cert is None:
        console.print(
            "Without TLS others on the network can read that address, and browsers elsewhere offer "
            "no gamepad: --tls-cert, --tls-key.",
            soft_wrap=True,
            highlight=False,
        )
    if not quiet and place.host == LOOPBACK and sys.stdout.isatty():
        webbrowser.open(station.address)


def _lines(scenario: Scenario, verdict: Verdict) -> list[str]:
    """Return what the pages are told at the end."""
    return [f"{scenario.name}: {verdict}.", *(f"Note: {remark}." for remark in verdict.remarks)]

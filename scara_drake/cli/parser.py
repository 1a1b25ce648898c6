"""The arguments of the command line. Nothing heavy is imported: the help is there at once."""

from __future__ import annotations

import argparse
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from scara_drake.cli.attack_arguments import add_attack
from scara_drake.cli.device_arguments import add_devices
from scara_drake.cli.reproduce_arguments import add_reproduce
from scara_drake.cli.study_arguments import add_scenario, add_sweep, add_tune
from scara_drake.exports.formats import FORMATS
from scara_drake.joints import JOINT_NAMES
from scara_drake.replay.arguments import LOOPBACK
from scara_drake.replay.arguments import add_arguments as add_replay_arguments

IK_EPILOG: Final = """\
The pose is that of the tool frame in the world, z up from mast height 0. Its orientation is
Rx(roll) Ry(pitch) Rz(yaw), angles about the axes x, y and z as they turn along (intrinsic xyz);
Drake's RollPitchYaw is Rz(yaw) Ry(pitch) Rx(roll). --unit and --angle hold for poses; postures
(--q-seed, --mast and the answers) are in m and rad.

Exit status: 0 where every pose is solved, 1 where one is not, 2 for bad input.

  scara-drake ik --position 1.2 -0.4 3 --rpy 90 0 20 --angle deg
  scara-drake ik --csv poses.csv --unit mm --path --output joints.csv
"""
# Of `scara_drake.ik`, whose import takes seconds.
IK_METHODS: Final = (
    "closed_form",
    "robust",
    "inverse_jacobian",
    "pso",
    "dpso",
    "dpsoij",
)
IK_METHOD: Final = "robust"
STATION_DURATION: Final = 600.0  # [s]
POSE_COLUMNS: Final = ("x", "y", "z", "roll", "pitch", "yaw")


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line.

    Its result has `module`, which runs the command by ``run(options, console)``, and `extra`, the
    optional dependencies that it needs, or "".
    """
    parser = argparse.ArgumentParser(
        prog="scara-drake",
        description="Run a scenario, show the model, solve inverse kinematics, tune, replay.",
    )
    parser.add_argument("--version", action="version", version=version("scara-drake"))
    parser.add_argument("--traceback", action="store_true", help="show where an error comes from")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")
    for add in (
        _add_run,
        _add_station,
        _add_compile,
        _add_show,
        _add_diagrams,
        add_devices,
        _add_ik,
        add_tune,
        add_sweep,
        add_attack,
        _add_replay,
        _add_recover,
        _add_compare,
        _add_report,
        _add_export,
        add_reproduce,
    ):
        add(commands)
    return parser


def _add_run(commands: Any) -> None:
    parser = commands.add_parser("run", help="simulate a scenario and record it")
    add_scenario(parser, "name of a shipped scenario, or a YAML file")
    parser.add_argument(
        "--duration", type=float, metavar="T", help="of the run [s] (default: the scenario's)"
    )
    parser.add_argument("--record", type=Path, metavar="FILE.nc", help="default runs/SCENARIO.nc")
    parser.add_argument("--html", type=Path, metavar="FILE.html", help="page to play offline")
    parser.add_argument("--no-realtime", action="store_true", help="as fast as it goes")
    parser.add_argument(
        "--realtime-priority",
        action="store_true",
        help="ask the system to run it before other programs (SCHED_FIFO, else nice)",
    )
    parser.add_argument("--no-meshcat", action="store_true", help="without the scene")
    parser.add_argument(
        "--engine",
        default="auto",
        help="auto, compiled or drake: what runs it (default auto: compiled where nobody watches)",
    )
    _add_server(parser)
    parser.set_defaults(module="scara_drake.cli.run", extra="")


def _add_station(commands: Any) -> None:
    parser = commands.add_parser(
        "station",
        help="run a scenario in real time, operated from a page in any browser",
        description="Serve the operator's station of a scenario and run it in real time.",
    )
    add_scenario(parser, "name of a shipped scenario, or a YAML file")
    parser.add_argument(
        "--duration",
        type=float,
        metavar="T",
        help=f"of the run [s] (default {STATION_DURATION:g}, or as long as a task takes)",
    )
    parser.add_argument("--record", type=Path, metavar="FILE.nc", help="default runs/SCENARIO.nc")
    parser.add_argument(
        "--host", default=LOOPBACK, help=f"where it listens, * for all networks; default {LOOPBACK}"
    )
    parser.add_argument("--port", type=int, default=0, help="default one that is free")
    parser.add_argument("--tls-cert", type=Path, metavar="FILE", help="certificate, for https")
    parser.add_argument("--tls-key", type=Path, metavar="FILE", help="its key")
    parser.add_argument("--no-browser", action="store_true", help="only say where the page is")
    parser.set_defaults(module="scara_drake.cli.station", extra="station")


def _add_compile(commands: Any) -> None:
    parser = commands.add_parser("compile", help="compile the kernels, so that no run has to")
    parser.add_argument(
        "scenarios", nargs="*", metavar="SCENARIO", help="what they need (default: all shipped)"
    )
    parser.set_defaults(module="scara_drake.cli.compile", extra="")


def _add_show(commands: Any) -> None:
    parser = commands.add_parser("show", help="the model in Meshcat, a slider for each joint")
    parser.add_argument("--once", action="store_true", help="leave after the first picture")
    _add_server(parser)
    parser.set_defaults(module="scara_drake.cli.show", extra="")


def _add_server(parser: argparse.ArgumentParser) -> None:
    """Add where the scene is served."""
    parser.add_argument(
        "--host", default="", help="where the scene is served, * for all networks; default: here"
    )
    parser.add_argument("--port", type=int, help="default the first free one from 7000 on")


def _add_diagrams(commands: Any) -> None:
    parser = commands.add_parser("diagrams", help="list the runnable Diagrams, draw them")
    parser.add_argument("--render", type=Path, metavar="FOLDER", help="write NAME.svg files")
    parser.set_defaults(module="scara_drake.cli.diagrams", extra="")


def _add_replay(commands: Any) -> None:
    parser = commands.add_parser("replay", help="play a recording again")
    add_replay_arguments(parser)
    parser.set_defaults(module="scara_drake.cli.replay", extra="replay")


def _add_recover(commands: Any) -> None:
    parser = commands.add_parser(
        "recover", help="make a recording of the journal of a run that was cut off"
    )
    parser.add_argument("journal", type=Path, metavar="JOURNAL")
    parser.add_argument(
        "--output", type=Path, metavar="FILE.nc", help="default: beside it, by its name"
    )
    parser.set_defaults(module="scara_drake.cli.recover", extra="")


def _add_compare(commands: Any) -> None:
    parser = commands.add_parser("compare", help="recordings beside each other: what differs")
    parser.add_argument(
        "recordings", nargs="+", type=Path, metavar="FILE.nc", help="the others against the first"
    )
    parser.add_argument(
        "--html", type=Path, metavar="FILE.html", help="page with the tables and the curves"
    )
    parser.set_defaults(module="scara_drake.cli.compare", extra="")


def _add_report(commands: Any) -> None:
    parser = commands.add_parser("report", help="after-action report of a recording, a page")
    parser.add_argument("recording", type=Path, metavar="FILE.nc")
    parser.add_argument(
        "--html", type=Path, metavar="FILE.html", help="default: beside it, by its name"
    )
    parser.set_defaults(module="scara_drake.cli.report", extra="")


def _add_export(commands: Any) -> None:
    formats = "\n".join(f"  {name:8} {each.suffix:8} {each.what}" for name, each in FORMATS.items())
    parser = commands.add_parser(
        "export",
        help="write a recording for other programs: CSV, Parquet, MCAP, rerun, trace",
        description="Write a recording, or a journal, in a format of other programs.",
        epilog=f"formats:\n{formats}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("recording", type=Path, metavar="FILE.nc")
    parser.add_argument(
        "--to", metavar="FORMAT", help="default: what the output's suffix says, or csv"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="OUT", help="default: beside it, by its name"
    )
    parser.set_defaults(module="scara_drake.cli.export", extra="")


def _add_ik(commands: Any) -> None:
    parser = commands.add_parser(
        "ik",
        help="inverse kinematics of a pose, or of the poses of a CSV file",
        description="Joint values for a pose, or for the poses of a CSV file.",
        epilog=IK_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    # What Python itself prints, such as -1e-05, is a number too.
    parser._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)
    _add_pose(parser.add_argument_group("the pose"))
    way = parser.add_argument_group("how to solve it")
    _add_way(way)
    amount = way.add_mutually_exclusive_group()
    amount.add_argument("--all", action="store_true", help="every solution, by the closed form")
    amount.add_argument("--path", action="store_true", help="the CSV is a path to follow in order")
    parser.add_argument("--json", action="store_true", help="print one JSON document, in m and rad")
    parser.add_argument(
        "--output", type=Path, metavar="FILE.csv", help="write the answers, in m and rad"
    )
    parser.set_defaults(module="scara_drake.cli.ik", extra="")


def _add_pose(what: Any) -> None:
    pose = what.add_mutually_exclusive_group(required=True)
    pose.add_argument("--position", nargs=3, type=float, metavar=("X", "Y", "Z"))
    pose.add_argument(
        "--csv",
        type=Path,
        metavar="FILE",
        help=f"poses by the columns {', '.join(POSE_COLUMNS)}, named in the first line",
    )
    what.add_argument(
        "--rpy",
        nargs=3,
        type=float,
        metavar=("ROLL", "PITCH", "YAW"),
        help="orientation Rx(roll) Ry(pitch) Rz(yaw), with --position",
    )
    what.add_argument("--unit", default="m", metavar="UNIT", help="m (default) or mm")
    what.add_argument("--angle", default="rad", metavar="UNIT", help="rad (default) or deg")


def _add_way(way: Any) -> None:
    way.add_argument(
        "--method", metavar="NAME", help=f"{', '.join(IK_METHODS)} (default {IK_METHOD})"
    )
    way.add_argument(
        "--joints", default="full", metavar="WHICH", help="full (default), or arm: the mast stays"
    )
    way.add_argument(
        "--task",
        default="pose",
        metavar="WHAT",
        help="pose (default), or position: exactly, and the orientation as near as possible",
    )
    way.add_argument("--mast", type=float, metavar="HEIGHT", help="[m], for --joints arm")
    way.add_argument(
        "--q-seed",
        nargs=6,
        type=float,
        metavar=JOINT_NAMES,
        help="posture where the search starts [m, rad]",
    )
    way.add_argument("--seed", type=int, default=0, help="of the random draws (default 0)")
    way.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="of the method, such as polish=False",
    )

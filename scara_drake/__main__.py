"""Command line: run a scenario, show the model, list and draw the Diagrams."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pydrake.geometry import Meshcat
from pydrake.visualization import ModelVisualizer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from scara_drake import __version__, joints, metrics
from scara_drake.cli import ik as ik_command
from scara_drake.cli import tune as tune_command
from scara_drake.common.resources import resource
from scara_drake.diagram import make_diagram
from scara_drake.display.block_diagram import render_svg
from scara_drake.display.camera import set_camera
from scara_drake.display.page import publish_recording, save_html, start_recording
from scara_drake.metrics.contact import yielding_joints
from scara_drake.recordings.files import save_recording
from scara_drake.scenario import Scenario, load_scenario, parse_overrides, scenario_names
from scara_drake.simulation.run import Run, run

BAD_INPUT, FAILED_RUN, INTERRUPTED = 2, 1, 130
SETTLING = 1.0  # [s], left out of the tracking figures: the drives take up the weight


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status: 0, 1 for a failed run, 2 for bad input."""
    options = _parser().parse_args(arguments)
    console = Console()
    errors = Console(stderr=True, soft_wrap=True)
    try:
        options.command(options, console)
    except ValueError as error:
        if options.traceback:
            raise
        errors.print(f"scara-drake: {escape(str(error))}", highlight=False)
        return BAD_INPUT
    except (RuntimeError, OSError) as error:
        if options.traceback:
            raise
        errors.print(f"scara-drake: failed: {escape(' '.join(str(error).split()))}")
        return FAILED_RUN
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="scara-drake", description=__doc__)
    parser.add_argument("--version", action="version", version=__version__)
    parser.add_argument("--traceback", action="store_true", help="show where an error comes from")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run_command = commands.add_parser("run", help="simulate a scenario and record it")
    run_command.add_argument("scenario", help="name of a shipped scenario, or a YAML file")
    run_command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a field, such as controller.phi=0.5",
    )
    run_command.add_argument(
        "--record", type=Path, metavar="FILE.nc", help="default runs/SCENARIO.nc"
    )
    run_command.add_argument("--html", type=Path, metavar="FILE.html", help="page to play offline")
    run_command.add_argument("--no-realtime", action="store_true", help="as fast as it goes")
    run_command.add_argument("--no-meshcat", action="store_true", help="without the scene")
    run_command.set_defaults(command=_run)

    show = commands.add_parser("show", help="the model in Meshcat, a slider for each joint")
    show.add_argument("--once", action="store_true", help="leave after the first picture")
    show.set_defaults(command=_show)

    diagrams = commands.add_parser("diagrams", help="list the runnable Diagrams, draw them")
    diagrams.add_argument("--render", type=Path, metavar="FOLDER", help="write NAME.svg files")
    diagrams.set_defaults(command=_diagrams)

    ik_command.add_parser(commands)
    tune_command.add_parser(commands)
    replay = commands.add_parser("replay", help="play a recording again", add_help=False)
    replay.add_argument("arguments", nargs=argparse.REMAINDER)
    replay.set_defaults(command=_replay)
    return parser


def _replay(options: argparse.Namespace, console: Console) -> None:
    try:
        from scara_drake.replay.player import (
            main as replay,  # its extra may not be installed
        )
    except ModuleNotFoundError as error:
        raise ValueError(f"replay: {error}, allowed with the extra 'replay' installed") from None
    if status := replay(options.arguments):
        raise SystemExit(status)


def _run(options: argparse.Namespace, console: Console) -> None:
    scenario = load_scenario(options.scenario, parse_overrides(options.set))
    record = options.record or Path("runs") / f"{scenario.name}.nc"
    for path, suffix in ((record, ".nc"), (options.html, ".html")):
        _check_target(path, suffix)
    if options.html and options.no_meshcat:
        raise ValueError("--html: needs the scene, allowed without --no-meshcat")
    meshcat = None if options.no_meshcat else Meshcat()
    if meshcat is not None:
        console.print(f"Scene: {meshcat.web_url()}")
        set_camera(meshcat, scenario.environment)
        if options.html:
            start_recording(meshcat)
    journal = record.with_suffix(".journal")
    rate = 0.0 if options.no_realtime else 1.0
    try:
        result = run(scenario, journal, rate, meshcat, progress=True)
    except ValueError:
        raise
    except Exception as error:
        kept = f" (what was recorded is in {journal})" if journal.exists() else ""
        raise RuntimeError(f"{error}{kept}") from error
    save_recording(result.recording, record)
    journal.unlink()
    _print_summary(console, scenario, result)
    console.print(f"Recording: {record}")
    if meshcat is not None and options.html:
        publish_recording(meshcat)
        save_html(meshcat, options.html)
        console.print(f"Page: {options.html}")
    if meshcat is not None and sys.stdin.isatty() and sys.stdout.isatty():
        console.input("Press Enter to close the scene. ")


def _check_target(path: Path | None, suffix: str) -> None:
    if path is not None and (path.suffix != suffix or path.is_dir()):
        raise ValueError(f"output: '{path}', allowed a file that ends in {suffix}")


def _print_summary(console: Console, scenario: Scenario, result: Run) -> None:
    recording = result.recording
    settled = recording.sel(time=slice(SETTLING, None))
    if settled.sizes["time"] < 2:
        settled = recording
    error = metrics.tracking_error(settled)
    table = Table(title=f"{scenario.name}: {result.simulated:.1f} s", title_justify="left")
    table.add_column("after the first second")
    table.add_column("RMS", justify="right")
    table.add_column("largest", justify="right")
    for joint, rms, peak in zip(
        joints.JOINT_NAMES,
        metrics.rmse(error).values,
        metrics.peak(error).values,
        strict=True,
    ):
        unit = "mm" if joint == "d1" else "mrad"
        table.add_row(f"{joint} error", f"{1e3 * rms:.3f} {unit}", f"{1e3 * peak:.3f} {unit}")
    tool = metrics.tool_error(settled)
    table.add_row(
        "tool error",
        f"{1e3 * float(metrics.rmse(tool)):.3f} mm",
        f"{1e3 * float(metrics.peak(tool)):.3f} mm",
    )
    if scenario.environment.surfaces:
        force = float(metrics.peak(metrics.contact_force(recording)))
        table.add_row("contact force", "", f"{force:.1f} N")
        if "saturation" in recording:
            share = yielding_joints(recording)
            names = [str(share.joint[i].values) for i in range(share.size) if share[i] > 0.0]
            table.add_row("joints that yield in contact", "", ", ".join(names) or "none")
    table.add_row("real-time factor", f"{result.real_time_factor:.2f}", "")
    console.print(table)
    if result.interrupted:
        console.print("Stopped early; what was simulated is recorded.")
    if result.late:
        console.print(f"Not in real time: the clock was lost {result.late} times.")


def _show(options: argparse.Namespace, console: Console) -> None:
    meshcat = Meshcat()
    set_camera(meshcat, load_scenario("free_motion").environment)
    visualizer = ModelVisualizer(meshcat=meshcat)
    visualizer.package_map().AddPackageXml(resource("models", "package.xml"))
    visualizer.AddModels(resource("models", "scara6.urdf"))
    visualizer.Finalize(position=joints.HOME)
    console.print(f"Scene: {meshcat.web_url()}   (Ctrl-C, or its Stop button, to leave)")
    visualizer.Run(position=joints.HOME, loop_once=options.once)


def _diagrams(options: argparse.Namespace, console: Console) -> None:
    table = Table()
    table.add_column("Diagram")
    table.add_column("duration", justify="right")
    table.add_column("what it is")
    for name in scenario_names():
        scenario = load_scenario(name)
        table.add_row(name, f"{scenario.duration:g} s", scenario.description)
        if options.render:
            options.render.mkdir(parents=True, exist_ok=True)
            (options.render / f"{name}.svg").write_text(render_svg(make_diagram(scenario)))
    console.print(table)
    if options.render:
        console.print(f"Block diagrams: {options.render}")


if __name__ == "__main__":
    sys.exit(main())

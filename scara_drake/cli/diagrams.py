"""The command `scara-drake diagrams`: list the runnable Diagrams, draw them."""

from __future__ import annotations

import argparse

from rich.console import Console
from rich.table import Table

from scara_drake.common.files import write_whole
from scara_drake.common.shipped import scenario_names, training_names
from scara_drake.diagram import make_diagram
from scara_drake.display.block_diagram import render_svg
from scara_drake.scenario import load_scenario


def run(options: argparse.Namespace, console: Console) -> None:
    """Print a table of the shipped scenarios; with `options.render`, draw their Diagrams.

    Raises:
        ValueError: Graphviz is not installed.
        OSError: the folder cannot be written.
    """
    table = Table()
    table.add_column("Diagram")
    table.add_column("duration", justify="right")
    table.add_column("what it is")
    training = training_names()
    for name in [*scenario_names(), *training]:
        scenario = load_scenario(name)
        table.add_row(name, f"{scenario.duration:g} s", scenario.description)
        if options.render and name not in training:
            options.render.mkdir(parents=True, exist_ok=True)
            write_whole(options.render / f"{name}.svg", render_svg(make_diagram(scenario)))
    console.print(table)
    if options.render:
        console.print(f"Block diagrams: {options.render}")

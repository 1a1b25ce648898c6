"""The command `scara-drake show`: the model in Meshcat, a slider for each joint."""

from __future__ import annotations

import argparse

from pydrake.visualization import ModelVisualizer
from rich.console import Console

from scara_drake import joints
from scara_drake.common.resources import resource
from scara_drake.display.camera import set_camera
from scara_drake.display.server import start_meshcat, who_reaches
from scara_drake.scenario import load_scenario


def run(options: argparse.Namespace, console: Console) -> None:
    """Show the robot until it is stopped."""
    meshcat = start_meshcat(options.host, options.port)
    set_camera(meshcat, load_scenario("free_motion").environment)
    visualizer = ModelVisualizer(meshcat=meshcat)
    visualizer.package_map().AddPackageXml(resource("models", "package.xml"))
    visualizer.AddModels(resource("models", "scara6.urdf"))
    visualizer.Finalize(position=joints.HOME)
    console.print(f"Scene: {meshcat.web_url()} ({who_reaches(options.host)})")
    console.print("Ctrl-C, or its Stop button, to leave.")
    visualizer.Run(position=joints.HOME, loop_once=options.once)

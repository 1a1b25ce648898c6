"""The wiring of what is kept and shown: recorder, exported ports, the scene in Meshcat."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, SceneGraph
from pydrake.systems.framework import DiagramBuilder

from scara_drake.common.block import Block
from scara_drake.display.camera import set_camera
from scara_drake.display.scene import add_visualization
from scara_drake.display.task import TaskAnnotations
from scara_drake.recordings.recorder import Origin, add_recorder
from scara_drake.scenario import dump_scenario
from scara_drake.wiring import Signals, packet_sizes, plant_of
from scara_drake.wiring.supervised import with_supervision

if TYPE_CHECKING:
    from scara_drake.ik.result import IkResult
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]

DRAWN = (
    "state",
    "X_WE_desired",
    "f_env_on_tool_W",
    "device_connected",
    "motion_master",
    "hand_target",
)


class Watching(Protocol):
    """What looks at a run from outside, such as the operator's station."""

    def add(self, builder: DiagramBuilder, scenario: Scenario, signals: Signals) -> None:
        """Add to a Diagram what it needs; nothing may read what that computes."""


def add_export(
    builder: DiagramBuilder, scenario: Scenario, answer: IkResult | None, signals: Signals
) -> None:
    """Record the signals that have a name in a recording, and export all of them.

    The recording also says how the first posture was found, if it was.
    """
    surfaces = tuple(surface.name for surface in scenario.environment.surfaces)
    if builder.HasSubsystemNamed("operator_supervisor"):
        scenario = with_supervision(scenario)  # that a live device has, so that it runs again
    text, duration = dump_scenario(scenario), scenario.duration
    notes = _notes(answer, device_name(signals)) | packet_sizes(signals)
    origin = Origin(scenario.name, text, scenario.seed, surfaces, duration, notes)
    periodic = periods(signals)
    add_recorder(builder, signals, origin, periodic, scenario.time_step, scenario.sample_period)
    for name, port in signals.items():
        builder.ExportOutput(port, name)


def _notes(answer: IkResult | None, device: str) -> dict[str, str | int | float]:
    if answer is None:
        return {"device": device}
    return {
        "device": device,
        "first_posture_method": answer.found_by,
        "first_posture_evaluations": answer.evaluations,
        "first_posture_seconds": answer.seconds,
    }


def add_scene(
    builder: DiagramBuilder, scenario: Scenario, signals: Signals, meshcat: Meshcat
) -> None:
    """Draw the plant, and what belongs to it that is no body."""
    plant, scene_graph = plant_of(builder), builder.GetSubsystemByName("scene_graph")
    annotations = add_visualization(
        builder,
        plant,
        cast(SceneGraph, scene_graph),
        meshcat,
        scenario.environment,
        places=places(scenario),
    )
    for name in DRAWN:
        if name in signals:
            builder.Connect(signals[name], annotations.GetInputPort(name))
    task, pipe = scenario.task, scenario.environment.cut
    if task is not None or pipe is not None:
        drawn = builder.AddNamedSystem("task", TaskAnnotations(meshcat, task, pipe))
        if pipe is not None:
            builder.Connect(signals["cells"], drawn.GetInputPort("cells"))


def places(scenario: Scenario) -> Array:
    """Return the places (n, 3) [m] of the task and of a known motion, to be in the picture."""
    known = getattr(scenario.operator, "places", lambda duration: ())(scenario.duration)
    asked = () if scenario.task is None else scenario.task.places()
    return np.vstack([np.reshape(known, (-1, 3)), np.reshape(asked, (-1, 3))])


def show_robot(meshcat: Meshcat, scenario: Scenario) -> None:
    """Turn the camera to where the robot of a scenario works."""
    set_camera(meshcat, scenario.environment, places(scenario))


def device_name(signals: Signals) -> str:
    """Return what the stick's axes come from, "" where there is no stick."""
    port = signals.get("joystick_axes")
    return str(getattr(port.get_system(), "device_name", "")) if port is not None else ""


def periods(signals: Signals) -> dict[str, float]:
    """Return the periods [s] of the signals whose block has one."""
    found = {}
    for name, port in signals.items():
        system = port.get_system()
        if isinstance(system, Block) and system.declaration.period > 0.0:
            found[name] = system.declaration.period
    return found

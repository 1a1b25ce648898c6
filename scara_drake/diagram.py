"""The wiring of a scenario, and nothing else: it reads like the block diagram.

::

    joystick -> mapping -> uplink -> inverse_kinematics -> governor -> controller -> drives -> plant
        ^                                                                                      |  ^
        '--- haptics <----------------- downlink <----------------- contact <-----------------'--'

With a master that can be pushed, its coupling takes the place of mapping and haptics. The parts of
the wiring are in `wiring`, a file a part.
"""

from __future__ import annotations

from pydrake.geometry import Meshcat
from pydrake.systems.framework import Diagram, DiagramBuilder

from scara_drake.scenario import Scenario, check_scenario
from scara_drake.wiring import Signals
from scara_drake.wiring.control import add_control, add_drives, add_forces
from scara_drake.wiring.operators import add_operator, start_answer, start_posture
from scara_drake.wiring.plant import add_plant
from scara_drake.wiring.robot import add_watch_over_efforts
from scara_drake.wiring.show import Watching, add_export, add_scene

PARTS = (add_plant, add_operator, add_control, add_watch_over_efforts, add_drives, add_forces)
__all__ = ["make_diagram", "start_posture"]


def make_diagram(
    scenario: Scenario, meshcat: Meshcat | None = None, station: Watching | None = None
) -> Diagram:
    """Build the Diagram of a scenario; every system and exported port is named.

    The scenario is not changed. With a meshcat the Diagram also draws itself there; what it
    computes stays the same to the bit. So it does with a station, which adds what it shows.

    Raises:
        ValueError: the scenario is not valid, or its first tool command cannot be reached.
    """
    check_scenario(scenario)
    builder, answer = DiagramBuilder(), start_answer(scenario)
    q_start = start_posture(scenario) if answer is None else answer.q
    signals: Signals = {}
    for add in PARTS:
        signals = add(builder, scenario, q_start, signals)
    add_export(builder, scenario, answer, signals)
    if station is not None:
        station.add(builder, scenario, signals)
    if meshcat is not None:
        add_scene(builder, scenario, signals, meshcat)
    diagram = builder.Build()
    diagram.set_name(scenario.name or "scara")
    return diagram

"""The wiring of an operator outside the Diagram: as a joystick's, from an exported input on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from scara_drake.wiring import Signals, outputs
from scara_drake.wiring.joystick import add_mapping, add_remote

if TYPE_CHECKING:
    from scara_drake.operator.external import External
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]


def add_external(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Export the input, and add what a joystick's signal passes from that port on."""
    operator: External = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    source = builder.AddNamedSystem("external", operator.make_source())
    builder.ExportInput(source.get_input_port(), operator.port)
    signals = signals | dict(outputs(source))
    if operator.port == "joystick_axes":
        signals = add_mapping(builder, operator.mapping, scenario.time_step, signals)
    return add_remote(builder, scenario, operator.first_command(), q_start, signals)

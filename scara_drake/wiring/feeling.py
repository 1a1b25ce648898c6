"""The wiring of what an operator feels of the force that has come over the channel."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydrake.systems.framework import DiagramBuilder, OutputPort

from scara_drake.operator.buzz import Buzz, FeltForce
from scara_drake.operator.haptics import HapticOutput
from scara_drake.operator.kinesthetic import KinestheticOutput
from scara_drake.wiring import Signals, chain, connect_by_name

if TYPE_CHECKING:
    from scara_drake.operator.devices import Device
    from scara_drake.scenario import Scenario


def add_feeling(
    builder: DiagramBuilder, scenario: Scenario, f_haptic: OutputPort, device: Device | None
) -> Signals:
    """Add the motors of a joystick, and where the scenario has one a device that pushes."""
    haptics = builder.AddNamedSystem("haptics", HapticOutput(scenario.haptics, device))
    builder.Connect(f_haptic, haptics.get_input_port())
    made = {"rumble": haptics.GetOutputPort("rumble")}
    if scenario.kinesthetic is not None:
        force = KinestheticOutput(scenario.kinesthetic, scenario.time_step)
        made["f_kinesthetic"] = chain(builder, "kinesthetic", force, f_haptic)
    return made


def add_supervised_feeling(
    builder: DiagramBuilder, scenario: Scenario, signals: Signals, device: Device | None
) -> Signals:
    """Add that, of a force that the operator scales, with what the supervisors tell laid over."""
    felt = signals["f_haptic"]
    if "live_settings" in signals:
        scale = builder.AddNamedSystem("felt_force", FeltForce())
        felt = connect_by_name(builder, scale, signals)["f_felt"]
    made = add_feeling(builder, scenario, felt, None)
    buzz = builder.AddNamedSystem("buzz", Buzz(device))
    return made | connect_by_name(builder, buzz, signals | {"rumble_force": made["rumble"]})

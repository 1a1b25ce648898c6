"""The wiring of an operator with a supervisor.

::

    joystick -> stick_filter -> operator_supervisor -> mapping -> (uplink)
                                   robot_report_received '----'
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pydrake.systems.framework import DiagramBuilder

from scara_drake.operator.stick_filter import StickFilter
from scara_drake.operator.supervised_mapping import SupervisedMapping
from scara_drake.operator.supervisor import OperatorSupervisor
from scara_drake.supervision.config import Supervision
from scara_drake.wiring import Signals, connect_by_name

if TYPE_CHECKING:
    from scara_drake.operator.joystick import Joystick
    from scara_drake.scenario import Scenario

# What comes back from the robot, and is connected when that is built.
RETURNED = ("robot_report_received", "age_down", "delay_down")


def with_supervision(scenario: Scenario) -> Scenario:
    """Return a scenario with supervisors, as whoever holds a live device has them."""
    if scenario.supervision is not None:
        return scenario
    return replace(scenario, supervision=Supervision())


def add_supervised_mapping(
    builder: DiagramBuilder, scenario: Scenario, says_buttons: bool, signals: Signals
) -> Signals:
    """Add what turns a device's sample into `tool_command`, and says whether it counts.

    `operator_status` is the one that the command belongs to, so that both cross the channel
    together.

    Args:
        builder: of the Diagram.
        scenario: of it, with `supervision`.
        says_buttons: they are those of somebody; one that is down at the start is no press.
        signals: of the joystick.
    """
    operator: Joystick = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    config, period = (scenario.supervision or Supervision()).operator, scenario.time_step
    made = dict(signals)
    for name, system in (
        ("stick_filter", StickFilter(operator.sample_period, config.spike, period)),
        ("operator_supervisor", OperatorSupervisor(config, says_buttons, period)),
        ("mapping", SupervisedMapping(operator.mapping, period)),
    ):
        builder.AddNamedSystem(name, system)
        made |= connect_by_name(builder, system, made)
    return made | {"operator_status": made.pop("operator_status_mapped")}


def return_report(builder: DiagramBuilder, signals: Signals) -> None:
    """Connect what the operator's side hears of the robot."""
    heard = {name: signals[name] for name in RETURNED if name in signals}
    for name in ("operator_supervisor", "mapping"):
        connect_by_name(builder, builder.GetSubsystemByName(name), heard)

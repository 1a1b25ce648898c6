"""The wiring of an operator with a joystick.

::

    joystick -> mapping -> uplink -> (watch) -> inverse_kinematics -> (controller)
        ^
        '--- haptics <- downlink <- (contact)
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, System

from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.operator.mapping import JoystickToPose
from scara_drake.wiring import Signals, link_signals, outputs
from scara_drake.wiring.feeling import add_feeling
from scara_drake.wiring.radio import add_shadow
from scara_drake.wiring.robot import add_supervised_remote
from scara_drake.wiring.supervised import (
    add_supervised_mapping,
    return_report,
    with_supervision,
)

if TYPE_CHECKING:
    from scara_drake.operator.devices import Device
    from scara_drake.operator.joystick import Joystick
    from scara_drake.operator.mapping import JoystickMapping
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]


def add_joystick(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the operator's side, the channel both ways and the inverse kinematics."""
    operator: Joystick = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    device = operator.open_device()
    supervised = device is not None or scenario.supervision is not None
    source = operator.make_source(device, supervised)
    _say_who_commands(source.device_name, device is None and operator.device == "auto")
    joystick = builder.AddNamedSystem("joystick", source)
    signals, first = signals | dict(outputs(joystick)), operator.first_command()
    if not supervised:
        signals = add_mapping(builder, operator.mapping, scenario.time_step, signals)
        return add_remote(builder, scenario, first, q_start, signals)
    scenario = with_supervision(scenario)
    signals = add_supervised_mapping(builder, scenario, source.says_buttons, signals)
    signals = add_remote(builder, scenario, first, q_start, signals, device)
    return_report(builder, signals)
    return signals


def add_mapping(
    builder: DiagramBuilder, mapping: JoystickMapping, period: float, signals: Signals
) -> Signals:
    """Add what turns `joystick_axes` into `tool_command`."""
    system = builder.AddNamedSystem("mapping", JoystickToPose(mapping, period))
    builder.Connect(signals["joystick_axes"], system.get_input_port())
    return signals | dict(outputs(system))


def add_remote(
    builder: DiagramBuilder,
    scenario: Scenario,
    command: Array,
    q_start: Array,
    signals: Signals,
    device: Device | None = None,
) -> Signals:
    """Add what `tool_command` passes up to the references, and the force back to the device.

    Args:
        builder: of the Diagram.
        scenario: of it.
        command: (8,) the first one, from which the channel starts.
        q_start: (6,) where the arm starts.
        signals: so far.
        device: which haptics shake, if there is one.
    """
    if scenario.supervision is not None:
        return add_supervised_remote(builder, scenario, command, q_start, signals, device)
    period, link = scenario.time_step, scenario.channel.link("up")
    uplink = builder.AddNamedSystem(
        "uplink", link.make_system(command, period, scenario.seed_of("uplink"))
    )
    add_shadow(builder, link, uplink, signals)
    seed = scenario.seed_of("inverse_kinematics")
    kinematics = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematicsSystem(scenario.inverse_kinematics, command, q_start, seed, period),
    )
    builder.Connect(signals["tool_command"], uplink.GetInputPort("signal_sent"))
    received = uplink.GetOutputPort("signal_received")
    watched = _add_watch(builder, scenario, uplink, command)
    builder.Connect(watched.get("tool_command_watched", received), kinematics.get_input_port())
    made = {
        **watched,
        **dict(outputs(kinematics)),
        "tool_command_received": received,
        **link_signals(uplink, "up"),
    }
    if "f_env_on_tool_W" in signals:
        made |= _add_force(builder, scenario, signals, device)
    return signals | made


def _say_who_commands(name: str, absent: bool) -> None:
    """Say what the axes come from, as "auto" leaves that open, and that no joystick was there."""
    logging.getLogger(__name__).info(
        "Operator: %s%s", name, ", as no joystick is plugged in" if absent else ""
    )


def _add_watch(
    builder: DiagramBuilder, scenario: Scenario, uplink: System, command: Array
) -> Signals:
    """Watch over the command where the scenario asks for it; return what it shows."""
    config = scenario.channel.watch
    if config is None:
        return {}
    watch = builder.AddNamedSystem("watch", config.make_system(command, scenario.time_step))
    for port, name in (
        ("signal_received", "tool_command"),
        ("age_of_information", "age"),
        ("delay", "delay"),
    ):
        builder.Connect(uplink.GetOutputPort(port), watch.GetInputPort(name))
    return dict(outputs(watch))


def _add_force(
    builder: DiagramBuilder, scenario: Scenario, signals: Signals, device: Device | None
) -> Signals:
    """Lead the contact force over the channel to what the operator feels."""
    period, link = scenario.time_step, scenario.channel.link("down")
    downlink = builder.AddNamedSystem(
        "downlink", link.make_system(np.zeros(3), period, scenario.seed_of("downlink"))
    )
    add_shadow(builder, link, downlink, signals)
    builder.Connect(signals["f_env_on_tool_W"], downlink.GetInputPort("signal_sent"))
    made = {**link_signals(downlink, "down"), "f_haptic": downlink.GetOutputPort("signal_received")}
    return made | add_feeling(builder, scenario, made["f_haptic"], device)

"""The wiring of what the operator changes during a run: delays of the channel, and gains."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike
from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from scara_drake.channel.live_delay import LiveDelay
from scara_drake.control.gain_scale import GainScale
from scara_drake.wiring import Signals, link_signals

if TYPE_CHECKING:
    from scara_drake.scenario import Scenario

SETTINGS = "live_settings"


def add_live_delay(
    builder: DiagramBuilder,
    direction: str,
    link: System,
    first: ArrayLike,
    period: float,
    signals: Signals,
) -> tuple[OutputPort, Signals]:
    """Add the delay that the operator sets behind a link, if there are settings of his.

    Args:
        builder: of the Diagram.
        direction: "up" or "down".
        link: with the port `signal_received`.
        first: (n,) received until the first sample arrives.
        period: [s].
        signals: so far.

    Returns:
        The port of what is received, and what the link tells, its delay and age with the live one.
    """
    received, told = link.GetOutputPort("signal_received"), link_signals(link, direction)
    if SETTINGS not in signals:
        return received, told
    ages = link.HasOutputPort("age_of_information")
    live = builder.AddNamedSystem(
        f"live_delay_{direction}", LiveDelay(first, period, direction, ages)
    )
    if ages:
        builder.Connect(link.GetOutputPort("age_of_information"), live.GetInputPort("age_sent"))
    builder.Connect(received, live.GetInputPort("signal_sent"))
    builder.Connect(link.GetOutputPort("delay"), live.GetInputPort("delay_sent"))
    builder.Connect(signals[SETTINGS], live.GetInputPort("live_settings"))
    return live.GetOutputPort("signal_delayed"), told | link_signals(live, direction)


def add_gain_scale(
    builder: DiagramBuilder, scenario: Scenario, controller: System, signals: Signals
) -> None:
    """Lead the operator's scale to a controller that takes one; say once where it takes none."""
    if SETTINGS not in signals:
        return
    if not controller.HasInputPort("gain_scale"):
        logging.getLogger(__name__).info(
            "Gain scale: of no effect with %s, allowed with IntegralSlidingMode",
            type(scenario.controller).__name__,
        )
        return
    scale = builder.AddNamedSystem("gain_scale", GainScale(scenario.time_step))
    builder.Connect(signals[SETTINGS], scale.get_input_port())
    builder.Connect(scale.get_output_port(), controller.GetInputPort("gain_scale"))

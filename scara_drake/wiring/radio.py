"""The wiring of a link whose packets suffer from where the tool is.

::

    (plant) -> tool_place -> shadow_NAME -> (link NAME)
                  (codec) -------^
"""

from __future__ import annotations

from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from scara_drake.channel.delays import DelayLaw
from scara_drake.channel.packets import Packets
from scara_drake.channel.shadow import RadioShadow
from scara_drake.operator.trainee import ToolPosition
from scara_drake.wiring import Signals, chain

PLACE = "tool_place"


def add_shadow(
    builder: DiagramBuilder,
    link: DelayLaw | Packets,
    carrier: System,
    signals: Signals,
    transmit: OutputPort | None = None,
) -> None:
    """Lead the tool's true place to a link that has a shadow, and what a codec asks for.

    Args:
        builder: of the Diagram.
        link: what the carrier was made of.
        carrier: its system, in the Diagram.
        signals: so far, with the plant's `state`.
        transmit: of a codec before the link.
    """
    if isinstance(link, Packets) and link.shadow is not None:
        if not builder.HasSubsystemNamed(PLACE):
            chain(builder, PLACE, ToolPosition(), signals["state"])
        name = f"shadow_{carrier.get_name()}"
        shadow = builder.AddNamedSystem(name, RadioShadow(link.shadow))
        place = builder.GetSubsystemByName(PLACE).get_output_port(0)
        builder.Connect(place, shadow.GetInputPort("place"))
        if transmit is not None:
            builder.Connect(transmit, shadow.GetInputPort("transmit"))
        transmit = shadow.get_output_port()
    if transmit is not None:
        builder.Connect(transmit, carrier.GetInputPort("transmit"))

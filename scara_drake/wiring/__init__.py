"""Parts of the wiring of a Diagram, and what they share: signals are output ports by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort, System

# Signals by the name under which they are exported and recorded.
Signals = dict[str, OutputPort]


def plant_of(builder: DiagramBuilder) -> MultibodyPlant:
    """Return the plant that `add_plant` has added."""
    return cast(MultibodyPlant, builder.GetSubsystemByName("plant"))


def outputs(system: System) -> Iterator[tuple[str, OutputPort]]:
    """Yield the output ports of a system with their names."""
    for index in range(system.num_output_ports()):
        port = system.get_output_port(index)
        yield port.get_name(), port


def link_signals(link: System, direction: str) -> Signals:
    """Return what a link tells about itself: its delay; of packets also age, count and buffer."""
    names = {
        "delay": f"delay_{direction}",
        "age_of_information": f"age_{direction}",
        "packet_counts": f"packet_counts_{direction}",
        "playout": f"playout_{direction}",
    }
    return {names[name]: port for name, port in outputs(link) if name in names}


def packet_sizes(signals: Signals) -> dict[str, int]:
    """Return how many numbers are in a packet of each link that has packets, for the recording."""
    links = {name: signals.get(f"packet_counts_{name}") for name in ("up", "down")}
    return {
        f"packet_numbers_{name}": cast(System, port.get_system()).GetInputPort("signal_sent").size()
        for name, port in links.items()
        if port is not None
    }


def connect_by_name(builder: DiagramBuilder, system: System, signals: Signals) -> Signals:
    """Connect the inputs of a system to the signals of their names; return its outputs."""
    for name, port in signals.items():
        if system.HasInputPort(name):
            builder.Connect(port, system.GetInputPort(name))
    return dict(outputs(system))


def chain(builder: DiagramBuilder, name: str, system: System, source: OutputPort) -> OutputPort:
    """Add a system with one input; return its first output."""
    builder.AddNamedSystem(name, system)
    builder.Connect(source, system.get_input_port(0))
    return system.get_output_port(0)

"""Helpers for tests of one LeafSystem on a bare Context."""

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, System


def ports(system: System) -> tuple[dict[str, int], dict[str, int]]:
    """Names and sizes of the input and output ports."""
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    return {p.get_name(): p.size() for p in inputs}, {p.get_name(): p.size() for p in outputs}


def tick(system: LeafSystem, context: Context) -> None:
    """Apply the discrete update once."""
    update = system.EvalUniquePeriodicDiscreteUpdate(context)
    context.get_mutable_discrete_state().SetFrom(update)


def outputs(system: LeafSystem, context: Context) -> np.ndarray:
    """All outputs, stacked."""
    count = system.num_output_ports()
    return np.concatenate([system.get_output_port(i).Eval(context) for i in range(count)])

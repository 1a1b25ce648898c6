"""What a controller has to be, whoever wrote it."""

from __future__ import annotations

import inspect
from typing import Any, Final, Protocol

from pydrake.systems.framework import InputPort, OutputPort, PortDataType, System

INPUTS: Final = {"state": 12, "state_desired": 12}
OUTPUTS: Final = {"actuation": 6}
NEEDS: Final = (
    "allowed a part with make_system(period) that returns a Drake system with the inputs "
    "state (12) and state_desired (12) and the output actuation (6)"
)


class ControllerPart(Protocol):
    """The `controller` of a scenario: it holds the gains and makes the system that uses them.

    The system has the inputs ``state`` and ``state_desired`` (12) = (q, v) [m, rad, m/s, rad/s] and
    the output ``actuation`` (6) [N, N m]; further outputs are exported under their names. A part
    that is a dataclass is checked and written with the scenario.
    """

    def make_system(self, period: float, /) -> System:
        """Return the controller, sampled every `period` [s] if it is sampled."""
        ...


def check_controller(part: Any) -> None:
    """Accept what has a `make_system` that takes a period.

    Raises:
        ValueError: otherwise; says what a controller needs.
    """
    if isinstance(part, type):
        raise ValueError(f"controller: the class {part.__name__} itself, {NEEDS}")
    maker = getattr(part, "make_system", None)
    if not callable(maker) or not _takes_a_period(maker):
        raise ValueError(f"controller: {type(part).__name__}, {NEEDS}")


def make_controller(part: ControllerPart, period: float) -> System:
    """Return the system of a part.

    Raises:
        ValueError: the part, or what it makes, is no controller; says what one needs.
    """
    check_controller(part)
    system = part.make_system(period)
    where = f"controller: {type(part).__name__}.make_system returns"
    if not isinstance(system, System):
        raise ValueError(f"{where} {type(system).__name__}, {NEEDS}")
    for name, size in INPUTS.items():
        if not (system.HasInputPort(name) and _is_vector(system.GetInputPort(name), size)):
            raise ValueError(f"{where} a system without the input {name} ({size}), {NEEDS}")
    for name, size in OUTPUTS.items():
        if not (system.HasOutputPort(name) and _is_vector(system.GetOutputPort(name), size)):
            raise ValueError(f"{where} a system without the output {name} ({size}), {NEEDS}")
    return system


def _takes_a_period(maker: Any) -> bool:
    try:
        inspect.signature(maker).bind(0.0)
    except TypeError:
        return False
    except ValueError:  # a builtin that does not tell
        return True
    return True


def _is_vector(port: InputPort | OutputPort, size: int) -> bool:
    return port.get_data_type() == PortDataType.kVectorValued and port.size() == size

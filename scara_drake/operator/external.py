"""An operator outside the Diagram, who speaks through one of its input ports."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Output
from scara_drake.common.fields import choice
from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.vectors import COMMAND_FRAME

Array = NDArray[np.float64]

SPOKEN = ("joystick_axes", "tool_command", "command_frame")
AXES = 5


@dataclass
class External:
    """An operator of your own: a program, a learner, a device, outside the Diagram.

    The Diagram of `make_diagram` then has an input port of the name in `port`. Unconnected it is
    the centred stick, or the command of the centred stick.

    Attributes:
        port: "joystick_axes" (5), the stick, each axis -1 to 1; "tool_command" (8), p_WE [m],
            quaternion w, x, y, z and mast height [m]; or, with a supervised robot,
            "command_frame" (10), such a command and the state and the engagements of a supervisor
            of your own, see `vectors.CommandFrame`.
        mapping: from the stick to the tool; with the others its centred stick is the first command.
    """

    port: str = choice("joystick_axes", SPOKEN)
    mapping: JoystickMapping = field(default_factory=JoystickMapping)

    def first_command(self) -> Array:
        """Return the tool command (8,) of the centred stick, see `initial_command`."""
        return initial_command(self.mapping)

    def make_source(self) -> ExternalSource:
        """Return the system whose input the Diagram exports."""
        at_rest = np.zeros(AXES) if self.port == "joystick_axes" else self.first_command()
        if self.port == "command_frame":
            at_rest = COMMAND_FRAME.zeros(tool_command=self.first_command())
        return ExternalSource(self.port, at_rest)


class ExternalSource(Block):
    """Passes on what comes from outside the Diagram.

    Ports:
        input external (n): NaN or infinity on it stops the run, unless a supervisor is to judge it
            (`command_frame`); `at_rest` where unconnected.
        output `port` (n): the same.

    Args:
        port: name of the output.
        at_rest: (n,) what an unconnected input reads.
    """

    def __init__(self, port: str, at_rest: Array) -> None:
        default, finite = tuple(at_rest.tolist()), port != "command_frame"
        super().__init__(
            Declaration(
                inputs={"external": Input(at_rest.size, finite=finite, default=default)},
                outputs={port: Output(at_rest.size, PASS_ON[port])},
            )
        )


@njit(cache=True)
def pass_on_axes(external: Array, joystick_axes: Array) -> None:
    """Copy what comes in, each axis within [-1, 1]."""
    for i in range(joystick_axes.size):
        joystick_axes[i] = min(max(external[i], -1.0), 1.0)


@njit(cache=True)
def pass_on_command(external: Array, tool_command: Array) -> None:
    """Copy what comes in."""
    tool_command[:] = external


@njit(cache=True)
def pass_on_frame(external: Array, command_frame: Array) -> None:
    """Copy what comes in."""
    command_frame[:] = external


PASS_ON = {
    "joystick_axes": pass_on_axes,
    "tool_command": pass_on_command,
    "command_frame": pass_on_frame,
}

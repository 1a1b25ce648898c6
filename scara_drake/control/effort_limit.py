"""What a controller asks of the drives, and the part of it that they give."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints
from scara_drake.common.block import Block, Declaration, Input, Output

Array = NDArray[np.float64]

# Beyond so many times the limit of its drive an effort is a fault of the controller.
ABSURD: Final = 1e6


@njit(cache=True)
def first_absurd(efforts: Array, limits: Array) -> int:
    """Return the first entry (n,) that is NaN, infinite or `ABSURD` times its limit; -1: none."""
    for i in range(efforts.size):
        if not abs(efforts[i]) <= ABSURD * limits[i]:
            return i
    return -1


def deliver(
    t: float,
    actuation_asked: Array,
    actuation_commanded: Array,
    limits: Array,
    maker: str,
    actuation: Array,
) -> None:
    """Write the efforts that act (6,).

    Args:
        t: [s].
        actuation_asked: what the controller has on its port `actuation` (6,) [N, N m].
        actuation_commanded: what it has on that port, if it has one (6,) [N, N m].
        limits: of the drives (6,) [N, N m].
        maker: name of the controller's system.
        actuation: written.

    Raises:
        RuntimeError: an effort is none; names system, port, time and entry.
    """
    for name, efforts in (
        ("actuation", actuation_asked),
        ("actuation_commanded", actuation_commanded),
    ):
        index = first_absurd(efforts, limits)
        if index >= 0:
            raise RuntimeError(
                f"{maker}: port '{name}' at t = {t:.6g} s: {name}[{index}] is {efforts[index]:g}, "
                f"allowed up to {ABSURD:g} times the drive's limit of {limits[index]:g}"
            )
    np.clip(actuation_asked, -limits, limits, out=actuation)


class EffortLimit(Block):
    """The limits of the six drives, after a controller that need not know them.

    Ports:
        input actuation_asked (6) [N, N m]: the controller's `actuation`.
        input actuation_commanded (6) [N, N m]: the port of that name of a controller that has one;
            it is only looked at.
        output actuation (6) [N, N m], of the inputs: what acts, and is recorded.

    No update, and no memory. Evaluating the output raises a RuntimeError where the controller asks
    for NaN, infinity or a million times a limit.

    Args:
        maker: name of the controller's system, for that message.
    """

    def __init__(self, maker: str) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "actuation_asked": Input(6),
                    "actuation_commanded": Input(6, default=(0.0,) * 6),
                },
                outputs={"actuation": Output(6, deliver)},
                parameters={"limits": joints.EFFORT, "maker": maker},
            )
        )

"""From the contact force to the force of a device that can push the hand."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import ABOVE_ZERO, check, number

Array = NDArray[np.float64]


@dataclass
class KinestheticMapping:
    """What a kinesthetic device is asked for. The limit is that of a small desktop device.

    Attributes:
        scale: force at the hand over force at the tool.
        limit: largest magnitude.
        slew: fastest change.
    """

    scale: float = number(0.02, "1", 0.0, 1e3)
    limit: float = number(3.3, "N", ABOVE_ZERO, 1e4)
    slew: float = number(500.0, "N/s", ABOVE_ZERO, 1e7)


@njit(cache=True)
def step_kinesthetic(
    f_haptic: Array, scale: float, limit: float, step: float, f_kinesthetic: Array
) -> None:
    """Move the force felt (3,) [N] towards scale f_haptic, by at most `step` [N] along a line.

    The target is cut to `limit` [N] in its own direction; one that is not finite counts as none.
    """
    target = scale * f_haptic
    size = np.sqrt((target * target).sum())
    if not np.isfinite(size):
        target = np.zeros(3)
    elif size > limit:
        target *= limit / size
    change = target - f_kinesthetic
    size = np.sqrt((change * change).sum())
    if size > step:
        change *= step / size
    f_kinesthetic += change


class KinestheticOutput(Block):
    """The force that a kinesthetic device should put on the hand.

    Ports:
        input f_haptic (3) [N]: force of the environment on the tool, as it came over the channel.
        output f_kinesthetic (3) [N]: force on the hand, in the axes of the world.

    Update, every period: see `step_kinesthetic`. Initial: zero. The device's own driver reads the
    port in a publish event of its own.

    Args:
        mapping: how the force is scaled and limited.
        period: [s].

    Raises:
        ValueError: a field of the mapping is out of its bounds.
    """

    def __init__(self, mapping: KinestheticMapping, period: float = 1e-3) -> None:
        check(mapping, "mapping")
        super().__init__(
            Declaration(
                inputs={"f_haptic": Input(3)},
                memory={"f_kinesthetic": Memory(3, port=True)},
                parameters={
                    "scale": float(mapping.scale),
                    "limit": float(mapping.limit),
                    "step": mapping.slew * period,
                },
                period=period,
                update=step_kinesthetic,
            )
        )

"""A guard behind the sensors: what is no number goes no farther."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.vectors import STATE

Array = NDArray[np.float64]


@njit(cache=True)
def keep_last(state_sensed: Array, last: Array) -> None:
    """Keep a state (12,) that is one."""
    if np.isfinite(state_sensed).all():
        last[:] = state_sensed


@njit(cache=True)
def show_last(state_sensed: Array, last: Array, state_measured: Array) -> None:
    """Write the state (12,), or the last one that was one."""
    state_measured[:] = state_sensed if np.isfinite(state_sensed).all() else last


class MeasurementGuard(Block):
    """Passes on what the sensors show of the joints, and the last of it where they show no number.

    That bridges the ticks until the supervisor has switched the drives off.

    Ports:
        input state_sensed (12).
        output state_measured (12), of this instant.

    Args:
        initial: (12,).
        period: [s].
    """

    def __init__(self, initial: ArrayLike, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={"state_sensed": Input(STATE.size)},
                memory={"last": Memory(initial)},
                outputs={"state_measured": Output(STATE.size, show_last)},
                period=period,
                update=keep_last,
            )
        )

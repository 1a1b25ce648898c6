"""How much of a controller's gains the operator lets act, during a run."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.vectors import LIVE_SETTINGS, live_settings_of

Array = NDArray[np.float64]

# Never more than the scenario's gains, which the rule against chatter has seen, and never so little
# that the arm sinks.
LEAST, MOST = 0.25, 1.0
SLEW: Final = 1.0  # [1/s]


@njit(cache=True)
def scale_step(live_settings: Array, period: float, gain_scale: Array) -> None:
    """One tick of `GainScale`, in place; a setting that is not finite changes nothing."""
    wanted = live_settings_of(live_settings).gain_scale
    if np.isfinite(wanted):
        step = min(max(wanted, LEAST), MOST) - gain_scale[0]
        gain_scale[0] += min(max(step, -SLEW * period), SLEW * period)


class GainScale(Block):
    """Leads the operator's `gain_scale` to the controller, without a step.

    Ports:
        input live_settings (5): see `vectors.LiveSettings`.
        output gain_scale (1): 0.25 to 1.

    Update, at t = k period: the scale goes to the wanted one at 1 a second. Initial: 1.

    Args:
        period: [s].
    """

    def __init__(self, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={"live_settings": Input(LIVE_SETTINGS.size)},
                memory={"gain_scale": Memory([MOST], port=True)},
                parameters={"period": period},
                period=period,
                update=scale_step,
            )
        )

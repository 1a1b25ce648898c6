"""A hand that presses and lets go: whether it came to rest, and what drift it left."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr

from scara_drake.metrics import bilateral
from scara_drake.operator.master import Master

LAST: Final = 0.5  # [s], end of the run, in which a drift is left


def is_stable(recording: xr.Dataset, master: Master) -> bool:
    """Whether the press of a master's second target is stable, see `bilateral.is_stable_press`."""
    begin, end = master.times[1:3]
    return bilateral.is_stable_press(
        recording,
        begin=begin,
        end=end,
        way=float(np.linalg.norm(master.targets[1])),
        stiffness=master.hand_stiffness,
        mass=master.hardware().mass,
    )


def drift_left(recording: xr.Dataset, duration: float, position_scale: float = 1.0) -> float:
    """Return the largest distance [m] of the tool from the master at the end of a run.

    Args:
        recording: of a hand that has let go by then.
        duration: of the run [s].
        position_scale: of the coupling.
    """
    apart = bilateral.drift(recording, position_scale)
    return float(apart.sel(time=slice(duration - LAST, None)).max())

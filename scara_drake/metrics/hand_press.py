"""A hand that presses and lets go: its hold, whether it came to rest, and what drift it left."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import xarray as xr

from scara_drake.metrics import bilateral

if TYPE_CHECKING:
    from scara_drake.operator.master import Master

LAST: Final = 0.5  # [s], end of the run, in which a drift is left


def hold(recording: xr.Dataset, master: Master) -> tuple[float, float]:
    """Return when the hand has arrived at its second target, and when it begins to let go [s].

    Raises:
        ValueError: the hand does not press and let go.
    """
    times = master.times
    if len(times) < 3 or recording.time[-1] < times[2]:
        raise ValueError("the hand does not press and let go")
    return times[1], times[2]


def steady(recording: xr.Dataset, master: Master) -> xr.Dataset:
    """Return the steady part of the press, see `bilateral.steady_press`.

    Raises:
        ValueError: the hand does not press and let go.
    """
    return bilateral.steady_press(recording, *hold(recording, master))


def is_stable(recording: xr.Dataset, master: Master) -> bool:
    """Whether the press of a master's second target is stable, see `bilateral.is_stable_press`.

    Raises:
        ValueError: the hand does not press and let go.
    """
    begin, end = hold(recording, master)
    return bilateral.is_stable_press(
        recording,
        begin=begin,
        end=end,
        way=float(np.linalg.norm(master.targets[1])),
        stiffness=master.hand_stiffness,
        mass=master.hardware().mass,
    )


def drift_left(
    recording: xr.Dataset, end: float, position_scale: float = 1.0, last: float = LAST
) -> float:
    """Return the largest distance [m] of the tool from the master at the end of a run.

    Args:
        recording: of a hand that has let go by then.
        end: of the run [s].
        position_scale: of the coupling.
        last: time before the end in which it is looked for [s].
    """
    apart = bilateral.drift(recording, position_scale)
    return float(apart.sel(time=slice(end - last, None)).max())

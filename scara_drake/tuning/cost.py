"""What a run of tuned gains costs.

The cost of a run compares it, joint by joint, with the run of the start gains::

    J = mean_i (E_i + e_i) / (E_i0 + e_i)  +  w  mean_i (V_i + v_i) / (V_i0 + v_i)

E_i is the tracking error of joint i: its RMS sqrt(mean(e²)), or the integral of time times its
magnitude, ITAE = int t |e| dt. V_i = sum |tau_k - tau_(k-1)| is the total variation of the effort
within the limits, w its weight, 0 the start. e_i is the E_i of a constant error of 1 µm or 1 µrad,
and v_i 0.1 % of the effort limit: a joint that does nothing does not count. So the start costs
1 + w.

All count from t = 1 s on, or from the middle of a run of less than 2 s: before, the drives take up
the weight and catch up with a reference that begins at speed, at their limits whatever the gains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import joints, metrics
from scara_drake.common import checks

Array = NDArray[np.float64]

SETTLING: Final = 1.0  # [s]
RESOLUTION: Final = 1e-6  # [m, rad], of the errors
EFFORT_RESOLUTION: Final = 1e-3 * joints.EFFORT  # [N, N m]


def rms(time: Array, error: Array) -> Array:
    """Root of the mean square (6,) of the errors (n, 6) at times (n,)."""
    return np.sqrt((error**2).mean(axis=0))


def itae(time: Array, error: Array) -> Array:
    """Integral of time times the magnitude (6,) of the errors (n, 6) at times (n,)."""
    return np.asarray(np.trapezoid(time[:, None] * np.abs(error), time, axis=0))


TRACKING: Final[dict[str, Callable[[Array, Array], Array]]] = {"rmse": rms, "itae": itae}


@dataclass(frozen=True)
class Figures:
    """What a run is judged by, joint by joint.

    Attributes:
        tracking: RMS error (6,) [m, rad], or ITAE (6,) [m s², rad s²].
        effort: total variation (6,) [N, N m].
    """

    tracking: Array
    effort: Array


@dataclass(frozen=True)
class Aim:
    """What is to become small.

    Attributes:
        tracking: the name of the error's figure, of `TRACKING`.
        effort_weight: w.
    """

    tracking: str = "rmse"
    effort_weight: float = 0.1

    def check(self) -> None:
        """Check the name and the bounds.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.choice("tracking", self.tracking, TRACKING)
        checks.number("effort_weight", self.effort_weight, 0.0, 1e6)


DEFAULT_AIM: Final = Aim()


@dataclass(frozen=True)
class Cost(Aim):
    """The cost of the module's formula.

    Attributes:
        duration: of the runs [s].
    """

    duration: float = 1.0

    def figures(self, recording: xr.Dataset) -> Figures:
        """Return the figures of a recording, after the settling."""
        settled = recording.sel(time=slice(self._settling(), None))
        time = settled.time.values - self._settling()
        error = metrics.tracking_error(settled).values
        effort = abs(settled.tau_applied.diff("time")).sum("time", skipna=False).values
        return Figures(TRACKING[self.tracking](time, error), effort)

    def __call__(self, figures: Figures, start: Figures) -> float:
        """Return J; figures that equal those of the start cost 1 + w."""
        time = np.array([0.0, self.duration - self._settling()])
        floor = TRACKING[self.tracking](time, np.full((2, 6), RESOLUTION))
        tracking = (figures.tracking + floor) / (start.tracking + floor)
        effort = (figures.effort + EFFORT_RESOLUTION) / (start.effort + EFFORT_RESOLUTION)
        return float(tracking.mean() + self.effort_weight * effort.mean())

    def _settling(self) -> float:
        return min(SETTLING, 0.5 * self.duration)

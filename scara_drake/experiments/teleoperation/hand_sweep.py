"""A hand that presses and sweeps: the impedance that a scenario displays, and what it should be.

The hand goes to the press of its second target, waits until that rests, and sweeps. What a coupling
displays of the wall is then in the spectra, see `metrics.bilateral`; what it should display is a
closed form, see `stability.displayed_impedance`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.environment.wall import Wall
from scara_drake.metrics import bilateral
from scara_drake.operator.hand import Sweep
from scara_drake.operator.master import Master
from scara_drake.scenario import Scenario
from scara_drake.simulation.run import simulate
from scara_drake.stability.displayed_impedance import Way, displayed_impedance, pressed
from scara_drake.wiring.bilateral import DEVICE_TICKS, own_latency

Array = NDArray[np.float64]

AXIS: Final = "y"
BAND_SWEPT = (0.06, 16.0)  # [Hz]: it fades in and out beside `bilateral.BAND`
FROZEN = 40  # delays that stand for one that varies


@dataclass(frozen=True)
class HandSweep:
    """When a hand is there, and how it sweeps.

    Attributes:
        times: it starts, and is there [s].
        duration: of the sweep [s].
        amplitude: of the hand's target [m].
        settle: before the sweep, and after it [s].
    """

    times: Sequence[float]
    duration: float = 30.0
    amplitude: float = 5e-3
    settle: float = 4.0

    @property
    def start(self) -> float:
        """Of the sweep [s]."""
        return self.times[1] + self.settle

    def run(self, made: Scenario) -> xr.Dataset:
        """Simulate a scenario of a hand, which is changed; without a surface it stays."""
        master = cast(Master, made.operator)
        goal = master.targets[1] if made.environment.surfaces else [0.0, 0.0, 0.0]
        master.times, master.targets = list(self.times[:2]), [[0.0, 0.0, 0.0], goal]
        axis = "xyz".index(AXIS)
        master.sweep = Sweep(axis, self.amplitude, *BAND_SWEPT, self.start, self.duration)
        return simulate(made, duration=self.start + self.duration + self.settle)

    def displayed(self, recording: xr.Dataset, force: str = "f_master") -> xr.DataArray:
        """Impedance (frequency) of its recording, see `bilateral.impedance`."""
        return bilateral.impedance(recording, AXIS, self.start, force)

    def delays(self, recording: xr.Dataset) -> xr.DataArray:
        """Delay there and back (time) [s] of what is in use during the sweep."""
        ages = [bilateral.age_of_information(recording, link) for link in ("up", "down")]
        return (ages[0] + ages[1]).sel(time=slice(self.start, None))


def wall_of(made: Scenario) -> Wall:
    """Return the only surface of a scenario, a wall."""
    (wall,) = made.environment.surfaces
    return cast(Wall, wall)


def true_impedance(made: Scenario, frequency: xr.DataArray) -> xr.DataArray:
    """Return that of the wall (frequency) [N s/m] in the master's units."""
    wall = wall_of(made)
    true = bilateral.wall_impedance(frequency, wall.stiffness, wall.damping)
    return made.coupling.impedance_scale * true


def predicted(made: Scenario, frequency: xr.DataArray, delay: float) -> xr.DataArray:
    """Return the closed form (frequency) [N s/m] of a scenario whose channel delays by so much.

    Args:
        made: a scenario of a hand that presses a wall.
        frequency: [Hz].
        delay: there and back [s].

    Raises:
        ValueError: its coupling has no closed form.
    """
    master, wall = cast(Master, made.operator), wall_of(made)
    way = Way(delay, made.time_step, own_latency(made) - DEVICE_TICKS * made.time_step)
    # How far the hand wants to be beyond the surface, in the master's units.
    centre = np.add(master.centre, [0.0, 0.0, master.mast_height])
    aim = centre + np.multiply(master.targets[1], made.coupling.position_scale)
    beyond = float(np.dot(np.subtract(wall.point, aim), wall.normal))
    depth = beyond / made.coupling.position_scale
    touched = pressed(made.coupling, wall, master.hand_stiffness, depth, way)
    return displayed_impedance(made.coupling, touched, frequency, way)


def predicted_error(made: Scenario, frequency: xr.DataArray, delays: Array) -> float:
    """Mean |log10| of the closed form over the wall's, and over the delays [decades].

    Args:
        made: a scenario of a hand that presses a wall.
        frequency: [Hz].
        delays: there and back, over the time [s]; one that varies slowly is taken as frozen.

    Raises:
        ValueError: its coupling has no closed form.
    """
    ideal = true_impedance(made, frequency)
    quantiles = np.quantile(delays, (np.arange(FROZEN) + 0.5) / FROZEN).round(6)
    frozen, counts = np.unique(quantiles, return_counts=True)
    errors = [bilateral.decades(predicted(made, frequency, delay), ideal) for delay in frozen]
    return float(np.average(errors, weights=counts))

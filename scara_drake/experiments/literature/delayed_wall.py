r"""The delayed, sampled virtual wall: the largest stiffness that a device of known mass bears.

A device m with the friction b, in free air or in a hand, is pushed back by K x and by B times the
difference of its last two places over T, sampled with the period T, held, and late by t_d.
Published: passive, and so stable in any passive hand, where without delay
:math:`b > K T / 2 + |B|` (Colgate and Schenkel, Journal of Robotic Systems 14, 1997, 37); stable in
free air, as long as the virtual damping is small, where

.. math::

    K < \frac{b + B}{T / 2 + t_d}

(Gil, Sanchez, Hulin, Preusche and Hirzinger, Journal of Computing and Information Science in
Engineering 9, 2009; Hulin, Albu-Schaeffer and Hirzinger, IEEE Transactions on Control Systems
Technology 22, 2014, 1297). The boundary is found by running the device's own kernel until its swing
grows or dies, and beside that by the eigenvalues of the held system, with scipy's exponential and
nothing of ours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import xarray as xr
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import expm

from scara_drake.common import checks
from scara_drake.common.bisection import bracket
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment, at_least, within
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.operator.device_motion import move_device
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled
from scara_drake.stability.certificates import colgate_bound

Array = NDArray[np.float64]
Hand = tuple[float, float]  # [N/m], [N s/m]

PERIOD: Final = 1e-3  # T [s]
MASS, FRICTION = 0.3, 2.0  # m [kg] and b [N s/m] of the device
HANDS: Final[dict[str, Hand]] = {"no hand": (0.0, 0.0), "hand": (150.0, 4.0)}
SPRINGS: Final = (0.0, 10.0, 100.0, 1e3, 1e4, 1e5)  # [N/m], hands that take nothing
DAMPINGS: Final = (0.0, 10.0)  # B [N s/m]
DELAYS: Final = (0.0, 0.001, 0.002, 0.005, 0.010)  # t_d [s]
PRECISION = 1e-5  # of a boundary
FOUR_DIGITS, LAW, LAW_DAMPED = 5e-5, 0.03, 0.13  # shares
SWINGS: Final = 20.0  # [s], of a run that tells whether it grows
FAR: Final = 1e6  # [m], from a start of 1 m


def run(seed: int = 0, delays: tuple[float, ...] = DELAYS, duration: float = SWINGS) -> Experiment:
    """Find the largest stable stiffness, by the kernel and by eigenvalues.

    Args:
        seed: of nothing, no part is random.
        delays: t_d [s], whole periods.
        duration: of a run [s].

    Raises:
        ValueError: a delay is no whole number of periods up to 1 s, or the runs are too short.
    """
    for index, delay in enumerate(delays):
        checks.number(f"delays[{index}]", delay, 0.0, 1.0)
        if not abs(delay / PERIOD - round(delay / PERIOD)) < 1e-9:
            raise ValueError(f"delays[{index}]: {delay} s, allowed whole periods of {PERIOD} s")
    checks.number("duration", duration, 1.0)
    names = ("hand", "damping", "delay")

    def over(find: Callable[[Hand, float, float], float], what: str) -> xr.Variable:
        found = [[[find(hand, b, t) for t in delays] for b in DAMPINGS] for hand in HANDS.values()]
        return labelled(names, np.array(found), "N/m", what)

    data = xr.Dataset(
        {
            "by_kernel": over(
                lambda hand, b, t: simulated_boundary(hand, b, t, duration),
                "largest stable stiffness, by runs of the device's kernel",
            ),
            "by_eigenvalues": over(
                exact_boundary, "the same, by the eigenvalues of the held system"
            ),
            "law": over(linear_law, "all damping over half a period and the delay"),
            "passive": labelled(
                ("damping",),
                np.array([colgate_bound(FRICTION, b, PERIOD) for b in DAMPINGS]),
                "N/m",
                "largest stiffness that is passive without delay; negative where none is",
            ),
            "in_springs": labelled(
                ("spring",),
                np.array([exact_boundary((spring, 0.0), 0.0, 0.0) for spring in SPRINGS]),
                "N/m",
                "largest stable stiffness without delay and damping, in a hand that is a spring",
            ),
        },
        coords={
            "hand": list(HANDS),
            "damping": ("damping", list(DAMPINGS), {"units": "N s/m"}),
            "delay": ("delay", list(delays), {"units": "s"}),
            "spring": ("spring", list(SPRINGS), {"units": "N/m"}),
        },
        attrs={"seed": seed, "period": PERIOD, "mass": MASS, "friction": FRICTION},
    )
    return Experiment("Delayed virtual wall", data, claims(data))


def linear_law(hand: Hand, damping: float, delay: float) -> float:
    """Return the stiffness [N/m] of the published law, the damping of the hand with the rest."""
    return (FRICTION + hand[1] + damping) / (0.5 * PERIOD + delay)


def exact_boundary(hand: Hand, damping: float, delay: float) -> float:
    """Return the stiffness [N/m] at which an eigenvalue of the held system leaves the circle."""
    late = round(delay / PERIOD)
    rates = np.zeros((3, 3))
    rates[0, 1] = 1.0
    rates[1] = [-hand[0] / MASS, -(FRICTION + hand[1]) / MASS, -1.0 / MASS]
    held = expm(rates * PERIOD)

    def grows(stiffness: float) -> bool:
        # x, v, the last x, and the forces on their way, newest first
        step, sampled = np.zeros((3 + late, 3 + late)), np.zeros(3 + late)
        sampled[[0, 2]] = stiffness + damping / PERIOD, -damping / PERIOD
        step[2, 0] = 1.0
        acting = sampled
        if late:
            acting = np.eye(3 + late)[-1]
            step[3] = sampled
            step[4:, 3:-1] = np.eye(late - 1)
        step[:2, :2] = held[:2, :2]
        step[:2] += np.outer(held[:2, 2], acting)
        return bool(np.abs(np.linalg.eigvals(step)).max() > 1.0 + 1e-12)

    return _boundary(grows, linear_law(hand, damping, delay))


def simulated_boundary(hand: Hand, damping: float, delay: float, duration: float = SWINGS) -> float:
    """Return the stiffness [N/m] from which the swing of the device's own kernel grows."""
    device = Master(
        mass=MASS,
        damping=FRICTION,
        actuator_limit=np.inf,
        hand_stiffness=hand[0],
        hand_damping=hand[1],
    ).parameters(PERIOD)
    steps, late = round(duration / PERIOD), round(delay / PERIOD)

    def grows(stiffness: float) -> bool:
        return _second_half_is_larger(_swing(device, stiffness, damping, late, steps))

    return _boundary(grows, linear_law(hand, damping, delay))


def _second_half_is_larger(x: Array) -> bool:
    if not abs(x[-1]) < FAR:
        return True
    half = x.size // 2
    window = np.hanning(half)  # what is left of a swing's phase falls with its cube
    return bool(window @ x[half : 2 * half] ** 2 > window @ x[:half] ** 2)


def _boundary(grows: Callable[[float], bool], near: float) -> float:
    return 0.5 * sum(bracket(grows, 0.5 * near, 2.0 * near, PRECISION))


@njit(cache=True)
def _swing(device: Array, stiffness: float, damping: float, late: int, steps: int) -> Array:
    """Return the place [m] of a device that is let go at 1 m, each period (steps,)."""
    motion, still, target = np.zeros(6), np.zeros(3), np.zeros(3)
    f_hand, f = np.zeros(3), np.zeros(3)
    motion[0] = 1.0
    x, wall = np.zeros(steps), np.zeros(steps)
    for k in range(steps):
        x[k] = motion[0]
        if not abs(x[k]) < FAR:
            x[-1] = np.inf
            break
        rate = (x[k] - x[k - 1]) / PERIOD if k > 0 else 0.0
        wall[k] = stiffness * x[k] + damping * rate
        f[0] = wall[k - late] if k >= late else 0.0
        move_device(device, f, still, motion, target, f_hand)
    return x


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge what was published of the wall; see `run` for the data."""
    free, damped = (data.sel(hand="no hand", damping=b) for b in DAMPINGS)
    return [_exact(data), _law(free), _law_damped(damped), _passive(data)]


def _exact(data: xr.Dataset) -> Claim:
    found = quantity(data.by_kernel, "N/m")
    off = abs(data.by_kernel / data.by_eigenvalues - 1.0).max()
    return Claim(
        "The simulated device bears what the eigenvalues of the held system say",
        quantity(data.by_eigenvalues, "N/m", "by eigenvalues"),
        (found, quantity(1e6 * off, "ppm", "apart", "up to")),
        Criterion(
            "within 50 ppm, four digits, at each delay and damping, with and without a hand",
            within(found, FOUR_DIGITS),
        ),
        "The device is integrated exactly for a held force, so only the search has an error.",
        OURS,
    )


def _law(free: xr.Dataset) -> Claim:
    found = quantity(free.by_kernel, "N/m")
    return Claim(
        "Gil and Hulin: without virtual damping, K < b / (T / 2 + t_d)",
        quantity(free.law, "N/m", "by the law"),
        (found, _apart(free)),
        Criterion(
            f"within {1e2 * LAW:g} % at each delay, and the law never above what is borne",
            (within(found, LAW), bool((free.by_kernel >= free.law).all())),
        ),
        "The law is the first term in the frequency of the swing, which is low where K is.",
        OURS,
    )


def _law_damped(damped: xr.Dataset) -> Claim:
    found = quantity(damped.by_kernel, "N/m")
    return Claim(
        "Gil and Hulin: with virtual damping five times the device's, K < (b + B) / (T / 2 + t_d)",
        quantity(damped.law, "N/m", "by the law"),
        (found, _apart(damped)),
        Criterion(
            f"within {1e2 * LAW_DAMPED:g} % at each delay (in kind: {2e2 * LAW_DAMPED:g} %), and "
            "what is borne is below the law at each",
            (within(found, LAW_DAMPED), bool((damped.by_kernel < damped.law).all())),
            within(found, 2.0 * LAW_DAMPED),
        ),
        "The law is for small virtual damping: this one is late as well, and here promises too "
        "much, the more the longer the delay.",
        OURS,
    )


def _apart(data: xr.Dataset) -> Quantity:
    return quantity(1e2 * (data.by_kernel / data.law - 1.0), "%", "from the law")


def _passive(data: xr.Dataset) -> Claim:
    found = quantity(data.in_springs, "N/m", "borne in hands that are springs")
    in_air = float(data.by_kernel.sel(hand="no hand", damping=DAMPINGS[1])[0])
    return Claim(
        "Colgate and Schenkel: for b > K T / 2 + |B| the wall is stable in every passive hand",
        quantity(data.passive.sel(damping=0.0), "N/m", "bound of passivity, B = 0"),
        found,
        Criterion(
            "at B = 0 and no delay, in every spring of 0 to 100 kN/m, at least the bound is borne, "
            "and in one less than 1 % more",
            (at_least(found), bool(data.in_springs.min() < 1.01 * data.passive.sel(damping=0.0))),
        ),
        f"Passive is more than stable: with B = {DAMPINGS[1]:g} N s/m no stiffness is, and in free "
        f"air {in_air:.0f} N/m are borne.",
        OURS,
    )

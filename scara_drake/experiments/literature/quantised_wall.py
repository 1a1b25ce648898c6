r"""The sampled virtual wall with an encoder: friction pays for what sampling and counts give.

A device with the friction b and f_c is pushed back by K times the count of its place in a wall,
sampled with the period T and held. Published as necessary and sufficient for a wall from which no
user gets energy (Abbott and Okamura, IEEE Transactions on Robotics 21, 2005, 952; the formula from
memory):

.. math::

    K \le \min\left(\frac{2 b}{T}, \frac{2 f_c}{\Delta}\right)

with :math:`\Delta` the count. Here users of two kinds go to and fro, a period each way: over many
counts, which finds the first bound, and by next to nothing over the edge of one, which finds the
second. Between two of both, what is got is a mean of the two. The device moves by its own kernel at
a hundredth of the period, and the user's force is held over that, so his work is exact.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.common.bisection import bracket
from scara_drake.experiments.claim import OURS, Claim, Criterion, Experiment, within
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.operator.device_motion import device_of, move_device
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled

Array = NDArray[np.float64]

PERIOD: Final = 1e-3  # T [s]
FINE: Final = 100  # steps of the user in a period
MASS: Final = 0.05  # [kg]; passivity does not depend on it
EDGE: Final = 3.5  # counts into the wall, where a count ends
OVER: Final = 0.001  # of a count, by which the edge is crossed
COUNTS: Final = (0, 10_000)  # ways of the users, in counts
CYCLES: Final = 3
PRECISION: Final = 1e-3  # of the stiffness that is found
NEAR: Final = 0.03  # share
BELOW: Final = 0.97  # of the bound, where users at random get nothing


class Wall(NamedTuple):
    """A device at a wall: b [N s/m], f_c [N] and the count [m]."""

    viscous: float
    friction: float
    resolution: float

    def bound(self) -> float:
        """Return the published bound of the stiffness [N/m]."""
        return min(2.0 * self.viscous / PERIOD, 2.0 * self.friction / self.resolution)


WALLS: Final[dict[str, Wall]] = {
    "viscous": Wall(0.5, 1.0, 1e-4),
    "viscous, fine": Wall(2.0, 0.26, 1e-5),
    "alike": Wall(1.0, 0.1, 1e-4),
    "counts": Wall(5.0, 0.05, 1e-4),
    "touch": Wall(0.1 + 4.0, 0.26, 5.5e-5),  # with the damping of a hand
    "counts, coarse": Wall(2.0, 0.2, 1e-3),
}


def run(seed: int = 0, walls: tuple[str, ...] = tuple(WALLS), users: int = 5) -> Experiment:
    """Find the stiffness from which on a user gets energy, and look below it at random users.

    Args:
        seed: of the users at random.
        walls: of `WALLS`.
        users: at random, at each wall.

    Raises:
        ValueError: an unknown wall, or no users.
    """
    for name in walls:
        checks.choice("walls", name, tuple(WALLS))
    checks.number("users", users, 1, 10_000)
    chosen = [WALLS[name] for name in walls]
    random = np.random.default_rng(seed)
    data = xr.Dataset(
        {
            "found": labelled(
                ("wall", "counts"),
                np.array([[largest_passive(wall, n) for n in COUNTS] for wall in chosen]),
                "N/m",
                "stiffness from which on a user who goes so many counts to and fro gets energy",
            ),
            "bound": labelled(
                ("wall",),
                np.array([wall.bound() for wall in chosen]),
                "N/m",
                "min(2 b/T, 2 f_c/count)",
            ),
            "least_work": labelled(
                ("wall",),
                np.array([least_work(wall, users, random) for wall in chosen]),
                "J",
                "least work at any time that a user at random has done, just below the bound",
            ),
        },
        coords={"wall": list(walls), "counts": list(COUNTS)},
        attrs={"seed": seed, "period": PERIOD},
    )
    return Experiment("Quantised virtual wall", data, claims(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Say what the walls and the published bound have to do with each other."""
    names = tuple(str(name) for name in data.wall.values)
    found = Quantity(tuple(data.found.min("counts").values.tolist()), "N/m", names=names)
    bound = Quantity(tuple(data.bound.values.tolist()), "N/m", names=names)
    return [
        Claim(
            "Abbott and Okamura (from memory): a virtual wall gives no user energy up to K = "
            "min(2 b / T, 2 f_c / count), and does beyond",
            bound,
            found,
            Criterion(
                f"the smallest stiffness at which one of two users gets energy is within "
                f"{1e2 * NEAR:g} % of it, at every wall",
                within(found, NEAR),
            ),
            "Who crosses the edge of a count with each sample gets K times the count on a way for "
            "which only Coulomb friction asks anything.",
            OURS,
        ),
        Claim(
            "Below the bound, users at random get nothing",
            None,
            (
                quantity(1e6 * data.least_work.min(), "uJ", "least work that one has done"),
                quantity(1e2 * BELOW, "%", "of the bound"),
            ),
            Criterion(
                "none has got out more than he put in, at any time, but for rounding",
                bool((data.least_work >= -1e-12).all()),
            ),
            "The bound is sufficient, too.",
            OURS,
        ),
    ]


def largest_passive(wall: Wall, counts: int) -> float:
    """Return the stiffness [N/m] from which on a user gets energy who goes so many counts."""
    count, device = wall.resolution, _device(wall)
    low_place = (EDGE - 0.5 * OVER) * count
    high_place = low_place + (counts + OVER) * count
    start = np.linspace(0.0, low_place, 10)
    places = np.concatenate([start, np.tile([high_place, low_place], CYCLES)])

    def gives(stiffness: float) -> bool:
        done = user_work(device, stiffness, count, FINE, places)
        return bool(done[-1] < done[-3])

    low, high = 0.0, wall.bound()
    while not gives(high):
        low, high = high, 2.0 * high
    return bracket(gives, low, high, PRECISION)[1]


def least_work(wall: Wall, users: int, random: np.random.Generator) -> float:
    """Return the least work [J] that one of some users at random has done at any time.

    Each goes from place to place by steps of a size of his own, about a depth of his own.
    """
    device, stiffness = _device(wall), BELOW * wall.bound()
    least = np.inf
    for _ in range(users):
        size = wall.resolution * 10.0 ** random.uniform(-2.0, 2.0)
        depth = wall.resolution * 10.0 ** random.uniform(0.0, 2.0)
        places = np.concatenate([[0.0], depth + size * random.normal(size=100)])
        done = user_work(device, stiffness, wall.resolution, FINE, places)
        least = min(least, float(done[1:].min()))
    return least


def _device(wall: Wall) -> Array:
    made = Master(
        mass=MASS, damping=wall.viscous, friction=wall.friction, actuator_limit=np.inf,
        hand_stiffness=0.0, hand_damping=0.0,
    )  # fmt: skip
    return made.parameters(PERIOD / FINE)


@njit(cache=True)
def user_work(device: Array, stiffness: float, count: float, fine: int, places: Array) -> Array:
    """Return the work [J] that a user has done at each sample (n,) of a virtual wall.

    Args:
        device: of `Master.parameters`, over a step of the user.
        stiffness: of the wall, K [N/m].
        count: of the encoder [m].
        fine: steps of the user in a sample.
        places: where he goes with each sample, in straight lines, from the first on (n,) [m].
    """
    d = device_of(device)
    motion, target, still = np.zeros(6), np.zeros(3), np.zeros(3)
    f, f_hand = np.zeros(3), np.zeros(3)
    work = np.zeros(places.size)
    motion[0] = places[0]
    for k in range(1, places.size):
        pushed = stiffness * max(count * np.rint(motion[0] / count), 0.0)
        speed = (places[k] - places[k - 1]) / (fine * d.period)
        done = 0.0
        for j in range(fine):
            before = motion[0]
            behind = places[k - 1] + speed * j * d.period - before
            wanted = speed + 0.2 * behind / d.period
            inertia = d.mass * (wanted - motion[3]) / d.period
            user = pushed + inertia + d.viscous * wanted + np.sign(wanted) * d.friction
            f[0] = pushed - user
            move_device(device, f, still, motion, target, f_hand)
            done += user * (motion[0] - before)
        work[k] = work[k - 1] + done
    return work

"""What is done to a posture (6,): limits, whole turns, and the other posture of the same pose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

TURN = 2.0 * np.pi
TURNED = 27  # postures that one becomes by a whole turn of three joints, either way


class Bounds(NamedTuple):
    """Which joints may move, and how far.

    Attributes:
        first_joint: 0 moves the mast, 1 keeps it.
        lower: joint limits (6,).
        upper: joint limits (6,).
    """

    first_joint: int
    lower: Array
    upper: Array


class Goal(NamedTuple):
    """A pose, and the joints that are to hold it.

    Attributes:
        p: tool position p_WE (3,) [m].
        R: tool rotation R_WE (3, 3).
        bounds: of the joints.
    """

    p: Array
    R: Array
    bounds: Bounds


@njit(cache=True)
def ranges_kernel(first_joint: int) -> Bounds:
    """Return the ranges of the joints."""
    # Copies: numba holds a constant array for another type, and would compile all callees twice.
    return Bounds(first_joint, LOWER.copy(), UPPER.copy())


@njit(cache=True)
def goal_kernel(p: Array, R: Array, first_joint: int) -> Goal:
    """Return a pose with the ranges of the joints."""
    return Goal(p, R, ranges_kernel(first_joint))


@njit(cache=True)
def turns_kernel(j: int) -> bool:
    """Whether joint j has more than one turn: theta2, theta3 and theta6."""
    return j == 1 or j == 2 or j == 5


@njit(cache=True)
def keep_limits_kernel(q: Array, bounds: Bounds, wrap: bool) -> None:
    """Bring q (6,) inside the limits: whole turns where allowed, else the nearest limit."""
    lower, upper = bounds.lower, bounds.upper
    for j in range(bounds.first_joint, 6):
        if wrap and turns_kernel(j):
            while q[j] > upper[j]:
                q[j] -= TURN
            while q[j] < lower[j]:
                q[j] += TURN
        q[j] = min(max(q[j], lower[j]), upper[j])


@njit(cache=True)
def nearest_turns_kernel(q: Array, reference: Array) -> None:
    """Turn theta2, theta3 and theta6 of q (6,) by whole turns to lie nearest to a posture."""
    for j in (1, 2, 5):
        turned = q[j] + TURN * np.round((reference[j] - q[j]) / TURN)
        if turned > UPPER[j]:
            turned -= TURN
        elif turned < LOWER[j]:
            turned += TURN
        if LOWER[j] <= turned <= UPPER[j]:
            q[j] = turned


@njit(cache=True)
def turned_kernel(q: Array, k: int, slack: float, turned: Array) -> bool:
    """Write turning k of the 27 of a posture (6,), settled; return whether it is inside."""
    turned[:] = q
    turned[1] += TURN * (k // 9 - 1)
    turned[2] += TURN * (k // 3 % 3 - 1)
    turned[5] += TURN * (k % 3 - 1)
    settle_kernel(turned, slack)
    return inside_kernel(turned)


@njit(cache=True)
def inside_kernel(q: Array) -> bool:
    """Whether a posture (6,) is inside the joint ranges."""
    for j in range(6):  # noqa: SIM110 (numba compiles no generator in `all`)
        if not LOWER[j] <= q[j] <= UPPER[j]:
            return False
    return True


@njit(cache=True)
def settle_kernel(q: Array, slack: float) -> None:
    """Put the joints of q (6,) that are past a limit by `slack` or less onto it, in place."""
    for j in range(6):
        if LOWER[j] - slack <= q[j] <= UPPER[j] + slack:
            q[j] = min(max(q[j], LOWER[j]), UPPER[j])


@njit(cache=True)
def distance_kernel(q: Array, near: Array) -> float:
    """Square of the distance between two postures (6,), metres and radians alike."""
    s = 0.0
    for j in range(6):
        s += (q[j] - near[j]) * (q[j] - near[j])
    return s


@njit(cache=True)
def mirror_kernel(q: Array, mirrored: Array) -> None:
    """Write the other posture (6,) of the same tool pose: the beam turned by half a turn.

    T(θ3 + π, π - θ4, π - θ5, θ6 + π) = T(θ3, θ4, θ5, θ6); θ4 and θ5 come out within ±π.
    """
    mirrored[:] = q
    mirrored[2] = q[2] + np.pi if q[2] <= 0.0 else q[2] - np.pi
    mirrored[3] = np.pi - q[3] if q[3] > 0.0 else -np.pi - q[3]
    mirrored[4] = np.pi - q[4] if q[4] > 0.0 else -np.pi - q[4]
    mirrored[5] = q[5] + np.pi if q[5] <= 0.0 else q[5] - np.pi


@njit(cache=True)
def wrap_kernel(angle: float) -> float:
    """Return the angle within (-pi, pi]."""
    wrapped = angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    return wrapped + 2.0 * np.pi if wrapped <= -np.pi else wrapped

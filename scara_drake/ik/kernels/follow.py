"""The inverse Jacobian iterated: from a seed, and along a path."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.layout import Layout
from scara_drake.ik.kernels.errors import within_kernel
from scara_drake.ik.kernels.postures import Goal, ranges_kernel
from scara_drake.ik.kernels.refine import Descent, refine_kernel, refine_position_first_kernel

Array = NDArray[np.float64]


class Iteration(NamedTuple):
    """How the inverse Jacobian is iterated; all numbers, so that ``np.array`` packs one.

    Attributes:
        first_joint: 0 moves the mast, 1 keeps it.
        position_first: 1 for the position exactly and the rotation in its null space, or 0.
        length: weight of the rotation [m/rad]; 0 leaves the position rows (26) alone.
        step: largest change of a joint in one iteration [rad], [m].
        iterations: budget of a point.
        max_change: largest change of a joint between neighbouring points [rad], [m].
        stop: 1 ends a path at the first point outside the tolerances, or 0.
    """

    first_joint: float
    position_first: float
    length: float
    step: float
    iterations: float
    max_change: float = np.inf
    stop: float = 0.0


iteration_of = Layout(Iteration).reader()


@njit(cache=True)
def _iterate(
    q: Array, goal: Goal, iteration: Array, wrap: bool, history: Array
) -> tuple[float, float, int, int]:
    s = iteration_of(iteration)
    descent = Descent(s.length, s.step, int(s.iterations), wrap)
    if s.position_first > 0.0 and s.length > 0.0:
        return refine_position_first_kernel(q, goal, descent, history)
    return refine_kernel(q, goal, descent, history)


@njit(cache=True)
def iterate_kernel(
    q: Array, p: Array, R: Array, iteration: Array, history: Array
) -> tuple[int, int]:
    """Solve one target p (3,), R (3, 3) from q (6,), in place; return evaluations, iterations.

    Args:
        q: posture, in place.
        p: target [m].
        R: target.
        iteration: see `Iteration`.
        history: (h, 2), receives the errors of the first h iterations.
    """
    goal = Goal(p, R, ranges_kernel(int(iteration_of(iteration).first_joint)))
    _, _, evaluations, iterations = _iterate(q, goal, iteration, True, history)
    return evaluations, iterations


@njit(cache=True)
def follow_kernel(
    p: Array,
    R: Array,
    iteration: Array,
    start: Array,
    begin: int,
    q: Array,
    evaluations: NDArray[np.int64],
    steps: NDArray[np.int64],
) -> int:
    """Follow targets from index `begin`, each from the answer before.

    A posture further than `max_change` from the one before is drawn back along the way.

    Args:
        p: targets (n, 3) [m].
        R: targets (n, 3, 3).
        iteration: see `Iteration`.
        start: posture (6,) before the first of them.
        begin: index of that one.
        q: postures (n, 6), written from there on.
        evaluations: (n,), likewise.
        steps: iterations (n,), likewise.

    Returns:
        The index of the first point outside the tolerances where the iteration stops there, else n.
    """
    s, bounds, none = iteration_of(iteration), ranges_kernel(0), np.empty((0, 2))
    first_joint, position_first = int(s.first_joint), s.position_first > 0.0
    before, pace = start.copy(), np.zeros(6)
    if begin > 1:
        pace[:] = before - q[begin - 2]
    for k in range(begin, p.shape[0]):
        goal = Goal(p[k], R[k], ranges_kernel(first_joint))
        evaluations[k], steps[k] = 0, 0
        good, largest = False, 0.0
        # From where the motion would carry on, which passes through a singular posture instead of
        # turning back there; else from the posture before.
        for attempt in range(2):
            for j in range(6):
                ahead = before[j] + (pace[j] if attempt == 0 else 0.0)
                inside = min(max(ahead, bounds.lower[j]), bounds.upper[j])
                q[k, j] = inside if j >= first_joint else before[j]
            position, rotation, ev, it = _iterate(q[k], goal, iteration, False, none)
            evaluations[k] += ev
            steps[k] += it
            largest = 0.0
            for j in range(6):
                largest = max(largest, abs(q[k, j] - before[j]))
            good = within_kernel(position, rotation, position_first) and largest <= s.max_change
            if good:
                break
        if not good and largest > s.max_change:
            for j in range(6):
                q[k, j] = before[j] + (q[k, j] - before[j]) * s.max_change / largest
        if s.stop > 0.0 and not good:
            return k
        pace[:] = q[k] - before
        before[:] = q[k]
    return p.shape[0]

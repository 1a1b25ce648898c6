"""What an inverse kinematics call takes and returns, and the tolerances that decide success."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Tolerances of the paper (section III-C): position [m] and orientation [rad].
POSITION_TOLERANCE: Final = 5e-3
ROTATION_TOLERANCE: Final = 0.0175
# Length that makes one radian count as much as the position tolerance makes a metre, [m/rad].
ROTATION_LENGTH: Final = POSITION_TOLERANCE / ROTATION_TOLERANCE

CONVERGED: Final = "converged"
OUT_OF_REACH: Final = "out of reach"
JOINT_LIMITS: Final = "joint limits"
NOT_ATTAINABLE: Final = "orientation not attainable"
NOT_CONVERGED: Final = "not converged"

# Who found a posture, where that is not the method itself.
ROBUST: Final = "robust"
FOLLOWED: Final = "inverse_jacobian"
CLOSED_FORM: Final = "closed_form"


@dataclass(frozen=True, eq=False)
class Problem:
    """One checked target.

    Attributes:
        p: desired tool position p_WE (3,) [m].
        R: desired tool rotation R_WE (3, 3).
        first_joint: 0 when the mast moves, 1 when it keeps its height.
        position_first: the position exactly and the orientation as near as possible (task
            "position"), instead of both at once (task "pose").
        start: posture (6,) where a local method begins and whose mast height an arm keeps.
        seeded: the start was given by the caller.
        seed: of the random draws.
    """

    p: Array
    R: Array
    first_joint: int
    position_first: bool
    start: Array
    seeded: bool
    seed: int


@dataclass(frozen=True, eq=False)
class Answer:
    """What a method found: the posture (6,) and the work done; nobody has confirmed it yet.

    `found_by` names the method that found it, "" for the one that was asked.
    """

    q: Array
    evaluations: int
    iterations: int
    history: Array | None = None
    found_by: str = ""


@dataclass(frozen=True, eq=False)
class PathAnswer:
    """What a method found along a path: postures (n, 6) and the work at each point (n,).

    `found_by` (n,) as in `Answer`; () where every point is the method's own.
    """

    q: Array
    evaluations: NDArray[np.int64]
    iterations: NDArray[np.int64]
    found_by: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class IkResult:
    """Answer to one target, confirmed by forward kinematics.

    Attributes:
        q: posture (6,), d1 [m], theta2 .. theta6 [rad], inside the joint ranges; the best found
            where success is False.
        position_error: distance of the tool point to the target [m].
        rotation_error: angle of the rotation left to the target [rad].
        success: task "pose": both errors within 5 mm and 0.0175 rad; task "position": the
            position within 5 mm.
        evaluations: forward kinematics spent.
        iterations: swarm iterations, or damped least-squares steps for the inverse Jacobian.
        method: name of the method that was asked.
        found_by: name of the method that found the posture: "dpso" for the swarm of "dpsoij", and
            "robust" where a swarm did not converge within its budget.
        seconds: wall time of the search [s]; nothing depends on it.
        reason: "converged", "out of reach", "joint limits", "orientation not attainable" or
            "not converged".
        history: with option history=True, (n, 2): position [m] and rotation [rad] error of the
            best posture at each iteration.
    """

    q: Array
    position_error: float
    rotation_error: float
    success: bool
    evaluations: int
    iterations: int
    method: str
    reason: str
    history: Array | None = None
    found_by: str = ""
    seconds: float = 0.0

    def _repr_html_(self) -> str:
        from scara_drake.ik.cards import of_result

        return of_result(self)


@dataclass(frozen=True, eq=False)
class IkPath:
    """Answers to n targets in order: the fields of IkResult as arrays (n, ...).

    `found_by` (n,) tells the first posture, found by a search, from those that the inverse Jacobian
    followed; `seconds` is the time of all.
    """

    q: Array
    position_error: Array
    rotation_error: Array
    success: NDArray[np.bool_]
    evaluations: NDArray[np.int64]
    iterations: NDArray[np.int64]
    method: str
    reason: tuple[str, ...]
    found_by: tuple[str, ...] = ()
    seconds: float = 0.0

    def __len__(self) -> int:
        return len(self.q)

    def _repr_html_(self) -> str:
        from scara_drake.ik.cards import of_path

        return of_path(self)

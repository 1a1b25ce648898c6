"""The public calls: check the target, run a method, confirm its answer by forward kinematics."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake import kinematics
from scara_drake.common import checks
from scara_drake.ik import closed_form, dpso, dpsoij, inverse_jacobian, robust
from scara_drake.ik.following import follow_robustly
from scara_drake.ik.kernels.errors import confirm_kernel
from scara_drake.ik.options import (
    ClosedFormOptions,
    DpsoijOptions,
    InverseJacobianOptions,
    MethodOptions,
    RobustOptions,
    SwarmOptions,
    make_options,
)
from scara_drake.ik.result import (
    CONVERGED,
    JOINT_LIMITS,
    NOT_ATTAINABLE,
    NOT_CONVERGED,
    OUT_OF_REACH,
    POSITION_TOLERANCE,
    Answer,
    IkPath,
    IkResult,
    PathAnswer,
    Problem,
)
from scara_drake.ik.target import confirm, make_problem
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]


class Method(NamedTuple):
    """How a method solves one target, and a path where it does not treat each point alone."""

    options: type[MethodOptions]
    solve: Callable[[Problem, Any], Answer]
    follow: Callable[[Sequence[Problem], Any], PathAnswer] | None = None


# A new method is one file and one line here.
METHODS: Final[dict[str, Method]] = {
    "closed_form": Method(ClosedFormOptions, closed_form.solve, closed_form.follow),
    "robust": Method(RobustOptions, robust.solve, follow_robustly),
    "inverse_jacobian": Method(
        InverseJacobianOptions, inverse_jacobian.solve, inverse_jacobian.follow
    ),
    "pso": Method(SwarmOptions, dpso.solve_single),
    "dpso": Method(SwarmOptions, dpso.solve),
    "dpsoij": Method(DpsoijOptions, dpsoij.solve, dpsoij.follow),
}


def solve(
    X_WE: Any,
    method: str = "robust",
    joints: str = "full",
    task: str = "pose",
    q_seed: ArrayLike | None = None,
    seed: int = 0,
    **options: object,
) -> IkResult:
    """Find joint values that bring the tool to a pose.

    Args:
        X_WE: desired tool pose, (4, 4) [m], or an object with GetAsMatrix4 (Drake's
            RigidTransform).
        method: a name of METHODS: "robust" (closed form and least squares, the fastest that finds
            every pose), "closed_form", "inverse_jacobian", "pso", "dpso", or "dpsoij" (the paper's,
            whose first posture is found by DPSO).
        joints: "full" moves all six, "arm" keeps q_seed[0] as the mast height.
        task: "pose" for position and orientation together; "position" for the position exactly
            and the orientation as near as the remaining joints allow.
        q_seed: posture (6,) where a local method starts; "arm" needs it. Swarm methods only turn
            theta2, theta3 and theta6 to lie nearest to it: their option nearest_to chooses the
            branch.
        seed: of the random draws; the same seed gives the same bits.
        options: of the method, see scara_drake.ik.options.

    Returns:
        The answer, confirmed by forward kinematics; success is never claimed outside the
        tolerances or the joint ranges.

    Raises:
        ValueError: the target, a name, an option or a seed is not allowed; one line that says
            what is.
    """
    chosen = _method(method)
    values = make_options(chosen.options, method, options)
    problem = make_problem(X_WE, "X_WE", joints, task, q_seed, seed)
    begin = time.perf_counter()
    answer = chosen.solve(problem, values)
    seconds = time.perf_counter() - begin
    position, rotation, success = confirm_kernel(
        answer.q, problem.p, problem.R, problem.position_first
    )
    return IkResult(
        q=answer.q,
        position_error=position,
        rotation_error=rotation,
        success=success,
        evaluations=answer.evaluations,
        iterations=answer.iterations,
        method=method,
        reason=CONVERGED if success else _diagnose(problem),
        history=answer.history,
        found_by=answer.found_by or method,
        seconds=seconds,
    )


def solve_path(
    X_WEs: Sequence[Any] | Array,
    method: str = "robust",
    joints: str = "full",
    task: str = "pose",
    q_seed: ArrayLike | None = None,
    seed: int = 0,
    **options: object,
) -> IkPath:
    """Find joint values along a path of n poses, (n, 4, 4) or a sequence; see `solve`.

    "robust", "closed_form", "inverse_jacobian" and "dpsoij" solve each point from the one before,
    and begin near q_seed; the others solve each point alone, point k with seed + k.

    Raises:
        ValueError: as `solve`; the path is empty; history is asked for.
    """
    chosen = _method(method)
    values = make_options(chosen.options, method, options)
    if values.history:
        raise ValueError("history: True, allowed False for a path")
    problems = [
        make_problem(X, f"X_WEs[{k}]", joints, task, q_seed, seed + k) for k, X in enumerate(X_WEs)
    ]
    if not problems:
        raise ValueError("X_WEs: 0 poses, allowed 1 or more")
    begin = time.perf_counter()
    if chosen.follow is not None:
        answer = chosen.follow(problems, values)
    else:
        answers = [chosen.solve(problem, values) for problem in problems]
        answer = PathAnswer(
            q=np.array([a.q for a in answers]),
            evaluations=np.array([a.evaluations for a in answers]),
            iterations=np.array([a.iterations for a in answers]),
            found_by=tuple(a.found_by for a in answers),
        )
    seconds = time.perf_counter() - begin
    position, rotation, success = confirm(answer.q, problems)
    reason = tuple(
        CONVERGED if good else _diagnose(problem)
        for problem, good in zip(problems, success, strict=True)
    )
    return IkPath(
        q=answer.q,
        position_error=position,
        rotation_error=rotation,
        success=success,
        evaluations=answer.evaluations,
        iterations=answer.iterations,
        method=method,
        reason=reason,
        found_by=tuple(name or method for name in answer.found_by) or (method,) * len(problems),
        seconds=seconds,
    )


def solve_all(X_WE: Any, joints: str = "full", q_seed: ArrayLike | None = None) -> Array:
    """Return every posture (n, 6) inside the joint ranges that holds a pose, by the closed form.

    Exact within 1e-9 m and 1e-9 rad, without duplicates, and with every whole turn of theta2,
    theta3 and theta6 that the ranges allow; empty where the pose cannot be held. In lexicographic
    order, or with q_seed the nearest first. Of the two continua of solutions (see
    `closed_form_mast`), members stand for the rest.

    Args:
        X_WE: tool pose, (4, 4) [m], or an object with GetAsMatrix4.
        joints: "full", or "arm" with the mast at q_seed[0]; its five joints hold only poses that
            meet one condition.
        q_seed: posture (6,).

    Raises:
        ValueError: as `solve`.
    """
    return closed_form.every_solution(make_problem(X_WE, "X_WE", joints, "pose", q_seed, 0))


def _method(name: str) -> Method:
    checks.choice("method", name, METHODS)
    return METHODS[name]


def _diagnose(problem: Problem) -> str:
    """Why a target was not met: geometry first, then a search of its own for a counterexample."""
    low, high = LOWER[0], UPPER[0]
    if problem.first_joint == 1:
        low = high = problem.start[0]
    # The beam stays horizontal: the rest must bridge what is left from its end.
    across = np.hypot(problem.p[0], problem.p[1]) - kinematics.D3
    up = problem.p[2] - np.clip(problem.p[2], low, high)
    if np.hypot(across, up) > kinematics.A4 + kinematics.D6 + POSITION_TOLERANCE:
        return OUT_OF_REACH
    if problem.position_first:
        return NOT_CONVERGED
    if robust.attainable(problem, limits=True):
        return NOT_CONVERGED
    if robust.attainable(problem, limits=False):
        return JOINT_LIMITS
    return NOT_ATTAINABLE

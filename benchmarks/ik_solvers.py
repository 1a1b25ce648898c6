"""What the inverse kinematics benchmark compares: the package's methods and the peers."""

from __future__ import annotations

import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from ik_targets import (
    DH,
    LOWER,
    MAST,
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    TIME_ALLOWED,
    UPPER,
    Array,
    Targets,
)
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.plant import MultibodyPlant
from pydrake.solvers import NloptSolver, SnoptSolver, SolverOptions

from scara_drake import ik, robot
from scara_drake.common.resources import resource
from scara_drake.ik import closed_form
from scara_drake.ik.kernels.follow import Iteration, follow_kernel
from scara_drake.ik.kernels.multistart import multistart_kernel
from scara_drake.ik.kernels.solutions import MOST, nearest_kernel
from scara_drake.ik.options import InverseJacobianOptions
from scara_drake.ik.result import ROTATION_LENGTH
from scara_drake.ik.robust import robust_kernel
from scara_drake.joints import HOME

# Drake's constraints are on squares, which its solvers keep to FEASIBLE [m²] only; so they aim at a
# part of the tolerances. The disturbance of the targets is less than that part.
FEASIBLE, MARGIN = 1e-7, 0.9
RTB = "roboticstoolbox"

# The answer to target k: (6,), or (points, 6) for a path; None or NaN where there is none.
Call = Callable[[int], Array | None]
# The posture for a pose (4, 4), from a seed (6,).
One = Callable[[Array, Array], Array | None]


@dataclass
class Solver:
    """One row of a table.

    Attributes:
        name: of the row.
        ours: of this package.
        call: solves target k.
        reference: heading of the column in which its median is 1, or empty.
    """

    name: str
    ours: bool
    call: Call
    reference: str = ""


def solvers(targets: Targets) -> tuple[list[Solver], list[str]]:
    """Return the solvers for these targets, and a line for each peer that is not installed."""
    found = path_methods(targets) if targets.paths else pose_methods(targets)
    missing = []
    mast = MAST if targets.arm else None
    peers: list[tuple[str, str, Callable[[], One]]] = [
        ("TRAC-IK, eps 1e-5", "pytracik", partial(trac_ik, mast, 1e-5)),
        ("TRAC-IK, eps 5e-3", "pytracik", partial(trac_ik, mast, 5e-3)),
        ("roboticstoolbox, chan", RTB, partial(toolbox, mast, "chan", 1e-6, 1.0)),
        ("roboticstoolbox, sugihara", RTB, partial(toolbox, mast, "sugihara", 1e-5, 1e-4)),
        ("Drake IK, SNOPT", "pydrake", partial(drake_ik, mast, SnoptSolver())),
        ("Drake IK, NLopt", "pydrake", partial(drake_ik, mast, NloptSolver())),
    ]
    for name, module, make in peers:
        if find_spec(module) is None:
            missing.append(
                f"{name}: not installed, left out (pip install 'scara-drake[benchmarks]')"
            )
        else:
            found.append(Solver(name, False, _call(targets, make())))
    return found, missing


def _call(targets: Targets, one: One) -> Call:
    """A peer's call: one pose from a random seed, or point by point from the answer before."""

    def pose(k: int) -> Array | None:
        return one(targets.X_WE[k], targets.seeds[k])

    def path(k: int) -> Array:
        answers = np.full((targets.X_WE.shape[1], 6), np.nan)
        before = targets.q[k]
        for point, X_WE in enumerate(targets.X_WE[k]):
            answer = one(X_WE, before)
            if answer is not None:
                answers[point] = before = answer
        return answers

    return path if targets.paths else pose


def pose_methods(targets: Targets) -> list[Solver]:
    """Our methods on single poses."""
    arm: dict[str, Any] = {"joints": "arm", "q_seed": [MAST, *HOME[1:]]}
    arguments = arm if targets.arm else {}

    def public(method: str, **options: Any) -> Call:
        def call(k: int) -> Array:
            return ik.solve(targets.X_WE[k], method, seed=k, **arguments, **options).q

        return call

    first_joint = 1 if targets.arm else 0
    p, R = _parts(targets)
    start, work = np.array([MAST, *HOME[1:]]), np.empty((MOST, 6))

    def one_kernel(k: int) -> Array:
        q = np.empty(6)
        robust_kernel(p[k], R[k], first_joint, start, k, q)
        return q

    def closed_form_kernel(k: int) -> Array:
        q = np.empty(6)
        nearest_kernel(p[k], R[k], first_joint, start, work, q)
        return q

    def draws_kernel(k: int) -> Array:
        q = start.copy()
        multistart_kernel(p[k], R[k], first_joint, k, q)
        return q

    return [
        Solver("robust: solve", True, public("robust"), "÷ solve"),
        Solver("robust: kernel", True, one_kernel, "÷ kernel"),
        Solver("closed_form: solve", True, public("closed_form")),
        Solver("closed_form: kernel", True, closed_form_kernel),
        Solver("least squares from draws: kernel", True, draws_kernel),
        Solver("dpsoij: solve", True, public("dpsoij")),
        Solver("dpso: solve", True, public("dpso")),
        Solver("dpso, no polish: solve", True, public("dpso", polish=False)),
    ]


def _parts(targets: Targets) -> tuple[Array, Array]:
    """Positions and rotations, contiguous."""
    X_WE = targets.X_WE
    return np.ascontiguousarray(X_WE[..., :3, 3]), np.ascontiguousarray(X_WE[..., :3, :3])


def path_methods(targets: Targets) -> list[Solver]:
    """Our methods on whole paths."""

    def public(method: str, **options: Any) -> Call:
        def call(k: int) -> Array:
            return ik.solve_path(
                targets.X_WE[k], method, joints="arm", q_seed=targets.q[k], seed=k, **options
            ).q

        return call

    def batch(k: int) -> Array:
        return closed_form.solve_batch(targets.X_WE[k], joints="arm", q_seed=targets.q[k])[0]

    return [
        Solver("robust: solve_path", True, public("robust"), "÷ solve"),
        Solver("dpsoij: solve_path", True, public("dpsoij")),
        Solver("inv. Jacobian: kernel", True, follow(targets), "÷ kernel"),
        Solver("inv. Jacobian: solve_path", True, public("inverse_jacobian")),
        Solver("closed_form: solve_path", True, public("closed_form")),
        Solver("closed_form: solve_batch", True, batch),
        Solver("dpsoij, paper: solve_path", True, public("dpsoij", variant="paper")),
    ]


def follow(targets: Targets) -> Call:
    """The compiled inverse Jacobian along a whole path."""
    options = InverseJacobianOptions()
    p, R = _parts(targets)
    n = p.shape[1]
    evaluations, steps = np.zeros(n, np.int64), np.zeros(n, np.int64)
    iteration = np.array(
        Iteration(1, False, ROTATION_LENGTH, options.max_step, options.max_iterations)
    )

    def call(k: int) -> Array:
        q = np.empty((n, 6))
        follow_kernel(p[k], R[k], iteration, targets.q[k], 0, q, evaluations, steps)
        return q

    return call


def trac_ik(mast: float | None, epsilon: float) -> One:
    """TRAC-IK, its two solvers side by side; stops at `epsilon` [m, rad] on each axis."""
    pytracik = import_module("pytracik")
    chain = pytracik.TRAC_IK(
        "base", "tool", urdf_chain(mast), TIME_ALLOWED, epsilon, pytracik.SolveType.Speed
    )
    moving = slice(0 if mast is None else 1, 6)

    def one(X_WE: Array, seed: Array) -> Array | None:
        quaternion = Quaternion(X_WE[:3, :3])
        answer = pytracik.ik(
            chain, seed[moving], *X_WE[:3, 3], quaternion.x(), quaternion.y(), quaternion.z(),
            quaternion.w(),
        )  # fmt: skip
        return None if answer[0] < 0 else _posture(mast, answer[1:])

    return one


def urdf_chain(mast: float | None) -> str:
    """The joints of models/scara6.urdf without its looks; with a height, the mast is fixed."""
    robot_element = ElementTree.fromstring(resource("models", "scara6.urdf").read_text())
    chain = ElementTree.Element("robot", name="scara6")
    for element in robot_element:
        if element.tag == "link":
            ElementTree.SubElement(chain, "link", name=element.attrib["name"])
        elif element.tag == "joint" and element.get("name") != "base_weld":
            chain.append(element)
            if mast is not None and element.get("name") == "d1":
                element.set("type", "fixed")
                origin = element.find("origin")
                assert origin is not None
                origin.set("xyz", f"0 0 {mast}")
    return ElementTree.tostring(chain, encoding="unicode")


def toolbox(mast: float | None, method: str, tolerance: float, gain: float) -> One:
    """Corke's toolbox: its Levenberg-Marquardt in C++, up to 100 restarts of 30 iterations."""
    peer = import_module(RTB)
    links = [peer.PrismaticDH(qlim=[LOWER[0], UPPER[0]])] if mast is None else []
    for (d, a, alpha), low, high in zip(DH[1:], LOWER[1:], UPPER[1:], strict=True):
        links.append(peer.RevoluteDH(d=d, a=a, alpha=alpha, qlim=[low, high]))
    sequence = peer.DHRobot(links).ets()
    moving = slice(0 if mast is None else 1, 6)

    def one(X_WE: Array, seed: Array) -> Array | None:
        X = X_WE
        if mast is not None:
            X = X_WE.copy()
            X[2, 3] -= mast
        answer = sequence.ik_LM(X, q0=seed[moving], tol=tolerance, method=method, k=gain)
        return _posture(mast, answer.q) if answer.success else None

    return one


def drake_ik(mast: float | None, solver: SnoptSolver | NloptSolver) -> One:
    """Drake's InverseKinematics with the same tolerances; random restarts while time is left."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    world, tool = plant.world_frame(), plant.GetFrameByName(robot.TOOL_FRAME)
    identity, origin = RotationMatrix(), np.zeros(3)
    random = np.random.default_rng(0)
    options = SolverOptions()
    options.SetOption(SnoptSolver.id(), "Major feasibility tolerance", FEASIBLE)
    options.SetOption(NloptSolver.id(), NloptSolver.ConstraintToleranceName(), FEASIBLE)

    def one(X_WE: Array, seed: Array) -> Array | None:
        deadline = time.perf_counter() + TIME_ALLOWED
        problem = InverseKinematics(plant, with_joint_limits=True)
        program, q = problem.prog(), problem.q()
        problem.AddPointToPointDistanceConstraint(
            world, X_WE[:3, 3], tool, origin, 0.0, MARGIN * POSITION_TOLERANCE
        )
        problem.AddOrientationConstraint(
            world, RotationMatrix(X_WE[:3, :3]), tool, identity, MARGIN * ROTATION_TOLERANCE
        )
        if mast is not None:
            program.AddBoundingBoxConstraint(mast, mast, q[0])
        guess = seed
        while True:
            result = solver.Solve(program, guess, options)
            if result.is_success():
                answer: Array = result.GetSolution(q)
                return answer if mast is None else _posture(mast, answer[1:])
            if time.perf_counter() > deadline:
                return None
            guess = random.uniform(LOWER, UPPER)

    return one


def _posture(mast: float | None, moving: Array) -> Array:
    return np.asarray(moving) if mast is None else np.array([mast, *moving])

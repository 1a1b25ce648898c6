"""The command `scara-drake ik`: joint values for a pose, or for the poses of a CSV file."""

from __future__ import annotations

import argparse
import ast
import json
import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from scara_drake import ik, kinematics
from scara_drake.cli.joint_steps import largest_step
from scara_drake.cli.parser import IK_METHOD, POSE_COLUMNS
from scara_drake.cli.pose_files import fields_of, read_csv, write_csv
from scara_drake.common import checks
from scara_drake.ik.target import FARTHEST
from scara_drake.joints import HOME, JOINT_NAMES

Array = NDArray[np.float64]

METRES: Final = {"m": 1.0, "mm": 1e-3}
RADIANS: Final = {"rad": 1.0, "deg": math.pi / 180.0}
ROTATION: Final = "Rx(roll) Ry(pitch) Rz(yaw)"
SAME: Final = 1e-6  # postures that differ less, but for whole turns, are one [m, rad]


def run(options: argparse.Namespace, console: Console) -> None:
    """Solve the poses of the command line and print or write the answers.

    Raises:
        ValueError: bad input; one line that says what is allowed.
        RuntimeError: a pose is not solved; the answers are printed all the same.
    """
    _check(options)
    poses, lines = _read_poses(options)
    X_WEs = _matrices(poses)
    far = _too_far(options, poses, lines)
    near = np.array([k not in far for k in range(len(poses))])
    found = iter(_solve(options, X_WEs[near]))
    answers = [next(found) if good else [] for good in near]
    step = None
    if options.path:
        step = largest_step(X_WEs, np.array([answer.q for (answer,) in answers]))
    method = "closed_form" if options.all else options.method or IK_METHOD
    if options.output:
        write_csv(options.output, poses, answers)
    if options.json:
        document = {
            "method": method,
            "joints": options.joints,
            "task": options.task,
            "rotation": ROTATION,
            **({"largest_step": step._asdict()} if step else {}),
            "poses": [
                {
                    "position": pose[:3].tolist(),
                    "rpy": pose[3:].tolist(),
                    "answers": [fields_of(answer) for answer in found],
                }
                for pose, found in zip(poses, answers, strict=True)
            ],
        }
        console.out(json.dumps(document, indent=2), highlight=False)
    else:
        console.print(_table(f"{method}, {options.joints}, {options.task}", answers, options.all))
        console.print(f"Orientation: {ROTATION}.")
        if step:
            console.print(f"Largest step: {step}.")
    unsolved = sum(not any(answer.success for answer in found) for found in answers)
    if unsolved:
        why = "".join(f"; {message}" for message in list(far.values())[:5])
        raise RuntimeError(f"{unsolved} of {len(poses)} poses not solved{why}")
    if step and step.flip:
        raise RuntimeError(f"no continuous path: {step}")


def _check(options: argparse.Namespace) -> None:
    checks.choice("--unit", options.unit, METRES)
    checks.choice("--angle", options.angle, RADIANS)
    if options.position and not options.rpy:
        raise ValueError("--rpy: missing, allowed ROLL PITCH YAW with --position")
    if options.csv and options.rpy:
        raise ValueError("--rpy: given, allowed with --position; --csv has its own columns")
    if options.path and not options.csv:
        raise ValueError("--path: given, allowed with --csv")
    if options.mast is not None and options.joints != "arm":
        raise ValueError(f"--mast: {options.mast:g}, allowed with --joints arm")
    if options.joints == "arm" and options.mast is None and options.q_seed is None:
        raise ValueError("--mast: missing, allowed HEIGHT [m] with --joints arm")
    if options.all and (options.method or options.option or options.task != "pose"):
        raise ValueError("--all: given, allowed without --method, --task and --option")
    if options.output and (options.output.suffix != ".csv" or options.output.is_dir()):
        raise ValueError(f"--output: '{options.output}', allowed a file that ends in .csv")


def _read_poses(options: argparse.Namespace) -> tuple[Array, list[int]]:
    """Return positions and angles (n, 6) [m, rad], and the lines of the file that they are on."""
    radians, lines = RADIANS[options.angle], [0]
    if options.csv:
        poses, lines, quaternions = read_csv(options.csv)
        if quaternions:
            radians = 1.0
    else:
        checks.vector("--position", options.position, 3)
        checks.vector("--rpy", options.rpy, 3)
        poses = np.array([[*options.position, *options.rpy]])
    return poses * np.repeat([METRES[options.unit], radians], 3), lines


def _matrices(poses: Array) -> Array:
    X_WEs = np.tile(np.eye(4), (len(poses), 1, 1))
    X_WEs[:, :3, :3] = kinematics.rotation_from_intrinsic_xyz(poses[:, 3:])
    X_WEs[:, :3, 3] = poses[:, :3]
    return X_WEs


def _too_far(options: argparse.Namespace, poses: Array, lines: list[int]) -> dict[int, str]:
    """Return what is wrong with the poses of a file that no robot could reach, by their index.

    Raises:
        ValueError: it is the only pose, or one of a path.
    """
    found = {}
    for k, pose in enumerate(poses):
        axis = int(np.argmax(np.abs(pose[:3])))
        if abs(pose[axis]) > FARTHEST:
            where = f"line {lines[k]}, column {POSE_COLUMNS[axis]}" if lines[k] else "--position"
            found[k] = f"{where}: {pose[axis]:g} m, allowed up to {FARTHEST:g} m"
            if options.path or not options.csv:
                raise ValueError(found[k])
    return found


def _solve(options: argparse.Namespace, X_WEs: Array) -> list[list[ik.IkResult]]:
    """Return the answers to each pose."""
    q_seed = options.q_seed
    if options.mast is not None:
        q_seed = [options.mast, *(q_seed or HOME)[1:]]
    where: dict[str, Any] = {"joints": options.joints, "q_seed": q_seed}
    if options.all:
        return [_every_solution(X_WE, **where) for X_WE in X_WEs]
    where |= {"task": options.task, "seed": options.seed, **_method_options(options.option)}
    method = options.method or IK_METHOD
    if options.path:
        return [[answer] for answer in _points(ik.solve_path(X_WEs, method, **where))]
    return [[ik.solve(X_WE, method, **where)] for X_WE in X_WEs]


def _method_options(settings: Sequence[str]) -> dict[str, object]:
    """Read NAME=VALUE with values as Python writes them; anything else is text."""
    values: dict[str, object] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not (name.isidentifier() and equals):
            raise ValueError(f"--option: '{setting}', allowed NAME=VALUE")
        if name in ("X_WE", "X_WEs", "method", "joints", "task", "q_seed", "seed"):
            raise ValueError(f"--option: '{name}' has an option of its own, --{name}")
        try:
            values[name] = ast.literal_eval(text)
        except (ValueError, SyntaxError):
            values[name] = text
    return values


def _every_solution(X_WE: Array, **where: Any) -> list[ik.IkResult]:
    q = ik.solve_all(X_WE, **where)
    position, rotation = kinematics.pose_error(X_WE, kinematics.forward_kinematics(q))
    success, none = np.ones(len(q), dtype=bool), np.zeros(len(q), dtype=np.int64)
    reason = ("converged",) * len(q)
    return _points(ik.IkPath(q, position, rotation, success, none, none, "closed_form", reason))


def _points(path: ik.IkPath) -> list[ik.IkResult]:
    return [
        ik.IkResult(
            q=path.q[k],
            position_error=float(path.position_error[k]),
            rotation_error=float(path.rotation_error[k]),
            success=bool(path.success[k]),
            evaluations=int(path.evaluations[k]),
            iterations=int(path.iterations[k]),
            method=path.method,
            reason=path.reason[k],
        )
        for k in range(len(path))
    ]


def _table(title: str, answers: list[list[ik.IkResult]], grouped: bool) -> Table:
    """Return a table of the answers; `grouped`, turns of one posture stand together."""
    solved = sum(any(answer.success for answer in found) for found in answers)
    title = f"{title}: {solved} of {len(answers)} poses solved"
    if grouped:
        answers = [sorted(found, key=_posture(found).__getitem__) for found in answers]
        counts = [len(set(_posture(found).values())) for found in answers]
        title += f"; {sum(map(len, answers))} solutions, which are {sum(counts)} postures and "
        title += "their whole turns of theta2, theta3 and theta6"
    table = Table(
        title=title,
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    headings = ["#", "d1\n[m]", *(f"{name}\n[rad]\n[deg]" for name in JOINT_NAMES[1:])]
    for heading in [*headings, "error\n[mm]\n[mrad]"]:
        table.add_column(Text(heading), justify="right", no_wrap=True)
    table.add_column("result\n\nevaluations")
    for index, found in enumerate(answers, start=1):
        if not found:
            table.add_row(str(index), *[""] * 7, "[red]no solution")
        postures = _posture(found) if grouped else {}
        for answer in found:
            table.add_row(
                f"{index}{_letter(postures[answer])}" if grouped else str(index),
                f"{answer.q[0]:.4f}",
                *(f"{angle:.4f}\n{math.degrees(angle):.2f}" for angle in answer.q[1:]),
                f"{1e3 * answer.position_error:.3f}\n{1e3 * answer.rotation_error:.3f}",
                f"[{'green' if answer.success else 'red'}]{answer.reason}[/]\n{answer.evaluations}",
            )
    return table


def _posture(found: Sequence[ik.IkResult]) -> dict[ik.IkResult, int]:
    """Number the postures of a pose, alike but for whole turns, in the order of their answers."""
    kinds: list[Array] = []
    numbers = {}
    for answer in found:
        kind = np.append(np.exp(1j * answer.q[1:]), answer.q[0])
        same = [k for k, other in enumerate(kinds) if np.abs(kind - other).max() < SAME]
        numbers[answer] = same[0] if same else len(kinds)
        if not same:
            kinds.append(kind)
    return numbers


def _letter(number: int) -> str:
    return chr(ord("a") + number)

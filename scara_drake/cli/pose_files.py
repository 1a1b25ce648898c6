"""The CSV files of `scara-drake ik`: poses in, answers out."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scara_drake import ik
from scara_drake.cli.parser import POSE_COLUMNS
from scara_drake.common.files import whole_file
from scara_drake.joints import JOINT_NAMES
from scara_drake.kinematics import intrinsic_xyz_from_rotation

Array = NDArray[np.float64]

QUATERNION = ("qw", "qx", "qy", "qz")
UNIT = 1e-3  # how far the length of a quaternion may be from one: its numbers may be rounded


def read_csv(path: Path) -> tuple[Array, list[int], bool]:
    """Read the columns x, y, z, roll, pitch, yaw of a CSV file; others are passed over.

    In place of the angles it may have the columns qw, qx, qy, qz of a quaternion.

    Returns:
        The numbers (n, 6) as written, n >= 1, or with quaternions turned into angles [rad]; the
        line of each; and whether they were quaternions.

    Raises:
        ValueError: no such file, a missing column, no rows, a value that is not a finite number, or
            a quaternion that is not of unit length within 1e-3; names the line and the column.
    """
    if not path.is_file():
        raise ValueError(f"--csv: '{path}', allowed a file that exists")
    rows, lines = [], []
    columns: tuple[str, ...] = POSE_COLUMNS
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            header = [name.strip() for name in reader.fieldnames or []]
            reader.fieldnames = header
            if set(QUATERNION) <= set(header) and not set(POSE_COLUMNS[3:]) & set(header):
                columns = (*POSE_COLUMNS[:3], *QUATERNION)
            missing = [name for name in columns if name not in header]
            if missing:
                raise ValueError(
                    f"{path}: no column {', '.join(missing)}, allowed a first line with "
                    f"{','.join(POSE_COLUMNS)}, or {','.join(QUATERNION)} for the angles"
                )
            for row in reader:
                lines.append(reader.line_num)
                rows.append([_number(path, lines[-1], name, row[name]) for name in columns])
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: {error}, allowed CSV in UTF-8") from None
    if not rows:
        raise ValueError(f"{path}: 0 poses, allowed 1 or more")
    poses, quaternions = np.array(rows), columns != POSE_COLUMNS
    if quaternions:
        poses = np.hstack([poses[:, :3], _angles(path, lines, poses[:, 3:])])
    return poses, lines, quaternions


def _angles(path: Path, lines: list[int], quaternions: Array) -> Array:
    """Return the angles (n, 3) [rad] of quaternions (n, 4), w x y z."""
    lengths = np.linalg.norm(quaternions, axis=1)
    for line, length in zip(lines, lengths, strict=True):
        if not abs(length - 1.0) <= UNIT:
            raise ValueError(
                f"{path}: line {line}, columns {','.join(QUATERNION)}: length {length:.6g}, "
                f"allowed 1 within {UNIT:g}"
            )
    R = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    angles: Array = intrinsic_xyz_from_rotation(R)
    return angles


def _number(path: Path, line: int, column: str, text: str | None) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(
            f"{path}: line {line}, column {column}: '{text or ''}', allowed a finite number"
        )
    return value


def fields_of(answer: ik.IkResult) -> dict[str, Any]:
    """Return what is written of an answer, by name, as plain Python values."""
    return {
        "q": answer.q.tolist(),
        "position_error": answer.position_error,
        "rotation_error": answer.rotation_error,
        "success": answer.success,
        "reason": answer.reason,
        "evaluations": answer.evaluations,
        "iterations": answer.iterations,
    }


def write_csv(path: Path, poses: Array, answers: list[list[ik.IkResult]]) -> None:
    """Write a row an answer, whole or not at all.

    The columns of the pose come first, so the file can be read again.

    Raises:
        OSError: the folder cannot be written.
    """
    results = ("position_error", "rotation_error", "success", "reason", "evaluations")
    with whole_file(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([*POSE_COLUMNS, *JOINT_NAMES, *results])
        for pose, found in zip(poses.tolist(), answers, strict=True):
            for answer in found:
                fields = fields_of(answer)
                writer.writerow([*pose, *fields["q"], *(fields[name] for name in results)])

"""The CSV files of `scara-drake ik`: poses in, answers out."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scara_drake import ik
from scara_drake.cli.parser import POSE_COLUMNS
from scara_drake.common.files import whole_file
from scara_drake.joints import JOINT_NAMES

Array = NDArray[np.float64]


def read_csv(path: Path) -> Array:
    """Read the columns x, y, z, roll, pitch, yaw of a CSV file; others are passed over.

    Returns:
        The numbers (n, 6) as written, n >= 1.

    Raises:
        ValueError: no such file, a missing column, no rows, or a value that is not a finite
            number; names the line and the column.
    """
    if not path.is_file():
        raise ValueError(f"--csv: '{path}', allowed a file that exists")
    rows = []
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            header = [name.strip() for name in reader.fieldnames or []]
            reader.fieldnames = header
            missing = [name for name in POSE_COLUMNS if name not in header]
            if missing:
                raise ValueError(
                    f"{path}: no column {', '.join(missing)}, allowed a first line with "
                    f"{','.join(POSE_COLUMNS)}"
                )
            for row in reader:
                rows.append(
                    [_number(path, reader.line_num, name, row[name]) for name in POSE_COLUMNS]
                )
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: {error}, allowed CSV in UTF-8") from None
    if not rows:
        raise ValueError(f"{path}: 0 poses, allowed 1 or more")
    return np.array(rows)


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

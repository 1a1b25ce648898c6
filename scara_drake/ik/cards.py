"""What answers of the inverse kinematics show of themselves in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from scara_drake.common.html import Markup, card, chip, folded, line, table
from scara_drake.display import look
from scara_drake.joints import JOINT_NAMES, JOINT_UNITS

if TYPE_CHECKING:
    from scara_drake.ik.result import IkPath, IkResult

_GOOD, _, _BAD, _ = look.VERDICTS
MOST_ROWS: Final = 60  # of a path; of a longer one some are left out


def of_result(result: IkResult) -> Markup:
    """Return the card of one answer: the joints, the errors left, and what they cost."""
    from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE

    head = [f"{name} [{unit}]" for name, unit in zip(JOINT_NAMES, JOINT_UNITS, strict=True)]
    left = [
        ("position", f"{1e3 * result.position_error:.3g} mm", f"{1e3 * POSITION_TOLERANCE:g} mm"),
        ("rotation", f"{result.rotation_error:.3g} rad", f"{ROTATION_TOLERANCE:g} rad"),
    ]
    by = "" if result.found_by in ("", result.method) else f", found by {result.found_by}"
    return card(
        f"IkResult: {result.method}{by}",
        line(_state(result.reason, result.success)),
        table([[f"{value:.4f}" for value in result.q]], head),
        table(left, ["error left", "", "tolerance"]),
        line(
            f"{_count(result.evaluations)} evaluations of the forward kinematics, "
            f"{_count(result.iterations)} iterations, {result.seconds:.2g} s"
        ),
    )


def of_path(path: IkPath) -> Markup:
    """Return the card of a path: how many points are solved, how well, and the joints, folded."""
    solved, count = int(np.sum(path.success)), len(path)
    reasons = ", ".join(sorted({word for word in path.reason if word != "converged"}))
    finders = [f"{path.found_by.count(by)} by {by}" for by in dict.fromkeys(path.found_by)]
    head = ["point", *JOINT_NAMES, "position [mm]", "rotation [rad]", "reason"]
    shown = np.unique(np.linspace(0, count - 1, min(count, MOST_ROWS)).astype(int))
    rows = [
        [
            index,
            *(f"{value:.4f}" for value in path.q[index]),
            f"{1e3 * path.position_error[index]:.3g}",
            f"{path.rotation_error[index]:.3g}",
            path.reason[index],
        ]
        for index in shown
    ]
    jump = float(np.abs(np.diff(path.q[:, 1:], axis=0)).max()) if count > 1 else 0.0
    facts = [
        ("largest position error", f"{1e3 * np.max(path.position_error):.3g} mm"),
        ("largest rotation error", f"{np.max(path.rotation_error):.3g} rad"),
        ("largest step of an angle", f"{jump:.3g} rad"),
        ("evaluations", _count(int(np.sum(path.evaluations)))),
        ("found", ", ".join(finders) or path.method),
    ]
    some = f", {len(shown)} of {count} points" if len(shown) < count else ""
    return card(
        f"IkPath: {path.method}, {count} points",
        line(_state(f"{solved} of {count} solved", solved == count), f" {reasons}"),
        table(facts),
        folded(f"joints [m, rad]{some}", table(rows, head)),
    )


def _state(words: str, good: bool) -> Markup:
    return chip(words, _GOOD if good else _BAD)


def _count(number: int) -> str:
    return f"{number:,}".replace(",", " ")

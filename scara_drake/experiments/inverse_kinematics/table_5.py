"""Table 5: which of the four desired postures the arm, and the arm with its mast, can reach."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from scara_drake import ik, kinematics
from scara_drake.experiments.claim import Claim, Criterion, Experiment, at_least
from scara_drake.experiments.inverse_kinematics import orientation_orders
from scara_drake.experiments.inverse_kinematics.free_arm import best_of_free_arm
from scara_drake.experiments.inverse_kinematics.postures import (
    ANGLE,
    E_O,
    E_O_MEANINGS,
    MOVES,
    NUMBERS,
    POSITIONS,
    REFERENCE_HEIGHT,
    WHO,
    angle_difference,
    home,
    inside,
    success,
    targets,
)
from scara_drake.experiments.quantity import Quantity, quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.ik.result import ROTATION_TOLERANCE
from scara_drake.recordings.labels import labelled

JOINTS = ("arm", "full")
PAPER_SOLVED = quantity(4, "of 4 postures")


def run(
    seed: int = 0, starts: int = 64, order_starts: int = 24, orders: Collection[str] | None = None
) -> Experiment:
    """Look for the best posture for each target, within the joint ranges and, arm alone, without.

    Args:
        seed: of the random starts.
        starts: of the search without joint ranges.
        order_starts: of that search for each order of roll, pitch and yaw.
        orders: those that are tried, ours among them; all if None.
    """
    X_WE, shape = targets(), (len(JOINTS), len(NUMBERS))
    position, rotation, exact = np.empty(shape), np.empty(shape), np.empty(shape)
    difference = np.empty(shape)
    reason = np.empty(shape, dtype="<U32")
    for i, joints in enumerate(JOINTS):
        for k, X in enumerate(X_WE):
            best = ik.solve(X, "dpso", joints, q_seed=home(), seed=seed)
            position[i, k], rotation[i, k] = best.position_error, best.rotation_error
            difference[i, k] = angle_difference(X, kinematics.forward_kinematics(best.q))
            reason[i, k] = best.reason
            point = ik.solve(X, "dpso", joints, task="position", q_seed=home(), seed=seed)
            exact[i, k] = point.rotation_error if point.success else np.nan
    free = np.array([best_of_free_arm(X, seed, starts) for X in X_WE])
    short = np.array([_short_of(p) for p in POSITIONS])
    dims = ("joints", "posture")
    data = xr.Dataset(
        {
            "position_error": labelled(dims, position, "m", "of the best posture found"),
            "rotation_error": labelled(dims, rotation, "rad", "of the best posture found"),
            "angle_difference": labelled(
                dims, difference, "rad", "the same as the difference of roll, pitch and yaw"
            ),
            "rotation_error_at_position": labelled(
                dims, exact, "rad", "best with the position met exactly; NaN if out of reach"
            ),
            "reason": labelled(dims, reason, "1", "why no posture meets the target"),
            "distance": labelled(
                ("posture",), np.linalg.norm(POSITIONS, axis=1), "m", "|P_d| from the arm's base"
            ),
            "out_of_reach": labelled(
                ("posture",), short, "m", "what the arm lacks to touch P_d, its beam horizontal"
            ),
            "free_position_error": labelled(
                ("posture",), free[:, 0], "m", "arm alone, without joint ranges"
            ),
            "free_rotation_error": labelled(
                ("posture",), free[:, 1], "rad", "arm alone, without joint ranges"
            ),
            "free_excess": labelled(
                ("posture",), free[:, 2], "rad", "how far joint 4 or 5 is beyond its range there"
            ),
        },
        coords={"joints": list(JOINTS), "posture": list(NUMBERS)},
        attrs={"seed": seed, "mast_height": REFERENCE_HEIGHT},
    )
    tried = orientation_orders.rotations(orders)
    fitted = orientation_orders.fit(tried, seed, order_starts)
    data = data.merge(fitted, combine_attrs="override")
    return Experiment("Table 5", data, claims(data), questions(data))


def claims(data: xr.Dataset) -> list[Claim]:
    """Judge that the postures can be reached; see `run` for the data."""
    met = success(data)
    return [_solved(data, met.sel(joints=joints), joints, who) for joints, who in WHO.items()]


def questions(data: xr.Dataset) -> tuple[OpenQuestion, ...]:
    """Show what the postures become by other readings of Table 5; see `run` for the data."""
    return _who(data), _order(data), _measure(data)


def _statement(who: str) -> str:
    return f"The four desired postures can be solved (Table 8), by {who}"


def _count(met: xr.DataArray) -> Quantity:
    return quantity(int(met.sum()), PAPER_SOLVED.unit)


def _criterion(count: Quantity) -> Criterion:
    return Criterion(
        "all four within 5 mm and 0.0175 rad inside Table 2 (in kind: three)",
        at_least(count),
        at_least(count, 0.75),
    )


def _solved(data: xr.Dataset, met: xr.DataArray, joints: str, who: str) -> Claim:
    count = _count(met)
    return Claim(
        _statement(who), PAPER_SOLVED, count, _criterion(count), _evidence(data, joints, met)
    )


def _who(data: xr.Dataset) -> OpenQuestion:
    met = success(data)
    readings = []
    for joints, who in WHO.items():
        rows, count = data.sel(joints=joints), _count(met.sel(joints=joints))
        errors = {
            "position error": quantity(_each(1e3 * rows.position_error), "mm"),
            "orientation error": quantity(_each(rows.rotation_error), "rad"),
            "solved": count,
        }
        verdict = _criterion(count).verdict(PAPER_SOLVED)
        readings.append(Reading(who, MOVES[joints], errors, verdict, joints == "full"))
    return OpenQuestion(
        "Does the mast take part in Table 5?", _statement(WHO["full"]), tuple(readings)
    )


def _order(data: xr.Dataset) -> OpenQuestion:
    met = inside(data.order_position_error, data.order_rotation_error)
    free = inside(data.order_free_position_error, data.order_free_rotation_error)
    readings = []
    for name in (str(order) for order in data.order.values):
        count = _count(met.sel(order=name))
        alone = data.order_free_rotation_error.sel(order=name)
        fit = {
            "with the mast": count,
            "arm alone, without joint ranges": _count(free.sel(order=name)),
            "orientation error of the arm alone": quantity(_each(alone), "rad"),
        }
        sequence, frame = name.split(", ")
        meaning = f"about {', '.join(sequence)}, one after the other, of {frame}"
        verdict = _criterion(count).verdict(PAPER_SOLVED)
        chosen = name == orientation_orders.OURS
        readings.append(Reading(name, meaning, fit, verdict, chosen))
    return OpenQuestion(
        "In which order do roll, pitch and yaw of Table 5 turn?",
        _statement(WHO["full"]),
        tuple(readings),
    )


def _measure(data: xr.Dataset) -> OpenQuestion:
    rows = data.sel(joints="full")
    readings = []
    for name, error in E_O.items():
        count = _count(inside(rows.position_error, rows[error]))
        found = {"orientation error": quantity(_each(rows[error]), "rad"), "solved": count}
        verdict = _criterion(count).verdict(PAPER_SOLVED)
        readings.append(Reading(name, E_O_MEANINGS[name], found, verdict, name == ANGLE))
    return OpenQuestion("What is E_o?", _statement(WHO["full"]), tuple(readings))


def _each(errors: xr.DataArray) -> dict[str, float]:
    return {f"posture {n}": round(float(errors.sel(posture=n)), 4) for n in NUMBERS}


def _evidence(data: xr.Dataset, joints: str, met: xr.DataArray) -> str:
    parts = []
    for number in data.posture.values[~met.values]:
        row = data.sel(posture=number, joints=joints)
        if joints == "arm" and row.out_of_reach > 0.0:
            parts.append(
                f"posture {number} lies {1e3 * float(row.distance):.0f} mm from the arm's base, "
                f"beyond its length of {1e3 * kinematics.REACH:.0f} mm, and "
                f"{1e3 * float(row.out_of_reach):.0f} mm beyond its reach at that height"
            )
        elif joints == "arm" and row.free_rotation_error <= ROTATION_TOLERANCE:
            parts.append(
                f"posture {number} is met to {float(row.free_rotation_error):.3f} rad only with "
                f"joint 4 or 5 {float(row.free_excess):.2f} rad beyond its range of Table 2, else "
                f"to {float(row.rotation_error):.2f} rad"
            )
        else:
            parts.append(
                f"posture {number} is met to {1e3 * float(row.position_error):.1f} mm and "
                f"{float(row.rotation_error):.3f} rad at best"
            )
    if joints == "full":
        parts.append(
            f"the mast height of Table 5 is not given: {REFERENCE_HEIGHT:g} m here, which leaves "
            "the mast the travel it needs"
        )
    text = "; ".join(parts)
    return text[0].upper() + text[1:] + "." if parts else "All lie inside the joint ranges."


def _short_of(p: tuple[float, float, float]) -> float:
    # The beam stays horizontal; forearm and tool must bridge what is left from its end.
    left = np.hypot(np.hypot(p[0], p[1]) - kinematics.D3, p[2])
    return max(0.0, float(left) - kinematics.A4 - kinematics.D6)

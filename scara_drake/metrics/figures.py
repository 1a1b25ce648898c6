"""The figures of a run that are told beside those of others, each by name, one number each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

import xarray as xr

from scara_drake.joints import JOINT_NAMES, JOINT_UNITS
from scara_drake.metrics.bilateral import contact_share, energy_margin
from scara_drake.metrics.command import STATUSES, status_shares
from scara_drake.metrics.curves import (
    AGES,
    COMMAND_ERRORS,
    CONTACT_FORCE,
    EFFORTS,
    FELT_FORCES,
    JOINT_ERRORS,
    PENETRATION,
    TOOL_ERROR,
    Curve,
)
from scara_drake.metrics.limits import saturated_share
from scara_drake.metrics.links import LINKS, traffic
from scara_drake.metrics.policy import completion_time
from scara_drake.metrics.tracking import energy, peak, rmse, total_variation

_BOTH: Final = ("RMS", "largest")
_REDUCED: Final[dict[str, Callable[[xr.DataArray], xr.DataArray]]] = {
    "RMS": rmse,
    "largest": peak,
    "mean": lambda curve: curve.mean("time"),
}
_CURVES: Final[tuple[tuple[Curve, tuple[str, ...]], ...]] = (
    (TOOL_ERROR, _BOTH),
    *((curve, _BOTH) for curve in COMMAND_ERRORS),
    *((curve, _BOTH) for curve in JOINT_ERRORS),
    (CONTACT_FORCE, ("largest",)),
    (PENETRATION, ("largest",)),
    *((curve, _BOTH) for curve in FELT_FORCES),
    *((curve, ("mean", "largest")) for curve in AGES),
    *((curve, ("RMS",)) for curve in EFFORTS),
)


class Figure(NamedTuple):
    """One number of a run.

    Attributes:
        name: of the figure.
        unit: of the value.
        value: the number.
    """

    name: str
    unit: str
    value: float


def figures(recording: xr.Dataset) -> dict[str, Figure]:
    """Return the figures of a recording by name; those that it has the variables for."""
    found = [*_of_curves(recording)]
    for part in (_drives, _contact, _command, _links, _coupling, _policy):
        found += part(recording)
    return {figure.name: figure for figure in found}


def _of_curves(recording: xr.Dataset) -> Iterator[Figure]:
    for curve, reductions in _CURVES:
        shown = curve.shown(recording)
        if shown is not None:
            for name in reductions:
                yield Figure(f"{curve.name}, {name}", curve.unit, float(_REDUCED[name](shown)))


def _drives(recording: xr.Dataset) -> Iterator[Figure]:
    if "tau_applied" not in recording or list(recording.joint.values) != list(JOINT_NAMES):
        return
    efforts = recording.tau_applied
    variation = total_variation(efforts)
    for joint, unit in zip(JOINT_NAMES, JOINT_UNITS, strict=True):
        rate = "N/s" if unit == "m" else "N m/s"
        yield Figure(f"{joint} effort, variation", rate, float(variation.sel(joint=joint)))
    most = 100.0 * float(saturated_share(efforts).max())
    yield Figure("at an effort limit, most of a joint", "%", most)
    if "v_measured" in recording:
        spent = energy(efforts, recording.v_measured).sum("joint", skipna=False)
        yield Figure("energy of the drives", "J", float(spent))


def _contact(recording: xr.Dataset) -> Iterator[Figure]:
    if CONTACT_FORCE.shown(recording) is not None:
        yield Figure("in contact", "%", 100.0 * contact_share(recording))


def _command(recording: xr.Dataset) -> Iterator[Figure]:
    shares = status_shares(recording) if "status" in recording else {}
    for name in STATUSES if shares else ():
        yield Figure(f"received command {name}", "%", 100.0 * shares[name])


def _links(recording: xr.Dataset) -> Iterator[Figure]:
    for link in LINKS:
        found = traffic(recording, link)
        if found is not None:
            lost = 100.0 * found.lost / max(found.sent, 1)
            yield Figure(f"packets {link}, lost", "%", lost)
            yield Figure(f"longest gap {link}", "ms", 1e3 * found.longest_gap)


def _coupling(recording: xr.Dataset) -> Iterator[Figure]:
    if "energy_master_in" in recording and "energy_slave_out" in recording:
        yield Figure("energy left in the coupling, least", "J", energy_margin(recording))


def _policy(recording: xr.Dataset) -> Iterator[Figure]:
    if "policy_done_at" in recording:
        yield Figure("the operator's work is done after", "s", completion_time(recording))
        yield Figure("stages done by the operator", "1", float(recording.policy_leg[-1]))

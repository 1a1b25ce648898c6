"""The figures of a run that are told beside those of others, each by name, one number each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Final, NamedTuple

import xarray as xr

from scara_drake.joints import JOINT_NAMES, JOINT_UNITS
from scara_drake.metrics.bilateral import contact_share, energy_margin, vector_size
from scara_drake.metrics.command import STATUSES, status_shares
from scara_drake.metrics.curves import (
    AGES,
    COMMAND_ERRORS,
    CONTACT_FORCE,
    EFFORTS,
    FELT_FORCES,
    FORCE_JNDS,
    JOINT_ERRORS,
    PENETRATION,
    TOOL_ERROR,
    Curve,
)
from scara_drake.metrics.limits import saturated_share
from scara_drake.metrics.links import LINKS, traffic
from scara_drake.metrics.manual import (
    displayed_stiffness,
    effort_transparency,
    free_resistance,
)
from scara_drake.metrics.noticed import noticed
from scara_drake.metrics.offsets import delay_derivative, force_offsets, tool_offsets
from scara_drake.metrics.policy import completion_time
from scara_drake.metrics.scales import Scales, scales_of
from scara_drake.metrics.squared_force import squared_force
from scara_drake.metrics.tracking import energy, peak, percentile95, rmse, total_variation

EXPLAINED: Final = 0.5  # least share of the force at the master that a stiffness has to explain

_BOTH: Final = ("RMS", "largest")
_REDUCED: Final[dict[str, Callable[[xr.DataArray], xr.DataArray]]] = {
    "RMS": rmse,
    "largest": peak,
    "mean": lambda curve: curve.mean("time"),
    "95 % within": percentile95,
}
_CURVES: Final[tuple[tuple[Curve, tuple[str, ...]], ...]] = (
    (TOOL_ERROR, _BOTH),
    *((curve, _BOTH) for curve in COMMAND_ERRORS),
    *((curve, _BOTH) for curve in JOINT_ERRORS),
    (CONTACT_FORCE, ("largest",)),
    (PENETRATION, ("largest",)),
    *((curve, _BOTH) for curve in FELT_FORCES),
    (FORCE_JNDS, ("mean", "95 % within")),
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
    for part in (
        _drives,
        _contact,
        _command,
        _links,
        _coupling,
        _offsets,
        _by_hand,
        _policy,
    ):
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
        yield Figure("squared force on the tool", "N^2 s", squared_force(recording))


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
            if f"packets_late_{link}" in recording:
                late = 100.0 * found.late / max(found.sent, 1)
                yield Figure(f"packets {link}, late", "%", late)
            yield Figure(f"longest gap {link}", "ms", 1e3 * found.longest_gap)
            yield Figure(f"packets {link}", "1/s", found.packets_per_second)
            if not math.isnan(found.numbers):
                yield Figure(f"load {link}", "kbit/s", found.kilobits_per_second())


def _coupling(recording: xr.Dataset) -> Iterator[Figure]:
    if "energy_master_in" in recording and "energy_slave_out" in recording:
        yield Figure("energy left in the coupling, least", "J", energy_margin(recording))


def _bilateral(recording: xr.Dataset) -> Scales | None:
    """Return the scales of a coupling whose recording has what both ends know; None if not."""
    needed = ("x_master", "v_master", "f_master", "p_WE_measured", "f_env_on_tool_W", "delay_up",
              "delay_down")  # fmt: skip
    if not all(name in recording for name in needed):
        return None
    with suppress(ValueError):  # not the scenario of a run
        return scales_of(recording)
    return None


def _offsets(recording: xr.Dataset) -> Iterator[Figure]:
    scales = _bilateral(recording)
    if scales is None or recording.sizes["time"] < 2:
        return
    parts = [("tool", "mm", 1e3, tool_offsets(recording, scales.position))]
    if CONTACT_FORCE.shown(recording) is not None:
        parts.append(("force", "N", 1.0, force_offsets(recording, scales.force)))
    for name, unit, scale, found in parts:
        late, wrong = found.time_offset, vector_size(found.value_offset)
        yield Figure(f"time offset of the {name}, mean", "ms", 1e3 * float(late.mean()))
        yield Figure(f"time offset of the {name}, largest", "ms", 1e3 * float(late.max()))
        yield Figure(f"time offset of the {name}, its rate", "ms/s", 1e3 * delay_derivative(late))
        yield Figure(f"value offset of the {name}, RMS", unit, scale * float(rmse(wrong)))


def _by_hand(recording: xr.Dataset) -> Iterator[Figure]:
    scales = _bilateral(recording)
    if scales is None:
        return
    found = noticed(recording, scales.force)
    yield Figure("force error that the hand would notice", "%", 100.0 * found.share)
    yield Figure("force in the range the JND is known for", "%", 100.0 * found.tested)
    with suppress(ValueError):  # nothing is touched
        yield Figure("effort transparency", "1", effort_transparency(recording, scales.force).ratio)
    with suppress(ValueError):  # nothing is touched, or the master hardly moves
        felt = displayed_stiffness(recording)
        if felt.unexplained <= 1.0 - EXPLAINED:
            yield Figure("displayed stiffness", "N/m", felt.stiffness)
    with suppress(ValueError):  # it touches from the start, or the master hardly moves
        yield Figure("resistance in free motion", "N s/m", free_resistance(recording).damping)


def _policy(recording: xr.Dataset) -> Iterator[Figure]:
    if "policy_done_at" in recording:
        yield Figure("the operator's work is done after", "s", completion_time(recording))
        yield Figure("stages done by the operator", "1", float(recording.policy_leg[-1]))

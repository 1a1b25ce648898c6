"""The verdict on a run: whether the arm did what it was told, by its recording alone.

The arm is lost where the tool or a joint is farther from its reference than the bounds below, for
`HOLD`, or for `END_HOLD` to the end of the recording. A start away from the reference is no loss
where the arm gets there. The command is lost where it ends without arriving, with the tool away
from it, or without the operator's device.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr

from scara_drake import joints
from scara_drake.metrics.command import command_error, status_shares
from scara_drake.metrics.limits import beyond_range, saturated_share, speed_ratio
from scara_drake.metrics.links import LINKS, silence, traffic
from scara_drake.metrics.stretches import stretches
from scara_drake.metrics.supervision import not_followed, stops_told
from scara_drake.metrics.tracking import contact_force, tool_error, tracking_error

TOOL_BOUND: Final = 0.05  # [m], of the tool from its reference
ANGLE_BOUND: Final = 0.1  # [rad], of a joint from its reference
COMMAND_BOUND: Final = 0.1  # [m], of the tool from the delayed command
HOLD: Final = 0.5  # [s], what passes sooner counts for nothing
END_HOLD: Final = 0.1  # [s], the same for what has not passed at the end of the recording
SPEED_BOUND: Final = 1.5  # times the fastest rate of a joint; a reference keeps to one
RANGE_BOUND: Final = 1e-2  # [m, rad], of a joint beyond its range
SATURATED: Final = 0.05  # share of the time at the effort limit that is worth a word
FORCE_BOUND: Final = 500.0  # [N], contact that is worth a word


@dataclass(frozen=True)
class Verdict:
    """What a run came to.

    Attributes:
        failures: why the run is no success, a sentence each; empty where it is one.
        remarks: what else has to be known of it.
        lost: whether the arm was lost, or did not follow at the end: it stood in a fault or an
            emergency stop, or its command did not arrive or was not followed.
    """

    failures: tuple[str, ...]
    remarks: tuple[str, ...]
    lost: bool = False

    @property
    def good(self) -> bool:
        """Whether the arm did what it was told."""
        return not self.failures

    def __str__(self) -> str:
        return "; ".join(self.failures) or "arm followed"

    def _repr_html_(self) -> str:
        from scara_drake.display.cards import of_verdict

        return of_verdict(self)


def verdict(recording: xr.Dataset) -> Verdict:
    """Judge a recording: a pure function of its variables."""
    lost, silent = [*_arm(recording), *not_followed(recording)], [*_silent(recording)]
    failures = [*lost, *_limits(recording), *silent]
    lost += [sentence for sentence in silent if sentence.startswith("command")]
    remarks = [*stops_told(recording), *_outages(recording), *_statuses(recording)]
    remarks += _efforts(recording)
    for sentence, open_end in _device(recording):
        (failures if open_end else remarks).append(sentence)
    for sentence, open_end in _command(recording):
        (failures if open_end and not failures else remarks).append(sentence)
        lost += [sentence] if open_end else []
    return Verdict(tuple(failures), (*remarks, *_forces(recording)), bool(lost))


def _arm(recording: xr.Dataset) -> Iterator[str]:
    """The stretches in which the arm was lost."""
    t, tool = recording.time.values, tool_error(recording)
    angles = abs(tracking_error(recording)).isel(joint=slice(1, None)).max("joint")
    away = ~((tool.values <= TOOL_BOUND) & (angles.values <= ANGLE_BOUND))
    for lost in stretches(t, away, HOLD):
        started = away[0] and lost.start == t[0] and not lost.open
        if started or lost.length < END_HOLD:
            continue
        during = slice(lost.start, lost.end)
        farthest = (
            f"tool up to {float(tool.sel(time=during).max()):.3g} m and joints up to "
            f"{float(angles.sel(time=during).max()):.3g} rad from their references"
        )
        back = "" if lost.open else f", back at t = {lost.end:.2f} s"
        yield f"arm lost at t = {lost.start:.2f} s{back}: {farthest}"


def _limits(recording: xr.Dataset) -> Iterator[str]:
    """The limits of the joints that were broken."""
    for what, rates, bound in (
        ("joints", recording.v_measured, SPEED_BOUND),
        ("references", recording.v_desired, 1.0 + 1e-6),
    ):
        ratio = speed_ratio(rates)
        over = ratio.max("time")
        if float(over.max()) > bound:
            first = float(recording.time[np.argmax((ratio > bound).any("joint").values)])
            yield (
                f"speed limit broken at t = {first:.2f} s: {what} up to "
                f"{_each(over, over > bound, '{:.3g}')} times it"
            )
    beyond = beyond_range(recording.q_measured)
    most = beyond.max("time")
    if float(most.max()) > RANGE_BOUND:
        first = float(recording.time[np.argmax((beyond > RANGE_BOUND).any("joint").values)])
        yield (
            f"joint range left at t = {first:.2f} s: by "
            f"{_each(most, most > RANGE_BOUND, '{:.3g}')} m or rad"
        )


def _silent(recording: xr.Dataset) -> Iterator[str]:
    """The links that ended without a packet."""
    for link, what in zip(LINKS, ("command", "force"), strict=True):
        silent = float(silence(recording, link)[-1])
        if silent > HOLD:
            since = max(float(recording.time[-1]) - silent, 0.0)
            yield f"{what} lost at t = {since:.2f} s: nothing came over the {link}link to the end"


def _device(recording: xr.Dataset) -> Iterator[tuple[str, bool]]:
    """The stretches in which the operator's device was lost, and whether it ended so."""
    if "device_connected" not in recording:
        return
    named = f" ({recording.attrs['device']})" if recording.attrs.get("device") else ""
    for lost in stretches(recording.time.values, recording.device_connected.values < 1.0):
        yield (
            f"the operator's device{named} was lost for {lost.length:.2f} s, from {lost}",
            lost.open and lost.length > HOLD,
        )


def _command(recording: xr.Dataset) -> Iterator[tuple[str, bool]]:
    """The stretches in which the tool was not where the command had it, and whether it ended so.

    A command beyond the reach is drawn back into it, which is as it should be: not a failure.
    """
    error, status = command_error(recording), recording.status
    if not bool(np.isfinite(error).all()):
        return
    for away in stretches(recording.time.values, error.values > COMMAND_BOUND, HOLD):
        during = slice(away.start, away.end)
        most = float(error.sel(time=during).max())
        limited = float(status.sel(time=during)[-1]) == 2.0
        reason = ", out of reach" if limited else ""
        yield (
            f"command not followed from {away}: tool up to {most:.3g} m from it{reason}",
            away.open and away.length >= HOLD and not limited,
        )


def _outages(recording: xr.Dataset) -> Iterator[str]:
    for link in LINKS:
        found = traffic(recording, link)
        if found is not None and found.outages:
            times = ", ".join(str(outage) for outage in found.outages[:5])
            more = len(found.outages) - 5
            rest = f" and {more} times more" if more > 0 else ""
            yield f"nothing came over the {link}link from {times}{rest}"
    if "command_watch" in recording:
        for lost in stretches(recording.time.values, recording.command_watch.values > 0.0):
            yield f"the command was lost from {lost}, until it was followed again"


def _statuses(recording: xr.Dataset) -> Iterator[str]:
    shares = status_shares(recording)
    if shares and shares["followed"] < 1.0:
        parts = ", ".join(f"{100.0 * share:.1f} % {name}" for name, share in shares.items())
        yield f"the received command was {parts}"


def _efforts(recording: xr.Dataset) -> Iterator[str]:
    share = saturated_share(recording.tau_applied)
    if float(share.max()) > SATURATED:
        percent = 100.0 * share
        yield f"at the effort limit: {_each(percent, share > SATURATED, '{:.0f} %')} of the time"


def _forces(recording: xr.Dataset) -> Iterator[str]:
    force = contact_force(recording)
    over = force.values > FORCE_BOUND
    if over.any():
        period = float(recording.time[-1] - recording.time[0]) / max(recording.time.size - 1, 1)
        yield (
            f"contact force up to {float(force.max()):.0f} N, above {FORCE_BOUND:.0f} N for "
            f"{over.sum() * period:.2f} s"
        )


def _each(values: xr.DataArray, shown: xr.DataArray, form: str) -> str:
    """The values of some joints with their names."""
    return ", ".join(
        f"{name} {form.format(value)}"
        for name, value, show in zip(joints.JOINT_NAMES, values.values, shown.values, strict=True)
        if show
    )

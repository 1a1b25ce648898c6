"""How a command became motion: the tool against the command as it was sent, and what was done."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr

from scara_drake.metrics.bilateral import as_received

# By the number in `status`.
STATUSES: Final = ("followed", "held", "limited")


def command_error(recording: xr.Dataset, delayed: bool = True) -> xr.DataArray:
    """Distance (time) [m] of the tool from the command as it was sent; NaN where there is none.

    Args:
        recording: of a run.
        delayed: compares with the command of one delay ago, that of the packet in use. As nothing
            that is lost has a delay, the error grows where no packet comes.
    """
    command = recording.p_WE_commanded
    if delayed and command.notnull().all() and recording.delay_up.notnull().all():
        command = as_received(command, recording.delay_up)
    return ((command - recording.p_WE_measured) ** 2).sum("axis", skipna=False) ** 0.5


def status_shares(recording: xr.Dataset) -> dict[str, float]:
    """Share of the time in which the command was followed, held and limited; empty without one.

    Held: it could not be followed, and the arm stood still. Limited: it was drawn back into reach.
    """
    status = recording.status.values
    if not np.isfinite(status).all():
        return {}
    numbers = [*range(len(STATUSES)), *(int(n) for n in np.unique(status) if n >= len(STATUSES))]
    names = dict(enumerate(STATUSES))
    return {names.get(n, f"status {n}"): float(np.mean(status == n)) for n in numbers}

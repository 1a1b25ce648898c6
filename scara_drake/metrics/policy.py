"""How far an operator who reacts came with his work: pure functions of a recording."""

from __future__ import annotations

import numpy as np
import xarray as xr

MOVES = 0.0  # see `vectors.PolicyState`


def completion_time(recording: xr.Dataset) -> float:
    """Return when the work was done [s]; NaN where it was not.

    Raises:
        ValueError: the recording is of no operator with a policy.
    """
    if "policy_done_at" not in recording:
        raise ValueError("recording: no policy_done_at, allowed that of an operator with a policy")
    done_at = float(recording.policy_done_at[-1])
    return done_at if done_at >= 0.0 else np.nan


def move_count(recording: xr.Dataset) -> int:
    """Return how many moves the operator began; of one who never pauses, how often he set out."""
    moves = recording.policy_phase.values == MOVES
    return int(np.count_nonzero(np.diff(moves.astype(int), prepend=0) > 0))

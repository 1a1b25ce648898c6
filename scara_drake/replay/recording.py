"""What a recording holds that is shown: joints, desired tool, force, and the surfaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.joints import JOINT_NAMES
from scara_drake.recordings.files import UNREADABLE, open_recording
from scara_drake.recordings.surfaces import Block, read_blocks

Array = NDArray[np.float64]

_OF_A_MASTER = ("x_master", "hand_target")  # where there is one
_SIGNALS = ["q_measured", "q_desired", "p_WE_desired", "f_env_on_tool_W"]
YEAR = 3.2e7  # [s]: no run is longer, and none could be drawn


def load(path: str | Path) -> tuple[xr.Dataset, list[Block]]:
    """Read of a recording what is shown: joints, desired tool, force; and the surfaces.

    Raises:
        ValueError: no such file, not a recording, or one that is damaged.
    """
    refusal = ValueError(f"recording: '{path}', allowed NetCDF written by a run")
    with open_recording(path) as recording:
        try:
            names = [*_SIGNALS, *(name for name in _OF_A_MASTER if name in recording)]
            data = recording[names].sel(joint=list(JOINT_NAMES)).load()
            blocks = read_blocks(data.attrs["scenario"])
        except UNREADABLE:
            raise refusal from None
    times = data.time.values
    if times.size == 0 or not np.isfinite(data.q_measured).all() or not _is_a_clock(times):
        raise refusal
    return data, blocks


def _is_a_clock(times: Array) -> bool:
    """Whether times rise, and are those of a run: not below 0, nor above a year."""
    return bool(times[0] >= 0.0 and times[-1] <= YEAR and (np.diff(times) > 0.0).all())

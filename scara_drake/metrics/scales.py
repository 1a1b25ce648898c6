"""The scales of the coupling that a recording was made with, read without Drake."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import xarray as xr

from scara_drake.recordings.surfaces import read_scenario


class Scales(NamedTuple):
    """The scales of a coupling.

    Attributes:
        position: way of the tool over that of the device.
        force: force at the device over that at the tool.
    """

    position: float = 1.0
    force: float = 1.0


def scales_of(recording: xr.Dataset) -> Scales:
    """Return the scales of a recording's coupling; 1 where its scenario names none.

    Raises:
        ValueError: its scenario is none.
    """
    text = recording.attrs.get("scenario")
    return _of_text(text) if text else Scales()


@lru_cache(maxsize=32)
def _of_text(text: str) -> Scales:
    coupling = read_scenario(text).get("coupling")
    fields = coupling if isinstance(coupling, dict) else {}
    return Scales(float(fields.get("position_scale", 1.0)), float(fields.get("force_scale", 1.0)))

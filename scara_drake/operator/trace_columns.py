"""What the columns of a trace may be, and what a trace without one stands for."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.layout import Layout
from scara_drake.operator.devices.sample import AXIS_LIMIT
from scara_drake.vectors import (
    BUTTON_NAMES,
    DEVICE_STATUS,
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    OPERATOR_BUTTONS,
    ORIENTATION_AXES,
    ORIENTATION_NAMES,
    SETTING_NAMES,
    STICK_NAMES,
    DeviceStatus,
)

Array = NDArray[np.float64]

COLUMNS: Final = ("time", *STICK_NAMES)
MORE_COLUMNS: Final = (*ORIENTATION_NAMES, *BUTTON_NAMES, *DeviceStatus._fields, *SETTING_NAMES)
# A recorded operator holds the dead-man button, and his device is there.
DEFAULTS: Final[dict[str, float]] = (
    dict.fromkeys(MORE_COLUMNS, 0.0)
    | {"engage": 1.0, "connected": 1.0}
    | NEUTRAL_SETTINGS._asdict()
)
_AXES: Final = (*STICK_NAMES, *ORIENTATION_NAMES)
_BITS: Final = (*BUTTON_NAMES, "connected")


class Said(NamedTuple):
    """A row of `MORE_COLUMNS`: what a device says beside its stick.

    Attributes:
        orientation: (3,) of `vectors.OrientationAxes`.
        buttons: (6,) of `vectors.OperatorButtons`.
        status: (4,) of `vectors.DeviceStatus`.
        settings: (5,) of `vectors.LiveSettings`.
    """

    orientation: Array
    buttons: Array
    status: Array
    settings: Array


SAID: Final = Layout(
    Said,
    orientation=ORIENTATION_AXES.size,
    buttons=OPERATOR_BUTTONS.size,
    status=DEVICE_STATUS.size,
    settings=LIVE_SETTINGS.size,
)
said_of = SAID.reader()


def bounds(column: str) -> tuple[float, float]:
    """Return the lowest and the highest value that a column may have."""
    if column in ("time", "lateness"):  # a run that waits for the clock is early
        return -np.inf, np.inf
    if column in _AXES:
        return -AXIS_LIMIT, AXIS_LIMIT
    return 0.0, 1.0 if column in _BITS else np.inf


def by_default(rows: int) -> Array:
    """Return what stands for the further columns where a trace has none, (rows, 18)."""
    return np.tile([DEFAULTS[name] for name in MORE_COLUMNS], (rows, 1))

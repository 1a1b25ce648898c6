"""What a device says at one moment."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.vectors import (
    JOYSTICK_AXES,
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    OPERATOR_BUTTONS,
    ORIENTATION_AXES,
)

Array = NDArray[np.float64]

AXIS_LIMIT = 1.05  # a little beyond 1 for a stick calibrated badly; the block clips it
# Of the arrays of a sample, by name.
SHAPES: Final[dict[str, int]] = {
    "axes": JOYSTICK_AXES.size,
    "orientation": ORIENTATION_AXES.size,
    "buttons": OPERATOR_BUTTONS.size,
    "settings": LIVE_SETTINGS.size,
}


class NoDeviceError(ValueError):
    """A kind of device that this machine cannot have: no library, no display."""


class Sample(NamedTuple):
    """What a device says at one moment.

    Attributes:
        connected: whether it is there; if not, the rest is what it said last.
        stamp: when it last spoke, of `time.monotonic` [s].
        axes: (5,) in the order of `vectors.JoystickAxes`, each in [-1, 1].
        orientation: (3,) of `vectors.OrientationAxes`, each in [-1, 1].
        buttons: (6,) of `vectors.OperatorButtons`, 1 while down.
        settings: (5,) of `vectors.LiveSettings`.
    """

    connected: bool
    stamp: float
    axes: Array
    orientation: Array = np.zeros(ORIENTATION_AXES.size)  # nobody writes into a sample
    buttons: Array = np.zeros(OPERATOR_BUTTONS.size)
    settings: Array = LIVE_SETTINGS.pack(**NEUTRAL_SETTINGS._asdict())


def at_rest(stamp: float, connected: bool = True) -> Sample:
    """Return the sample of a device that nobody touches."""
    return Sample(connected, stamp, np.zeros(JOYSTICK_AXES.size))


def is_good(sample: Sample) -> bool:
    """Return whether all of a sample is finite, and its axes within `AXIS_LIMIT`."""
    axes = np.concatenate([sample.axes, sample.orientation])
    rest = np.concatenate([sample.buttons, sample.settings])
    # Not "any beyond": NaN is beyond nothing.
    return bool((np.abs(axes) <= AXIS_LIMIT).all() and np.isfinite(rest).all())

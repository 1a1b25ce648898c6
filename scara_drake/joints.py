"""The six joints: names, units, ranges, efforts and the home posture; numpy only."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def _constant(values: list[float]) -> Array:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


JOINT_NAMES: Final = ("d1", "theta2", "theta3", "theta4", "theta5", "theta6")
JOINT_UNITS: Final = ("m", "rad", "rad", "rad", "rad", "rad")

# Table 2 of the paper, [m] and [rad].
LOWER: Final = _constant([2.5, -2 * np.pi, -2 * np.pi, -0.75 * np.pi, -0.75 * np.pi, -2 * np.pi])
UPPER: Final = _constant([10.0, 2 * np.pi, 2 * np.pi, 0.75 * np.pi, 0.75 * np.pi, 2 * np.pi])
# Reference speeds that the drives are asked for, [m/s] and [rad/s]; see models/README.md.
MAX_SPEED: Final = _constant([0.5, 1.5, 1.5, 2.0, 3.0, 3.0])
# Effort limits, [N] and [N m]: enough to move as the experiments ask and to stop.
EFFORT: Final = _constant([15e3, 8e3, 3e3, 3e3, 500.0, 100.0])
# SCARA configuration with the tool along -y, away from every limit and singularity.
HOME: Final = _constant([3.0, -0.5, 0.0, -0.5, 1.0, 0.0])


def check_configuration(name: str, q: ArrayLike) -> Array:
    """Return q as a float array (6,) within the joint ranges.

    Raises:
        ValueError: not numbers, wrong shape, not finite, or outside Table 2; names the joint and
            its range.
    """
    allowed = "allowed (6,): d1 [m], theta2 .. theta6 [rad]"
    try:
        array = np.array(q, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: {q!r}, {allowed}") from None
    if array.shape != (6,):
        raise ValueError(f"{name}: shape {array.shape}, {allowed}")
    for joint, unit, value, low, high in zip(
        JOINT_NAMES, JOINT_UNITS, array, LOWER, UPPER, strict=True
    ):
        if not low <= value <= high:  # also refuses NaN
            raise ValueError(
                f"{name}: {joint} = {value:g} {unit}, allowed {low:.4g} to {high:.4g} {unit}"
            )
    return array

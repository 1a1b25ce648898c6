"""The steps of the joints along a path, and which of them is a flip."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake import kinematics
from scara_drake.joints import JOINT_NAMES

Array = NDArray[np.float64]

# A joint may step so far between neighbouring poses [m, rad], and by what the tool itself turns and
# moves [rad, rad/m: over the shortest arm, the beam]; beyond that it has changed the branch.
ALLOWED: Final = 0.7
PER_METRE: Final = 1.0 / kinematics.D3


class Step(NamedTuple):
    """A step of one joint: name, size [m, rad], index of the pose it leads to, whether a flip."""

    joint: str
    size: float
    pose: int
    flip: bool

    def __str__(self) -> str:
        unit = "m" if self.joint == JOINT_NAMES[0] else "rad"
        return f"{self.joint} {self.size:.4g} {unit}, from pose {self.pose} to {self.pose + 1}"


def largest_step(X_WEs: Array, q: Array) -> Step | None:
    """Return the largest flip of a path, or without one its largest step; None for one pose.

    Args:
        X_WEs: poses (n, 4, 4).
        q: postures (n, 6).
    """
    if len(q) < 2:
        return None
    steps = np.abs(np.diff(q, axis=0))
    moved, turned = kinematics.pose_error(X_WEs[1:], X_WEs[:-1])
    flips = steps.max(axis=1) > ALLOWED + turned + PER_METRE * moved
    k = int(np.argmax(steps.max(axis=1) + np.where(flips, 1e6, 0.0)))
    joint = int(np.argmax(steps[k]))
    return Step(JOINT_NAMES[joint], float(steps[k, joint]), k + 1, bool(flips[k]))

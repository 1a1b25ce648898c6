"""The wiring of a joint motion: its references go straight to the controller."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from scara_drake.operator.joint_motion import JointMotionSource
from scara_drake.wiring import Signals, outputs

if TYPE_CHECKING:
    from scara_drake.operator.joint_motion import JointMotion
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]


def add_joint_motion(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the source of the references; there is neither channel nor inverse kinematics."""
    motion: JointMotion = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    source = builder.AddNamedSystem("joint_motion", JointMotionSource(motion))
    return signals | dict(outputs(source))

"""Inverse kinematics: pure functions over compiled kernels."""

from scara_drake.ik.options import PAPER, PARAMETERS, TUNED, Dpso, Swarm
from scara_drake.ik.result import (
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    IkPath,
    IkResult,
)
from scara_drake.ik.solve import METHODS, solve, solve_all, solve_path

__all__ = [
    "METHODS",
    "PAPER",
    "PARAMETERS",
    "POSITION_TOLERANCE",
    "ROTATION_TOLERANCE",
    "TUNED",
    "Dpso",
    "IkPath",
    "IkResult",
    "Swarm",
    "solve",
    "solve_all",
    "solve_path",
]

"""The tick of a simulated master, as kernels: who moves the hand."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.operator.device_motion import device_of, move_device
from scara_drake.operator.hand import WAYPOINT, hand_path_of, hand_target_at

Array = NDArray[np.float64]

WAYPOINT_SIZE: Final = WAYPOINT.size


@njit(cache=True)
def master_step(
    t: float,
    f_master: Array,
    device: Array,
    hand_path: Array,
    motion_master: Array,
    hand_target: Array,
    f_hand: Array,
) -> None:
    """One tick of `SimulatedMaster`, in place."""
    path, target_next = hand_path_of(hand_path), np.empty(3)
    waypoints = path.waypoints.reshape((-1, WAYPOINT_SIZE))
    hand_target_at(t + device_of(device).period, waypoints, path.sweep, target_next)
    move_device(device, f_master, target_next, motion_master, hand_target, f_hand)


@njit(cache=True)
def guided_step(
    hand_wanted: Array,
    f_master: Array,
    device: Array,
    motion_master: Array,
    hand_target: Array,
    f_hand: Array,
) -> None:
    """One tick of `SimulatedMaster` with a policy, in place."""
    move_device(device, f_master, hand_wanted, motion_master, hand_target, f_hand)

"""Position up and force down with an ideal slave: what the coupling does, not what our robot does.

One axis: the hand and the device of `Master`, and a slave that is where the device is, at a wall.
All of the delay there and back is then that of the channel, so this bounds what `Direct` can bear
with any robot. A robot adds its own lag, see `own_latency` of the wiring.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scara_drake.coupling.layouts import motion_of
from scara_drake.environment import Wall, normal_force, surface_row
from scara_drake.metrics.bilateral import STEADY, SWING
from scara_drake.operator.hand import hand_target_at
from scara_drake.operator.master import Master, move_device

Array = NDArray[np.float64]

STEP = 1e-4  # [s], of the integration
LONGEST = 0.1  # [s], of the delays that are looked at
Y = 1  # the axis of the press
WAY = 0.01  # [m], from the centre to the wall


def ideal_slave(omega: ArrayLike, delay: float) -> tuple[Array, Array, Array, Array]:
    """Return the hybrid parameters of position up, force down, and a slave that is where it should.

    Its eta is cos(2 w T): 1 at no delay, just absolutely stable, and less at any delay.

    Args:
        omega: angular frequencies [rad/s].
        delay: T, of each direction [s].
    """
    late = np.exp(-1j * np.asarray(omega, dtype=np.float64) * delay)
    none = np.zeros_like(late)
    return none, late, -late, none


def stable_delay(
    master: Master | None = None, wall: Wall | None = None, force_scale: float = 1.0
) -> float:
    """Return the longest delay there and back [s] at which a press on a wall is stable.

    Stable is what the table of the couplings calls so; zero if no delay is. The delay is found to
    a step of the integration.

    Args:
        master: who presses; the second of its targets is the press, the third its end.
        wall: its impedance; it is `WAY` away along -y.
        force_scale: force at the device over that of the wall.
    """
    master, row = master or Master(), surface_row(wall or Wall())
    low, high = -1, round(LONGEST / STEP)
    while high - low > 1:
        middle = (low + high) // 2
        if _is_stable(middle, master, row, force_scale):
            low = middle
        else:
            high = middle
    return max(low, 0) * STEP


def _is_stable(delay: int, master: Master, wall: Array, force_scale: float) -> bool:
    begin, end = master.times[1:3]
    force, speed = _press(
        delay, master.parameters(STEP), master.waypoints(), master.sweep.parameters(),
        wall, force_scale, round(end / STEP),
    )  # fmt: skip
    way = float(np.linalg.norm(master.targets[1]))
    rest = round((begin + STEADY * (end - begin)) / STEP)
    steady = round((end - STEADY * (end - begin)) / STEP)
    energy = master.hardware().mass * abs(speed[rest:]).max() ** 2
    driven = energy >= master.hand_stiffness * way**2
    ripple = force[steady:].std()
    return bool(not driven and ripple < SWING * master.hand_stiffness * way)


@njit(cache=True)
def _press(
    delay: int,
    device: Array,
    waypoints: Array,
    sweep: Array,
    wall: Array,
    force_scale: float,
    steps: int,
) -> tuple[Array, Array]:
    """Return the force at the device [N] and its speed [m/s] along y at each step (steps,)."""
    motion, target, following = np.zeros(6), np.zeros(3), np.zeros(3)
    f_hand, f = np.zeros(3), np.zeros(3)
    now = motion_of(motion)
    force, speed = np.zeros(steps), np.zeros(steps)
    felt = np.zeros(steps)
    for k in range(steps):
        felt[k] = force_scale * normal_force(wall, -WAY - now.x[Y], -now.v[Y])
        f[Y] = -felt[k - delay] if k >= delay else 0.0
        force[k], speed[k] = f[Y], now.v[Y]
        hand_target_at((k + 1) * STEP, waypoints, sweep, following)
        move_device(device, f, following, motion, target, f_hand)
    return force, speed

"""An operator who reacts, and a robot that is where it should be: his work in one compiled loop.

The kernels are those of the Diagram: the operator's mind, the hand and its device, both ends of the
coupling, the limiter of the commands and the surface. In place of the arm the tool is where the
limiter is, so what is left is the operator, the delay and the coupling.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.motion import limit_motion
from scara_drake.coupling.wave_variables import WaveVariables, wave_master, wave_slave
from scara_drake.environment import Wall, normal_force, surface_row
from scara_drake.operator.continuous import follow
from scara_drake.operator.device_motion import move_device
from scara_drake.operator.master import Master
from scara_drake.operator.move_and_wait import move_and_wait
from scara_drake.operator.moves import DONE, MOVING, mind_of
from scara_drake.operator.policy import MoveAndWait, OperatorPolicy, Policy
from scara_drake.operator.policy_sense import sense_of

Array = NDArray[np.float64]

PERIOD = 1e-3  # [s]
LONGEST = 120.0  # [s], of a piece of work
WALL = -0.05  # [m], the surface along y
Y = 1  # the axis that the surface is normal to
LIMITS = (0.5, 10.0, 400.0)  # [m/s], [m/s²], [1/s], of the commands, as in the scenario bilateral


class Station(NamedTuple):
    """What a loop works with: parameters and memories of its kernels.

    Attributes:
        worker: of the operator.
        mind: of the operator.
        sense: of the operator.
        device: of the master.
        near: constants of the coupling at the master.
        far: the same at the robot.
        near_memory: memory of the coupling at the master.
        far_memory: the same at the robot.
        up: packets to the robot (late + 1, n).
        down: packets to the master (late + 1, n).
        seen: tool positions on their way (late + 1, 3) [m].
        wall: see `surface_row`.
        limits: of the commands.
    """

    worker: Array
    mind: Array
    sense: Array
    device: Array
    near: Array
    far: Array
    near_memory: Array
    far_memory: Array
    up: Array
    down: Array
    seen: Array
    wall: Array
    limits: Array


class Outcome(NamedTuple):
    """What came of a piece of work.

    Attributes:
        seconds: until it was done; NaN where it was not.
        moves: that were begun.
        squared_force: of the tool, its integral over the time [N² s].
        peak_force: of the tool [N].
    """

    seconds: float
    moves: float
    squared_force: float
    peak_force: float


def work(
    policy: Policy,
    delay: float,
    seed: int,
    wall: Wall | None = None,
    master: Master | None = None,
    longest: float = LONGEST,
) -> Outcome:
    """Let an operator do his work over a delay.

    Args:
        policy: the operator.
        delay: there and back [s], half of it each way.
        seed: of the operator.
        wall: a surface, whose force comes back by wave variables; without one nothing is felt, and
            the tool is where the device was.
        master: the device and the hand.
        longest: when he gives up [s].
    """
    master = master or Master()
    late = round(0.5 * delay / PERIOD)
    mind = OperatorPolicy(policy, np.zeros(3), 1.0, master.hand_stiffness, PERIOD, seed).declaration
    coupling = WaveVariables()
    near = coupling.make_master(PERIOD, master.hardware().force).declaration
    far = coupling.make_slave(PERIOD, np.zeros(8), LIMITS[2]).declaration
    exchange = coupling.exchange()
    station = Station(
        np.array(mind.parameters["worker"]),
        np.array(mind.memory["mind"].initial),
        np.array(mind.memory["sense"].initial),
        master.parameters(PERIOD),
        np.array(near.parameters["constants"]),
        np.array(far.parameters["constants"]),
        np.array(near.memory["memory"].initial),
        np.array(far.memory["memory"].initial),
        np.zeros((late + 1, exchange.up_size)),
        np.zeros((late + 1, exchange.down_size)),
        np.zeros((late + 1, 3)),
        surface_row(wall or Wall()),
        np.array(LIMITS),
    )
    waits = isinstance(policy, MoveAndWait)
    return Outcome(*_work(station, waits, wall is not None, round(longest / PERIOD)))


@njit(cache=True)
def _work(
    station: Station, waits: bool, feels: bool, steps: int
) -> tuple[float, float, float, float]:
    """Run; each part reads what the others had before. Return the fields of an `Outcome`."""
    s = station
    late, m = s.seen.shape[0] - 1, mind_of(s.mind)
    age = np.full(1, late * PERIOD)
    motion, target, f_hand, f_master = np.zeros(6), np.zeros(3), np.zeros(3), np.zeros(3)
    tool, f_env, command = np.zeros(6), np.zeros(3), np.zeros(8)
    sent_up, sent_down = np.zeros(s.up.shape[1]), np.zeros(s.down.shape[1])
    meters_near, meters_far = np.zeros(6), np.zeros(6)
    moves, squared, peak, was = 0.0, 0.0, 0.0, m.phase[()]
    for k in range(steps):
        # What was sent so many ticks ago leaves its place to what is sent now.
        at = k % (late + 1)
        s.seen[at], s.up[at], s.down[at] = tool[:3], sent_up, sent_down
        came = (k + 1) % (late + 1)
        t, seen = k * PERIOD, s.seen[came]
        if waits:
            move_and_wait(t, seen, age, motion, f_hand, s.worker, s.mind, s.sense)
        else:
            follow(t, seen, age, motion, f_hand, s.worker, s.mind, s.sense)
        if m.phase[()] == MOVING and was != MOVING:
            moves += 1.0
        was = m.phase[()]
        if was == DONE:
            return sense_of(s.sense).done_at[()].item(), moves, squared, peak
        before = motion.copy()
        move_device(s.device, f_master, m.aim, motion, target, f_hand)
        if feels:
            wave_master(before, s.down[came], s.near, s.near_memory, sent_up, f_master, meters_near)
            shown, force = tool.copy(), normal_force(s.wall, WALL - tool[Y], -tool[3 + Y])
            limit_motion(
                command[:3] - tool[:3], tool[3:], s.limits[0], s.limits[1], s.limits[2], PERIOD
            )
            tool[:3] += PERIOD * tool[3:]
            wave_slave(
                s.up[came], f_env, shown, s.far, s.far_memory, sent_down, command, meters_far
            )
            f_env[Y] = force
        else:
            sent_up[:3] = before[:3]
            tool[:3] = s.up[came][:3]
        squared += PERIOD * f_env[Y] ** 2
        peak = max(peak, f_env[Y])
    return np.nan, moves, squared, peak

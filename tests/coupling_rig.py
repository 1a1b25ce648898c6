"""One axis of a teleoperation, in one compiled loop: for studies of a coupling without the arm.

It has the kernels and the order of the Diagram: everything reads what the others had before. The
robot is the limiter of the commands and, for the rest, a delay of some ticks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from numba import float64, njit, typeof, types, void

from scara_drake.channel.codec import Codec, DeadBand, ask, encode, step_codec
from scara_drake.common.motion import limit_motion
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.layouts import PACKET
from scara_drake.operator.hand import hand_target_at
from scara_drake.operator.master import Master, move_device

PERIOD = 1e-3

Delay = float | Callable[[float], float] | np.ndarray
AXIS = 1
# Columns of the result.
(
    T, X_M, F_M, X_S, F_ENV, E_IN_M, E_OUT_M, E_IN_S, E_OUT_S, RX_M, RX_S, X_HAND, F_APPLIED,
    SENT_UP, SENT_DOWN,
) = range(15)  # fmt: skip


@njit
def send(packet, bands, keep_alive, memory, coded):
    """Code a packet; return whether it is sent. Without bands all are, as they are."""
    coded[:] = packet
    if bands.size == 0:
        return True
    transmit = np.zeros(1)
    ask(packet, bands, keep_alive, 1, memory, transmit)
    encode(packet, bands, memory, coded)
    step_codec(packet, bands, keep_alive, 1, memory)
    return transmit[0] > 0.5


def run(
    master_kernel, slave_kernel, c_master, c_slave, mem_m, mem_s, sizes, waypoints, sweep, device,
    arrive_up, arrive_down, wall, limiter, lag, e_up, e_down, bands_up, bands_down, keep_alive,
    codec_up, codec_down, result,
):  # fmt: skip
    """Run; `arrive_*[k]` is the number of the packet that is on the receiver's port at tick k.

    One that the codec did not send never comes: what was on the port stays.
    """
    steps = result.shape[0]
    n_up, n_down = sizes[0], sizes[1]
    ups, downs = np.zeros((steps + 1, n_up)), np.zeros((steps + 1, n_down))
    en_m, en_s = np.zeros(6), np.zeros(6)
    sent_m, sent_s = np.zeros(n_up), np.zeros(n_down)
    motion, target, nxt = np.zeros(6), np.zeros(3), np.zeros(3)
    f_hand, f = np.zeros(3), np.zeros(3)
    command = np.zeros(8)
    xs, vs = np.zeros(3), np.zeros(3)
    tool = np.zeros((steps + 1, 2))
    f_env, ms = np.zeros(3), np.zeros(6)
    up, down = np.zeros(n_up), np.zeros(n_down)
    is_sent = np.ones((steps + 1, 2))
    for k in range(steps):
        t = k * 1e-3
        # plant and contact: the tool follows the limiter with a lag
        i = max(k - lag, 0)
        d = (wall[0] - tool[i, 0]) if k > 0 else 0.0
        force = 0.0
        if d > 0.0:
            force = max(wall[1] * d - wall[2] * min(d / 1e-3, 1.0) * tool[i, 1], 0.0)
        # read what was before
        if is_sent[arrive_up[k], 0] > 0.5:
            up[:] = ups[arrive_up[k]]
        if is_sent[arrive_down[k], 1] > 0.5:
            down[:] = downs[arrive_down[k]]
        f_old = f.copy()
        motion_old = motion.copy()
        for j in range(3):
            ms[j] = xs[j]
            ms[3 + j] = vs[j]
        cmd_old = command.copy()
        # the slave's limiter
        error = cmd_old[:3] - xs
        limit_motion(error, vs, limiter[0], limiter[1], limiter[2], 1e-3)
        xs += 1e-3 * vs
        tool[k + 1, 0], tool[k + 1, 1] = xs[AXIS], vs[AXIS]
        slave_kernel(up, f_env, ms, c_slave, mem_s, sent_s, command, en_s)
        hand_target_at(t + 1e-3, waypoints, sweep, nxt)
        move_device(device, f_old, nxt, motion, target, f_hand)
        master_kernel(motion_old, down, c_master, mem_m, sent_m, f, en_m)
        f_env[AXIS] = force
        is_sent[k + 1, 0] = send(sent_m, bands_up, keep_alive, codec_up, ups[k + 1])
        is_sent[k + 1, 1] = send(sent_s, bands_down, keep_alive, codec_down, downs[k + 1])
        result[k, 0] = t
        result[k, 1] = motion[AXIS]
        result[k, 2] = f[AXIS]
        result[k, 3] = xs[AXIS]
        result[k, 4] = force
        result[k, 5] = en_m[AXIS]
        result[k, 6] = en_m[3 + AXIS]
        result[k, 7] = en_s[AXIS]
        result[k, 8] = en_s[3 + AXIS]
        result[k, 9] = down[e_down + AXIS] if e_down >= 0 else 0.0
        result[k, 10] = up[e_up + AXIS] if e_up >= 0 else 0.0
        result[k, 11] = nxt[AXIS]
        result[k, 12] = f_old[AXIS]
        result[k, 13], result[k, 14] = is_sent[k + 1]


@cache
def compiled(signature):
    """The loop; the kernels are passed by their addresses, so couplings of like types share it."""
    return njit(signature)(run)


def kernel_type(kernel, arrays):
    """The type of a kernel that takes so many arrays; it is compiled, or loaded from its cache."""
    passed = (float64[::1],) * arrays
    kernel.compile(passed)
    return types.FunctionType(kernel.overloads[passed].signature)


@dataclass
class Rig:
    """The standard case of the bilateral studies; all fields in SI units."""

    master: Master = field(default_factory=Master)
    wall: float = -0.01  # surface [m]
    stiffness: float = 1e4  # [N/m]
    damping: float = 100.0  # [N s/m]
    max_speed: float = 0.5
    max_acceleration: float = 10.0
    bandwidth: float = 400.0
    lag: int = 3  # ticks from the limiter to the tool
    limit: float = np.inf
    codec: DeadBand | None = None

    def run(
        self,
        coupling: Coupling,
        up: Delay,
        down: Delay,
        duration: float = 12.0,
        e_up: slice | None = None,
        e_down: slice | None = None,
    ) -> np.ndarray:
        """Return the columns; `up`, `down` are delays [s], functions of t or arrival tables.

        `e_up`, `e_down` say where in the payloads the energies are, for the columns RX_S, RX_M.
        """
        steps = round(duration / PERIOD)
        result = np.zeros((steps, 15))
        master = coupling.make_master(PERIOD, self.limit).declaration
        hold = 0.0 if self.codec is None else self.codec.keep_alive
        slave = coupling.make_slave(PERIOD, np.zeros(8), self.bandwidth, hold).declaration
        exchange = coupling.exchange()
        bands_up, keep_alive, codec_up = self._coded("up", exchange, exchange.up_size)
        bands_down, keep_alive, codec_down = self._coded("down", exchange, exchange.down_size)
        arguments = [
            master.parameters["constants"],
            slave.parameters["constants"],
            np.array(master.memory["memory"].initial),
            np.array(slave.memory["memory"].initial),
            np.array([exchange.up_size, exchange.down_size]),
            self.master.waypoints(),
            self.master.sweep.parameters(),
            replace(self.master, actuator_limit=self.limit).parameters(PERIOD),
            arrivals(up, steps),
            arrivals(down, steps),
            np.array([self.wall, self.stiffness, self.damping]),
            np.array([self.max_speed, self.max_acceleration, self.bandwidth]),
            self.lag,
            -1 if e_up is None else PACKET.size + e_up.start,
            -1 if e_down is None else PACKET.size + e_down.start,
            bands_up,
            bands_down,
            keep_alive,
            codec_up,
            codec_down,
            result,
        ]
        kernels = kernel_type(master.update, 7), kernel_type(slave.update, 8)
        loop = compiled(void(*kernels, *map(typeof, arguments)))
        loop(master.update, slave.update, *arguments)
        return result

    def _coded(self, direction: str, exchange: Exchange, size: int) -> tuple:
        """Bands, keep-alive [ticks] and memory of a codec; no bands without one."""
        if self.codec is None:
            return np.zeros(0), 1.0, np.zeros(0)
        is_ = Codec(self.codec, direction, exchange.felt(direction), size, PERIOD).declaration
        memory = np.array(is_.memory["sent"].initial)
        return is_.parameters["bands"], float(is_.parameters["keep_alive"]), memory


def energy_left(result: np.ndarray) -> np.ndarray:
    """Energy [J] that coupling and channel hold at each tick, without the reserve."""
    came_in = result[:, E_IN_M] + result[:, E_IN_S]
    return came_in - result[:, E_OUT_M] - result[:, E_OUT_S]


def arrivals(delay: Delay, steps: int, loss: float = 0.0, seed: int = 0) -> np.ndarray:
    """The number of the packet on the port at each tick: the newest that has arrived."""
    if isinstance(delay, np.ndarray):
        return delay[:steps]
    t = PERIOD * np.arange(steps)
    law = delay if callable(delay) else (lambda t: delay + 0.0 * t)
    travel = np.maximum(np.array([law(s) for s in t]), 0.0)
    arrive = np.arange(steps) + np.round(travel / PERIOD).astype(int)
    if loss > 0.0:
        arrive[np.random.default_rng(seed).random(steps) < loss] = 10 * steps
    newest = np.zeros(steps + 1, dtype=np.int64)
    for k, a in enumerate(arrive):
        if a < steps:
            newest[a + 1] = max(newest[a + 1], k + 1)  # row k + 1 is written at tick k
    return np.maximum.accumulate(newest)[:steps]


PROFILES: dict[str, Delay] = {
    "5 ms": 0.005,
    "20 ms": 0.02,
    "50 ms": 0.05,
    "100 ms": 0.1,
    "200 ms": 0.2,
    "0.2 sin t": lambda t: max(0.2 * math.sin(t), 0.0),
    "0.1 (1 + sin t)": lambda t: 0.1 * (1.0 + math.sin(t)),
    "1 + sin t": lambda t: 1.0 + math.sin(t),
}

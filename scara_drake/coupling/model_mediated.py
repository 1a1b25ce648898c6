"""Model-mediated coupling: the slave sends a model of what it touches, the master renders it.

The slave fits the model on each axis while there is contact, see `surface_model`.

The master renders the newest model at its own rate, so no force crosses the channel and no delay is
in the loop that the hand feels. A model that changes under the hand would make a step of force:
the energy of the rendered spring may grow by `power` and no faster, beside the work of the hand.
Beside that a hand that goes in or comes out at v takes up to K (v T_s)^2 of the sampled spring.

The slave follows the master by a spring and a damper, as in `tdpa`, while nothing touches it. While
something does, it is pushed with the force that the master shows, see `press`: with the spring
alone the tool would press with K_c / (K_c + K) of it. Until the first model has arrived, the master
moves freely and shows nothing.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.fields import number
from scara_drake.common.layout import Layout
from scara_drake.coupling.ends import Coupling, Exchange
from scara_drake.coupling.kernels import admit, hold_velocity, master_tick, meter, slave_tick
from scara_drake.coupling.layouts import HELD, held_of
from scara_drake.coupling.surface_model import FIT, MODEL, fit_surface, read_surface, render

Array = NDArray[np.float64]

MOVING = 1e-3  # [m/s]: a hold says nothing about K and B


class Gains(NamedTuple):
    """`ModelMediated` in a kernel, in the master's units.

    A velocity that is held fades to the share `fade` at every tick.
    """

    stiffness: float
    damping: float
    drift_gain: float
    max_speed: float
    fade: float
    forgetting: float
    touch_force: float
    max_stiffness: float
    max_damping: float
    power: float


class Up(NamedTuple):
    """Payload to the slave: position [m], velocity [m/s] and force [N] of the device, (3,) each."""

    x: Array
    v: Array
    f: Array


class Down(NamedTuple):
    """Payload to the master: a `Model` of each axis (3, 4)."""

    models: Array


class MasterMemory(NamedTuple):
    """Rest positions of the rendered springs (3,) [m]."""

    rendered: Array


class SlaveMemory(NamedTuple):
    """Memory at the slave.

    Attributes:
        x_d: followed position (3,) [m].
        f: force of the spring and the damper at the last tick (3,) [N].
        held: received velocity, see `Held`.
        fits: a `Fit` of each axis (3, 14).
    """

    x_d: Array
    f: Array
    held: Array
    fits: Array


GAINS = Layout(Gains)
UP, DOWN = Layout(Up, x=3, v=3, f=3), Layout(Down, models=(3, MODEL.size))
MASTER_MEMORY = Layout(MasterMemory, rendered=3)
SLAVE_MEMORY = Layout(SlaveMemory, x_d=3, f=3, held=HELD.size, fits=(3, FIT.size))
gains_of, up_of, down_of = GAINS.reader(), UP.reader(), DOWN.reader()
master_memory_of, slave_memory_of = MASTER_MEMORY.reader(), SLAVE_MEMORY.reader()


@njit(cache=True)
def model_master(
    motion_master: Array,
    packet_from_slave: Array,
    constants: Array,
    memory: Array,
    packet_to_slave: Array,
    f_master: Array,
    energy_master: Array,
) -> None:
    """One tick at the master: render the newest models."""
    s = master_tick(
        motion_master, packet_from_slave, constants, memory, packet_to_slave, f_master,
        energy_master,
    )  # fmt: skip
    p, m = gains_of(s.gains), master_memory_of(s.memory)
    models, sent = down_of(s.newest).models, up_of(s.sent)
    for i in range(3):
        f_master[i], m.rendered[i] = render(
            models[i],
            s.x[i],
            s.v[i],
            m.rendered[i],
            s.period,
            p.max_stiffness,
            p.power,
            p.max_damping,
        )
        sent.x[i] = s.x[i]
        sent.v[i] = s.v[i]
        sent.f[i] = f_master[i]


@njit(cache=True)
def press(spring: float, shown: float) -> float:
    """Return the force [N] on a tool that is touched: the one that the master shows.

    The spring to the master adds to it where it pulls back, and takes its place where it is larger.
    So the tool never presses with more than the larger of both, and never goes further ahead of the
    master than the shown force bends the spring.
    """
    side = math.copysign(1.0, shown)
    return spring + side * min(max(side * (shown - spring), 0.0), abs(shown))


@njit(cache=True)
def model_slave(
    packet_from_master: Array,
    f_env_on_tool_W: Array,
    motion_limited: Array,
    constants: Array,
    memory: Array,
    packet_to_master: Array,
    tool_command: Array,
    energy_slave: Array,
) -> None:
    """One tick at the slave: follow the master, and fit what is touched."""
    s = slave_tick(
        packet_from_master, f_env_on_tool_W, motion_limited, constants, memory, packet_to_master
    )
    p, m = gains_of(s.gains), slave_memory_of(s.memory)
    newest, models = up_of(s.newest), down_of(s.sent).models
    ahead = hold_velocity(s, newest.v, p.fade, m.held)
    v_held = held_of(m.held).v
    for i in range(3):
        v = v_held[i] + p.drift_gain * (newest.x[i] + ahead * newest.v[i] - m.x_d[i])
        v = min(max(v, -p.max_speed), p.max_speed)
        meter(energy_slave, i, -m.f[i] * v * s.period)
        m.x_d[i] += v * s.period
        f = p.stiffness * (m.x_d[i] - s.x[i])
        if abs(s.f_env[i]) > p.touch_force:
            f = press(f, newest.f[i])
        f += p.damping * (v - s.v[i])
        m.f[i] = f
        admit(i, f, s, tool_command)
        if abs(s.f_env[i]) > p.touch_force and abs(s.v[i]) > MOVING:
            fit_surface(s.x[i], s.v[i], s.f_env[i], p.forgetting, m.fits[i])
            read_surface(m.fits[i], s.f_env[i], models[i])


@dataclass
class ModelMediated(Coupling):
    """A local model of the environment at the master.

    Attributes:
        stiffness: K_c from the received position to the tool.
        damping: B_c beside it.
        drift_gain: of the position error.
        max_speed: of the followed position at the device.
        fade_time: time constant of the received velocity while nothing arrives.
        forgetting: lambda of the least squares, each sample.
        touch_force: at the tool, above which there is contact.
        max_stiffness: that the master renders at most; less where its device cannot.
        max_damping: the same of the damping.
        power: at which a model may store energy under the hand.
    """

    stiffness: float = number(1000.0, "N/m", 1.0, 1e5)
    damping: float = number(40.0, "N s/m", 0.0, 1e4)
    drift_gain: float = number(5.0, "1/s", 0.0, 100.0)
    max_speed: float = number(0.3, "m/s", 1e-3, 10.0)
    fade_time: float = number(0.02, "s", 1e-3, 10.0)
    forgetting: float = number(0.995, "1", 0.9, 1.0)
    touch_force: float = number(0.5, "N", 1e-3, 1e3)
    max_stiffness: float = number(1e4, "N/m", 1.0, 1e5)
    max_damping: float = number(1e5, "N s/m", 0.0, 1e5)
    power: float = number(0.1, "W", 0.0, 1e3)

    def within(self, stiffness: float, damping: float) -> Self:
        """The coupling whose rendered model is cut to these limits [N/m, N s/m]."""
        return replace(
            self,
            max_stiffness=min(self.max_stiffness, stiffness),
            max_damping=min(self.max_damping, damping),
        )

    def asked_stiffness(self, surface: float) -> float:
        """Stiffness [N/m] of the rendered model of a surface [N/m]."""
        return min(self.impedance_scale * surface, self.max_stiffness)

    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""
        of_model = {"stiffness": "stiffness", "damping": "damping", "x": "place", "side": "side"}
        models = DOWN.slices["models"]
        return Exchange(
            UP,
            DOWN,
            model_master,
            model_slave,
            MASTER_MEMORY,
            SLAVE_MEMORY,
            felt_up=((UP.slices["v"], "speed"), (UP.slices["f"], "force")),
            felt_down=tuple(
                (slice(models.start + MODEL.slices[name].start, models.stop, MODEL.size), quantity)
                for name, quantity in of_model.items()
            ),
        )

    def parameters(self, period: float) -> Array:
        """The gains in the master's units."""
        scale = self.impedance_scale
        return GAINS.pack(
            stiffness=scale * self.stiffness,
            damping=scale * self.damping,
            drift_gain=self.drift_gain,
            max_speed=self.max_speed,
            fade=math.exp(-period / self.fade_time),
            forgetting=self.forgetting,
            touch_force=self.force_scale * self.touch_force,
            max_stiffness=self.max_stiffness,
            max_damping=self.max_damping,
            power=self.power,
        )

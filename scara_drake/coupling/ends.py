"""The two ends of a bilateral coupling: their ports, their packets, and what all kinds share.

Everything is per axis of W and in the master's units: a position of the slave is its way from the
first command over `position_scale`, a force that of the tool times `force_scale`. Forces are
positive where they resist motion in the positive direction, so force times velocity is the power
that the hand, or the command, puts in.

A packet is its number and a payload. The receiver keeps the highest number it has seen, so loss,
reordering and a channel that runs backwards cost performance only; while nothing arrives it holds.
"""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from scara_drake.common import checks
from scara_drake.common.finite import all_finite, check_finite
from scara_drake.common.state import declare_state

Array = NDArray[np.float64]
Kernel = Callable[..., None]

# The energy meters of a port: what has come in (3) and what has gone out (3) [J], never falling.
E_IN, E_OUT = 0, 3
NUMBER = 0  # of a packet; the payload follows
# Constants of an end, before those of the kind.
PERIOD, LIMIT, BANDWIDTH, MASS, GRIP, FULL_GRIP, OWN = range(7)
FIRM = 1.0  # [N] at the tool, from which the contact damping acts in full
# Head of an end's memory: x (3) and force (3) of the last tick, velocity held (3).
X, F, HELD, HEAD = 0, 3, 6, 9


@dataclass
class Coupling:
    """What all couplings have.

    Attributes:
        position_scale: way of the tool over that of the device.
        force_scale: force at the device over that at the tool.
        virtual_mass: of the tool, where the force of the coupling moves it [kg].
        contact_damping: of that mass to the ground while something is touched [N s/m]; it stands
            in for what the lag of the robot takes from a stiff contact, and only dissipates.
    """

    position_scale: float = 1.0
    force_scale: float = 1.0
    virtual_mass: float = 1.0  # [kg]
    contact_damping: float = 50.0  # [N s/m]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        checks.number(f"{name}.position_scale", self.position_scale, 1e-3, 100.0)
        checks.number(f"{name}.force_scale", self.force_scale, 1e-6, 100.0)
        checks.number(f"{name}.virtual_mass", self.virtual_mass, 0.1, 1e3)
        checks.number(f"{name}.contact_damping", self.contact_damping, 0.0, 1e3)

    @property
    def impedance_scale(self) -> float:
        """Factor from an impedance at the tool to that in the master's units."""
        return self.position_scale * self.force_scale

    @abstractmethod
    def kernels(self) -> tuple[Kernel, Kernel]:
        """The kernels of one tick at the master and at the slave, see `MasterEnd`, `SlaveEnd`."""

    @abstractmethod
    def sizes(self) -> tuple[int, int, int, int]:
        """Sizes of the packets up and down, and of the memories at master and slave."""

    @abstractmethod
    def parameters(self, period: float) -> Array:
        """The constants of the kind, in the master's units, for both kernels."""

    def constants(self, period: float, limit: float, bandwidth: float) -> Array:
        """All constants for the kernels."""
        scale = self.impedance_scale
        virtual = [scale * self.virtual_mass, scale * self.contact_damping]
        head = [period, limit, bandwidth, *virtual, self.force_scale * FIRM]
        return np.concatenate([head, self.parameters(period)])

    def make_master(self, period: float, actuator_limit: float = np.inf) -> "MasterEnd":
        """Return the end at the master; the limit of its device [N] is for the meters."""
        return MasterEnd(self, period, actuator_limit)

    def make_slave(
        self, period: float, first_command: ArrayLike, bandwidth: float = 30.0
    ) -> "SlaveEnd":
        """Return the end at the slave.

        Args:
            period: [s].
            first_command: tool command (8,) of the master's centre.
            bandwidth: of the limiter that follows the commands [1/s], see `servo.limit_motion`.
        """
        return SlaveEnd(self, period, first_command, bandwidth)


@njit(cache=True)
def receive(packet: Array, newest: Array) -> float:
    """Keep a packet in `newest` if it is newer; return by how many numbers, 0 if it is not."""
    progress = packet[NUMBER] - newest[NUMBER]
    if not progress > 0.0:
        return 0.0
    newest[:] = packet
    return progress


@njit(cache=True)
def meter(energy: Array, axis: int, work: float) -> None:
    """Add work [J] that an axis of a port took in, or gave if negative, to its meters (6,)."""
    if work > 0.0:
        energy[E_IN + axis] += work
    else:
        energy[E_OUT + axis] -= work


@njit(cache=True)
def meter_device(motion: Array, f: Array, constants: Array, memory: Array, energy: Array) -> None:
    """Meter the device's port: it has moved under the force that was commanded two ticks ago.

    The force now on the port acts over the period that begins, so the one before it moved the
    device here. The product is exact, see `master`.
    """
    limit = constants[LIMIT]
    for i in range(3):
        force = min(max(memory[F + i], -limit), limit)
        meter(energy, i, force * (motion[i] - memory[X + i]))
        memory[X + i] = motion[i]
        memory[F + i] = f[i]


@njit(cache=True)
def admit(
    axis: int, f: float, f_env: float, motion: Array, constants: Array, command: Array
) -> None:
    """Write the command with which the limiter moves the virtual mass: M v' = f - f_env - D v.

    The contact damping D grows with the force that is felt, up to `FIRM`. The limiter's velocity
    goes to half its bandwidth times the distance to the command, at twice the bandwidth. So v' is
    the net force over M where the command is ahead of the motion by 2 / bandwidth times
    v + v' / (2 bandwidth), of the period in which it is read. Whatever a limit takes away stays in
    `motion`, from which the next command starts: nothing winds up.
    """
    period, bandwidth, v = constants[PERIOD], constants[BANDWIDTH], motion[3 + axis]
    damping = constants[GRIP] * min(abs(f_env) / constants[FULL_GRIP], 1.0)
    acceleration = (f - f_env - damping * v) / constants[MASS]
    wanted = v + acceleration * (period + 0.5 / bandwidth)
    command[axis] = motion[axis] + period * v + 2.0 / bandwidth * wanted


@njit(cache=True)
def hold_velocity(progress: float, v: Array, fade: float, memory: Array) -> None:
    """Keep a received velocity (3,) in the memory; it fades while nothing arrives."""
    for i in range(3):
        if progress > 0.0:
            memory[HELD + i] = v[i]
        else:
            memory[HELD + i] *= fade


class MasterEnd(LeafSystem):
    """The end of a coupling at the master.

    Input ports:
        motion_master (6): x_m, v_m of the device [m, m/s]
        packet_from_slave (n_down)
    Output ports, all discrete state:
        packet_to_slave (n_up)
        f_master (3): force of the device, before the limit of its actuators; positive resists [N]
        energy_master (6): taken from the hand (3), given to it (3) [J], at the device's port
    Update (every period): the kernel of the kind, with the newest packet.
    Initial: zero.

    Args:
        coupling: checked.
        period: [s].
        actuator_limit: of the device [N].
    """

    def __init__(self, coupling: Coupling, period: float, actuator_limit: float) -> None:
        super().__init__()
        coupling.validate("coupling")
        up, down, memory, _ = coupling.sizes()
        self._kernel = coupling.kernels()[0]
        self._constants = coupling.constants(period, actuator_limit, np.inf)
        self._motion = self.DeclareVectorInputPort("motion_master", 6)
        self._received = self.DeclareVectorInputPort("packet_from_slave", down)
        self._sent = declare_state(self, up, "packet_to_slave")
        self._f = declare_state(self, 3, "f_master")
        self._energy = declare_state(self, 6, "energy_master")
        self._newest = declare_state(self, down)
        self._memory = declare_state(self, memory)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        motion, packet = self._motion.Eval(context), self._received.Eval(context)
        if not all_finite(motion, packet):
            check_finite(self, context, (self._motion, self._received))
        self._kernel(
            motion,
            packet,
            self._constants,
            discrete.get_mutable_value(self._newest),
            discrete.get_mutable_value(self._memory),
            discrete.get_mutable_value(self._sent),
            discrete.get_mutable_value(self._f),
            discrete.get_mutable_value(self._energy),
        )


@njit(cache=True)
def to_master_units(
    motion_limited: Array, f_env_on_tool_W: Array, frame: Array, motion: Array, f_env: Array
) -> None:
    """Write motion (6,) and resisting force (3,) of the tool in the master's units.

    `frame` (5,) is the first commanded point (3) [m], the position scale and the force scale.
    """
    for i in range(3):
        motion[i] = (motion_limited[i] - frame[i]) / frame[3]
        motion[3 + i] = motion_limited[3 + i] / frame[3]
        f_env[i] = -frame[4] * f_env_on_tool_W[i]


class SlaveEnd(LeafSystem):
    """The end of a coupling at the slave.

    Input ports:
        packet_from_master (n_up)
        f_env_on_tool_W (3): force of the environment on the tool [N]
        motion_limited (6): p, v of the tool that the joints are truly asked for [m, m/s]
    Output ports, all discrete state:
        packet_to_master (n_down)
        tool_command (8): p_WE [m], quaternion w x y z of R_WE, mast height [m]
        energy_slave (6): given back by the slave (3), given to it (3) [J], in the master's units,
            at the port that the kind names
    Update (every period): the kernel of the kind, with the newest packet.
    Initial: the first command, the rest zero.

    Args:
        coupling: checked.
        period: [s].
        first_command: (8,).
        bandwidth: of the limiter that follows the commands [1/s].
    """

    def __init__(
        self, coupling: Coupling, period: float, first_command: ArrayLike, bandwidth: float
    ) -> None:
        super().__init__()
        coupling.validate("coupling")
        up, down, _, memory = coupling.sizes()
        self._kernel = coupling.kernels()[1]
        self._constants = coupling.constants(period, np.inf, bandwidth)
        first = np.array(first_command, dtype=np.float64)
        scales = [coupling.position_scale, coupling.force_scale]
        self._frame = np.concatenate([first[:3], scales])
        self._received = self.DeclareVectorInputPort("packet_from_master", up)
        self._f_env = self.DeclareVectorInputPort("f_env_on_tool_W", 3)
        self._motion = self.DeclareVectorInputPort("motion_limited", 6)
        self._sent = declare_state(self, down, "packet_to_master")
        self._command = declare_state(self, first, "tool_command")
        self._energy = declare_state(self, 6, "energy_slave")
        self._newest = declare_state(self, up)
        self._memory = declare_state(self, memory)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        motion_limited, packet = self._motion.Eval(context), self._received.Eval(context)
        force = self._f_env.Eval(context)
        if not (all_finite(motion_limited, packet) and all_finite(force, force)):
            check_finite(self, context, (self._received, self._f_env, self._motion))
        motion, f_env, command = np.empty(6), np.empty(3), np.empty(3)
        to_master_units(motion_limited, force, self._frame, motion, f_env)
        self._kernel(
            motion,
            f_env,
            packet,
            self._constants,
            discrete.get_mutable_value(self._newest),
            discrete.get_mutable_value(self._memory),
            discrete.get_mutable_value(self._sent),
            command,
            discrete.get_mutable_value(self._energy),
        )
        discrete.get_mutable_value(self._command)[:3] = self._frame[:3] + self._frame[3] * command

"""The two ends of a bilateral coupling: what a kind of coupling says, and the blocks made of it.

A kind is a dataclass with its gains, and an `Exchange`: the layouts of what it sends and remembers,
and its two laws. The blocks, their ports and what all laws share are the same for all, see
`kernels`.
"""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.block import Block, Declaration, Input, Kernel, Memory
from scara_drake.common.fields import check, number
from scara_drake.common.layout import Layout
from scara_drake.coupling.layouts import (
    MASTER_CONSTANTS,
    MASTER_MEMORY,
    METERS,
    MOTION,
    PACKET,
    SLAVE_CONSTANTS,
)
from scara_drake.vectors import Felt

Array = NDArray[np.float64]

FIRM = 1.0  # [N] at the tool, from which the contact damping acts in full


@dataclass(frozen=True)
class Exchange:
    """What a kind of coupling sends, remembers and does.

    Attributes:
        up: payload of a packet to the slave.
        down: payload of a packet to the master.
        master: law of a tick at the master; its arguments are those of `kernels.master_tick`, with
            which it begins.
        slave: law of a tick at the slave; its arguments are those of `kernels.slave_tick`, and
            ``tool_command`` and ``energy_slave``.
        master_memory: what the law at the master remembers; None for nothing.
        slave_memory: what the law at the slave remembers; None for nothing.
        uses_late: whether a packet is of use that comes after its time to be played, see
            `Playout`. A position that is late is still newer than the last; a wave is not asked
            for then.
        felt_up: which entries of the payload to the slave are perceived together, and as what, a
            name of `channel.codec.QUANTITIES`; without any, no codec can tell what to send.
        felt_down: the same of the payload to the master.
    """

    up: Layout
    down: Layout
    master: Kernel
    slave: Kernel
    master_memory: Layout | None = None
    slave_memory: Layout | None = None
    uses_late: bool = True
    felt_up: tuple[Felt, ...] = ()
    felt_down: tuple[Felt, ...] = ()

    def felt(self, direction: str) -> tuple[Felt, ...]:
        """What is perceived of a packet "up" or "down", by its entries."""
        felt = {"up": self.felt_up, "down": self.felt_down}[direction]
        head = PACKET.size
        return tuple(
            (slice(head + entries.start, head + entries.stop, entries.step), quantity)
            for entries, quantity in felt
        )

    @property
    def up_size(self) -> int:
        """Entries of a packet to the slave."""
        return PACKET.size + self.up.size

    @property
    def down_size(self) -> int:
        """Entries of a packet to the master."""
        return PACKET.size + self.down.size

    def master_start(self) -> Array:
        """Return the first memory at the master."""
        own = self.master_memory.size if self.master_memory else 0
        return MASTER_MEMORY.zeros(rest=np.zeros(self.down_size + own))

    def slave_start(self) -> Array:
        """Return the first memory at the slave."""
        own = self.slave_memory.size if self.slave_memory else 0
        return np.zeros(self.up_size + own)


@dataclass
class Coupling:
    """What all couplings have.

    Attributes:
        position_scale: way of the tool over that of the device.
        force_scale: force at the device over that at the tool.
        virtual_mass: of the tool, where the force of the coupling moves it.
        contact_damping: of that mass to the ground while something is touched; it stands in for
            what the lag of the robot takes from a stiff contact, and only dissipates.
    """

    position_scale: float = number(1.0, "1", 1e-3, 100.0)
    force_scale: float = number(1.0, "1", 1e-6, 100.0)
    virtual_mass: float = number(1.0, "kg", 0.1, 1e3)
    contact_damping: float = number(50.0, "N s/m", 0.0, 1e3)

    @property
    def impedance_scale(self) -> float:
        """Factor from an impedance at the tool to that in the master's units."""
        return self.position_scale * self.force_scale

    def reserves(self) -> float:
        """Energy [J] that an axis may give out beside what came in, in the master's units."""
        return 0.0

    def within(self, stiffness: float, damping: float) -> Self:
        """Return what is left of the coupling on a device that renders no more than these.

        A force that comes from the robot is not changed by what the device renders; only a kind
        that makes its force at the device has something to cut.

        Args:
            stiffness: largest that the device renders [N/m].
            damping: the same [N s/m].
        """
        return self

    def asked_stiffness(self, surface: float) -> float:
        """Return the stiffness [N/m] that a device is asked for where a surface [N/m] is touched.

        That of the surface, and of the coupling's spring before it where it has one.
        """
        spring = getattr(self, "stiffness", None)
        if spring is None or surface == 0.0:
            return self.impedance_scale * surface
        return self.impedance_scale * surface * spring / (surface + spring)

    def asked_damping(self) -> float:
        """Return the damping [N s/m] that the kind itself asks of the device."""
        return 0.0

    @abstractmethod
    def exchange(self) -> Exchange:
        """What the kind sends, remembers and does."""

    @abstractmethod
    def parameters(self, period: float) -> Array:
        """The gains of the kind, in the master's units, for both laws."""

    def make_master(self, period: float, actuator_limit: float = np.inf) -> "MasterEnd":
        """Return the end at the master; the limit of its device [N] is for the meters."""
        return MasterEnd(self, period, actuator_limit)

    def make_slave(
        self,
        period: float,
        first_command: ArrayLike,
        bandwidth: float = 30.0,
        hold: float = 0.0,
    ) -> "SlaveEnd":
        """Return the end at the slave.

        Args:
            period: [s].
            first_command: tool command (8,) of the master's centre.
            bandwidth: of the limiter that follows the commands [1/s], see `motion.limit_motion`.
            hold: silence up to which what was received last is still the same, as a codec says
                [s]; 0 where every packet is sent.
        """
        return SlaveEnd(self, period, first_command, bandwidth, hold)


class MasterEnd(Block):
    """The end of a coupling at the master.

    Ports:
        input motion_master (6) [m, m/s]: x_m, v_m of the device.
        input packet_from_slave (n_down).
        output packet_to_slave (n_up).
        output f_master (3) [N]: force of the device, before the limit of its actuators; positive
            resists.
        output energy_master (6) [J]: taken from the hand (3), given to it (3), at the device's
            port.

    Update, every period: the law of the kind, with the newest packet. Initial: zero. NaN or
    infinity on an input stops the run.

    Args:
        coupling: of some kind.
        period: [s].
        actuator_limit: of the device [N].

    Raises:
        ValueError: a field of the coupling is out of its bounds.
    """

    def __init__(self, coupling: Coupling, period: float, actuator_limit: float) -> None:
        check(coupling, "coupling")
        kind = coupling.exchange()
        constants = MASTER_CONSTANTS.pack(
            period=period, actuator_limit=actuator_limit, gains=coupling.parameters(period)
        )
        super().__init__(
            Declaration(
                inputs={
                    "motion_master": Input(MOTION.size, finite=True),
                    "packet_from_slave": Input(kind.down_size, finite=True),
                },
                memory={
                    "packet_to_slave": Memory(kind.up_size, port=True),
                    "f_master": Memory(3, port=True),
                    "energy_master": Memory(METERS.size, port=True),
                    "memory": Memory(kind.master_start()),
                },
                parameters={"constants": constants},
                period=period,
                update=kind.master,
            )
        )


class SlaveEnd(Block):
    """The end of a coupling at the slave.

    Ports:
        input packet_from_master (n_up).
        input f_env_on_tool_W (3) [N]: force of the environment on the tool.
        input motion_limited (6) [m, m/s]: p, v of the tool that the joints are truly asked for.
        output packet_to_master (n_down).
        output tool_command (8): p_WE [m], quaternion w x y z of R_WE, mast height [m].
        output energy_slave (6) [J]: given back by the slave (3), given to it (3), in the master's
            units, at the port that the kind names.

    Update, every period: the law of the kind, with the newest packet. Initial: the first command,
    the rest zero. NaN or infinity on an input stops the run.

    Args:
        coupling: of some kind.
        period: [s].
        first_command: (8,).
        bandwidth: of the limiter that follows the commands [1/s].
        hold: silence up to which what was received last stands [s].

    Raises:
        ValueError: a field of the coupling is out of its bounds.
    """

    def __init__(
        self,
        coupling: Coupling,
        period: float,
        first_command: ArrayLike,
        bandwidth: float,
        hold: float = 0.0,
    ) -> None:
        check(coupling, "coupling")
        kind = coupling.exchange()
        first = np.array(first_command, dtype=np.float64)
        scale = coupling.impedance_scale
        constants = SLAVE_CONSTANTS.pack(
            period=period,
            bandwidth=bandwidth,
            hold=hold,
            mass=scale * coupling.virtual_mass,
            grip=scale * coupling.contact_damping,
            firm=coupling.force_scale * FIRM,
            position_scale=coupling.position_scale,
            force_scale=coupling.force_scale,
            p_first=first[:3],
            gains=coupling.parameters(period),
        )
        super().__init__(
            Declaration(
                inputs={
                    "packet_from_master": Input(kind.up_size, finite=True),
                    "f_env_on_tool_W": Input(3, finite=True),
                    "motion_limited": Input(MOTION.size, finite=True),
                },
                memory={
                    "packet_to_master": Memory(kind.down_size, port=True),
                    "tool_command": Memory(first, port=True),
                    "energy_slave": Memory(METERS.size, port=True),
                    "memory": Memory(kind.slave_start()),
                },
                parameters={"constants": constants},
                period=period,
                update=kind.slave,
            )
        )

r"""The dead-band codec: a packet is sent when a hand could feel what is new in it.

In kind that of IEEE 1918.1.1 (2024): by Weber's law a change is felt from a share k of what is
there, so a vector x is sent when

.. math::

    |x - x_\text{sent}| > \max(k\,|x_\text{sent}|,\; \text{floor})

with the norm of all its axes together, as the dead zone of Hirche and Hinterseer (2008) is a ball;
the floor keeps noise around zero from being sent. Silence then means "as before, within k". After
`keep_alive` a packet is sent anyway, so that a lost one is made good, and an end that is silent can
be told from one that is cut off.

The codec leaves the packet as it is. Couplings that account for energy send the sum of it, so what
came in over samples that were not sent is in the next packet; until then the receiver knows less
than there is, and gives out less.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import ABOVE_ZERO, check, number
from scara_drake.common.layout import REST, Cell, Layout

Array = NDArray[np.float64]

# Which entries of a packet are felt together, and what they are, a name of `QUANTITIES`.
Felt = tuple[slice, str]


@dataclass
class DeadBand:
    """Which packets are sent: those with news that can be felt, and the keep-alives.

    The floors are those of the hand, in the master's units. Positions have no Weber's law, only the
    floor; waves have that of a floor of speed under one of force, models of surfaces those of one
    over the other.

    Attributes:
        k_up: share of what goes to the robot, from which a change is sent.
        k_down: the same of what comes back.
        speed: floor of velocities.
        force: floor of forces.
        place: floor of positions.
        keep_alive: longest time without a packet.
    """

    k_up: float = number(0.1, "1", 0.0, 0.9)
    k_down: float = number(0.1, "1", 0.0, 0.9)
    speed: float = number(1e-3, "m/s", ABOVE_ZERO, 1.0)
    force: float = number(0.05, "N", ABOVE_ZERO, 100.0)
    place: float = number(1e-4, "m", ABOVE_ZERO, 0.1)
    keep_alive: float = number(0.05, "s", ABOVE_ZERO, 10.0)

    def bands(self, direction: str, felt: Sequence[Felt]) -> Array:
        """Return a `Band` for each of what is felt in a packet "up" or "down", in a row (n,)."""
        k = {"up": self.k_up, "down": self.k_down}[direction]
        return np.concatenate(
            [
                BAND.pack(
                    first=entries.start,
                    end=entries.stop,
                    step=entries.step or 1,
                    k=0.0 if quantity in ABSOLUTE else k,
                    floor=QUANTITIES[quantity](self),
                )
                for entries, quantity in felt
            ]
        )


# The floor of each quantity.
QUANTITIES: Final[dict[str, Callable[[DeadBand], float]]] = {
    "speed": lambda band: band.speed,
    "force": lambda band: band.force,
    "place": lambda band: band.place,
    "wave": lambda band: math.sqrt(band.force * band.speed),
    "stiffness": lambda band: band.force / band.place,
    "damping": lambda band: band.force / band.speed,
    "side": lambda band: 0.0,  # any change
}
ABSOLUTE: Final = ("place",)


class Band(NamedTuple):
    """What is felt together: entries first, first + step, ... before `end`; share and floor."""

    first: float
    end: float
    step: float
    k: float
    floor: float


class Sent(NamedTuple):
    """Memory of the codec.

    Attributes:
        ticks: so far.
        silent: ticks since a packet was sent; infinite before the first.
        packet: that was sent last.
    """

    ticks: Cell
    silent: Cell
    packet: Array


BAND, SENT = Layout(Band), Layout(Sent, ticks=(), silent=(), packet=REST)
BAND_SIZE = BAND.size
band_of, sent_of = BAND.reader(), SENT.reader()


@njit(cache=True)
def is_felt(packet: Array, sent: Array, bands: Array) -> bool:
    """Whether a packet (n,) has news beside the one sent last (n,), by its bands, see `Band`."""
    rows = bands.reshape((-1, BAND_SIZE))
    for index in range(rows.shape[0]):
        b = band_of(rows[index])
        change, size = 0.0, 0.0
        for i in range(int(b.first), int(b.end), int(b.step)):
            change += (packet[i] - sent[i]) ** 2
            size += sent[i] ** 2
        if math.sqrt(change) > max(b.k * math.sqrt(size), b.floor):
            return True
    return False


@njit(cache=True)
def ask(
    packet: Array, bands: Array, keep_alive: float, stride: int, sent: Array, transmit: Array
) -> None:
    """Write whether the packet is sent, 1 or 0 (1,).

    Args:
        packet: (n,).
        bands: see `Band`.
        keep_alive: ticks in the longest silence.
        stride: ticks in a send period.
        sent: memory, see `Sent`.
        transmit: (1,).
    """
    m = sent_of(sent)
    transmit[0] = 0.0
    if int(m.ticks[()]) % stride == 0:
        late = m.silent[()] + stride > keep_alive  # the next tick at which one can be sent
        if late or is_felt(packet, m.packet, bands):
            transmit[0] = 1.0


@njit(cache=True)
def step_codec(packet: Array, bands: Array, keep_alive: float, stride: int, sent: Array) -> None:
    """One tick of `Codec`: remember what is sent."""
    m, transmit = sent_of(sent), np.empty(1)
    ask(packet, bands, keep_alive, stride, sent, transmit)
    m.ticks[()] += 1.0
    m.silent[()] += 1.0
    if transmit[0] > 0.0:
        m.silent[()] = 1.0
        m.packet[:] = packet


class Codec(Block):
    """Says of each packet whether it is sent, for a selective `PacketChannel`.

    Ports:
        input packet (n).
        output transmit (1): 1 where it is sent, 0 where not; of the same instant.

    Update, at t = k period, where `transmit` is 1: the packet is remembered as the one sent last.
    Initial: nothing was sent, so the first one is.

    Args:
        config: checked.
        direction: "up" or "down".
        felt: which entries of a packet are felt, one or more.
        size: entries of a packet, n.
        period: [s].
        send_period: of the link, a multiple of the period [s]; no packet is sent between.

    Raises:
        ValueError: a field is out of its bounds.
    """

    def __init__(
        self,
        config: DeadBand,
        direction: str,
        felt: Sequence[Felt],
        size: int,
        period: float = 1e-3,
        send_period: float = 1e-3,
    ) -> None:
        check(config, "codec")
        super().__init__(
            Declaration(
                inputs={"packet": Input(size)},
                memory={"sent": Memory(SENT.zeros(silent=np.inf, packet=np.zeros(size)))},
                outputs={"transmit": Output(1, ask)},
                parameters={
                    "bands": config.bands(direction, felt),
                    "keep_alive": round(config.keep_alive / period),
                    "stride": round(send_period / period),
                },
                period=period,
                update=step_codec,
            )
        )

r"""The dead-band codec: a packet is sent when a hand could feel what is new in it.

In kind that of IEEE 1918.1.1 (2024): by Weber's law a change is felt from a share k of what is
there, so a vector x is sent when

.. math::

    |x - x_\text{sent}| > \max(k\,|x_\text{sent}|,\; \text{floor})

with the norm of all its axes together, as the dead zone of Hirche and Hinterseer (2008) is a ball;
the floor keeps noise around zero from being sent. Silence then means "as before, within k". After
`keep_alive` a packet is sent anyway, so that a lost one is made good, and an end that is silent can
be told from one that is cut off.

A packet has all axes, so one that is sent for one of them would carry what cannot be felt on the
others. It does not: such an entry is sent as it was sent last, and one within the floor of zero as
zero. A loop whose gain is above one over a long delay would grow from that.

All else in a packet is sent as it is. Couplings that account for energy send the sum of it, so what
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
from scara_drake.vectors import Felt

Array = NDArray[np.float64]


@dataclass
class DeadBand:
    """Which packets are sent: those with news that can be felt, and the keep-alives.

    The floors are those of the hand, in the master's units. Positions have no Weber's law, only the
    floor. That of waves is where the power is that of both floors, those of models of surfaces
    where it takes 1 cm, or 0.1 m/s, to make the floor of force.

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
        return np.concatenate([self._band(k, *together) for together in felt])

    def _band(self, k: float, entries: slice, quantity: str) -> Array:
        step, floor, absolute = entries.step or 1, QUANTITIES[quantity](self), quantity in ABSOLUTE
        share = floor / math.sqrt(len(range(entries.start, entries.stop, step)))
        return BAND.pack(
            first=entries.start,
            end=entries.stop,
            step=step,
            k=0.0 if absolute else k,
            floor=floor,
            noise=-1.0 if absolute else share,
        )


WAY, PACE = 0.01, 0.1  # [m], [m/s]
# The floor of each quantity.
QUANTITIES: Final[dict[str, Callable[[DeadBand], float]]] = {
    "speed": lambda band: band.speed,
    "force": lambda band: band.force,
    "place": lambda band: band.place,
    "wave": lambda band: math.sqrt(band.force * band.speed),
    "stiffness": lambda band: band.force / WAY,
    "damping": lambda band: band.force / PACE,
    "side": lambda band: 0.0,  # any change
}
ABSOLUTE: Final = ("place",)


class Band(NamedTuple):
    """What is felt together.

    Attributes:
        first: entry; the next are `step` further each, before `end`.
        end: see there.
        step: see there.
        k: share of the norm, from which a change is felt.
        floor: smallest change of the norm that is felt.
        noise: size up to which an entry is zero; below zero, where zero is one place among others.
    """

    first: float
    end: float
    step: float
    k: float
    floor: float
    noise: float


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
def norms(packet: Array, sent: Array, band: Band) -> tuple[float, float, float]:
    """Return |x - x_sent|, the bound above which that is felt, and of how many entries they are."""
    change, size, count = 0.0, 0.0, 0.0
    for i in range(int(band.first), int(band.end), int(band.step)):
        change += (packet[i] - sent[i]) ** 2
        size += sent[i] ** 2
        count += 1.0
    return math.sqrt(change), max(band.k * math.sqrt(size), band.floor), count


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
    m, rows = sent_of(sent), bands.reshape((-1, BAND_SIZE))
    transmit[0] = 0.0
    if int(m.ticks[()]) % stride != 0:
        return
    if m.silent[()] + stride > keep_alive:  # the next packet would come too late
        transmit[0] = 1.0
    for index in range(rows.shape[0]):
        change, bound, _ = norms(packet, m.packet, band_of(rows[index]))
        if change > bound:
            transmit[0] = 1.0


@njit(cache=True)
def encode(packet: Array, bands: Array, sent: Array, packet_sent: Array) -> None:
    """Write the packet as it would be sent (n,): what cannot be felt in it is as it was sent last.

    That is a change of an entry below the bound over the root of how many are felt together: of a
    change that is felt at least one is above.
    """
    m, rows = sent_of(sent), bands.reshape((-1, BAND_SIZE))
    packet_sent[:] = packet
    for index in range(rows.shape[0]):
        b = band_of(rows[index])
        _, bound, count = norms(packet, m.packet, b)
        for i in range(int(b.first), int(b.end), int(b.step)):
            if abs(packet[i]) <= b.noise:
                packet_sent[i] = 0.0
            elif abs(packet[i] - m.packet[i]) <= bound / math.sqrt(count):
                packet_sent[i] = m.packet[i]


@njit(cache=True)
def step_codec(packet: Array, bands: Array, keep_alive: float, stride: int, sent: Array) -> None:
    """One tick of `Codec`: remember what is sent."""
    m, transmit, packet_sent = sent_of(sent), np.empty(1), np.empty(packet.size)
    ask(packet, bands, keep_alive, stride, sent, transmit)
    m.ticks[()] += 1.0
    m.silent[()] += 1.0
    if transmit[0] > 0.0:
        encode(packet, bands, sent, packet_sent)
        m.silent[()] = 1.0
        m.packet[:] = packet_sent


class Codec(Block):
    """Says of each packet whether it is sent, for a selective `PacketChannel`, and as what.

    Ports:
        input packet (n).
        output transmit (1): 1 where it is sent, 0 where not; of the same instant.
        output packet_sent (n): the packet without what cannot be felt; of the same instant.

    Update, at t = k period, where `transmit` is 1: packet_sent is remembered as sent last.
    Initial: nothing was sent, so the first packet is.

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
                outputs={"transmit": Output(1, ask), "packet_sent": Output(size, encode)},
                parameters={
                    "bands": config.bands(direction, felt),
                    "keep_alive": round(config.keep_alive / period),
                    "stride": round(send_period / period),
                },
                period=period,
                update=step_codec,
            )
        )

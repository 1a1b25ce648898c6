"""Where the radio is worse: a part of the cell in which packets take longer and more are lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.channel.delays import LONGEST
from scara_drake.channel.layouts import radio_of
from scara_drake.common.block import Block, Declaration, Input, Output
from scara_drake.common.fields import ABOVE_ZERO, check, number, vector
from scara_drake.common.layout import Layout

Array = NDArray[np.float64]

FAR = 1e3  # [m]


@dataclass
class Shadow:
    """A box of the cell where the radio is worse, such as what lies behind a wall.

    While the tool is in it, packets take `delay` more and are lost with a chance of `loss` beside
    that of the link. Both come in smoothly from a face of the box to `edge` inside of it. A box
    that reaches far is a half-space.

    Attributes:
        low: corner of the box in W.
        high: the corner across.
        edge: way over which the shadow comes in.
        delay: that a packet takes more in the depth of it.
        loss: chance there that one is lost.
    """

    low: list[float] = vector([-FAR, -FAR, -FAR], "m", -FAR, FAR)
    high: list[float] = vector([FAR, FAR, FAR], "m", -FAR, FAR)
    edge: float = number(0.05, "m", ABOVE_ZERO, 10.0)
    delay: float = number(0.02, "s", 0.0, LONGEST)
    loss: float = number(0.1, "1", 0.0, 1.0)

    def check_together(self, name: str) -> None:
        """Check that the corners are some.

        Raises:
            ValueError: `high` is not above `low` on some axis.
        """
        for axis, (low, high) in enumerate(zip(self.low, self.high, strict=True)):
            if high <= low:
                raise ValueError(
                    f"{name}.high[{axis}]: {high:g}, allowed above {low:g} ({name}.low)"
                )

    def parameters(self) -> Array:
        """Return the fields as `shade` takes them."""
        return SHADE.pack(
            low=self.low, high=self.high, edge=self.edge, delay=self.delay, loss=self.loss
        )


class Shade(NamedTuple):
    """`Shadow` in a kernel."""

    low: Array
    high: Array
    edge: float
    delay: float
    loss: float


SHADE = Layout(Shade, low=3, high=3)
shade_of = SHADE.reader()


@njit(cache=True)
def shade(place: Array, shadow: Array) -> float:
    """Share 0 to 1 of the shadow at a place (3,) [m]: 3 s² - 2 s³ of the depth over the edge."""
    p = shade_of(shadow)
    inside = np.inf
    for i in range(3):
        inside = min(inside, place[i] - p.low[i], p.high[i] - place[i])
    share = min(max(inside / p.edge, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


@njit(cache=True)
def show_radio(place: Array, transmit: Array, shadow: Array, radio: Array) -> None:
    """Write what the radio does to a packet that is sent now, see `layouts.Radio`."""
    p, r, share = shade_of(shadow), radio_of(radio), shade(place, shadow)
    r.transmit[()], r.delay[()], r.loss[()] = transmit[0], share * p.delay, share * p.loss


class RadioShadow(Block):
    """Says what the tool's place does to the packets of a link.

    Ports:
        input place (3): p_WE of the tool [m].
        input transmit (1): of a codec before the link; 1 where it is not connected.
        output radio (3): for the input `transmit` of a `PacketChannel`; of the same instant.

    Args:
        shadow: checked.

    Raises:
        ValueError: a field is out of its bounds.
    """

    def __init__(self, shadow: Shadow) -> None:
        check(shadow, "shadow")
        super().__init__(
            Declaration(
                inputs={"place": Input(3), "transmit": Input(1, default=(1.0,))},
                outputs={"radio": Output(3, show_radio)},
                parameters={"shadow": shadow.parameters()},
            )
        )

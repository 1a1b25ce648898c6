"""The watch over the channel: whether commands arrive, and whether it gives energy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import check
from scara_drake.common.layout import Layout
from scara_drake.safety import Reason
from scara_drake.supervision.config import RobotSupervision
from scara_drake.supervision.layouts import (
    CHANNEL_ENERGY,
    LINK_CONDITION,
    channel_energy_of,
    link_condition_of,
)

Array = NDArray[np.float64]

NONE, GIVES_ENERGY = float(Reason.NONE), float(Reason.CHANNEL_ENERGY)


class LinkBounds(NamedTuple):
    """Of `RobotSupervision`: `age_limit` [s], `energy` [J]."""

    age_limit: float
    energy: float


LINK_BOUNDS = Layout(LinkBounds)
link_bounds_of = LINK_BOUNDS.reader()


@njit(cache=True)
def watch_link(
    age: Array,
    delay: Array,
    channel_energy: Array,
    bounds: Array,
    forgiven: Array,
    link_condition: Array,
) -> None:
    """One tick of `LinkWatch`, in place."""
    b, link = link_bounds_of(bounds), link_condition_of(link_condition)
    energy = channel_energy_of(channel_energy)
    link.lost[()] = 1.0 if age[0] - delay[0] > b.age_limit else 0.0
    given = energy.given[()] - energy.taken[()]
    link.fault[()] = NONE
    if given - forgiven[0] > b.energy:
        link.fault[()], forgiven[0] = GIVES_ENERGY, given


class LinkWatch(Block):
    """Tells whether the command is lost, and whether the channel gives more than it took.

    Ports:
        input age (1), delay (1) [s]: of the packet in use; zero where unconnected: a link without
            packets loses none.
        input channel_energy (2) [J]: see `ChannelEnergy`; zero where unconnected.
        output link_condition (2): see `layouts.LinkCondition`.

    Update, at t = k period: lost where age - delay, the time since the packet in use arrived,
    exceeds `age_limit`; a fault, for a tick, where what the channel gave exceeds what it took by
    more than `energy_bound`, from then on counted afresh. Initial: neither.

    Args:
        config: checked.
        period: [s].

    Raises:
        ValueError: a field is out of its bounds.
    """

    def __init__(self, config: RobotSupervision, period: float = 1e-3) -> None:
        check(config, "supervision.robot")
        super().__init__(
            Declaration(
                inputs={
                    "age": Input(1, default=(0.0,)),
                    "delay": Input(1, default=(0.0,)),
                    "channel_energy": Input(CHANNEL_ENERGY.size, default=(0.0, 0.0)),
                },
                memory={
                    "link_condition": Memory(LINK_CONDITION.size, port=True),
                    "forgiven": Memory(1),
                },
                parameters={
                    "bounds": LINK_BOUNDS.pack(
                        age_limit=config.age_limit, energy=config.energy_bound
                    )
                },
                period=period,
                update=watch_link,
            )
        )

"""Imperfect drives: encoders, the lag of the actuators, and friction in the joints.

They sit between the plant and the controller and add no tick to the loop (see "One tick" in
docs/architecture.md): what they show belongs to what the plant and the controller show now.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.fields import vector
from scara_drake.common.layout import Layout
from scara_drake.plant.encoder import Encoder
from scara_drake.plant.friction import JointFriction

Array = NDArray[np.float64]


@dataclass
class ActuatorLag:
    """First-order lag of the drives' efforts; 0.3 ms is a current loop of 500 Hz.

    Attributes:
        time_constant: of each drive; 0 is none.
    """

    time_constant: list[float] = vector([3e-4] * 6, "s", 0.0, 10.0)

    def parameters(self, period: float) -> Array:
        """Return the lag over a period [s] as `lag_of` reads it."""
        time_constant = np.array(self.time_constant, dtype=np.float64)
        periods = period / np.maximum(time_constant, 1e-9)  # below a nanosecond there is no lag
        return LAG.pack(decay=np.exp(-periods), mean=-np.expm1(-periods) / periods)

    def make_system(self, period: float) -> "ActuatorLagSystem":
        """Return the lag, sampled every `period` [s]."""
        return ActuatorLagSystem(self, period)


class Lag(NamedTuple):
    """The lag of a period h: exp(-h / T), and its mean over the period (1 - exp(-h / T)) T / h."""

    decay: Array
    mean: Array


LAG = Layout(Lag, decay=6, mean=6)
lag_of = LAG.reader()


@njit(cache=True)
def lag_step(actuation: Array, lag: Array, tau: Array) -> None:
    """Move the drives' efforts (6,) by one period towards those asked for (6,), in place."""
    decay = lag_of(lag).decay
    for i in range(6):
        u = actuation[i]
        tau[i] = u + decay[i] * (tau[i] - u)


@njit(cache=True)
def deliver(actuation: Array, lag: Array, tau: Array, actuation_delivered: Array) -> None:
    """Write the mean efforts (6,) over the period that begins."""
    mean = lag_of(lag).mean
    for i in range(6):
        u = actuation[i]
        actuation_delivered[i] = u + mean[i] * (tau[i] - u)


class ActuatorLagSystem(Block):
    """First-order lag of the efforts, T tau' = u - tau, exact for a held u.

    Ports:
        input actuation (6) [N, N m]: u, the effort asked for.
        output actuation_delivered (6) [N, N m], of the input and of the memory: mean of tau over
            the step of the plant that it drives, hence with the impulse of tau,
            u + (tau - u) (1 - exp(-h / T)) T / h.

    Update, at t = k h: tau <- u + (tau - u) exp(-h / T). Initial: tau = 0, the drives are at rest.

    Args:
        lag: checked.
        period: h [s].
    """

    def __init__(self, lag: ActuatorLag, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={"actuation": Input(6)},
                memory={"tau": Memory(6)},
                outputs={"actuation_delivered": Output(6, deliver)},
                parameters={"lag": lag.parameters(period)},
                period=period,
                update=lag_step,
            )
        )


@dataclass
class Drives:
    """What the drives and the sensors do to the loop; None is the ideal part.

    Attributes:
        encoder: what the controller sees of the joints.
        lag: of the efforts.
        friction: of the joints.
    """

    encoder: Encoder | None = None
    lag: ActuatorLag | None = None
    friction: JointFriction | None = None

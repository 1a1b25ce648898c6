"""The socket of a joint controller: its ports, its events, and the checks of what arrives."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import (
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
)

from scara_drake.common.finite import all_finite, check_finite
from scara_drake.common.state import declare_state

Array = NDArray[np.float64]

# Bits of the port `saturation`.
OUTSIDE_LAYER, EFFORT_LIMIT = 1, 2


@njit(cache=True)
def limit_effort(
    tau: Array, effort: Array, outside: Array, tau_limited: Array, saturation: Array
) -> None:
    """Write tau within its limits (n,), and the bits of `saturation` (n,).

    Args:
        tau: before the limits (n,) [N, N m].
        effort: limits (n,) [N, N m].
        outside: |s| / phi (n,); 1 or more is outside the boundary layer.
        tau_limited: written.
        saturation: written; 0, OUTSIDE_LAYER, EFFORT_LIMIT or their sum.
    """
    for i in range(tau.size):
        tau_limited[i] = min(max(tau[i], -effort[i]), effort[i])
        saturation[i] = 0.0
        if outside[i] >= 1.0:
            saturation[i] += OUTSIDE_LAYER
        if tau_limited[i] != tau[i]:
            saturation[i] += EFFORT_LIMIT


class JointController(LeafSystem):
    """A sampled controller of the six joints; a law is added by `start` and `sample`.

    Input ports:
        state (12): q, v measured [m, rad, m/s, rad/s]
        state_desired (12): q, v references
        engaged (1): optional, engaged if not connected; below 0.5 the drives are off: no effort,
            and the law starts afresh at every period, so that it takes over without a jump
    Output ports, all discrete state:
        actuation (6): effort within the limits of the drives [N, N m]
        actuation_commanded (6): effort before the limits
        saturation (6): 0, or the sum of 1 (outside the boundary layer) and 2 (effort limit)
    Update (every period): the law, see `sample`.
    Initial: see `start`.

    Args:
        period: [s].
    """

    def __init__(self, period: float):
        super().__init__()
        self.period = period
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("state_desired", 12)
        self._engaged = self.DeclareVectorInputPort("engaged", 1)
        self.tau_limited = declare_state(self, 6, "actuation")
        self.tau = declare_state(self, 6, "actuation_commanded")
        self.saturation = declare_state(self, 6, "saturation")
        self.DeclareInitializationDiscreteUpdateEvent(self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    @abstractmethod
    def start(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Write the memory and the outputs of a law that begins now.

        Args:
            desired: references (12,) of this instant.
            state: measured (12,), of the same instant.
            discrete: holds all memory and outputs.
        """

    @abstractmethod
    def sample(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Advance the law by one period.

        A sampled plant has stepped before its controller is updated, so `state` is one period
        younger than `desired`: a law carries the references one period along their velocity.
        """

    def _start(self, context: Context, discrete: DiscreteValues) -> EventStatus:
        self.start(*self._inputs(context), discrete)
        if not self._is_engaged(context):
            self._release(discrete)
        return EventStatus.Succeeded()

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        desired, state = self._inputs(context)
        if self._is_engaged(context):
            self.sample(desired, state, discrete)
        else:
            carried = desired.copy()
            carried[:6] += self.period * desired[6:]
            self.start(carried, state, discrete)
            self._release(discrete)

    def _inputs(self, context: Context) -> tuple[Array, Array]:
        desired, state = self._desired.Eval(context), self._state.Eval(context)
        if not all_finite(desired, state):
            check_finite(self, context, (self._state, self._desired))
        return desired, state

    def _is_engaged(self, context: Context) -> bool:
        port = self._engaged
        return not port.HasValue(context) or port.Eval(context)[0] >= 0.5

    def _release(self, discrete: DiscreteValues) -> None:
        for group in (self.tau_limited, self.tau, self.saturation):
            discrete.get_mutable_value(group)[:] = 0.0

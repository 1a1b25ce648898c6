"""Integral sliding mode control with a sliding perturbation observer (SMCSPO).

With the estimates of `perturbation_observer` in place of the state, e^ = q_d - x1^ and
e^' = v_d - x2^::

    sigma^ = e^' + c e^
    s^     = sigma^ - z,  z' = -k sigma^
    u      = c e^' + k sigma^ + rho sat(s^ / phi) - Psi^
    tau    = m_hat u                  limited to the drive's effort

With exact estimates sigma' = q_d'' - k sigma - rho sat(s / phi), whatever the load: rho has to
cover the error of the estimate, and the reference's acceleration unless that is fed forward, but
not the perturbation. Positions are measured, velocities are not. The paper names this observer as
future work; it is that of Moura, Elmali and Olgac (1997).
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiscreteValues, EventStatus

from scara_drake import joints, robot
from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.control.chatter import check_chatter
from scara_drake.control.controller import JointController
from scara_drake.control.integral_sliding_mode import (
    M_HAT,
    C,
    ismc_law,
    sliding_surface,
)
from scara_drake.control.perturbation_observer import lag_step, observer_gains, observer_step

Array = NDArray[np.float64]

# Largest pole times T_s. The chatter rule is that of an exact velocity; faster observers leave it
# less than its 2, down to 1.3 where the product is 1.
FASTEST = 0.5


@njit(cache=True)
def observer_law(
    state_desired: Array,
    state: Array,
    acceleration: Array,
    gains: Array,
    observer: Array,
    period: float,
    begin: bool,
    memory: Array,
    x2: Array,
    psi: Array,
    lagged: Array,
    s: Array,
    tau: Array,
    tau_limited: Array,
    saturation: Array,
) -> None:
    """Observe one sample and apply the law to the estimates; write from memory on, n joints.

    The observer takes the effort that acted during the past period from `tau_limited`, before the
    law overwrites it: so it knows of the drives' limits.

    Args:
        state_desired: q, v references (2n,).
        state: measured (2n,); only the positions are looked at.
        acceleration: of the reference (n,), or zero [m/s², rad/s²].
        gains: (7, n), see `ismc_law`.
        observer: (4, n), see `observer_gains`.
        period: [s].
        begin: start on the sliding surface, z = sigma^, with a reference of the same instant as
            the state; otherwise the reference is one period old, and is carried along its velocity.
        memory: (4n,): estimate of the position, z of `ismc_law`, and x1, x2 of `lag_step`.
        x2: estimate of the velocity (n,).
        psi: of the perturbation [m/s², rad/s²].
        lagged: effort, as old as psi [N, N m].
        s: s^.
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    n = psi.size
    m_hat = gains[M_HAT]
    x1, z = memory[:n], memory[n : 2 * n]
    observer_step(state[:n], tau_limited / m_hat, observer, period, x1, x2, psi)
    lag_step(tau_limited, observer, period, memory[2 * n : 3 * n], memory[3 * n :], lagged)
    sigma, feedforward = np.empty(n), np.empty(n)
    lead = 0.0 if begin else period
    sliding_surface(state_desired, np.concatenate((x1, x2)), gains[C], lead, sigma)
    for i in range(n):
        rate = state_desired[n + i] - x2[i]
        feedforward[i] = m_hat[i] * (gains[C, i] * rate - psi[i] + acceleration[i])
        if begin:
            z[i] = sigma[i]
    ismc_law(sigma, gains, lead, feedforward, z, s, tau, tau_limited, saturation)


def _six(value: float) -> list[float]:
    return [value] * 6


@dataclass
class ObserverSlidingMode:
    """Gains of the law and of its observer per joint.

    The slopes c and k are those of Table 12; rho is a tenth of it, for the observer does the rest.

    Attributes:
        c: slope of the sliding surface [1/s].
        k: gain of the nominal part [1/s].
        rho: gain of the discontinuous part [m/s², rad/s²].
        phi: boundary layer of s^ [m/s, rad/s].
        pole: triple pole of the observer [1/s].
        eps: layer of the observer [m, rad]. A step of Psi leaves it above 2.7 eps pole² where
            pole T_s is 0.2, and above 3.7 eps pole² where that is small.
        anti_windup: |s^| is clamped to 2 phi.
        acceleration_feedforward: the reference's acceleration is added to u.
        allow_chatter: gains that break the rule of `chatter` are accepted.
    """

    c: list[float] = field(default_factory=lambda: [50.0, 50.0, 50.0, 40.0, 10.0, 10.0])
    k: list[float] = field(default_factory=lambda: [150.0, 100.0, 100.0, 75.0, 40.0, 20.0])
    rho: list[float] = field(default_factory=lambda: [50.0, 15.0, 15.0, 12.0, 10.0, 10.0])
    phi: list[float] = field(default_factory=lambda: _six(1.0))
    pole: list[float] = field(default_factory=lambda: _six(200.0))
    eps: list[float] = field(default_factory=lambda: _six(0.005))
    anti_windup: bool = True
    acceleration_feedforward: bool = False
    allow_chatter: bool = False

    def validate(self, name: str) -> None:
        """Check the gains; `name` is the field's path in the scenario.

        Raises:
            ValueError: a gain is negative or not finite, or phi, pole or eps is not positive.
        """
        for gain in ("c", "k", "rho"):
            checks.vector(f"{name}.{gain}", getattr(self, gain), 6, 0.0)
        for width in ("phi", "pole", "eps"):
            checks.vector(f"{name}.{width}", getattr(self, width), 6, checks.ABOVE_ZERO)

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the observer is slow enough for this period [s] and the law does not chatter.

        The law's slope, by which the chatter rule goes, has c beside k and rho / phi.

        Raises:
            ValueError: a pole above 0.5 / period; or the gains chatter, and `allow_chatter` is not
                set.
        """
        checks.vector(f"{name}.pole", self.pole, 6, checks.ABOVE_ZERO, FASTEST / period)
        if not self.allow_chatter:
            m_hat, rho, phi = robot.nominal_inertias(), np.array(self.rho), np.array(self.phi)
            check_chatter(name, m_hat, np.add(self.k, self.c), rho, phi, period)

    def array(self) -> Array:
        """Return the gains of the law as `ismc_law` takes them (7, 6)."""
        phi = np.array(self.phi)
        clamp = 2.0 * phi if self.anti_windup else np.full(6, np.inf)
        rows = [
            self.c, self.k, self.rho, phi, robot.nominal_inertias(), joints.EFFORT, clamp,
        ]  # fmt: skip
        return np.array(rows, dtype=np.float64)

    def make_system(self, period: float) -> "ObserverSlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return ObserverSlidingModeController(self, period)


class ObserverSlidingModeController(JointController):
    """Integral sliding mode control of the six joints on estimated states.

    Ports: those of `JointController`, of whose `state` the velocities are not used but have to be
        finite; and the outputs, all discrete state:
        sliding_variable (6): s^ [m/s, rad/s]
        velocity_estimate (6): [m/s, rad/s]
        perturbation_estimate (6): Psi^ [m/s², rad/s²]
        actuation_lagged (6): effort as late as Psi^ sees a perturbation [N, N m]
    Update (every period): see `observer_law`. The sampled plant has stepped before, so the position
        is that at the end of the period in which the effort on `actuation` acted.
    Initial: at rest in the measured position with Psi^ = 0, and z = sigma^, hence s^ = 0.
    While not engaged: the observer runs on, with no effort, and z = sigma^. So the drives take over
        an arm that moves without a jump.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: ObserverSlidingMode, period: float = 1e-3):
        super().__init__(period)
        self._gains = gains.array()
        self._observer = observer_gains(gains.pole, gains.eps, period)
        self._s = declare_state(self, 6, "sliding_variable")
        self._x2 = declare_state(self, 6, "velocity_estimate")
        self._psi = declare_state(self, 6, "perturbation_estimate")
        self._lagged = declare_state(self, 6, "actuation_lagged")
        self._memory = declare_state(self, 24)
        self._v_desired = declare_state(self, 6) if gains.acceleration_feedforward else None
        self._none = np.zeros(6)

    def _start(self, context: Context, discrete: DiscreteValues) -> EventStatus:
        # From these estimates the observer's first step, without effort, is none.
        for group in (self._memory, self._x2, self._psi, self._lagged, self.tau_limited):
            discrete.get_mutable_value(group)[:] = 0.0
        discrete.get_mutable_value(self._memory)[:6] = self._state.Eval(context)[:6]
        return super()._start(context, discrete)

    def start(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Observe, and begin on the sliding surface; both states are of one instant."""
        if self._v_desired is not None:
            discrete.get_mutable_value(self._v_desired)[:] = desired[6:]
        self._apply(desired, state, self._none, True, discrete)

    def sample(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Observe, and apply the law; the reference is one period old."""
        acceleration = self._none
        if self._v_desired is not None:
            before = discrete.get_mutable_value(self._v_desired)
            acceleration = (desired[6:] - before) / self.period
            before[:] = desired[6:]
        self._apply(desired, state, acceleration, False, discrete)

    def _apply(
        self,
        desired: Array,
        state: Array,
        acceleration: Array,
        begin: bool,
        discrete: DiscreteValues,
    ) -> None:
        observer_law(
            desired,
            state,
            acceleration,
            self._gains,
            self._observer,
            self.period,
            begin,
            discrete.get_mutable_value(self._memory),
            discrete.get_mutable_value(self._x2),
            discrete.get_mutable_value(self._psi),
            discrete.get_mutable_value(self._lagged),
            discrete.get_mutable_value(self._s),
            discrete.get_mutable_value(self.tau),
            discrete.get_mutable_value(self.tau_limited),
            discrete.get_mutable_value(self.saturation),
        )

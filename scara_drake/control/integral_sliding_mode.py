"""Integral sliding mode control of all joints at once, equations (27) to (47) of the paper.

With e = q_d - q the law is::

    sigma = e' + c e                    (28)
    s     = sigma - z                   (27)
    z'    = -u2,  u2 = k sigma          (33)
    u1    = rho sat(s / phi)            (37), boundary layer phi
    tau   = m_hat (u1 + u2)             limited to the drive's effort

Equation (30) makes u an acceleration, so u is multiplied by a constant nominal inertia m_hat per
joint: one number, no model of the dynamics. ``z(0) = sigma(0)`` starts the motion on the sliding
surface, without a reaching phase (46).
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiscreteValues, EventStatus, LeafSystem

from scara_drake import checks, robot

Array = NDArray[np.float64]


@njit(cache=True)
def sliding_surface(
    state_desired: Array, state: Array, c: Array, lead: float, sigma: Array
) -> None:
    """Write sigma = e' + c e (6,), equation (28), from two states (12,) = (q, v).

    The reference is carried `lead` seconds along its own velocity before the comparison.
    """
    for i in range(sigma.size):
        rate = state_desired[6 + i]
        error = state_desired[i] + lead * rate - state[i]
        sigma[i] = rate - state[6 + i] + c[i] * error


@njit(cache=True)
def ismc_law(
    sigma: Array,
    z: Array,
    k: Array,
    rho: Array,
    phi: Array,
    m_hat: Array,
    effort: Array,
    period: float,
    s: Array,
    tau: Array,
    tau_limited: Array,
) -> None:
    """Apply the law for one sample, all arrays (6,): write s, tau and tau_limited, advance z.

    The forward Euler step of z is exact for the sampled sum. After it, |sigma - z| is clamped to
    2 phi, by moving z: an integral that has wound up no longer delays the recovery.
    """
    for i in range(sigma.size):
        s[i] = sigma[i] - z[i]
        u2 = k[i] * sigma[i]
        u1 = rho[i] * min(max(s[i] / phi[i], -1.0), 1.0)
        tau[i] = m_hat[i] * (u1 + u2)
        tau_limited[i] = min(max(tau[i], -effort[i]), effort[i])
        s_max = 2.0 * phi[i]
        next_z = z[i] - period * u2
        z[i] = min(max(next_z, sigma[i] - s_max), sigma[i] + s_max)


@dataclass
class IntegralSlidingMode:
    """Gains of the law per joint; the defaults are Table 12 of the paper.

    Position in metres and radians, so sigma, s and phi are in m/s and rad/s, c and k in 1/s, rho in
    m/s² and rad/s².
    """

    c: list[float] = field(default_factory=lambda: [50.0, 50.0, 50.0, 40.0, 10.0, 10.0])
    k: list[float] = field(default_factory=lambda: [150.0, 100.0, 100.0, 75.0, 40.0, 20.0])
    rho: list[float] = field(default_factory=lambda: [500.0, 150.0, 150.0, 120.0, 100.0, 100.0])
    phi: list[float] = field(default_factory=lambda: [1.0] * 6)

    def validate(self, name: str) -> None:
        """Check the gains; `name` is the field's path in the scenario.

        Raises:
            ValueError: a gain is negative or not finite, or phi is not positive.
        """
        for gain in ("c", "k", "rho"):
            checks.vector(f"{name}.{gain}", getattr(self, gain), 6, 0.0)
        checks.vector(f"{name}.phi", self.phi, 6, math.ulp(0.0))

    def make_system(self, period: float) -> "IntegralSlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return IntegralSlidingModeController(self, period)


class IntegralSlidingModeController(LeafSystem):
    """Integral sliding mode control of the six joints.

    Input ports:
        state (12): q, v measured [m, rad, m/s, rad/s]
        state_desired (12): q, v references
    Output ports, all discrete state:
        actuation (6): effort within the limits of the drives [N, N m]
        actuation_commanded (6): effort before the limits
        sliding_variable (6): s of equation (27) [m/s, rad/s]
    Update (every period): equations (27) to (37), see `ismc_law`. A sampled plant has stepped
        before its controller is updated, so the measured state is one period younger than the
        reference: the reference is carried one period along its velocity.
    Initial: z = sigma, hence s = 0; actuation = m_hat k sigma.
    """

    def __init__(self, gains: IntegralSlidingMode, period: float = 1e-3):
        super().__init__()
        self._c, self._k = np.array(gains.c), np.array(gains.k)
        self._rho, self._phi = np.array(gains.rho), np.array(gains.phi)
        self._m_hat = np.array(robot.nominal_inertias())
        self._effort = np.array(robot.EFFORT)
        self._period = period
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("state_desired", 12)
        self._tau_limited = self.DeclareDiscreteState(6)
        self._tau = self.DeclareDiscreteState(6)
        self._s = self.DeclareDiscreteState(6)
        self._z = self.DeclareDiscreteState(6)
        self.DeclareStateOutputPort("actuation", self._tau_limited)
        self.DeclareStateOutputPort("actuation_commanded", self._tau)
        self.DeclareStateOutputPort("sliding_variable", self._s)
        self.DeclareInitializationDiscreteUpdateEvent(self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _start(self, context: Context, discrete: DiscreteValues) -> EventStatus:
        z = discrete.get_mutable_value(self._z)
        desired, state = self._desired.Eval(context), self._state.Eval(context)
        sliding_surface(desired, state, self._c, 0.0, z)
        # Period zero: the law is evaluated and z stays sigma.
        self._apply(z.copy(), 0.0, discrete)
        return EventStatus.Succeeded()

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        sigma = np.empty(6)
        desired, state = self._desired.Eval(context), self._state.Eval(context)
        sliding_surface(desired, state, self._c, self._period, sigma)
        self._apply(sigma, self._period, discrete)

    def _apply(self, sigma: Array, period: float, discrete: DiscreteValues) -> None:
        ismc_law(
            sigma,
            discrete.get_mutable_value(self._z),
            self._k,
            self._rho,
            self._phi,
            self._m_hat,
            self._effort,
            period,
            discrete.get_mutable_value(self._s),
            discrete.get_mutable_value(self._tau),
            discrete.get_mutable_value(self._tau_limited),
        )

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

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiscreteValues, EventStatus, LeafSystem

from scara_drake import checks, robot
from scara_drake.state import declare_state

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


# Rows of the array (6, 6) of gains, one column a joint: one array crosses into the kernel faster
# than six.
C, K, RHO, PHI, M_HAT, EFFORT = range(6)


@njit(cache=True)
def ismc_law(
    sigma: Array, gains: Array, period: float, z: Array, s: Array, tau: Array, tau_limited: Array
) -> None:
    """Apply the law for one sample, all arrays (6,): write s, tau and tau_limited, advance z.

    The forward Euler step of z is exact for the sampled sum. After it, |sigma - z| is clamped to
    2 phi, by moving z: an integral that has wound up no longer delays the recovery.

    Args:
        sigma: equation (28) [m/s, rad/s].
        gains: (6, 6), rows c, k, rho, phi, m_hat and the effort limit.
        period: [s]; with zero z stays.
        z: equation (33), in place.
        s: equation (27).
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
    """
    for i in range(sigma.size):
        phi, effort = gains[PHI, i], gains[EFFORT, i]
        s[i] = sigma[i] - z[i]
        u2 = gains[K, i] * sigma[i]
        u1 = gains[RHO, i] * min(max(s[i] / phi, -1.0), 1.0)
        tau[i] = gains[M_HAT, i] * (u1 + u2)
        tau_limited[i] = min(max(tau[i], -effort), effort)
        z[i] = min(max(z[i] - period * u2, sigma[i] - 2.0 * phi), sigma[i] + 2.0 * phi)


@njit(cache=True)
def ismc_sample(
    state_desired: Array,
    state: Array,
    gains: Array,
    period: float,
    z: Array,
    s: Array,
    tau: Array,
    tau_limited: Array,
) -> None:
    """Compare the states (12,) and apply the law; the reference is one period old."""
    sigma = np.empty(6)
    sliding_surface(state_desired, state, gains[C], period, sigma)
    ismc_law(sigma, gains, period, z, s, tau, tau_limited)


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
        checks.vector(f"{name}.phi", self.phi, 6, checks.ABOVE_ZERO)

    def array(self) -> Array:
        """Return the gains with m_hat and the efforts of the robot, as `ismc_law` takes them."""
        rows = [self.c, self.k, self.rho, self.phi, robot.nominal_inertias(), robot.EFFORT]
        return np.array(rows, dtype=np.float64)

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
        self._gains = gains.array()
        self._period = period
        self._state = self.DeclareVectorInputPort("state", 12)
        self._desired = self.DeclareVectorInputPort("state_desired", 12)
        self._tau_limited = declare_state(self, 6, "actuation")
        self._tau = declare_state(self, 6, "actuation_commanded")
        self._s = declare_state(self, 6, "sliding_variable")
        self._z = declare_state(self, 6)
        self.DeclareInitializationDiscreteUpdateEvent(self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _start(self, context: Context, discrete: DiscreteValues) -> EventStatus:
        desired, state = self._desired.Eval(context), self._state.Eval(context)
        # At the start both are of the same instant; the law is evaluated and z stays sigma.
        z = discrete.get_mutable_value(self._z)
        sliding_surface(desired, state, self._gains[C], 0.0, z)
        self._sample(desired, state, 0.0, discrete)
        return EventStatus.Succeeded()

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        desired, state = self._desired.Eval(context), self._state.Eval(context)
        self._sample(desired, state, self._period, discrete)

    def _sample(
        self, desired: Array, state: Array, period: float, discrete: DiscreteValues
    ) -> None:
        ismc_sample(
            desired,
            state,
            self._gains,
            period,
            discrete.get_mutable_value(self._z),
            discrete.get_mutable_value(self._s),
            discrete.get_mutable_value(self._tau),
            discrete.get_mutable_value(self._tau_limited),
        )

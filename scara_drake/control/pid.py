"""PID control of all joints at once.

With e = q_d - q::

    a   = kp e + ki int e + kd e'
    tau = m_hat a          limited to the drive's effort

Integral sliding mode control is this law as long as its s stays inside the boundary layer::

    kd = k + rho / phi
    kp = kd c + k rho / phi
    ki = k c rho / phi

so a PID with these gains is what that law has to be measured against.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import DiscreteValues

from scara_drake import joints, robot
from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.control import integral_sliding_mode as ismc
from scara_drake.control.chatter import LIMIT
from scara_drake.control.controller import JointController, limit_effort
from scara_drake.robot import chatter_number

Array = NDArray[np.float64]

# Rows of the array (5, n) of gains, one column a joint.
KP, KI, KD, M_HAT, EFFORT = range(5)


@njit(cache=True)
def pid_law(
    error: Array,
    error_rate: Array,
    gains: Array,
    period: float,
    integral: Array,
    tau: Array,
    tau_limited: Array,
    saturation: Array,
) -> None:
    """Apply the law for one sample, all arrays (n,): write the last three, advance the integral.

    The integral holds while the effort is at its limit and the error would drive it further.

    Args:
        error: e [m, rad].
        error_rate: e' [m/s, rad/s].
        gains: (5, n), rows kp, ki, kd, m_hat and the effort limit.
        period: [s].
        integral: ki int e [m/s², rad/s²], in place; the sum up to the sample before this one.
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    for i in range(error.size):
        a = gains[KP, i] * error[i] + integral[i] + gains[KD, i] * error_rate[i]
        tau[i] = gains[M_HAT, i] * a
    limit_effort(tau, gains[EFFORT], np.zeros(error.size), tau_limited, saturation)
    for i in range(error.size):
        if saturation[i] == 0.0 or tau[i] * error[i] < 0.0:
            integral[i] += period * gains[KI, i] * error[i]


@njit(cache=True)
def pid_start(error: Array, error_rate: Array, gains: Array, integral: Array) -> None:
    """Write the integral (n,) with which the effort begins at zero; zero where there is none."""
    for i in range(error.size):
        if gains[KI, i] > 0.0:
            integral[i] = -gains[KP, i] * error[i] - gains[KD, i] * error_rate[i]
        else:
            integral[i] = 0.0


@njit(cache=True)
def tracking_errors(
    state_desired: Array, state: Array, lead: float, error: Array, error_rate: Array
) -> None:
    """Write e and e' (n,) of two states (2n,) = (q, v).

    The reference is carried `lead` seconds along its own velocity before the comparison.
    """
    n = error.size
    for i in range(n):
        rate = state_desired[n + i]
        error[i] = state_desired[i] + lead * rate - state[i]
        error_rate[i] = rate - state[n + i]


@dataclass
class Pid:
    """Gains per joint; the defaults equal integral sliding mode control with Table 12.

    Attributes:
        kp: of the error [1/s²].
        ki: of its integral [1/s³].
        kd: of its rate [1/s].
        allow_chatter: gains that break the rule of `check_sampling` are accepted.
    """

    kp: list[float] = field(
        default_factory=lambda: [107500.0, 27500.0, 27500.0, 16800.0, 5400.0, 3200.0]
    )
    ki: list[float] = field(default_factory=lambda: [3.75e6, 750e3, 750e3, 360e3, 40e3, 20e3])
    kd: list[float] = field(default_factory=lambda: [650.0, 250.0, 250.0, 195.0, 140.0, 120.0])
    allow_chatter: bool = False

    @classmethod
    def from_sliding_mode(cls, gains: ismc.IntegralSlidingMode) -> "Pid":
        """Return the PID that integral sliding mode control with `gains` is inside its layer."""
        array = gains.array()
        c, k, slope = array[ismc.C], array[ismc.K], array[ismc.RHO] / array[ismc.PHI]
        scale = array[ismc.M_HAT] / robot.nominal_inertias()
        kd = scale * (k + slope)
        kp = kd * c + scale * k * slope
        ki = scale * k * c * slope
        return cls(kp.tolist(), ki.tolist(), kd.tolist(), gains.allow_chatter)

    def validate(self, name: str) -> None:
        """Check the gains; `name` is the field's path in the scenario.

        Raises:
            ValueError: a gain is negative or not finite.
        """
        for gain in ("kp", "ki", "kd"):
            checks.vector(f"{name}.{gain}", getattr(self, gain), 6, 0.0)

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the gains do not chatter at this period [s].

        A sampled double integrator under kp and kd is stable where T_s (kd + kp T_s / 2) < 2.

        Raises:
            ValueError: the rule of `chatter` is broken by that sum, and `allow_chatter` is not set.
        """
        gains = self.array()
        slope = gains[M_HAT] * (gains[KD] + 0.5 * period * gains[KP])
        number = chatter_number(slope, period)
        if number >= LIMIT and not self.allow_chatter:
            raise ValueError(
                f"{name}: chatters, T_s max lambda(M^-1 m_hat (kd + kp T_s / 2)) = {number:.3g} at "
                f"T_s = {period:g} s, allowed below 2: lower kd and kp (or set "
                f"{name}.allow_chatter)"
            )

    def array(self) -> Array:
        """Return the gains as `pid_law` takes them (5, 6)."""
        rows = [self.kp, self.ki, self.kd, robot.nominal_inertias(), joints.EFFORT]
        return np.array(rows, dtype=np.float64)

    def make_system(self, period: float) -> "PidController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return PidController(self, period)


class PidController(JointController):
    """PID control of the six joints.

    Ports: those of `JointController`; `saturation` has no layer to tell of.
    Update (every period): see `pid_law`; the reference is carried one period along its velocity.
    Initial, and while not engaged: the integral with which the effort begins at zero.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: Pid, period: float = 1e-3):
        super().__init__(period)
        self._gains = gains.array()
        self._integral = declare_state(self, 6)

    def start(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Begin without an effort; both states are of one instant."""
        error, error_rate = np.empty((2, 6))
        tracking_errors(desired, state, 0.0, error, error_rate)
        integral, *results = self._results(discrete)
        pid_start(error, error_rate, self._gains, integral)
        pid_law(error, error_rate, self._gains, 0.0, integral, *results)

    def sample(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Apply the law; the reference is one period old."""
        error, error_rate = np.empty((2, 6))
        tracking_errors(desired, state, self.period, error, error_rate)
        pid_law(error, error_rate, self._gains, self.period, *self._results(discrete))

    def _results(self, discrete: DiscreteValues) -> tuple[Array, ...]:
        return (
            discrete.get_mutable_value(self._integral),
            discrete.get_mutable_value(self.tau),
            discrete.get_mutable_value(self.tau_limited),
            discrete.get_mutable_value(self.saturation),
        )

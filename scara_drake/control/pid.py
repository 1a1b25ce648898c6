r"""PID control of all joints at once.

With :math:`e = q_d - q`, and limited to the drive's effort,

.. math::

    a    &= k_p\,e + k_i \int e\,dt + k_d\,\dot e \\
    \tau &= \hat m\,a

Integral sliding mode control is this law as long as its s stays inside the boundary layer:

.. math::

    k_d &= k + \rho / \phi \\
    k_p &= k_d\,c + k \rho / \phi \\
    k_i &= k\,c\,\rho / \phi

so a PID with these gains is what that law has to be measured against.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints, robot
from scara_drake.common.block import Memory
from scara_drake.common.fields import vector
from scara_drake.common.layout import Rows
from scara_drake.control import ismc_law as ismc
from scara_drake.control.chatter import LIMIT
from scara_drake.control.controller import JointController, Law, limit_effort, release
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.robot import chatter_number

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """Gains of the law, each row (n,).

    Attributes:
        kp: [1/s²].
        ki: [1/s³].
        kd: [1/s].
        m_hat: [kg, kg m²].
        effort: limit [N, N m].
        period: T_s [s], the same for all joints.
    """

    kp: Array
    ki: Array
    kd: Array
    m_hat: Array
    effort: Array
    period: Array


GAINS = Rows(Gains)
gains_of = GAINS.reader()


@njit(cache=True)
def pid_law(
    error: Array,
    error_rate: Array,
    gains: Array,
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
        gains: (6, n), see `Gains`.
        integral: ki int e [m/s², rad/s²], in place; the sum up to the sample before this one.
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    g = gains_of(gains)
    for i in range(error.size):
        a = g.kp[i] * error[i] + integral[i] + g.kd[i] * error_rate[i]
        tau[i] = g.m_hat[i] * a
    limit_effort(tau, g.effort, np.zeros(error.size), tau_limited, saturation)
    for i in range(error.size):
        if saturation[i] == 0.0 or tau[i] * error[i] < 0.0:
            integral[i] += g.period[i] * g.ki[i] * error[i]


@njit(cache=True)
def pid_start(error: Array, error_rate: Array, gains: Array, integral: Array) -> None:
    """Write the integral (n,) with which the effort begins at zero; zero where there is none."""
    g = gains_of(gains)
    for i in range(error.size):
        if g.ki[i] > 0.0:
            integral[i] = -g.kp[i] * error[i] - g.kd[i] * error_rate[i]
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


@njit(cache=True)
def pid_initialize(
    state_desired: Array,
    state: Array,
    gains: Array,
    integral: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Apply the law with the integral of no effort; both states are of one instant."""
    error, error_rate = np.empty(integral.size), np.empty(integral.size)
    tracking_errors(state_desired, state, 0.0, error, error_rate)
    pid_start(error, error_rate, gains, integral)
    pid_law(error, error_rate, gains, integral, actuation_commanded, actuation, saturation)


@njit(cache=True)
def pid_update(
    state_desired: Array,
    state: Array,
    gains: Array,
    integral: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Apply the law; the reference is one period old."""
    error, error_rate = np.empty(integral.size), np.empty(integral.size)
    tracking_errors(state_desired, state, gains_of(gains).period[0], error, error_rate)
    pid_law(error, error_rate, gains, integral, actuation_commanded, actuation, saturation)


@njit(cache=True)
def pid_rest(
    state_desired: Array,
    state: Array,
    gains: Array,
    integral: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Keep the integral where the effort would begin at zero; the reference is one period old."""
    error, error_rate = np.empty(integral.size), np.empty(integral.size)
    tracking_errors(state_desired, state, gains_of(gains).period[0], error, error_rate)
    pid_start(error, error_rate, gains, integral)
    release(actuation_commanded, actuation, saturation)


@dataclass
class Pid:
    """Gains per joint; the defaults equal integral sliding mode control with Table 12.

    Attributes:
        kp: of the error.
        ki: of its integral.
        kd: of its rate.
        allow_chatter: gains that break the rule of `check_sampling` are accepted.
    """

    kp: list[float] = vector(
        [107500.0, 27500.0, 27500.0, 16800.0, 5400.0, 3200.0], "1/s²", 0.0, symbol="kp"
    )
    ki: list[float] = vector([3.75e6, 750e3, 750e3, 360e3, 40e3, 20e3], "1/s³", 0.0, symbol="ki")
    kd: list[float] = vector([650.0, 250.0, 250.0, 195.0, 140.0, 120.0], "1/s", 0.0, symbol="kd")
    allow_chatter: bool = False

    @classmethod
    def from_sliding_mode(cls, gains: IntegralSlidingMode) -> "Pid":
        """Return the PID that integral sliding mode control with `gains` is inside its layer."""
        g = ismc.GAINS.unpack(gains.array())
        c, k, slope = g.c, g.k, g.rho / g.phi
        scale = g.m_hat / robot.nominal_inertias()
        kd = scale * (k + slope)
        kp = kd * c + scale * k * slope
        ki = scale * k * c * slope
        return cls(kp.tolist(), ki.tolist(), kd.tolist(), gains.allow_chatter)

    def check_sampling(
        self, name: str, period: float, model: robot.RobotModel | None = None
    ) -> None:
        """Check that the gains do not chatter at this period [s] on a robot, or the nominal one.

        A sampled double integrator under kp and kd is stable where T_s (kd + kp T_s / 2) < 2.

        Raises:
            ValueError: the rule of `chatter` is broken by that sum, and `allow_chatter` is not set.
        """
        g = GAINS.unpack(self.array(period))
        number = chatter_number(g.m_hat * (g.kd + 0.5 * period * g.kp), period, model)
        if number >= LIMIT and not self.allow_chatter:
            raise ValueError(
                f"{name}: chatters, T_s max lambda(M^-1 m_hat (kd + kp T_s / 2)) = {number:.3g} at "
                f"T_s = {period:g} s, allowed below 2: lower kd and kp (or set "
                f"{name}.allow_chatter)"
            )

    def array(self, period: float) -> Array:
        """Return the gains as `pid_law` takes them (6, 6); the period in [s]."""
        return GAINS.pack(
            kp=self.kp,
            ki=self.ki,
            kd=self.kd,
            m_hat=robot.nominal_inertias(),
            effort=joints.EFFORT,
            period=period,
        )

    def make_system(self, period: float) -> "PidController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return PidController(self, period)


class PidController(JointController):
    """PID control of the six joints.

    Ports: those of `JointController`; `saturation` has no layer to tell of.

    Update, at t = k period: see `pid_law`, with the reference carried one period along its
    velocity. Initial, and while not engaged: the integral with which the effort begins at zero.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: Pid, period: float = 1e-3) -> None:
        super().__init__(
            period,
            Law(update=pid_update, initialize=pid_initialize, rest=pid_rest, limited=True),
            parameters={"gains": gains.array(period)},
            memory={"integral": Memory(6)},
        )

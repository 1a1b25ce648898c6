r"""Conventional sliding mode control, with which the paper compares its law (Table 10).

With :math:`e = q_d - q`

.. math::

    \sigma &= \dot e + c\,e \\
    u      &= \rho \operatorname{sat}(\sigma / \phi) \\
    \tau   &= \hat m\,u

limited to the drive's effort. Inside the boundary layer that is a PD law: a constant perturbation d
[m/s², rad/s²] leaves the steady error :math:`\phi d / (\rho c)`, for there is no integral. Outside
it :math:`\sigma` has to be reached first.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints, robot
from scara_drake.common.block import Memory
from scara_drake.common.fields import ABOVE_ZERO, vector
from scara_drake.common.layout import Rows
from scara_drake.control.chatter import Slopes, check_chatter
from scara_drake.control.controller import JointController, Law, limit_effort, release
from scara_drake.control.ismc_law import sliding_surface

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """Gains of the law, each row (n,).

    Attributes:
        c: [1/s].
        rho: [m/s², rad/s²].
        phi: [m/s, rad/s].
        m_hat: [kg, kg m²].
        effort: limit [N, N m].
        period: T_s [s], the same for all joints.
    """

    c: Array
    rho: Array
    phi: Array
    m_hat: Array
    effort: Array
    period: Array


GAINS = Rows(Gains)
gains_of = GAINS.reader()


@njit(cache=True)
def smc_law(sigma: Array, gains: Array, tau: Array, tau_limited: Array, saturation: Array) -> None:
    """Apply the law to a sample, all arrays (n,): write the last three.

    Args:
        sigma: e' + c e [m/s, rad/s].
        gains: (6, n), see `Gains`.
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    g = gains_of(gains)
    outside = np.empty(sigma.size)
    for i in range(sigma.size):
        ratio = sigma[i] / g.phi[i]
        outside[i] = abs(ratio)
        tau[i] = g.m_hat[i] * g.rho[i] * min(max(ratio, -1.0), 1.0)
    limit_effort(tau, g.effort, outside, tau_limited, saturation)


@njit(cache=True)
def smc_initialize(
    state_desired: Array,
    state: Array,
    gains: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Apply the law to two states of one instant."""
    sliding_surface(state_desired, state, gains_of(gains).c, 0.0, sliding_variable)
    smc_law(sliding_variable, gains, actuation_commanded, actuation, saturation)


@njit(cache=True)
def smc_update(
    state_desired: Array,
    state: Array,
    gains: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Apply the law; the reference is one period old."""
    g = gains_of(gains)
    sliding_surface(state_desired, state, g.c, g.period[0], sliding_variable)
    smc_law(sliding_variable, gains, actuation_commanded, actuation, saturation)


@njit(cache=True)
def smc_rest(
    state_desired: Array,
    state: Array,
    gains: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Show sigma, without an effort; the reference is one period old."""
    g = gains_of(gains)
    sliding_surface(state_desired, state, g.c, g.period[0], sliding_variable)
    release(actuation_commanded, actuation, saturation)


@njit(cache=True)
def smc_rest_initialize(
    state_desired: Array,
    state: Array,
    gains: Array,
    sliding_variable: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Show sigma, without an effort; both states are of one instant."""
    sliding_surface(state_desired, state, gains_of(gains).c, 0.0, sliding_variable)
    release(actuation_commanded, actuation, saturation)


@dataclass
class SlidingMode:
    """Gains of the law per joint.

    The slope c is that of Table 12, and rho is its rho + k: the torque is as steep a function of
    sigma as that of the integral law, hence as far from chatter.

    Attributes:
        c: slope of the sliding surface.
        rho: gain of the discontinuous part.
        phi: boundary layer of sigma.
        allow_chatter: gains that break the rule of `chatter` are accepted.
    """

    c: list[float] = vector(
        [50.0, 50.0, 50.0, 40.0, 10.0, 10.0], "1/s", 0.0, symbol="c", equation="(28)"
    )
    rho: list[float] = vector(
        [650.0, 250.0, 250.0, 195.0, 140.0, 120.0], "m/s² | rad/s²", 0.0, symbol="rho"
    )
    phi: list[float] = vector([1.0] * 6, "m/s | rad/s", ABOVE_ZERO, symbol="phi")
    allow_chatter: bool = False

    def check_sampling(
        self, name: str, period: float, model: robot.RobotModel | None = None
    ) -> None:
        """Check that the gains do not chatter at this period [s] on a robot, or the nominal one.

        Raises:
            ValueError: they do, and `allow_chatter` is not set; gives the smallest phi.
        """
        if not self.allow_chatter:
            g = GAINS.unpack(self.array(period))
            slopes = Slopes(g.m_hat, g.c, np.zeros(6), g.rho, g.phi)
            check_chatter(name, slopes, period, model)

    def array(self, period: float) -> Array:
        """Return the gains as `smc_law` takes them (6, 6); the period in [s]."""
        return GAINS.pack(
            c=self.c,
            rho=self.rho,
            phi=self.phi,
            m_hat=robot.nominal_inertias(),
            effort=joints.EFFORT,
            period=period,
        )

    def make_system(self, period: float) -> "SlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return SlidingModeController(self, period)


class SlidingModeController(JointController):
    """Conventional sliding mode control of the six joints.

    Ports: those of `JointController`, and
        output sliding_variable (6) [m/s, rad/s]: sigma.

    Update, at t = k period: see `smc_law`, with the reference carried one period along its
    velocity. Initial: the law at that instant; it has no memory.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: SlidingMode, period: float = 1e-3) -> None:
        super().__init__(
            period,
            Law(
                update=smc_update,
                initialize=smc_initialize,
                rest=smc_rest,
                rest_initialize=smc_rest_initialize,
                limited=True,
            ),
            parameters={"gains": gains.array(period)},
            memory={"sliding_variable": Memory(6, port=True)},
        )

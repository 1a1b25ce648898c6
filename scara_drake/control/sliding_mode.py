"""Conventional sliding mode control, with which the paper compares its law (Table 10).

With e = q_d - q and sigma = e' + c e::

    u   = rho sat(sigma / phi)
    tau = m_hat u          limited to the drive's effort

Inside the boundary layer that is a PD law: a constant perturbation d [m/s², rad/s²] leaves the
steady error phi d / (rho c), for there is no integral. Outside it sigma has to be reached first.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import DiscreteValues

from scara_drake import joints, robot
from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.control.chatter import check_chatter
from scara_drake.control.controller import JointController, limit_effort
from scara_drake.control.integral_sliding_mode import sliding_surface

Array = NDArray[np.float64]

# Rows of the array (5, n) of gains, one column a joint.
C, RHO, PHI, M_HAT, EFFORT = range(5)


@njit(cache=True)
def smc_law(sigma: Array, gains: Array, tau: Array, tau_limited: Array, saturation: Array) -> None:
    """Apply the law to a sample, all arrays (n,): write the last three.

    Args:
        sigma: e' + c e [m/s, rad/s].
        gains: (5, n), rows c, rho, phi, m_hat and the effort limit.
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    outside = np.empty(sigma.size)
    for i in range(sigma.size):
        ratio = sigma[i] / gains[PHI, i]
        outside[i] = abs(ratio)
        tau[i] = gains[M_HAT, i] * gains[RHO, i] * min(max(ratio, -1.0), 1.0)
    limit_effort(tau, gains[EFFORT], outside, tau_limited, saturation)


@njit(cache=True)
def smc_sample(
    state_desired: Array,
    state: Array,
    gains: Array,
    lead: float,
    sigma: Array,
    tau: Array,
    tau_limited: Array,
    saturation: Array,
) -> None:
    """Compare the states (12,), with the reference carried `lead` [s], and apply the law."""
    sliding_surface(state_desired, state, gains[C], lead, sigma)
    smc_law(sigma, gains, tau, tau_limited, saturation)


@dataclass
class SlidingMode:
    """Gains of the law per joint.

    The slope c is that of Table 12, and rho is its rho + k: the torque is as steep a function of
    sigma as that of the integral law, hence as far from chatter.

    Attributes:
        c: slope of the sliding surface [1/s].
        rho: gain of the discontinuous part [m/s², rad/s²].
        phi: boundary layer of sigma [m/s, rad/s].
        allow_chatter: gains that break the rule of `chatter` are accepted.
    """

    c: list[float] = field(default_factory=lambda: [50.0, 50.0, 50.0, 40.0, 10.0, 10.0])
    rho: list[float] = field(default_factory=lambda: [650.0, 250.0, 250.0, 195.0, 140.0, 120.0])
    phi: list[float] = field(default_factory=lambda: [1.0] * 6)
    allow_chatter: bool = False

    def validate(self, name: str) -> None:
        """Check the gains; `name` is the field's path in the scenario.

        Raises:
            ValueError: a gain is negative or not finite, or phi is not positive.
        """
        checks.vector(f"{name}.c", self.c, 6, 0.0)
        checks.vector(f"{name}.rho", self.rho, 6, 0.0)
        checks.vector(f"{name}.phi", self.phi, 6, checks.ABOVE_ZERO)

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the gains do not chatter at this period [s].

        Raises:
            ValueError: they do, and `allow_chatter` is not set; gives the smallest phi.
        """
        if not self.allow_chatter:
            gains = self.array()
            check_chatter(name, gains[M_HAT], np.zeros(6), gains[RHO], gains[PHI], period)

    def array(self) -> Array:
        """Return the gains as `smc_law` takes them (5, 6)."""
        rows = [self.c, self.rho, self.phi, robot.nominal_inertias(), joints.EFFORT]
        return np.array(rows, dtype=np.float64)

    def make_system(self, period: float) -> "SlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return SlidingModeController(self, period)


class SlidingModeController(JointController):
    """Conventional sliding mode control of the six joints.

    Ports: those of `JointController`, and the output, discrete state:
        sliding_variable (6): sigma [m/s, rad/s]
    Update (every period): see `smc_law`; the reference is carried one period along its velocity.
    Initial: the law at that instant; it has no memory.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: SlidingMode, period: float = 1e-3):
        super().__init__(period)
        self._gains = gains.array()
        self._sigma = declare_state(self, 6, "sliding_variable")

    def start(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Apply the law to two states of one instant."""
        smc_sample(desired, state, self._gains, 0.0, *self._results(discrete))

    def sample(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Apply the law; the reference is one period old."""
        smc_sample(desired, state, self._gains, self.period, *self._results(discrete))

    def _results(self, discrete: DiscreteValues) -> tuple[Array, ...]:
        return (
            discrete.get_mutable_value(self._sigma),
            discrete.get_mutable_value(self.tau),
            discrete.get_mutable_value(self.tau_limited),
            discrete.get_mutable_value(self.saturation),
        )

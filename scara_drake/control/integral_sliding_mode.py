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
from pydrake.systems.framework import DiscreteValues

from scara_drake import joints, robot
from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.control.chatter import check_chatter
from scara_drake.control.controller import JointController, limit_effort
from scara_drake.control.gravity import gravity_effort, gravity_parameters

Array = NDArray[np.float64]

MODES = ("normalised", "paper")
# The paper's unit of length is the millimetre: u in N, sigma and phi of the mast in mm/s.
PAPER_UNIT = np.array([1e-3, 1.0, 1.0, 1.0, 1.0, 1.0])  # [m, rad]


@njit(cache=True)
def sliding_surface(
    state_desired: Array, state: Array, c: Array, lead: float, sigma: Array
) -> None:
    """Write sigma = e' + c e (6,), equation (28), from two states (12,) = (q, v).

    The reference is carried `lead` seconds along its own velocity before the comparison.
    """
    n = sigma.size
    for i in range(n):
        rate = state_desired[n + i]
        error = state_desired[i] + lead * rate - state[i]
        sigma[i] = rate - state[n + i] + c[i] * error


# Rows of the array (7, n) of gains, one column a joint: one array crosses into the kernel faster
# than seven.
C, K, RHO, PHI, M_HAT, EFFORT, CLAMP = range(7)


@njit(cache=True)
def ismc_law(
    sigma: Array,
    gains: Array,
    period: float,
    feedforward: Array,
    z: Array,
    s: Array,
    tau: Array,
    tau_limited: Array,
    saturation: Array,
) -> None:
    """Apply the law for one sample, all arrays (n,): write the last four, advance z.

    The forward Euler step of z is exact for the sampled sum. After it, |sigma - z| is clamped by
    moving z: an integral that has wound up no longer delays the recovery.

    Args:
        sigma: equation (28) [m/s, rad/s].
        gains: (7, n), rows c, k, rho, phi, m_hat, the effort limit and the clamp of |s|.
        period: [s]; with zero z stays.
        feedforward: effort that is added to the law's [N, N m].
        z: equation (33), in place.
        s: equation (27).
        tau: effort before the limits [N, N m].
        tau_limited: effort within the limits.
        saturation: see `limit_effort`.
    """
    outside = np.empty(sigma.size)
    for i in range(sigma.size):
        phi, clamp = gains[PHI, i], gains[CLAMP, i]
        s[i] = sigma[i] - z[i]
        outside[i] = abs(s[i]) / phi
        u2 = gains[K, i] * sigma[i]
        u1 = gains[RHO, i] * min(max(s[i] / phi, -1.0), 1.0)
        tau[i] = gains[M_HAT, i] * (u1 + u2) + feedforward[i]
        z[i] = min(max(z[i] - period * u2, sigma[i] - clamp), sigma[i] + clamp)
    limit_effort(tau, gains[EFFORT], outside, tau_limited, saturation)


@njit(cache=True)
def ismc_sample(
    state_desired: Array,
    state: Array,
    gains: Array,
    period: float,
    feedforward: Array,
    z: Array,
    s: Array,
    tau: Array,
    tau_limited: Array,
    saturation: Array,
) -> None:
    """Compare the states (12,) and apply the law; the reference is one period old."""
    sigma = np.empty(6)
    sliding_surface(state_desired, state, gains[C], period, sigma)
    ismc_law(sigma, gains, period, feedforward, z, s, tau, tau_limited, saturation)


def _six(value: float) -> list[float]:
    return [value] * 6


@dataclass
class IntegralSlidingMode:
    """Gains of the law per joint; the defaults are Table 12 of the paper.

    Modes per joint:

    - ``normalised``: positions in metres and radians, so sigma, s and phi are in m/s and rad/s, c
      and k in 1/s, rho in m/s² and rad/s²; tau = m_hat u with the robot's nominal inertia.
    - ``paper``: the raw law. tau = u is in N and N m, the mast's positions are in mm, and the
      integral is not clamped. It makes sense for the mast; the other joints are left without the
      factor of their inertia.

    Attributes:
        c: slope of the sliding surface [1/s].
        k: gain of the nominal part u2 [1/s].
        rho: gain of the discontinuous part u1.
        phi: boundary layer of s.
        mode: of each joint, "normalised" or "paper".
        anti_windup: |s| is clamped to 2 phi (joints in ``normalised`` mode).
        acceleration_feedforward: the nominal inertia times the reference's acceleration is added.
        gravity_compensation: the effort that holds the nominal robot against gravity is added.
        allow_chatter: gains that break the rule of `chatter` are accepted.
    """

    c: list[float] = field(default_factory=lambda: [50.0, 50.0, 50.0, 40.0, 10.0, 10.0])
    k: list[float] = field(default_factory=lambda: [150.0, 100.0, 100.0, 75.0, 40.0, 20.0])
    rho: list[float] = field(default_factory=lambda: [500.0, 150.0, 150.0, 120.0, 100.0, 100.0])
    phi: list[float] = field(default_factory=lambda: _six(1.0))
    mode: list[str] = field(default_factory=lambda: ["normalised"] * 6)
    anti_windup: bool = True
    acceleration_feedforward: bool = False
    gravity_compensation: bool = False
    allow_chatter: bool = False

    def validate(self, name: str) -> None:
        """Check the gains; `name` is the field's path in the scenario.

        Raises:
            ValueError: a gain is negative or not finite, phi is not positive, or a mode unknown.
        """
        for gain in ("c", "k", "rho"):
            checks.vector(f"{name}.{gain}", getattr(self, gain), 6, 0.0)
        checks.vector(f"{name}.phi", self.phi, 6, checks.ABOVE_ZERO)
        if len(self.mode) != 6:
            raise ValueError(f"{name}.mode: {len(self.mode)} entries, allowed 6")
        for index, mode in enumerate(self.mode):
            checks.choice(f"{name}.mode[{index}]", mode, MODES)

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the gains do not chatter at this period [s].

        Raises:
            ValueError: they do, and `allow_chatter` is not set; gives the smallest phi.
        """
        if not self.allow_chatter:
            gains = self.array()
            unit = np.where(self._paper(), PAPER_UNIT, 1.0)
            m_hat, k, rho, phi = gains[M_HAT], gains[K], gains[RHO], gains[PHI]
            check_chatter(name, m_hat, k, rho, phi, period, unit)

    def array(self) -> Array:
        """Return the gains as `ismc_law` takes them (7, 6), in SI units.

        In millimetres and newtons the law is that of a nominal inertia of 1 N s²/mm = 1000 kg,
        with rho over that inertia.
        """
        unit, paper = PAPER_UNIT, self._paper()
        m_hat = np.where(paper, 1.0 / unit, robot.nominal_inertias())
        rho = np.where(paper, np.multiply(self.rho, unit), self.rho)
        phi = np.where(paper, np.multiply(self.phi, unit), self.phi)
        clamp = np.where(paper | (not self.anti_windup), np.inf, 2.0 * phi)
        rows = [self.c, self.k, rho, phi, m_hat, joints.EFFORT, clamp]
        return np.array(rows, dtype=np.float64)

    def make_system(self, period: float) -> "IntegralSlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return IntegralSlidingModeController(self, period)

    def _paper(self) -> NDArray[np.bool_]:
        return np.array([mode == "paper" for mode in self.mode])


class IntegralSlidingModeController(JointController):
    """Integral sliding mode control of the six joints.

    Ports: those of `JointController`, and the output, discrete state:
        sliding_variable (6): s of equation (27) [m/s, rad/s]
    Update (every period): equations (27) to (37), see `ismc_law`. A sampled plant has stepped
        before its controller is updated, so the measured state is one period younger than the
        reference: the reference is carried one period along its velocity.
    Initial, and while not engaged: z = sigma, hence s = 0; actuation = m_hat k sigma at the start.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: IntegralSlidingMode, period: float = 1e-3):
        super().__init__(period)
        self._gains = gains.array()
        self._gravity = gravity_parameters() if gains.gravity_compensation else None
        self._s = declare_state(self, 6, "sliding_variable")
        self._z = declare_state(self, 6)
        self._v_desired = declare_state(self, 6) if gains.acceleration_feedforward else None
        self._m_hat = robot.nominal_inertias()
        self._none = np.zeros(6)

    def start(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Begin on the sliding surface; both states are of one instant."""
        z = discrete.get_mutable_value(self._z)
        sliding_surface(desired, state, self._gains[C], 0.0, z)
        if self._v_desired is not None:
            discrete.get_mutable_value(self._v_desired)[:] = desired[6:]
        sigma = z.copy()
        feedforward = self._feedforward(desired, state, discrete)
        ismc_law(sigma, self._gains, 0.0, feedforward, *self._results(discrete))

    def sample(self, desired: Array, state: Array, discrete: DiscreteValues) -> None:
        """Apply the law; the reference is one period old."""
        ismc_sample(
            desired,
            state,
            self._gains,
            self.period,
            self._feedforward(desired, state, discrete),
            *self._results(discrete),
        )

    def _results(self, discrete: DiscreteValues) -> tuple[Array, ...]:
        return (
            discrete.get_mutable_value(self._z),
            discrete.get_mutable_value(self._s),
            discrete.get_mutable_value(self.tau),
            discrete.get_mutable_value(self.tau_limited),
            discrete.get_mutable_value(self.saturation),
        )

    def _feedforward(self, desired: Array, state: Array, discrete: DiscreteValues) -> Array:
        if self._v_desired is None and self._gravity is None:
            return self._none
        effort = np.zeros(6)
        if self._gravity is not None:
            gravity_effort(state[:6], self._gravity, effort)
        if self._v_desired is not None:
            before = discrete.get_mutable_value(self._v_desired)
            effort += self._m_hat * (desired[6:] - before) / self.period
            before[:] = desired[6:]
        return effort

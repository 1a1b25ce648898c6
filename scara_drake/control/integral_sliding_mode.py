"""Integral sliding mode control of all joints at once: gains and controller of `ismc_law`."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake import joints, robot
from scara_drake.common.block import Input, Memory, Output
from scara_drake.common.fields import ABOVE_ZERO, vector, words
from scara_drake.common.layout import Layout
from scara_drake.common.scratch import scratch
from scara_drake.control.chatter import Slopes, check_chatter
from scara_drake.control.controller import JointController, Law, release
from scara_drake.control.gravity import LINKS, gravity_effort, gravity_parameters
from scara_drake.control.ismc_law import GAINS, gains_of, ismc_law, sliding_surface

Array = NDArray[np.float64]

MODES = ("normalised", "paper")
# The paper's unit of length is the millimetre: u in N, sigma and phi of the mast in mm/s.
PAPER_UNIT = np.array([1e-3, 1.0, 1.0, 1.0, 1.0, 1.0])  # [m, rad]


class Parameters(NamedTuple):
    """What the controller of the arm knows.

    Attributes:
        gains: (8, 6), see `Gains`.
        links: (4, 6), see `gravity_parameters`.
        inertia: that an acceleration of the reference is multiplied with (6,) [kg, kg m²].
        gravity_compensation: 1 or 0.
        acceleration_feedforward: 1 or 0.
    """

    gains: Array
    links: Array
    inertia: Array
    gravity_compensation: float
    acceleration_feedforward: float


class Integral(NamedTuple):
    """Memory of the controller.

    Attributes:
        z: of equation (33) (6,) [m/s, rad/s].
        v_desired: of the sample before (6,) [m/s, rad/s].
        s: of equation (27) (6,) [m/s, rad/s].
    """

    z: Array
    v_desired: Array
    s: Array


PARAMETERS = Layout(Parameters, gains=(GAINS.size, 6), links=(LINKS.size, 6), inertia=6)
INTEGRAL = Layout(Integral, z=6, v_desired=6, s=6)
parameters_of = PARAMETERS.reader()
integral_of = INTEGRAL.reader()


@njit(cache=True)
def add_feedforward(
    state_desired: Array, state: Array, parameters: Array, memory: Array, feedforward: Array
) -> None:
    """Add the efforts of gravity and of the reference's acceleration, if wanted, to (6,)."""
    p, m = parameters_of(parameters), integral_of(memory)
    if p.gravity_compensation > 0.0:
        gravity_effort(state[:6], p.links, feedforward)
    if p.acceleration_feedforward > 0.0:
        period = gains_of(p.gains).period[0]
        for i in range(6):
            change = state_desired[6 + i] - m.v_desired[i]
            feedforward[i] += p.inertia[i] * change / period
    m.v_desired[:] = state_desired[6:]


@njit(cache=True)
def ismc_initialize(
    state_desired: Array,
    state: Array,
    parameters: Array,
    memory: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Apply the law on the sliding surface, z = sigma; both states are of one instant."""
    p, m = parameters_of(parameters), integral_of(memory)
    sigma, feedforward = scratch(6), scratch(6)
    feedforward[:] = 0.0
    sliding_surface(state_desired, state, gains_of(p.gains).c, 0.0, sigma)
    m.z[:], m.v_desired[:] = sigma, state_desired[6:]
    add_feedforward(state_desired, state, parameters, memory, feedforward)
    ismc_law(
        sigma, p.gains, feedforward, m.z,
        m.s, actuation_commanded, actuation, saturation,
    )  # fmt: skip


@njit(cache=True)
def scale_gains(gains: Array, scale: float, scaled: Array) -> None:
    """Write the gains (8, 6) with k and rho times a scale; with 1 they are the same to the bit."""
    scaled[:] = gains
    g = gains_of(scaled)
    for i in range(6):
        g.k[i] *= scale
        g.rho[i] *= scale


@njit(cache=True)
def ismc_update(
    state_desired: Array,
    state: Array,
    gain_scale: Array,
    parameters: Array,
    memory: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Apply the law; the reference is one period old."""
    p, m = parameters_of(parameters), integral_of(memory)
    g = gains_of(p.gains)
    sigma, feedforward, scaled = scratch(6), scratch(6), scratch(8, 6)
    feedforward[:] = 0.0
    add_feedforward(state_desired, state, parameters, memory, feedforward)
    sliding_surface(state_desired, state, g.c, g.period[0], sigma)
    scale_gains(p.gains, gain_scale[0], scaled)
    ismc_law(
        sigma, scaled, feedforward, m.z,
        m.s, actuation_commanded, actuation, saturation,
    )  # fmt: skip


@njit(cache=True)
def ismc_rest(
    state_desired: Array,
    state: Array,
    parameters: Array,
    memory: Array,
    actuation_commanded: Array,
    actuation: Array,
    saturation: Array,
) -> None:
    """Stay on the sliding surface without an effort; the reference is one period old."""
    p, m = parameters_of(parameters), integral_of(memory)
    g = gains_of(p.gains)
    sliding_surface(state_desired, state, g.c, g.period[0], m.z)
    m.v_desired[:] = state_desired[6:]
    m.s[:] = 0.0
    release(actuation_commanded, actuation, saturation)


@njit(cache=True)
def show_sliding_variable(memory: Array, sliding_variable: Array) -> None:
    """Write s (6,)."""
    sliding_variable[:] = integral_of(memory).s


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
        c: slope of the sliding surface.
        k: gain of the nominal part u2.
        rho: gain of the discontinuous part u1.
        phi: boundary layer of s.
        mode: of each joint, "normalised" or "paper".
        anti_windup: |s| is clamped to 2 phi (joints in ``normalised`` mode).
        acceleration_feedforward: the nominal inertia times the reference's acceleration is added.
        gravity_compensation: the effort that holds the nominal robot against gravity is added.
        allow_chatter: gains that break the rule of `chatter` are accepted.
    """

    c: list[float] = vector(
        [50.0, 50.0, 50.0, 40.0, 10.0, 10.0], "1/s", 0.0, symbol="c", equation="(28)"
    )
    k: list[float] = vector(
        [150.0, 100.0, 100.0, 75.0, 40.0, 20.0], "1/s", 0.0, symbol="k", equation="(33)"
    )
    rho: list[float] = vector(
        [500.0, 150.0, 150.0, 120.0, 100.0, 100.0],
        "m/s² | rad/s²",
        0.0,
        symbol="rho",
        equation="(37)",
    )
    phi: list[float] = vector([1.0] * 6, "m/s | rad/s", ABOVE_ZERO, symbol="phi", equation="(37)")
    mode: list[str] = words(["normalised"] * 6, MODES)
    anti_windup: bool = True
    acceleration_feedforward: bool = False
    gravity_compensation: bool = False
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
            unit = np.where(self._paper(), PAPER_UNIT, 1.0)
            slopes = Slopes(g.m_hat, g.c, g.k, g.rho, g.phi, unit=unit)
            check_chatter(name, slopes, period, model)

    def array(self, period: float = 0.0) -> Array:
        """Return the gains as `ismc_law` takes them (8, 6), in SI units.

        In millimetres and newtons the law is that of a nominal inertia of 1 N s²/mm = 1000 kg,
        with rho over that inertia.

        Args:
            period: T_s [s]; with zero the integral stands still.
        """
        unit, paper = PAPER_UNIT, self._paper()
        phi = np.where(paper, np.multiply(self.phi, unit), self.phi)
        return GAINS.pack(
            c=self.c,
            k=self.k,
            rho=np.where(paper, np.multiply(self.rho, unit), self.rho),
            phi=phi,
            m_hat=np.where(paper, 1.0 / unit, robot.nominal_inertias()),
            effort=joints.EFFORT,
            clamp=np.where(paper | (not self.anti_windup), np.inf, 2.0 * phi),
            period=period,
        )

    def parameters(self, period: float) -> Array:
        """Return what the kernels of the controller read, see `Parameters`."""
        return PARAMETERS.pack(
            gains=self.array(period),
            links=gravity_parameters() if self.gravity_compensation else np.zeros((LINKS.size, 6)),
            inertia=robot.nominal_inertias(),
            gravity_compensation=float(self.gravity_compensation),
            acceleration_feedforward=float(self.acceleration_feedforward),
        )

    def make_system(self, period: float) -> "IntegralSlidingModeController":
        """Return a controller with these gains, the robot's nominal inertias and efforts."""
        return IntegralSlidingModeController(self, period)

    def _paper(self) -> NDArray[np.bool_]:
        return np.array([mode == "paper" for mode in self.mode])


class IntegralSlidingModeController(JointController):
    """Integral sliding mode control of the six joints.

    Ports: those of `JointController`, and
        input gain_scale (1): optional, of k and rho, 1 if not connected.
        output sliding_variable (6) [m/s, rad/s]: s of equation (27).

    Update, at t = k period: equations (27) to (37), see `ismc_law`, with the reference carried one
    period along its velocity; before it, with e = q_d - q::

        feedforward = G(q)                               with gravity_compensation
                    + m_hat (v_d - v_d before) / period  with acceleration_feedforward

    Initial: the law with z = sigma, hence s = 0 and actuation = m_hat k sigma; u2 acts from there
    on, so z is advanced over the first period as over any other. While not engaged: z = sigma.

    Args:
        gains: checked.
        period: [s].
    """

    def __init__(self, gains: IntegralSlidingMode, period: float = 1e-3) -> None:
        super().__init__(
            period,
            Law(update=ismc_update, initialize=ismc_initialize, rest=ismc_rest, limited=True),
            parameters={"parameters": gains.parameters(period)},
            memory={"memory": Memory(INTEGRAL.size)},
            outputs={"sliding_variable": Output(6, show_sliding_variable)},
            inputs={"gain_scale": Input(1, default=(1.0,))},
        )

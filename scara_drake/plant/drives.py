"""Imperfect drives: encoders, the lag of the actuators, and friction in the joints.

They sit between the plant and the controller and add no tick to the loop (see "One tick" in
docs/architecture.md): what they show belongs to what the plant and the controller show now.
"""

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from scara_drake.common import checks
from scara_drake.common.state import declare_state
from scara_drake.plant.encoder import Encoder
from scara_drake.robot import chatter_number, inverse_mass_matrices

Array = NDArray[np.float64]

# Rows of the parameters (4, 6) of the friction.
COULOMB, SIGMA_0, SIGMA_1, VISCOUS = range(4)
# A spring sigma_0 and a damper sigma_1 that act one step late are stable while
# h² sigma_0 + 2 h (sigma_1 + viscous) is below this many times the inertia, for every motion.
FRICTION_LIMIT = 4.0


@dataclass
class ActuatorLag:
    """First-order lag of the drives' efforts; 0.3 ms is a current loop of 500 Hz.

    Attributes:
        time_constant: of each drive [s]; 0 is none.
    """

    time_constant: list[float] = field(default_factory=lambda: [3e-4] * 6)

    def validate(self, name: str) -> None:
        """Check the field; `name` is the path in the scenario.

        Raises:
            ValueError: a number out of its range.
        """
        checks.vector(f"{name}.time_constant", self.time_constant, 6, 0.0, 10.0)

    def make_system(self, period: float) -> "ActuatorLagSystem":
        """Return the lag, sampled every `period` [s]."""
        return ActuatorLagSystem(self, period)


class ActuatorLagSystem(LeafSystem):
    """First-order lag of the efforts, T tau' = u - tau, exact for a held u.

    Input port:
        actuation (6): u, the effort asked for [N, N m]
    Output port, a function of the input and of the memory:
        actuation_delivered (6): mean of tau over the step of the plant that it drives, hence with
            the impulse of tau, u + (tau - u) (1 - exp(-h / T)) T / h
    Update (every period h): tau <- u + (tau - u) exp(-h / T)
    Initial: tau = 0, the drives are at rest.

    Args:
        lag: checked.
        period: h [s].
    """

    def __init__(self, lag: ActuatorLag, period: float = 1e-3):
        super().__init__()
        time_constant = np.array(lag.time_constant, dtype=np.float64)
        periods = period / np.maximum(time_constant, 1e-9)  # below a nanosecond there is no lag
        self._decay, self._mean = np.exp(-periods), -np.expm1(-periods) / periods
        self._actuation = self.DeclareVectorInputPort("actuation", 6)
        self._tau = declare_state(self, 6)
        self.DeclareVectorOutputPort(
            "actuation_delivered",
            6,
            self._deliver,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    def _deliver(self, context: Context, output: BasicVector) -> None:
        u, tau = self._actuation.Eval(context), context.get_discrete_state(self._tau).value()
        output.SetFromVector(u + self._mean * (tau - u))

    def _advance(self, context: Context, discrete: DiscreteValues) -> None:
        u, tau = self._actuation.Eval(context), discrete.get_mutable_value(self._tau)
        tau[:] = u + self._decay * (tau - u)


@njit(cache=True)
def friction_force(state: Array, parameters: Array, memory: Array, force: Array) -> None:
    """Move the bristles along with the joints and write the force of the friction (6,).

    Args:
        state: q, v (12,).
        parameters: (4, 6), rows coulomb, sigma_0, sigma_1, viscous.
        memory: (12,), deflections z and the positions q of the sample before, NaN for none; in
            place.
        force: on the joints [N, N m], written.
    """
    for i in range(6):
        coulomb, sigma_0 = parameters[COULOMB, i], parameters[SIGMA_0, i]
        q, v = state[i], state[6 + i]
        if sigma_0 > 0.0:
            z_max = coulomb / sigma_0
            moved = 0.0 if np.isnan(memory[6 + i]) else q - memory[6 + i]
            memory[i] = min(max(memory[i] + moved, -z_max), z_max)
        memory[6 + i] = q
        bristle = sigma_0 * memory[i] + parameters[SIGMA_1, i] * v
        force[i] = -min(max(bristle, -coulomb), coulomb) - parameters[VISCOUS, i] * v


@dataclass
class JointFriction:
    """Dry and viscous friction of the joints: an elasto-plastic bristle, after Prandtl.

    The bristle's deflection z follows the joint up to the presliding displacement and slips from
    there on::

        z' = v  within |z| <= z_max = coulomb / sigma_0,  else 0
        force = -clip(sigma_0 z + sigma_1 v, -coulomb, coulomb) - viscous v

    so |force| <= coulomb + viscous |v|. It is passive (against the energy sigma_0 z² / 2), and as z
    depends on the position alone, a joint at rest does not creep. sigma_1 damps the bristle
    critically with the least inertia that a joint can have.

    The default dry friction is 2 % of the effort limits, usual for geared drives. The viscous part
    is zero, because the joints of the URDF have one of their own.

    Attributes:
        coulomb: dry friction [N, N m].
        viscous: [N s/m, N m s/rad].
        presliding: z_max, the displacement before a joint breaks away [m, rad].
    """

    coulomb: list[float] = field(default_factory=lambda: [300.0, 160.0, 60.0, 60.0, 10.0, 2.0])
    viscous: list[float] = field(default_factory=lambda: [0.0] * 6)
    presliding: list[float] = field(default_factory=lambda: [2e-5] + [1e-4] * 5)

    def validate(self, name: str) -> None:
        """Check the fields; `name` is the path in the scenario.

        Raises:
            ValueError: a number out of its range.
        """
        checks.vector(f"{name}.coulomb", self.coulomb, 6, 0.0, 1e5)
        checks.vector(f"{name}.viscous", self.viscous, 6, 0.0, 1e5)
        checks.vector(f"{name}.presliding", self.presliding, 6, checks.ABOVE_ZERO, 0.1)

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the sampled friction is stable on the nominal robot in every posture.

        Raises:
            ValueError: it is too stiff or too viscous for this period [s].
        """
        _, sigma_0, sigma_1, viscous = self.array()
        number = chatter_number(period * sigma_0 + 2.0 * (sigma_1 + viscous), period)
        if not number < FRICTION_LIMIT:
            raise ValueError(
                f"{name}: h max lambda(M^-1 (h sigma_0 + 2 (sigma_1 + viscous))) = {number:.3g} at "
                f"h = {period:g} s, allowed below {FRICTION_LIMIT:g}: longer presliding, less "
                "coulomb or viscous friction, or a shorter time step"
            )

    def array(self) -> Array:
        """Return the parameters (4, 6) of `friction_force`."""
        sigma_0 = np.divide(self.coulomb, self.presliding)
        least_inertia = 1.0 / np.diagonal(inverse_mass_matrices(), axis1=1, axis2=2).max(axis=0)
        sigma_1 = 2.0 * np.sqrt(sigma_0 * least_inertia)
        return np.array([self.coulomb, sigma_0, sigma_1, self.viscous], dtype=np.float64)

    def make_system(self, period: float) -> "JointFrictionSystem":
        """Return the friction, sampled every `period` [s]."""
        return JointFrictionSystem(self, period)


class JointFrictionSystem(LeafSystem):
    """Friction of the six joints, see `JointFriction`.

    Input port:
        state (12): q, v of the plant, not of its encoders [m, rad, m/s, rad/s]
    Output port, discrete state:
        friction_force (6): generalized force on the joints [N, N m]
    Update (every period) and initial: see `friction_force`; the bristles start undeflected.

    A plant with sampled output ports steps before discrete states are updated: the force written at
    tick k is that of the state from which step k + 1 starts, so the friction adds no delay.

    Args:
        friction: checked.
        period: [s].
    """

    def __init__(self, friction: JointFriction, period: float = 1e-3):
        super().__init__()
        self._parameters = friction.array()
        self._state = self.DeclareVectorInputPort("state", 12)
        self._memory = declare_state(self, np.concatenate([np.zeros(6), np.full(6, np.nan)]))
        self._force = declare_state(self, 6, "friction_force")
        self.DeclareInitializationDiscreteUpdateEvent(self._update)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        friction_force(
            self._state.Eval(context),
            self._parameters,
            discrete.get_mutable_value(self._memory),
            discrete.get_mutable_value(self._force),
        )


@dataclass
class Drives:
    """What the drives and the sensors do to the loop; None is the ideal part."""

    encoder: Encoder | None = None
    lag: ActuatorLag | None = None
    friction: JointFriction | None = None

    def validate(self, name: str) -> None:
        """Check the parts; `name` is the path in the scenario.

        Raises:
            ValueError: a number out of its range.
        """
        for part in ("encoder", "lag", "friction"):
            value = getattr(self, part)
            if value is not None:
                value.validate(f"{name}.{part}")

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the friction is stable at this period [s].

        Raises:
            ValueError: see `JointFriction.check_sampling`.
        """
        if self.friction is not None:
            self.friction.check_sampling(f"{name}.friction", period)

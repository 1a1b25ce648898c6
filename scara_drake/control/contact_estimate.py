"""The contact force on the tool without a force sensor, from the perturbation observer.

The observer's Psi^ holds everything that moves a joint beside tau / m_hat: inertia, gravity,
damping, and the environment. What the model of the nominal robot does not explain of it is taken
for a force at the tool point (Kallu et al., 2019)::

    tau^  = F(tau)
    tau_c = M(q) (tau^ / m_hat + Psi^) + C(q, v^) v^ + G(q) + D v^ - tau^
    f_W   = argmin |W^1/2 (J_vᵀ f - tau_c)|²,   W = diag(1 / m_hat)

F is the lag with which the observer sees a perturbation, Psi^ = F(Psi). With an effort of the same
age tau^ / m_hat + Psi^ is F(v'), an acceleration that was; without, every change of the effort
would be taken for a contact.

The weights make the six residues, [N] and [N m], comparable: an error of Psi^ is one of m_hat Psi^
in the effort, so heavy joints count less. Friction, a payload and whatever touches another link are
taken for a force on the tool as well.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem, ValueProducer

from scara_drake import robot
from scara_drake.common import checks
from scara_drake.common.finite import all_finite, check_finite
from scara_drake.common.state import declare_state
from scara_drake.kinematics import jacobian

Array = NDArray[np.float64]

# Directions of the force that the joints feel this much less than another are given none of it:
# along a stretched arm.
SMALLEST_RATIO: Final = 0.01
PERIOD: Final = 0.01  # [s]


def make_model() -> MultibodyPlant:
    """Return the nominal robot, finalized, in continuous time."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return plant


def unexplained_effort(
    plant: MultibodyPlant, context: Context, q: Array, v: Array, v_dot: Array, tau: Array
) -> Array:
    """Return tau_c (6,) [N, N m]: what moves the joints beside the drives and the model.

    Args:
        plant: the model.
        context: of the plant; its positions and velocities are overwritten.
        q: (6,) [m, rad].
        v: (6,) [m/s, rad/s].
        v_dot: (6,) [m/s², rad/s²].
        tau: effort of the drives (6,) [N, N m].
    """
    plant.SetPositions(context, q)
    plant.SetVelocities(context, v)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)  # gravity and damping
    return plant.CalcInverseDynamics(context, v_dot, forces) - tau


def tool_force(q: Array, effort: Array) -> Array:
    """Return the force f_W (3,) [N] at the tool point that comes nearest to J_vᵀ f = effort (6,).

    Args:
        q: (6,) [m, rad].
        effort: (6,) [N, N m].
    """
    root = 1.0 / np.sqrt(robot.nominal_inertias())
    J_v = jacobian(q)[3:]
    force = np.linalg.lstsq((J_v * root).T, root * effort, rcond=SMALLEST_RATIO)[0]
    return np.asarray(force, dtype=np.float64)


class ContactForceEstimator(LeafSystem):
    """Estimates the force of the environment on the tool, see the module.

    Input ports:
        state (12): q, v measured; only q is used [m, rad]
        actuation_lagged (6): effort as old as the perturbation estimate [N, N m]
        perturbation_estimate (6): Psi^ [m/s², rad/s²]
        velocity_estimate (6): v^ [m/s, rad/s]
    Output port, discrete state:
        f_estimated_W (3): force of the environment on the tool [N]
    Update (every period, from `settling` on): the estimate.
    Initial: zero. Until the observer has found the weight of the arm, that would be taken for a
        contact.

    Args:
        period: [s]; not that of the loop, for an evaluation of the model costs more than the
            controller.
        settling: time of the first estimate [s].

    Raises:
        ValueError: a period out of 1 ms to 1 s, or a negative settling.
    """

    def __init__(self, period: float = PERIOD, settling: float = 0.25):
        super().__init__()
        checks.number("period", period, 1e-3, 1.0)
        checks.number("settling", settling, 0.0)
        self._m_hat = robot.nominal_inertias()
        self._state = self.DeclareVectorInputPort("state", 12)
        self._tau = self.DeclareVectorInputPort("actuation_lagged", 6)
        self._psi = self.DeclareVectorInputPort("perturbation_estimate", 6)
        self._v = self.DeclareVectorInputPort("velocity_estimate", 6)
        self._f = declare_state(self, 3, "f_estimated_W")
        self._plant = make_model()
        # A Context to compute in, of which each Context of this system has a copy; no result
        # depends on what was left in it.
        self._scratch = self.DeclareCacheEntry(
            "model",
            ValueProducer(
                allocate=lambda: AbstractValue.Make(self._plant.CreateDefaultContext()),
                calc=ValueProducer.NoopCalc,
            ),
            {self.nothing_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, settling, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        ports = (self._state, self._tau, self._psi, self._v)
        state, tau, psi, v = (port.Eval(context) for port in ports)
        if not (all_finite(state, tau) and all_finite(psi, v)):
            check_finite(self, context, ports)
        q = state[:6]
        effort = unexplained_effort(
            self._plant, self._scratch.Eval(context), q, v, tau / self._m_hat + psi, tau
        )
        discrete.get_mutable_value(self._f)[:] = tool_force(q, effort)

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

import threading
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import Context

from scara_drake import robot
from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.kinematics import jacobian

Array = NDArray[np.float64]

# Directions of the force that the joints feel this much less than another are given none of it:
# along a stretched arm.
SMALLEST_RATIO: Final = 0.01
PERIOD: Final = 0.01  # [s]


class Model:
    """The nominal robot in continuous time, to compute with.

    Attributes:
        plant: finalized.
    """

    def __init__(self) -> None:
        self.plant = MultibodyPlant(time_step=0.0)
        robot.add_scara(self.plant)
        self.plant.Finalize()
        self._local = threading.local()

    def context(self) -> Context:
        """Return a Context to compute in; what was left in it has to be overwritten.

        Each thread has its own, as making one costs as much as a whole estimate.
        """
        if not hasattr(self._local, "context"):
            self._local.context = self.plant.CreateDefaultContext()
        return self._local.context


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


def estimate(
    state: Array,
    actuation_lagged: Array,
    perturbation_estimate: Array,
    velocity_estimate: Array,
    m_hat: Array,
    model: Model,
    f_estimated_W: Array,
) -> None:
    """Write the force of the environment on the tool (3,) [N], see the module.

    Args:
        state: q, v measured (12,); only q is used [m, rad].
        actuation_lagged: effort as old as the perturbation estimate (6,) [N, N m].
        perturbation_estimate: Psi^ (6,) [m/s², rad/s²].
        velocity_estimate: v^ (6,) [m/s, rad/s].
        m_hat: (6,) [kg, kg m²].
        model: of the robot.
        f_estimated_W: written.
    """
    q, tau = state[:6], actuation_lagged
    v_dot = tau / m_hat + perturbation_estimate
    effort = unexplained_effort(model.plant, model.context(), q, velocity_estimate, v_dot, tau)
    f_estimated_W[:] = tool_force(q, effort)


class ContactForceEstimator(Block):
    """Estimates the force of the environment on the tool, see the module.

    Ports:
        input state (12) [m, rad, m/s, rad/s]: q, v measured; only q is used.
        input actuation_lagged (6) [N, N m]: effort as old as the perturbation estimate.
        input perturbation_estimate (6) [m/s², rad/s²]: Psi^.
        input velocity_estimate (6) [m/s, rad/s]: v^.
        output f_estimated_W (3) [N]: force of the environment on the tool.

    Update, at t = settling + k period: see `estimate`, which is plain Python, for the model is a
    MultibodyPlant. Initial: zero. Until the observer has found the weight of the arm, that would be
    taken for a contact.

    Args:
        period: [s]; not that of the loop, for an evaluation of the model costs more than the
            controller.
        settling: time of the first estimate [s].

    Raises:
        ValueError: a period out of 1 ms to 1 s, or a negative settling.
    """

    def __init__(self, period: float = PERIOD, settling: float = 0.25) -> None:
        checks.number("period", period, 1e-3, 1.0)
        checks.number("settling", settling, 0.0)
        super().__init__(
            Declaration(
                inputs={
                    "state": Input(12, finite=True),
                    "actuation_lagged": Input(6, finite=True),
                    "perturbation_estimate": Input(6, finite=True),
                    "velocity_estimate": Input(6, finite=True),
                },
                memory={"f_estimated_W": Memory(3, port=True)},
                parameters={"m_hat": robot.nominal_inertias(), "model": Model()},
                period=period,
                offset=settling,
                update=estimate,
            )
        )

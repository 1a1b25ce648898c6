r"""The contact force on the tool without a force sensor, from the perturbation observer.

The observer's Psi^ holds everything that moves a joint beside tau / m_hat: inertia, gravity,
damping, and the environment. What the model of the nominal robot does not explain of it is taken
for a force at the tool point (Kallu et al., 2019)

.. math::

    \hat\tau &= F(\tau) \\
    \tau_c   &= M(q)\,(\hat\tau / \hat m + \hat\Psi) + C(q, \hat v)\,\hat v + G(q)
                + D\,\hat v - \hat\tau \\
    f_W      &= \operatorname{argmin}_f\; (J_v^\top f - \tau_c)^\top W\,(J_v^\top f - \tau_c),
                \quad W = \operatorname{diag}(1 / \hat m)

F is the lag with which the observer sees a perturbation, Psi^ = F(Psi). With an effort of the same
age tau^ / m_hat + Psi^ is F(v'), an acceleration that was; without, every change of the effort
would be taken for a contact.

The weights make the six residues, [N] and [N m], comparable: an error of Psi^ is one of m_hat Psi^
in the effort, so heavy joints count less. Friction, a payload and whatever touches another link are
taken for a force on the tool as well.
"""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import robot
from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.dynamics.arm import arm_parameters
from scara_drake.dynamics.equations import (
    WORK,
    arm_of,
    link_forces,
    mass_matrix_and_bias,
    place_links,
    work_of,
)
from scara_drake.kinematics import tool_kinematics_kernel

Array = NDArray[np.float64]

# Directions of the force that the joints feel this much less than another are given none of it:
# along a stretched arm.
SMALLEST_RATIO: Final = 0.01
PERIOD: Final = 0.01  # [s]


@cache
def nominal_arm() -> Array:
    """Return the nominal robot as `dynamics.equations.arm_of` reads it; nobody writes into it."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    return arm_parameters(plant)


@njit(cache=True)
def unexplained_effort(
    q: Array, v: Array, v_dot: Array, tau: Array, arm: Array, work: Array, effort: Array
) -> None:
    """Write tau_c (6,) [N, N m]: what moves the joints beside the drives and the model.

    Args:
        q: (6,) [m, rad].
        v: (6,) [m/s, rad/s].
        v_dot: (6,) [m/s², rad/s²].
        tau: effort of the drives (6,) [N, N m].
        arm: the model, see `dynamics.equations.Arm`.
        work: see `dynamics.equations.Work`; written over.
        effort: written.
    """
    a, w = arm_of(arm), work_of(work)
    place_links(q, a, w)
    link_forces(v, a, w)
    mass_matrix_and_bias(a, w)
    for i in range(effort.size):
        effort[i] = w.bias[i] + a.damping[i] * v[i] - tau[i]
        for j in range(effort.size):
            effort[i] += w.M[i, j] * v_dot[j]


@njit(cache=True)
def tool_force(q: Array, effort: Array, m_hat: Array, f_W: Array) -> None:
    """Write the force (3,) [N] at the tool point that comes nearest to J_vᵀ f = effort (6,).

    Args:
        q: (6,) [m, rad].
        effort: (6,) [N, N m].
        m_hat: inertias of the joints (6,), of which W is the inverse [kg, kg m²].
        f_W: written.
    """
    p, R, J = np.empty(3), np.empty((3, 3)), np.empty((6, 6))
    tool_kinematics_kernel(q, p, R, J)
    A, b = np.empty((6, 3)), np.empty(6)
    for i in range(b.size):
        root = 1.0 / np.sqrt(m_hat[i])
        b[i] = root * effort[i]
        for axis in range(f_W.size):
            A[i, axis] = root * J[3 + axis, i]
    f_W[:] = np.linalg.lstsq(A, b, SMALLEST_RATIO)[0]


@njit(cache=True)
def estimate(
    state: Array,
    actuation_lagged: Array,
    perturbation_estimate: Array,
    velocity_estimate: Array,
    m_hat: Array,
    arm: Array,
    work: Array,
    f_estimated_W: Array,
) -> None:
    """Write the force of the environment on the tool (3,) [N], see the module.

    Args:
        state: q, v measured (12,); only q is used [m, rad].
        actuation_lagged: effort as old as the perturbation estimate (6,) [N, N m].
        perturbation_estimate: Psi^ (6,) [m/s², rad/s²].
        velocity_estimate: v^ (6,) [m/s, rad/s].
        m_hat: (6,) [kg, kg m²].
        arm: the model, see `nominal_arm`.
        work: see `dynamics.equations.Work`.
        f_estimated_W: written.
    """
    q, tau = state[:6], actuation_lagged
    v_dot, effort = tau / m_hat + perturbation_estimate, np.empty(6)
    unexplained_effort(q, velocity_estimate, v_dot, tau, arm, work, effort)
    tool_force(q, effort, m_hat, f_estimated_W)


class ContactForceEstimator(Block):
    """Estimates the force of the environment on the tool, see the module.

    Ports:
        input state (12) [m, rad, m/s, rad/s]: q, v measured; only q is used.
        input actuation_lagged (6) [N, N m]: effort as old as the perturbation estimate.
        input perturbation_estimate (6) [m/s², rad/s²]: Psi^.
        input velocity_estimate (6) [m/s, rad/s]: v^.
        output f_estimated_W (3) [N]: force of the environment on the tool.

    Update, at t = settling + k period: see `estimate`. Initial: zero. Until the observer has found
    the weight of the arm, that would be taken for a contact.

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
                memory={"f_estimated_W": Memory(3, port=True), "work": Memory(WORK.size)},
                parameters={"m_hat": robot.nominal_inertias(), "arm": nominal_arm()},
                period=period,
                offset=settling,
                update=estimate,
            )
        )

"""Brakes of the joints, which close by their springs when the drives are switched off."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.joints import EFFORT
from scara_drake.plant.friction import BRISTLES, FRICTION, bristles_of, joint_friction
from scara_drake.robot import inverse_mass_matrices

Array = NDArray[np.float64]

STIFFNESS = 0.1  # natural frequency of a held joint in samples, far below what is unstable


@njit(cache=True)
def let_go(bristles: Array) -> None:
    """Put the bristles (12,) of open brakes where no joint is."""
    m = bristles_of(bristles)
    m.z[:] = 0.0
    m.q[:] = np.nan


@njit(cache=True)
def update_brakes(
    state: Array, drives_engaged: Array, brakes: Array, bristles: Array, braking: Array
) -> None:
    """One tick of `Brakes`, in place."""
    if drives_engaged[0] > 0.5:
        let_go(bristles)
        braking[:] = 0.0
    else:
        joint_friction(state, brakes, bristles, braking)


@njit(cache=True)
def choose_effort(
    actuation: Array, drives_engaged: Array, braking: Array, actuation_braked: Array
) -> None:
    """Write the effort (6,) that acts on the joints: of the drives, or of the closed brakes."""
    actuation_braked[:] = actuation if drives_engaged[0] > 0.5 else braking


def brake_parameters(period: float) -> Array:
    """Return brakes, sampled every `period` [s], as a friction, see `plant.friction.Friction`.

    A closed brake is dry friction that holds as much as the drive gives, and is as stiff as the
    sampling bears with the least inertia that a joint has.
    """
    least_inertia = 1.0 / np.diagonal(inverse_mass_matrices(), axis1=1, axis2=2).max(axis=0)
    w = STIFFNESS / period
    return FRICTION.pack(
        coulomb=EFFORT,
        sigma_0=w * w * least_inertia,
        sigma_1=2.0 * w * least_inertia,
        viscous=np.zeros(6),
    )


class Brakes(Block):
    """Lets the effort of the drives act, or where they are off that of the brakes.

    A controller without a measurement cannot hold the arm, and no effort at all would drop the
    mast; so the brakes close, which need neither.

    Ports:
        input actuation (6) [N, N m]: of the drives.
        input drives_engaged (1): below one half they are off.
        input state (12): of the joints themselves, not what is measured of them.
        output braking (6) [N, N m]: zero while open.
        output actuation_braked (6) [N, N m]: what acts on the joints.

    Update, at t = k period: the dry friction of `plant.friction`, up to the limits of the drives.

    Args:
        period: [s].
    """

    def __init__(self, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={"actuation": Input(6), "drives_engaged": Input(1), "state": Input(12)},
                memory={
                    "bristles": Memory(BRISTLES.zeros(q=np.full(6, np.nan))),
                    "braking": Memory(6, port=True),
                },
                outputs={"actuation_braked": Output(6, choose_effort)},
                parameters={"brakes": brake_parameters(period)},
                period=period,
                update=update_brakes,
            )
        )

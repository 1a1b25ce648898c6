"""The sum of all forces on the joints beside those of the drives."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Output

Array = NDArray[np.float64]

NO_FORCE = Input(6, default=(0.0,) * 6)


@njit(cache=True)
def add_up(
    generalized_force: Array,
    friction_force: Array,
    perturbation_force: Array,
    applied_generalized_force: Array,
    joint_forces: Array,
) -> None:
    """Write the sum (6,) [N, N m]."""
    for i in range(joint_forces.size):
        inner = generalized_force[i] + friction_force[i] + perturbation_force[i]
        joint_forces[i] = inner + applied_generalized_force[i]


class JointForces(Block):
    """Adds up the forces on the joints; what is not connected is zero.

    Ports, all (6) [N for d1, N m for the others]:
        input generalized_force: of the contact.
        input friction_force: of the joints.
        input perturbation_force: of the scenario.
        input applied_generalized_force: from outside the Diagram.
        output joint_forces: their sum.
    """

    def __init__(self) -> None:
        names = ("generalized_force", "friction_force", "perturbation_force")
        super().__init__(
            Declaration(
                inputs=dict.fromkeys((*names, "applied_generalized_force"), NO_FORCE),
                outputs={"joint_forces": Output(6, add_up)},
            )
        )

"""Dry and viscous friction in the joints."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.block import Block, Declaration, Input, Memory
from scara_drake.common.fields import ABOVE_ZERO, vector
from scara_drake.common.layout import Layout
from scara_drake.robot import RobotModel, chatter_number, inverse_mass_matrices

Array = NDArray[np.float64]

# A spring sigma_0 and a damper sigma_1 that act one step late are stable while
# h² sigma_0 + 2 h (sigma_1 + viscous) is below this many times the inertia, for every motion.
FRICTION_LIMIT = 4.0


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
        coulomb: dry friction.
        viscous: per velocity.
        presliding: z_max, the displacement before a joint breaks away.
    """

    coulomb: list[float] = vector([300.0, 160.0, 60.0, 60.0, 10.0, 2.0], "N | N m", 0.0, 1e5)
    viscous: list[float] = vector([0.0] * 6, "N s/m | N m s/rad", 0.0, 1e5)
    presliding: list[float] = vector([2e-5] + [1e-4] * 5, "m | rad", ABOVE_ZERO, 0.1)

    def check_sampling(self, name: str, period: float, model: RobotModel | None = None) -> None:
        """Check that the sampled friction is stable in every posture of a robot, or the nominal.

        Raises:
            ValueError: it is too stiff or too viscous for this period [s].
        """
        f = FRICTION.unpack(self.parameters())
        number = chatter_number(period * f.sigma_0 + 2.0 * (f.sigma_1 + f.viscous), period, model)
        if not number < FRICTION_LIMIT:
            raise ValueError(
                f"{name}: h max lambda(M^-1 (h sigma_0 + 2 (sigma_1 + viscous))) = {number:.3g} at "
                f"h = {period:g} s, allowed below {FRICTION_LIMIT:g}: longer presliding, less "
                "coulomb or viscous friction, or a shorter time step"
            )

    def parameters(self) -> Array:
        """Return the friction as `friction_of` reads it."""
        sigma_0 = np.divide(self.coulomb, self.presliding)
        least_inertia = 1.0 / np.diagonal(inverse_mass_matrices(), axis1=1, axis2=2).max(axis=0)
        return FRICTION.pack(
            coulomb=self.coulomb,
            sigma_0=sigma_0,
            sigma_1=2.0 * np.sqrt(sigma_0 * least_inertia),
            viscous=self.viscous,
        )

    def make_system(self, period: float) -> "JointFrictionSystem":
        """Return the friction, sampled every `period` [s]."""
        return JointFrictionSystem(self, period)


class Friction(NamedTuple):
    """`JointFriction` in a kernel.

    Attributes:
        coulomb: (6,) [N, N m].
        sigma_0: stiffness of the bristles (6,) [N/m, N m/rad].
        sigma_1: damping of the bristles (6,) [N s/m, N m s/rad].
        viscous: (6,) [N s/m, N m s/rad].
    """

    coulomb: Array
    sigma_0: Array
    sigma_1: Array
    viscous: Array


class Bristles(NamedTuple):
    """Memory of the friction.

    Attributes:
        z: deflections (6,) [m, rad].
        q: positions of the sample before (6,) [m, rad], NaN for none.
    """

    z: Array
    q: Array


FRICTION = Layout(Friction, coulomb=6, sigma_0=6, sigma_1=6, viscous=6)
BRISTLES = Layout(Bristles, z=6, q=6)
friction_of = FRICTION.reader()
bristles_of = BRISTLES.reader()


@njit(cache=True)
def joint_friction(state: Array, friction: Array, bristles: Array, friction_force: Array) -> None:
    """Move the bristles along with the joints and write the force of the friction (6,).

    Args:
        state: q, v (12,).
        friction: of `JointFriction.parameters`.
        bristles: memory, see `Bristles`; in place.
        friction_force: on the joints [N, N m], written.
    """
    f, m = friction_of(friction), bristles_of(bristles)
    for i in range(6):
        coulomb, sigma_0 = f.coulomb[i], f.sigma_0[i]
        q, v = state[i], state[6 + i]
        if sigma_0 > 0.0:
            z_max = coulomb / sigma_0
            moved = 0.0 if np.isnan(m.q[i]) else q - m.q[i]
            m.z[i] = min(max(m.z[i] + moved, -z_max), z_max)
        m.q[i] = q
        bristle = sigma_0 * m.z[i] + f.sigma_1[i] * v
        friction_force[i] = -min(max(bristle, -coulomb), coulomb) - f.viscous[i] * v


class JointFrictionSystem(Block):
    """Friction of the six joints, see `JointFriction`.

    Ports:
        input state (12) [m, rad, m/s, rad/s]: q, v of the plant, not of its encoders.
        output friction_force (6) [N, N m]: generalized force on the joints.

    Update, every period, and initial: see `joint_friction`; the bristles start undeflected.

    A plant with sampled output ports steps before discrete states are updated: the force written at
    tick k is that of the state from which step k + 1 starts, so the friction adds no delay.

    Args:
        friction: checked.
        period: [s].
    """

    def __init__(self, friction: JointFriction, period: float = 1e-3) -> None:
        super().__init__(
            Declaration(
                inputs={"state": Input(12)},
                memory={
                    "bristles": Memory(BRISTLES.pack(z=np.zeros(6), q=np.full(6, np.nan))),
                    "friction_force": Memory(6, port=True),
                },
                parameters={"friction": friction.parameters()},
                period=period,
                update=joint_friction,
                initialize=joint_friction,
            )
        )

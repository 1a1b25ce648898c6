"""The bare robot in other simulators: the same URDF, reflected inertias and dampings, no contact.

Each is checked against Drake's plant before it is timed: the acceleration at random postures,
speeds and efforts.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuatorIndex, MultibodyForces_

from scara_drake import joints, robot
from scara_drake.common.resources import resource

Array = NDArray[np.float64]

AGREE = 1e-9  # of the largest acceleration of a joint
SAMPLES = 50

# Advances the robot by so many steps.
Steps = Callable[[int], None]


class Reference:
    """Drake's plant, and what the others take from it.

    Attributes:
        armature: reflected inertia of each joint (6,) [kg, kg m²].
        damping: of each joint (6,) [N s/m, N m s/rad].
        weight: efforts that carry the arm at home (6,) [N, N m].
    """

    def __init__(self) -> None:
        self._plant = MultibodyPlant(time_step=0.0)
        robot.add_scara(self._plant)
        self._plant.Finalize()
        self._context = self._plant.CreateDefaultContext()
        count = self._plant.num_actuators()
        actuators = [
            self._plant.get_joint_actuator(JointActuatorIndex(index)) for index in range(count)
        ]
        self.armature = np.array([a.calc_reflected_inertia(self._context) for a in actuators])
        self.damping = np.array([a.joint().default_damping_vector()[0] for a in actuators])
        self._plant.SetPositions(self._context, joints.HOME)
        self.weight = -self._plant.CalcGravityGeneralizedForces(self._context)

    def acceleration(self, q: Array, v: Array, effort: Array) -> Array:
        """Return the acceleration (6,) by the equations of motion."""
        self._plant.SetPositionsAndVelocities(self._context, np.concatenate([q, v]))
        forces = MultibodyForces_[float](self._plant)
        self._plant.CalcForceElementsContribution(self._context, forces)
        # Of the force elements only the dampings are generalized forces; the weights are on bodies.
        bias = self._plant.CalcBiasTerm(self._context)
        applied = forces.generalized_forces() + effort
        applied += self._plant.CalcGravityGeneralizedForces(self._context)
        mass = self._plant.CalcMassMatrix(self._context)
        return np.linalg.solve(mass, applied - bias)

    def states(self) -> Iterator[tuple[Array, Array, Array]]:
        """Yield random postures, speeds and efforts."""
        rng = np.random.default_rng(0)
        for _ in range(SAMPLES):
            q = rng.uniform(joints.LOWER, joints.UPPER)
            v = rng.uniform(-1.0, 1.0, 6) * joints.MAX_SPEED
            yield q, v, rng.uniform(-1.0, 1.0, 6) * joints.EFFORT

    def check(self, name: str, acceleration: Callable[[Array, Array, Array], Array]) -> float:
        """Return how far a peer is from Drake, relative to each joint's largest acceleration.

        Raises:
            RuntimeError: farther than `AGREE`: it is another robot.
        """
        drake = np.array([self.acceleration(*state) for state in self.states()])
        peer = np.array([acceleration(*state) for state in self.states()])
        worst = float((np.abs(peer - drake) / np.abs(drake).max(axis=0)).max())
        if not worst <= AGREE:
            raise RuntimeError(f"{name}: {worst:.2g} from Drake's acceleration, allowed {AGREE:g}")
        return worst


def mujoco_steps(reference: Reference, period: float) -> dict[str, tuple[Steps, float]]:
    """Return MuJoCo's robot, step by step from Python and in C; and how far it is from Drake."""
    import mujoco

    spec = mujoco.MjSpec.from_file(str(resource("models", "scara6.urdf")))
    spec.option.timestep = period
    off = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    spec.option.disableflags |= int(off)
    model = spec.compile()
    model.dof_armature[:], model.dof_damping[:] = reference.armature, reference.damping
    data = mujoco.MjData(model)

    def acceleration(q: Array, v: Array, effort: Array) -> Array:
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, v, effort
        mujoco.mj_forward(model, data)
        return np.array(data.qacc)

    worst = reference.check("MuJoCo", acceleration)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = joints.HOME, 0.0, reference.weight

    def from_python(count: int) -> None:
        for _ in range(count):
            mujoco.mj_step(model, data)

    def in_c(count: int) -> None:
        mujoco.mj_step(model, data, nstep=count)

    return {
        "MuJoCo, bare robot, step by step from Python": (from_python, worst),
        "MuJoCo, bare robot, its loop in C": (in_c, worst),
    }


def pinocchio_steps(reference: Reference, period: float) -> dict[str, tuple[Steps, float]]:
    """Return Pinocchio's `aba` with semi-implicit Euler; and how far it is from Drake."""
    import pinocchio  # type: ignore[import-not-found,unused-ignore] # not in every environment

    model = pinocchio.buildModelFromUrdf(str(resource("models", "scara6.urdf")))
    model.armature = reference.armature
    data: Any = model.createData()

    def acceleration(q: Array, v: Array, effort: Array) -> Array:
        return np.array(pinocchio.aba(model, data, q, v, effort - reference.damping * v))

    worst = reference.check("Pinocchio", acceleration)
    q, v = joints.HOME.copy(), np.zeros(6)

    def from_python(count: int) -> None:
        nonlocal q, v
        for _ in range(count):
            effort = reference.weight - reference.damping * v
            v = v + period * pinocchio.aba(model, data, q, v, effort)
            q = q + period * v

    return {"Pinocchio's aba, bare robot, step by step from Python": (from_python, worst)}


PEERS = {"mujoco": mujoco_steps, "pinocchio": pinocchio_steps}


def peer_steps(period: float) -> dict[str, tuple[Steps, float]]:
    """Return the peers that are installed, by name, and how far each is from Drake."""
    reference = Reference()
    found: dict[str, tuple[Steps, float]] = {}
    for module, make in PEERS.items():
        if importlib.util.find_spec(module) is not None:
            found |= make(reference, period)
    return found

"""models/scara6.urdf as other programs read it, behind the same few questions.

They are asked about the bare links: no program but Drake reads the drives' inertia.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cache
from importlib import import_module
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.resources import resource
from scara_drake.joints import JOINT_NAMES

Array = NDArray[np.float64]

URDF = str(resource("models", "scara6.urdf"))
LINKS = [f"link_{i}" for i in range(1, 7)]
TOOL = "tool"


class Reader(ABC):
    """A program that reads the URDF.

    Attributes:
        module: what is imported; the class of the same name loads the file.
        exact: how far its tool may be from Drake's [m, and 1 for the entries of R].
    """

    module: ClassVar[str]
    exact: ClassVar[float] = 1e-12

    @abstractmethod
    def tool(self, q: Array) -> Array:
        """X_WE (4, 4) at a posture."""

    @abstractmethod
    def masses(self) -> list[float]:
        """Masses of link_1 to link_6 [kg]."""


class Dynamic(Reader):
    """A program that knows the equations of motion too."""

    @abstractmethod
    def mass_matrix(self, q: Array) -> Array:
        """M(q) (6, 6), without the drives."""

    @abstractmethod
    def gravity(self, q: Array) -> Array:
        """Efforts (6,) that hold the arm at a posture."""


def pose(R: Any, p: Any) -> Array:
    """X (4, 4) of a rotation matrix, flat or not, and a point."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = np.reshape(R, (3, 3)), p
    return X


class Mujoco(Dynamic):
    module = "mujoco"

    def __init__(self) -> None:
        self.lib: Any = import_module(self.module)
        spec = self.lib.MjSpec.from_file(URDF)
        spec.compiler.fusestatic = False  # else the tool's frame is gone
        self.model = spec.compile()
        self.data = self.lib.MjData(self.model)

    def tool(self, q: Array) -> Array:
        self.data.qpos[:] = q
        self.lib.mj_kinematics(self.model, self.data)
        body = self.data.body(TOOL)
        return pose(body.xmat, body.xpos)

    def masses(self) -> list[float]:
        return [float(self.model.body(link).mass[0]) for link in LINKS]

    def _forward(self, q: Array) -> None:
        self.data.qpos[:], self.data.qvel[:] = q, 0.0
        self.lib.mj_forward(self.model, self.data)

    def mass_matrix(self, q: Array) -> Array:
        self._forward(q)
        M = np.zeros((6, 6))
        self.lib.mj_fullM(self.model, self.data, M)
        return M

    def gravity(self, q: Array) -> Array:
        self._forward(q)
        return np.array(self.data.qfrc_bias)


class Pinocchio(Dynamic):
    module = "pinocchio"

    def __init__(self) -> None:
        self.lib: Any = import_module(self.module)
        self.model = self.lib.buildModelFromUrdf(URDF)
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(TOOL)

    def tool(self, q: Array) -> Array:
        self.lib.framesForwardKinematics(self.model, self.data, q)
        return np.array(self.data.oMf[self.frame].homogeneous)

    def masses(self) -> list[float]:
        return [float(inertia.mass) for inertia in self.model.inertias][1:]

    def mass_matrix(self, q: Array) -> Array:
        M = np.triu(self.lib.crba(self.model, self.data, q))
        return M + np.triu(M, 1).T

    def gravity(self, q: Array) -> Array:
        return np.array(self.lib.computeGeneralizedGravity(self.model, self.data, q))


class Pybullet(Dynamic):
    module = "pybullet"
    exact = 1e-6  # it tells poses in single precision

    def __init__(self) -> None:
        self.lib: Any = import_module(self.module)
        self.lib.connect(self.lib.DIRECT)
        self.lib.setGravity(0.0, 0.0, -9.81)
        flags = self.lib.URDF_USE_INERTIA_FROM_FILE
        self.robot = self.lib.loadURDF(URDF, useFixedBase=True, flags=flags)
        count = self.lib.getNumJoints(self.robot)
        told = [self.lib.getJointInfo(self.robot, index) for index in range(count)]
        self.links = {each[12].decode(): each[0] for each in told}
        moving = {each[1].decode(): each[0] for each in told if each[3] >= 0}
        assert tuple(moving) == tuple(JOINT_NAMES)
        self.joints = list(moving.values())

    def tool(self, q: Array) -> Array:
        for index, value in zip(self.joints, q, strict=True):
            self.lib.resetJointState(self.robot, index, value)
        link = self.links[TOOL]
        state = self.lib.getLinkState(self.robot, link, computeForwardKinematics=True)
        return pose(self.lib.getMatrixFromQuaternion(state[5]), state[4])

    def masses(self) -> list[float]:
        assert self.lib.getDynamicsInfo(self.robot, self.links["base"])[0] == 0.0
        return [self.lib.getDynamicsInfo(self.robot, self.links[link])[0] for link in LINKS]

    def mass_matrix(self, q: Array) -> Array:
        return np.array(self.lib.calculateMassMatrix(self.robot, q.tolist()))

    def gravity(self, q: Array) -> Array:
        zero = [0.0] * 6
        return np.array(self.lib.calculateInverseDynamics(self.robot, q.tolist(), zero, zero))


class Yourdfpy(Reader):
    module = "yourdfpy"

    def __init__(self) -> None:
        self.robot: Any = import_module(self.module).URDF.load(URDF)

    def tool(self, q: Array) -> Array:
        self.robot.update_cfg(dict(zip(JOINT_NAMES, q, strict=True)))
        return np.array(self.robot.get_transform(TOOL, "world"))

    def masses(self) -> list[float]:
        return [float(self.robot.link_map[link].inertial.mass) for link in LINKS]


class Urchin(Reader):
    module = "urchin"

    def __init__(self) -> None:
        self.robot: Any = import_module(self.module).URDF.load(URDF)

    def tool(self, q: Array) -> Array:
        configuration = dict(zip(JOINT_NAMES, q, strict=True))
        return np.array(self.robot.link_fk(configuration, link=TOOL))

    def masses(self) -> list[float]:
        return [float(self.robot.link_map[link].inertial.mass) for link in LINKS]


class Roboticstoolbox(Dynamic):
    module = "roboticstoolbox"

    def __init__(self) -> None:
        read = import_module(f"{self.module}.models.URDF.URDFRobot").URDF_read
        links, name, _ = read(URDF)
        self.robot: Any = import_module(self.module).Robot(links, name=name)
        self.robot.gravity = [0.0, 0.0, -9.81]

    def tool(self, q: Array) -> Array:
        return np.array(self.robot.fkine(q, end=TOOL).A)

    def masses(self) -> list[float]:
        return [float(self.robot.link_dict[link].m) for link in LINKS]

    def mass_matrix(self, q: Array) -> Array:
        return np.array(self.robot.inertia(q))

    def gravity(self, q: Array) -> Array:
        return np.array(self.robot.gravload(q))


READERS: dict[str, type[Reader]] = {
    each.module: each for each in (Mujoco, Pinocchio, Pybullet, Roboticstoolbox, Urchin, Yourdfpy)
}
DYNAMIC = [name for name, each in READERS.items() if issubclass(each, Dynamic)]


@cache
def reader(module: str) -> Reader:
    """The robot as a program has loaded it, once."""
    return READERS[module]()

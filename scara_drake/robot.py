"""The robot in a MultibodyPlant: its model, its nominal inertias and its mass matrices."""

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, SpatialInertia, UnitInertia

from scara_drake import joints
from scara_drake.common.fields import number, vector
from scara_drake.common.resources import resource

Array = NDArray[np.float64]


MODEL: Final = "scara6"  # name of the model instance
TOOL_FRAME: Final = "tool"
NEGLIGIBLE: Final = 1e-6  # [kg]; a lighter payload is none, and would only meet rounding


@dataclass
class RobotModel:
    """How the simulated robot differs from the nominal one, which the controllers know.

    Attributes:
        mass_scale: factors of the masses and of the rotational inertias of link_1 to link_6; the
            inertias of the drives stay.
        payload_mass: of a point mass that the tool holds.
        payload_offset: where that is, in the tool frame.
    """

    mass_scale: list[float] = vector([1.0] * 6, "1", 0.1, 10.0)
    payload_mass: float = number(0.0, "kg", 0.0, 500.0)
    payload_offset: list[float] = vector([0.0] * 3, "m", -2.0, 2.0)


def add_scara(
    plant: MultibodyPlant, model: RobotModel | None = None, name: str = MODEL
) -> ModelInstanceIndex:
    """Add models/scara6.urdf to a plant that is not finalized; its base is welded to the world.

    Args:
        plant: receives the robot, and the body ``payload`` where the model has one.
        model: None is the nominal robot.
        name: of the model instance; a second robot in a plant needs another.

    Raises:
        ValueError: the plant has a model instance of this name.
    """
    model = model or RobotModel()
    if plant.HasModelInstanceNamed(name):
        raise ValueError(f"name: '{name}', allowed one that no model instance of the plant has")
    parser = Parser(plant)
    parser.package_map().AddPackageXml(resource("models", "package.xml"))
    if name == MODEL and all(scale == 1.0 for scale in model.mass_scale):
        (instance,) = parser.AddModels(resource("models", "scara6.urdf"))
    else:
        (instance,) = parser.AddModelsFromString(_changed_urdf(model.mass_scale, name), "urdf")
    if model.payload_mass > NEGLIGIBLE:
        point = SpatialInertia(model.payload_mass, np.zeros(3), UnitInertia(0.0, 0.0, 0.0))
        payload = plant.AddRigidBody("payload", instance, point)
        tool = plant.GetFrameByName(TOOL_FRAME, instance)
        X_EP = RigidTransform(np.array(model.payload_offset))
        plant.WeldFrames(tool, payload.body_frame(), X_EP)
    return instance


def _changed_urdf(mass_scale: list[float], name: str) -> str:
    """Return the URDF with a name, and mass and inertia of link_1 to link_6 times their factor."""
    ET.register_namespace("drake", "http://drake.mit.edu")  # Drake looks for its tags by prefix
    root = ET.parse(resource("models", "scara6.urdf")).getroot()
    root.set("name", name)
    for index, scale in enumerate(mass_scale, start=1):
        for element in root.findall(f"link[@name='link_{index}']/inertial/*"):
            if element.tag in ("mass", "inertia"):
                for key, value in element.attrib.items():
                    element.set(key, repr(scale * float(value)))
    return ET.tostring(root, encoding="unicode")


@lru_cache(maxsize=1)
def nominal_inertias() -> Array:
    """Constant nominal inertia m̂ per joint (6,) [kg, kg m²].

    The geometric mean of the diagonal of the mass matrix, drive inertias included, over a fixed
    sample of the workspace: one number a joint, no model of the dynamics.
    """
    plant = MultibodyPlant(time_step=0.0)
    add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    samples = np.random.default_rng(0).uniform(joints.LOWER, joints.UPPER, (500, 6))
    logs = np.empty_like(samples)
    for row, q in zip(logs, samples, strict=True):
        plant.SetPositions(context, q)
        row[:] = np.log(np.diag(plant.CalcMassMatrix(context)))
    inertias = np.exp(logs.mean(axis=0))
    inertias.setflags(write=False)
    return inertias


def drive_accelerations() -> Array:
    """What the drives' effort limits give the nominal inertias (6,) [m/s², rad/s²]."""
    return np.asarray(joints.EFFORT / nominal_inertias(), dtype=np.float64)


def inverse_mass_matrices(model: RobotModel | None = None) -> Array:
    """M(q)^-1 (n, 6, 6) of a robot over a grid of postures [1/kg, 1/(kg m²)].

    The grid spans joints 3 to 5, and joint 6 where a payload is beside its axis: the matrix does
    not depend on the mast nor on joint 2, and on the roll of the bare tool to less than 0.01 kg m².

    Args:
        model: None is the nominal robot.
    """
    m = model or RobotModel()
    offset = tuple(m.payload_offset) if m.payload_mass > NEGLIGIBLE else (0.0, 0.0, 0.0)
    return _inverse_mass_matrices(tuple(m.mass_scale), m.payload_mass, offset)


@lru_cache(maxsize=8)
def _inverse_mass_matrices(
    mass_scale: tuple[float, ...], payload_mass: float, payload_offset: tuple[float, ...]
) -> Array:
    plant = MultibodyPlant(time_step=0.0)
    add_scara(plant, RobotModel(list(mass_scale), payload_mass, list(payload_offset)))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = joints.HOME.copy()
    matrices = []
    axes = (np.linspace(joints.LOWER[i], joints.UPPER[i], 13) for i in (3, 4))
    rolls = np.linspace(-np.pi, np.pi, 8, endpoint=False) if any(payload_offset[:2]) else [0.0]
    for q[2], q[3], q[4], q[5] in product(np.linspace(-np.pi, np.pi, 13), *axes, rolls):
        plant.SetPositions(context, q)
        matrices.append(plant.CalcMassMatrix(context))
    inverses: Array = np.linalg.inv(np.array(matrices, dtype=np.float64))
    inverses.setflags(write=False)
    return inverses


def lightness(model: RobotModel | None = None) -> float:
    """Largest factor by which an effort accelerates a robot more than the nominal one.

    It is max over postures of lambda_max(M(q)^-1 M_nominal(q)). A payload, which makes it smaller,
    is left out.
    """
    bare = RobotModel(model.mass_scale) if model else None
    ratios = inverse_mass_matrices(bare) @ np.linalg.inv(inverse_mass_matrices())
    return float(np.linalg.eigvals(ratios).real.max())


def chatter_number(gain: Array, period: float, model: RobotModel | None = None) -> float:
    """T_s max over postures of lambda_max(M(q)^-1 diag(gain)); below 2 the loop does not chatter.

    Args:
        gain: effort per unit of sigma (6,) [N s/m, N m s/rad], m_hat (rho / phi + k).
        period: T_s [s].
        model: of the robot; None is the nominal one.
    """
    # D^1/2 M^-1 D^1/2 is symmetric and has the same eigenvalues.
    root, inverse_mass = np.sqrt(gain), inverse_mass_matrices(model)
    largest, row = 0.0, 0
    while (row := next_above(inverse_mass, root, largest, row)) < len(inverse_mass):
        symmetric = inverse_mass[row] * root * root[:, None]
        largest = float(np.linalg.eigvalsh(symmetric)[-1])
        row += 1
    return period * largest


@njit(cache=True)
def next_above(matrices: Array, root: Array, bound: float, start: int) -> int:
    """Index of the next matrix that has an eigenvalue above a bound, or their number.

    Where all are below it, bound I - D M D is positive definite: Cholesky tells at a tenth of the
    cost of the eigenvalues.

    Args:
        matrices: M, symmetric (m, n, n).
        root: diagonal of D (n,).
        bound: of the eigenvalues of D M D.
        start: index of the first to look at.
    """
    n = root.size
    lower = np.empty((n, n))
    for index in range(start, matrices.shape[0]):
        for i in range(n):
            for j in range(i + 1):
                rest = -root[i] * matrices[index, i, j] * root[j]
                for k in range(j):
                    rest -= lower[i, k] * lower[j, k]
                if i > j:
                    lower[i, j] = rest / lower[j, j]
                    continue
                if not bound + rest > 0.0:
                    return index
                lower[i, i] = math.sqrt(bound + rest)
    return matrices.shape[0]

"""The robot: names, ranges, home posture, nominal inertias, and its place in a MultibodyPlant."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, SpatialInertia, UnitInertia

from scara_drake.common import checks
from scara_drake.common.resources import resource

Array = NDArray[np.float64]


def _constant(values: list[float]) -> Array:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


JOINT_NAMES: Final = ("d1", "theta2", "theta3", "theta4", "theta5", "theta6")
JOINT_UNITS: Final = ("m", "rad", "rad", "rad", "rad", "rad")
TOOL_FRAME: Final = "tool"

# Table 2 of the paper, [m] and [rad].
LOWER: Final = _constant([2.5, -2 * np.pi, -2 * np.pi, -0.75 * np.pi, -0.75 * np.pi, -2 * np.pi])
UPPER: Final = _constant([10.0, 2 * np.pi, 2 * np.pi, 0.75 * np.pi, 0.75 * np.pi, 2 * np.pi])
# Reference speeds that the drives are asked for, [m/s] and [rad/s]; see models/README.md.
MAX_SPEED: Final = _constant([0.5, 1.5, 1.5, 2.0, 3.0, 3.0])
# Effort limits, [N] and [N m]: enough to move as the experiments ask and to stop.
EFFORT: Final = _constant([15e3, 8e3, 3e3, 3e3, 500.0, 100.0])
# SCARA configuration with the tool along -y, away from every limit and singularity.
HOME: Final = _constant([3.0, -0.5, 0.0, -0.5, 1.0, 0.0])


def check_configuration(name: str, q: ArrayLike) -> Array:
    """Return q as a float array (6,) within the joint ranges.

    Raises:
        ValueError: not numbers, wrong shape, not finite, or outside Table 2; names the joint and
            its range.
    """
    allowed = "allowed (6,): d1 [m], theta2 .. theta6 [rad]"
    try:
        array = np.array(q, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: {q!r}, {allowed}") from None
    if array.shape != (6,):
        raise ValueError(f"{name}: shape {array.shape}, {allowed}")
    for joint, unit, value, low, high in zip(
        JOINT_NAMES, JOINT_UNITS, array, LOWER, UPPER, strict=True
    ):
        if not low <= value <= high:  # also refuses NaN
            raise ValueError(
                f"{name}: {joint} = {value:g} {unit}, allowed {low:.4g} to {high:.4g} {unit}"
            )
    return array


@dataclass
class RobotModel:
    """How the simulated robot differs from the nominal one, which the controllers know.

    Attributes:
        mass_scale: factors of the masses and of the rotational inertias of link_1 to link_6; the
            inertias of the drives stay.
        payload_mass: of a point mass that the tool holds [kg].
        payload_offset: where that is, in the tool frame [m].
    """

    mass_scale: list[float] = field(default_factory=lambda: [1.0] * 6)
    payload_mass: float = 0.0  # [kg]
    payload_offset: list[float] = field(default_factory=lambda: [0.0] * 3)  # [m]

    def validate(self, name: str) -> None:
        """Check the fields; `name` is the path in the scenario.

        Raises:
            ValueError: a number out of its range.
        """
        checks.vector(f"{name}.mass_scale", self.mass_scale, 6, 0.1, 10.0)
        checks.number(f"{name}.payload_mass", self.payload_mass, 0.0, 500.0)
        checks.vector(f"{name}.payload_offset", self.payload_offset, 3, -2.0, 2.0)


def add_scara(plant: MultibodyPlant, model: RobotModel | None = None) -> ModelInstanceIndex:
    """Add models/scara6.urdf to a plant that is not finalized; its base is welded to the world.

    Args:
        plant: receives the robot, and the body ``payload`` where the model has one.
        model: None is the nominal robot.
    """
    model = model or RobotModel()
    parser = Parser(plant)
    parser.package_map().AddPackageXml(resource("models", "package.xml"))
    if all(scale == 1.0 for scale in model.mass_scale):
        (instance,) = parser.AddModels(resource("models", "scara6.urdf"))
    else:
        (instance,) = parser.AddModelsFromString(_scaled_urdf(model.mass_scale), "urdf")
    if model.payload_mass > 0.0:
        point = SpatialInertia(model.payload_mass, np.zeros(3), UnitInertia(0.0, 0.0, 0.0))
        payload = plant.AddRigidBody("payload", instance, point)
        tool = plant.GetFrameByName(TOOL_FRAME, instance)
        X_EP = RigidTransform(np.array(model.payload_offset))
        plant.WeldFrames(tool, payload.body_frame(), X_EP)
    return instance


def _scaled_urdf(mass_scale: list[float]) -> str:
    """Return the URDF with the mass and the inertia of link_1 to link_6 times their factor."""
    ET.register_namespace("drake", "http://drake.mit.edu")  # Drake looks for its tags by prefix
    root = ET.parse(resource("models", "scara6.urdf")).getroot()
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
    samples = np.random.default_rng(0).uniform(LOWER, UPPER, (500, 6))
    logs = np.empty_like(samples)
    for row, q in zip(logs, samples, strict=True):
        plant.SetPositions(context, q)
        row[:] = np.log(np.diag(plant.CalcMassMatrix(context)))
    inertias = np.exp(logs.mean(axis=0))
    inertias.setflags(write=False)
    return inertias

"""What the tool can touch: walls, boxes and pipes, how they push back, and a pipe to cut."""

from scara_drake.environment.blade import Blade
from scara_drake.environment.box import Box
from scara_drake.environment.compliance import Compliance, ConstantVelocity, SineMotion
from scara_drake.environment.contact import ImpedanceContact
from scara_drake.environment.cutting import PipeCutting
from scara_drake.environment.cylinder import Cylinder
from scara_drake.environment.force import contact_force, tool_contact
from scara_drake.environment.law import normal_force
from scara_drake.environment.pipe import PipeCut
from scara_drake.environment.scene import ContactShapes, add_surfaces
from scara_drake.environment.surfaces import (
    Environment,
    Surface,
    surface_distance,
    surface_row,
)
from scara_drake.environment.wall import Wall

__all__ = [
    "Blade",
    "Box",
    "Compliance",
    "ConstantVelocity",
    "ContactShapes",
    "Cylinder",
    "Environment",
    "ImpedanceContact",
    "PipeCut",
    "PipeCutting",
    "SineMotion",
    "Surface",
    "Wall",
    "add_surfaces",
    "contact_force",
    "normal_force",
    "surface_distance",
    "surface_row",
    "tool_contact",
]

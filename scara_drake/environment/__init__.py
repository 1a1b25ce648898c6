"""What the tool can touch: walls, boxes and pipes, and how they push back."""

from scara_drake.environment.compliance import ConstantVelocity, SineMotion
from scara_drake.environment.contact import ImpedanceContact
from scara_drake.environment.law import contact_force, normal_force, surface_distance, tool_contact
from scara_drake.environment.scene import ContactShapes, add_surfaces
from scara_drake.environment.surfaces import Box, Cylinder, Environment, Surface, Wall

__all__ = [
    "Box",
    "ConstantVelocity",
    "ContactShapes",
    "Cylinder",
    "Environment",
    "ImpedanceContact",
    "SineMotion",
    "Surface",
    "Wall",
    "add_surfaces",
    "contact_force",
    "normal_force",
    "surface_distance",
    "tool_contact",
]

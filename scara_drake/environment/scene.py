"""The surfaces in Drake's geometry: what is drawn, and what stops the links."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    Box,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Shape,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from scara_drake import robot
from scara_drake.display import look
from scara_drake.environment.pipe import PipeCut
from scara_drake.environment.surfaces import Environment, Surface
from scara_drake.environment.wall import Wall

FRICTION = CoulombFriction(0.6, 0.5)
RIGID = 1e12  # stiffness of the tool where Drake's contact yields, so that the surface's counts
_TOOL_LINKS = ("link_6", robot.TOOL_FRAME)


@dataclass(frozen=True)
class ContactShapes:
    """Shapes between which Drake's own contact acts on the tool.

    Attributes:
        tool: shapes of the tool.
        compliant: shapes of the surfaces with the law "drake", to their index.
    """

    tool: frozenset[GeometryId]
    compliant: dict[GeometryId, int]


def add_surfaces(
    plant: MultibodyPlant, scene_graph: SceneGraph, environment: Environment
) -> ContactShapes:
    """Draw the surfaces at rest, and let them stop the links.

    The tool against a surface is `ImpedanceContact`'s: Drake's own contact between the two is
    excluded, or the force would count twice. Only with the law "drake" it is Drake's: compliant
    point contact, with the stiffness of the surface and the dissipation 3/2 alpha. A surface that
    moves is no part of the plant's geometry: `SceneAnnotations` draws it, and the other links pass
    through it.

    Call it after `robot.add_scara`, because filters and properties are for shapes that exist, and
    before `plant.Finalize()`, because it adds shapes.
    """
    tool = plant.CollectRegisteredGeometries([plant.GetBodyByName(name) for name in _TOOL_LINKS])
    world = plant.world_body()
    filters = scene_graph.collision_filter_manager()
    compliant: dict[GeometryId, int] = {}
    for index, surface in enumerate(environment.surfaces):
        if surface.motion is not None:
            continue
        X_WS = surface.pose()
        for name, shape, X_SG, color in drawing(surface):
            plant.RegisterVisualGeometry(world, X_WS @ X_SG, shape, name, np.array(color))
        shape, X_SG = surface.shape()
        properties = ProximityProperties()
        drake = surface.law == "drake"
        AddContactMaterial(
            properties,
            dissipation=1.5 * surface.alpha if drake else None,
            point_stiffness=surface.stiffness if drake else None,
            friction=FRICTION,
        )
        solid = plant.RegisterCollisionGeometry(
            world, X_WS @ X_SG, shape, f"{surface.name}_shape", properties
        )
        if drake:
            compliant[solid] = index
        else:
            filters.Apply(CollisionFilterDeclaration().ExcludeBetween(tool, GeometrySet(solid)))
    if environment.cut is not None:
        solid = _add_pipe(plant, environment.cut)
        filters.Apply(CollisionFilterDeclaration().ExcludeBetween(tool, GeometrySet(solid)))
    shapes = [
        shape
        for name in _TOOL_LINKS
        for shape in plant.GetCollisionGeometriesForBody(plant.GetBodyByName(name))
    ]
    if compliant:
        _make_rigid(plant, scene_graph, shapes)
    return ContactShapes(frozenset(shapes), compliant)


def _add_pipe(plant: MultibodyPlant, pipe: PipeCut) -> GeometryId:
    """Draw a pipe to cut, and return what stops the links but the tool."""
    world, X_WS, (shape, _) = plant.world_body(), pipe.pose(), pipe.solid().shape()
    plant.RegisterVisualGeometry(world, X_WS, shape, pipe.name, np.array(look.PIPE))
    properties = ProximityProperties()
    AddContactMaterial(properties, friction=FRICTION)
    return plant.RegisterCollisionGeometry(world, X_WS, shape, f"{pipe.name}_shape", properties)


def _make_rigid(plant: MultibodyPlant, scene_graph: SceneGraph, shapes: list[GeometryId]) -> None:
    """Let shapes neither yield nor dissipate beside a compliant surface."""
    source = plant.get_source_id()
    assert source is not None  # the plant is registered with its scene graph, it has shapes there
    for shape in shapes:
        properties = scene_graph.model_inspector().GetProximityProperties(shape)
        rigid = ProximityProperties(properties)
        for name, value in (("point_contact_stiffness", RIGID), ("hunt_crossley_dissipation", 0.0)):
            rigid.UpdateProperty("material", name, value)
        scene_graph.AssignRole(source, shape, rigid, RoleAssign.kReplace)


def drawing(surface: Surface) -> list[tuple[str, Shape, RigidTransform, tuple[float, ...]]]:
    """Return what a surface looks like: of each part the name, shape, pose X_SG and colour."""
    shape, X_SG = surface.shape()
    parts: list[tuple[str, Shape, RigidTransform, tuple[float, ...]]]
    parts = [(surface.name, shape, X_SG, look.SURFACE)]
    if isinstance(surface, Wall):
        for bar in look.edge_frame(surface.size, surface.thickness):
            X_SF = X_SG @ RigidTransform(bar.X)
            parts.append((f"{surface.name}_{bar.name}", Box(*bar.size), X_SF, bar.color))
    return parts

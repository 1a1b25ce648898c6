"""The scene in Meshcat: the plant by Drake's own visualizers, and our annotations."""

from __future__ import annotations

from numpy.typing import ArrayLike
from pydrake.geometry import (
    Meshcat,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Role,
    SceneGraph,
)
from pydrake.lcm import DrakeLcm
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from pydrake.visualization import ApplyVisualizationConfig, VisualizationConfig

from scara_drake.display.annotations import PERIOD, ROBOT, SceneAnnotations
from scara_drake.display.camera import set_camera
from scara_drake.environment import Environment

NEVER = 1e9  # [s]
# Drake ends the program where a Meshcat is freed by another thread than its own, and the garbage
# collector frees a Diagram, with what it draws on, in whichever thread it happens to run.
_DRAWN_ON: list[Meshcat] = []


def add_visualization(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    meshcat: Meshcat,
    environment: Environment,
    collision_shapes: bool = False,
    places: ArrayLike = (),
) -> SceneAnnotations:
    """Draw a finalized plant and return the annotations, named and in the builder, to be connected.

    Args:
        builder: of the Diagram that holds the plant and the scene graph.
        plant: with the robot and the surfaces.
        scene_graph: of the plant.
        meshcat: where to draw; its camera is set.
        environment: the surfaces, for the camera and for those that move.
        places: (n, 3) [m] where the robot goes, for the camera.
        collision_shapes: also offers Drake's collision shapes and contact forces, for debugging.
    """
    if not any(meshcat is other for other in _DRAWN_ON):
        _DRAWN_ON.append(meshcat)
    config = VisualizationConfig(
        publish_period=PERIOD,
        publish_illustration=False,
        publish_proximity=collision_shapes,
        publish_contacts=collision_shapes,
        publish_inertia=False,
    )
    ApplyVisualizationConfig(
        config,
        builder,
        plant=plant,
        scene_graph=scene_graph,
        meshcat=meshcat,
        lcm=DrakeLcm("memq://null"),  # nothing goes on the network
    )
    # It puts the shapes there at the start; the annotations move them, where there is time.
    shapes = MeshcatVisualizerParams(
        role=Role.kIllustration, prefix=ROBOT, publish_period=NEVER, visible_by_default=True
    )
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, shapes)
    set_camera(meshcat, environment, places)
    annotations = builder.AddNamedSystem(
        "annotations", SceneAnnotations(meshcat, surfaces=environment.surfaces)
    )
    builder.Connect(scene_graph.get_query_output_port(), annotations.GetInputPort("query_object"))
    return annotations

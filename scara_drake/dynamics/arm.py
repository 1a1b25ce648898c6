"""A finalized plant as the array that `equations` step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, PrismaticJoint, RevoluteJoint
from pydrake.systems.framework import Context

from scara_drake.dynamics.equations import ARM, JOINTS

Array = NDArray[np.float64]


def arm_parameters(plant: MultibodyPlant) -> Array:
    """Return a plant as `equations.arm_of` reads it.

    Raises:
        ValueError: it is not a chain of six joints, each along or about the z axis of its
            frame and at the origin of the link that it moves.
    """
    context = plant.CreateDefaultContext()
    joints = moving_joints(plant)
    rows = [_link(plant, context, joint) for joint in joints]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return ARM.pack(
        **columns,
        gravity=plant.gravity_field().gravity_vector(),
        period=plant.time_step(),
    )


def moving_joints(plant: MultibodyPlant) -> list[Joint]:
    """Return the joints that move, in the order of the velocities."""
    moving = [plant.get_joint(index) for index in plant.GetJointIndices()]
    moving = sorted((j for j in moving if j.num_velocities()), key=lambda j: j.velocity_start())
    kinds = (PrismaticJoint, RevoluteJoint)
    if len(moving) != JOINTS or not all(isinstance(joint, kinds) for joint in moving):
        raise ValueError(f"plant: {len(moving)} joints, allowed {JOINTS} that slide or turn")
    anchored = plant.world_body()
    for joint in moving:
        welded = {body.index() for body in plant.GetBodiesWeldedTo(anchored)}
        if joint.parent_body().index() not in welded:
            raise ValueError(f"plant: joint '{joint.name()}' does not follow the one before")
        anchored = joint.child_body()
    return moving


def _link(plant: MultibodyPlant, context: Context, joint: Joint) -> dict[str, object]:
    """Return the row of a joint and of the link that it moves."""
    link = joint.child_body()
    if not joint.frame_on_child().GetFixedPoseInBodyFrame().IsExactlyIdentity():
        raise ValueError(f"plant: joint '{joint.name()}' is not at the origin of its link")
    if not np.array_equal(axis_of(joint), [0.0, 0.0, 1.0]):
        raise ValueError(f"plant: axis of joint '{joint.name()}', allowed z")
    # The link before it carries the joint, maybe by a body that is welded to it.
    before = _mover(plant, joint)
    X_PJ = plant.CalcRelativeTransform(context, before, joint.frame_on_parent())
    bodies = [body.index() for body in plant.GetBodiesWeldedTo(link)]
    M_L = plant.CalcSpatialInertia(context, link.body_frame(), bodies)
    about_com = M_L.Shift(M_L.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    drive = next(
        actuator
        for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
        if actuator.joint().index() == joint.index()
    )
    return {
        "slides": float(isinstance(joint, PrismaticJoint)),
        "R_PJ": X_PJ.rotation().matrix(),
        "p_PJ": X_PJ.translation(),
        "mass": M_L.get_mass(),
        "p_com": M_L.get_com(),
        "inertia": about_com,
        "armature": drive.default_reflected_inertia(),
        "damping": joint.default_damping_vector()[0],
        "effort": drive.effort_limit(),
        "lower": joint.position_lower_limits()[0],
        "upper": joint.position_upper_limits()[0],
    }


def axis_of(joint: Joint) -> Array:
    """Return along or about which axis (3,) of its frame a joint moves; NaN for another kind."""
    if isinstance(joint, PrismaticJoint):
        return np.asarray(joint.translation_axis(), dtype=np.float64)
    if isinstance(joint, RevoluteJoint):
        return np.asarray(joint.revolute_axis(), dtype=np.float64)
    return np.full(3, np.nan)


def _mover(plant: MultibodyPlant, joint: Joint) -> Frame:
    """Return the frame of the link that moves a joint: of the one before, or the world's."""
    welded = {body.index() for body in plant.GetBodiesWeldedTo(joint.parent_body())}
    if plant.world_body().index() in welded:
        return plant.world_frame()
    for index in plant.GetJointIndices():
        other = plant.get_joint(index)
        if other.num_velocities() and other.child_body().index() in welded:
            return other.child_body().body_frame()
    raise ValueError(f"plant: nothing moves joint '{joint.name()}'")

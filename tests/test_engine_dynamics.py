"""The engine's step of the arm against that of Drake's plant."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from strategies import examples

from scara_drake import joints
from scara_drake.dynamics.arm import arm_parameters
from scara_drake.dynamics.equations import ARM, WORK, plant_step, set_efforts
from scara_drake.robot import RobotModel, add_scara

PERIOD = 1e-3  # [s]
# Further in, no joint gets to its limit within two periods.
MARGIN = 0.02  # [m], [rad]

MODELS = {
    "nominal": RobotModel(),
    "payload": RobotModel(payload_mass=40.0, payload_offset=[0.1, -0.2, 0.05]),
    "scaled": RobotModel(mass_scale=[0.3, 2.0, 1.5, 0.7, 3.0, 1.2]),
}


def plant_of(model: RobotModel) -> tuple[Simulator, MultibodyPlant]:
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=PERIOD), builder)
    add_scara(plant, model)
    plant.Finalize()
    builder.ExportInput(plant.get_actuation_input_port(), "tau")
    builder.ExportInput(plant.get_applied_generalized_force_input_port(), "force")
    return Simulator(builder.Build()), plant


PLANTS = {name: plant_of(model) for name, model in MODELS.items()}

units = st.floats(0.0, 1.0)
signs = st.floats(-1.0, 1.0)


def drake_step(simulator, plant, q, v, tau, force):
    """The state (12,) of the plant after its step."""
    diagram = simulator.get_system()
    context = diagram.CreateDefaultContext()
    plant.SetPositionsAndVelocities(
        plant.GetMyMutableContextFromRoot(context), np.concatenate([q, v])
    )
    diagram.GetInputPort("tau").FixValue(context, tau)
    diagram.GetInputPort("force").FixValue(context, force)
    simulator.reset_context(context)
    simulator.Initialize()
    simulator.AdvanceTo(0.5 * PERIOD)
    return plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(simulator.get_context()))


@examples(60)
@given(
    name=st.sampled_from(sorted(PLANTS)),
    place=st.lists(units, min_size=6, max_size=6),
    speed=st.lists(signs, min_size=6, max_size=6),
    effort=st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6),
    push=st.lists(signs, min_size=6, max_size=6),
)
def test_a_step_is_that_of_drakes_plant(name, place, speed, effort, push):
    simulator, plant = PLANTS[name]
    low, high = joints.LOWER + MARGIN, joints.UPPER - MARGIN
    q, v = low + np.array(place) * (high - low), np.array(speed) * joints.MAX_SPEED
    tau, force = np.array(effort) * joints.EFFORT, 500.0 * np.array(push)
    expected = drake_step(simulator, plant, q, v, tau, force)
    arm, work, state = arm_parameters(plant), WORK.zeros(), np.concatenate([q, v])
    set_efforts(tau, force, arm, work)
    assert plant_step(arm, work, state)
    # The efforts are up to three times the drives' limits: both keep them.
    np.testing.assert_allclose(state, expected, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("joint", range(6))
def test_a_joint_that_would_reach_its_limit_is_not_stepped(joint):
    _, plant = PLANTS["nominal"]
    arm, work = arm_parameters(plant), WORK.zeros()
    state = np.concatenate([joints.HOME, np.zeros(6)])
    state[joint] = joints.UPPER[joint] - 1e-3
    state[6 + joint] = 1.0
    before = state.copy()
    assert not plant_step(arm, work, state)
    assert WORK.unpack(work).beyond[()] == joint + 1
    np.testing.assert_array_equal(state, before)
    state[6 + joint] = 0.1  # two periods from here it is still within
    assert plant_step(arm, work, state)


def test_the_arms_data_are_those_of_the_plant():
    _, plant = PLANTS["payload"]
    arm = ARM.unpack(arm_parameters(plant))
    context = plant.CreateDefaultContext()
    assert arm.mass.sum() == pytest.approx(plant.CalcTotalMass(context), rel=1e-14)
    assert list(arm.slides) == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    np.testing.assert_array_equal(arm.effort, joints.EFFORT)


def test_another_robot_is_refused():
    plant = MultibodyPlant(time_step=PERIOD)
    plant.Finalize()
    with pytest.raises(ValueError, match="0 joints, allowed 6"):
        arm_parameters(plant)

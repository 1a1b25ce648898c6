import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports, tick
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant

from scara_drake import joints, kinematics, load_scenario, robot, simulate
from scara_drake.control.contact_estimate import (
    ContactForceEstimator,
    nominal_arm,
    tool_force,
    unexplained_effort,
)
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.dynamics.equations import WORK

M_HAT = robot.nominal_inertias()


@functools.cache
def plant():
    found = MultibodyPlant(time_step=0.0)
    robot.add_scara(found)
    found.Finalize()
    return found


def force_of(q, effort):
    """What `tool_force` writes."""
    f_W = np.empty(3)
    tool_force(q, effort, M_HAT, f_W)
    return f_W


def posture(rng):
    """Within the ranges, away from the stretched arm."""
    q = rng.uniform(joints.LOWER, joints.UPPER)
    q[4] = rng.uniform(0.4, 2.0)
    return q


def acceleration_under_a_push(q, v, tau, f_W):
    """Drake's own answer: v' of the robot with a force on the tool point."""
    context = plant().CreateDefaultContext()
    plant().SetPositions(context, q)
    plant().SetVelocities(context, v)
    plant().get_actuation_input_port().FixValue(context, tau)
    tool = plant().GetFrameByName(robot.TOOL_FRAME)
    push = ExternallyAppliedSpatialForce()
    push.body_index = tool.body().index()
    push.p_BoBq_B = tool.GetFixedPoseInBodyFrame().translation()
    push.F_Bq_W = SpatialForce(np.zeros(3), f_W)
    plant().get_applied_spatial_force_input_port().FixValue(context, Value([push]))
    return plant().EvalTimeDerivatives(context).CopyToVector()[6:]


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_of_an_exact_acceleration_the_force_is_exact(seed):
    rng = np.random.default_rng(seed)
    q, v, tau = posture(rng), rng.normal(0, 0.5, 6), rng.normal(0, 100.0, 6)
    f_W = rng.normal(0, 100.0, 3)
    v_dot = acceleration_under_a_push(q, v, tau, f_W)
    effort = np.empty(6)
    unexplained_effort(q, v, v_dot, tau, nominal_arm(), WORK.zeros(), effort)
    np.testing.assert_allclose(force_of(q, effort), f_W, atol=1e-6)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_the_weights_make_the_residue_the_least_in_units_of_the_inertias(seed):
    rng = np.random.default_rng(seed)
    q, effort = posture(rng), M_HAT * rng.normal(size=6)
    J_v = kinematics.jacobian(q)[3:]
    residue = effort - J_v.T @ force_of(q, effort)
    np.testing.assert_allclose(J_v @ (residue / M_HAT), 0.0, atol=1e-9)


def test_along_a_stretched_arm_there_is_no_force_to_feel():
    q = np.array([3.0, 0.3, 0.0, np.pi / 2, np.pi / 2, 0.0])
    J_v = kinematics.jacobian(q)[3:]
    blind = np.linalg.svd(J_v)[0][:, -1]
    assert np.linalg.norm(J_v.T @ blind) < 1e-9
    force = force_of(q, M_HAT * np.random.default_rng(0).normal(size=6))
    assert abs(force @ blind) < 1e-6 * np.linalg.norm(force)


def estimator_and_context():
    system = ContactForceEstimator()
    system.set_name("contact_estimate")
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.concatenate([joints.HOME, np.zeros(6)]))
    for name in ("actuation_lagged", "perturbation_estimate", "velocity_estimate"):
        system.GetInputPort(name).FixValue(context, np.zeros(6))
    return system, context


def test_ports():
    system, _ = estimator_and_context()
    assert ports(system) == (
        {
            "state": 12,
            "actuation_lagged": 6,
            "perturbation_estimate": 6,
            "velocity_estimate": 6,
        },
        {"f_estimated_W": 3},
    )


def test_held_against_gravity_it_feels_nothing_and_pushed_the_push():
    system, context = estimator_and_context()
    model = plant().CreateDefaultContext()
    plant().SetPositions(model, joints.HOME)
    hold = -plant().CalcGravityGeneralizedForces(model)
    f_W = np.array([20.0, -30.0, 50.0])
    for push in (np.zeros(3), f_W):
        tau = hold - kinematics.jacobian(joints.HOME)[3:].T @ push
        system.GetInputPort("actuation_lagged").FixValue(context, tau)
        # At rest: Psi = -tau / m_hat.
        system.GetInputPort("perturbation_estimate").FixValue(context, -tau / M_HAT)
        tick(system, context)
        np.testing.assert_allclose(system.get_output_port().Eval(context), push, atol=1e-9)


def test_a_clone_has_a_model_of_its_own():
    system, context = estimator_and_context()
    tick(system, context)
    clone = context.Clone()
    moved = np.concatenate([joints.HOME + 0.1, np.zeros(6)])
    system.GetInputPort("state").FixValue(clone, moved)
    tick(system, clone)
    before = system.get_output_port().Eval(context).copy()
    assert np.abs(system.get_output_port().Eval(clone) - before).max() > 1.0
    tick(system, context)
    np.testing.assert_array_equal(system.get_output_port().Eval(context), before)


def test_what_is_not_a_number_stops_the_run():
    system, context = estimator_and_context()
    system.GetInputPort("velocity_estimate").FixValue(context, np.full(6, np.nan))
    with pytest.raises(RuntimeError, match=r"contact_estimate: port 'velocity_estimate' at t = 0"):
        tick(system, context)


@pytest.mark.parametrize("bad", [{"period": 0.0}, {"settling": -1.0}])
def test_bad_settings_are_refused(bad):
    with pytest.raises(ValueError, match="allowed"):
        ContactForceEstimator(**bad)


@pytest.mark.slow  # the experiment perturbation_observer sees the same in a shorter press
def test_in_steady_pressing_it_is_within_a_tenth_of_the_true_force():
    scenario = load_scenario("teleoperation")
    scenario.controller = ObserverSlidingMode()
    run = simulate(scenario, duration=24.0)
    free = run.sel(time=slice(13.0, 15.0))
    assert float(abs(free.f_env_on_tool_W).max()) == 0.0
    assert float(abs(free.f_estimated_W).max()) < 5.0
    pressing = run.sel(time=slice(22.5, 24.0))
    force = (pressing.f_env_on_tool_W**2).sum("axis") ** 0.5
    assert float(force.min()) > 100.0
    error = ((pressing.f_estimated_W - pressing.f_env_on_tool_W) ** 2).sum("axis") ** 0.5
    assert float((error / force).max()) < 0.1

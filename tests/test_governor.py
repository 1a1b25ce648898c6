import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from scara_drake import robot
from scara_drake.common.fields import check
from scara_drake.control.governor import BOUNDS, ReferenceGovernor, ReferenceGovernorSystem, govern
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.inverse_dynamics import InverseDynamics
from scara_drake.joints import EFFORT, MAX_SPEED
from scara_drake.operator.joint_motion import JointMotion, JointMotionSource

TS = 1e-3


def one_joint(speed=0.8, acceleration=4.0):
    """Bounds of one joint."""
    return BOUNDS.pack(speed=speed, acceleration=acceleration)


def advance(offset, lost=0.0, bounds=None):
    """Advance by one period in which a drive lost this much acceleration."""
    govern(np.array([lost]), one_joint() if bounds is None else bounds, TS, offset)


def test_the_offset_is_the_lost_acceleration_integrated_twice():
    bounds = one_joint(1e-9, 1e-9)  # no return to speak of
    offset = np.zeros(2)
    for _ in range(200):
        advance(offset, -3.0, bounds)
    t = 200 * TS
    np.testing.assert_allclose(offset, [-0.5 * 3.0 * t * (t + TS), -3.0 * t], rtol=1e-6)


@settings(deadline=None, max_examples=100)
@given(
    st.floats(-2.0, 2.0),
    st.floats(-0.8, 0.8),
    st.floats(0.1, 2.0),
    st.floats(1.0, 20.0),
)
def test_the_return_keeps_its_bounds_stops_at_zero_and_does_not_pass_it(q, v, speed, acceleration):
    v = min(max(v, -speed), speed)
    # From where it can stop: a return that has to turn round first may pass through zero once.
    moving_in = q * v < 0.0 and v * v > 0.5 * acceleration * abs(q)
    offset = np.array([q, 0.0 if moving_in else v])
    bounds = one_joint(speed, acceleration)
    slowest = 2.0 * abs(q) / speed + 2.0 * speed / acceleration + 1.0
    offsets = [offset.copy()]
    for _ in range(round(3.0 * slowest / TS)):
        advance(offset, 0.0, bounds)
        offsets.append(offset.copy())
    path = np.array(offsets)
    step = acceleration * TS
    assert np.abs(path[:, 1]).max() <= speed * (1 + 1e-9)
    assert np.abs(np.diff(path[:, 1])).max() <= step * (1 + 1e-9)
    np.testing.assert_array_equal(path[-1], 0.0)  # exactly
    if q != 0.0:
        assert (path[:, 0] * np.sign(q)).min() >= -step * TS


def test_joints_are_governed_one_by_one():
    offset = np.zeros(6)
    govern(np.array([0.0, -30.0, 30.0]), np.repeat(one_joint(), 3, axis=1), TS, offset)
    np.testing.assert_allclose(offset[3:], [0.0, -30.0 * TS, 30.0 * TS])
    np.testing.assert_allclose(offset[:3], TS * offset[3:])


def test_ports_and_pass_through_to_the_bit():
    system = ReferenceGovernor().make_system(TS)
    assert ports(system) == (
        {"state_desired": 12, "actuation_commanded": 6, "actuation": 6},
        {"state_desired_governed": 12, "reference_offset": 12},
    )
    # The output reads the references at once, and the efforts never.
    governed = int(system.GetOutputPort("state_desired_governed").get_index())
    offset = int(system.GetOutputPort("reference_offset").get_index())
    assert [system.HasDirectFeedthrough(i, governed) for i in range(3)] == [True, False, False]
    assert not system.HasDirectFeedthrough(offset)
    context = system.CreateDefaultContext()
    for reference in np.random.default_rng(0).normal(size=(20, 12)):
        system.GetInputPort("state_desired").FixValue(context, reference)
        governed = system.GetOutputPort("state_desired_governed").Eval(context)
        np.testing.assert_array_equal(governed, reference)


class Arm:
    """The arm in closed loop with a motion of its joints, with or without a governor."""

    def __init__(self, motion, controller, governor=None):
        builder = DiagramBuilder()
        plant = builder.AddNamedSystem("plant", MultibodyPlant(time_step=TS))
        robot.add_scara(plant)
        plant.Finalize()
        plant.SetDefaultPositions(motion.start_state()[:6])
        source = builder.AddNamedSystem("source", JointMotionSource(motion))
        system = builder.AddNamedSystem("controller", controller.make_system(TS))
        desired = source.GetOutputPort("state_desired")
        if governor is not None:
            inserted = builder.AddNamedSystem("governor", governor.make_system(TS))
            builder.Connect(desired, inserted.GetInputPort("state_desired"))
            for name in ("actuation_commanded", "actuation"):
                builder.Connect(system.GetOutputPort(name), inserted.GetInputPort(name))
            desired = inserted.GetOutputPort("state_desired_governed")
        builder.Connect(desired, system.GetInputPort("state_desired"))
        builder.Connect(plant.get_state_output_port(), system.GetInputPort("state"))
        builder.Connect(system.GetOutputPort("actuation"), plant.get_actuation_input_port())
        self._logs = [
            LogVectorOutput(port, builder, TS)
            for port in (
                plant.get_state_output_port(),
                desired,
                system.GetOutputPort("actuation_commanded"),
            )
        ]
        self._diagram = builder.Build()

    def run(self, duration):
        """Return states, references and commanded efforts, each (n, ...)."""
        simulator = Simulator(self._diagram)
        simulator.AdvanceTo(duration)
        context = simulator.get_context()
        return [log.FindLog(context).data().T.copy() for log in self._logs]


def swing(duration, displacement=2.0):
    """A move of joint 2."""
    displacements = [0.0, displacement, 0.0, 0.0, 0.0, 0.0]
    return JointMotion(displacement=displacements, start=0.1, move_duration=duration)


@pytest.mark.parametrize("controller", [IntegralSlidingMode(), InverseDynamics()])
def test_a_slow_motion_is_the_same_to_the_bit_with_and_without(controller):
    runs = [
        Arm(swing(1.5), controller, governor).run(0.8) for governor in (None, ReferenceGovernor())
    ]
    for without, governed in zip(*runs, strict=True):
        np.testing.assert_array_equal(without, governed)


@pytest.mark.parametrize("controller", [IntegralSlidingMode(), InverseDynamics()])
def test_a_fast_motion_no_longer_overshoots(controller):
    # 2 rad in 0.35 s ask for 94 rad/s² of a drive that gives the nominal inertia 41.
    motion = swing(0.35)
    goal = motion.start_state()[1] + 2.0
    overshoot, late = [], []
    for governor in (None, ReferenceGovernor()):
        state, desired, tau = Arm(motion, controller, governor).run(3.5)
        assert (np.abs(tau[:, 1]) > EFFORT[1]).sum() > 100
        overshoot.append(state[:, 1].max() - goal)
        late.append(abs(state[-1, 1] - goal))
        # It joins the source without a jump: never more than the source's own acceleration.
        assert np.abs(np.diff(desired[:, 7])).max() < 1.02 * 94.3 * TS
    assert overshoot[0] > 0.3
    assert overshoot[1] < 0.01
    assert late[1] < 1e-4
    np.testing.assert_array_equal(desired[-1, 6:], 0.0)


def test_memory_is_in_the_context():
    arm = Arm(swing(0.35), IntegralSlidingMode(), ReferenceGovernor())
    first, again = arm.run(0.5), arm.run(0.5)
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("field", ["speed", "acceleration"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf])
def test_bad_bounds_are_refused_by_name(field, value):
    governor = ReferenceGovernor()
    getattr(governor, field)[3] = value
    with pytest.raises(ValueError, match=rf"^governor\.{field}\[3\]: "):
        check(governor, "governor")


def test_the_defaults_leave_the_drives_most_of_their_effort():
    governor = ReferenceGovernor()
    check(governor, "governor")
    assert isinstance(governor.make_system(TS), ReferenceGovernorSystem)
    weight = np.array([9.81, 0.0, 0.0, 0.0, 0.0, 0.0])
    able = EFFORT / robot.nominal_inertias() - weight
    assert (governor.acceleration < 0.25 * able).all()
    assert (governor.speed <= MAX_SPEED).all()

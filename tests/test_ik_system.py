import numpy as np
import pytest
import strategies
from hypothesis import given
from hypothesis import strategies as st
from leaf import outputs, ports, tick
from scipy.spatial.transform import Rotation

from scara_drake import kinematics
from scara_drake.common.fields import check
from scara_drake.ik import servo, solve
from scara_drake.ik.system import InverseKinematics, InverseKinematicsSystem, first_posture
from scara_drake.joints import HOME, LOWER, MAX_SPEED, UPPER
from scara_drake.operator.mapping import JoystickMapping, initial_command
from scara_drake.vectors import pose_matrix

COMMAND = initial_command(JoystickMapping())


def system_and_context(command=COMMAND, **options):
    system = InverseKinematicsSystem(InverseKinematics(**options), COMMAND, seed=1)
    context = system.CreateDefaultContext()
    system.get_input_port().FixValue(context, command)
    return system, context


def test_ports():
    system, _ = system_and_context()
    assert ports(system) == (
        {"tool_command": 8},
        {
            "state_desired": 12,
            "servo_state": 17,
            "X_WE_desired": 7,
            "status": 1,
            "motion_limited": 6,
        },
    )


@pytest.mark.parametrize("method", ["dpsoij", "inverse_jacobian", "dpso", "pso"])
def test_starts_at_the_answer_for_the_first_command(method):
    system, context = system_and_context(method=method)
    state = system.GetOutputPort("state_desired").Eval(context)
    distance, _ = kinematics.pose_error(
        pose_matrix(COMMAND), kinematics.forward_kinematics(state[:6])
    )
    assert distance < 5e-3
    np.testing.assert_array_equal(state[6:], 0.0)
    assert state[0] == COMMAND[7]


@pytest.mark.parametrize(("joints", "task"), [("arm", "position"), ("full", "pose")])
def test_the_first_posture_is_on_the_branch_nearest_home(joints, task):
    """No answer of an exhaustive search is nearer to home and as good."""
    rng = np.random.default_rng(4)
    for _ in range(3):
        command = COMMAND.copy()
        command[:3] += rng.uniform(-0.3, 0.3, 3)
        config = InverseKinematics(joints=joints, task=task)
        home = HOME.copy()
        home[0] = command[7]
        answer = first_posture(config, command, seed=0)
        _, angle = kinematics.pose_error(
            pose_matrix(command), kinematics.forward_kinematics(answer)
        )
        distance = np.linalg.norm(answer - home)
        for _ in range(60):
            start = rng.uniform(LOWER, UPPER)
            start[0] = command[7]
            other = solve(
                pose_matrix(command),
                "inverse_jacobian",
                joints,
                task,
                q_seed=start,
                max_iterations=200,
            )
            if other.success and other.rotation_error < angle - 1e-3:
                pytest.fail(f"better oriented: {other.q}")
            if other.success and other.rotation_error < angle + 1e-3:
                # Wraps of a whole turn are other answers too: take the nearest.
                turns = 2 * np.pi * np.round((other.q - home) / (2 * np.pi)) * [0, 1, 1, 0, 0, 1]
                assert np.linalg.norm(other.q - turns - home) > distance - 1e-2


def test_an_unreachable_first_command_is_refused():
    command = COMMAND.copy()
    command[0] = 5.0
    with pytest.raises(ValueError, match=r"^first tool command: \[5\.000, -0\.760, 3\.000\] m"):
        InverseKinematicsSystem(InverseKinematics(), command)


def test_a_target_that_cannot_be_reached_is_held_and_said():
    # The full pose asks for an orientation that the arm does not have at that height of the mast.
    command = COMMAND.copy()
    command[:3] = [0.0, 0.0, 9.0]
    system, context = system_and_context(command, joints="full", task="pose", method="dpso")
    before = system.GetOutputPort("state_desired").Eval(context)
    for _ in range(400):
        tick(system, context)
        after = system.GetOutputPort("state_desired").Eval(context)
        assert np.isfinite(after).all()
        if system.GetOutputPort("status").Eval(context)[0] == 1.0:
            np.testing.assert_array_equal(after[6:], 0.0)
    del before


@pytest.mark.parametrize("method", ["dpsoij", "dpso"])
def test_memory_is_in_the_context(method):
    command = COMMAND.copy()
    command[:3] += [0.1, 0.05, -0.1]
    system, context = system_and_context(command, method=method)
    start = outputs(system, context)
    for _ in range(5):
        tick(system, context)
    clone = context.Clone()
    for _ in range(5):
        tick(system, context)
        tick(system, clone)
    np.testing.assert_array_equal(outputs(system, context), outputs(system, clone))
    np.testing.assert_array_equal(outputs(system, system.CreateDefaultContext()), start)


@pytest.mark.parametrize("task", ["position", "pose"])
def test_dpso_at_every_sample_jumps_and_dpsoij_does_not(task):
    """Figure 22 in kind: the swarm answers each sample anew, on any branch, and the joints lag."""
    moving = np.tile(COMMAND, (60, 1))
    moving[:, 0] += np.linspace(0.0, 0.02, 60)

    def run(method):
        joints = "arm" if task == "position" else "full"
        system, context = system_and_context(method=method, joints=joints, task=task)
        q, statuses = [], set()
        for command in moving:
            system.get_input_port().FixValue(context, command)
            tick(system, context)
            statuses.add(float(system.GetOutputPort("status").Eval(context)[0]))
            q.append(system.GetOutputPort("state_desired").Eval(context)[:6])
        assert np.abs(np.ptp(q, axis=0)).max() > 0.0
        return np.abs(np.diff(q, axis=0)), statuses

    steps, statuses = run("dpsoij")
    assert steps.max() < 3e-3
    assert statuses == {servo.TRACKING}
    steps, statuses = run("dpso")
    assert servo.CATCHING_UP in statuses
    # At the speed limit of some joint in many samples, and never beyond.
    assert np.median((steps / (1e-3 * MAX_SPEED)).max(axis=1)) > 0.99


@pytest.mark.parametrize(
    ("method", "joints", "task"),
    [
        ("dpsoij", "arm", "position"),
        ("dpsoij", "full", "pose"),
        ("inverse_jacobian", "full", "pose"),
        ("robust", "arm", "pose"),
        ("closed_form", "full", "pose"),
        ("dpso", "arm", "position"),
        ("pso", "arm", "position"),
    ],
)
@strategies.examples(4)
@given(
    offset=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    turned=st.tuples(*[st.floats(-np.pi, np.pi)] * 3),
    mast=st.floats(-5.0, 15.0),
)
def test_references_never_exceed_the_joint_speeds(method, joints, task, offset, turned, mast):
    """Whatever is commanded, near, out of reach or elsewhere turned, and whatever the method."""
    system, context = system_and_context(method=method, joints=joints, task=task)
    command = COMMAND.copy()
    command[:3] += offset
    command[3:7] = Rotation.from_rotvec(turned).as_quat(scalar_first=True)
    command[7] = mast
    system.get_input_port().FixValue(context, command)
    before = system.GetOutputPort("state_desired").Eval(context).copy()
    for _ in range(40):
        tick(system, context)
        after = system.GetOutputPort("state_desired").Eval(context).copy()
        assert np.all(np.abs(after[:6] - before[:6]) <= 1e-3 * MAX_SPEED * (1 + 1e-9))
        assert np.all(np.abs(after[6:]) <= MAX_SPEED * (1 + 1e-9))
        assert np.all((after[:6] >= LOWER) & (after[:6] <= UPPER))
        before = after


def test_the_closed_form_at_every_sample_follows_without_a_jump():
    moving = np.tile(COMMAND, (60, 1))
    moving[:, 0] += np.linspace(0.0, 0.02, 60)
    system, context = system_and_context(method="closed_form", joints="full", task="pose")
    q = [system.GetOutputPort("state_desired").Eval(context)[:6]]
    for command in moving:
        system.get_input_port().FixValue(context, command)
        tick(system, context)
        assert system.GetOutputPort("status").Eval(context)[0] == 0.0
        state = system.GetOutputPort("state_desired").Eval(context)
        pose = system.GetOutputPort("X_WE_desired").Eval(context)
        distance, angle = kinematics.pose_error(
            pose_matrix(pose), kinematics.forward_kinematics(state[:6])
        )
        assert distance < 1e-9
        assert angle < 1e-8
        q.append(state[:6])
    assert np.abs(np.diff(q, axis=0)).max() < 3e-3
    with pytest.raises(ValueError, match=r"task with method closed_form: 'position', allowed pose"):
        check(InverseKinematics(method="closed_form"), "inverse_kinematics")


@pytest.mark.parametrize(
    ("field", "value"), [("method", "magic"), ("joints", "legs"), ("task", "all"), ("max_speed", 0)]
)
def test_bad_fields_are_refused(field, value):
    with pytest.raises(ValueError, match=rf"^inverse_kinematics\.{field}: .*allowed"):
        check(InverseKinematics(**{field: value}), "inverse_kinematics")

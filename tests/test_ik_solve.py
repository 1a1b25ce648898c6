"""The public calls: every success is confirmed here by forward kinematics, never by the solver."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.math import RigidTransform

from scara_drake import ik, kinematics
from scara_drake.joints import HOME, LOWER, UPPER

# Table 5 of the paper, [mm] and [rad]; positions from the base of the arm, here 6 m up the mast.
TABLE_5 = [
    ((-990, 642, -1140), (-2.35, -0.82, -1.74)),
    ((-600, 425, -284), (-1.43, 0.87, -3.03)),
    ((-2, 820, -250), (1.57, 1.57, 0)),
    ((1620, 1620, -500), (-1.57, 0.78, 0.78)),
]
AT_6_M = np.array([6.0, *HOME[1:]])


def table_5(number):
    position, angles = TABLE_5[number - 1]
    X = np.eye(4)
    X[:3, :3] = kinematics.rotation_from_intrinsic_xyz(angles)
    X[:3, 3] = np.array(position) / 1e3 + [0.0, 0.0, 6.0]
    return X


def postures(n, seed):
    return np.random.default_rng(seed).uniform(LOWER, UPPER, (n, 6))


def confirm(result, X, task="pose"):
    """Recompute everything the result claims."""
    position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(result.q))
    inside = bool(np.all((result.q >= LOWER) & (result.q <= UPPER)))
    assert inside
    assert result.position_error == pytest.approx(position, abs=1e-12)
    assert result.rotation_error == pytest.approx(rotation, abs=1e-12)
    good = position <= 5e-3 and (task == "position" or rotation <= 0.0175)
    assert result.success == good
    assert (result.reason == "converged") == result.success


@pytest.mark.parametrize("joints", ["full", "arm"])
@pytest.mark.parametrize("method", ["robust", "dpso", "dpsoij"])
def test_every_reachable_pose_is_solved(method, joints):
    for k, q in enumerate(postures(50 if method == "dpsoij" else 300, seed=1)):
        X = kinematics.forward_kinematics(q)
        held = np.array([q[0], *HOME[1:]])
        result = ik.solve(X, method=method, joints=joints, q_seed=held, seed=k)
        confirm(result, X)
        assert result.success
        if joints == "arm":
            assert result.q[0] == q[0]


@pytest.mark.parametrize("joints", ["full", "arm"])
@pytest.mark.parametrize("task", ["pose", "position"])
def test_inverse_jacobian_from_a_near_seed(joints, task):
    rng = np.random.default_rng(2)
    for q in 0.9 * postures(300, seed=2) + 0.05 * (LOWER + UPPER):
        X = kinematics.forward_kinematics(q)
        near = q + rng.uniform(-0.05, 0.05, 6)
        if joints == "arm":
            near[0] = q[0]
        result = ik.solve(X, method="inverse_jacobian", joints=joints, task=task, q_seed=near)
        confirm(result, X, task)
        assert result.success
        if task == "position":
            assert result.position_error < 1e-6


@pytest.mark.parametrize("joints", ["full", "arm"])
def test_position_task_is_exact_in_the_position_whatever_the_orientation(joints):
    rng = np.random.default_rng(3)
    for k, q in enumerate(postures(60, seed=3)):
        X = kinematics.forward_kinematics(q)
        X[:3, :3] = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, 3))
        result = ik.solve(X, method="dpso", joints=joints, task="position", q_seed=q, seed=k)
        confirm(result, X, "position")
        assert result.success
        assert result.position_error < 1e-6


def test_position_task_minimises_the_orientation_error():
    # No small motion that keeps the tool point turns the tool nearer to the target.
    rng = np.random.default_rng(4)
    for k, q in enumerate(postures(10, seed=4)):
        X = kinematics.forward_kinematics(q)
        X[:3, :3] = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, 3))
        best = ik.solve(X, method="dpso", joints="arm", task="position", q_seed=q, seed=k)
        for _ in range(40):
            nudged = best.q + rng.normal(size=6) * 0.03 * [0, 1, 1, 1, 1, 1]
            # Back to the tool point by Newton on the position rows, plain numpy.
            for _ in range(8):
                p = kinematics.forward_kinematics(nudged)[:3, 3]
                J = kinematics.jacobian(nudged)[3:, 1:]
                nudged[1:] += np.linalg.pinv(J, rcond=1e-8) @ (X[:3, 3] - p)
            position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(nudged))
            if position < 1e-8 and np.all((nudged >= LOWER) & (nudged <= UPPER)):
                assert rotation >= best.rotation_error - 1e-6


@pytest.mark.parametrize("number", [2, 3, 4])
def test_table_5_with_the_mast_is_exact(number):
    result = ik.solve(table_5(number), method="dpso", q_seed=AT_6_M)
    confirm(result, table_5(number))
    assert result.success
    assert result.position_error < 1e-6
    assert result.rotation_error < 1e-6


def test_table_5_posture_1_with_the_mast_is_within_tolerance():
    result = ik.solve(table_5(1), method="dpso", q_seed=AT_6_M)
    confirm(result, table_5(1))
    assert result.success


@pytest.mark.parametrize(("number", "rotation"), [(1, 0.30), (2, 0.072), (3, 0.015)])
def test_table_5_arm_alone_holds_the_position(number, rotation):
    X = table_5(number)
    result = ik.solve(X, method="dpso", joints="arm", task="position", q_seed=AT_6_M)
    confirm(result, X, "position")
    assert result.position_error < 1e-6
    assert result.rotation_error == pytest.approx(rotation, abs=0.005)


@pytest.mark.parametrize("method", ["inverse_jacobian", "pso", "dpso", "dpsoij"])
@pytest.mark.parametrize(
    ("number", "reason"),
    [(1, "joint limits"), (2, "orientation not attainable"), (4, "out of reach")],
)
def test_table_5_arm_alone_fails_with_the_reason(method, number, reason):
    options: dict[str, Any] = {} if method == "inverse_jacobian" else {"budget": 20_000}
    X = table_5(number)
    result = ik.solve(X, method=method, joints="arm", q_seed=AT_6_M, **options)
    confirm(result, X)
    assert not result.success
    assert result.reason == reason


def test_table_5_posture_3_arm_alone_is_within_tolerance():
    X = table_5(3)
    result = ik.solve(X, method="dpso", joints="arm", q_seed=AT_6_M)
    confirm(result, X)
    assert result.success


def test_table_6_pattern_position_rows_lose_the_orientation():
    # The paper's inverse Jacobian: below 1 mm, orientation off by 0.5 rad and more.
    for number in (1, 2, 3):
        X = table_5(number)
        result = ik.solve(
            X, method="inverse_jacobian", joints="arm", q_seed=AT_6_M, rows="position"
        )
        confirm(result, X)
        assert result.position_error < 1e-3
        assert result.rotation_error > 0.5
        assert not result.success


@pytest.mark.parametrize("joints", ["full", "arm"])
@pytest.mark.parametrize("task", ["pose", "position"])
@pytest.mark.parametrize("method", ["inverse_jacobian", "dpsoij"])
def test_out_of_reach(method, joints, task):
    X = np.eye(4)
    X[:3, 3] = [4.0, 0.0, 6.0]
    result = ik.solve(X, method=method, joints=joints, task=task, q_seed=AT_6_M)
    confirm(result, X, task)
    assert not result.success
    assert result.reason == "out of reach"
    # The best found is the arm stretched towards the target.
    if task == "position":
        assert result.position_error == pytest.approx(4.0 - kinematics.REACH, abs=2e-3)


def test_a_local_method_that_stops_short_says_so():
    X = kinematics.forward_kinematics(postures(1, seed=5)[0])
    result = ik.solve(X, method="inverse_jacobian", q_seed=AT_6_M, max_iterations=1)
    confirm(result, X)
    assert result.reason == "not converged"


@settings(max_examples=60, deadline=None)
@given(
    p=st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 12)),
    rpy=st.tuples(*[st.floats(-np.pi, np.pi)] * 3),
    seed=st.integers(0, 2**64),
    joints=st.sampled_from(["full", "arm"]),
    task=st.sampled_from(["pose", "position"]),
    method=st.sampled_from(["inverse_jacobian", "pso", "dpso", "dpsoij"]),
)
def test_no_target_breaks_the_limits_or_earns_a_false_success(p, rpy, seed, joints, task, method):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = kinematics.rotation_from_intrinsic_xyz(rpy), p
    options = {} if method == "inverse_jacobian" else {"budget": 2000, "starts": 2}
    result = ik.solve(X, method, joints, task, q_seed=AT_6_M, seed=seed, **options)
    confirm(result, X, task)
    if joints == "arm":
        assert result.q[0] == 6.0


@pytest.mark.parametrize("method", ["pso", "dpso", "dpsoij"])
@pytest.mark.parametrize("task", ["pose", "position"])
def test_a_seed_gives_the_same_bits(method, task):
    X = table_5(2)
    a, b, c = (ik.solve(X, method=method, task=task, seed=s, q_seed=AT_6_M) for s in (7, 7, 8))
    assert a.q.tobytes() == b.q.tobytes()
    assert (a.evaluations, a.iterations) == (b.evaluations, b.iterations)
    assert a.q.tobytes() != c.q.tobytes() or a.evaluations != c.evaluations


def test_a_rigid_transform_is_a_pose():
    X = table_5(4)
    a, b = ik.solve(X), ik.solve(RigidTransform(X))
    np.testing.assert_allclose(a.q, b.q, atol=1e-9)


def test_turns_lie_nearest_to_the_seed():
    q = HOME.copy()
    X = kinematics.forward_kinematics(q)
    for turns in (-1.0, 0.0, 1.0):
        near = q.copy()
        near[5] = q[5] + turns * 2 * np.pi
        result = ik.solve(X, method="dpso", q_seed=near, joints="arm")
        assert abs(result.q[5] - near[5]) <= np.pi + 1e-9


def test_history_ends_at_the_answer():
    X = table_5(4)
    runs: list[tuple[str, dict[str, Any]]] = [
        ("inverse_jacobian", {}),
        ("pso", {}),
        ("dpso", {}),
        ("dpso", {"polish": False}),
    ]
    for method, options in runs:
        result = ik.solve(X, method=method, history=True, q_seed=AT_6_M, **options)
        history = of_kind(np.ndarray, result.history)
        assert history.ndim == 2
        assert history.shape[1] == 2
        assert len(history) >= 1
        assert np.all(np.isfinite(history))
    result = ik.solve(X, method="inverse_jacobian", history=True, q_seed=AT_6_M)
    last = of_kind(np.ndarray, result.history)[-1]
    np.testing.assert_allclose(last, [result.position_error, result.rotation_error], atol=1e-7)
    assert ik.solve(X).history is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "closed_forms"}, "method: 'closed_forms', allowed .*dpsoij"),
        ({"joints": "legs"}, "joints: 'legs', allowed full, arm"),
        ({"task": "pose6"}, "task: 'pose6', allowed pose, position"),
        ({"joints": "arm"}, "q_seed: None, allowed"),
        ({"seed": 0.5}, "seed: 0.5, allowed a whole number"),
        ({"q_seed": np.zeros(5)}, r"q_seed: shape \(5,\)"),
        ({"q_seed": np.zeros(6)}, "q_seed: d1 = 0 m, allowed 2.5 to 10 m"),
        ({"q_seed": [np.nan] * 6}, "q_seed: d1 = nan"),
        ({"wings": 2}, "wings: not an option of robust, allowed history, .*nearest_to"),
        ({"method": "inverse_jacobian", "starts": 2}, "starts: not an option of inverse_jacobian"),
        ({"method": "dpso", "nearest_to": HOME, "polish": False}, "polish: False, allowed True"),
        ({"nearest_to": np.zeros(5)}, "nearest_to: 5 entries, allowed 6"),
        ({"X_WE": np.eye(3)}, r"X_WE: shape \(3, 3\), allowed \(4, 4\)"),
        ({"X_WE": np.diag([1.0, 1.0, -1.0, 1.0])}, "X_WE: not a rigid transform"),
        ({"X_WE": 2.0 * np.eye(4)}, "X_WE: not a rigid transform"),
        ({"X_WE": np.full((4, 4), np.nan)}, "X_WE: not finite"),
    ],
)
def test_bad_input_is_refused_in_one_line(arguments, message):
    arguments = {"X_WE": table_5(4), **arguments}
    with pytest.raises(ValueError, match=message) as error:
        ik.solve(**arguments)
    assert "\n" not in str(error.value)


def test_a_seed_outside_by_rounding_is_clipped():
    q = np.array([2.5 - 1e-9, *HOME[1:]])
    X = kinematics.forward_kinematics(HOME)
    assert ik.solve(X, q_seed=q, joints="arm", task="position").q[0] == 2.5


def test_the_registry_lists_the_methods():
    assert {"inverse_jacobian", "pso", "dpso", "dpsoij"} <= set(ik.METHODS)


@pytest.mark.parametrize("beyond", [0.006, 0.1, 0.5])
@pytest.mark.parametrize("elevation", [0.0, 0.6, -1.2, np.pi / 2])
def test_a_little_out_of_reach_is_not_success(beyond, elevation):
    # The beam of 0.75 m stays horizontal, the other 1.55 m point anywhere in its vertical plane.
    reach = np.array([0.75 + 1.55 * np.cos(elevation), 1.55 * np.sin(elevation)])
    outward = np.array([np.cos(elevation), np.sin(elevation)])
    for distance, reachable in ((-0.006, True), (beyond, False)):
        across, up = reach + distance * outward
        X = np.eye(4)
        X[:3, 3] = [0.8 * across, 0.6 * across, 6.0 + up]
        result = ik.solve(X, "dpso", "arm", "position", q_seed=AT_6_M)
        confirm(result, X, "position")
        assert result.success == reachable
        if not reachable:
            assert result.reason == "out of reach"
            assert result.position_error == pytest.approx(beyond, abs=2e-3)

"""The closed form against forward kinematics and an exhaustive search by least squares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake import ik, kinematics
from scara_drake.ik import closed_form
from scara_drake.ik.kernels.closed_form_arm import arm_branches_kernel, arm_solutions_kernel
from scara_drake.ik.kernels.closed_form_mast import mast_branches_kernel
from scara_drake.ik.kernels.postures import Bounds, Goal, mirror_kernel
from scara_drake.ik.kernels.refine import Descent, refine_kernel
from scara_drake.joints import HOME, LOWER, UPPER

HALF = np.pi / 2
# The wrist on the axis of the mast: d3 + a4 sin θ4 = 0.
ON_AXIS = -np.arcsin(kinematics.D3 / kinematics.A4)


def postures(n, seed):
    return np.random.default_rng(seed).uniform(LOWER, UPPER, (n, 6))


def solutions(X, joints, mast_height):
    """Solutions modulo whole turns, by the kernels."""
    q = np.empty((24, 6))
    p, R = X[:3, 3].copy(), X[:3, :3].copy()
    if joints == "arm":
        return q[: arm_solutions_kernel(p, R, mast_height, q)].copy()
    return q[: mast_branches_kernel(p, R, q)].copy()


def distances(q, other):
    """Largest joint difference of q (n, 6) to one posture, whole turns aside."""
    d = q - other
    d[:, 1:] = (d[:, 1:] + np.pi) % (2 * np.pi) - np.pi
    return np.abs(d).max(axis=1)


def check_law(X, q):
    """Every row is exact, within (-pi, pi], and no two are the same."""
    position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(q))
    assert max(position.max(), rotation.max()) <= 1e-9
    assert np.all(q[:, 1:] > -np.pi)
    assert np.all(q[:, 1:] <= np.pi)
    for k in range(1, len(q)):
        assert distances(q[:k], q[k]).min() > 1e-6


def search(X, joints, mast_height, restarts, seed):
    """Exact solutions inside the limits from random starts, by least squares."""
    rng = np.random.default_rng(seed)
    first, none, found = (1 if joints == "arm" else 0), np.empty((0, 2)), []
    p, R = X[:3, 3].copy(), X[:3, :3].copy()
    low, high = LOWER.copy(), UPPER.copy()
    low[0], high[0] = np.clip([p[2] - 2.3, p[2] + 2.3], LOWER[0], UPPER[0])
    for _ in range(restarts):
        q = rng.uniform(low, high)
        if first:
            q[0] = mast_height
        position, rotation, *_ = refine_kernel(
            q, Goal(p, R, Bounds(first, LOWER, UPPER)), Descent(1.0, 1.0, 40, True), none
        )
        if max(position, rotation) < 1e-8:
            found.append(q)
    return np.array(found)


def turned(q):
    """All whole turns of postures (n, 6) inside the limits."""
    turns = np.array(np.meshgrid(*[[-2, -1, 0, 1, 2]] * 3)).reshape(3, -1).T * 2 * np.pi
    wrapped = np.repeat(q, len(turns), axis=0)
    wrapped[:, [1, 2, 5]] += np.tile(turns, (len(q), 1))
    return wrapped[np.all((wrapped >= LOWER - 1e-9) & (wrapped <= UPPER + 1e-9), axis=1)]


def check_complete(joints, poses, restarts, seed):
    for k, q in enumerate(postures(poses, seed)):
        X = kinematics.forward_kinematics(q)
        mine = solutions(X, joints, q[0])
        check_law(X, mine)
        listed = ik.solve_all(X, joints, q if joints == "arm" else None)
        inside = turned(mine)
        inside = inside[np.all((inside >= LOWER) & (inside <= UPPER), axis=1)]
        assert len(listed) == len(inside)
        found = search(X, joints, q[0], restarts, k)
        assert len(found) > 0
        for other in found:
            assert distances(mine, other).min() < 1e-4
        for other in [*turned(found[:3]), q]:
            assert np.abs(listed - other).max(axis=1).min() < 1e-4


@pytest.mark.parametrize(("joints", "counts"), [("arm", {2}), ("full", {4, 8, 12})])
def test_random_poses_are_exact_and_have_the_counts_of_theory(joints, counts):
    seen = set()
    for q in postures(2000, seed=1):
        X = kinematics.forward_kinematics(q)
        mine = solutions(X, joints, q[0])
        check_law(X, mine)
        assert distances(mine, q).min() < 1e-6
        seen.add(len(mine))
    assert seen == counts


@pytest.mark.slow
@pytest.mark.parametrize(("joints", "counts"), [("arm", {2}), ("full", {4, 8, 12})])
def test_a_hundred_thousand_poses_are_exact(joints, counts):
    singular = 0
    for q in postures(100_000, seed=2):
        X = kinematics.forward_kinematics(q)
        mine = solutions(X, joints, q[0])
        check_law(X, mine)
        generic = len(mine) in counts and distances(mine, q).min() < 1e-6
        if not generic:  # where solutions meet: only in postures that are singular to many digits
            columns = kinematics.jacobian(q)[:, 1 if joints == "arm" else 0 :]
            assert np.linalg.svd(columns)[1][-1] < 1e-6
            assert distances(mine, q).min() < 1e-3
            singular += 1
    assert singular <= 10


@pytest.mark.parametrize(("joints", "poses", "restarts"), [("arm", 300, 60), ("full", 60, 300)])
def test_an_exhaustive_search_finds_nothing_else(joints, poses, restarts):
    check_complete(joints, poses, restarts, seed=3)


@pytest.mark.slow
@pytest.mark.parametrize(("joints", "restarts"), [("arm", 100), ("full", 400)])
def test_an_exhaustive_search_finds_nothing_else_long(joints, restarts):
    check_complete(joints, 1000, restarts, seed=4)


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_solutions_come_with_their_mirror(joints):
    mirrored = np.empty(6)
    for q in postures(200, seed=5):
        mine = solutions(kinematics.forward_kinematics(q), joints, q[0])
        for row in mine:
            mirror_kernel(row, mirrored)
            assert distances(mine, mirrored).min() < 1e-9


def test_four_candidates_and_their_residuals():
    q, residual = np.empty((4, 6)), np.empty(4)
    for own in postures(300, seed=6):
        X = kinematics.forward_kinematics(own)
        p, R = X[:3, 3].copy(), X[:3, :3].copy()
        assert arm_branches_kernel(p, R, own[0], q, residual) == 4
        assert np.all(q[:, 0] == own[0])
        position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(q))
        # The wrist is met by all, so the tool axis alone is off, and turns about the wrist.
        np.testing.assert_allclose(np.sin(rotation), residual, atol=1e-7)
        assert np.all(position <= kinematics.D6 * rotation + 1e-7)
        assert np.sum(residual < 1e-7) == 2


def test_a_pose_off_the_arms_manifold_has_no_solution_but_a_residual():
    rng = np.random.default_rng(7)
    q, residual = np.empty((4, 6)), np.empty(4)
    for own in postures(100, seed=7):
        X = kinematics.forward_kinematics(own)
        X[:3, :3] = X[:3, :3] @ kinematics.rotation_from_intrinsic_xyz(rng.uniform(0.02, 0.05, 3))
        arm_branches_kernel(X[:3, 3].copy(), X[:3, :3].copy(), own[0], q, residual)
        assert residual.min() > 1e-7
        assert len(solutions(X, "arm", own[0])) == 0
        assert ik.solve_all(X, "arm", own).shape == (0, 6)


DEGENERATE = {
    "home": HOME,
    "stretched": [3.0, 0.7, 0.3, HALF, 0.5, 0.2],
    "folded": [3.0, 0.7, 0.3, -HALF, 0.5, 0.2],
    "forearm vertical": [3.0, 0.7, HALF, 0.6, 0.5, 0.2],
    "forearm vertical, upwards": [5.0, -1.7, -HALF, -0.6, 0.5, 0.2],
    "tool up": [3.0, 0.4, HALF, 0.6, HALF - 0.6, 0.3],
    "tool down": [3.0, 0.4, -HALF, 0.6, HALF - 0.6, 0.3],
    "tool horizontal": [3.0, 0.4, 0.0, 0.3, 0.9, 1.0],
    "SCARA, tool along the beam": [3.0, 0.4, 0.0, 0.6, -0.6, 1.0],
    "tool along the beam": [3.0, 0.4, 0.8, 0.6, -0.6, 1.0],
    "wrist on the mast": [3.0, 0.4, HALF, ON_AXIS, 0.7, 1.0],
    "SCARA, elbow folded onto the beam": [3.0, 0.4, 0.0, ON_AXIS, 1.1, -1.0],
    "zero": [3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "at limits": [2.5, -2 * np.pi, 2 * np.pi, 0.75 * np.pi, -0.75 * np.pi, 2 * np.pi],
}


@pytest.mark.parametrize("joints", ["arm", "full"])
@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_postures(name, joints):
    q = np.array(DEGENERATE[name])
    X = kinematics.forward_kinematics(q)
    mine = solutions(X, joints, q[0])
    check_law(X, mine)
    assert distances(mine, q).min() < 1e-6
    listed = ik.solve_all(X, joints, q)
    np.testing.assert_allclose(listed[0], q, atol=1e-6)
    for other in search(X, joints, q[0], 300, seed=8):
        assert distances(mine, other).min() < 5e-3  # blurred where three solutions meet


# Continua: θ3 against θ6 on the straight arm, θ2 against θ6 on the axis of the mast.
FAMILIES = [
    [3.0, 0.7, 0.3, HALF, -HALF, 0.2],
    [3.0, 0.7, 0.3, HALF, HALF, 0.2],
    [3.0, 0.7, 0.3, -HALF, HALF, 0.2],
    [3.0, 0.7, HALF, ON_AXIS, -HALF - ON_AXIS, 0.2],
    [3.0, 0.7, -HALF, ON_AXIS, -HALF - ON_AXIS, 0.2],
]


@pytest.mark.parametrize("joints", ["arm", "full"])
@pytest.mark.parametrize("q", FAMILIES)
def test_a_continuum_of_solutions_has_representatives(q, joints):
    q = np.array(q)
    X = kinematics.forward_kinematics(q)
    mine = solutions(X, joints, q[0])
    assert len(mine) >= 2
    check_law(X, mine)
    result = ik.solve(X, "closed_form", joints, q_seed=q)
    assert max(result.position_error, result.rotation_error) <= 1e-9


def edge_values(low, high):
    special = [0.0, HALF, -HALF, np.pi, -np.pi, ON_AXIS, low, high]
    return st.one_of(
        st.floats(low, high), st.sampled_from([x for x in special if low <= x <= high])
    )


@settings(max_examples=400, deadline=None)
@given(
    q=st.tuples(*[edge_values(low, high) for low, high in zip(LOWER, UPPER, strict=True)]),
    joints=st.sampled_from(["arm", "full"]),
)
def test_every_posture_is_found_again(q, joints):
    q = np.array(q)
    X = kinematics.forward_kinematics(q)
    result = ik.solve(X, "closed_form", joints, q_seed=q)
    assert result.success
    assert max(result.position_error, result.rotation_error) <= 1e-7
    if joints == "arm":
        assert result.q[0] == q[0]


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_solve_all_lists_the_whole_turns_inside_the_limits_in_order(joints):
    for q in postures(100, seed=9):
        X = kinematics.forward_kinematics(q)
        listed = ik.solve_all(X, joints, q)
        assert np.all((listed >= LOWER) & (listed <= UPPER))
        position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(listed))
        assert max(position.max(), rotation.max()) <= 1e-9
        everything = turned(listed)
        for row in everything:
            assert np.abs(listed - row).max(axis=1).min() < 1e-9
        first = 1 if joints == "arm" else 0
        away = np.linalg.norm((listed - q)[:, first:], axis=1)
        assert np.all(np.diff(away) > -1e-8)
        assert len(np.unique(np.round(listed, 6), axis=0)) == len(listed)


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_a_joint_at_its_limit_is_inside(joints):
    rng = np.random.default_rng(19)
    for k, q in enumerate(postures(240, seed=19)):
        j = k % 6
        q[j] = LOWER[j] if rng.random() < 0.5 else UPPER[j]
        listed = ik.solve_all(kinematics.forward_kinematics(q), joints, q)
        assert np.abs(listed[0] - q).max() < 1e-9


def test_solve_all_without_a_seed_is_lexicographic():
    for q in postures(50, seed=10):
        listed = ik.solve_all(kinematics.forward_kinematics(q))
        rounded = [tuple(row) for row in np.round(listed, 9)]
        assert rounded == sorted(rounded)


@pytest.mark.parametrize(
    "p", [[4.0, 0.0, 6.0], [0.0, 0.0, 20.0], [0.0, 0.0, -5.0], [2.31, 0.0, 6.0]]
)
@pytest.mark.parametrize("joints", ["arm", "full"])
def test_out_of_reach_is_empty(p, joints):
    q = np.array([6.0, *HOME[1:]])
    for rpy in np.random.default_rng(11).uniform(-np.pi, np.pi, (20, 3)):
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = kinematics.rotation_from_intrinsic_xyz(rpy), p
        assert ik.solve_all(X, joints, q).shape == (0, 6)
        result = ik.solve(X, "closed_form", joints, q_seed=q)
        assert not result.success
        assert np.all((result.q >= LOWER) & (result.q <= UPPER))


def test_the_edge_of_reach_survives_rounding():
    q = np.array([5.0, 0.7, 0.3, HALF, 0.5, 0.2])
    X = kinematics.forward_kinematics(q)
    rng = np.random.default_rng(12)
    for joints in ("arm", "full"):
        for _ in range(50):
            Y = X.copy()
            Y[:3, 3] += 1e-12 * rng.normal(size=3)
            listed = ik.solve_all(Y, joints, q)
            assert np.abs(listed[0] - q).max() < 1e-4


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_the_method_takes_the_nearest_solution(joints):
    rng = np.random.default_rng(13)
    poses, answers, near = [], [], rng.uniform(LOWER, UPPER)
    for q in postures(100, seed=13):
        q[0] = near[0]
        X = kinematics.forward_kinematics(q)
        result = ik.solve(X, "closed_form", joints, q_seed=near)
        assert result.success
        assert max(result.position_error, result.rotation_error) <= 1e-9
        np.testing.assert_allclose(result.q, ik.solve_all(X, joints, near)[0], atol=1e-9)
        poses.append(X)
        answers.append(result.q)
    batch, success = closed_form.solve_batch(poses, joints, near)
    assert batch.tobytes() == np.array(answers).tobytes()
    assert success.all()


def test_without_a_seed_the_home_posture_decides():
    for q in postures(30, seed=14):
        X = kinematics.forward_kinematics(q)
        near = HOME.copy()
        near[0] = np.clip(X[2, 3], LOWER[0], UPPER[0])
        expected = ik.solve(X, "closed_form", q_seed=near).q
        assert ik.solve(X, "closed_form").q.tobytes() == expected.tobytes()
        assert closed_form.solve_batch([X])[0][0].tobytes() == expected.tobytes()


@pytest.mark.parametrize("joints", ["arm", "full"])
def test_without_a_solution_the_least_error_inside_the_limits(joints):
    rng = np.random.default_rng(15)
    q_seed = np.array([5.0, *HOME[1:]])
    poses = np.tile(np.eye(4), (100, 1, 1))
    poses[:, :3, :3] = kinematics.rotation_from_intrinsic_xyz(rng.uniform(-np.pi, np.pi, (100, 3)))
    poses[:, :3, 3] = rng.uniform([-2, -2, 1], [2, 2, 11], (100, 3))
    batch, success = closed_form.solve_batch(poses, joints, q_seed)
    for X, row, good in zip(poses, batch, success, strict=True):
        result = ik.solve(X, "closed_form", joints, q_seed=q_seed)
        assert result.q.tobytes() == row.tobytes()
        assert result.success == good
        assert np.all((row >= LOWER) & (row <= UPPER))
        if joints == "arm":
            assert row[0] == 5.0
        if len(ik.solve_all(X, joints, q_seed)) == 0:
            assert not good or result.rotation_error > 1e-9 or result.position_error > 1e-9


def test_a_target_off_the_manifold_within_tolerance_is_a_success():
    rng = np.random.default_rng(16)
    for q in 0.8 * postures(100, seed=16) + 0.1 * (LOWER + UPPER):
        X = kinematics.forward_kinematics(q)
        X[:3, 3] += rng.uniform(-1e-4, 1e-4, 3)
        result = ik.solve(X, "closed_form", "arm", q_seed=q)
        if result.success:
            assert result.position_error < 5e-3
    assert result.reason in ("converged", "not converged")


def test_a_path_keeps_its_branch():
    rng = np.random.default_rng(17)
    for joints in ("arm", "full"):
        for _ in range(10):
            middle = 0.5 * postures(1, seed=int(rng.integers(1000)))[0] + 0.25 * (LOWER + UPPER)
            t = np.linspace(0.0, 2 * np.pi, 100)[:, None]
            path = middle + 0.3 * np.sin(t + rng.uniform(0, 6, 6)) * [0, 1, 1, 1, 1, 1]
            X = kinematics.forward_kinematics(path)
            answer = ik.solve_path(X, "closed_form", joints, q_seed=path[0])
            assert answer.success.all()
            np.testing.assert_allclose(answer.q[0], path[0], atol=1e-6)
            assert max(answer.position_error.max(), answer.rotation_error.max()) <= 1e-9


def test_the_same_bits_every_time():
    for q in postures(50, seed=18):
        X = kinematics.forward_kinematics(q)
        assert ik.solve_all(X).tobytes() == ik.solve_all(X).tobytes()
        one, two = (ik.solve(X, "closed_form", seed=s) for s in (1, 2))
        assert one.q.tobytes() == two.q.tobytes()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda X: ik.solve_all(X, "legs"), "joints: 'legs', allowed full, arm"),
        (lambda X: ik.solve_all(X, "arm"), "q_seed: None, allowed"),
        (lambda X: ik.solve_all(X[:3]), r"X_WE: shape \(3, 4\)"),
        (lambda X: ik.solve_all(2 * X), "X_WE: not a rigid transform"),
        (lambda X: ik.solve_all(X, q_seed=np.zeros(6)), "q_seed: d1 = 0 m"),
        (lambda X: ik.solve(X, "closed_form", task="position"), "task: 'position', allowed pose"),
        (lambda X: ik.solve_path([X], "closed_form", task="position"), "task: 'position', allowed"),
        (lambda X: ik.solve(X, "closed_form", history=True), "history: True, allowed False"),
        (lambda X: ik.solve(X, "closed_form", starts=3), "starts: not an option of closed_form"),
        (lambda X: closed_form.solve_batch(X), r"X_WEs: shape \(4, 4\), allowed \(n, 4, 4\)"),
        (lambda X: closed_form.solve_batch([X, 2 * X]), r"X_WEs\[1\]: not a rigid transform"),
        (lambda X: closed_form.solve_batch([X * np.nan]), r"X_WEs\[0\]: not finite"),
        (lambda X: closed_form.solve_batch([X], "arm"), "q_seed: None, allowed"),
        (lambda X: closed_form.solve_batch([X], "legs"), "joints: 'legs', allowed"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, message):
    with pytest.raises(ValueError, match=message) as error:
        call(kinematics.forward_kinematics(HOME))
    assert "\n" not in str(error.value)


def test_an_empty_batch_is_empty():
    q, success = closed_form.solve_batch(np.empty((0, 4, 4)))
    assert q.shape == (0, 6)
    assert success.shape == (0,)

"""Paths: within tolerance at every point, and never a jump."""

import numpy as np
import pytest

from scara_drake import ik, joints, kinematics

LOWER, UPPER = np.array(joints.LOWER), np.array(joints.UPPER)


def joint_path(rng, scale, n=50):
    """A cubic through four random postures around a centre: the sets of the reference."""
    centre = 0.8 * rng.uniform(LOWER, UPPER) + 0.1 * (LOWER + UPPER)
    knots = centre + rng.uniform(-0.4, 0.4, (4, 6)) * scale
    s = np.linspace(0, 3, n)
    return np.clip(
        np.column_stack([np.polyval(np.polyfit(range(4), k, 3), s) for k in knots.T]),
        LOWER,
        UPPER,
    )


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("task", ["pose", "position"])
def test_arm_paths_are_followed_without_a_jump(scale, task):
    rng = np.random.default_rng(1)
    for k in range(20):
        q = joint_path(rng, scale)
        q[:, 0] = q[0, 0]
        X = kinematics.forward_kinematics(q)
        path = ik.solve_path(X, "dpsoij", "arm", task, q_seed=q[0], seed=k)
        position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(path.q))
        np.testing.assert_allclose(path.position_error, position, atol=1e-12)
        assert path.success.all()
        assert position.max() < 1e-6
        assert rotation.max() < (1e-5 if task == "pose" else 0.0175)
        assert np.all((path.q >= LOWER) & (path.q <= UPPER))
        assert np.abs(np.diff(path.q, axis=0)).max() <= 2.0 * np.abs(np.diff(q, axis=0)).max()


def test_paths_with_the_mast():
    rng = np.random.default_rng(2)
    whole = 0
    for k in range(20):
        q = joint_path(rng, 1)
        X = kinematics.forward_kinematics(q)
        path = ik.solve_path(X, "dpsoij", q_seed=q[0], seed=k)
        whole += bool(path.success.all())
        assert np.abs(np.diff(path.q, axis=0)).max() <= 0.7 + 1e-12
    # A branch may end at a joint limit behind a fold of the mast's six joints.
    assert whole >= 19


def test_a_path_that_leaves_the_reach_fails_there_and_comes_back_without_a_jump():
    q = np.array([6.0, -0.5, 0.1, 0.2, 1.0, 0.3])
    start = kinematics.forward_kinematics(q)
    out = np.concatenate([np.linspace(0, 2.0, 25), np.linspace(2.0, 0, 25)])
    X = np.repeat(start[None], 50, axis=0)
    direction = start[:3, 3] - [0, 0, 6.0]
    X[:, :3, 3] += out[:, None] * direction / np.linalg.norm(direction)
    path = ik.solve_path(X, "dpsoij", "arm", "position", q_seed=q)
    beyond = np.linalg.norm(X[:, :3, 3] - [0, 0, 6.0], axis=1) > kinematics.REACH + 5e-3
    assert beyond.sum() > 5
    assert not path.success[beyond].any()
    assert set(np.array(path.reason)[beyond]) == {"out of reach"}
    assert path.success[~beyond].mean() > 0.9
    assert np.abs(np.diff(path.q, axis=0)).max() <= 0.7 + 1e-12


def test_dpso_at_every_point_jumps_where_dpsoij_does_not():
    # Figures 12 to 15 of the paper.
    rng = np.random.default_rng(3)
    q = joint_path(rng, 1)
    q[:, 0] = q[0, 0]
    X = kinematics.forward_kinematics(q)

    def largest_step(method, **options):
        path = ik.solve_path(X, method, "arm", q_seed=q[0], **options)
        return np.abs(np.diff(path.q, axis=0)).max()

    assert largest_step("dpso", polish=False) > 1.0
    assert largest_step("dpsoij") < 0.3


def test_a_path_gives_the_same_bits_and_numbers_its_seeds():
    q = joints.HOME + np.linspace(0, 0.3, 10)[:, None]
    X = kinematics.forward_kinematics(q)
    a, b = (ik.solve_path(X, "dpso", seed=4) for _ in range(2))
    assert a.q.tobytes() == b.q.tobytes()
    single = ik.solve(X[3], "dpso", seed=7)
    assert a.q[3].tobytes() == single.q.tobytes()
    assert len(a) == 10
    assert a.evaluations.shape == a.iterations.shape == a.success.shape == (10,)


def test_a_path_of_one_point_is_a_solve():
    X = kinematics.forward_kinematics(joints.HOME)
    path, single = ik.solve_path([X]), ik.solve(X)
    assert path.q[0].tobytes() == single.q.tobytes()


def test_bad_paths_are_refused():
    with pytest.raises(ValueError, match="X_WEs: 0 poses"):
        ik.solve_path([])
    with pytest.raises(ValueError, match=r"X_WEs\[1\]: shape"):
        ik.solve_path([np.eye(4), np.eye(3)])
    with pytest.raises(ValueError, match="history: True, allowed False"):
        ik.solve_path([np.eye(4)], history=True)
    with pytest.raises(ValueError, match="max_joint_change"):
        ik.solve_path([np.eye(4)], max_joint_change=0.0)


def test_the_literal_method_holds_the_position_and_loses_the_orientation():
    """The pattern of the reference: within 5 mm, joint 6 still, the orientation adrift."""
    rng = np.random.default_rng(3)
    drifts, better = [], []
    for k in range(10):
        q = joint_path(rng, 1)
        q[:, 0] = q[0, 0]
        X = kinematics.forward_kinematics(q)
        literal = ik.solve_path(X, "dpsoij", "arm", q_seed=q[0], seed=k, variant="paper")
        default = ik.solve_path(X, "dpsoij", "arm", q_seed=q[0], seed=k)
        np.testing.assert_array_equal(np.diff(literal.q[:, 5]), 0.0)
        if literal.success[0]:
            assert literal.position_error[1:].max() <= 5e-3
            drifts.append(literal.rotation_error.max())
            better.append(default.rotation_error.max())
    assert len(drifts) >= 3  # the literal swarm finds about half of the first points
    assert np.median(drifts) > 0.05
    assert max(better) < 1e-5


def test_an_unknown_variant_is_refused():
    with pytest.raises(ValueError, match=r"^variant: 'mine', allowed default, paper$"):
        ik.solve(np.eye(4), "dpsoij", variant="mine")

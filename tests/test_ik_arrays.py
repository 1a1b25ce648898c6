"""What is no pose is refused in one line; what is one but for rounding is taken for it."""

import numpy as np
import pytest
import strategies
from hypothesis import given
from hypothesis import strategies as st
from strategies.postures import reachable

from scara_drake import ik, kinematics
from scara_drake.ik.closed_form import solve_batch
from scara_drake.joints import HOME

POSE = kinematics.forward_kinematics(HOME)
CALLS = {
    "solve": lambda X: ik.solve(X),
    "solve_all": lambda X: ik.solve_all(X),
    "solve_path": lambda X: ik.solve_path([POSE, X]),
    "solve_batch": lambda X: solve_batch([X]),
}


def refused(call, *arguments):
    with pytest.raises(ValueError, match="allowed") as error:
        call(*arguments)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("name", CALLS)
@strategies.examples(25)
@given(
    magnitude=st.one_of(st.floats(1.001e6, 1.7e308), st.sampled_from([1e78, 1e150, 1e300])),
    axis=st.integers(0, 2),
    negative=st.booleans(),
)
def test_positions_beyond_a_thousand_kilometres_are_refused(name, magnitude, axis, negative):
    X = POSE.copy()
    X[axis, 3] = -magnitude if negative else magnitude
    assert "m, allowed positions up to 1e+06 m" in refused(CALLS[name], X)


@strategies.examples(25)
@given(p=st.tuples(*[st.floats(-1e6, 1e6)] * 3), method=st.sampled_from(["robust", "closed_form"]))
def test_every_position_up_to_there_gets_an_answer(p, method):
    X = POSE.copy()
    X[:3, 3] = p
    result = ik.solve(X, method)
    assert np.isfinite(result.q).all()
    distance, _ = kinematics.pose_error(X, kinematics.forward_kinematics(result.q))
    assert result.position_error == pytest.approx(distance, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize(
    "X",
    [
        POSE + 0j,
        np.ma.masked_array(POSE, mask=np.eye(4, dtype=bool)),
        POSE.astype(str),
        POSE.astype(object),
        POSE > 0.0,
        [[1.0, 2.0], [3.0]],
        None,
        {},
        "pose",
        10**400,
        [[10**400] * 4] * 4,
    ],
    ids=lambda X: type(X).__name__,
)
def test_what_is_no_array_of_real_numbers_is_refused(name, X):
    refused(CALLS[name], X)


@pytest.mark.parametrize(
    "seed", [HOME + 0j, np.ma.masked_less(HOME, 0.0), ["1"] * 6, [True] * 6, [[1.0], 2.0], {}]
)
def test_seeds_and_branches_are_real_numbers_too(seed):
    assert "q_seed: " in refused(lambda: ik.solve(POSE, q_seed=seed))
    assert "nearest_to: " in refused(lambda: ik.solve(POSE, nearest_to=seed))


@strategies.examples(50)
@given(target=reachable(), decimals=st.integers(4, 12))
def test_a_rounded_pose_is_the_pose(target, decimals):
    q, X = target
    rounded = np.round(X, decimals)
    result = ik.solve(rounded, joints="arm", q_seed=q)
    assert result.success
    position, rotation = kinematics.pose_error(X, kinematics.forward_kinematics(result.q))
    # The tolerances, and what the rounding has moved.
    assert position <= 5e-3 + 2 * 10.0**-decimals
    assert rotation <= 0.0175 + 2 * 10.0**-decimals
    q_batch, success = solve_batch(rounded[None], "full")
    assert success[0] == ik.solve(rounded, "closed_form").success
    assert np.isfinite(q_batch).all()


@strategies.examples(25)
@given(target=reachable(), decimals=st.integers(0, 1), scale=st.floats(1.01, 3.0))
def test_what_is_no_rotation_is_refused_and_a_remedy_named(target, decimals, scale):
    _, X = target
    X = X.copy()
    X[:3, :3] *= scale
    assert "Rotation.from_matrix gives the nearest" in refused(ik.solve, X)
    mirrored = X.copy()
    mirrored[:3, :3] /= -scale
    refused(ik.solve, mirrored)

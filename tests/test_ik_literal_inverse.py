"""Equations (8) and (9), taken literally, ask for the inverse of a matrix that has none."""

import numpy as np
import strategies
from hypothesis import given
from strategies.postures import postures

from scara_drake import kinematics


@strategies.examples(50)
@given(postures())
def test_j_jt_of_the_six_by_five_jacobian_is_singular(q):
    """J (6, 5) by differences of the tool's pose: J J^T is 6 by 6 and its rank at most 5."""
    h, J = 1e-6, np.empty((6, 5))
    X = kinematics.forward_kinematics(q)
    for column, j in enumerate(range(1, 6)):
        step = np.eye(6)[j] * h
        high, low = kinematics.forward_kinematics(q + step), kinematics.forward_kinematics(q - step)
        W = (high[:3, :3] - low[:3, :3]) @ X[:3, :3].T / (2 * h)
        J[:, column] = [*(high - low)[:3, 3] / (2 * h), W[2, 1], W[0, 2], W[1, 0]]
    values = np.linalg.svd(J @ J.T, compute_uv=False)
    assert values[5] <= 1e-12 * values[0]

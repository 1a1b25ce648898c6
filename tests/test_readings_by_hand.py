"""What the readings rest on, computed once more in a few lines of numpy and scipy."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import least_squares
from small_experiments import small

from scara_drake import kinematics
from scara_drake.experiments.control import table_10_readings
from scara_drake.experiments.inverse_kinematics import literal_inverse, orientation_orders

# Table 1: theta, d, a, alpha of each row, and which of theta and d is the joint's.
ROWS = [
    (0, None, 0, 0), (None, 0, 0, -np.pi / 2), (None, 0.75, 0, np.pi / 2),
    (None, 0, 0.82, 0), (None, 0, 0, np.pi / 2), (None, 0.73, 0, 0),
]  # fmt: skip
LOWER = np.array([2.5, -2 * np.pi, -2 * np.pi, -3 * np.pi / 4, -3 * np.pi / 4, -2 * np.pi])
UPPER = np.array([10.0, 2 * np.pi, 2 * np.pi, 3 * np.pi / 4, 3 * np.pi / 4, 2 * np.pi])
# Table 5 [m], [rad].
P = np.array([[-990, 642, -1140], [-600, 425, -284], [-2, 820, -250], [1620, 1620, -500]]) / 1e3
O = np.array([[-2.35, -0.82, -1.74], [-1.43, 0.87, -3.03], [1.57, 1.57, 0], [-1.57, 0.78, 0.78]])  # noqa: E741 - the paper's symbol


def about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def tool(q):
    X = np.eye(4)
    for value, (theta, d, a, alpha) in zip(q, ROWS, strict=True):
        T, U = np.eye(4), np.eye(4)
        T[:3, :3] = about("z", value if theta is None else theta)
        T[2, 3] = value if d is None else d
        U[:3, :3], U[0, 3] = about("x", alpha), a
        X = X @ T @ U
    return X


def off(q, p, R):
    X = tool(q)
    turned = np.clip((np.trace(R.T @ X[:3, :3]) - 1) / 2, -1, 1)
    return np.linalg.norm(X[:3, 3] - p), np.arccos(turned)


@pytest.mark.parametrize("posture", range(4))
def test_with_the_mast_table_5_is_met_inside_table_2_and_by_the_arm_alone_it_is_not(posture):
    R = about("x", O[posture, 0]) @ about("y", O[posture, 1]) @ about("z", O[posture, 2])
    p = P[posture] + [0, 0, 6]

    def residual(q):
        X = tool(q)
        return [*(X[:3, 3] - p), *(0.1 * (X[:3, :3] - R)).ravel()]

    def best(lower, upper):
        draw = np.random.default_rng(posture)
        found = (
            least_squares(residual, draw.uniform(lower, upper), bounds=(lower, upper)).x
            for _ in range(12)
        )
        errors = []
        for q in found:
            errors.append(off(q, p, R))
            if errors[-1][0] < 5e-3 and errors[-1][1] < 0.0175:
                return errors[-1]
        return min(errors, key=lambda e: np.hypot(e[0], 0.1 * e[1]))

    position, rotation = best(LOWER, UPPER)
    assert position < 5e-3
    assert rotation < 0.0175
    still = np.array([1e-9, 0, 0, 0, 0, 0])
    fixed = np.array([6.0, *LOWER[1:]]) - still, np.array([6.0, *UPPER[1:]]) + still
    position, rotation = best(*fixed)
    assert (position < 5e-3 and rotation < 0.0175) == (posture == 2)


def test_an_order_is_a_product_of_three_turns():
    made = orientation_orders.rotations()
    assert len(made) == 24
    for name, R in made.items():
        axes, frame = name.split(", ")
        for angles, one in zip(O, R, strict=True):
            turns = [about(axis, angle) for axis, angle in zip(axes, angles, strict=True)]
            a, b, c = turns if frame == "turning axes" else turns[::-1]
            np.testing.assert_allclose(one, a @ b @ c, atol=1e-12)


def response(c, k, rho, d, times):
    """x(t) of x'' = u + d inside the layer: e' , e'' and z' are linear in e, e', z and 1."""
    # sigma = v + c e, s = sigma - z, u = rho s + k sigma, e'' = -u - d, z' = -k sigma; v = e'
    A = np.zeros((4, 4))
    A[0, 1] = 1
    A[1] = [-(rho + k) * c, -(rho + k), rho, -d]
    A[2] = [-k * c, -k, 0, 0]
    start = np.array([1, 0, c, 1])  # e = 1, v = 0, z = sigma
    step = expm(A * (times[1] - times[0]))
    states = [start]
    for _ in times[1:]:
        states.append(step @ states[-1])
    return 1 - np.array(states)[:, 0]


@pytest.mark.parametrize("pair", range(len(table_10_readings.GAINS)))
@pytest.mark.parametrize(("name", "d"), [("none", 0.0), ("constant", -10.0)])
def test_the_times_of_table_10_are_those_of_the_exponential(pair, name, d):
    data = small("table_10").data.sel(disturbance=name).isel(pair=pair)
    c, k = table_10_readings.GAINS[pair]
    t = np.arange(0, 12, 2e-3)
    x = response(c, k, 50.0, d, t)
    outside = np.flatnonzero(abs(x - 1) > 0.01)
    assert float(data.pair_rise_time) == pytest.approx(t[np.argmax(x >= 0.9)], abs=0.02)
    assert float(data.pair_settling_time) == pytest.approx(t[outside[-1] + 1], abs=0.06)


def test_the_mast_hangs_where_its_law_balances_its_weight():
    data = small("figures_16_17").data
    raw = data.error_in_metres.values
    weight, held = 735.5 * 9.81, 300.0
    assert raw[raw.size // 2 :].mean() == pytest.approx((weight - held) / (150 * 50), rel=0.01)
    in_mm = (data.q_desired - data.q_measured).sel(run="mm and N")[-1]
    assert 1e3 * float(in_mm) == pytest.approx((weight - held) / (150 * 50), rel=0.01)


@pytest.mark.parametrize(
    ("channel", "delay"),
    [
        ("paper", lambda t: np.maximum(0.2 * np.sin(t), 0)),
        ("paper_offset", lambda t: 0.1 * (1 + np.sin(t))),
        ("paper_2s", lambda t: 1 + np.sin(t)),
        ("paper_round_trip", lambda t: np.maximum(0.1 * np.sin(t), 0)),
    ],
)
def test_the_force_of_figure_28_is_late_by_the_formula(channel, delay):
    data = small("figure_28").data.sel(channel=channel)
    t = data.time.values
    wanted = np.interp(t - delay(t) - 1e-3, t, data.force)
    assert abs(data.force_felt - wanted).max() < 0.01 * data.force.max()


def test_the_literal_inverse_is_newton_with_the_mast_and_does_not_exist_without():
    draw = np.random.default_rng(0)
    q = draw.uniform(LOWER, UPPER)
    goal = q + 1e-3 * draw.normal(size=6)
    h, X = 1e-6, tool(q)
    J = np.empty((6, 6))
    for j in range(6):
        high, low = tool(q + h * np.eye(6)[j]), tool(q - h * np.eye(6)[j])
        W = (high[:3, :3] - low[:3, :3]) @ X[:3, :3].T / (2 * h)
        J[:, j] = [W[2, 1], W[0, 2], W[1, 0], *(high - low)[:3, 3] / (2 * h)]
    left = tool(goal)[:3, :3] @ X[:3, :3].T
    turned = [left[2, 1] - left[1, 2], left[0, 2] - left[2, 0], left[1, 0] - left[0, 1]]
    dP = [*np.divide(turned, 2), *(tool(goal) - X)[:3, 3]]
    one = literal_inverse.iterate(tool(goal)[np.newaxis], q[np.newaxis], "full", 1)[0, 0]
    step = np.remainder(one - q + np.pi, 2 * np.pi) - np.pi
    np.testing.assert_allclose(step, np.linalg.solve(J, dP), atol=1e-5)
    met = literal_inverse.iterate(tool(goal)[np.newaxis], q[np.newaxis], "full", 20)
    np.testing.assert_allclose(kinematics.forward_kinematics(met)[0, 0], tool(goal), atol=1e-9)
    gram = J[:, 1:] @ J[:, 1:].T
    assert np.linalg.svd(gram, compute_uv=False)[-1] < 1e-9 * np.linalg.norm(gram)

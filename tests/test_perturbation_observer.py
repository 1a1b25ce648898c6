import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, solve_discrete_lyapunov
from scipy.signal import cont2discrete

from scara_drake.control.perturbation_observer import lag_step, observer_gains, observer_step

POLES = st.floats(1.0, 1000.0)
PERIODS = st.floats(1e-4, 2e-3)

# The plant of the observer's own model: x1' = x2, x2' = u + Psi, Psi' = 0.
A = np.diag([1.0, 1.0], 1)
B = np.array([[0.0], [1.0], [0.0]])


def step(x, position, u, gains, period):
    """One step of one joint; x (3,) are its estimates."""
    parts = [np.array([value]) for value in x]
    observer_step(np.array([position]), np.array([u]), gains, period, *parts)
    return np.concatenate(parts)


def sliding_gains(pole, eps):
    """The published tuning: k1, k2 and a3 of a triple pole."""
    k1 = 3.0 * pole * eps
    return k1, pole * k1, np.sqrt(pole / 3.0)


def error_matrix(pole, period):
    """Of the estimation error over one step, taken from the kernel column by column."""
    gains = observer_gains([pole], [np.inf], period)
    transition = expm(A * period)
    columns = [
        transition @ e - step(np.zeros(3), (transition @ e)[0], 0.0, gains, period)
        for e in np.eye(3)
    ]
    return np.array(columns).T


def test_the_published_gains_give_a_triple_pole():
    pole, eps = 200.0, 0.005
    k1, k2, a3 = sliding_gains(pole, eps)
    polynomial = [1.0, k1 / eps, k2 / eps, a3**2 * k2 / eps]
    np.testing.assert_allclose(polynomial, np.poly([-pole] * 3))


@settings(deadline=None, max_examples=50)
@given(POLES, PERIODS)
def test_the_sampled_error_has_the_poles_of_the_continuous_one(pole, period):
    eps = 0.01
    k1, k2, a3 = sliding_gains(pole, eps)
    continuous = A - np.outer([k1, k2, a3**2 * k2], [1.0, 0.0, 0.0]) / eps
    units = np.array([1.0, period, period**2])  # so that the entries are of one size
    sampled = error_matrix(pole, period) / units[None, :] * units[:, None]
    np.testing.assert_allclose(np.poly(sampled), np.poly(expm(continuous * period)), atol=1e-9)


def test_at_short_periods_the_gains_are_the_published_ones_times_the_period():
    pole, eps, period = 50.0, 0.01, 1e-7
    k1, k2, a3 = sliding_gains(pole, eps)
    rates = observer_gains([pole], [eps], period)[:3, 0] / period
    np.testing.assert_allclose(rates, np.array([k1, k2, a3**2 * k2]) / eps, rtol=1e-4)


@settings(deadline=None, max_examples=50)
@given(PERIODS, st.integers(0, 2**32 - 1))
def test_between_samples_it_is_the_held_plant_exactly(period, seed):
    x, u = np.random.default_rng(seed).normal(size=3), 0.7
    a_d, b_d, *_ = cont2discrete((A, B, np.eye(3), np.zeros((3, 1))), period, method="zoh")
    expected = a_d @ x + b_d[:, 0] * u
    # With the position it predicts, an observer corrects nothing.
    gains = observer_gains([300.0], [0.01], period)
    np.testing.assert_allclose(step(x, expected[0], u, gains, period), expected, atol=1e-9)


def follow(psi, u, pole, period, duration, noise=0.0):
    """Observe x'' = u + psi(t) from rest; return the states and the estimates (n, 3)."""
    gains = observer_gains([pole], [0.05], period)
    x, estimate = np.zeros(2), np.zeros(3)
    rng = np.random.default_rng(0)
    truth, seen = [], []
    for k in range(round(duration / period)):
        held = psi((k + 0.5) * period) + u
        x = np.array([x[0] + period * x[1] + 0.5 * period**2 * held, x[1] + period * held])
        estimate = step(estimate, x[0] + noise * rng.normal(), u, gains, period)
        truth.append([*x, psi((k + 1) * period)])
        seen.append(estimate)
    return np.array(truth), np.array(seen)


@pytest.mark.parametrize("pole", [50.0, 200.0, 1000.0])
def test_of_a_constant_perturbation_nothing_is_left(pole):
    truth, seen = follow(lambda t: -9.81, 5.0, pole, 1e-3, 30.0 / pole + 0.05)
    np.testing.assert_allclose(seen[-1], truth[-1], atol=1e-7)


def test_a_growing_perturbation_is_seen_three_time_constants_late():
    pole, rate = 100.0, 40.0
    truth, seen = follow(lambda t: rate * t, 0.0, pole, 1e-4, 0.5)
    lag = (truth[-1, 2] - seen[-1, 2]) / rate
    assert lag == pytest.approx(3.0 / pole, rel=0.01)


@pytest.mark.parametrize("pole", [50.0, 200.0])
def test_noise_is_amplified_as_the_lyapunov_equation_says(pole):
    period, sigma = 1e-3, 1e-5
    units = np.array([1.0, period, period**2])  # so that the entries are of one size
    gain = observer_gains([pole], [1.0], period)[:3, 0] * units
    matrix = error_matrix(pole, period) / units[None, :] * units[:, None]
    variance = solve_discrete_lyapunov(matrix, sigma**2 * np.outer(gain, gain))
    truth, seen = follow(lambda t: 0.0, 0.0, pole, period, 20.0, noise=sigma)
    late = (seen - truth)[500:]
    np.testing.assert_allclose(late.std(axis=0), np.sqrt(np.diag(variance)) / units, rtol=0.15)


def test_a_wild_sample_moves_the_estimates_no_further_than_the_layer_does():
    gains = observer_gains([200.0], [0.005], 1e-3)
    np.testing.assert_array_equal(
        step(np.zeros(3), 1e3, 0.0, gains, 1e-3), step(np.zeros(3), 0.005, 0.0, gains, 1e-3)
    )


@pytest.mark.parametrize(("period", "factor"), [(2e-5, 3.7), (1e-3, 2.75)])
def test_a_step_within_the_stated_bound_stays_in_the_layer(period, factor):
    # The peak of the error after a step of Psi is exp(-2) (2/p)²/2 Psi = Psi / (3.7 p²) where
    # samples are dense.
    pole, eps = 200.0, 0.005

    def largest_share(psi):
        gains = observer_gains([pole], [np.inf], period)
        estimate, largest = np.zeros(3), 0.0
        for k in range(1, round(0.05 / period)):
            position = 0.5 * psi * (k * period) ** 2
            predicted = estimate[0] + period * (estimate[1] + 0.5 * period * estimate[2])
            largest = max(largest, abs(position - predicted))
            estimate = step(estimate, position, 0.0, gains, period)
        return largest / eps

    assert largest_share(factor * eps * pole**2) == pytest.approx(1.0, abs=0.05)


@settings(deadline=None, max_examples=20)
@given(POLES, PERIODS, st.integers(0, 2**32 - 1))
def test_the_lagged_effort_is_what_the_observer_would_say_of_that_perturbation(pole, period, seed):
    rng = np.random.default_rng(seed)
    gains = observer_gains([pole], [np.inf], period)
    x, estimate = np.zeros(2), np.zeros(3)
    x1, x2, lagged = np.zeros(1), np.zeros(1), np.zeros(1)
    for u in np.cumsum(rng.normal(size=50)):
        x = np.array([x[0] + period * x[1] + 0.5 * period**2 * u, x[1] + period * u])
        estimate = step(estimate, x[0], 0.0, gains, period)
        lag_step(np.array([u]), gains, period, x1, x2, lagged)
        np.testing.assert_allclose(lagged[0], estimate[2], rtol=1e-7, atol=1e-7)

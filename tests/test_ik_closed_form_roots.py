"""Roots of trigonometric polynomials against numpy's, and against roots put there."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake.ik.kernels.trigonometric import MAX_ROOTS, evaluate_kernel, roots_kernel

angle = st.floats(-3.0, 3.0)


def roots_of(c):
    roots, multiple = np.empty(MAX_ROOTS), np.empty(MAX_ROOTS)
    n = roots_kernel(c, roots, multiple)
    return roots[:n], multiple[:n] > 0


def samples(c, t):
    k = np.arange(1, 4)
    return c[0] + np.cos(np.outer(t, k)) @ c[1::2] + np.sin(np.outer(t, k)) @ c[2::2]


def coefficients(f):
    """Of a function that is such a polynomial: least squares on a grid."""
    t = np.linspace(0.0, 2 * np.pi, 50, endpoint=False)
    columns = [np.ones_like(t)]
    for k in (1, 2, 3):
        columns += [np.cos(k * t), np.sin(k * t)]
    return np.linalg.lstsq(np.array(columns).T, f(t), rcond=None)[0]


def on_the_circle(c):
    """Real roots by the companion matrix of the polynomial in exp(it)."""
    half = [(c[2 * k - 1] - 1j * c[2 * k]) / 2 for k in (3, 2, 1)]
    z = np.roots([*half, c[0], *np.conj(half[::-1])])
    z = z[np.abs(np.abs(z) - 1.0) < 1e-7]
    return np.sort((np.angle(z) + 3.0) % (2 * np.pi) - 3.0)


def test_value_and_derivatives():
    rng = np.random.default_rng(0)
    for c in rng.normal(size=(20, 7)):
        t, h = rng.uniform(-3, 3), 1e-4
        f, slope, curvature = evaluate_kernel(c, t)
        before, at, after = samples(c, np.array([t - h, t, t + h]))
        assert f == pytest.approx(at, abs=1e-13)
        assert slope == pytest.approx((after - before) / (2 * h), abs=1e-5)
        assert curvature == pytest.approx((after - 2 * at + before) / h**2, abs=1e-4)


def test_all_roots_are_those_of_the_companion_matrix():
    counts = set()
    for c in np.random.default_rng(1).normal(size=(3000, 7)):
        roots, multiple = roots_of(c)
        expected = on_the_circle(c)
        assert len(roots) == len(expected)
        np.testing.assert_allclose(roots, expected, atol=1e-8)
        assert not multiple.any()
        counts.add(len(roots))
    assert counts == {0, 2, 4, 6}


@settings(max_examples=300, deadline=None)
@given(a=angle, b=angle, d=angle)
def test_double_roots_are_found_and_marked(a, b, d):
    # Touches zero at a; crosses it at b and d, unless these are near.
    c = coefficients(lambda t: (1 - np.cos(t - a)) * np.sin((t - b) / 2) * np.sin((t - d) / 2) * 4)
    roots, multiple = roots_of(c)
    for wanted in (a, b, d):
        away = np.abs((roots - wanted + np.pi) % (2 * np.pi) - np.pi)
        assert away.min() < 2e-3  # where three or four coincide; a double root is sharper
    apart = min(abs(np.sin((x - y) / 2)) for x, y in ((a, b), (a, d), (b, d)))
    if apart > 0.01:
        assert np.sum(multiple) == 1
        assert len(roots) == 3
        assert abs(roots[multiple][0] - a) < 1e-6


@pytest.mark.parametrize("gap", [1e-3, 1e-5, 1e-7, 0.0])
def test_close_roots_are_told_apart_or_marked(gap):
    c = coefficients(lambda t: (np.cos(t - 0.4) - np.cos(gap)) * (2.0 + np.cos(t)))
    roots, multiple = roots_of(c)
    assert len(roots) == 2 or multiple.all()
    np.testing.assert_allclose(roots, 0.4, atol=gap + 1e-7)


@pytest.mark.parametrize("missed_by", [1e-13, 1e-11])
def test_a_double_root_missed_by_rounding_is_kept(missed_by):
    c = coefficients(lambda t: (1.0 + missed_by - np.cos(t - 0.4)) * (2.0 + np.cos(t)))
    roots, multiple = roots_of(c)
    np.testing.assert_allclose(roots, 0.4, atol=1e-6)
    assert multiple.all()


def test_zero_and_constants():
    roots, multiple = roots_of(np.zeros(7))
    assert roots.tolist() == [0.0]
    assert multiple.all()
    assert len(roots_of(np.array([1.0, 0, 0, 0, 0, 0, 0]))[0]) == 0
    assert len(roots_of(np.array([1.0, 0.3, 0.2, 0.1, 0.1, 0.1, 0.1]))[0]) == 0


@pytest.mark.parametrize("root", [-3.0, -np.pi / 2, 0.0, np.pi / 2, np.pi])
def test_a_root_on_the_end_of_an_interval_is_found_once(root):
    roots, _ = roots_of(coefficients(lambda t: np.sin(t - root)))
    assert len(roots) == 2
    assert np.abs(np.sin(roots - root)).max() < 1e-12

"""Laws of sliding mode control, on the smallest plant that has them.

With c = 0 and a reference at rest sigma = -v, so x'' = u + d is sigma' = -d - u.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake.experiments.control.second_order import ismc_gains, respond, smc_gains

FINE = 1e-5  # [s], period where a law in continuous time is the answer


def nothing(t):
    return 0.0 * t


def at_rest(t):
    return 0.0 * t, 0.0 * t


def sigma_of(d, sigma0, k, rho, phi, duration, period):
    """ISMC of sigma' = d - u from sigma0, under the function d."""
    gains = ismc_gains(0.0, k, rho, phi, period=period)
    return respond("ISMC", gains, [lambda t: -d(t)], duration, at_rest, start_rate=-sigma0).isel(
        case=0
    )


@pytest.mark.parametrize(("k", "rho"), [(50.0, 150.0), (100.0, 500.0), (20.0, 10.0)])
def test_without_perturbation_sigma_decays_at_k_on_the_surface(k, rho):
    run = sigma_of(nothing, 0.3, k, rho, 1.0, 4.0 / k, FINE)
    np.testing.assert_allclose(run.sigma, 0.3 * np.exp(-k * run.time), atol=0.3 * k * FINE)
    assert abs(run.s).max() < 1e-12


def test_sampled_sigma_decays_by_its_factor_of_each_period():
    run = sigma_of(nothing, 0.3, 50.0, 150.0, 1.0, 0.1, 1e-3)
    np.testing.assert_allclose(run.sigma, 0.3 * 0.95 ** np.arange(run.time.size), atol=1e-13)


def closed_form(t, d, k, slope):
    return d * (np.exp(-slope * t) - np.exp(-k * t)) / (k - slope)


@pytest.mark.parametrize("d", [30.0, -120.0])
def test_a_constant_perturbation_follows_its_closed_form(d):
    k, rho, phi = 50.0, 150.0, 1.0
    off = []
    for period in (4e-5, 1e-5):
        run = sigma_of(lambda t: np.full_like(t, d), 0.0, k, rho, phi, 0.1, period)
        off.append(float(abs(run.sigma - closed_form(run.time, d, k, rho / phi)).max()))
    assert off[1] < abs(d) * 1e-5
    assert off[1] < 0.3 * off[0]  # converges with the first power of the period


@settings(deadline=None, max_examples=30)
@given(
    k=st.floats(1.0, 100.0),
    rho=st.floats(20.0, 200.0),
    share=st.floats(0.1, 0.95),
    frequency=st.floats(0.1, 200.0),
    square=st.booleans(),
)
def test_s_keeps_its_bound(k, rho, share, frequency, square):
    # |s| <= phi H / rho wherever |d| <= H < rho.
    height, phi = share * rho, 1.0

    def d(t):
        wave = np.sin(frequency * t)
        return height * (np.sign(wave) if square else wave)

    run = sigma_of(d, 0.2, k, rho, phi, 0.5, 1e-4)
    assert abs(run.s).max() <= phi * height / rho * (1.0 + 1e-6)


def test_the_bound_is_reached_by_a_constant_perturbation():
    run = sigma_of(lambda t: np.full_like(t, 90.0), 0.0, 50.0, 150.0, 1.0, 0.3, 1e-3)
    assert float(run.s[-1]) == pytest.approx(90.0 / 150.0, rel=1e-6)


def test_conventional_sliding_mode_leaves_phi_d_over_rho_c():
    c, rho, phi = 2.0, 700.0, 1.5
    run = respond("SMC", smc_gains(c, rho, phi), [lambda t: np.full_like(t, 20.0)], 10.0)
    assert float(run.x[-1, 0] - 1.0) == pytest.approx(phi * 20.0 / (rho * c), rel=1e-6)
    still = respond("ISMC", ismc_gains(c, 50.0, 50.0, phi), [lambda t: np.full_like(t, 20.0)], 15.0)
    assert abs(float(still.x[-1, 0]) - 1.0) < 1e-9


def test_the_plant_moves_exactly_under_held_forces():
    # rho = k = 0: nothing but d and the start; a sub-step holds d at its middle.
    run = respond(
        "ISMC",
        ismc_gains(0.0, 0.0, 0.0, 1.0),
        [lambda t: np.full_like(t, 3.0), lambda t: 6.0 * t],
        2.0,
        start=[1.0, 0.0],
        start_rate=[-2.0, 0.5],
    )
    t = run.time
    np.testing.assert_allclose(run.x[:, 0], 1.0 - 2.0 * t + 1.5 * t**2, atol=1e-12)
    np.testing.assert_allclose(run.v[:, 1], 0.5 + 3.0 * t**2, atol=1e-12)
    np.testing.assert_allclose(run.x[:, 1], 0.5 * t + t**3, atol=1e-7)


def test_cases_do_not_know_of_each_other():
    k, b = np.array([20.0, 50.0, 80.0]), np.array([0.5, 1.0, 2.0])
    ds = [nothing, lambda t: np.sin(9.0 * t), lambda t: 5.0 + nothing(t)]
    together = respond("ISMC", ismc_gains(1.0, k, 40.0, 0.5, 30.0), ds, 1.0, b=b)
    for i, d in enumerate(ds):
        alone = respond("ISMC", ismc_gains(1.0, k[i], 40.0, 0.5, 30.0), [d], 1.0, b=b[i])
        for name in ("x", "v", "sigma", "s", "u"):
            np.testing.assert_array_equal(together[name][:, i], alone[name][:, 0])


def test_the_effort_keeps_its_limit_and_the_clamp_its_own():
    def strong(t):
        return np.where(t < 0.5, 300.0, 0.0)

    gains = (ismc_gains(1.0, 50.0, 150.0, 1.0, 200.0, anti_windup=on) for on in (True, False))
    clamped, wound = (respond("ISMC", g, [strong], 3.0) for g in gains)
    assert abs(clamped.u).max() <= 200.0
    assert abs(clamped.s).max() < 3.0 < 10.0 < abs(wound.s).max()


@pytest.mark.parametrize(
    ("law", "gains", "message"),
    [
        ("PID", ismc_gains(1.0, 1.0, 1.0, 1.0), "^law: 'PID', allowed ISMC, SMC"),
        ("SMC", ismc_gains(1.0, 1.0, 1.0, 1.0), r"^gains: shape \(8, 1\), allowed \(6, 1\)"),
        ("SMC", smc_gains(np.ones(3), 1.0, 1.0), r"^gains: shape \(6, 3\)"),
    ],
)
def test_what_does_not_fit_is_refused(law, gains, message):
    with pytest.raises(ValueError, match=message):
        respond(law, gains, [nothing, nothing], 1.0)

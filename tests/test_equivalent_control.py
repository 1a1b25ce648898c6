"""Equations (31) and (38) to (42), on the data of the experiment and by closed forms."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.experiments import IN_KIND, NOT_REPRODUCED, REPRODUCED
from scara_drake.experiments.control import equivalent_control as equations
from scara_drake.experiments.control.second_order import ismc_gains, respond, smc_gains

PERIOD = 2e-4


@lru_cache
def experiment():
    return equations.run(duration=1.5)


def verdicts(data):
    return [claim.verdict for claim in equations.claims(data)]


def test_verdicts():
    assert verdicts(experiment().data) == [IN_KIND, REPRODUCED, REPRODUCED, REPRODUCED]


@pytest.mark.parametrize("phi", equations.LAYERS)
def test_u1_lags_behind_a_sine_as_a_first_order_filter_does(phi):
    # s' = Psi - (rho / phi) s: u1 = rho s / phi is Psi through a lag of phi / rho.
    data = experiment().data.sel(phi=phi, disturbance="fast sine")
    late = data.sel(time=slice(0.75, None))
    missing = np.abs(late.u1 - late.psi).max() / np.abs(late.psi).max()
    corner = equations.RHO / phi
    assert float(missing) == pytest.approx(20.0 / np.hypot(20.0, corner), abs=0.02)


@examples(15)
@given(
    st.floats(0.1, 5.0), st.floats(1.0, 60.0), st.floats(1.0, 200.0),
    st.floats(-0.9, 0.9), st.floats(0.2, 30.0), st.floats(0.02, 1.0),
)  # fmt: skip
def test_whatever_the_disturbance_below_rho_sigma_decays_at_k(c, k, rho, share, omega, phi):
    # s = 0 to begin with, so |s| <= phi max|Psi| / rho, and sigma' = s' - k sigma.
    phi = max(phi, 1.5 * rho * PERIOD)
    gains = ismc_gains(c, k, rho, phi, anti_windup=False, period=PERIOD)
    amplitude = share * rho
    run = respond("ISMC", gains, [lambda t: amplitude * np.cos(omega * t)], 0.5, start=0.9)
    sigma, s = run.sigma.values[:, 0], run.s.values[:, 0]
    psi = np.abs(-c * run.v.values[:, 0]).max() + abs(amplitude)
    if psi >= rho:
        return
    assert np.abs(s).max() <= 1.02 * phi * psi / rho
    # The sampled decay is (1 - k T)^n; what s adds is at most itself and k times its integral.
    decay = sigma[0] * (1.0 - k * PERIOD) ** np.arange(sigma.size)
    assert np.abs(sigma - decay).max() <= 2.0 * np.abs(s).max() + 1e-9


@examples(15)
@given(
    st.floats(1.0, 200.0), st.floats(-0.95, 0.95), st.floats(0.2, 30.0), st.floats(0.5, 5.0),
)  # fmt: skip
def test_outside_its_layer_smc_falls_where_rho_exceeds_the_perturbation(rho, share, omega, start):
    phi = max(0.1, 1.5 * rho * PERIOD)
    gains = smc_gains(1.0, rho, phi, period=PERIOD)
    d = share * rho
    run = respond("SMC", gains, [lambda t: d * np.sin(omega * t)], 0.3, start=1.0 - start)
    sigma, v = run.sigma.values[:, 0], run.v.values[:, 0]
    met = (np.abs(sigma) >= phi) & (np.abs(v) + abs(d) < 0.99 * rho)
    product = sigma[:-1] * np.diff(sigma)
    assert (product[met[:-1]] <= 0.0).all()


def test_it_judges_what_it_is_given():
    data = experiment().data.copy(deep=True)
    data.sigma_smc[:] = np.exp(-data.time)
    for off, verdict in ((0.5, REPRODUCED), (5.0, IN_KIND)):  # of 1 % and 10 % in the thinnest
        data.u1[:] = (1.0 - off * data.phi) * data.psi
        late = off * data.phi * data.time / data.time.max()
        data.sigma[:] = (
            (np.exp(-equations.K * data.time) + late)
            .transpose("phi", "time")
            .values[:, :, np.newaxis]
        )
        assert verdicts(data) == [REPRODUCED, verdict, verdict, REPRODUCED]
    data.sigma_smc[:] = np.exp(data.time)
    data.u1[:] = 0.0
    data.sigma[:] = 1.0
    data.s[:] = 0.0
    assert verdicts(data) == [NOT_REPRODUCED] * 4

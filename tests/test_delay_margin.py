"""Delay margins: the formula, the sampled loop, the law itself, and the whole Diagram."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind

from scara_drake import joints, load_scenario, metrics, simulate
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.ismc_law import GAINS, ismc_law
from scara_drake.robot import inverse_mass_matrices
from scara_drake.stability.delay_margin import (
    arm_onset,
    crossover,
    delay_margin,
    grows,
    mass_ratios,
    onset,
    phase_margin,
    sampled_loop,
    simulated_onset,
    spectral_radius,
)
from scara_drake.stability.linear import least_mass_ratio

TS = 1e-3
TABLE_11 = of_kind(IntegralSlidingMode, load_scenario("joint_sine").controller)
TABLE_12 = IntegralSlidingMode()
TABLES = {"Table 11": TABLE_11, "Table 12": TABLE_12}
each_table = pytest.mark.parametrize("table", TABLES)

gain = st.floats(1.0, 100.0)


def alone(table, joint, b, period=TS):
    """M^-1 and the gains of one joint with the plant gain b."""
    gains = TABLES[table].array(period)[:, [joint]]
    return np.array([[b / GAINS.unpack(gains).m_hat[0]]]), gains


def laws(table, joint) -> tuple[float, float, float, float]:
    gains = TABLES[table]
    return gains.c[joint], gains.k[joint], gains.rho[joint], gains.phi[joint]


@settings(deadline=None, max_examples=50)
@given(gain, gain, st.floats(10.0, 500.0), st.floats(0.2, 2.0), st.floats(0.3, 3.0))
def test_the_loop_crosses_one_with_the_phase_margin(c, k, rho, phi, b):
    w = float(crossover(c, k, rho, phi, b))
    loop = b * (1j * w + c) * ((k + rho / phi) * 1j * w + k * rho / phi) / (1j * w) ** 3
    assert abs(loop) == pytest.approx(1.0)
    margin = float(phase_margin(c, k, rho, phi, b))
    assert loop == pytest.approx(-np.exp(1j * margin), abs=1e-6)
    delayed = loop * np.exp(-1j * w * float(delay_margin(c, k, rho, phi, b)))
    assert delayed == pytest.approx(-1.0, abs=1e-6)


@each_table
@pytest.mark.parametrize("joint", range(6))
def test_the_sampled_loop_tends_to_the_formula(table, joint):
    period = 2.5e-4
    inverse_mass, gains = alone(table, joint, 1.0, period)
    expected = float(delay_margin(*laws(table, joint), period=period))
    assert onset(inverse_mass, gains) == pytest.approx(expected, abs=0.15 * period)


def check_that_formula_spectrum_and_simulation_agree(table, joint, b):
    gains = TABLES[table].array(TS)
    exact = onset(*alone(table, joint, b))
    assert simulated_onset(b, gains[:, [joint]])[0] == pytest.approx(exact, abs=2e-5)
    formula = float(delay_margin(*laws(table, joint), b, TS))
    assert formula == pytest.approx(exact, abs=0.15e-3)


@each_table
@pytest.mark.parametrize("joint", [0, 1, 5])
def test_formula_spectrum_and_simulation_agree(table, joint):
    check_that_formula_spectrum_and_simulation_agree(table, joint, 1.0)


@pytest.mark.slow
@each_table
def test_formula_spectrum_and_simulation_agree_over_the_workspace(table):
    for ratios in (*mass_ratios(TABLES[table]), np.ones(6)):
        for joint, b in enumerate(ratios):
            check_that_formula_spectrum_and_simulation_agree(table, joint, b)


def test_figures_of_the_tables():
    # 1 / a is 5 ms and 4 ms for joint 2.
    onsets = [onset(*alone(table, 1, 1.0)) for table in TABLES]
    assert 4e-3 < onsets[0] < 6e-3
    assert 2e-3 < onsets[1] < 4e-3


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3, 2.7e-3])
def test_a_period_of_the_sampled_loop_is_what_a_fine_integration_gives(delay):
    gains = TABLE_12.array(TS)[:, [1]]
    g = GAINS.unpack(gains)
    inverse_mass, fine = 1.4 / g.m_hat[0], 1000
    step = sampled_loop(np.array([[inverse_mass]]), gains, delay)
    ticks, shift = 12, round(delay / TS * fine)
    q, v, z = 1e-6, 2e-5, np.array([3e-5])
    x = np.zeros(step.shape[0])
    x[:3] = q, v, z[0]
    efforts = np.zeros(ticks * fine + shift + fine)
    s, tau, limited, saturation = np.empty((4, 1))
    free = gains.copy()
    GAINS.unpack(free).effort[:] = GAINS.unpack(free).clamp[:] = np.inf
    h = TS / fine
    for tick in range(ticks):
        np.testing.assert_allclose(x[:3], [q, v, z[0]], rtol=1e-6, atol=1e-12)
        sigma = np.array([-v - g.c[0] * q])
        ismc_law(sigma, free, np.zeros(1), z, s, tau, limited, saturation)
        start = tick * fine + shift
        efforts[start : start + fine] = limited[0]
        for effort in efforts[tick * fine : (tick + 1) * fine]:
            a = inverse_mass * effort
            q += h * v + 0.5 * h * h * a
            v += h * a
        x = step @ x


def test_without_a_delay_the_paper_s_gains_are_stable_and_ten_times_them_are_not():
    inverse_mass, gains = alone("Table 12", 0, 1.0)
    assert spectral_radius(inverse_mass, gains, 0.0) < 1.0
    g = GAINS.unpack(gains)
    g.k[:], g.rho[:] = 10.0 * g.k, 10.0 * g.rho
    assert onset(inverse_mass, gains) == 0.0
    assert grows(1.0, gains, 0.0).all()
    assert float(delay_margin(g.c[0], g.k[0], g.rho[0], g.phi[0], period=TS)) < 0.0


def test_a_slow_loop_bears_any_delay_that_is_looked_for():
    inverse_mass, gains = alone("Table 12", 5, 1.0)
    g = GAINS.unpack(gains)
    g.c[:], g.k[:], g.rho[:] = 0.1, 0.1, 1.0
    assert onset(inverse_mass, gains) == math.inf


def test_a_joint_that_is_too_heavy_bears_no_delay():
    least = float(least_mass_ratio(*laws("Table 12", 1)))
    inverse_mass, gains = alone("Table 12", 1, 0.9 * least)
    assert onset(inverse_mass, gains) == 0.0
    assert float(delay_margin(*laws("Table 12", 1), 0.9 * least)) < 0.0
    assert float(delay_margin(*laws("Table 12", 1), 1.1 * least)) > 0.0


@each_table
def test_extremes_of_the_inertia(table):
    low, high = mass_ratios(TABLES[table])
    assert (low <= high).all()
    assert low[0] == pytest.approx(1.0)
    # Drive inertias of 40 and 25 kg m² keep joints 2 and 3 within a factor of four.
    assert (high / low < 4.0).all()


@each_table
def test_coupling_takes_from_the_arm_what_a_joint_alone_would_bear(table):
    arm = arm_onset(TABLES[table], TS, every=40).min()
    ratios = mass_ratios(TABLES[table])[1]
    least = min(onset(*alone(table, joint, b)) for joint, b in enumerate(ratios))
    assert 0.5 * least < arm < least


def test_the_whole_diagram_loses_stability_where_the_arm_does():
    # A process delay of 0 is one tick, of 1 ms two; the mast of Table 12 bears 1.6 ms.
    assert TS < arm_onset(TABLE_12, TS, every=40).min() < 2 * TS
    gains = TABLE_12.array(TS)
    scenario = load_scenario("joint_sine", {"controller": "!IntegralSlidingMode {}"})
    changes = []
    for ticks in (1, 2):
        delay = {"_tag": "!ConstantDelay", "delay": (ticks - 1) * TS}
        scenario = load_scenario(
            "joint_sine",
            {
                "controller": "!IntegralSlidingMode {}",
                "operator.amplitude": 0.0,
                "process_delay.actuation": delay,
            },
        )
        late = simulate(scenario, duration=1.5).sel(time=slice(1.0, None))
        changes.append(float(metrics.chatter(late.tau_applied).sel(joint="d1")))
        radius = max(spectral_radius(m, gains, ticks * TS) for m in inverse_mass_matrices()[::40])
        assert (radius > 1.0) == (ticks == 2)
    assert changes[0] < 1.0 < 0.1 * joints.EFFORT[0] < changes[1]


@pytest.mark.slow
@each_table
def test_every_posture_of_the_grid_bears_a_tick(table):
    assert arm_onset(TABLES[table], TS).min() > TS

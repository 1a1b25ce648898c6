from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from scara_drake import metrics

T = np.linspace(0.0, 2 * np.pi, 20001)
SINE = xr.DataArray(3.0 * np.sin(T), dims="time", coords={"time": T})
TIME = np.linspace(0.0, 20.0, 20001)
SHARE = st.floats(0.1, 0.9)


def signal(values, time=TIME):
    return xr.DataArray(values, dims="time", coords={"time": time})


def first_order(tau=1.0, time=TIME):
    """Step response 1 - exp(-t / tau)."""
    return signal(1.0 - np.exp(-time / tau), time)


def damped(t, zeta, omega):
    """Step response of omega² / (s² + 2 zeta omega s + omega²), zeta < 1."""
    root = np.sqrt(1.0 - zeta**2)
    angle = omega * root * t + np.arccos(zeta)
    return 1.0 - np.exp(-zeta * omega * t) * np.sin(angle) / root


def test_rmse_and_peak_of_a_sine():
    np.testing.assert_allclose(metrics.rmse(SINE), 3.0 / np.sqrt(2.0), rtol=1e-4)
    np.testing.assert_allclose(metrics.peak(-SINE), 3.0)


def test_percentile_of_a_sine():
    # |sin| stays within sin(0.95 π / 2) for 95 % of the time.
    found = metrics.percentile95(SINE)
    np.testing.assert_allclose(found, 3.0 * np.sin(0.95 * np.pi / 2), rtol=1e-3)


def test_chatter_is_the_mean_absolute_difference():
    np.testing.assert_allclose(metrics.chatter(xr.DataArray([0.0, 1.0, -1.0], dims="time")), 1.5)
    # A smooth signal's total variation over its samples: 12 over one period of amplitude 3.
    np.testing.assert_allclose(metrics.chatter(SINE), 12.0 / 20000, rtol=1e-6)
    np.testing.assert_allclose(metrics.total_variation(SINE), 12.0 / (2 * np.pi), rtol=1e-6)


@pytest.mark.parametrize("tau", [0.2, 1.0])
def test_integrals_of_a_first_order_error(tau):
    error = first_order(tau) - 1.0
    np.testing.assert_allclose(metrics.iae(error), tau, rtol=1e-5)
    np.testing.assert_allclose(metrics.ise(error), tau / 2, rtol=1e-5)
    np.testing.assert_allclose(metrics.itae(error), tau**2, rtol=1e-5)
    later = error.assign_coords(time=error.time + 7.0)
    np.testing.assert_allclose(metrics.itae(later), tau**2, rtol=1e-5)


@settings(deadline=None, max_examples=20)
@given(tau=st.floats(0.1, 3.0), start=st.floats(-5.0, 5.0), step=st.floats(-4.0, 4.0))
def test_first_order_step(tau, start, step):
    if abs(step) < 0.01:
        step = 1.0
    x = start + step * first_order(tau)
    target = start + step
    for low, high, expected in ((0.0, 0.9, np.log(10.0)), (0.1, 0.9, np.log(9.0))):
        found = metrics.rise_time(x, start, target, (low, high))
        np.testing.assert_allclose(found, tau * expected, rtol=1e-4)
    settled = metrics.settling_time(x, start, target)
    np.testing.assert_allclose(settled, tau * np.log(100.0), rtol=1e-4)
    settled = metrics.settling_time(x, start, target, band=0.05)
    np.testing.assert_allclose(settled, tau * np.log(20.0), rtol=1e-4)
    np.testing.assert_allclose(metrics.overshoot(x, start, target), 0.0, atol=1e-9)


@settings(deadline=None, max_examples=30)
@given(zeta=SHARE, omega=st.floats(3.0, 10.0), band=st.floats(0.005, 0.05))
def test_second_order_step(zeta, omega, band):
    x = signal(damped(TIME, zeta, omega))
    root = np.sqrt(1.0 - zeta**2)
    overshoot = np.exp(-np.pi * zeta / root)
    np.testing.assert_allclose(metrics.overshoot(x), overshoot, rtol=1e-4, atol=1e-6)
    rise = (np.pi - np.arccos(zeta)) / (omega * root)
    np.testing.assert_allclose(metrics.rise_time(x, fractions=(0.0, 1.0)), rise, rtol=1e-4)
    # It settles on the edge of the band, never leaves it, and the envelope says by when.
    settled = float(metrics.settling_time(x, band=band))
    assert abs(damped(settled, zeta, omega) - 1.0) == pytest.approx(band, rel=0.02)
    after = np.linspace(settled, 20.0, 5001)
    assert abs(damped(after, zeta, omega) - 1.0).max() <= band * 1.01
    assert settled <= -np.log(band * root) / (zeta * omega) + 1e-3


def test_times_are_found_between_coarse_samples():
    ramp = signal([0.0, 0.5, 1.25, 0.995], [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(metrics.rise_time(ramp), 1.0 + 0.4 / 0.75)
    # From 1.25 down to 0.995 it crosses 1.01, the upper edge.
    np.testing.assert_allclose(metrics.settling_time(ramp), 2.0 + 0.24 / 0.255)
    np.testing.assert_allclose(metrics.overshoot(ramp), 0.25)


def test_what_does_not_arrive_has_no_time():
    short = signal([0.0, 0.5, 0.8], [0.0, 1.0, 2.0])
    assert np.isnan(metrics.rise_time(short))
    assert np.isnan(metrics.settling_time(short))
    assert metrics.settling_time(signal([1.0, 1.001, 0.995], [0.0, 1.0, 2.0])) == 0.0


def test_steady_state_is_the_mean_of_the_end():
    error = first_order() - 1.0 + 0.25
    np.testing.assert_allclose(metrics.steady_state(error), 0.25, atol=1e-6)
    np.testing.assert_allclose(metrics.steady_state(error, 1.0), error.mean("time"))
    offset = signal(np.where(TIME < 10.0, 9.0, 2.0))
    np.testing.assert_allclose(metrics.steady_state(offset, 0.5), 2.0)


def test_outside_layer_is_a_share_of_the_samples_there_are():
    s = signal([0.5, -2.0, np.nan, 1.0, 1.5], range(5))
    np.testing.assert_allclose(metrics.outside_layer(s, 1.0), 0.5)
    both = xr.concat([s, s], "joint")
    phi = xr.DataArray([1.0, 1.75], dims="joint")
    np.testing.assert_allclose(metrics.outside_layer(both, phi), [0.5, 0.25])


def test_work_is_signed_and_energy_is_not():
    # A mass on a sine: what goes in comes out again.
    rate, effort = SINE, SINE.copy(data=np.cos(T))
    np.testing.assert_allclose(metrics.work(effort, rate), 0.0, atol=1e-6)
    np.testing.assert_allclose(metrics.energy(effort, rate), 6.0, rtol=1e-6)
    # A damper takes all of it.
    np.testing.assert_allclose(metrics.work(-2.0 * rate, rate), -18.0 * np.pi, rtol=1e-6)


def chirp(t):
    return np.sin(1.3 * t) + 0.4 * np.sin(3.1 * t + 1.0)


@settings(deadline=None, max_examples=20)
@given(
    delay=st.floats(-0.3, 0.3),
    gain=st.floats(0.2, 3.0),
    offset=st.floats(-2.0, 2.0),
    period=st.sampled_from([0.001, 0.01, 0.02]),
)
def test_lag_is_found_between_samples(delay, gain, offset, period):
    t = np.arange(0.0, 6.0, period)
    response = signal(offset + gain * chirp(t - delay), t)
    found = metrics.lag(response, signal(chirp(t), t), 0.5)
    np.testing.assert_allclose(found, delay, atol=1e-4)


def test_lag_has_no_answer_where_there_is_none():
    constant = signal(np.ones_like(TIME))
    assert np.isnan(metrics.lag(signal(chirp(TIME)), constant, 0.2))
    assert np.isnan(metrics.lag(constant, signal(chirp(TIME)), 0.2))
    assert np.isnan(metrics.lag(signal(chirp(TIME - 0.5)), signal(chirp(TIME)), 0.2))


@pytest.mark.parametrize(
    ("time", "largest", "message"),
    [
        ([0.0, 1.0, 2.0, 4.0, 5.0], 1.0, "^time: not even"),
        (range(5), 2.0, "^largest: 2 s, allowed"),
    ],
)
def test_lag_refuses_what_it_cannot_shift(time, largest, message):
    five = signal(np.arange(5.0), time)
    with pytest.raises(ValueError, match=message):
        metrics.lag(five, five, largest)


ONE: list[Callable[..., xr.DataArray]] = [
    metrics.iae, metrics.ise, metrics.itae, metrics.steady_state, metrics.percentile95,
    metrics.total_variation, metrics.overshoot, metrics.rise_time, metrics.settling_time,
]  # fmt: skip


def lag_of_waves(response, reference):
    """The lag on top of a wave: that of two exponentials alone is any, they look alike shifted."""
    wave = np.sin(2.0 * response.time)
    return metrics.lag(response + wave, reference + wave, 0.5)


TWO: list[Callable[..., xr.DataArray]] = [metrics.energy, metrics.work, lag_of_waves]
LEAVE_OUT = {metrics.steady_state, metrics.percentile95}


def family():
    """Responses of several time constants, over two more dims."""
    tau = np.array([[0.5, 0.8, 1.0], [1.5, 1.8, 2.0]])
    values = 1.0 - np.exp(-TIME[:, None, None] / tau)
    return xr.DataArray(values, dims=("time", "run", "joint"), coords={"time": TIME})


@pytest.mark.parametrize("measure", ONE + TWO)
def test_other_dims_are_kept_in_any_order(measure):
    data = family()
    arguments = (data, 2.0 * data)[: 2 if measure in TWO else 1]
    whole = measure(*arguments)
    assert whole.dims == ("run", "joint")
    assert set(whole.coords) == set()
    for run in range(2):
        for joint in range(3):
            alone = measure(*(a.isel(run=run, joint=joint) for a in arguments))
            np.testing.assert_allclose(whole[run, joint], alone, rtol=1e-12, atol=1e-12)
    turned = measure(*(a.transpose("joint", "time", "run") for a in arguments))
    xr.testing.assert_allclose(turned.transpose("run", "joint"), whole)


@pytest.mark.parametrize("measure", ONE + TWO)
def test_a_gap_is_left_out_or_gives_nan_as_stated(measure):
    data = family()
    data[9000, 0, 1] = np.nan
    data[19500, 0, 1] = np.nan
    result = measure(*(data, data)[: 2 if measure in TWO else 1])
    assert np.isnan(result[0, 1]) == (measure not in LEAVE_OUT)
    assert result.notnull().sum() == 6 - int(measure not in LEAVE_OUT)


def test_targets_may_differ_by_entry():
    scale = xr.DataArray([2.0, -3.0], dims="run")
    x = 1.0 + scale * family()
    np.testing.assert_allclose(
        metrics.settling_time(x, 1.0, 1.0 + scale), metrics.settling_time(family()), rtol=1e-9
    )
    np.testing.assert_allclose(
        metrics.rise_time(x, 1.0, 1.0 + scale), metrics.rise_time(family()), rtol=1e-9
    )


def test_errors_of_a_recording():
    joints = xr.DataArray([[1.0, 2.0]], dims=("time", "joint"))
    points = xr.DataArray([[0.0, 3.0, 4.0]], dims=("time", "axis"))
    recording = xr.Dataset(
        {
            "q_desired": joints,
            "q_measured": 0.5 * joints,
            "p_WE_desired": points,
            "p_WE_measured": 0.0 * points,
            "f_env_on_tool_W": points * np.nan,
        }
    )
    np.testing.assert_allclose(metrics.tracking_error(recording), [[0.5, 1.0]])
    np.testing.assert_allclose(metrics.tool_error(recording), [5.0])
    assert np.isnan(metrics.contact_force(recording)).all()

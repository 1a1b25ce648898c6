import numpy as np
import xarray as xr

from scara_drake import metrics

T = np.linspace(0.0, 2 * np.pi, 20001)
SINE = xr.DataArray(3.0 * np.sin(T), dims="time")


def test_rmse_and_peak_of_a_sine():
    np.testing.assert_allclose(metrics.rmse(SINE), 3.0 / np.sqrt(2.0), rtol=1e-4)
    np.testing.assert_allclose(metrics.peak(-SINE), 3.0)


def test_chatter_is_the_mean_absolute_difference():
    np.testing.assert_allclose(metrics.chatter(xr.DataArray([0.0, 1.0, -1.0], dims="time")), 1.5)
    # A smooth signal's total variation over its samples: 12 over one period of amplitude 3.
    np.testing.assert_allclose(metrics.chatter(SINE), 12.0 / 20000, rtol=1e-6)


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

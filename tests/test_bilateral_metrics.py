from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from scara_drake.metrics import bilateral as bm
from scara_drake.operator.hand import Sweep, hand_target_at
from scara_drake.operator.master import Master, move_device

PERIOD = 1e-3
START, SWEPT, TAIL = 1.0, 20.0, 2.0  # [s]


def recording(duration: float = 2.0, **signals: ArrayLike) -> xr.Dataset:
    """A recording at rest, but for the signals (n,) on y or (n, 3) that are given."""
    time = PERIOD * np.arange(round(duration / PERIOD) + 1)
    names = ("x_master", "v_master", "f_master", "f_hand", "hand_target", "p_WE_measured",
             "f_env_on_tool_W", "energy_master_in", "energy_master_out", "energy_slave_in",
             "energy_slave_out")  # fmt: skip
    data: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
        name: (("time", "axis"), np.zeros((time.size, 3))) for name in names
    }
    for name in ("delay_up", "delay_down"):
        data[name] = (("time",), np.zeros(time.size))
    made = xr.Dataset(data, coords={"time": time, "axis": ["x", "y", "z"]})
    for name, values in signals.items():
        samples = np.broadcast_to(values, time.shape)
        if name not in made:
            made[name] = ("time", samples.copy())
        elif made[name].ndim == 1:
            made[name][:] = samples
        else:
            made[name].loc[{"axis": "y"}] = samples
    return made


TIME = recording().time.values


@settings(deadline=None, max_examples=30)
@given(lag=st.floats(0.0, 0.5), slope=st.floats(-3.0, 3.0))
def test_a_ramp_received_late_is_lower_by_slope_times_age(lag: float, slope: float) -> None:
    made = recording(x_master=slope * TIME)
    got = bm.as_received(made.x_master, xr.full_like(made.time, lag)).sel(axis="y")
    np.testing.assert_allclose(got, slope * np.maximum(TIME - lag, 0.0), atol=1e-12)
    assert got.dims == ("time",)


def test_the_age_is_that_of_packets_or_the_delay() -> None:
    assert bm.age_of_information(recording(delay_up=0.2), "up")[5] == 0.2
    assert bm.age_of_information(recording(delay_up=0.2, age_up=0.3), "up")[5] == 0.3
    assert bm.age_of_information(recording(delay_up=0.2), "down")[5] == 0.0


def test_a_tool_that_is_late_by_the_delay_has_no_position_error_but_a_drift() -> None:
    move = lambda t: 0.04 * np.sin(3.0 * np.maximum(t, 0.0))  # noqa: E731
    made = recording(x_master=move(TIME), p_WE_measured=7.0 + 2.0 * move(TIME - 0.3), delay_up=0.3)
    np.testing.assert_allclose(bm.position_error(made, 2.0), 0.0, atol=1e-12)
    np.testing.assert_allclose(bm.drift(made, 2.0), abs(move(TIME) - move(TIME - 0.3)), atol=1e-12)
    off = recording(p_WE_measured=np.where(TIME > 0.0, 3e-3, 0.0))
    assert bm.position_error(off)[-1] == pytest.approx(3e-3)


def test_the_force_error_takes_scale_sign_and_delay_away() -> None:
    at_tool = 20.0 * np.sin(4.0 * TIME)
    shown = -0.1 * 20.0 * np.sin(4.0 * np.maximum(TIME - 0.05, 0.0))
    made = recording(f_env_on_tool_W=at_tool, f_master=shown, delay_down=0.05)
    np.testing.assert_allclose(bm.force_error(made, 0.1), 0.0, atol=1e-5)
    assert float(bm.force_error(made, 1.0).max()) > 15.0


def test_a_recording_without_a_wall_has_no_force_at_the_tool() -> None:
    made = recording(f_env_on_tool_W=np.nan, f_master=2.0)
    made.f_env_on_tool_W[:] = np.nan
    assert float(bm.force_error(made).max()) == 2.0
    assert bm.contact_share(made) == 0.0


def test_ripple_peak_and_contact() -> None:
    turns = recording(f_master=3.0 + np.sqrt(2.0) * np.sin(2.0 * math.pi * 5.0 * TIME))
    assert bm.force_ripple(turns) == pytest.approx(1.0, rel=1e-3)
    turns.f_master.loc[{"axis": "x"}] = 3.0
    assert bm.force_ripple(turns) == pytest.approx(1.0, rel=1e-3)
    assert bm.peak_force(turns) == pytest.approx(math.hypot(3.0, 3.0 + math.sqrt(2.0)), rel=1e-3)
    touched = recording(f_env_on_tool_W=np.where(TIME < 0.5, 4.0, 0.0))
    assert bm.contact_share(touched) == pytest.approx(0.25, abs=1e-3)


@pytest.mark.parametrize(("share", "driven"), [(0.99, False), (1.01, True)])
def test_a_spring_throws_a_device_no_faster_than_its_energy(share: float, driven: bool) -> None:
    mass, stiffness, way = 0.3, 150.0, 0.04
    # The largest speed of an oscillator that is let go at `way`.
    speed = share * way * math.sqrt(stiffness / mass)
    swing = recording(v_master=speed * np.sin(math.sqrt(stiffness / mass) * TIME))
    assert bm.is_driven(swing, mass, 0.5 * stiffness * way**2) is driven


def test_the_energy_margin_is_the_least_of_all_axes() -> None:
    passing = recording(energy_master_in=TIME, energy_slave_out=np.maximum(TIME - 0.2, 0.0))
    assert bm.energy_margin(passing) == 0.0
    assert bm.energy_margin(passing, 0.1) == 0.1
    making = recording(energy_slave_in=0.5 * TIME, energy_master_out=np.minimum(TIME, 1.0))
    assert bm.energy_margin(making) == pytest.approx(-0.5)
    assert bm.energy_margin(making, 0.1) == pytest.approx(-0.4)


def swept(stiffness: float, damping: float, late: int = 0, noise: float = 0.0) -> xr.Dataset:
    """A hand that sweeps a device against a spring and a damper, `late` ticks away."""
    sweep = Sweep(1, 5e-3, 0.06, 16.0, START, SWEPT)
    master = Master(times=[0.5], targets=[[0.0, 0.01, 0.0]], sweep=sweep, actuator_limit=1e9)
    steps = round((START + SWEPT + TAIL) / PERIOD) + 1
    waypoints, parameters = master.waypoints(), master.sweep.parameters()
    device = master.parameters(PERIOD)
    motion, target, after = np.zeros(6), np.zeros(3), np.empty(3)
    f_hand, f = np.zeros(3), np.zeros((steps + late + 1, 3))
    rows = np.zeros((4, steps))
    for k in range(steps):
        f[k + late] = stiffness * motion[:3] + damping * motion[3:]
        shown = f[k]
        rows[:, k] = motion[4], shown[1], f_hand[1], target[1]
        hand_target_at((k + 1) * PERIOD, waypoints, parameters, after)
        move_device(device, shown, after, motion, target, f_hand)
    rows[1] += noise * np.sin(2.0 * math.pi * 3.3 * PERIOD * np.arange(steps))
    names = ("v_master", "f_master", "f_hand", "hand_target")
    duration = PERIOD * (steps - 1)
    return recording(duration, **dict(zip(names, rows, strict=True)))


@settings(deadline=None, max_examples=5)
@given(stiffness=st.floats(50.0, 2000.0), damping=st.floats(1.0, 20.0))
def test_a_sweep_finds_the_spring_and_the_damper(stiffness: float, damping: float) -> None:
    made = swept(stiffness, damping)
    found = bm.impedance(made, "y", START)
    true = bm.wall_impedance(found.frequency, stiffness, damping)
    assert found.frequency[0] >= 0.1
    assert found.frequency[-1] <= 10.0
    assert bm.decades(found, true) < 0.005
    # The hand feels the device beside it, m s + b.
    device = 2.0 + 0.3 * 2j * math.pi * found.frequency
    assert bm.decades(bm.impedance(made, "y", START, "f_hand"), true + device) < 0.02


def test_a_delay_turns_the_impedance_and_leaves_its_size() -> None:
    late = 60
    found = bm.impedance(swept(50.0, 1.0, late), "y", START)
    true = bm.wall_impedance(found.frequency, 50.0, 1.0)
    assert bm.decades(found, true) < 0.01
    turned = np.angle(found / true * np.exp(2j * math.pi * found.frequency * late * PERIOD))
    assert np.median(abs(turned)) < 0.02


def test_what_the_sweep_did_not_cause_counts_little() -> None:
    found = bm.impedance(swept(300.0, 5.0, noise=0.2), "y", START)
    clean = bm.wall_impedance(found.frequency, 300.0, 5.0)
    assert bm.decades(found, clean) < 0.03


def test_decades() -> None:
    frequency = xr.DataArray(np.linspace(0.1, 10.0, 200), dims="frequency")
    frequency = frequency.assign_coords(frequency=frequency.values)
    wall = bm.wall_impedance(frequency, 1e4, 100.0)
    assert abs(wall[0]) == pytest.approx(math.hypot(100.0, 1e4 / (0.2 * math.pi)))
    assert bm.decades(0.1 * wall, wall) == pytest.approx(1.0)
    assert bm.decades(0.1 * wall, wall, signed=True) == pytest.approx(-1.0)
    assert bm.decades(0.0 * wall, wall) == math.inf
    # A factor that is ten to the power of log10 f has its mean at log10 f = 0.
    assert bm.decades(frequency * wall, wall, signed=True) == pytest.approx(0.0, abs=1e-3)
    assert bm.decades(frequency * wall, wall) == pytest.approx(0.5, abs=2e-3)

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.systems.analysis import Simulator
from strategies import examples

from scara_drake.common.resources import resource
from scara_drake.operator.joystick import Joystick, JoystickSource
from scara_drake.operator.mapping import JoystickMapping, remove_dead_zone
from scara_drake.operator.shipped_trace import (
    OperatorProfile,
    main,
    operator_trace,
    stick_for,
    write_operator_trace,
)
from scara_drake.operator.trace import Trace, load_operator, load_trace, save_trace
from scara_drake.operator.trace_columns import COLUMNS, MORE_COLUMNS, SAID
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.vectors import SETTING_NAMES

HEADER = "time,x,y,z,mast_axis,mast_hat\n"


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_columns_in_any_order_among_others(tmp_path: Path) -> None:
    path = write(
        tmp_path / "t.csv",
        "note,mast_hat, y,time,x,mast_axis,z\na,1,0.2,0,0.1,0.4,0.3\n\nb,-1,0,0.5,0,0,1.05\n",
    )
    times, axes = load_trace(path)
    np.testing.assert_array_equal(times, [0.0, 0.5])
    np.testing.assert_array_equal(axes, [[0.1, 0.2, 0.3, 0.4, 1.0], [0, 0, 1.05, 0, -1]])


@settings(max_examples=30, deadline=None)
@given(axes=arrays(float, (4, 5), elements=st.floats(-1.05, 1.05)))
def test_what_is_written_is_read(
    axes: np.ndarray, tmp_path_factory: pytest.TempPathFactory
) -> None:
    rows = "".join(f"{k}," + ",".join(map(repr, row.tolist())) + "\n" for k, row in enumerate(axes))
    path = write(tmp_path_factory.mktemp("trace") / "t.csv", HEADER + rows)
    np.testing.assert_array_equal(load_trace(path)[1], axes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no column time, x, y, z, mast_axis, mast_hat"),
        ("time,x,z,mast_axis\n0,0,0,0\n", "no column y, mast_hat"),
        (HEADER, "no rows"),
        (HEADER + "0,0,0,0,0,0\n1,0,nan,0,0,0\n", "line 3, y: 'nan', allowed a finite"),
        (HEADER + "0,0,0,-inf,0,0\n", "line 2, z: '-inf', allowed a finite"),
        (HEADER + "inf,0,0,0,0,0\n", "line 2, time: 'inf', allowed a finite"),
        (HEADER + "0,0,0,0,0\n", "line 2, mast_hat: '', allowed a finite"),
        (HEADER + "0,left,0,0,0,0\n", "line 2, x: 'left', allowed a finite"),
        (HEADER + "0,0,0,0,1.06,0\n", r"line 2, mast_axis: 1.06, allowed -1.05 to 1.05"),
        (HEADER + "0,0,0,0,0,0\n0,0,0,0,0,0\n", "time 0 s after 0 s, allowed times that increase"),
        (HEADER + "1,0,0,0,0,0\n0.5,0,0,0,0,0\n", "time 0.5 s after 1 s"),
        (HEADER + "0,0.1_0,0,0,0,0\n", "line 2, x: '0.1_0', allowed a finite"),
        (HEADER + "0,\u0661,0,0,0,0\n", "line 2, x: '\u0661', allowed a finite"),
        (HEADER + "0,0,0,0,0,0\n\n1,0,0,True,0,0\n", "line 4, z: 'True', allowed a finite"),
        (HEADER + "0,0,0,True,0,0\n", "line 2, z: 'True', allowed a finite"),
        (HEADER + '0,"0,0,0,0,0\n' + "1,0,0,0,0,0\n" * 200, "allowed CSV text"),
        (HEADER + "0,a" + "\nb" * 200, "allowed a finite number|allowed CSV"),
        (HEADER.replace("z", "x"), "no column z"),
        ("x," + HEADER + "0,0,0,0,0,0,0\n", "column x twice, allowed once"),
        (HEADER + "1700000000.5,0,0,0,0,0\n", "first time is 1700000000 s|1700000000.5 s"),
        (HEADER + "100,0,0,0,0,0\n", "first time is 100 s, allowed at most 10 s; .*first_row"),
        (HEADER + "0,0,0,0,0,0\n1000,0,0,0,0,0\n", "gap of 1000 s .* times are in seconds"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        load_trace(write(tmp_path / "bad.csv", text))
    assert "bad.csv" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("period", [1.0, 10.0, 20.0])
def test_milliseconds_are_refused(tmp_path: Path, period: float) -> None:
    rows = "".join(f"{period * k},0,0,0,0,0\n" for k in range(200))
    with pytest.raises(ValueError, match=r"from row to row in 200 rows.* times are in seconds"):
        load_trace(write(tmp_path / "ms.csv", HEADER + rows))


@pytest.mark.parametrize("first", [0.0, 100.0, 1.7e9])
def test_times_are_counted_from_the_first_row_where_asked(tmp_path: Path, first: float) -> None:
    rows = "".join(f"{first + k},0,0,0,0,0\n" for k in range(3))
    path = write(tmp_path / "t.csv", HEADER + rows)
    np.testing.assert_array_equal(load_trace(path, from_first_row=True)[0], [0.0, 1.0, 2.0])


def test_a_field_of_the_scenario_asks_for_it(tmp_path: Path) -> None:
    path = write(tmp_path / "t.csv", HEADER + "1700000000,0,0,0,0,0\n1700000001,0,0,0,0,1\n")
    settings = {"operator.trace": str(path)}
    with pytest.raises(ValueError, match=r"operator\.trace_from_first_row"):
        load_scenario("free_motion", settings)
    scenario = load_scenario("free_motion", settings | {"operator.trace_from_first_row": True})
    assert isinstance(scenario.operator, Joystick)


def test_missing_file_and_binary_file(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"trace: '.*no\.csv', allowed a CSV file that exists"):
        load_trace(tmp_path / "no.csv")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="UTF-8"):
        load_trace(tmp_path / "b.csv")


# A trace out of a recording.


@pytest.mark.parametrize(
    "fields",
    [{}, {"logging.period": 0.01}, {"logging.period": 0.007, "operator.sample_period": 0.02}],
)
def test_a_recording_played_again_is_equal_to_the_bit(tmp_path: Path, fields: dict) -> None:
    # From a trace of its own: the stick starts anywhere and moves with every sample.
    axes = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 5))
    axes[:, :3] *= 0.2
    rows = "".join(
        f"{0.01 * k:.2f}," + ",".join(map(repr, row.tolist())) + "\n" for k, row in enumerate(axes)
    )
    trace = write(tmp_path / "first.csv", HEADER + rows)
    first = simulate(load_scenario("free_motion", {"operator.trace": str(trace), **fields}), 2.0)
    save_trace(first, tmp_path / "again.csv")
    fields = fields | {"operator.trace": str(tmp_path / "again.csv")}
    again = simulate(load_scenario("free_motion", fields), 2.0)
    assert np.ptp(first.joystick_axes.values, axis=0).min() > 0.1
    assert first.equals(again)  # NaN, of what is not there, included


def test_a_device_starts_at_rest_and_then_has_its_first_sample(tmp_path: Path) -> None:
    """What a trace cannot say of a device, that it is at zero before it is read, is a row too."""
    axes = np.zeros((4, 5))
    axes[1:, 0] = 0.5, 0.25, -1.0
    recording = xr.Dataset(
        {"joystick_axes": (("time", "stick"), axes, {"period": 0.01})},
        coords={"time": [0.0, 0.01, 0.02, 0.03]},
    )
    save_trace(recording, tmp_path / "t.csv")
    times, rows = load_trace(tmp_path / "t.csv")
    np.testing.assert_array_equal(times, [-0.01, 0.0, 0.01, 0.02])
    np.testing.assert_array_equal(rows, axes)


def test_what_has_no_stick_or_too_few_of_its_samples_is_refused(tmp_path: Path) -> None:
    def sparse(value: float, every: float) -> xr.Dataset:
        axes = np.full((3, 5), value)
        return xr.Dataset(
            {"joystick_axes": (("time", "stick"), axes, {"period": 0.01})},
            coords={"time": every * np.arange(3)},
        )

    for recording, said in (
        (xr.Dataset(coords={"time": [0.0]}), "no joystick_axes"),
        (sparse(np.nan, 0.01), "no joystick_axes"),
        (sparse(0.0, 0.02), "a sample every 0.02 s, allowed at most 0.01 s"),
    ):
        with pytest.raises(ValueError, match=said):
            save_trace(recording, tmp_path / "t.csv")
    assert list(tmp_path.iterdir()) == []


# What a device says beside its stick.


def test_further_columns_are_read_and_missing_ones_have_their_defaults(tmp_path: Path) -> None:
    text = "clutch," + HEADER.strip() + ",delay_up\n1,0,0,0,0,0,0,0.25\n"
    trace = load_operator(write(tmp_path / "t.csv", text))
    assert trace.said is not None
    said = dict(zip(MORE_COLUMNS, trace.said[0], strict=True))
    assert said.pop("clutch") == 1.0
    assert said.pop("delay_up") == 0.25
    ones = {"engage", "connected", "force_scale", "motion_scale", "gain_scale"}
    assert said == {name: float(name in ones) for name in said}
    assert load_operator(write(tmp_path / "s.csv", HEADER + "0,0,0,0,0,0\n")).said is None


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("engage", "2", "line 2, engage: 2, allowed 0 to 1"),
        ("yaw", "-1.2", r"line 2, yaw: -1.2, allowed -1.05 to 1.05"),
        ("age", "-1", "line 2, age: -1, allowed 0 to inf"),
        ("gain_scale", "nan", "line 2, gain_scale: 'nan', allowed a finite"),
    ],
)
def test_further_columns_are_checked(tmp_path: Path, column: str, value: str, message: str) -> None:
    text = f"{HEADER.strip()},{column}\n0,0,0,0,0,0,{value}\n"
    with pytest.raises(ValueError, match=message):
        load_operator(write(tmp_path / "t.csv", text))


def played(trace: Trace, duration: float) -> xr.Dataset:
    """What a recording holds of a source: each port before the update of a tick."""
    source = JoystickSource(trace, 0.01)
    simulator = Simulator(source)
    times = np.arange(round(duration / 0.01)) * 0.01
    rows: dict[str, list[np.ndarray]] = {name: [] for name in source.declaration.memory}
    for time in times:
        simulator.AdvanceTo(max(time - 1e-6, 0.0))
        for name, entries in rows.items():
            entries.append(source.GetOutputPort(name).Eval(simulator.get_context()))
    ports = {name: np.array(entries) for name, entries in rows.items()}
    vectors = {
        name: (("time", f"of_{name}"), ports[name], {"period": 0.01})
        for name in ("joystick_axes", "orientation_axes", "operator_buttons")
    }
    status, settings = ports["device_status"].T, ports["live_settings"].T
    names = ("device_connected", "device_age", "lateness", "bad_samples")
    single = dict(zip(names, status, strict=True))
    single |= {f"live_{name}": row for name, row in zip(SETTING_NAMES, settings, strict=True)}
    np.testing.assert_array_equal(ports["device_connected"][:, 0], status[0])
    return xr.Dataset(
        vectors | {name: ("time", row) for name, row in single.items()}, coords={"time": times}
    )


@examples(10)
@given(seed=st.integers(0, 2**32 - 1))
def test_all_that_a_device_said_is_written_and_read_to_the_bit(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    draws = np.random.default_rng(seed)
    said = draws.uniform(0.0, 1.0, (12, SAID.size))
    said[:, MORE_COLUMNS.index("lateness")] -= 0.5  # a run that waits is early
    trace = Trace(np.linspace(0.0, 0.11, 12), draws.uniform(-1.0, 1.0, (12, 5)), said)
    first = played(trace, 0.12)
    path = tmp_path_factory.mktemp("trace") / "t.csv"
    save_trace(first, path)
    assert len(pd.read_csv(path).columns) == 1 + 5 + SAID.size
    xr.testing.assert_identical(first, played(load_operator(path), 0.12))


@pytest.mark.slow
def test_a_trace_with_further_columns_runs_compiled_as_in_drake(tmp_path: Path) -> None:
    draws = np.random.default_rng(5)
    columns = {name: draws.uniform(0.0, 1.0, 40) for name in (*COLUMNS[1:], *MORE_COLUMNS)}
    path = tmp_path / "t.csv"
    pd.DataFrame({"time": np.linspace(0.0, 0.39, 40)} | columns).to_csv(path, index=False)
    scenario = load_scenario("free_motion", {"operator.trace": str(path)})
    drake, compiled = (simulate(scenario, 0.4, engine=name) for name in ("drake", "compiled"))
    for name in ("joystick_axes", "orientation_axes", "operator_buttons", "device_connected"):
        np.testing.assert_array_equal(drake[name], compiled[name])
    for name in ("device_age", "lateness", "bad_samples", *(f"live_{n}" for n in SETTING_NAMES)):
        np.testing.assert_array_equal(drake[name], compiled[name])
        assert drake[name].std() > 0.1


# The shipped operator.


def shipped() -> Path:
    return resource("diagrams", "operator_trace.csv")


def commanded_y(axes: np.ndarray, mapping: JoystickMapping) -> np.ndarray:
    excess = np.clip((np.abs(axes[:, 1]) - mapping.dead_zone) / (1 - mapping.dead_zone), 0, 1)
    return mapping.centre[1] + mapping.scale * np.sign(axes[:, 1]) * excess


def test_shipped_trace_is_regenerated_byte_for_byte(tmp_path: Path) -> None:
    main([str(tmp_path / "again.csv")])
    assert (tmp_path / "again.csv").read_bytes() == shipped().read_bytes()


def test_shipped_trace_is_30_s_at_100_hz_of_8_bits() -> None:
    assert shipped().read_text().splitlines()[0] == ",".join(COLUMNS)
    times, axes = load_trace(shipped())
    np.testing.assert_array_equal(times, np.arange(3000) / 100)
    spikes = np.zeros(3000, dtype=bool)
    for start, _, samples, _ in OperatorProfile().spikes:
        spikes[round(100 * start) : round(100 * start) + samples] = True
    levels = axes[~spikes, :3] * 127
    np.testing.assert_allclose(levels, np.round(levels), atol=127 * 0.5e-5 + 1e-9)
    assert set(axes[:, 4]) == {0.0, 1.0}
    assert not axes[:, 3].any()


def test_shipped_trace_presses_twice_and_never_deeper_than_25_mm() -> None:
    times, axes = load_trace(shipped())
    depth = OperatorProfile().wall_y - commanded_y(axes, JoystickMapping())
    assert depth.max() < 0.025
    mean = np.convolve(depth, np.ones(31) / 31, mode="same")  # free of tremor
    inside = mean > 0.005
    presses = np.flatnonzero(np.diff(inside.astype(int)) == 1)
    assert len(presses) == 2
    assert inside[presses[1] + 1 :].argmin() > 400  # 4 s and more
    held = (times > 22) & (times < 25)
    assert abs(depth[held].mean() - 0.018) < 0.002
    # The free motion stays 10 cm away, spikes included; the end is at the centre.
    assert depth[times < 15].max() < -0.1
    assert np.abs(axes[times > 29, :3]).max() < JoystickMapping().dead_zone


def test_shipped_trace_moves_every_axis_and_the_mast_freely() -> None:
    times, axes = load_trace(shipped())
    free = times < 15
    assert (np.ptp(axes[free, :3], axis=0) > 0.2).all()
    assert 1.0 < axes[free, 4].sum() / 100 < 3.0  # [s] of hat


def test_shipped_trace_has_three_spikes_of_one_to_three_samples() -> None:
    _, axes = load_trace(shipped())
    jumps = np.argwhere(np.abs(np.diff(axes[:, :3], axis=0)) > 0.3)
    rows = jumps[:, 0].reshape(-1, 2)
    assert len(rows) == 3
    assert sorted(rows[:, 1] - rows[:, 0]) == [1, 2, 3]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_shipped_trace_has_tremor_of_8_to_10_hz(axis: int) -> None:
    times, axes = load_trace(shipped())
    still = axes[(times >= 21.4) & (times < 25.4), axis]
    power = np.abs(np.fft.rfft(still - still.mean())) ** 2
    frequency = np.fft.rfftfreq(still.size, 0.01)
    band = (frequency >= 7.5) & (frequency <= 10.5)  # 3 of 50 Hz: white noise would give 6 %
    assert power[band].sum() > 0.5 * power.sum()
    assert np.ptp(still) < 0.03


def test_reaches_without_tremor_are_minimum_jerk() -> None:
    smooth = OperatorProfile(tremor=0.0, spikes=[], levels=10**9)
    times, axes = operator_trace(smooth)
    leg = (times >= 1.0) & (times <= 2.6)
    speed = np.gradient(axes[leg, 0], 0.01)
    distance = axes[leg, 0][-1] - axes[leg, 0][0]
    assert speed.max() == pytest.approx(1.875 * distance / 1.6, rel=1e-3)
    assert abs(speed[0]) < 0.01 * speed.max()


@settings(deadline=None)  # compiles at the first call
@given(offset=st.floats(-0.5, 0.5))
def test_stick_for_is_the_inverse_of_the_mapping(offset: float) -> None:
    mapping = JoystickMapping()
    stick = stick_for(offset, mapping)
    assert mapping.scale * remove_dead_zone(stick, mapping.dead_zone) == pytest.approx(
        offset, abs=1e-12
    )


def test_depths_follow_the_profile(tmp_path: Path) -> None:
    profile = replace(
        OperatorProfile(), wall_y=-1.0, hold_depth=0.01, tremor=0.0, levels=10**9, seed=3
    )
    write_operator_trace(tmp_path / "t.csv", profile)
    times, axes = load_trace(tmp_path / "t.csv")
    held = commanded_y(axes, profile.mapping)[(times > 22) & (times < 25)]
    np.testing.assert_allclose(held, -1.01, atol=1e-5)

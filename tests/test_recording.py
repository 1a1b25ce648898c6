import json
import subprocess
import sys
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake import (
    load_recording,
    load_scenario,
    make_diagram,
    recording,
    save_recording,
    simulate,
    to_table,
)
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.signals import JOINT_QUANTITIES, SIGNALS


@pytest.fixture(scope="module")
def run():
    scenario = load_scenario("teleoperation", {"duration": 0.2, "seed": 3})
    return scenario, simulate(scenario)


def test_dims_units_and_attributes(run):
    _, dataset = run
    dims = {
        ("time", "joint"): "q_measured q_desired v_measured v_desired tau_commanded tau_applied "
        "sliding_variable saturation",
        ("time", "axis"): "p_WE_measured p_WE_desired p_WE_commanded p_WE_received f_env_on_tool_W "
        "f_haptic",
        ("time", "surface"): "penetration",
        ("time", "motor"): "rumble",
        ("time", "stick"): "joystick_axes",
        ("time",): "delay_up delay_down status",
    }
    names = [name for group in dims.values() for name in group.split()]
    assert sorted(names) == sorted(dataset.data_vars)
    assert {name for name, signal in SIGNALS.items() if signal.always} <= set(names)
    for expected, group in dims.items():
        for name in group.split():
            assert dataset[name].dims == expected
            if "joint" in expected and name != "saturation":
                units = dataset[dataset[name].attrs["units_in"]]
                assert units.dims == ("joint",)
                assert set(units.values[1:]) == {"rad" + units.values[0].removeprefix("m")} or (
                    list(units.values) == ["N"] + 5 * ["N m"]
                )
            else:
                assert dataset[name].attrs["units"]
            assert dataset[name].notnull().all()
    assert list(dataset.joint.values) == ["d1", *(f"theta{i}" for i in range(2, 7))]
    assert list(dataset.surface.values) == ["wall"]
    assert dataset.time.attrs["units"] == "s"
    np.testing.assert_allclose(dataset.time, np.arange(201) * 1e-3, atol=1e-12)
    assert dataset.attrs["seed"] == 3
    assert set(json.loads(dataset.attrs["versions"])) >= {"scara-drake", "drake", "numpy"}
    assert dataset.joystick_axes.attrs["period"] == 0.01
    assert dataset.q_measured.attrs["period"] == 0.001


def test_the_recorded_scenario_runs_again_to_the_same_bits(run, tmp_path):
    _, dataset = run
    (tmp_path / "again.yaml").write_text(dataset.attrs["scenario"])
    assert simulate(load_scenario(tmp_path / "again.yaml")).equals(dataset)


def test_tool_position_is_that_of_the_joints(run):
    _, dataset = run
    expected = forward_kinematics(dataset.q_measured.values)[:, :3, 3]
    np.testing.assert_array_equal(dataset.p_WE_measured, expected)


def test_your_own_simulator_gives_the_same_recording(run):
    scenario, _ = run
    dataset = simulate(scenario, engine="drake")
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(scenario.duration)
    assert without_wall_time(recording(diagram, simulator.get_context())).identical(
        without_wall_time(dataset)
    )


def without_wall_time(dataset):
    """The dataset without the seconds that the first posture took, and without what ran it."""
    left_out = {"first_posture_seconds", "engine"}
    kept = {k: v for k, v in dataset.attrs.items() if k not in left_out}
    return dataset.drop_attrs(deep=False).assign_attrs(kept)


def test_another_diagram_is_refused():
    builder = DiagramBuilder()
    builder.AddSystem(ConstantVectorSource(np.zeros(1)))
    diagram = builder.Build()
    with pytest.raises(ValueError, match="allowed a Diagram of"):
        recording(diagram, diagram.CreateDefaultContext())


def test_a_file_gives_back_the_same_dataset(run, tmp_path):
    _, dataset = run
    save_recording(dataset, tmp_path / "new" / "run.nc")
    loaded = load_recording(tmp_path / "new" / "run.nc")
    assert loaded.equals(dataset)
    assert loaded.attrs["scenario"] == dataset.attrs["scenario"]
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["run.nc"]


def test_a_failed_write_leaves_the_old_file_and_nothing_else(run, tmp_path, monkeypatch):
    _, dataset = run
    path = tmp_path / "run.nc"
    path.write_text("old")

    def fail(self, target, **kwargs):
        target.write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", fail)
    with pytest.raises(OSError, match="disk full"):
        save_recording(dataset, path)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("run.nc", "old")]


def test_other_files_are_refused(tmp_path):
    (tmp_path / "x.nc").write_text("no")
    with pytest.raises(ValueError, match="allowed NetCDF written by a run"):
        load_recording(tmp_path / "x.nc")
    with pytest.raises(ValueError, match="allowed a file that exists"):
        load_recording(tmp_path / "none.nc")


def test_times_are_the_decimals_that_they_are_written_as(run):
    _, dataset = run
    for k in range(201):
        assert dataset.sel(time=float(f"{k / 1000:.3f}")).time == dataset.time[k]


@pytest.fixture(scope="module")
def file(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("format") / "run.nc"
    save_recording(run[1], path)
    return path


def test_other_programs_can_read_the_file(file):
    """No texts of variable length, no integers of 8 bytes, a checksum for each chunk."""
    with netCDF4.Dataset(file) as data:
        data.set_auto_chartostring(False)
        assert data.Conventions.startswith("CF-1.")
        assert data.format_version == 2
        owners: list[Any] = [data, *data.variables.values()]
        values = [owner.getncattr(name) for owner in owners for name in owner.ncattrs()]
        assert {np.asarray(value).dtype.kind for value in values} <= set("Uif")
        assert np.dtype(np.int64) not in {getattr(value, "dtype", None) for value in values}
        assert "_FillValue" not in data["time"].ncattrs()
        assert data["time"].long_name
        for name, variable in data.variables.items():
            assert variable.dtype in (np.float64, np.dtype("S1")), name
            if variable.dimensions[0] == "time":
                on = {name for name, value in variable.filters().items() if value}
                assert on >= {"fletcher32", "shuffle", "zlib"}


@pytest.mark.parametrize("seed", [0, 2**31 - 1, 2**31, 2**63 - 1])
def test_every_seed_comes_back(run, tmp_path, seed):
    save_recording(run[1].isel(time=slice(3)).assign_attrs(seed=seed), tmp_path / "run.nc")
    assert load_recording(tmp_path / "run.nc").attrs["seed"] == seed


def test_a_name_in_any_script_comes_back(run, tmp_path):
    attributes = {"scenario_name": "Überlauf θ₂ 押す"}
    save_recording(run[1].isel(time=slice(3)).assign_attrs(attributes), tmp_path / "run.nc")
    assert load_recording(tmp_path / "run.nc").attrs["scenario_name"] == "Überlauf θ₂ 押す"


def test_units_are_such_as_libraries_read(run):
    """Those of the joints are in coordinates: each has its own."""
    known = {"1", "m", "m/s", "m/s^2", "rad", "rad/s", "rad/s^2", "N", "N m", "J", "s"}
    _, dataset = run
    assert {v.attrs["units"] for v in dataset.data_vars.values() if "units" in v.attrs} <= known
    for name in JOINT_QUANTITIES:
        assert set(dataset[name].values) <= known
        assert dataset[name].dims == ("joint",)
    assert dataset[dataset.tau_applied.attrs["units_in"]].sel(joint="theta2") == "N m"


def test_a_run_without_a_surface_has_no_empty_dimension():
    dataset = simulate(load_scenario("mast_step", {"duration": 0.05}))
    assert 0 not in dataset.sizes.values()
    assert "penetration" not in dataset


def test_a_table_has_a_row_for_each_sample(run):
    _, dataset = run
    table = to_table(dataset)
    np.testing.assert_array_equal(table.index, dataset.time)
    np.testing.assert_array_equal(
        table["q_measured_theta3"], dataset.q_measured.sel(joint="theta3")
    )
    np.testing.assert_array_equal(table["delay_up"], dataset.delay_up)
    assert table.shape == (201, sum(int(np.prod(v.shape[1:])) for v in dataset.data_vars.values()))
    assert table.attrs["units"]["tau_applied_theta2"] == "N m"
    assert table.attrs["units"]["time"] == "s"


def test_a_recording_of_the_first_format_is_read(run, tmp_path):
    """Texts of variable length, a seed of 8 bytes, an empty dimension, no checksums."""
    old = run[1].isel(surface=slice(0)).assign_attrs(seed=np.int64(3))
    del old.attrs["format_version"], old.attrs["ended_by"]
    old.to_netcdf(tmp_path / "old.nc", engine="netcdf4")
    loaded = load_recording(tmp_path / "old.nc")
    assert loaded.equals(old)
    assert loaded.attrs["seed"] == 3


WITHOUT_DRAKE = """
import sys
sys.modules["pydrake"] = None
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import scara_drake as sd
from scara_drake import metrics, plotting
from scara_drake.cli.main import main
data = sd.load_recording(sys.argv[1])
assert float(metrics.peak(metrics.tool_error(data))) >= 0.0
assert len(sd.to_table(data)) == data.sizes["time"]
for draw in (plotting.tracking, plotting.tracking_error, plotting.tool_path, plotting.contact_force,
             plotting.haptic):
    draw(data, plt.subplots()[1])
for suffix in (".csv", ".parquet", ".mcap"):
    assert sd.export(sys.argv[1], sys.argv[1] + suffix).stat().st_size
assert main(["compare", sys.argv[1], sys.argv[1], "--html", sys.argv[1] + ".html"]) == 0
assert main(["replay", "--speed", "10", sys.argv[1]]) == 0
assert main(["run", "joint_sine"]) == 2
assert not [name for name in sys.modules if name.startswith("pydrake.")]
"""


def test_recordings_are_read_judged_drawn_and_played_without_drake(file):
    command = [sys.executable, "-c", WITHOUT_DRAKE, str(file)]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stderr.startswith("scara-drake: run: ")
    assert result.stderr.count("\n") == 1

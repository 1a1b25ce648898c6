import json

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
)
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings.signals import SIGNALS


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
    scenario, dataset = run
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(scenario.duration)
    assert recording(diagram, simulator.get_context()).identical(dataset)


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

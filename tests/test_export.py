"""Recordings for other programs, read back by those programs' own readers."""

import json
import subprocess
import sys
import tracemalloc
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from scipy.spatial.transform import Rotation
from strategies import examples

import scara_drake as sd
from scara_drake.cli.main import main
from scara_drake.cli.parser import make_parser
from scara_drake.display import look
from scara_drake.exports import mcap_file, parquet_file, scene
from scara_drake.exports.formats import FORMATS
from scara_drake.joints import JOINT_NAMES
from scara_drake.kinematics import forward_kinematics
from scara_drake.recordings import table as tables

needs_rerun = pytest.mark.skipif(find_spec("rerun") is None, reason="rerun-sdk is not installed")
WALL = {"name": "front", "point": [0.8, -0.75, 3.0], "normal": [0.0, 1.0, 0.0]}


@pytest.fixture(scope="module")
def recording() -> xr.Dataset:
    """The tool presses from the start; once it is not known where it shall be."""
    scenario = sd.load_scenario("teleoperation", {"environment.surfaces": [WALL]})
    made = sd.simulate(scenario, duration=0.2, engine="drake")
    made.p_WE_desired[:50] = np.nan  # less than a piece
    return made


@pytest.fixture(scope="module")
def file(recording: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export") / "press.nc"
    sd.save_recording(recording, path)
    return path


@pytest.fixture(autouse=True)
def in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Several pieces, of which the last is short."""
    monkeypatch.setattr(tables.pieces, "__defaults__", (64,))


def messages(path: Path) -> tuple[dict[str, list], Any]:
    """The messages of an MCAP file by topic, each with its time [ns], and its summary."""
    found: dict[str, list] = {}
    with open(path, "rb") as stream:
        reader = make_reader(stream)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            data = json.loads(message.data)
            of_topic = found.setdefault(channel.topic, [])
            if len(of_topic) % 50 == 0:
                jsonschema.validate(data, json.loads(schema.data))
            of_topic.append((message.log_time, data))
        return found, reader.get_summary()


@pytest.mark.parametrize("to", ["csv", "parquet"])
def test_a_table_reads_back_to_the_bit(
    recording: xr.Dataset, file: Path, tmp_path: Path, to: str
) -> None:
    path = sd.export(file, tmp_path / f"press.{to}")
    read = pd.read_csv(path) if to == "csv" else pd.read_parquet(path)
    pd.testing.assert_frame_equal(read.set_index("time"), sd.to_table(recording), check_exact=True)
    column = recording.tau_applied.sel(joint="theta3").values
    np.testing.assert_array_equal(read["tau_applied_theta3"], column)
    assert len(read.columns) == len(set(read.columns))


def test_a_csv_has_its_units_beside_it(file: Path, tmp_path: Path) -> None:
    path = sd.export(file, tmp_path / "press.csv")
    beside = json.loads((tmp_path / "press.csv-metadata.json").read_text())
    told = {each["name"]: each for each in beside["tableSchema"]["columns"]}
    assert list(told) == list(pd.read_csv(path, nrows=1).columns)
    assert beside["url"] == "press.csv"
    assert told["tau_applied_d1"]["schema:unitText"] == "N"
    assert told["tau_applied_theta2"]["schema:unitText"] == "N m"
    assert told["penetration_front"]["dc:description"] == "depth of the tool in each surface"
    assert all(each["schema:unitText"] for each in told.values())
    assert beside["dc:description"]["scenario_name"] == "teleoperation"


def test_a_parquet_has_its_units_inside(file: Path, tmp_path: Path) -> None:
    path = sd.export(file, tmp_path / "press.parquet")
    assert pd.read_parquet(path).attrs["units"]["q_measured_theta2"] == "rad"
    schema = pq.read_schema(path)
    assert schema.field("v_measured_d1").metadata[b"units"] == b"m/s"
    assert schema.metadata[b"scenario"].startswith(b"name: teleoperation")


def test_an_mcap_has_every_number_at_its_time(
    recording: xr.Dataset, file: Path, tmp_path: Path
) -> None:
    found, summary = messages(sd.export(file, tmp_path / "press.mcap"))
    stamps = np.round(1e9 * recording.time.values).astype(int).tolist()
    for name, variable in recording.data_vars.items():
        if not variable.notnull().any():
            assert f"/{name}" not in found
            continue
        assert [stamp for stamp, _ in found[f"/{name}"]] == stamps
    rows = [[row[joint] for joint in JOINT_NAMES] for _, row in found["/q_measured"]]
    np.testing.assert_array_equal(rows, recording.q_measured)
    values = [row["value"] for _, row in found["/delay_up"]]
    np.testing.assert_array_equal(values, recording.delay_up)
    known = [row["x"] for _, row in found["/p_WE_desired"]]
    assert known[:50] == [None] * 50  # what is not known is null, not NaN, which JSON has not
    np.testing.assert_array_equal(known[50:], recording.p_WE_desired.sel(axis="x")[50:])
    assert "[N m]" in json.dumps(
        next(json.loads(s.data) for s in summary.schemas.values() if s.name.endswith("tau_applied"))
    )
    assert {"foxglove.JointStates", "foxglove.FrameTransforms", "foxglove.SceneUpdate"} <= {
        schema.name for schema in summary.schemas.values()
    }


def test_an_mcap_has_the_robot_where_it_is(
    recording: xr.Dataset, file: Path, tmp_path: Path
) -> None:
    found, _ = messages(sd.export(file, tmp_path / "press.mcap"))
    assert len(found["/tf"]) == 11  # a picture each 20 ms
    for stamp, message in found["/tf"]:
        at = recording.sel(time=stamp / 1e9, method="nearest")
        frames = {each["child_frame_id"]: each for each in message["transforms"]}
        X = forward_kinematics(at.q_measured.values)
        place, turn = (frames["tool"][key] for key in ("translation", "rotation"))
        np.testing.assert_allclose([place[k] for k in "xyz"], X[:3, 3], atol=1e-12)
        R = Rotation.from_quat([turn[k] for k in "xyzw"]).as_matrix()
        np.testing.assert_allclose(R, X[:3, :3], atol=1e-12)
        assert ("desired" in frames) is (stamp >= 50e6)
    first = found["/scene"][0][1]["entities"]
    carried = {entity["frame_id"] for entity in first}
    assert carried - {"world"} <= set(frames)
    wall = next(entity for entity in first if entity["frame_id"] == "world")
    assert len(wall["cubes"]) == 5  # and its edges
    states = {each["name"]: each for each in found["/joint_states"][-1][1]["joints"]}
    assert states["theta4"]["effort"] == float(recording.tau_applied.sel(joint="theta4")[-1])
    # The arrow ends at the tool, as long as the force says, along it.
    arrow = found["/scene"][-1][1]["entities"][0]["arrows"][0]
    force = recording.f_env_on_tool_W.values[-1]
    newtons = float(np.linalg.norm(force))
    assert newtons > 50.0
    assert arrow["shaft_length"] == pytest.approx(look.shaft_length(newtons))
    turn = Rotation.from_quat([arrow["pose"]["orientation"][k] for k in "xyzw"])
    along = turn.as_matrix()[:, 0]
    np.testing.assert_allclose(along, force / newtons, atol=1e-9)
    start = np.array([arrow["pose"]["position"][k] for k in "xyz"])
    tip = start + along * (arrow["shaft_length"] + arrow["head_length"])
    np.testing.assert_allclose(tip, recording.p_WE_measured.values[-1], atol=1e-9)


@examples(100)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: max(map(abs, q)) > 0.1)
)
def test_quaternions_are_those_of_scipy(q: list[float]) -> None:
    R = Rotation.from_quat(q).as_matrix()
    found = scene.quaternions(R[None])[0]
    assert abs(found @ Rotation.from_quat(q).as_quat()) == pytest.approx(1.0, abs=1e-12)


def test_pictures_are_due_once_each_whatever_the_pieces() -> None:
    times = np.round(np.arange(0.0, 1.0005, 0.001), 9)
    whole, _ = scene.pictured(times, -1.0)
    np.testing.assert_allclose(times[whole], 0.02 * np.arange(51), atol=1e-12)
    before, parts = -1.0, []
    for start in range(0, times.size, 33):
        rows, before = scene.pictured(times[start : start + 33], before)
        parts += (rows + start).tolist()
    assert parts == whole.tolist()


@needs_rerun
@pytest.mark.parametrize("name", ["press", "bilateral", "joint_sine"])
def test_a_rerun_recording_is_whole_and_has_what_is_drawn(
    recording: xr.Dataset, tmp_path: Path, name: str
) -> None:
    if name != "press":
        recording = sd.simulate(sd.load_scenario(name), duration=0.1, engine="drake")
    path = sd.export(recording, tmp_path / "run.rrd")
    command = [sys.executable, "-m", "rerun_cli", "rrd"]
    subprocess.run([*command, "verify", str(path)], check=True, capture_output=True)
    said = subprocess.run(
        [*command, "stats", str(path)], check=True, capture_output=True, text=True
    ).stdout
    for entity in ("/world/tool", "/world/link_4", "/signals/q_measured/d1", "/curves/tool_error"):
        assert entity in said
    assert ("/signals/joystick_axes" in said) is (name == "press")
    assert ("/world/device" in said) is (name == "bilateral")
    assert "/world/force" in said


def test_a_trace_that_is_played_again_gives_the_same_run(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    first = sd.simulate(sd.load_scenario("teleoperation"), duration=2.0)
    sd.save_recording(first, tmp_path / "first.nc")
    assert main(["export", str(tmp_path / "first.nc"), "--to", "trace"]) == 0
    trace = tmp_path / "first.trace.csv"
    again = ["run", "teleoperation", "--no-realtime", "--no-meshcat", "--duration", "2"]
    again += ["--set", f"operator.trace={trace}", "--record", str(tmp_path / "again.nc")]
    assert main(again) == 0
    comparison = sd.compare(tmp_path / "first.nc", tmp_path / "again.nc")
    assert comparison.equal
    assert np.ptp(first.joystick_axes.values, axis=0).max() > 0.1
    assert set(comparison.scenario.index) == {"operator.trace", "device"}


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mcap"])
def test_a_long_recording_needs_no_more_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    """Four times the length grows the peak by less than half of the numbers that come to it."""
    peaks = []
    monkeypatch.setattr(tables.pieces, "__defaults__", (256,))
    monkeypatch.setattr(parquet_file, "ROWS", 256)
    monkeypatch.setattr(mcap_file, "CHUNK", 1 << 14)
    for samples in (2_000, 2_000, 8_000):  # the first time, modules are imported
        long = xr.Dataset(
            {"x": (("time", "entry"), np.ones((samples, 8)), {"units": "m"})},
            coords={"time": 1e-3 * np.arange(samples), "entry": list("abcdefgh")},
        )
        sd.save_recording(long, tmp_path / "long.nc")
        tracemalloc.start()
        sd.export(tmp_path / "long.nc", tmp_path / f"long{suffix}")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[2] - peaks[1] < 0.5 * 6_000 * long.x[0].nbytes


def test_what_is_bad_is_one_line_and_nothing_is_written(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    xr.Dataset({"x": 1.0}).to_netcdf(tmp_path / "other.nc", engine="netcdf4")
    bilateral = sd.simulate(sd.load_scenario("bilateral"), duration=0.05, engine="drake")
    sd.save_recording(bilateral, tmp_path / "bilateral.nc")
    damaged = tmp_path / "damaged.nc"
    damaged.write_bytes(file.read_bytes()[:-200])
    before = sorted(tmp_path.iterdir())
    out = str(tmp_path / "out")
    for arguments, said in (
        (["no.nc"], "allowed a file that exists"),
        ([str(file), "--to", "hdf"], "to: 'hdf', allowed csv, parquet, mcap, rerun, trace"),
        (
            [str(file), "-o", out + ".xls"],
            "allowed a file that ends in .csv, .parquet, .mcap, .rrd",
        ),
        ([str(file), "--to", "mcap", "-o", out + ".csv"], "allowed a file that ends in .mcap"),
        ([str(file), "-o", str(file) + "/x/out.csv"], "allowed a file in a folder"),
        ([str(tmp_path / "other.nc"), "-o", out + ".csv"], "recording: no time"),
        ([str(damaged), "-o", out + ".csv"], "recording: "),
        ([str(tmp_path / "bilateral.nc"), "--to", "trace", "-o", out + ".csv"], "no joystick_axes"),
    ):
        assert main(["export", *arguments]) == 2, arguments
        err = capsys.readouterr().err
        assert said in err
        assert err.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_what_is_missing_is_named_with_what_installs_it(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    for to, package, extra in (
        ("parquet", "pyarrow.parquet", "export"),
        ("mcap", "mcap.writer", "export"),
        ("rerun", "rerun.blueprint", "rerun"),
    ):
        monkeypatch.setitem(sys.modules, package, None)
        monkeypatch.delitem(sys.modules, f"scara_drake.exports.{FORMATS[to].module}", raising=False)
        out = tmp_path / f"out{FORMATS[to].suffix}"
        assert main(["export", str(file), "--to", to, "-o", str(out)]) == 2
        err = capsys.readouterr().err
        assert f"pip install 'scara-drake[{extra}]'" in err
        assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_failure_leaves_what_was_there(
    recording: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pandas.DataFrame.to_csv", lambda *_, **__: (_ for _ in ()).throw(OSError))
    old = tmp_path / "out.csv"
    old.write_text("old")
    with pytest.raises(OSError):  # noqa: PT011 - of which nothing is said
        sd.export(recording, old)
    assert old.read_text() == "old"
    assert list(tmp_path.iterdir()) == [old]


def test_the_help_names_every_format(capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        make_parser().parse_args(["export", "-h"])
    said = capsys.readouterr().out
    for name, each in FORMATS.items():
        assert name in said
        assert each.what in said

"""Recordings beside each other: what is the same, what is not, and what cannot be compared."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

import scara_drake as sd
from scara_drake import metrics
from scara_drake.cli.main import main
from scara_drake.comparison.differences import differences
from scara_drake.comparison.plots import thinned
from scara_drake.comparison.report import change_of
from scara_drake.joints import JOINT_NAMES


def run(name: str, duration: float = 0.3, **fields: object) -> xr.Dataset:
    settings = {key.replace("__", "."): value for key, value in fields.items()}
    return sd.simulate(sd.load_scenario(name, settings), duration=duration, engine="drake")


@pytest.fixture(scope="module")
def one() -> xr.Dataset:
    return run("teleoperation")


@pytest.fixture(scope="module")
def sine() -> xr.Dataset:
    return run("joint_sine")


def by_name(one: xr.Dataset, other: xr.Dataset) -> dict:
    return {difference.name: difference for difference in differences(one, other)}


def test_a_run_again_is_equal_to_the_bit(one: xr.Dataset) -> None:
    comparison = sd.compare(one, run("teleoperation"))
    assert comparison.equal
    assert len(comparison.scenario) == 0
    assert "Equal to the bit: all variables at all times." in str(comparison)
    figures = comparison.figures
    np.testing.assert_array_equal(figures["A"], figures["B"])
    error = 1e3 * float(metrics.rmse(metrics.tool_error(one)))
    assert figures.loc["tool from its reference, RMS", "A"] == pytest.approx(error, rel=1e-12)
    assert figures.loc["tool from its reference, RMS", "unit"] == "mm"


def test_the_figures_are_those_of_the_samples(one: xr.Dataset) -> None:
    figures = sd.compare(one, one).figures["A"]
    for index, joint in enumerate(JOINT_NAMES):
        error = 1e3 * (one.q_desired.values - one.q_measured.values)[:, index]
        assert figures[f"{joint} error, RMS"] == pytest.approx(np.sqrt(np.mean(error**2)))
        assert figures[f"{joint} error, largest"] == np.abs(error).max()
        effort = one.tau_applied.values[:, index]
        assert figures[f"{joint} effort, RMS"] == pytest.approx(np.sqrt(np.mean(effort**2)))
        steps = np.abs(np.diff(effort)).sum() / 0.3
        assert figures[f"{joint} effort, variation"] == pytest.approx(steps)
    sent = 1e3 * np.linalg.norm(one.p_WE_commanded.values - one.p_WE_measured.values, axis=1)
    assert figures["tool from the command as sent, largest"] == pytest.approx(sent.max())
    assert figures["age of what came down, mean"] == pytest.approx(50.0)
    assert figures["received command followed"] == 100.0


@examples(50)
@given(
    index=st.integers(0, 300),
    joint=st.sampled_from(JOINT_NAMES),
    name=st.sampled_from(["q_measured", "v_measured", "tau_applied"]),
    factor=st.floats(1e-12, 1e3),
)
def test_one_changed_number_is_found_where_it_is(
    one: xr.Dataset, index: int, joint: str, name: str, factor: float
) -> None:
    """The oracle is the change itself: its place, its size, and the size of its neighbours."""
    column = JOINT_NAMES.index(joint)
    values = one[name].values.copy()
    values[index, column] += factor * (1.0 + abs(values[index, column]))
    changed = one.assign({name: one[name].copy(data=values)})
    found = by_name(one, changed)
    difference = found.pop(name)
    assert all(each.equal for each in found.values())
    assert not difference.equal
    time = float(one.time[index])
    assert difference.first == time
    assert difference.where == f"{joint} at {time:.6g} s"
    apart = abs(values[index, column] - float(one[name][index, column]))
    assert difference.largest == apart
    same_unit = [0] if joint == "d1" else list(range(1, 6))
    scale = max(np.abs(each[:, same_unit]).max() for each in (values, one[name].values))
    assert difference.relative == pytest.approx(apart / scale, rel=1e-12)


def test_nothing_is_as_good_as_nothing_but_not_as_a_number(one: xr.Dataset) -> None:
    values = one.f_haptic.values.copy()
    values[3, 1] = np.nan
    gap = one.assign(f_haptic=one.f_haptic.copy(data=values))
    assert by_name(gap, gap.copy(deep=True))["f_haptic"].equal
    difference = by_name(one, gap)["f_haptic"]
    assert (difference.largest, difference.where) == (np.inf, "y at 0.003 s")
    zero = one.assign(f_haptic=-0.0 * one.f_haptic)
    assert not by_name(one, zero)["f_haptic"].equal  # a bit is a bit
    assert by_name(one, zero)["f_haptic"].largest == 0.0


def test_a_shorter_and_a_coarser_recording_are_compared_where_both_have_samples(
    one: xr.Dataset,
) -> None:
    part = one.isel(time=slice(20, 200, 7))
    found = by_name(one, part)
    assert all(difference.equal for difference in found.values())
    comparison = sd.compare(one, part, names=("whole", "part"))
    assert not comparison.equal
    said = str(comparison)
    assert "not of one length: whole 0.3 s, part 0.195 s; the figures end at 0.195 s" in said
    assert "not of one period: whole 0.001 s, part 0.007 s" in said
    assert "all 20 variables equal to the bit at the times that both have" in said
    assert (comparison.start, comparison.end) == (0.02, 0.195)


def test_times_that_never_meet_are_told(one: xr.Dataset) -> None:
    off = one.assign_coords(time=one.time + 5e-4)
    assert {each.remark for each in differences(one, off)} == {"no times in common"}
    assert not any(each.equal for each in differences(one, off))
    with pytest.raises(ValueError, match="no time in common"):
        sd.compare(one, one.assign_coords(time=one.time + 9.0))


def test_recordings_of_other_scenarios_say_what_they_do_not_have(
    one: xr.Dataset, sine: xr.Dataset
) -> None:
    bilateral = run("bilateral")
    comparison = sd.compare(one, sine, bilateral)
    figures = comparison.figures
    assert np.isnan(figures.loc["contact force, largest", "B"])
    assert np.isnan(figures.loc["force of the device, RMS", ["A", "B"]].astype(float)).all()
    assert figures.loc["age of what came up, mean", "C"] == 100.0
    found = {each.name: each for each in comparison.variables["C"]}
    assert found["x_master"].remark == "only in the second"
    assert found["joystick_axes"].remark == "only in the first"
    assert "status" in {each.name for each in comparison.variables["C"]}
    assert any(remark.startswith("B does not have delay_down") for remark in comparison.remarks)
    assert "not the same surfaces: A wall; B none; C wall" in comparison.remarks
    # Of another kind of part the kind is told, not its fields.
    assert list(comparison.scenario.loc["operator"]) == ["!Joystick", "!JointMotion", "!Master"]
    assert not any(str(name).startswith("operator.") for name in comparison.scenario.index)


def test_the_field_that_was_changed_is_named(one: xr.Dataset) -> None:
    comparison = sd.compare(one, run("teleoperation", controller__phi=0.5), names=("one", "half"))
    assert list(comparison.scenario.index) == ["controller.phi"]
    assert list(comparison.scenario.loc["controller.phi"])[1] == "[0.5, 0.5, 0.5, 0.5, 0.5, 0.5]"
    first = {each.name: each for each in comparison.variables["half"]}["tau_applied"]
    assert first.first == 0.001


def test_other_joints_and_surfaces_are_compared_by_their_names(one: xr.Dataset) -> None:
    few = one.sel(joint=["theta4", "theta2"]).assign_coords(surface=["door"])
    found = by_name(one, few)
    assert found["q_measured"].largest == 0.0
    assert not found["q_measured"].equal
    assert found["q_measured"].remark == "d1, theta3, theta5, theta6 only in the first"
    assert found["penetration"].remark == "wall only in the first; door only in the second"
    comparison = sd.compare(one, few)
    assert comparison.verdicts["B"] == "none: not all joints are there"
    assert np.isnan(comparison.figures.loc["d1 error, RMS", "B"])
    both = comparison.figures.loc["theta4 error, RMS", ["A", "B"]]
    assert both["A"] == both["B"]
    other = one.assign(delay_up=one.delay_up.assign_attrs(units="ms"))
    assert by_name(one, other)["delay_up"].remark == "not the same kind: s and ms"


def test_a_recording_of_little_is_compared_and_not_judged(one: xr.Dataset, tmp_path: Path) -> None:
    little = one[["q_measured", "q_desired"]].drop_attrs()
    comparison = sd.compare(one, little)
    assert comparison.verdicts["B"].startswith("none: there is no v_measured")
    comparison.save_html(tmp_path / "page.html")
    assert "tool position: not in B" in (tmp_path / "page.html").read_text()


def test_the_command_prints_and_writes_a_page(
    one: xr.Dataset, sine: xr.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    for name, recording in (("<one>", one), ("sine", sine.assign_attrs(device="<b>pad</b>"))):
        sd.save_recording(recording, tmp_path / f"{name}.nc")
    files = [str(tmp_path / "<one>.nc"), str(tmp_path / "sine.nc")]
    page = tmp_path / "new" / "page.html"
    assert main(["compare", *files, "--html", str(page)]) == 0
    said = capsys.readouterr().out
    assert "Verdict on sine: " in said
    assert f"Page: {page}" in said
    text = page.read_text()
    assert "<one>" not in text
    assert "&lt;one&gt;" in text
    assert "<b>pad" not in text
    assert "&lt;b&gt;pad" in text
    assert text.count("data:image/png;base64,") == 9
    assert "http" not in text.replace("https://www.w3.org", "")  # nothing from the network
    assert [each.name for each in page.parent.iterdir()] == ["page.html"]


def test_bad_input_is_one_line(
    one: xr.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    good, bad = tmp_path / "good.nc", tmp_path / "bad.nc"
    sd.save_recording(one, good)
    bad.write_bytes(good.read_bytes()[:-100])
    xr.Dataset({"x": 1.0}).to_netcdf(tmp_path / "other.nc", engine="netcdf4")
    for arguments, said in (
        ([str(good)], "recordings: 1, allowed 2 to 10"),
        ([str(good)] * 11, "recordings: 11, allowed 2 to 10"),
        ([str(good), str(tmp_path / "no.nc")], "allowed a file that exists"),
        ([str(good), str(bad)], "recording: "),
        ([str(good), str(tmp_path / "other.nc")], "'other', allowed one with samples"),
        ([str(good), str(good), "--html", str(tmp_path / "page.txt")], "--html: "),
    ):
        assert main(["compare", *arguments]) == 2
        err = capsys.readouterr().err
        assert said in err
        assert err.count("\n") == 1
    assert sorted(each.name for each in tmp_path.iterdir()) == ["bad.nc", "good.nc", "other.nc"]
    assert main(["compare", str(good), str(good)]) == 0
    assert "Equal to the bit" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("first", "value", "said"),
    [
        (2.0, 3.0, "+50.0 %"),
        (2.0, 1.0, "-50.0 %"),
        (2.0, 2.0, "="),
        (2.0, 2.0002, "~"),
        (2.0, 40.0, "x 20"),
        (0.0, 1.0, "not 0"),
        (-1.0, 1.0, "x -1"),
        (np.nan, 1.0, ""),
    ],
)
def test_a_change_is_told_in_few_words(first: float, value: float, said: str) -> None:
    assert change_of(first, value) == said


@examples(50)
@given(st.integers(1, 5000), st.integers(0, 2**32 - 1), st.integers(20, 400))
def test_a_curve_that_is_thinned_keeps_its_extremes(size: int, seed: int, most: int) -> None:
    times, values = np.arange(size) / 1e3, np.random.default_rng(seed).normal(size=size)
    x, y = thinned(times, values, most)
    assert len(x) <= most + 2
    assert (np.diff(x) > 0.0).all()
    assert {values.min(), values.max()} <= set(y)
    np.testing.assert_array_equal(y, values[np.searchsorted(times, x)])

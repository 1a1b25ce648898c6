"""Damage to a journal or a recording is noticed, or does no harm."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from journalled import journalled
from strategies import examples
from strategies.files import DAMAGES, FLIPS, Cut, Flip, Splice

from scara_drake import load_recording, load_scenario, save_recording
from scara_drake.recordings.files import save_journal
from scara_drake.recordings.journal import Journal, read_journal
from scara_drake.replay.recording import load as load_for_replay


def journal_of(path: Path, seed: int) -> bytes:
    rng = np.random.default_rng(seed)
    with Journal(path) as journal:
        journal.begin({"seed": seed}, 3)
        for block in range(4):
            journal.append(np.arange(5.0) + 5 * block, rng.normal(size=(5, 3)))
        journal.end("duration", 20.0)
    return path.read_bytes()


@pytest.fixture(scope="module")
def journals(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes, bytes]:
    folder = tmp_path_factory.mktemp("journals")
    first, second = (journal_of(folder / f"{seed}.journal", seed) for seed in (0, 1))
    return folder / "damaged.journal", first, second


def check_one_line(error: ValueError) -> None:
    assert "\n" not in str(error)


@given(DAMAGES)
@examples(300)
def test_of_a_damaged_journal_the_blocks_before_the_damage_are_read(
    journals: tuple[Path, bytes, bytes], damage: Flip | Cut | Splice
) -> None:
    path, first, second = journals
    expected = {}
    for whole in (first, second):
        path.write_bytes(whole)
        contents, _, values = read_journal(path)
        assert (contents.samples, contents.lost, contents.ended_by) == (20, 0, "duration")
        expected[contents.description["seed"]] = values
    broken = damage.of(first, second)
    path.write_bytes(broken)
    try:
        contents, times, values = read_journal(path)
    except ValueError as error:
        check_one_line(error)
        return
    # Nothing is read that was not written, in the order in which it was written.
    written = expected[contents.description["seed"]]
    np.testing.assert_array_equal(times, np.arange(contents.samples))
    np.testing.assert_array_equal(values, written[: contents.samples])
    if broken not in (first, second):
        assert contents.lost > 0 or contents.ended_by == "cut off"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The journal and the recording of a run."""
    folder = tmp_path_factory.mktemp("files")
    journal, record = folder / "run.journal", folder / "run.nc"
    journalled(load_scenario("teleoperation", {"duration": 0.3}), journal, "drake")
    save_journal(journal, record)
    return journal, record


def never_wrong(
    path: Path, load: Callable[[Path], xr.Dataset], whole: xr.Dataset, variables: list[str]
) -> None:
    """What is read is what was written, or nothing and one line."""
    try:
        found = load(path)
    except ValueError as error:
        check_one_line(error)
        return
    count = found.sizes["time"]
    for name in variables:
        expected = whole[name][:count] if "time" in whole[name].dims else whole[name]
        np.testing.assert_array_equal(found[name], expected)
    if count == whole.sizes["time"]:
        known = {name: value for name, value in whole.attrs.items() if name != "ended_by"}
        assert {name: found.attrs[name] for name in known} == known
    else:
        assert found.attrs["ended_by"] != "duration"


@given(FLIPS)
@examples(50)
def test_a_flipped_byte_of_a_recording_is_noticed_or_does_no_harm(
    files: tuple[Path, Path], flip: Flip
) -> None:
    record = files[1]
    whole, path = load_recording(record), record.with_name("flipped.nc")
    path.write_bytes(flip.of(record.read_bytes(), b""))
    never_wrong(path, load_recording, whole, list(map(str, whole.variables)))
    shown = ["q_measured", "q_desired", "p_WE_desired", "f_env_on_tool_W", "time"]
    never_wrong(path, lambda file: load_for_replay(file)[0], whole, shown)


@given(FLIPS)
@examples(50)
def test_a_flipped_byte_of_a_journal_is_noticed_or_does_no_harm(
    files: tuple[Path, Path], flip: Flip
) -> None:
    journal = files[0]
    whole, path = load_recording(journal), journal.with_name("flipped.journal")
    path.write_bytes(flip.of(journal.read_bytes(), b""))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        never_wrong(path, load_recording, whole, list(map(str, whole.variables)))
        assert all("bytes lost" in str(warning.message) for warning in said)


def test_the_loss_is_said(files: tuple[Path, Path], tmp_path: Path) -> None:
    whole = files[0].read_bytes()
    path = tmp_path / "run.journal"
    path.write_bytes(whole[:-30_000] + b"?" + whole[-29_999:])
    with pytest.warns(UserWarning, match=r"damaged after \d+ samples; \d+ bytes lost"):
        found = load_recording(path)
    assert 0 < found.sizes["time"] < 301
    assert found.attrs["ended_by"].startswith("damage: ")
    assert found.attrs["ended_at"] == found.time[-1]


@pytest.mark.parametrize(
    "change",
    [
        {"time": lambda data: data.time * 1e18},
        {"time": lambda data: data.time * np.nan},
        {"time": lambda data: -data.time},
    ],
)
def test_times_that_no_run_has_are_not_played(
    files: tuple[Path, Path], tmp_path: Path, change: dict[str, Callable[[xr.Dataset], xr.Dataset]]
) -> None:
    data = load_recording(files[1])
    save_recording(data.assign_coords(time=change["time"](data).values), tmp_path / "x.nc")
    with pytest.raises(ValueError, match="allowed NetCDF written by a run"):
        load_for_replay(tmp_path / "x.nc")


@pytest.mark.parametrize("surfaces", ["a text", "[a text]", "{a: b}", "7", "[{point: a}]", "[[1]]"])
def test_surfaces_that_are_none_are_not_played(
    files: tuple[Path, Path], tmp_path: Path, surfaces: str
) -> None:
    text = f"environment: {{surfaces: {surfaces}}}"
    save_recording(load_recording(files[1]).assign_attrs(scenario=text), tmp_path / "x.nc")
    with pytest.raises(ValueError, match="allowed NetCDF written by a run"):
        load_for_replay(tmp_path / "x.nc")

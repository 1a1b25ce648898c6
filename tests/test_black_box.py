"""The last seconds before each fault are kept at the full rate, and nothing else changes."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

import scara_drake as sd
from scara_drake.recordings.black_box import LENGTH, MOST, BlackBox
from scara_drake.recordings.files import save_journal
from scara_drake.safety import MEANINGS, Reason, State

WIDTH, FAULTS = 28, 27  # the joints, then a status


class Kept:
    """A keeper that remembers."""

    path: Path | None = None
    has_samples = True

    def begin(self, description, width):
        self.times, self.values, self.ended = [], [], None

    def append(self, times, values):
        self.times += times.tolist()
        self.values += values.tolist()

    def end(self, by, at, notes=None):
        self.ended = by, at, notes


DESCRIPTION = {
    "columns": {"state": [0, 12], "state_desired": [12, 24], "robot_status": [24, 28]},
    "periods": dict.fromkeys(("state", "state_desired", "robot_status"), 1e-3),
    "surfaces": [], "duration": 1e9, "scenario": "", "scenario_name": "x", "seed": 0,
    "versions": {}, "notes": {},
}  # fmt: skip


def run(seconds, faults, period=0.01, block=100, path=None):
    """A run at 1 kHz whose count of faults grows at some times [s]."""
    kept = Kept()
    kept.path = path
    box = BlackBox(kept, period)
    box.begin(DESCRIPTION, WIDTH)
    times = np.arange(int(seconds * 1000), dtype=np.float64) * 1e-3
    values = np.zeros((times.size, WIDTH))
    values[:, 0] = times
    for at in faults:
        values[times >= at - 1e-9, FAULTS] += 1.0
        values[times >= at - 1e-9, 24:26] = State.FAULT, Reason.OVER_FORCE
    for first in range(0, times.size, block):
        box.append(times[first : first + block], values[first : first + block])
    box.end("duration", seconds, {"late": "none"})
    return kept, box


@examples(25)
@given(st.sampled_from([0.001, 0.002, 0.007, 0.01, 0.1 / 3]), st.integers(1, 300))
def test_the_recording_has_the_samples_that_it_asked_for(period, block):
    kept, box = run(1.0, [], period, block)
    expected = np.ceil(np.arange(0.0, 1.0, period) * 1000 - 1e-6) * 1e-3
    np.testing.assert_allclose(kept.times, expected[expected < 1.0 - 1e-9], atol=1e-12)
    assert box.boxes == []
    assert kept.ended == ("duration", 1.0, {"late": "none"})


@pytest.mark.parametrize("at", [0.5, 12.3])
def test_a_box_has_all_ticks_up_to_the_fault(at):
    _, box = run(14.0, [at])
    (found,) = box.boxes
    assert found.time.values[-1] == pytest.approx(at)
    assert found.sizes["time"] == min(int(LENGTH * 1000), round(at * 1000) + 1)
    np.testing.assert_allclose(np.diff(found.time.values), 1e-3)
    assert found.attrs["ended_by"] == "a fault"


def test_a_cascade_is_one_fault_and_there_are_so_many_at_most():
    _, box = run(40.0, [1.0, 1.2, 1.9, *np.arange(5.0, 39.0, 2.0)])
    assert len(box.boxes) == MOST
    assert box.missed == 1 + 17 - MOST


def test_files_are_beside_the_recording_and_load(tmp_path):
    _, box = run(3.0, [1.0, 2.5])
    paths = box.write(tmp_path / "press.nc")
    assert [path.name for path in paths] == ["press.fault-1.nc", "press.fault-2.nc"]
    assert sd.load_recording(paths[1]).time.values[-1] == pytest.approx(2.5)


def test_a_box_is_on_the_disk_from_the_fault_on_and_the_recording_tells_of_it(tmp_path):
    kept, box = run(4.0, [1.0, 3.0], path=tmp_path / "press.journal")
    left = sorted(tmp_path.iterdir())
    assert [path.name for path in left] == ["press.fault-1.journal", "press.fault-2.journal"]
    # As after a crash, by what `scara-drake recover` does.
    save_journal(left[1], tmp_path / "left.nc")
    found = sd.load_recording(tmp_path / "left.nc")
    _, in_memory = run(4.0, [1.0, 3.0])
    xr.testing.assert_equal(found.load(), in_memory.boxes[1])
    assert box.boxes == [], "what is on the disk is not kept in memory too"
    told = json.loads(kept.ended[2]["faults"])
    assert [fault["time"] for fault in told] == [1.0, 3.0]
    assert {fault["says"] for fault in told} == {f"FAULT: {MEANINGS[Reason.OVER_FORCE].says}"}
    first, _ = box.write(tmp_path / "press.nc")
    xr.testing.assert_equal(sd.load_recording(first).load(), in_memory.boxes[0])
    assert not list(tmp_path.glob("*.journal"))

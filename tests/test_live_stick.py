"""What a live stick commands while it is untouched, lost, and back."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from strategies import examples

from scara_drake.operator.devices import Sample, ScriptedDevice
from scara_drake.operator.joystick import JoystickSource
from scara_drake.operator.live_stick import PICK_UP, REST_ZONE
from scara_drake.vectors import BUTTON_NAMES, OPERATOR_BUTTONS

PERIOD = 0.01
POSITIONS, RATES = slice(0, 3), slice(3, 5)
axis = st.one_of(st.sampled_from([-1.0, 0.0, 1.0]), st.floats(-1.0, 1.0))
sample = st.lists(axis, min_size=5, max_size=5)
# Rows of: whether the device is there, whether a button is down, its axes.
script = st.lists(st.tuples(st.booleans(), st.booleans(), sample), min_size=1, max_size=40)


class RowsDevice:
    """Does at the k-th read what row k of a script says; the last row for ever."""

    name = "Scripted Pad"

    def __init__(self, rows: list[tuple[bool, bool, list[float]]]) -> None:
        self.rows, self.reads = rows, 0

    def sample(self) -> Sample:
        self.reads += 1
        there, pressed, axes = self.rows[min(self.reads, len(self.rows)) - 1]
        buttons = OPERATOR_BUTTONS.pack(**dict.fromkeys(BUTTON_NAMES, 0.0) | {"hold": pressed})
        return Sample(there, 0.0, np.array(axes), buttons=buttons)

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        return False

    def close(self) -> None:
        pass


def play(rows: list[tuple[bool, bool, list[float]]]) -> tuple[np.ndarray, np.ndarray]:
    """Axes (n, 5) and device_connected (n,) after each read."""
    source = JoystickSource(RowsDevice(rows), PERIOD)
    simulator = Simulator(source)
    axes, connected = [], []
    for k in range(len(rows)):
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        context = simulator.get_context()
        axes.append(source.GetOutputPort("joystick_axes").Eval(context))
        connected.append(source.GetOutputPort("device_connected").Eval(context)[0])
    return np.array(axes), np.array(connected)


def rows(*values: float, there: bool = True, pressed: bool = False):
    return [(there, pressed, [value] * 5) for value in values]


@examples(100)
@given(script=script)
def test_a_lost_device_holds_positions_and_stops_rates(script) -> None:
    axes, connected = play(script)
    np.testing.assert_array_equal(connected, [row[0] for row in script])
    before = np.vstack([np.zeros(5), axes[:-1]])
    lost = connected == 0.0
    np.testing.assert_array_equal(axes[lost, POSITIONS], before[lost, POSITIONS])
    np.testing.assert_array_equal(axes[lost, RATES], 0.0)


@examples(100)
@given(script=script)
def test_an_axis_moves_only_to_where_the_stick_is(script) -> None:
    """And from a loss, or the start, on it stays until the stick is there or passes, or a press."""
    axes, _ = play(script)
    for i in range(5):
        held, counting, side, ever, button = 0.0, False, 0.0, False, False
        for (there, pressed, stick), value in zip(script, axes[:, i], strict=True):
            if not there:
                counting, side, button = False, 0.0, True
                held = 0.0 if i >= 3 else held
                assert value == held
                continue
            away = stick[i] - held
            zone = REST_ZONE if held == 0.0 else PICK_UP
            reached = abs(away) <= zone or away * side < 0.0
            counting = counting or reached or (ever and pressed and not button)
            ever, button, side = ever or counting, pressed, np.sign(away)
            held = stick[i] if counting else held
            assert value == held


@pytest.mark.parametrize("rest", [-1.0, -0.5, 0.5, 1.0])
def test_a_trigger_at_rest_commands_nothing_until_it_has_been_near_the_middle(rest: float) -> None:
    axes, _ = play([*rows(rest, rest, rest), *rows(rest, pressed=True), *rows(0.4 * rest, rest)])
    np.testing.assert_array_equal(axes, 0.0)
    axes, _ = play(rows(rest, 0.05, rest))
    np.testing.assert_array_equal(axes[:, 0], [0.0, 0.05, rest])
    axes, _ = play(rows(rest, -0.3 * rest))  # passed between two samples
    np.testing.assert_array_equal(axes[:, 0], [0.0, -0.3 * rest])


def test_back_it_waits_for_the_held_value_or_for_a_new_press() -> None:
    moved, lost = rows(0.0, 0.6), rows(0.0, there=False)
    axes, _ = play([*moved, *lost, *rows(0.0, 0.3, 0.59, 0.7)])
    np.testing.assert_array_equal(axes[2:, 0], [0.6, 0.6, 0.6, 0.59, 0.7])
    axes, _ = play([*moved, *lost, *rows(0.0), *rows(0.0, pressed=True)])
    np.testing.assert_array_equal(axes[2:, 0], [0.6, 0.6, 0.0])
    # A button that is down already when it comes back is no press.
    axes, _ = play([*moved, *lost, *rows(0.0, 0.0, pressed=True)])
    np.testing.assert_array_equal(axes[2:, 0], 0.6)


def test_it_is_said_once_a_loss_and_once_a_return(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "scara_drake"):
        play([*rows(0.0), *rows(0.0, 0.0, 0.0, there=False), *rows(0.0, 0.0)])
    said = [record.getMessage() for record in caplog.records]
    assert len(said) == 2
    assert said[0].startswith("Scripted Pad: unplugged")
    assert said[1].startswith("Scripted Pad: plugged in again")


def test_a_clone_goes_on_as_the_original() -> None:
    script = [*rows(0.0, 0.6), *rows(0.0, 0.0, there=False), *rows(0.2, 0.7, 0.1)]
    expected, _ = play(script)
    source = JoystickSource(RowsDevice(script), PERIOD)
    simulator = Simulator(source)
    simulator.AdvanceTo(3.5 * PERIOD)
    fork = Simulator(source, simulator.get_context().Clone())
    fork.AdvanceTo(6.5 * PERIOD)
    port = source.GetOutputPort("joystick_axes")
    np.testing.assert_array_equal(port.Eval(fork.get_context()), expected[-1])


# What goes to the supervisor beside the stick.

GOOD = Sample(
    True,
    0.0,
    np.full(5, 0.05),
    np.full(3, 0.05),
    np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    np.array([0.1, 0.0, 0.5, 1.0, 1.0]),
)


def spoilt(field: str, value: float) -> Sample:
    entries = np.array(getattr(GOOD, field))
    entries[-1] = value
    changed: Any = {field: entries}
    return GOOD._replace(**changed)


class Ports:
    """The block of a device that says one sample after another, and a clock that is set."""

    def __init__(self, samples: list[Sample]) -> None:
        said = iter(samples)
        self.source = JoystickSource(ScriptedDevice(lambda at: next(said), stamped=False), PERIOD)
        assert self.source.clock is not None
        self.clock = self.source.clock
        self.clock.now = lambda: 0.0
        self.simulator, self.ticks = Simulator(self.source), 0

    def tick(self) -> dict[str, np.ndarray]:
        self.simulator.AdvanceTo((self.ticks + 0.5) * PERIOD)
        self.ticks += 1
        names = [name for name in self.source.declaration.memory if name != "grip"]
        context = self.simulator.get_context()
        return {name: self.source.GetOutputPort(name).Eval(context).copy() for name in names}


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("axes", np.nan),
        ("axes", 1.06),
        ("axes", -np.inf),
        ("orientation", np.nan),
        ("orientation", -1.06),
        ("buttons", np.nan),
        ("settings", np.inf),
    ],
)
def test_bad_samples_are_dropped_and_counted_in_a_row(field: str, value: float) -> None:
    bad = spoilt(field, value)
    ports = Ports([GOOD, bad, bad, bad, GOOD, bad, GOOD._replace(connected=False), bad])
    rows = [ports.tick() for _ in range(8)]
    counts = [row["device_status"][3] for row in rows]
    assert counts == [0, 1, 2, 3, 0, 1, 0, 1]
    for row in rows[1:4]:
        for name, held in rows[0].items():
            if name != "device_status":
                np.testing.assert_array_equal(row[name], held)


def test_the_largest_axis_that_is_taken_is_clipped() -> None:
    ports = Ports([GOOD, spoilt("axes", 1.05)])
    ports.tick()
    row = ports.tick()
    assert row["joystick_axes"][4] == 1.0
    assert row["device_status"][3] == 0.0


def test_a_lost_device_turns_nothing_and_presses_nothing() -> None:
    ports = Ports([GOOD, GOOD._replace(connected=False)])
    assert ports.tick()["operator_buttons"][0] == 1.0
    row = ports.tick()
    assert row["device_status"][0] == row["device_connected"][0] == 0.0
    np.testing.assert_array_equal(row["operator_buttons"], 0.0)
    np.testing.assert_array_equal(row["orientation_axes"], 0.0)
    np.testing.assert_array_equal(row["joystick_axes"], [0.05, 0.05, 0.05, 0.0, 0.0])
    np.testing.assert_array_equal(row["live_settings"], GOOD.settings)


def test_age_is_that_of_the_stamp_and_lateness_that_of_the_pacing() -> None:
    ports = Ports([GOOD, GOOD, GOOD._replace(stamp=np.nan), GOOD._replace(stamp=9.0)])
    ports.clock.now = lambda: 0.25
    ports.clock.lateness = -0.125
    np.testing.assert_array_equal(ports.tick()["device_status"], [1.0, 0.25, -0.125, 0.0])
    ports.clock.now = lambda: 3.0
    assert ports.tick()["device_status"][1] == 3.0
    assert ports.tick()["device_status"][1] == 3.0  # a stamp that is no number tells nothing new
    assert ports.tick()["device_status"][1] == 0.0  # none is younger than now


@pytest.mark.parametrize("field", ["axes", "orientation", "buttons", "settings"])
def test_other_shapes_are_refused(field: str) -> None:
    changed: Any = {field: np.zeros(2)}
    ports = Ports([GOOD._replace(**changed)])
    with pytest.raises(ValueError, match=rf"Scripted device: {field} \(2,\), allowed"):
        ports.tick()

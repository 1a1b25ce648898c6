from __future__ import annotations

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from scara_drake.operator.devices import Sample
from scara_drake.operator.joystick import JoystickSource
from scara_drake.vectors import STICK_NAMES


class FakeDevice:
    name = "fake"

    def __init__(self, samples: list[list[float]]) -> None:
        self._samples = list(samples)
        self.reads = 0

    def sample(self) -> Sample:
        self.reads += 1
        axes = np.array(self._samples[min(self.reads, len(self._samples)) - 1])
        return Sample(True, 0.0, axes)

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        return False

    def close(self) -> None:
        pass


def trace(rows: int, start: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    axes = np.random.default_rng(1).uniform(-1, 1, (rows, 5))
    return start + np.arange(rows) / 100, axes


def log(source: JoystickSource, duration: float) -> tuple[np.ndarray, np.ndarray]:
    builder = DiagramBuilder()
    builder.AddSystem(source)
    # Half a period off, so that every sample is seen after its tick.
    sink = LogVectorOutput(source.GetOutputPort("joystick_axes"), builder, 0.005)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(duration)
    found = sink.FindLog(simulator.get_context())
    return found.sample_times(), found.data().T


def test_port_and_names() -> None:
    source = JoystickSource(trace(3))
    assert source.num_input_ports() == 0
    assert source.GetOutputPort("joystick_axes").size() == len(STICK_NAMES) == 5


def test_plays_every_row_of_a_long_trace_at_its_time() -> None:
    times, axes = trace(500)
    sample_times, data = log(JoystickSource((times, axes), 0.01), 4.996)
    between = np.arange(1, len(sample_times), 2)  # at 5, 15, 25 ... ms
    np.testing.assert_array_equal(data[between], axes[: between.size])


def test_zero_order_hold_between_rows_and_after_the_last() -> None:
    times, axes = np.array([0.0, 0.1]), np.array([[0.1] * 5, [0.2] * 5])
    sample_times, data = log(JoystickSource((times, axes), 0.01), 0.3)
    np.testing.assert_array_equal(data[sample_times <= 0.1 + 1e-9, 0], 0.1)
    np.testing.assert_array_equal(data[sample_times > 0.1 + 1e-9, 0], 0.2)


def test_first_row_before_its_time() -> None:
    times, axes = trace(5, start=1.0)
    source = JoystickSource((times, axes))
    context = source.CreateDefaultContext()
    port = source.GetOutputPort("joystick_axes")
    np.testing.assert_array_equal(port.Eval(context), axes[0])
    _, data = log(source, 0.1)
    np.testing.assert_array_equal(data, np.tile(axes[0], (len(data), 1)))


def test_device_starts_at_zero_is_read_once_a_period_and_only_in_events() -> None:
    device = FakeDevice([[0.1] * 5, [0.2] * 5, [0.3] * 5])
    source = JoystickSource(device, 0.01)
    simulator = Simulator(source)
    port = source.GetOutputPort("joystick_axes")
    for _ in range(5):
        np.testing.assert_array_equal(port.Eval(simulator.get_context()), np.zeros(5))
    assert device.reads == 0
    simulator.AdvanceTo(0.025)
    assert device.reads == 3
    np.testing.assert_array_equal(port.Eval(simulator.get_context()), [0.3] * 5)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_samples_that_are_not_finite_are_dropped(bad: float) -> None:
    good, spoilt = [0.1, 0.2, 0.3, 0.4, 1.0], [0.9, 0.9, bad, 0.9, 0.9]
    for source in (
        JoystickSource(FakeDevice([[0.0] * 5, good, spoilt])),
        JoystickSource((np.array([0.0, 0.01]), np.array([good, spoilt]))),
    ):
        _, data = log(source, 0.05)
        np.testing.assert_array_equal(data[-1], good)


def test_samples_beyond_one_are_clipped() -> None:
    source = JoystickSource((np.array([0.0]), np.array([[1.05, -1.05, 0, 0, 0]])))
    _, data = log(source, 0.02)
    np.testing.assert_array_equal(data[:, :2], np.tile([1.0, -1.0], (len(data), 1)))


def test_clone_and_second_run_give_equal_bits() -> None:
    source = JoystickSource(trace(100))
    first = Simulator(source)
    first.AdvanceTo(0.305)
    fork = Simulator(source, first.get_context().Clone())
    first.AdvanceTo(0.5)
    fork.AdvanceTo(0.5)
    again = Simulator(source)
    port = source.GetOutputPort("joystick_axes")
    np.testing.assert_array_equal(port.Eval(again.get_context()), trace(100)[1][0])
    again.AdvanceTo(0.5)
    values = [port.Eval(s.get_context()) for s in (first, fork, again)]
    np.testing.assert_array_equal(values[0], values[1])
    np.testing.assert_array_equal(values[0], values[2])


def test_the_caller_may_change_the_arrays_afterwards() -> None:
    times, axes = trace(3)
    source = JoystickSource((times, axes))
    wanted = axes[0].copy()
    axes[:] = 0.0
    _, data = log(source, 0.005)
    np.testing.assert_array_equal(data[-1], wanted)


@pytest.mark.parametrize(
    ("times", "axes"),
    [
        ([], np.zeros((0, 5))),
        ([0.0, 1.0], np.zeros((2, 4))),
        ([0.0], np.zeros((2, 5))),
        ([0.0, 0.0], np.zeros((2, 5))),
        ([0.0, np.nan], np.zeros((2, 5))),
    ],
)
def test_bad_traces_are_refused(times: list[float], axes: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"trace: .*allowed"):
        JoystickSource((times, axes))


def test_bad_period_and_bad_device_are_refused() -> None:
    with pytest.raises(ValueError, match="period: 0"):
        JoystickSource(trace(3), 0)
    with pytest.raises(ValueError, match=r"fake: axes \(4,\), allowed \(5,\)"):
        Simulator(JoystickSource(FakeDevice([[0.0] * 4]))).AdvanceTo(0.01)

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.common.value import Value
from pydrake.common.yaml import yaml_load_typed
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import DiscreteTimeDelay, LogVectorOutput, VectorLogSink

from scara_drake.channel.delays import ConstantDelay, SineDelay
from scara_drake.channel.laws import delay_at
from scara_drake.channel.links import Channel
from scara_drake.channel.signal_delay import SignalDelay
from scara_drake.common.fields import check

H = 1e-3
OMEGA = np.array([3.0, 5.0])
PHASE = np.array([0.3, 1.0])


def signal(t: float | np.ndarray) -> np.ndarray:
    """Two smooth signals, (..., 2), with |u''| at most 9 and 25."""
    return np.sin(np.multiply.outer(t, OMEGA) + PHASE)


class SignalSource(LeafSystem):
    """A smooth signal of time; not a symbol of the package, so that the oracle is independent."""

    def __init__(self) -> None:
        super().__init__()
        self.DeclareVectorOutputPort(
            "signal", 2, self._calc, prerequisites_of_calc={self.time_ticket()}
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(signal(context.get_time()))


def build(delay: Any, initial: Any = (0.0, 0.0), drake_steps: int | None = None) -> Diagram:
    """source -> uplink (and Drake's own delay), both logged at every tick."""
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source", SignalSource())
    uplink = builder.AddNamedSystem("uplink", SignalDelay(delay, initial, H))
    builder.Connect(source.get_output_port(), uplink.GetInputPort("signal_sent"))
    for name in ("signal_received", "delay"):
        LogVectorOutput(uplink.GetOutputPort(name), builder, H).set_name(name)
    if drake_steps is not None:
        drake = builder.AddSystem(DiscreteTimeDelay(H, drake_steps, 2))
        builder.Connect(source.get_output_port(), drake.get_input_port())
        LogVectorOutput(drake.get_output_port(), builder, H).set_name("drake")
    return builder.Build()


def logged(simulator: Simulator, name: str) -> tuple[np.ndarray, np.ndarray]:
    diagram = of_kind(Diagram, simulator.get_system())
    log = of_kind(VectorLogSink, diagram.GetSubsystemByName(name)).FindLog(simulator.get_context())
    return log.sample_times().copy(), log.data().T.copy()


def run(diagram: Diagram, duration: float) -> Simulator:
    simulator = Simulator(diagram)
    simulator.AdvanceTo(duration)
    return simulator


def test_ports_and_initial_outputs() -> None:
    system = SignalDelay(SineDelay(0.1, 0.05), [1.0, 2.0, 3.0])
    context = system.CreateDefaultContext()
    assert system.GetInputPort("signal_sent").size() == 3
    np.testing.assert_array_equal(system.GetOutputPort("signal_received").Eval(context), [1, 2, 3])
    assert system.GetOutputPort("delay").Eval(context) == pytest.approx([0.05])


def test_memory_is_sized_for_the_longest_delay_only() -> None:
    context = SignalDelay(SineDelay(0.2), np.zeros(8)).CreateDefaultContext()
    assert 8 * 201 <= context.num_total_states() <= 8 * 204


@pytest.mark.parametrize("steps", [0, 1, 7, 100, 300])
def test_constant_delay_equals_drake_s_sample_for_sample(steps: int) -> None:
    # Same count of ticks: Drake's block has the same tick of latency of its own.
    diagram = build(ConstantDelay(steps * 1e-3), drake_steps=steps)
    simulator = run(diagram, 0.8)
    _, own = logged(simulator, "signal_received")
    _, drake = logged(simulator, "drake")
    np.testing.assert_array_equal(own, drake)
    assert np.abs(own[-1]).min() > 0.01


def test_no_delay_is_one_tick() -> None:
    simulator = run(build(ConstantDelay(0.0), signal(0.0)), 0.5)
    times, received = logged(simulator, "signal_received")
    np.testing.assert_allclose(received[1:], signal(times[:-1]), atol=1e-15)


@pytest.mark.parametrize(
    "delay",
    [
        SineDelay(0.2),
        SineDelay(0.1, 0.1),
        SineDelay(0.05, 0.1, 17.0),
        SineDelay(0.1, phase=math.pi / 2),
        ConstantDelay(0.12345),
    ],
)
def test_varying_delay_is_within_the_error_of_linear_interpolation(delay: Any) -> None:
    simulator = run(build(delay, signal(0.0)), 6.0)
    times, received = logged(simulator, "signal_received")
    _, tau = logged(simulator, "delay")
    if isinstance(delay, SineDelay):
        angle = delay.frequency * times[:-1] + delay.phase
        wanted = delay.offset + delay.amplitude * np.sin(angle)
        np.testing.assert_allclose(tau[1:, 0], np.maximum(wanted, 0.0), atol=1e-15)
    sent_at = times[:-1] - tau[1:, 0]
    begun = sent_at >= 0.0
    error = np.abs(received[1:] - signal(sent_at))[begun]
    assert (error.max(axis=0) <= H**2 / 8 * OMEGA**2 + 1e-12).all()


def test_sine_delay_is_clamped_to_the_past() -> None:
    simulator = run(build(SineDelay(0.2), signal(0.0)), 6.0)
    times, tau = logged(simulator, "delay")
    assert tau.min() == 0.0
    assert tau.max() <= 0.2
    assert (tau[times > 3.15] == 0.0).mean() > 0.9  # sin t < 0 until 6.28 s


def test_initial_value_is_held_until_the_first_sample_arrives() -> None:
    simulator = run(build(ConstantDelay(0.05), [7.0, -7.0]), 0.1)
    times, received = logged(simulator, "signal_received")
    waiting = times < 0.0505  # 50 ticks of delay and its own
    np.testing.assert_array_equal(
        received[waiting], np.tile([7.0, -7.0], (int(np.count_nonzero(waiting)), 1))
    )
    np.testing.assert_allclose(received[~waiting][0], signal(0.0), atol=1e-15)


@pytest.mark.parametrize("delay", [ConstantDelay(0.1), SineDelay(0.1, 0.1, 4.0)])
def test_a_fork_is_exact_right_after_it(delay: Any) -> None:
    diagram = build(delay)
    simulator = run(diagram, 0.3005)
    port = diagram.GetSubsystemByName("uplink").GetOutputPort("signal_received")

    def values(fork: Simulator) -> np.ndarray:
        uplink = diagram.GetSubsystemByName("uplink")
        collected = []
        for tick in range(1, 151):
            fork.AdvanceTo(0.3005 + tick * H)
            collected.append(port.Eval(uplink.GetMyContextFromRoot(fork.get_context())))
        return np.array(collected)

    clone = simulator.get_context().Clone()
    straight = values(simulator)  # moves on before the fork is used
    np.testing.assert_array_equal(values(Simulator(diagram, clone)), straight)


def test_a_second_run_on_the_same_diagram_starts_clean() -> None:
    diagram = build(SineDelay(0.1, 0.1, 4.0), [5.0, 5.0])
    first = logged(run(diagram, 0.4), "signal_received")[1]
    second = logged(run(diagram, 0.4), "signal_received")[1]
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(second[0], [5.0, 5.0])


@settings(deadline=None)
@given(
    amplitude=st.floats(0, 2),
    offset=st.floats(-2, 2),
    frequency=st.floats(0, 10),
    phase=st.floats(-math.pi, math.pi),
    t=st.floats(0, 100),
)
def test_delay_stays_between_zero_and_its_maximum(
    amplitude: float, offset: float, frequency: float, phase: float, t: float
) -> None:
    delay = SineDelay(amplitude, offset, frequency, phase)
    value = delay_at(delay.parameters(), t)
    assert 0.0 <= value <= delay.maximum() + 1e-12
    assert value == pytest.approx(max(0.0, amplitude * math.sin(frequency * t + phase) + offset))


@pytest.mark.parametrize("t", [0.0, 0.5, 1.2, 5.0, 6.2])
def test_a_phase_of_a_quarter_turn_is_a_cosine(t: float) -> None:
    delay = SineDelay(0.1, phase=math.pi / 2)
    assert delay_at(delay.parameters(), t) == pytest.approx(max(0.1 * math.cos(t), 0.0))


def test_presets_of_the_paper() -> None:
    assert SineDelay().maximum() == 0.2
    assert SineDelay(1.0, 1.0).maximum() == 2.0
    assert ConstantDelay(0.3).maximum() == 0.3
    assert SineDelay(0.1, -0.5).maximum() == 0.0


def test_channel_reads_from_yaml_with_tags() -> None:
    text = "{up: !SineDelay {amplitude: 1.0, offset: 1.0}, down: !ConstantDelay {delay: 0.1}}"
    channel = yaml_load_typed(schema=Channel, data=text, defaults=Channel())
    assert channel == Channel(up=SineDelay(1.0, 1.0), down=ConstantDelay(0.1))
    check(channel, "channel")


@pytest.mark.parametrize(
    ("channel", "named"),
    [
        (
            Channel(up=SineDelay(2.0, 1.0)),
            r"channel\.up: a delay of up to 3 s, allowed 0 to 2\.5 s \(channel\.max_delay\)",
        ),
        (Channel(down=ConstantDelay(0.2), max_delay=0.1), r"channel\.down: .* 0 to 0\.1 s"),
        (Channel(down=ConstantDelay(-0.2)), r"channel\.down\.delay: -0\.2"),
        (Channel(up=ConstantDelay(math.nan)), r"channel\.up\.delay: nan"),
        (Channel(up=SineDelay(-0.1)), r"channel\.up\.amplitude: -0\.1"),
        (Channel(up=SineDelay(0.1, math.inf)), r"channel\.up\.offset: inf"),
        (Channel(up=SineDelay(0.1, 0.0, -1.0)), r"channel\.up\.frequency: -1"),
        (Channel(up=SineDelay(0.1, phase=7.0)), r"channel\.up\.phase: 7.0, allowed -6\.28"),
        (Channel(max_delay=math.inf), r"channel\.max_delay: inf"),
    ],
)
def test_bad_channels_are_named(channel: Channel, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        check(channel, "channel")


@pytest.mark.parametrize("initial", [[], [[0.0]], [math.nan]])
def test_bad_initial_signals_are_refused(initial: Any) -> None:
    with pytest.raises(ValueError, match="initial: "):
        SignalDelay(ConstantDelay(), initial)


def test_a_run_without_events_keeps_nothing_on_the_system() -> None:
    # Everything that changes is in the Context: there are no other mutable attributes.
    system = SignalDelay(ConstantDelay(0.01), [0.0])
    before = {key: repr(value) for key, value in vars(system).items()}
    context = system.CreateDefaultContext()
    system.GetInputPort("signal_sent").FixValue(context, Value(BasicVector(np.array([1.0]))))
    Simulator(system, context).AdvanceTo(0.1)
    assert {key: repr(value) for key, value in vars(system).items()} == before
    assert system.GetOutputPort("signal_received").Eval(context) == [1.0]

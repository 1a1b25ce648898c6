"""A long memory in an archive gives what the same memory at hand gives, and what a deque gives."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink
from strategies import examples

from scara_drake.channel import packets, signal_delay
from scara_drake.channel.delays import ConstantDelay, DelayLaw, SineDelay, StepDelay, TableDelay
from scara_drake.channel.impairments import Jitter, Loss
from scara_drake.channel.packets import PacketChannel, Packets
from scara_drake.channel.signal_delay import SHORT, SignalDelay, store_ticks
from scara_drake.common.block import Block

H = 1e-3
PORTS = ("signal_received", "delay", "age_of_information", "packet_counts", "playout")


class Source(LeafSystem):
    """Two signals of time that never repeat; not a symbol of the package."""

    def __init__(self) -> None:
        super().__init__()
        self.DeclareVectorOutputPort(
            "signal", 2, self._calc, prerequisites_of_calc={self.time_ticket()}
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        t = context.get_time()
        output.SetFromVector(np.array([t, math.sin(11.0 * t)]))


def two_ways(make: Callable[[], Block], every: int) -> tuple[Block, Block]:
    """The same link with an archive, stored once in `every` ticks, and without."""
    made = []
    for ticks in (every, 0):
        with pytest.MonkeyPatch.context() as patch:
            for module in (signal_delay, packets):
                patch.setattr(module, "store_ticks", lambda rows, size, ticks=ticks: ticks)
            made.append(make())
    return made[0], made[1]


def logged_beside(blocks: dict[str, Block], period: float = H) -> Diagram:
    """Blocks behind one source, every output of theirs logged."""
    builder = DiagramBuilder()
    source = builder.AddSystem(Source())
    for name, block in blocks.items():
        builder.AddNamedSystem(name, block)
        builder.Connect(source.get_output_port(), block.get_input_port())
        for port in PORTS:
            if block.HasOutputPort(port):
                log = LogVectorOutput(block.GetOutputPort(port), builder, period)
                log.set_name(f"{name} {port}")
    return builder.Build()


def logs(diagram: Diagram, simulator: Simulator, name: str) -> list[np.ndarray]:
    found = []
    for port in PORTS:
        if diagram.HasSubsystemNamed(f"{name} {port}"):
            sink = of_kind(VectorLogSink, diagram.GetSubsystemByName(f"{name} {port}"))
            found.append(sink.FindLog(simulator.get_context()).data().copy())
    return found


@st.composite
def links(draw: st.DrawFn) -> Callable[[], Block]:
    """Links of each kind and law; the delays of some jump."""
    longest = draw(st.floats(0.0, 0.15))
    times = sorted(draw(st.sets(st.floats(0.0, 0.3), min_size=1, max_size=5)))
    steps = [draw(st.floats(0.0, longest)) for _ in times]
    laws: list[DelayLaw] = [
        ConstantDelay(longest),
        ConstantDelay(math.floor(longest / H) * H),
        SineDelay(longest / 2, longest / 2, draw(st.floats(0.0, 60.0))),
        StepDelay(times, steps),
        TableDelay(times, steps),
    ]
    law = draw(st.sampled_from(laws))
    if draw(st.booleans()):
        return lambda: SignalDelay(law, [7.0, -7.0], H)
    spread = draw(st.floats(1e-4, 0.05))
    jitter = draw(st.sampled_from([Jitter(), Jitter("gamma", spread, spread)]))
    loss = draw(st.sampled_from([Loss(), Loss(0.2, 0.9, 0.1, 0.3)]))
    send_period = H * draw(st.integers(1, 4))
    link = Packets(law, jitter, loss, [0.1, 0.12], send_period, longest + spread)
    seed = draw(st.integers(0, 2**62 - 1))
    return lambda: PacketChannel(link, [7.0, -7.0], H, seed)


@examples(40)
@given(links(), st.integers(1, 60))
def test_an_archive_changes_no_bit(make: Callable[[], Block], every: int) -> None:
    """However seldom it is stored: most periods come a rounding before or after a tick."""
    divided, whole = two_ways(make, every)
    diagram = logged_beside({"divided": divided, "whole": whole})
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.32)
    pairs = zip(logs(diagram, simulator, "divided"), logs(diagram, simulator, "whole"), strict=True)
    for one, other in pairs:
        assert one.tobytes() == other.tobytes()


@examples(25)
@given(
    st.lists(st.floats(0.0, 0.1), min_size=1, max_size=8),
    st.integers(1, 40),
    st.sampled_from([H, 5e-4, 2e-3]),
)
def test_a_delay_that_jumps_reads_what_a_deque_has(
    delays: list[float], every: int, period: float
) -> None:
    law = StepDelay([0.03 * index for index in range(len(delays))], delays)
    divided, _ = two_ways(lambda: SignalDelay(law, [7.0, -7.0], period), every)
    diagram = logged_beside({"divided": divided}, period)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.25)
    received, shown = logs(diagram, simulator, "divided")
    history = deque([np.array([7.0, -7.0])] * 250, maxlen=250)
    for k in range(received.shape[1] - 1):
        history.append(np.array([k * period, math.sin(11.0 * k * period)]))
        age = shown[0, k + 1] / period
        whole = math.floor(age + 1e-9)
        late, early = history[-1 - whole], history[-2 - whole]
        wanted = late + (age - whole) * (early - late)
        np.testing.assert_allclose(received[:, k + 1], wanted, rtol=0.0, atol=1e-7)


LONG = {
    "constant": lambda: SignalDelay(ConstantDelay(2.2), [7.0, -7.0], H),
    "sine": lambda: SignalDelay(SineDelay(1.1, 1.1, 7.0), [7.0, -7.0], H),
    "packets": lambda: PacketChannel(
        Packets(SineDelay(0.4, 0.4, 7.0), Jitter("gamma", 0.1, 0.2), Loss(0.1)), [7.0, -7.0], H, 5
    ),
}


@pytest.mark.parametrize("name", LONG)
def test_a_clone_goes_on_and_a_second_run_starts_clean(name: str) -> None:
    block = LONG[name]()
    assert block.declaration.archive
    diagram = logged_beside({"link": block})
    ends = set()
    for _ in range(2):
        simulator = Simulator(diagram)
        simulator.AdvanceTo(1.7305)
        clone = Simulator(diagram, simulator.get_context().Clone())
        for one in (simulator, clone):
            one.AdvanceTo(2.6)
            received = logs(diagram, one, "link")[0]
            ends.add(received[:, -850:].tobytes())
            assert np.ptp(received[0]) > 0.1
    assert len(ends) == 1


def test_memory_at_hand_grows_with_the_root_of_the_length() -> None:
    for longest in (1.0, 4.0, 16.0):
        rows = round(longest / H) + 1
        link = Packets(ConstantDelay(longest), longest=longest)
        for block in (
            SignalDelay(ConstantDelay(longest), np.zeros(8)),
            PacketChannel(link, np.zeros(8)),
        ):
            context = block.CreateDefaultContext()
            state = context.get_discrete_state()
            at_hand = sum(state.value(group).size for group in range(state.num_groups()))
            assert at_hand <= 10 * 4 * math.sqrt(rows) + 60


@pytest.mark.parametrize("rows", [300, 2001, 60_001])
def test_a_store_falls_on_a_tick_to_the_bit(rows: int) -> None:
    ticks = store_ticks(rows, 8)
    for period in (1e-3, 5e-4, 7e-4):
        assert all(k * (ticks * period) == (k * ticks) * period for k in range(1, 5000))


def test_a_short_memory_has_no_archive() -> None:
    for block in (
        SignalDelay(ConstantDelay(0.2), np.zeros(8)),
        PacketChannel(Packets(longest=0.15), np.zeros(8)),
    ):
        assert not block.declaration.archive
        assert block.declaration.store is None
    assert store_ticks(SHORT // 8, 8) == 0

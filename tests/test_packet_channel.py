import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, VectorSystem
from pydrake.systems.primitives import LogVectorOutput
from scipy import stats

from scara_drake.channel.delays import ConstantDelay, SineDelay, StepDelay, TableDelay
from scara_drake.channel.impairments import Jitter, Loss, in_outage, is_lost, jitter_time
from scara_drake.channel.packets import PacketChannel, Packets
from scara_drake.channel.signal_delay import SignalDelay
from scara_drake.common.fields import check

H = 1e-3


class Count(VectorSystem):
    """The number of the tick."""

    def __init__(self):
        super().__init__(0, 1, False)

    def DoCalcVectorOutput(self, context, inputs, state, output):
        output[:] = round(context.get_time() / H)


class EveryThird(VectorSystem):
    """1 at every third tick, else 0."""

    def __init__(self):
        super().__init__(0, 1, False)

    def DoCalcVectorOutput(self, context, inputs, state, output):
        output[:] = round(context.get_time() / H) % 3 == 0


def run(system, steps):
    """Send the number of the tick; return received, delay and age after each tick."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    builder.Connect(builder.AddSystem(Count()).get_output_port(), system.get_input_port())
    logs = [
        LogVectorOutput(system.GetOutputPort(name), builder, H)
        for name in ("signal_received", "delay", "age_of_information")
    ]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((steps + 0.5) * H)
    return np.array([log.FindLog(simulator.get_context()).data()[0, 1:] for log in logs])


def test_ports():
    assert ports(PacketChannel(Packets(), [0.0, 0.0])) == (
        {"signal_sent": 2},
        {
            "signal_received": 2,
            "delay": 1,
            "age_of_information": 1,
            "packet_counts": 2,
        },
    )


@pytest.mark.parametrize("steps", [0, 1, 7, 100])
def test_a_constant_delay_equals_that_of_signal_delay(steps):
    law = ConstantDelay(steps * H)
    builder = DiagramBuilder()
    delay = builder.AddSystem(SignalDelay(law, [-1.0]))
    builder.Connect(builder.AddSystem(Count()).get_output_port(), delay.get_input_port())
    log = LogVectorOutput(delay.GetOutputPort("signal_received"), builder, H)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(300.5 * H)
    packets = run(PacketChannel(Packets(law, longest=0.2), [-1.0]), 300)[0]
    np.testing.assert_array_equal(log.FindLog(simulator.get_context()).data()[0, 1:], packets)


def test_out_of_order_arrivals_loss_and_outage_by_hand():
    # Packet:         0  1  2  3  4  5  6  7  8  9
    # delay in ticks: 2  6  3  1  1  1  4  1  1  8
    # arrives at:     2  7  5  4  -  - 10  8  9 17
    # Packets 4 and 5 are sent in an outage, [3.5, 5.5) ms.
    ticks = [2, 6, 3, 1, 1, 1, 4, 1, 1, 8]
    law = StepDelay([(i - 0.25) * H for i in range(10)], [d * H for d in ticks])
    link = Packets(law, outages=[3.5e-3, 5.5e-3], longest=8e-3)
    received, delay, age = run(PacketChannel(link, [-1.0]), 12)
    #       tick:     0   1  2  3  4  5  6  7  8  9 10 11
    by_hand = [-1, -1, 0, 0, 3, 3, 3, 3, 7, 8, 8, 8]
    np.testing.assert_array_equal(received[:12], by_hand)
    in_use = np.array([0, 0, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1]) * H
    np.testing.assert_allclose(delay, in_use, atol=1e-12)
    stamps = np.array([0, 0, 0, 0, 3, 3, 3, 3, 7, 8, 8, 8])
    np.testing.assert_allclose(age, (np.arange(12) - stamps) * H, atol=1e-12)


def test_a_packet_slower_than_the_longest_is_lost():
    link = Packets(ConstantDelay(4e-3), Jitter("uniform", 1e-3, 0.5e-3), longest=5e-3)
    received, _, _ = run(PacketChannel(link, [-1.0], seed=3), 400)
    travel = np.array(
        [4e-3 + jitter_time(link.jitter.parameters(), 3, packet) for packet in range(400)]
    )
    assert (travel > link.longest).any()
    assert not np.isin(np.flatnonzero(travel > link.longest), received).any()


@settings(deadline=None, max_examples=40)
@given(
    st.integers(0, 2**31),
    st.floats(0.0, 0.05),
    st.floats(1e-3, 0.02),
    st.floats(0.0, 0.5),
)
def test_the_received_signal_never_runs_backwards_nor_from_the_future(seed, delay, jitter, loss):
    link = Packets(
        ConstantDelay(delay), Jitter("gamma", jitter, jitter), Loss(in_good=loss), longest=0.3
    )
    received, _, age = run(PacketChannel(link, [-1.0], seed=seed), 400)
    assert (np.diff(received) >= 0).all()
    assert (received <= np.arange(400)).all()
    arrived = received >= 0
    np.testing.assert_allclose(age[arrived], (np.arange(400) - received)[arrived] * H, atol=1e-9)
    assert (age[arrived] >= delay - 1e-9).all()


@pytest.mark.parametrize(
    ("distribution", "law"),
    [
        ("uniform", stats.uniform(0.01 - np.sqrt(3) * 4e-3, 2 * np.sqrt(3) * 4e-3)),
        ("normal", stats.norm(0.01, 4e-3)),
        ("gamma", stats.gamma(6.25, scale=1.6e-3)),
        (
            "lognormal",
            stats.lognorm(np.sqrt(np.log(1.16)), scale=0.01 / np.sqrt(1.16)),
        ),
    ],
)
def test_jitter_of_1e5_packets_has_the_distribution_asked_for(distribution, law):
    jitter = Jitter(distribution, 0.01, 4e-3).parameters()
    times = np.array([jitter_time(jitter, 11, packet) for packet in range(100_000)])
    assert times.mean() == pytest.approx(0.01, rel=0.01)
    assert times.std() == pytest.approx(4e-3, rel=0.02)
    assert stats.kstest(times, law.cdf).pvalue > 0.01


def lost_packets(loss, n=100_000, seed=5):
    chances, is_bad = loss.parameters(), np.zeros(())
    lost, bad = np.empty(n, bool), np.empty(n, bool)
    for packet in range(n):
        lost[packet] = is_lost(chances, seed, packet, is_bad)
        bad[packet] = is_bad > 0.5
    return lost, bad


def test_independent_loss_of_1e5_packets():
    lost, _ = lost_packets(Loss(in_good=0.1))
    assert lost.mean() == pytest.approx(0.1, abs=4 * np.sqrt(0.09 / lost.size))
    assert abs(np.corrcoef(lost[1:], lost[:-1])[0, 1]) < 4 / np.sqrt(lost.size)


def test_bursts_of_gilbert_and_elliott_of_1e5_packets():
    # Stationary share of bad = to_bad / (to_bad + to_good), mean stay 1 / to_good.
    loss = Loss(in_good=0.01, in_bad=0.6, to_bad=0.02, to_good=0.2)
    lost, bad = lost_packets(loss)
    share = 0.02 / 0.22
    assert bad.mean() == pytest.approx(share, rel=0.1)
    edges = np.diff(bad.astype(int), prepend=0, append=0)
    stays = np.flatnonzero(edges < 0) - np.flatnonzero(edges > 0)
    assert stays.mean() == pytest.approx(5.0, rel=0.05)
    assert lost.mean() == pytest.approx(0.01 * (1 - share) + 0.6 * share, rel=0.05)


def test_outages_are_half_open():
    outages = np.array([0.1, 0.2, 0.5, 0.5, 0.7, 0.9])
    times = [0.0, 0.1, 0.15, 0.2, 0.5, 0.7, 0.899, 0.9]
    assert [in_outage(outages, t) for t in times] == [
        False, True, True, False, False, True, True, False,
    ]  # fmt: skip


def test_slow_sending_holds_between_packets():
    received, _, age = run(PacketChannel(Packets(send_period=5e-3), [-1.0]), 12)
    np.testing.assert_array_equal(received, [0] * 5 + [5] * 5 + [10] * 2)
    np.testing.assert_allclose(age, (np.arange(12) % 5) * H, atol=1e-12)


class Ramp(VectorSystem):
    def __init__(self):
        super().__init__(0, 1, False)

    def DoCalcVectorOutput(self, context, inputs, state, output):
        output[:] = context.get_time()


def test_clones_and_second_runs_give_the_same_bits():
    builder = DiagramBuilder()
    source = builder.AddSystem(Ramp())
    link = Packets(SineDelay(0.02, 0.02, 5.0), Jitter("gamma", 5e-3, 5e-3), Loss(0.1))
    channel = builder.AddSystem(PacketChannel(link, [0.0], seed=1))
    builder.Connect(source.get_output_port(), channel.get_input_port())
    log = LogVectorOutput(channel.GetOutputPort("signal_received"), builder, H)
    diagram = builder.Build()
    runs = []
    for _ in range(2):
        simulator = Simulator(diagram)
        simulator.AdvanceTo(0.3)
        clone = Simulator(diagram, simulator.get_context().Clone())
        for one in (simulator, clone):
            one.AdvanceTo(0.6)
            runs.append(log.FindLog(one.get_context()).data()[:, -250:].copy())
    for other in runs[1:]:
        np.testing.assert_array_equal(runs[0], other)


@pytest.mark.parametrize(
    ("link", "message"),
    [
        (Packets(ConstantDelay(-0.1)), r"^up\.delay\.delay: -0\.1, allowed 0 to 60$"),
        (Packets(ConstantDelay(float("inf"))), r"^up\.delay\.delay: inf"),
        (Packets(ConstantDelay(3.0)), r"^up\.delay: up to 3 s, allowed 0 to 2\.5 s"),
        (Packets(loss=Loss(in_good=1.5)), r"^up\.loss\.in_good: 1\.5, allowed 0 to 1$"),
        (Packets(loss=Loss(to_bad=-0.1)), r"^up\.loss\.to_bad: -0\.1, allowed 0 to 1$"),
        (Packets(jitter=Jitter("cauchy")), r"^up\.jitter\.distribution: 'cauchy', allowed none"),
        (Packets(jitter=Jitter("gamma")), r"^up\.jitter\.mean: 0\.0, allowed above 0"),
        (Packets(jitter=Jitter("uniform", 1e-3, 1e-3)), r"^up\.jitter\.std: 0\.001, allowed 0 to"),
        (Packets(outages=[1.0]), r"^up\.outages: \[1\.0\], allowed pairs"),
        (Packets(outages=[2.0, 1.0]), r"^up\.outages: .* rising order$"),
        (Packets(StepDelay([0.0, 1.0], [0.1])), r"^up\.delay\.delays: 1 entries, allowed 2$"),
        (Packets(TableDelay([1.0, 1.0], [0.1, 0.1])), r"^up\.delay\.times\[1\]: 1\.0, allowed"),
    ],
)
def test_bad_links_are_refused_by_field_and_range(link, message):
    with pytest.raises(ValueError, match=message):
        check(link, "up")


def test_a_send_period_between_ticks_is_refused():
    with pytest.raises(ValueError, match=r"send_period: 0\.0015 s, allowed a multiple of 0\.001 s"):
        PacketChannel(Packets(send_period=1.5e-3), [0.0])


def test_a_selective_channel_sends_what_it_is_asked_to():
    channel = PacketChannel(Packets(delay=ConstantDelay(2 * H)), [-1.0], selective=True)
    builder = DiagramBuilder()
    builder.AddSystem(channel)
    count = builder.AddSystem(Count())
    every_third = builder.AddSystem(EveryThird())
    builder.Connect(count.get_output_port(), channel.GetInputPort("signal_sent"))
    builder.Connect(every_third.get_output_port(), channel.GetInputPort("transmit"))
    logs = [
        LogVectorOutput(channel.GetOutputPort(name), builder, H)
        for name in ("signal_received", "delay", "age_of_information", "packet_counts")
    ]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(20.5 * H)
    received, delay, age, counts = (
        log.FindLog(simulator.get_context()).data()[0, 1:] for log in logs
    )
    # Ticks 0, 3, 6, ... are sent, arrive two ticks later, and stand until the next.
    ticks = np.arange(20)
    sent = np.where(ticks >= 2, 3 * ((ticks - 2) // 3), -1)
    np.testing.assert_array_equal(received, sent)
    np.testing.assert_allclose(delay[2:], 2 * H, atol=1e-12)
    np.testing.assert_allclose(age, (ticks - np.maximum(sent, 0)) * H, atol=1e-12)
    np.testing.assert_array_equal(counts, ticks // 3 + 1)

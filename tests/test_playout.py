"""A playout buffer, against a receiver written with dictionaries, and by its laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from strategies import examples
from test_long_channels import H, logged_beside, logs, two_ways

from scara_drake.channel.delays import ConstantDelay, SineDelay, StepDelay
from scara_drake.channel.impairments import Jitter, Loss, is_lost, jitter_time
from scara_drake.channel.packets import PacketChannel, Packets
from scara_drake.channel.playout import Playout
from scara_drake.common.fields import check

STEPS = 400


def played(link: Packets, seed: int = 0, steps: int = STEPS) -> dict[str, np.ndarray]:
    """What a link shows after each tick, of the number of the tick that is sent to it."""
    channel = PacketChannel(link, [-1.0, 0.0], H, seed)
    diagram = logged_beside({"link": channel})
    simulator = Simulator(diagram)
    simulator.AdvanceTo((steps + 0.5) * H)
    received, delay, age, counts, *playout = logs(diagram, simulator, "link")
    number = np.round(received[0, 1:] / H)
    number[received[0, 1:] == -1.0] = -1.0
    shown = {"number": number, "delay": delay[0, 1:], "age": age[0, 1:], "counts": counts[:, 1:]}
    return shown | ({"playout": playout[0][:, 1:]} if playout else {})


def arrivals(link: Packets, seed: int, steps: int = STEPS) -> dict[int, int]:
    """Tick of arrival of each packet that arrives, by the tick of its sending."""
    stride, is_bad, found = round(link.send_period / H), np.zeros(()), {}
    for packet, tick in enumerate(range(0, steps, stride)):
        lost = is_lost(link.loss.parameters(), seed, packet, is_bad)
        travel = link.delay.at(tick * H) + jitter_time(link.jitter.parameters(), seed, packet)
        if not lost and travel <= link.longest:
            found[tick] = math.ceil(round((tick * H + max(travel, 0.0)) / H, 6))
    return found


@st.composite
def jittery(draw: st.DrawFn) -> Packets:
    """Links with jitter, loss and a stride, without a buffer."""
    spread = draw(st.floats(5e-4, 0.02))
    return Packets(
        ConstantDelay(draw(st.floats(0.0, 0.03))),
        Jitter("gamma", spread, draw(st.sampled_from([0.3, 1.0])) * spread),
        Loss(draw(st.sampled_from([0.0, 0.1])), 0.9, draw(st.sampled_from([0.0, 0.05])), 0.2),
        send_period=H * draw(st.integers(1, 4)),
        longest=draw(st.sampled_from([0.06, 0.3])),
    )


@st.composite
def buffered(draw: st.DrawFn) -> Packets:
    """The same with a buffer of any kind."""
    link = draw(jittery())
    link.playout = Playout(
        draw(st.sampled_from(["fixed", "adaptive"])),
        draw(st.floats(0.0, 0.05)),
        draw(st.floats(50.0, 100.0)),
        draw(st.floats(1.0, 300.0)),
        draw(st.floats(0.05, 0.2)),
        draw(st.sampled_from([0.0, 0.01, 0.5])),
        draw(st.sampled_from(["use", "drop"])),
    )
    return link


@examples(20)
@given(st.integers(0, 40), st.integers(0, 40), st.booleans())
def test_a_constant_delay_in_a_buffer_is_the_delay_of_the_buffer(
    delay: int, more: int, adaptive: bool
) -> None:
    depth = (delay + more) * H
    plain = played(Packets(ConstantDelay(depth), longest=0.1))
    kind = "adaptive" if adaptive else "fixed"
    playout = Playout(kind, depth, shrink=0.0)
    link = Packets(ConstantDelay(delay * H), longest=0.1, playout=playout)
    if adaptive and more:  # it would shrink where nothing comes, before the first packet
        return
    behind = played(link)
    for name, values in plain.items():
        np.testing.assert_array_equal(behind[name], values, err_msg=name)


@examples(40)
@given(buffered(), st.integers(0, 2**62))
def test_what_is_played_is_in_order_once_and_after_its_time(link: Packets, seed: int) -> None:
    shown, there = played(link, seed), arrivals(link, seed)
    number, depth = shown["number"], shown["playout"][3]
    changes = np.flatnonzero(np.diff(number, prepend=-1.0))
    assert (np.diff(number) >= 0).all()
    for tick in changes:
        sent = int(number[tick])
        assert sent in there
        assert there[sent] <= tick
        assert tick * H >= sent * H + depth[tick] - 1e-9
    in_use = number >= 0
    since = (np.arange(STEPS) - np.maximum(number, 0)) * H
    np.testing.assert_allclose(shown["age"][in_use], since[in_use], atol=1e-9)
    late, used, skipped, _ = shown["playout"][:, -1]
    # Nothing is silent: of the packets that were due each was played, or is counted.
    due = [sent for sent in there if max(there[sent] * H, sent * H + depth.max()) < 0.38]
    missing = [sent for sent in due if sent not in number]
    assert len(missing) <= late - used + skipped
    if link.playout is not None and not link.playout.adaptive:
        assert skipped == 0


@examples(30)
@given(jittery(), st.integers(0, 2**62), st.floats(0.0, 0.05), st.sampled_from(["use", "drop"]))
def test_a_fixed_buffer_is_that_of_a_dictionary(
    link: Packets, seed: int, depth: float, late: str
) -> None:
    link.playout = Playout(depth=depth, late=late)
    there = arrivals(link, seed)
    number = -1
    ready: dict[int, list[int]] = {}
    wait = math.ceil(round(depth / H, 6))
    for sent, tick in there.items():
        if tick <= sent + wait:
            ready.setdefault(sent + wait, []).append(sent)
        elif late == "use":
            ready.setdefault(tick, []).append(sent)
    shown = played(link, seed)
    used = 0
    for tick in range(STEPS):
        newest = max(ready.get(tick, [-1]))
        if newest > number:
            number = newest
            used += there[newest] > newest + wait
        assert shown["number"][tick] == number, tick
    came_late = sum(tick > sent + wait for sent, tick in there.items())
    np.testing.assert_array_equal(shown["playout"][:3, -1], [came_late, used, 0])


@examples(20)
@given(jittery(), st.integers(0, 2**62))
def test_a_buffer_as_deep_as_the_longest_delay_misses_nothing_but_what_is_lost(
    link: Packets, seed: int
) -> None:
    link.longest = 0.06
    link.playout = Playout(depth=0.06)
    shown, there = played(link, seed), arrivals(link, seed)
    wanted, number = [], -1
    for tick in range(STEPS):
        number = tick - 60 if tick - 60 in there else number
        wanted.append(number)
    np.testing.assert_array_equal(shown["number"], wanted)
    np.testing.assert_array_equal(shown["playout"][:3, -1], 0)


@examples(15)
@given(jittery(), st.integers(0, 2**62), st.sampled_from(["use", "drop"]))
def test_a_fixed_buffer_in_an_archive_is_that_at_hand(link: Packets, seed: int, late: str) -> None:
    link.playout = Playout(depth=0.035, late=late)
    blocks = two_ways(lambda: PacketChannel(link, [7.0, -7.0], H, seed), 16)
    diagram = logged_beside({"divided": blocks[0], "whole": blocks[1]})
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.4)
    pairs = zip(logs(diagram, simulator, "divided"), logs(diagram, simulator, "whole"), strict=True)
    for one, other in pairs:
        assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("percentile", [50.0, 90.0, 99.0])
def test_an_adaptive_depth_is_the_percentile_of_the_delays(percentile: float) -> None:
    jitter = Jitter("gamma", 8e-3, 4e-3)
    link = Packets(ConstantDelay(5e-3), jitter, longest=0.2)
    link.playout = Playout("adaptive", 0.0, percentile, window=2000.0)
    steps = 8000
    depth = played(link, 3, steps)["playout"][3, -4000:]
    times = [5e-3 + jitter_time(jitter.parameters(), 3, packet) for packet in range(steps)]
    wanted = np.ceil(np.array(times) / H) * H
    assert np.median(depth) == pytest.approx(np.percentile(wanted, percentile), abs=1.01 * H)


def test_an_adaptive_depth_knows_of_a_delay_when_a_packet_has_brought_it() -> None:
    law = StepDelay([0.0, 0.1, 0.3], [0.01, 0.05, 0.01])
    link = Packets(law, longest=0.2)
    link.playout = Playout("adaptive", percentile=99.0, window=50.0, shrink=0.1)
    shown = played(link, steps=1500)
    depth, number = np.round(shown["playout"][3] / H), shown["number"]
    np.testing.assert_array_equal(depth[10:150], 10)  # the first with 50 ms comes at 150
    np.testing.assert_array_equal(depth[150:530] >= 50, True)
    # Nothing comes from 110 to 149, and of what is sent then nothing is passed over.
    np.testing.assert_array_equal(number[109:150], 99)
    np.testing.assert_array_equal(number[150:350], np.arange(100, 300))
    assert depth[-1] <= 12  # it has come back, and told whom it passed over for that
    assert 30 <= shown["playout"][2, -1] <= 40


def test_an_adaptive_depth_stays_below_its_bound() -> None:
    link = Packets(SineDelay(0.1, 0.1, 3.0), longest=0.5)
    link.playout = Playout("adaptive", percentile=99.0, maximum=0.05)
    shown = played(link, steps=1000)
    assert shown["playout"][3].max() <= 0.0521
    assert shown["playout"][0, -1] > 100


def test_a_late_packet_is_used_only_where_nothing_newer_was_played() -> None:
    # Packet: 0 1 2 3 4 5; delay in ticks; with a depth of 3 ticks, packets 1 and 4 are late.
    ticks = [2, 4, 3, 1, 5, 9]
    law = StepDelay([(i - 0.25) * H for i in range(6)], [d * H for d in ticks])
    #        tick:  0   1   2  3  4  5  6  7  8  9
    dropped = [-1, -1, -1, 0, 0, 2, 3, 3, 3, 3]
    used = [-1, -1, -1, 0, 0, 2, 3, 3, 3, 4]
    for late, by_hand in (("drop", dropped), ("use", used)):
        link = Packets(law, longest=0.01, playout=Playout(depth=3e-3, late=late))
        shown = played(link, steps=10)
        np.testing.assert_array_equal(shown["number"], by_hand)


BAD: list[tuple[dict[str, Any], str]] = [
    ({"kind": "adaptable"}, r"^up\.playout\.kind: 'adaptable', allowed fixed, adaptive"),
    ({"depth": -1.0}, r"^up\.playout\.depth: -1\.0, allowed 0 to 60$"),
    ({"depth": math.nan}, r"^up\.playout\.depth: nan"),
    ({"percentile": 0.0}, r"^up\.playout\.percentile: 0\.0, allowed above 0, up to 100$"),
    ({"percentile": 101.0}, r"^up\.playout\.percentile: 101\.0"),
    ({"window": 0.5}, r"^up\.playout\.window: 0\.5, allowed 1 to 1e\+06$"),
    ({"shrink": 0.6}, r"^up\.playout\.shrink: 0\.6, allowed 0 to 0\.5$"),
    ({"late": "keep"}, r"^up\.playout\.late: 'keep', allowed coupling, use, drop"),
    (
        {"kind": "adaptive", "depth": 0.6},
        r"^up\.playout\.depth: 0\.6, allowed 0 to 0\.5$",
    ),
]


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_a_bad_buffer_is_refused_by_field_and_range(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check(Packets(playout=Playout(**changes)), "up")

"""A link whose packets suffer from where the tool is, by hand and in a whole loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from engines import both, differences
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from scara_drake import load_scenario, simulate
from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.impairments import Loss
from scara_drake.channel.packets import PacketChannel, Packets
from scara_drake.channel.shadow import RadioShadow, Shadow, shade
from scara_drake.common.fields import check

H = 1e-3
WALL = Shadow(low=[-1e3, -1e3, -1e3], high=[1e3, 0.0, 1e3], edge=0.1, delay=0.02, loss=0.5)


class Ticks(LeafSystem):
    """The number of the tick, and a place that goes 1 mm a tick from y = 0.1 m downwards."""

    def __init__(self) -> None:
        super().__init__()
        time = {self.time_ticket()}
        self.DeclareVectorOutputPort("tick", 1, self._tick, prerequisites_of_calc=time)
        self.DeclareVectorOutputPort("place", 3, self._place, prerequisites_of_calc=time)

    def _tick(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, round(context.get_time() / H))

    def _place(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(np.array([0.3, 0.1 - round(context.get_time() / H) * H, -7.0]))


def received(link: Packets, steps: int) -> NDArray[np.float64]:
    """Numbers received and packets lost after each tick (2, steps)."""
    builder = DiagramBuilder()
    ticks = builder.AddSystem(Ticks())
    shadow = builder.AddSystem(RadioShadow(link.shadow or Shadow()))
    channel = builder.AddSystem(PacketChannel(link, [-1.0], H, seed=4))
    builder.Connect(ticks.GetOutputPort("place"), shadow.GetInputPort("place"))
    builder.Connect(shadow.GetOutputPort("radio"), channel.GetInputPort("transmit"))
    builder.Connect(ticks.GetOutputPort("tick"), channel.GetInputPort("signal_sent"))
    names = ("signal_received", "packet_counts")
    sinks = [LogVectorOutput(channel.GetOutputPort(name), builder, H) for name in names]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((steps + 0.5) * H)
    data = [sink.FindLog(simulator.get_context()).data()[-1, 1:] for sink in sinks]
    return np.stack(data)


@pytest.mark.parametrize(
    ("y", "share"),
    # 3 s² - 2 s³ of the depth over 0.1 m: of a quarter 0.15625, of a half 0.5.
    [(1.0, 0.0), (0.0, 0.0), (-0.025, 0.15625), (-0.05, 0.5), (-0.1, 1.0), (-5.0, 1.0)],
)
def test_a_shadow_comes_in_smoothly_from_its_face(y: float, share: float) -> None:
    assert shade(np.array([3.0, y, 2.0]), WALL.parameters()) == pytest.approx(share, abs=1e-15)


def test_a_box_is_bounded_on_all_sides() -> None:
    box = Shadow(low=[0.0, 1.0, 2.0], high=[1.0, 2.0, 3.0], edge=0.1).parameters()
    inside = np.array([0.5, 1.5, 2.5])
    assert shade(inside, box) == 1.0
    for axis in range(3):
        for way in (-0.6, 0.6):
            assert shade(inside + way * np.eye(3)[axis], box) == 0.0


def test_the_delay_of_a_packet_is_that_of_the_place_where_it_is_sent() -> None:
    shadow = Shadow(high=[1e3, 0.0, 1e3], edge=0.1, delay=0.02, loss=0.0)
    link = Packets(ConstantDelay(5 * H), longest=0.1, shadow=shadow)
    numbers = received(link, 320)[0]
    # By hand: packet k is sent at y = 0.1 m - k mm, so it is as deep as (k - 100) mm.
    newest = np.full(400, -1.0)
    for k in range(320):
        s = min(max((k - 100) / 100.0, 0.0), 1.0)
        travel = 5.0 + 20.0 * s * s * (3.0 - 2.0 * s)
        tick = k + int(np.ceil(travel - 1e-6))
        if tick < 400:
            newest[tick] = max(newest[tick], k)
    by_hand = np.maximum.accumulate(newest)[:320]
    np.testing.assert_array_equal(numbers, by_hand)
    assert numbers[-1] == 319 - 25


def test_the_loss_is_none_outside_and_half_in_the_depth() -> None:
    lost = received(Packets(longest=0.1, shadow=WALL), 2200)[1]
    assert lost[100] == 0
    assert lost[-1] - lost[200] == pytest.approx(1000, abs=4 * np.sqrt(500))


def test_what_the_link_loses_itself_is_lost_with_a_shadow_too() -> None:
    alone = Packets(loss=Loss(in_good=0.2), longest=0.1)
    outside = Packets(loss=alone.loss, longest=0.1, shadow=Shadow([5.0] * 3, [6.0] * 3))
    shadow = Shadow(loss=0.0, delay=0.0)
    inside = Packets(loss=alone.loss, longest=0.1, shadow=shadow)
    np.testing.assert_array_equal(received(outside, 300), received(inside, 300))


JITTER = (
    "!Packets {{delay: !ConstantDelay {{delay: 0.005}}, longest: 0.2,"
    " jitter: {{distribution: gamma, mean: 0.002, std: 0.001}}, playout: {playout},"
    " shadow: {{high: [1000, -0.975, 1000], edge: 0.02, delay: 0.02, loss: 0.2}}}}"
)
PRESS: dict[str, Any] = {
    "operator.times": [0.02, 0.12, 6.0, 7.0],
    "operator.hand_stiffness": 600.0,
    "channel.up": JITTER.format(playout="{depth: 0.03}"),
    "channel.down": JITTER.format(playout="{kind: adaptive, percentile: 90}"),
    "inverse_kinematics.max_acceleration": 50.0,
    "duration": 0.3137,
}


def test_the_place_is_the_true_one_of_the_tool_on_both_links_and_in_both_engines() -> None:
    scenario = load_scenario("bilateral", PRESS)
    compiled, drake = both(scenario)
    worst = differences(compiled, drake)
    assert max(worst.values()) < 1e-6
    for name in ("age_up", "age_down", "delay_up", "delay_down", "packets_lost_up"):
        assert worst[name] == 0.0, name
    for link in ("up", "down"):
        assert compiled[f"packets_lost_{link}"][-1] > 3


def test_the_recorded_delay_is_the_law_of_the_recorded_place() -> None:
    link = (
        "!Packets {longest: 0.2, shadow: {high: [1000, -1.038, 1000], edge: 0.02, delay: 0.05,"
        " loss: 0.0}}"
    )
    recording = simulate(load_scenario("bilateral", {**PRESS, "channel.up": link}))
    t, age = recording.time.values, recording.age_up.values
    arrived = np.flatnonzero(recording.delay_up.values > 0.0)
    # A sample is from before the plant's step, and what is on the ports from the tick before it.
    sent = np.round((t[arrived] - age[arrived]) / H).astype(int)
    share = np.clip((-1.038 - recording.p_WE_measured.sel(axis="y").values) / 0.02, 0.0, 1.0)
    law = 0.05 * share**2 * (3.0 - 2.0 * share)
    np.testing.assert_allclose(recording.delay_up.values[arrived], law[sent], atol=1e-9)
    assert law[sent].max() > 2.0 * law[sent].min() > 1e-3


BAD: list[tuple[dict[str, Any], str]] = [
    ({"edge": 0.0}, r"^up\.shadow\.edge: 0\.0, allowed above 0, up to 10$"),
    ({"loss": 1.5}, r"^up\.shadow\.loss: 1\.5, allowed 0 to 1$"),
    ({"low": [0.0, 0.0]}, r"^up\.shadow\.low: 2 entries, allowed 3$"),
    ({"low": [0.0] * 3, "high": [1.0, 0.0, 1.0]}, r"^up\.shadow\.high\[1\]: 0, allowed above 0"),
    ({"delay": 3.0}, r"^up\.shadow\.delay: 3\.0, allowed 0 to 2\.5$"),
]


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_a_bad_shadow_is_refused_by_field_and_range(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check(Packets(shadow=Shadow(**changes)), "up")


def test_a_link_that_is_a_mere_delay_has_no_shadow() -> None:
    with pytest.raises(ValueError, match=r"channel\.up\.shadow: unknown field"):
        load_scenario("bilateral", {"channel.up": "!ConstantDelay {shadow: {}}"})

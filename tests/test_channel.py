import math

import pytest
from kinds import of_kind

from scara_drake import load_scenario, simulate
from scara_drake.channel.delays import ConstantDelay, Delay, SineDelay
from scara_drake.channel.impairments import Loss
from scara_drake.channel.links import Channel
from scara_drake.channel.packets import Packets
from scara_drake.channel.presets import PRESETS
from scara_drake.common.fields import check


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_valid_and_say_where_they_are_from(name):
    channel = Channel(preset=name)
    check(channel, "channel")
    assert channel.link("up") == channel.link("down") == PRESETS[name].link
    assert PRESETS[name].source


@pytest.mark.parametrize(
    ("name", "span"), [("paper", (0, 0.2)), ("paper_offset", (0, 0.2)), ("paper_2s", (0, 2.0))]
)
def test_the_readings_of_the_paper_span_what_it_says(name, span):
    link = of_kind(Delay, PRESETS[name].link)
    delays = [link.at(2 * math.pi * i / 400) for i in range(400)]
    assert (min(delays), max(delays)) == pytest.approx(span)


def test_a_hop_by_satellite_is_no_faster_than_light():
    link = of_kind(Packets, PRESETS["satellite"].link)
    assert link.delay.at(0.0) > 2 * 35_786e3 / 299_792_458.0


def test_a_preset_is_chosen_by_name_in_a_scenario():
    scenario = load_scenario("teleoperation", {"channel.preset": "paper"})
    run = simulate(scenario, duration=1.0)
    assert float(run.delay_up[-1]) == pytest.approx(0.2 * math.sin(0.999), abs=1e-3)
    with pytest.raises(ValueError, match=r"^channel\.preset: 'wlan', allowed none, paper,"):
        load_scenario("teleoperation", {"channel.preset": "wlan"})


def test_packets_are_chosen_by_tag_in_a_scenario():
    link = "!Packets {delay: !SineDelay {amplitude: 0.05}, loss: {in_good: 0.1}}"
    scenario = load_scenario("teleoperation", {"channel.up": link})
    assert scenario.channel.link("up") == Packets(SineDelay(0.05), loss=Loss(in_good=0.1))


@pytest.mark.parametrize(
    ("channel", "message"),
    [
        (Channel(up=ConstantDelay(-0.1)), r"^channel\.up\.delay: -0\.1, allowed 0 to 60$"),
        (
            Channel(down=SineDelay(3.0)),
            r"^channel\.down: a delay of up to 3 s, allowed 0 to 2\.5 s \(channel\.max_delay\)$",
        ),
        (Channel(max_delay=-1.0), r"^channel\.max_delay: -1\.0, allowed 0 to 60$"),
    ],
)
def test_bad_channels_are_refused_by_field_and_range(channel, message):
    with pytest.raises(ValueError, match=message):
        check(channel, "channel")


def hold(outage):
    """The tool references of a press with the command cut off from 4 s on."""
    link = f"!Packets {{delay: !ConstantDelay {{delay: 0.05}}, outages: [4.0, {outage}]}}"
    scenario = load_scenario("free_motion", {"channel.up": link})
    return simulate(scenario, duration=7.0)


def test_an_outage_holds_then_stops_and_resumes_without_a_jump():
    run = hold(5.5)
    speed = abs(run.v_desired).max("joint")
    assert float(speed.sel(time=slice(3.5, 4.0)).max()) > 0.01
    assert float(speed.sel(time=slice(5.0, 5.5)).max()) < 1e-3
    # Resuming, the references stay within what one period of acceleration changes.
    change = abs(run.v_desired.diff("time")).max()
    whole = simulate(load_scenario("free_motion"), duration=7.0)
    assert float(change) < 5.0 * float(abs(whole.v_desired.diff("time")).max())

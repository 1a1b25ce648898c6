"""How few kilobits a press needs: the dead-band codec over the share k that is not felt.

Published: up to 90 % fewer packets at k = 10 % (Hirche, Hinterseer, Steinbach and Buss, Presence
16, 2007; Kammerl, Vittorias, Nitsch, Faerber, Steinbach and Hirche, Presence 19, 2010), and
performance that falls above a dead band of 27 % (Chaudhari et al., IEEE World Haptics 2011), both
with people. Here the hand of the scenario `bilateral` presses into the wall and lets go, with TDPA.

Errors are from what was sent one delay before, not from the packet in use, which in a silence is
older: the difference is what the codec leaves out. They are taken while the hand presses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, cast

import numpy as np
import xarray as xr

from scara_drake import metrics
from scara_drake.channel.codec import DeadBand
from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.links import Channel
from scara_drake.channel.packets import Packets
from scara_drake.common import checks
from scara_drake.experiments.claim import Experiment
from scara_drake.experiments.literature.dead_band_claims import EVERY, STANDARD, claims
from scara_drake.metrics import bilateral, hand_press
from scara_drake.metrics.links import HEADER, LINKS, NUMBER
from scara_drake.metrics.noticed import force_jnd
from scara_drake.operator.master import Master
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

SCENARIO = "bilateral"
BANDS: Final = (EVERY, 0.0, 0.05, 0.1, 0.2, 0.27, 0.4)
DELAYS: Final = (0.0, 0.1)  # [s], each way
FIGURES: Final = {
    "packets_up": ("1/s", "packets up"),
    "packets_down": ("1/s", "packets down"),
    "bitrate": ("kbit/s", "of both links"),
    "position_error": ("m", "tool from master, delay removed, rms, pressing"),
    "force_error": ("N", "force at the master from that at the tool, delay removed, rms, pressing"),
    "noticed": ("1", "share of the press in which that is more than one JND"),
    "drift": ("m", "tool from master, largest at the end of the run"),
}


def run(
    seed: int = 0,
    bands: Sequence[float] = BANDS,
    delays: Sequence[float] = DELAYS,
    duration: float = 12.0,
) -> Experiment:
    """Press with each dead band over each delay.

    Args:
        seed: of nothing, no part is random.
        bands: k of both directions; `EVERY` for no codec.
        delays: each way [s].
        duration: of a run [s].

    Raises:
        ValueError: the run ends before the press is over, or a band that is compared is missing.
    """
    if not {EVERY, STANDARD} <= set(bands):
        raise ValueError(
            f"bands: {list(bands)}, allowed with {EVERY:g} and {STANDARD:g} among them"
        )
    over = cast(Master, load_scenario(SCENARIO).operator).times[-1]
    checks.number("duration", duration, over + hand_press.LAST)
    found = [[press(band, delay, seed, duration) for band in bands] for delay in delays]
    data = xr.Dataset(
        {
            name: labelled(
                ("delay", "band"), np.array([[one[name] for one in row] for row in found]), *said
            )
            for name, said in FIGURES.items()
        },
        coords={
            "delay": ("delay", list(delays), {"units": "s"}),
            "band": ("band", list(bands), {"units": "1", "long_name": "k; -1 without a codec"}),
        },
        attrs={"seed": seed, "scenario": SCENARIO, "number": NUMBER, "header": HEADER},
    )
    return Experiment("Dead band", data, claims(data))


def press(band: float, delay: float, seed: int, duration: float) -> dict[str, float]:
    """Return `FIGURES` of a press with the dead band k over a delay each way [s]."""
    scenario = load_scenario(SCENARIO, {"seed": seed})
    link = Packets(delay=ConstantDelay(delay))
    codec = None if band == EVERY else DeadBand(k_up=band, k_down=band)
    scenario.channel = Channel(up=link, down=link, codec=codec)
    recording = simulate(scenario, duration=duration)
    begin, end = cast(Master, scenario.operator).times[1:3]
    pressed = slice(begin, end)
    felt = bilateral.as_received(bilateral.resisting_force(recording), recording.delay_down).sel(
        time=pressed
    )
    led = bilateral.as_received(recording.x_master, recording.delay_up)
    apart = bilateral.vector_size(bilateral.tool_way(recording) - led)
    force = bilateral.vector_size(recording.f_master - felt)
    traffic: list[Any] = [metrics.traffic(recording, link) for link in LINKS]
    return {
        "packets_up": traffic[0].packets_per_second,
        "packets_down": traffic[1].packets_per_second,
        "bitrate": sum(one.kilobits_per_second() for one in traffic),
        "position_error": float(metrics.rmse(apart.sel(time=pressed))),
        "force_error": float(metrics.rmse(force)),
        "noticed": float((force > force_jnd(bilateral.vector_size(felt))).mean()),
        "drift": hand_press.drift_left(recording, duration),
    }

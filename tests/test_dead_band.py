"""The table of the dead bands, and what the recording tells of the load of its links."""

from __future__ import annotations

import pytest
from small_experiments import small

from scara_drake import load_scenario, simulate
from scara_drake.experiments import IN_KIND, NOT_REPRODUCED, REPRODUCED, Experiment
from scara_drake.experiments.literature import dead_band
from scara_drake.metrics import traffic
from scara_drake.metrics.figures import figures


def experiment() -> Experiment:
    return small("dead_band")


def verdicts(**factors: float) -> list[str]:
    data = experiment().data.copy(deep=True)
    for name, factor in factors.items():
        coded = data.band > dead_band.EVERY
        data[name] = data[name].where(~coded, data[name] * factor)
    return [claim.verdict for claim in dead_band.claims(data)]


def test_verdicts() -> None:
    assert verdicts() == [REPRODUCED, IN_KIND, REPRODUCED, REPRODUCED]


def test_it_judges_what_it_is_given() -> None:
    assert verdicts(packets_up=5.0)[0] == NOT_REPRODUCED
    assert verdicts(packets_up=1.5, packets_down=5.0)[0] == NOT_REPRODUCED
    assert verdicts(position_error=2.0)[1] == NOT_REPRODUCED
    assert verdicts(noticed=10.0)[2] == NOT_REPRODUCED
    assert verdicts(noticed=0.1)[2] == NOT_REPRODUCED
    assert verdicts(drift=1e9)[3] == NOT_REPRODUCED


def test_a_silent_press_is_nearly_the_one_that_is_sent_in_full() -> None:
    data = experiment().data
    every, coded = (data.sel(band=band) for band in (dead_band.EVERY, 0.1))
    assert every.packets_up.values == pytest.approx(1000.0)
    # 10 and 7 numbers of 8 B with 28 B of UDP over IP, a thousand times a second.
    assert every.bitrate.values == pytest.approx(8e-3 * 1000.0 * (28 + 80 + 28 + 56))
    assert (coded.bitrate < 0.2 * every.bitrate).all()
    assert (data.drift < 1e-3).all()


def test_the_compared_bands_have_to_be_there() -> None:
    with pytest.raises(ValueError, match=r"bands: \[0\.1\], allowed with -1 and 0\.1 among them"):
        dead_band.run(bands=(0.1,))
    with pytest.raises(ValueError, match=r"duration: 5\.0, allowed 7\.5"):
        dead_band.run(duration=5.0)


@pytest.mark.parametrize(
    ("send_period", "number", "header", "expected"),
    [
        (1e-3, 8.0, 28.0, 736.0),  # 8 numbers: (64 + 28) B, a thousand times a second
        (1e-3, 4.0, 28.0, 480.0),
        (1e-3, 8.0, 0.0, 512.0),
        (5e-3, 8.0, 28.0, 147.2),
    ],
)
def test_the_load_is_that_of_payload_and_header(
    send_period: float, number: float, header: float, expected: float
) -> None:
    link = f"!Packets {{send_period: {send_period}}}"
    recording = simulate(load_scenario("free_motion", {"channel.up": link}), duration=1.0)
    assert recording.attrs["packet_numbers_up"] == 8
    found = traffic(recording, "up")
    assert found is not None
    assert found.packets_per_second == pytest.approx(1.0 / send_period, rel=0.01)
    assert found.kilobits_per_second(number, header) == pytest.approx(expected, rel=0.01)
    assert figures(recording)["load up"].value == found.kilobits_per_second()
    del recording.attrs["packet_numbers_up"]  # as in those of before
    assert "load up" not in figures(recording)
    assert "packets up" in figures(recording)

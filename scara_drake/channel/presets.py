"""Named channels: the readings of the paper, and tiers of networks; each with its source."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from scara_drake.channel.delays import ConstantDelay, DelayLaw, SineDelay
from scara_drake.channel.impairments import Jitter, Loss
from scara_drake.channel.packets import Packets
from scara_drake.channel.playout import Playout


@dataclass(frozen=True)
class Preset:
    """A link for each direction.

    Attributes:
        link: of either direction.
        meaning: what it is.
        source: where its numbers are from, and which are assumed.
        playout: buffer that is recommended; None where no packet overtakes another. Its depth is
            the first millisecond in which at least 99 of 100 packets come: with less, waves are
            missing all the time, and each millisecond more is felt as mass.
    """

    link: DelayLaw | Packets
    meaning: str
    source: str
    playout: Playout | None = None

    def buffered(self) -> DelayLaw | Packets:
        """Return the link with the buffer that is recommended, if there is one."""
        if self.playout is None or not isinstance(self.link, Packets):
            return self.link
        return replace(self.link, playout=self.playout)


def _network(delay: float, jitter: float, loss: Loss, longest: float) -> Packets:
    """Delay, then jitter of gamma distribution with mean = 2 std = `jitter`, all in [s]."""
    return Packets(
        ConstantDelay(delay), Jitter("gamma", jitter, 0.5 * jitter), loss, [], 1e-3, longest
    )


PRESETS: Final[dict[str, Preset]] = {
    "none": Preset(ConstantDelay(0.0), "no delay but the tick of the block", "definition"),
    "paper": Preset(
        SineDelay(0.2, 0.0, 1.0),
        "0.2 sin t, zero where negative: 0 to 0.2 s",
        "section VII of the paper; a delay cannot be negative",
    ),
    "paper_offset": Preset(
        SineDelay(0.1, 0.1, 1.0),
        "0.1 (1 + sin t): 0 to 0.2 s",
        "section VII of the paper, read as an amplitude around its mean",
    ),
    "paper_2s": Preset(
        SineDelay(1.0, 1.0, 1.0),
        "1 + sin t: 0 to 2 s",
        'section VII of the paper, which calls its delay "0-2 s"',
    ),
    "lan": Preset(
        _network(0.2e-3, 0.1e-3, Loss(), 0.05),
        "a wired local network",
        "assumed: store and forward of a few switches, each below 0.1 ms",
        Playout(depth=1e-3),
    ),
    "5g": Preset(
        _network(8e-3, 2e-3, Loss(1e-4), 0.2),
        "5G, 10 ms one way",
        "3GPP TS 22.261, discrete automation: 10 ms end to end, 99.99 %; the jitter is assumed",
        Playout(depth=14e-3),
    ),
    "4g": Preset(
        _network(20e-3, 6.5e-3, Loss(1e-3, 0.5, 1e-3, 0.1), 0.5),
        "4G, 26.5 ms one way, bursts of loss",
        "Ofcom, Measuring mobile broadband performance in the UK (2014): 53.1 ms round trip; "
        "jitter and loss are assumed",
        Playout(depth=37e-3),
    ),
    "satellite": Preset(
        _network(0.26, 0.01, Loss(1e-3), 0.6),
        "a geostationary satellite, 270 ms one way",
        "ITU-T G.114: 260 ms for a hop at 36 000 km; jitter and loss are assumed",
        Playout(depth=0.286),
    ),
}

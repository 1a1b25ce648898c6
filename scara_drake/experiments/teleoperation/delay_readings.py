"""What the communication delay t_d = 0.2 sin t, which the paper calls 0 to 2 s, may be."""

from __future__ import annotations

from typing import Any, Final, NamedTuple


class DelayReading(NamedTuple):
    """One way to read it.

    Attributes:
        name: as a reading is called.
        meaning: what it does.
        overrides: of a scenario with a channel.
    """

    name: str
    meaning: str
    overrides: dict[str, Any]


_HALF: Final = {"_tag": "!SineDelay", "amplitude": 0.1, "frequency": 1.0}

# By the name of the preset, where it is one. The first is the formula as it stands.
DELAYS: Final[dict[str, DelayReading]] = {
    "paper": DelayReading(
        "0.2 sin t", "each way, zero where it is negative", {"channel.preset": "paper"}
    ),
    "paper_offset": DelayReading(
        "0.1 (1 + sin t)", "each way, around its mean", {"channel.preset": "paper_offset"}
    ),
    "paper_2s": DelayReading(
        "1 + sin t", "each way, from 0 to 2 s", {"channel.preset": "paper_2s"}
    ),
    "paper_round_trip": DelayReading(
        "0.2 sin t, there and back",
        "half of it each way, zero where it is negative",
        {"channel.up": _HALF, "channel.down": _HALF},
    ),
}

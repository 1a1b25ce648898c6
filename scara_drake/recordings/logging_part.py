"""What a scenario says of its recording."""

from __future__ import annotations

from dataclasses import dataclass

from scara_drake.common.fields import number


@dataclass
class Logging:
    """What a run records.

    Attributes:
        period: from sample to sample.
    """

    period: float = number(1e-3, "s", 1e-3, 1.0)

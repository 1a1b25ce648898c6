"""A device that does what a script says, for tests, docs and demonstrations without hardware."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Callable, Sequence

from scara_drake.operator.devices.sample import Sample

Script = Sequence[tuple[float, Sample]] | Callable[[float], Sample]


class ScriptedDevice:
    """Says at each time what its script has for it, and keeps what shook it.

    Args:
        script: rows of (time [s] from the first sample on, what it says from then on), in the
            order of time; or a function of that time.
        name: of the device.
        now: the clock [s].
        stamped: each sample has the stamp of the moment; else it keeps that of the script.

    Attributes:
        rumbles: (low, high, milliseconds) of each `rumble`.

    Raises:
        ValueError: a script without rows, or with times that fall.
    """

    def __init__(
        self,
        script: Script,
        name: str = "Scripted device",
        now: Callable[[], float] = time.monotonic,
        stamped: bool = True,
    ) -> None:
        self._at = script if callable(script) else _player(script)
        self._name, self._now, self._stamped = name, now, stamped
        self._start: float | None = None
        self._closed = False
        self.rumbles: list[tuple[float, float, int]] = []

    @property
    def name(self) -> str:
        """What it was called."""
        return self._name

    def sample(self) -> Sample:
        """Return what the script says for now; not connected once it is closed."""
        now = self._now()
        if self._start is None:
            self._start = now
        said = self._at(now - self._start)
        if self._stamped:
            said = said._replace(stamp=now)
        return said._replace(connected=said.connected and not self._closed)

    def rumble(self, low: float, high: float, milliseconds: int) -> bool:
        """Keep what it was told; False once it is closed."""
        if not self._closed:
            self.rumbles.append((low, high, milliseconds))
        return not self._closed

    def close(self) -> None:
        """Let go; a second call does nothing."""
        self._closed = True


def _player(rows: Sequence[tuple[float, Sample]]) -> Callable[[float], Sample]:
    times = [at for at, _ in rows]
    if not times or times != sorted(times):
        raise ValueError(f"script: times {times}, allowed one or more that do not fall")
    return lambda at: rows[max(bisect_right(times, at) - 1, 0)][1]

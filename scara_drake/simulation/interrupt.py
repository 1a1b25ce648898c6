"""Signals that ask a run to end, and wait for a good moment."""

from __future__ import annotations

import signal
import sys
import threading
from types import FrameType, TracebackType
from typing import Any, Final

# What ends a program from outside: Ctrl-C, `kill`, a terminal that is closed.
ENDING: Final = tuple(
    number
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if (number := getattr(signal, name, None)) is not None  # Windows has no SIGHUP
)


class DeferredInterrupt:
    """Notes the first signal instead of raising; a second one raises.

    Between `with` and its end `pressed` says whether one came. The second one raises
    KeyboardInterrupt if it is a Ctrl-C, and SystemExit otherwise. Only the main thread can handle
    signals: elsewhere an interrupt raises KeyboardInterrupt as always. A signal that is ignored, as
    `nohup` has it of SIGHUP, stays so.

    Attributes:
        signal: the last that came, or None.
    """

    def __init__(self, *signals: signal.Signals) -> None:
        """Listen to some signals; to Ctrl-C alone if none is given."""
        self.signal: signal.Signals | None = None
        self._signals = signals or (signal.SIGINT,)
        self._before: dict[signal.Signals, Any] = {}
        self._on = threading.current_thread() is threading.main_thread()

    @property
    def pressed(self) -> bool:
        """Whether a signal came."""
        return self.signal is not None

    def reason(self) -> str:
        """What came: "interrupt" for Ctrl-C, "signal SIGTERM" and the like, or ""."""
        if self.signal is None:
            return ""
        return "interrupt" if self.signal == signal.SIGINT else f"signal {self.signal.name}"

    def raise_if_pressed(self) -> None:
        """End the program now if a signal came: there is nothing yet to be kept.

        Raises:
            KeyboardInterrupt: it was a Ctrl-C.
            SystemExit: it was another.
        """
        if self.signal == signal.SIGINT:
            raise KeyboardInterrupt
        if self.signal is not None:
            sys.exit(128 + self.signal)

    def __enter__(self) -> DeferredInterrupt:
        if self._on:
            for number in self._signals:
                if number == signal.SIGINT or signal.getsignal(number) != signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        again = self.signal is not None
        self.signal = signal.Signals(number)
        if again:
            self.raise_if_pressed()

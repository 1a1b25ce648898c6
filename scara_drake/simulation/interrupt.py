"""An interrupt (Ctrl-C) that waits for a good moment."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any


class DeferredInterrupt:
    """Notes the first SIGINT instead of raising; a second one raises as usual.

    Between `with` and its end `pressed` says whether it came. Only the main thread can handle
    signals: elsewhere an interrupt raises KeyboardInterrupt as always.
    """

    def __init__(self) -> None:
        self.pressed = False
        self._before: Any = None
        self._on = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> DeferredInterrupt:
        if self._on:
            self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._on:
            signal.signal(signal.SIGINT, self._before)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.pressed = True
        signal.signal(signal.SIGINT, self._before)

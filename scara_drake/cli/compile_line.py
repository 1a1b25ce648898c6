"""The first call of a kernel compiles it, which takes a while: a line that tells of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

from numba.core import event
from rich.console import Console
from rich.control import Control
from rich.segment import ControlType

COMPILED: Final = "numba:compile"  # numba's name of the event; what is in the cache causes none
ERASE: Final = Control((ControlType.ERASE_IN_LINE, 2), ControlType.CARRIAGE_RETURN)


class CompileLine(event.Listener):
    """Counts and names the kernels that are compiled, in a line that is there while it goes on."""

    def __init__(self, console: Console) -> None:
        self.count = 0
        self._depth = 0  # a kernel compiles what it calls
        self._console = console

    def on_start(self, event: Any) -> None:
        """Show that one more is being compiled."""
        self.count += 1
        self._depth += 1
        if self._console.is_terminal:
            self._console.control(ERASE)
            self._console.print(
                f"Compiling kernels, only the first time: {self.count} ({_name(event)})",
                end="\r",
                highlight=False,
                markup=False,
                no_wrap=True,
                overflow="ellipsis",
            )

    def on_end(self, event: Any) -> None:
        """Take the line away where nothing is being compiled any more."""
        self._depth -= 1
        if self._depth == 0 and self._console.is_terminal:
            self._console.control(ERASE)


def _name(event: Any) -> str:
    """Return the file and the name of what an event compiles, such as "servo.servo_step"."""
    function = event.data["dispatcher"].py_func
    return f"{function.__module__.rpartition('.')[2]}.{function.__name__}"


@contextmanager
def counted_kernels(console: Console) -> Iterator[CompileLine]:
    """Show how many kernels are compiled in a block; nothing where the console is no terminal."""
    line = CompileLine(console)
    with event.install_listener(COMPILED, line):
        yield line

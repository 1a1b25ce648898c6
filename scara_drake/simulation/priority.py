"""What a run in real time asks of the system and of Python, so that its ticks are not late."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Final

FIFO_PRIORITY: Final = 20  # of 1 to 99; interrupt threads of the kernel have 50
NICE: Final = -10
SWITCH_INTERVAL: Final = 1e-4  # [s]; Python's own is 5 ms, in which five ticks are late
NO_PRIORITY: Final = "the priority of any other program"


@contextmanager
def undisturbed() -> Iterator[None]:
    """Keep Python from stalling the thread: its other threads hand over after a tenth of a tick.

    And its garbage collector no longer looks through what is there already, the most of which are
    modules; that takes a third of a second.
    """
    interval = sys.getswitchinterval()
    gc.collect()
    gc.freeze()
    sys.setswitchinterval(min(interval, SWITCH_INTERVAL))
    try:
        yield
    finally:
        sys.setswitchinterval(interval)
        gc.unfreeze()


@contextmanager
def real_time_priority() -> Iterator[str]:
    """Give the calling thread, and no thread or process that it starts, the priority it can get.

    That is the scheduling class SCHED_FIFO, before all normal programs, where the system lets it
    (root, or a limit `rtprio`), else a lower nice value, else none. What it was comes back at the
    end. A thread of that class that never waits can take a whole core, all but the share that the
    kernel keeps back (5 % by default).

    Yields:
        What it has got, in words.
    """
    with ExitStack() as stack:
        for name, give in (
            (f"SCHED_FIFO {FIFO_PRIORITY}", _give_fifo),
            (f"nice {NICE}", _give_nice),
        ):
            try:
                stack.callback(give())
            except (OSError, AttributeError):  # not allowed, or another kind of system
                continue
            yield name
            return
        yield NO_PRIORITY


def _give_fifo() -> Callable[[], None]:
    """Take the class; return what gives it back."""
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    fifo = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    os.sched_setscheduler(0, fifo, os.sched_param(FIFO_PRIORITY))

    def give_back() -> None:
        try:
            os.sched_setscheduler(0, policy, parameters)
        except PermissionError:  # only root may take that flag from a thread
            os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, parameters)

    return give_back


def _give_nice() -> Callable[[], None]:
    """Take the nice value; return what gives it back."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    os.setpriority(os.PRIO_PROCESS, 0, min(before, NICE))
    return lambda: os.setpriority(os.PRIO_PROCESS, 0, before)

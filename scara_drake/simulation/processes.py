"""Processes that simulate, and are renewed: a Diagram is never freed, see `simulate`."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Final

# Each run leaves 2 MB in its process.
RUNS_PER_PROCESS: Final = 100


@contextmanager
def renewed_processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Yield processes, each of which is replaced after `RUNS_PER_PROCESS` runs.

    No more than `jobs` calls may wait at a time: a process whose runs are used up is replaced when
    the next call comes.
    """
    processes = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        jobs, processes, _leave_interrupts, max_tasks_per_child=RUNS_PER_PROCESS
    ) as pool:
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)


def _leave_interrupts() -> None:
    """Ctrl-C reaches every process of the terminal; a run takes it, an idle process does not."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

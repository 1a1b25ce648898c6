"""Tasks side by side in threads, for what releases the interpreter's lock, as compiled runs do."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from scara_drake.common import checks

Task = TypeVar("Task")
Result = TypeVar("Result")

MOST_JOBS = 1024


def job_count(jobs: int | None) -> int:
    """Return how many tasks run side by side: all cores if None.

    Raises:
        ValueError: it is out of its bounds.
    """
    count = (os.cpu_count() or 1) if jobs is None else jobs
    checks.number("jobs", count, 1, MOST_JOBS)
    return count


def side_by_side(
    do: Callable[[Task], Result], tasks: Iterable[Task], jobs: int | None = None
) -> Iterator[Result]:
    """Yield the result of each task, in order; an error ends those that have not begun.

    Args:
        do: does a task.
        tasks: any number.
        jobs: how many side by side; all cores if None.

    Raises:
        ValueError: `jobs` is out of its bounds.
    """
    threads = ThreadPoolExecutor(job_count(jobs))
    try:
        yield from threads.map(do, tasks)
    finally:
        threads.shutdown(cancel_futures=True)

"""Tasks in processes of their own, each by name: what breaks one breaks no other."""

from __future__ import annotations

import io
import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

Result = TypeVar("Result")
Do = Callable[[str], Result]


@dataclass
class _Worker:
    process: Any  # a Process of the context "spawn"
    pipe: Connection
    task: str = ""


class Workers(Generic[Result]):
    """Some processes that do tasks; to be used by `with`, whose end ends them at once."""

    def __init__(self, do: Do[Result], jobs: int) -> None:
        """Prepare; a process begins with its first task.

        Args:
            do: does a task by its name; it must not raise, and can be pickled.
            jobs: how many processes.
        """
        self._do, self._jobs = do, jobs
        self._workers: list[_Worker] = []

    def __enter__(self) -> Workers[Result]:
        return self

    def __exit__(self, *error: object) -> None:
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            worker.process.join()

    def each(
        self, tasks: Iterable[str], began: Callable[[str], None] = lambda task: None
    ) -> Iterator[tuple[str, Result | None]]:
        """Yield each task with its result as it ends; None where its process died.

        Args:
            tasks: they begin in this order.
            began: is told of each as it begins.
        """
        todo = list(tasks)
        while todo or self._busy():
            for worker in self._free(len(todo)):
                worker.task = todo.pop(0)
                worker.pipe.send(worker.task)
                began(worker.task)
            pipes = {worker.pipe: worker for worker in self._busy()}
            for ready in wait(list(pipes), timeout=1.0):
                worker = pipes[ready]  # type: ignore[index]  # only pipes are waited for
                task, worker.task = worker.task, ""
                try:
                    result = worker.pipe.recv()
                except (EOFError, OSError):
                    self._workers.remove(worker)
                    worker.process.join()
                    result = None
                yield task, result

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.task]

    def _free(self, wanted: int) -> list[_Worker]:
        """Return up to so many workers without a task; new ones while there may be more."""
        free = [worker for worker in self._workers if not worker.task][:wanted]
        while len(free) < wanted and len(self._workers) < self._jobs:
            free.append(self._begin())
        return free

    def _begin(self) -> _Worker:
        spawned = multiprocessing.get_context("spawn")  # a fork of a process with threads may hang
        ours, theirs = spawned.Pipe()
        process = spawned.Process(target=_serve, args=(theirs, self._do))
        process.start()
        theirs.close()  # so that the death of the process is seen as the end of the pipe
        self._workers.append(_Worker(process, ours))
        return self._workers[-1]


def _serve(pipe: Connection, do: Do[Any]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits
    sys.stderr = io.StringIO()  # the terminal has one progress display, that of the other process
    while True:
        try:
            task = pipe.recv()
        except EOFError:
            return
        pipe.send(do(task))

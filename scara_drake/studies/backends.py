"""Where the runs of a study run: on this machine, or on the workers of a Dask or Ray cluster.

Each backend runs the same function on the same scenario, so a run has the same bits anywhere.
"""

from __future__ import annotations

import socket
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from importlib.metadata import version
from itertools import islice
from typing import Any, Final, Protocol, TypeVar

from scara_drake.common import checks
from scara_drake.common.checks import shown
from scara_drake.common.parallel import job_count
from scara_drake.scenario import Scenario
from scara_drake.simulation.many import Failed, Figure, each_run, one_line, try_run

Result = TypeVar("Result")
# Takes numbered scenarios and what is kept of a run; yields results as they come.
Runner = Callable[
    [Iterable[tuple[int, Scenario]], Figure[Result]],
    Iterator[tuple[int, Result | Failed]],
]

BACKENDS: Final = ("local", "dask", "ray")
ANSWER: Final = 5.0  # [s] in which a cluster has to answer
AHEAD: Final = 2  # runs that are handed out for each place on a cluster
# How to tell that it is such a cluster that answers, as their own time-outs are minutes: what is
# said to it, and a byte of its answer by its place. Dask begins with the number of its frames,
# which has eight bytes; Ray speaks HTTP/2, whose first frame is of the kind 4.
GREETINGS: Final = {
    "dask": (b"", 7, 0),
    "ray": (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 3, 4),
}
# On which the bits depend.
PACKAGES: Final = ("scara-drake", "drake", "numpy", "numba")


class Cluster(Protocol):
    """Workers somewhere.

    Attributes:
        places: how many runs they do side by side.
    """

    places: int

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Hashable:
        """Hand out a call; return a handle."""

    def first(self, handles: list[Any]) -> Any:
        """Wait until one of some calls has ended; return its handle."""

    def result(self, handle: Any) -> Any:
        """Return what a call has returned, or that it `Failed`, its worker with it."""


@contextmanager
def runner(
    backend: str, jobs: int | None, address: str | None, engine: str
) -> Iterator[Runner[Any]]:
    """Yield what runs scenarios on a backend.

    Args:
        backend: of `BACKENDS`.
        jobs: how many run side by side; all cores if None. A cluster of its own kind knows itself.
        address: of a Dask scheduler or a Ray head; None starts workers on this machine.
        engine: see `simulate`.

    Raises:
        ValueError: the backend is not installed, or nobody answers at the address.
    """
    checks.choice("backend", backend, BACKENDS)
    count = job_count(jobs)
    if backend == "local":
        if address:
            raise ValueError(f"address: {shown(address)}, allowed with the backend dask or ray")
        yield partial(each_run, jobs=count, engine=engine)
        return
    try:
        module = import_module("distributed" if backend == "dask" else "ray")
    except ModuleNotFoundError as error:
        raise ValueError(
            f"backend: '{backend}', allowed with the extra '{backend}' installed ({error})"
        ) from None
    if address:
        _check_answer(backend, address)
    with (dask_cluster if backend == "dask" else ray_cluster)(module, count, address) as cluster:
        _check_versions(cluster)
        yield partial(spread, cluster, engine=engine)


def spread(
    cluster: Cluster,
    scenarios: Iterable[tuple[int, Scenario]],
    figure: Figure[Result],
    engine: str,
) -> Iterator[tuple[int, Result | Failed]]:
    """Simulate scenarios on a cluster; yield each one's number and its figure as it ends."""
    todo = iter(scenarios)
    waiting: dict[Hashable, int] = {}
    while True:
        for number, scenario in islice(todo, AHEAD * cluster.places - len(waiting)):
            waiting[cluster.submit(try_run, scenario, figure, engine)] = number
        if not waiting:
            return
        handle = cluster.first(list(waiting))
        yield waiting.pop(handle), cluster.result(handle)


@contextmanager
def dask_cluster(distributed: Any, jobs: int, address: str | None) -> Iterator[Cluster]:
    """Yield the workers of a Dask scheduler, or of a new one on this machine.

    Raises:
        ValueError: nobody answers at the address, or the scheduler has no workers.
    """
    own = None
    if not address:
        own = distributed.LocalCluster(
            n_workers=jobs, threads_per_worker=1, dashboard_address=None, silence_logs=50
        )
    try:
        client = distributed.Client(address or own, timeout=ANSWER)
        try:
            client.wait_for_workers(1, timeout=ANSWER)
            yield _Dask(distributed, client)
        finally:
            client.close()
    except OSError as error:  # a time-out is one
        raise _nobody(address, one_line(error)) from None
    finally:
        if own is not None:
            own.close()


class _Dask:
    def __init__(self, distributed: Any, client: Any) -> None:
        self._distributed, self._client = distributed, client
        self.places = sum(client.nthreads().values())

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Hashable:
        future: Hashable = self._client.submit(function, *arguments, pure=False)
        return future

    def first(self, handles: list[Any]) -> Any:
        return next(iter(self._distributed.wait(handles, return_when="FIRST_COMPLETED").done))

    def result(self, handle: Any) -> Any:
        try:
            return handle.result()
        except (self._distributed.KilledWorker, self._distributed.CancelledError) as error:
            return Failed(f"its worker ended ({one_line(error)})")


@contextmanager
def ray_cluster(ray: Any, jobs: int, address: str | None) -> Iterator[Cluster]:
    """Yield the workers of a Ray cluster, or of a new one on this machine.

    Raises:
        ValueError: nobody answers at the address.
    """
    own = {"include_dashboard": False, "num_cpus": jobs} if not address else {}
    began = not ray.is_initialized()
    if began:
        try:
            ray.init(
                address=address or "local",
                log_to_driver=False,
                logging_level="error",
                **own,
            )
        except Exception as error:  # it raises nothing more special
            raise _nobody(address, one_line(error)) from None
    try:
        yield _Ray(ray)
    finally:
        if began:
            ray.shutdown()


class _Ray:
    def __init__(self, ray: Any) -> None:
        self._ray = ray
        self._remote = ray.remote(num_cpus=1)(_call)
        self.places = max(1, int(ray.cluster_resources().get("CPU", 1)))

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Hashable:
        handle: Hashable = self._remote.remote(function, *arguments)
        return handle

    def first(self, handles: list[Any]) -> Any:
        return self._ray.wait(handles, num_returns=1)[0][0]

    def result(self, handle: Any) -> Any:
        try:
            return self._ray.get(handle)
        except self._ray.exceptions.WorkerCrashedError as error:
            return Failed(f"its worker ended ({one_line(error)})")


def _call(function: Callable[..., Result], *arguments: Any) -> Result:
    return function(*arguments)


def versions() -> dict[str, str]:
    """Return the versions on which the bits of a run depend."""
    return {name: version(name) for name in PACKAGES}


def _check_versions(cluster: Cluster) -> None:
    """Refuse a cluster whose workers have other versions.

    Raises:
        ValueError: names the first.
    """
    handle = cluster.submit(versions)
    found = cluster.result(cluster.first([handle]))
    for name, here in versions().items():
        if found[name] != here:
            raise ValueError(f"address: workers with {name} {found[name]}, allowed {here} as here")


def _check_answer(backend: str, address: str) -> None:
    """Refuse an address where no cluster of this kind answers.

    Raises:
        ValueError: it is no address, or nobody answers.
    """
    scheme, _, place = address.rpartition("://")
    host, colon, port = place.rpartition(":")
    if not (colon and host and port.isdecimal()):
        raise ValueError(f"address: {shown(address)}, allowed HOST:PORT")
    said, at, byte = GREETINGS[backend]
    try:
        with socket.create_connection((host.strip("[]"), int(port)), ANSWER) as connection:
            if scheme == "tls":  # nothing is said in clear
                return
            connection.sendall(said)
            answer = connection.recv(9, socket.MSG_WAITALL)
    except (OSError, OverflowError, UnicodeError) as error:
        raise _nobody(address, one_line(error)) from None
    if len(answer) <= at or answer[at] != byte:
        raise _nobody(address, f"what is there is no {backend.capitalize()}")


def _nobody(address: str | None, reason: str) -> ValueError:
    return ValueError(
        f"address: {shown(address or 'this machine')}, allowed one that answers within "
        f"{ANSWER:g} s ({reason})"
    )

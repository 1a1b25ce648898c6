"""Executes the notebooks, once, into build/notebooks: tests and site read these copies.

    python docs/run_notebooks.py [01_robot_and_diagram ...] [--jobs 2]

A notebook whose copy was made of the same notebook and the same package is left as it is. An error
names notebook and cell. A cell that writes to stderr has failed too: a warning is no picture.
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Final

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

ROOT: Final = Path(__file__).parents[1]
SOURCES: Final = ROOT / "notebooks"
EXECUTED: Final = ROOT / "build" / "notebooks"
SUFFIXES: Final = (".py", ".yaml", ".urdf", ".csv")  # of what a result may depend on
LONGEST: Final = 600  # [s] of a cell, on a machine with much to do
DIGEST: Final = "scara_drake_digest"  # in the metadata of a copy


class NotebookError(Exception):
    """A cell failed; the message names notebook and cell."""


def names() -> list[str]:
    """Return the names of all notebooks."""
    return sorted(path.stem for path in SOURCES.glob("*.ipynb"))


def digest(name: str) -> str:
    """Return a hash of a notebook and of everything that its results may depend on."""
    notebook = (SOURCES / f"{name}.ipynb").read_bytes()
    return hashlib.sha256(_package() + notebook).hexdigest()


@cache
def _package() -> bytes:
    found = hashlib.sha256()
    for folder in ("scara_drake", "diagrams", "models", "profiles"):
        for path in sorted(p for p in (ROOT / folder).rglob("*") if p.suffix in SUFFIXES):
            found.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return found.digest()


@contextmanager
def _alone(name: str) -> Iterator[None]:
    """Let one process at a time execute a notebook; the next one finds its copy."""
    EXECUTED.mkdir(parents=True, exist_ok=True)
    with (EXECUTED / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def execute(name: str) -> Path:
    """Return the executed copy of a notebook, which is made where it is missing or out of date.

    Raises:
        NotebookError: a cell failed, took too long, or wrote to stderr; no copy is left then.
    """
    made, wanted = EXECUTED / f"{name}.ipynb", digest(name)
    with _alone(name):
        if made.is_file() and read(made).metadata.get(DIGEST) == wanted:
            return made
        made.unlink(missing_ok=True)
        notebook = read(SOURCES / f"{name}.ipynb")
        begin = time.perf_counter()
        run(notebook, name)
        notebook.metadata[DIGEST] = wanted
        half = made.with_suffix(".half")
        nbformat.write(notebook, half)
        half.replace(made)
        sys.stdout.write(f"{name}: {time.perf_counter() - begin:.0f} s\n")
        return made


def read(path: Path) -> Any:
    """Return a notebook."""
    return nbformat.read(path, as_version=4)


def run(notebook: Any, name: str) -> None:
    """Execute a notebook in its folder.

    Raises:
        NotebookError: as `execute`.
    """
    try:
        client_of(notebook).execute()
    except (CellExecutionError, CellTimeoutError, DeadKernelError) as error:
        raise NotebookError(f"{where(notebook, name)}: {error}") from None
    for index, cell in enumerate(notebook.cells):
        for output in cell.get("outputs", ()):
            if output.output_type == "stream" and output.name == "stderr":
                raise NotebookError(f"{name}, cell {index}: stderr: {output.text.strip()}")


def client_of(notebook: Any) -> NotebookClient:
    """Return what executes a notebook in its folder."""
    return NotebookClient(
        notebook,
        timeout=LONGEST,
        startup_timeout=LONGEST,
        extra_arguments=["--Application.log_level=ERROR"],  # of the kernel's own words
        resources={"metadata": {"path": str(SOURCES)}},
    )


def where(notebook: Any, name: str) -> str:
    """Return the place of the cell that failed: the one behind the last that was finished."""
    for index, cell in enumerate(notebook.cells):
        outputs = cell.get("outputs", ())
        if any(output.output_type == "error" for output in outputs):
            return f"{name}, cell {index}"
    return name


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute what is asked for, all if nothing is; 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", metavar="NAME", help="of notebooks; all if none")
    parser.add_argument("--jobs", type=int, default=2, help="how many side by side (2)")
    options = parser.parse_args(arguments)
    unknown = sorted(set(options.names) - set(names()))
    wrong = f"NAME: {', '.join(unknown)}, allowed {', '.join(names())}" if unknown else ""
    if options.jobs < 1:
        wrong = f"--jobs: {options.jobs}, allowed 1 or more"
    if wrong:
        sys.stderr.write(f"{wrong}\n")
        return 2
    failed = False
    with ThreadPoolExecutor(options.jobs) as pool:
        for future in [pool.submit(execute, name) for name in options.names or names()]:
            try:
                future.result()
            except NotebookError as error:
                sys.stderr.write(f"{error}\n")
                failed = True
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main())

"""The command line: it takes the arguments, runs the command, and answers by an exit status."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Final

from rich.console import Console
from rich.markup import escape

from scara_drake.cli.parser import make_parser

FAILED_RUN: Final = 1
BAD_INPUT: Final = 2
INTERRUPTED: Final = 130


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status: 0, 1 or 3 for a failed run, 2 for bad input.

    A command fails by what it raises, or by what it returns: a status, or None where all is well.
    """
    options = make_parser().parse_args(arguments)
    errors = Console(stderr=True, soft_wrap=True)
    try:
        # Only now: what a command needs takes seconds to import, and may not be installed.
        module = _module_of(options.command, options.module, options.extra)
        from scara_drake.cli.compile_line import counted_kernels  # numba is there by now

        with _told(errors), counted_kernels(errors):
            status: int = module.run(options, Console()) or 0
    except ValueError as error:
        if options.traceback:
            raise
        errors.print(f"scara-drake: {escape(str(error))}", highlight=False)
        return BAD_INPUT
    except (RuntimeError, OSError) as error:
        if options.traceback:
            raise
        errors.print(f"scara-drake: failed: {escape(' '.join(str(error).split()))}")
        return FAILED_RUN
    except KeyboardInterrupt:
        return INTERRUPTED
    return status


@contextmanager
def _told(console: Console) -> Iterator[None]:
    """Let warnings and notes of the package be lines on the console, each once."""

    def show(message: Warning | str, category: type[Warning], *rest: Any, **more: Any) -> None:
        if issubclass(category, UserWarning):
            console.print(f"scara-drake: warning: {message}", markup=False, highlight=False)
        else:
            before(message, category, *rest, **more)

    notes = logging.getLogger("scara_drake")
    handler = logging.Handler()
    handler.emit = lambda record: console.print(  # type: ignore[method-assign]  # it is one line
        record.getMessage(), markup=False, highlight=False
    )
    notes.addHandler(handler)
    notes.setLevel(logging.INFO)
    # The scene gives the root logger a handler of its own, which would tell it a second time.
    propagates, notes.propagate = notes.propagate, False
    with warnings.catch_warnings():
        before = warnings.showwarning
        warnings.showwarning = show
        warnings.simplefilter("always", UserWarning)
        try:
            yield
        finally:
            notes.removeHandler(handler)
            notes.propagate = propagates


def _module_of(command: str, name: str, extra: str) -> Any:
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if not extra and not str(error.name).startswith("pydrake"):
            raise
        what = f"the extra '{extra}'" if extra else "Drake"
        raise ValueError(f"{command}: {error}, allowed with {what} installed") from None

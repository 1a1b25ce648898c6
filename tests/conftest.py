"""What every test can count on, and what the last lines of a run say of those that were skipped.

A test that needs something of the machine is marked with its kind and skipped without it. On a
developer's machine the skipped ones are counted; where CI=true what they need is installed, so that
one of them skipped fails the run.
"""

import os
import signal
from collections import Counter
from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

# Kinds of tests, by their mark, that need what a machine may not have.
NEEDED = ("browser", "drawing", "device", "check_urdf")
OTHER = "other"

# Those that set their number of examples themselves do it by `strategies.examples`.
settings.register_profile("nightly", max_examples=10 * settings().max_examples, deadline=None)


def pytest_configure() -> None:
    """Draw ten times the examples on demand, and let Ctrl-C be heard, in child processes too.

    A shell in the background ignores Ctrl-C.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if os.environ.get("SCARA_DRAKE_NIGHTLY"):
        settings.load_profile("nightly")


def skipped(config: pytest.Config) -> Counter[tuple[str, str]]:
    """How many were skipped, by kind and reason."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    reports: Iterable[Any] = reporter.stats.get("skipped", ()) if reporter else ()
    return Counter((_kind(report), _reason(report)) for report in reports)


def _kind(report: Any) -> str:
    marks = getattr(report, "keywords", {})
    return next((kind for kind in NEEDED if kind in marks), OTHER)


def _reason(report: Any) -> str:
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return str(text).removeprefix("Skipped: ")


def _missing_in_ci(config: pytest.Config) -> int:
    if os.environ.get("CI", "").lower() != "true":
        return 0
    return sum(count for (kind, _), count in skipped(config).items() if kind in NEEDED)


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail where CI skipped what it has to try."""
    if session.exitstatus == pytest.ExitCode.OK and _missing_in_ci(session.config):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Count the skipped ones by kind and reason, the last lines but one."""
    counted = skipped(config)
    if not counted:
        return
    terminalreporter.section(f"skipped: {sum(counted.values())}")
    for (kind, reason), count in sorted(counted.items()):
        terminalreporter.write_line(f"{count} {kind}: {reason}")
    if missing := _missing_in_ci(config):
        line = f"CI has to try what needs a machine: {missing} skipped"
        terminalreporter.write_line(line, red=True)

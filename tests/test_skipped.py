"""What a run says of the tests that it skipped, and when skipping fails it."""

from pathlib import Path

import conftest
import pytest

pytest_plugins = ["pytester"]

TESTS = """
import pytest

@pytest.mark.{kind}
@pytest.mark.skipif(True, reason="nothing of that kind here")
def test_needs():
    pass

def test_elsewhere():
    pytest.skip("only on Tuesdays")

def test_always():
    pass
"""
MARKS = "[pytest]\nmarkers =\n browser:\n drawing:\n device:\n check_urdf:\n slow:\n"


@pytest.fixture
def tried(pytester, monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    pytester.makeconftest(Path(conftest.__file__).read_text())
    pytester.makefile(".ini", pytest=MARKS)
    return pytester


@pytest.mark.parametrize("kind", conftest.NEEDED)
def test_skipped_ones_are_counted_by_kind_and_reason(tried, kind):
    tried.makepyfile(TESTS.format(kind=kind))
    result = tried.runpytest_inprocess("-p", "no:cacheprovider")
    lines = ["*skipped: 2*", f"1 {kind}: nothing of that kind here", "1 other: only on Tuesdays"]
    result.stdout.fnmatch_lines(lines)
    assert result.ret == pytest.ExitCode.OK


def test_those_of_other_processes_are_counted_too(tried, monkeypatch):
    monkeypatch.setenv("CI", "true")
    tried.makepyfile(TESTS.format(kind="device"))
    result = tried.runpytest_subprocess("-p", "no:cacheprovider", "-n", "1")
    result.stdout.fnmatch_lines(["*skipped: 2*", "1 device: nothing of that kind here"])
    assert result.ret == pytest.ExitCode.TESTS_FAILED


@pytest.mark.parametrize("kind", conftest.NEEDED)
def test_ci_fails_where_it_skips_what_needs_a_machine(tried, monkeypatch, kind):
    monkeypatch.setenv("CI", "true")
    tried.makepyfile(TESTS.format(kind=kind))
    result = tried.runpytest_inprocess("-p", "no:cacheprovider")
    result.stdout.fnmatch_lines(["CI has to try what needs a machine: 1 skipped"])
    assert result.ret == pytest.ExitCode.TESTS_FAILED


def test_ci_lets_others_be_skipped(tried, monkeypatch):
    monkeypatch.setenv("CI", "true")
    tried.makepyfile(TESTS.format(kind="slow"))
    assert tried.runpytest_inprocess("-p", "no:cacheprovider").ret == pytest.ExitCode.OK


def test_nightly_draws_ten_times_the_examples(tried, monkeypatch):
    monkeypatch.setenv("SCARA_DRAKE_NIGHTLY", "1")
    tried.makepyfile(
        "from hypothesis import settings\n"
        "def test_it():\n    assert settings().max_examples == 1000\n"
    )
    assert tried.runpytest_subprocess("-p", "no:cacheprovider").ret == pytest.ExitCode.OK

"""What a run in real time asks of the system is given back, and is nobody else's."""

from __future__ import annotations

import gc
import os
import sys
import threading

import pytest

from scara_drake.simulation import priority


def scheduling() -> tuple[int, int, int]:
    """Class, priority and nice value of the calling thread."""
    return (
        os.sched_getscheduler(0),
        os.sched_getparam(0).sched_priority,
        os.getpriority(os.PRIO_PROCESS, 0),
    )


def refuse(*_: object) -> None:
    raise PermissionError


def in_a_thread(function):
    found = []
    thread = threading.Thread(target=lambda: found.append(function()))
    thread.start()
    thread.join()
    return found[0]


@pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="no such call on this system")
def test_what_is_given_is_given_back_and_no_thread_inherits_it() -> None:
    before = scheduling()
    with priority.real_time_priority() as got:
        during, inherited = scheduling(), in_a_thread(scheduling)
    assert scheduling()[1:] == before[1:]
    if got.startswith("SCHED_FIFO"):
        assert during[0] & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO
        assert during[1] == priority.FIFO_PRIORITY
        assert inherited[0] & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER
    elif got.startswith("nice"):
        assert during[2] == min(before[2], priority.NICE)


def test_it_falls_back_to_nice_then_to_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[int] = []
    monkeypatch.setattr(os, "sched_setscheduler", refuse, raising=False)
    monkeypatch.setattr(os, "setpriority", lambda which, who, nice: given.append(nice))
    before = os.getpriority(os.PRIO_PROCESS, 0)
    with priority.real_time_priority() as got:
        assert got == f"nice {priority.NICE}"
    assert given == [min(before, priority.NICE), before]
    monkeypatch.setattr(os, "setpriority", refuse)
    with priority.real_time_priority() as got:
        assert got == priority.NO_PRIORITY
    monkeypatch.delattr(os, "sched_getscheduler", raising=False)
    monkeypatch.delattr(os, "getpriority")
    with priority.real_time_priority() as got:
        assert got == priority.NO_PRIORITY


def test_priority_is_given_back_where_the_run_fails() -> None:
    before = scheduling()
    with pytest.raises(RuntimeError), priority.real_time_priority():
        raise RuntimeError
    assert scheduling()[1:] == before[1:]


def test_python_is_left_as_it_was() -> None:
    interval = sys.getswitchinterval()
    with priority.undisturbed():
        assert sys.getswitchinterval() == pytest.approx(priority.SWITCH_INTERVAL)
        assert gc.get_freeze_count() > 0
    assert sys.getswitchinterval() == interval
    assert gc.get_freeze_count() == 0

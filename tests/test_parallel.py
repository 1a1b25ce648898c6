from __future__ import annotations

import threading

import pytest

from scara_drake.common.parallel import side_by_side


def test_tasks_wait_for_each_other_and_come_back_in_order() -> None:
    both = threading.Barrier(2, timeout=30.0)  # [s]; nobody passes it alone

    def do(task: int) -> int:
        both.wait()
        return task**2

    assert list(side_by_side(do, range(6), jobs=2)) == [0, 1, 4, 9, 16, 25]
    assert list(side_by_side(abs, [], jobs=2)) == []


def test_an_error_ends_those_that_have_not_begun() -> None:
    begun = []

    def do(task: int) -> None:
        begun.append(task)
        raise KeyError(task)

    with pytest.raises(KeyError, match="0"):
        list(side_by_side(do, range(1000), jobs=1))
    assert len(begun) < 1000


@pytest.mark.parametrize("jobs", [0, -1, 1025])
def test_jobs_out_of_bounds_are_refused(jobs: int) -> None:
    with pytest.raises(ValueError, match=r"^jobs: "):
        list(side_by_side(abs, [1], jobs))

"""Runs a small study and kills itself, as `kill -9` does, when some of its runs are kept.

python kill_study.py STORE.nc RUNS
"""

import os
import signal
import sys

from small_study import small_study

from scara_drake.studies import store
from scara_drake.studies.sweep import sweep


def main() -> None:
    """Run, and end in the middle."""
    add, count = store.Store.add, int(sys.argv[2])

    def add_and_die(self: store.Store, number: int, row: store.Row) -> None:
        add(self, number, row)
        if len(self.rows) == count:
            os.kill(os.getpid(), signal.SIGKILL)

    store.Store.add = add_and_die  # type: ignore[method-assign]  # the place to die
    sweep(small_study(), sys.argv[1], jobs=2)


if __name__ == "__main__":
    main()

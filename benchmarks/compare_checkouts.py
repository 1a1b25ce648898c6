"""Whether a change costs time: the scenarios in two checkouts, interleaved.

Each checkout has a process of its own, which builds the Diagrams once; they take turns, so that
what else the machine does falls on both alike. A ratio is the median of the ratios of the rounds.
Run it on a machine that rests::

    git worktree add ../before main~1
    python benchmarks/compare_checkouts.py ../before . --rounds 21
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

# Runs in the checkout; it may be of any age that has these two names.
WORKER = """
import sys, time
from pydrake.systems.analysis import Simulator
from scara_drake import load_scenario, make_diagram
seconds, names = float(sys.argv[1]), sys.argv[2:]
cases = []
for name in names:
    diagram = make_diagram(load_scenario(name))
    cases.append((Simulator(diagram), diagram.CreateDefaultContext()))
def measure(simulator, start, seconds):
    simulator.reset_context(start.Clone())
    simulator.Initialize()
    begin = time.perf_counter()
    simulator.AdvanceTo(seconds + 0.5e-3)
    return 1e3 * (time.perf_counter() - begin) / seconds
for simulator, start in cases:
    measure(simulator, start, 0.1)
print("ready", flush=True)
for line in sys.stdin:
    print(measure(*cases[int(line)], seconds), flush=True)
"""


class Checkout:
    """A process with the Diagrams of one checkout."""

    def __init__(self, folder: Path, seconds: float, names: list[str]):
        self._process = subprocess.Popen(
            [sys.executable, "-c", WORKER, str(seconds), *names],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(folder)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def answer(self) -> str:
        """Return the next line of the process.

        Raises:
            RuntimeError: it has ended; what it said stands on the terminal.
        """
        assert self._process.stdout is not None  # it was asked for
        line = self._process.stdout.readline().strip()
        if not line:
            raise RuntimeError("a checkout cannot run the scenarios, see above")
        return line

    def measure(self, case: int) -> float:
        """Return the wall time of a simulated millisecond [µs]."""
        assert self._process.stdin is not None  # it was asked for
        self._process.stdin.write(f"{case}\n")
        self._process.stdin.flush()
        return float(self.answer())

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()


def main() -> None:
    """Print a table of the ratios."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("before", type=Path, help="folder of a checkout")
    parser.add_argument("after", type=Path, help="folder of another")
    parser.add_argument("--seconds", type=float, default=2.0, help="of each run, simulated")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--scenarios", nargs="+", default=["teleoperation", "bilateral"])
    options = parser.parse_args()
    folders = [options.before.resolve(), options.after.resolve()]
    checkouts = [Checkout(folder, options.seconds, options.scenarios) for folder in folders]
    try:
        for checkout in checkouts:
            checkout.answer()
        times = np.empty((options.rounds, len(options.scenarios), 2))
        for index in track(range(options.rounds), "Rounds"):
            for case in range(len(options.scenarios)):
                # Each goes first as often as the other.
                for side in (0, 1) if index % 2 else (1, 0):
                    times[index, case, side] = checkouts[side].measure(case)
    finally:
        for checkout in checkouts:
            checkout.close()
    table = Table("scenario", "before [µs/ms]", "after [µs/ms]", "after / before")
    for case, name in enumerate(options.scenarios):
        before, after = np.median(times[:, case], axis=0)
        ratio = np.median(times[:, case, 1] / times[:, case, 0])
        table.add_row(name, f"{before:.1f}", f"{after:.1f}", f"{ratio:.3f}")
    Console().print(table)


if __name__ == "__main__":
    main()

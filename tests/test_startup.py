"""Importing compiles nothing, and a second process finds its kernels compiled."""

import subprocess
import sys

REPORT = """
import gc
from numba.core.registry import CPUDispatcher
import scara_drake as sd
for name in sd.__all__:
    getattr(sd, name)
kernels = [k for k in gc.get_objects() if isinstance(k, CPUDispatcher)]
kernels = [k for k in kernels if k.__module__.startswith("scara_drake")]
print(len(kernels), sum(len(k.signatures) for k in kernels))
sd.ik.solve(sd.kinematics.forward_kinematics([3.0, -0.5, 0.1, -0.5, 1.0, 0.0]))
print(sum(sum(k.stats.cache_misses.values()) for k in kernels))
print(sum(sum(k.stats.cache_hits.values()) for k in kernels))
"""


def report():
    """Kernels, compiled on import, compiled by a solve, found compiled by it."""
    run = subprocess.run([sys.executable, "-c", REPORT], capture_output=True, text=True, check=True)
    return [int(word) for word in run.stdout.split()]


def test_importing_compiles_nothing_and_a_second_run_finds_its_kernels():
    kernels, on_import, _, _ = report()
    assert kernels > 30
    assert on_import == 0
    _, _, compiled, found = report()
    assert compiled == 0
    assert found > 0

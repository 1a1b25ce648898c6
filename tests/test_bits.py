"""The shipped scenarios give the recordings that they have always given, to the bit.

The digests hold for one arithmetic: that of the pinned libraries on one kind of processor, told by
a digest of functions and products of its own. Elsewhere the last bits may differ, and the test
says so instead of failing. After a change that is meant to change results, this writes them anew::

    python tests/test_bits.py
"""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numba import njit

from scara_drake import load_scenario, simulate
from scara_drake.recordings.recorder import versions
from scara_drake.scenario import scenario_names

DIGESTS = Path(__file__).with_name("bits.json")


def digest(arrays: dict[str, np.ndarray]) -> str:
    """SHA-256 of named arrays, their types and shapes."""
    found = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        found.update(f"{name} {array.dtype} {array.shape}".encode())
        found.update(array.tobytes())
    return found.hexdigest()


def digest_of(recording: xr.Dataset) -> str:
    return digest({str(name): recording[name].values for name in recording.variables})


@njit
def functions(x: np.ndarray) -> np.ndarray:
    found = np.empty((6, x.size))
    for i in range(x.size):
        found[0, i], found[1, i], found[2, i] = math.sin(x[i]), math.cos(x[i]), math.exp(x[i])
        found[3, i], found[4, i] = math.atan2(x[i], 2.0), math.sqrt(abs(x[i]))
        found[5, i] = math.log1p(abs(x[i]))
    return found


def arithmetic() -> str:
    """Digest of what this machine and these libraries make of some numbers."""
    x = np.random.default_rng(0).normal(size=4096)
    square = x.reshape(64, 64)
    arrays = {"compiled": functions(x), "product": square @ square, "solved": np.linalg.inv(square)}
    arrays |= {f.__name__: f(x) for f in (np.sin, np.cos, np.exp, np.arctan)}
    versioned = {name: v for name, v in versions().items() if name != "scara-drake"}
    arrays["versions"] = np.array(json.dumps(versioned, sort_keys=True))
    return digest(arrays)


@pytest.mark.parametrize("engine", ["compiled", "drake"])
@pytest.mark.parametrize("name", scenario_names())
def test_a_shipped_scenario_keeps_its_bits(name: str, engine: str) -> None:
    known = json.loads(DIGESTS.read_text())
    if known["arithmetic"] != arithmetic():
        pytest.skip("another arithmetic: libraries or processor differ from those of the digests")
    assert digest_of(simulate(load_scenario(name), engine=engine)) == known[engine][name]


def write() -> None:
    known: dict[str, Any] = {"arithmetic": arithmetic()}
    for engine in ("drake", "compiled"):
        known[engine] = {
            name: digest_of(simulate(load_scenario(name), engine=engine))
            for name in scenario_names()
        }
    DIGESTS.write_text(json.dumps(known, indent=2) + "\n")


if __name__ == "__main__":
    write()

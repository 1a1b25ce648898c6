"""The benchmark of the engine judges what it measures, and steps the robot that Drake has."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

import engine_speed
import peers

from scara_drake import joints


def said(times: dict[str, float]) -> list[str]:
    """The verdicts, in the order of the criteria, on times that are the same in each round."""
    table = engine_speed.verdicts(list(times), np.array([[*times.values()]] * 3))
    return [str(cell) for cell in table.columns[-1].cells]


def test_verdicts_on_times_by_hand() -> None:
    teleoperation, bilateral = map(engine_speed.engine, engine_speed.SCENARIOS)
    times = {
        engine_speed.PLANT: 50.0,
        teleoperation: 15.0,
        bilateral: 17.6,
        engine_speed.diagram(engine_speed.SCENARIOS[0]): 180.0,
        engine_speed.THREADS: 16.6,
    }
    assert said(times) == ["met", "met", "missed", "met", ""]
    times |= {teleoperation: 15.1, bilateral: 17.4, engine_speed.MUJOCO: 15.2}
    assert said(times) == ["missed", "missed", "met", "met", "met"]
    times[engine_speed.THREADS] = 17.0
    assert said(times)[3] == "missed"


def test_the_reference_is_a_robot_that_hangs_still_and_falls_by_its_weight() -> None:
    reference = peers.Reference()
    still = reference.acceleration(joints.HOME, np.zeros(6), reference.weight)
    np.testing.assert_allclose(still, 0.0, atol=1e-9)
    falling = reference.acceleration(joints.HOME, np.zeros(6), np.zeros(6))
    # Nothing holds the mast: all of the arm falls.
    assert abs(falling[0]) == pytest.approx(9.81, rel=1e-2)


def test_another_robot_is_refused() -> None:
    reference = peers.Reference()
    with pytest.raises(RuntimeError, match=r"^peer: .* from Drake's acceleration, allowed 1e-09$"):
        reference.check("peer", lambda q, v, u: 1.0001 * reference.acceleration(q, v, u))

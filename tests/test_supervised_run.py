"""A supervised run with a fault in it, from the stick to the arm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from scara_drake.safety import Reason, State
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

LOST = 1.7  # [s]


def run_with_a_lost_pad(path: Path, engine: str) -> xr.Dataset:
    """Full deflection and the mast going up, from 0.6 s; the pad is gone for 0.3 s, then back."""
    times = np.arange(0.0, 3.1, 0.01)
    rows = pd.DataFrame({"time": times, "x": 0.0, "y": 0.0, "z": 0.0, "mast_axis": 0.0})
    moves = times >= 0.6
    rows["x"], rows["mast_hat"], rows["engage"] = -1.0 * moves, 1.0 * moves, 1.0 * (times >= 0.5)
    rows["connected"] = 1.0 - ((times >= LOST) & (times < LOST + 0.3))
    rows.round(4).to_csv(path, index=False)
    settings = {
        "operator.trace": str(path),
        "operator.mapping.mode": "rate",
        "duration": 3.0,
        "supervision": "{}",
    }
    scenario = load_scenario("free_motion", settings | {"operator.mapping.rate": 0.5})
    return simulate(scenario, engine=engine)


def test_a_pad_lost_at_full_speed_brings_tool_and_mast_to_rest_and_back_it_moves_nothing(
    tmp_path: Path,
) -> None:
    run = run_with_a_lost_pad(tmp_path / "lost.csv", "drake")
    time, dt = run.time.values, 1e-3
    measured = run.p_WE_measured.values
    speed = np.linalg.norm(np.diff(measured, axis=0), axis=1) / dt
    mast = run.q_measured.values[:, 0]
    assert speed[time[:-1] < LOST].max() > 0.45
    known = time[np.argmax(run.robot_state.values == State.HOLD)]
    delay = float(run.delay_up.sel(time=known, method="nearest"))
    assert known == pytest.approx(LOST + delay, abs=0.01)
    rest = time[:-1] > known + 0.4
    assert speed[rest].max() < 5e-3
    assert (np.abs(np.diff(mast)) / dt)[rest].max() < 5e-3
    # Commanded and followed without a step, and within the drives.
    commanded = run.p_WE_commanded.values
    v = np.diff(commanded[time >= 0.7], axis=0) / dt
    assert np.linalg.norm(np.diff(v, axis=0), axis=1).max() / dt <= 3.0 + 1e-6
    desired = run.v_desired.values
    assert np.abs(np.diff(desired, axis=0)).max() < 0.03
    np.testing.assert_array_equal(run.tau_commanded, run.tau_applied, "no effort limit")
    # Plugged in again with the button still down: nothing.
    state, reason = run.operator_state.values, run.operator_reason.values
    after = time > LOST + 0.01
    assert (state[after] == State.HOLD).all()
    assert (reason[after] == Reason.DEVICE_LOST).all()
    assert np.ptp(commanded[time > LOST + 0.5], axis=0).max() == 0.0


@pytest.mark.slow
def test_the_engine_and_drake_run_it_to_the_same_states(tmp_path: Path) -> None:
    runs = [run_with_a_lost_pad(tmp_path / "lost.csv", engine) for engine in ("compiled", "drake")]
    one, other = runs
    for name in ("operator_state", "operator_reason", "robot_state", "robot_reason"):
        np.testing.assert_array_equal(one[name], other[name])
    np.testing.assert_array_equal(one.p_WE_commanded, other.p_WE_commanded)


def test_a_stick_that_is_a_speed_needs_a_supervisor() -> None:
    with pytest.raises(ValueError, match=r"operator\.mapping\.mode: 'rate', allowed position with"):
        load_scenario("free_motion", {"operator.mapping.mode": "rate"})
    load_scenario("free_motion", {"operator.mapping.mode": "rate", "supervision": "{}"})

"""What a hand feels of each coupling, against springs and dampers that are added by hand."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.environment.compliance import SineMotion
from scara_drake.metrics.figures import figures
from scara_drake.metrics.manual import (
    backdrivability,
    displayed_stiffness,
    effort_transparency,
    free_resistance,
)
from scara_drake.metrics.noticed import compliance_jnds, force_jnd, force_jnds, noticed
from scara_drake.metrics.scales import Scales, scales_of
from scara_drake.metrics.squared_force import squared_force
from scara_drake.scenario import Scenario, load_scenario
from scara_drake.simulation.run import simulate
from scara_drake.studies.figures import METRICS, figures_of

PRESS = [0.5, 4.5, 6.0]  # [s], slowly: the springs are seen, not the masses
HAND, WALL = 150.0, 1e4  # [N/m]


def made(coupling: str, delay: float, wall: float = WALL) -> Scenario:
    link = f"!ConstantDelay {{delay: {delay}}}"
    scenario = load_scenario(
        "bilateral", {"coupling": coupling, "channel.up": link, "channel.down": link}
    )
    (surface,) = scenario.environment.surfaces
    surface.stiffness, surface.damping = wall, min(surface.damping, 0.05 * wall)
    return scenario


@cache
def pressed(coupling: str, delay: float, wall: float = WALL) -> xr.Dataset:
    """A press that goes 3 cm beyond the wall, until the hand begins to let go."""
    scenario = made(coupling, delay, wall)
    operator: Any = scenario.operator
    operator.times, operator.targets = PRESS, operator.targets[:3]
    return simulate(scenario, duration=6.0)


def series(*springs: float) -> float:
    return 1.0 / sum(1.0 / spring for spring in springs)


@pytest.mark.parametrize(
    ("coupling", "delay", "wall", "stiffness", "within"),
    [
        ("!PositionDamping {}", 0.0, WALL, series(100.0, WALL), 0.01),
        ("!PositionDamping {}", 0.05, WALL, series(100.0, WALL), 0.01),
        ("!PositionDamping {stiffness: 300.0}", 0.0, WALL, series(300.0, WALL), 0.01),
        ("!Tdpa {}", 0.0, WALL, series(1000.0, WALL), 0.04),
        ("!ScaledForce {}", 0.05, 200.0, 0.1 * 200.0, 0.01),
        ("!Direct {}", 0.0, 200.0, 200.0, 0.01),
        # A wave that is under way is a spring b / T, in a row with the others.
        ("!WaveVariables {}", 0.05, WALL, series(1000.0, WALL, 20.0 / 0.052), 0.1),
    ],
)
def test_the_stiffness_that_is_shown_is_that_of_springs_in_a_row(
    coupling: str, delay: float, wall: float, stiffness: float, within: float
) -> None:
    felt = displayed_stiffness(pressed(coupling, delay, wall))
    assert felt.stiffness == pytest.approx(stiffness, rel=within)
    assert felt.unexplained < 0.05


def test_pd_shows_its_own_damper_too() -> None:
    assert displayed_stiffness(pressed("!PositionDamping {}", 0.05)).damping == pytest.approx(
        30.0, rel=0.02
    )


@pytest.mark.parametrize(
    ("coupling", "wall", "ratio"),
    [("!Direct {}", 200.0, 1.0), ("!ScaledForce {}", 200.0, 1.0), ("!Tdpa {}", WALL, 1.0)],
)
def test_the_effort_is_handed_on_in_the_masters_units(
    coupling: str, wall: float, ratio: float
) -> None:
    recording = pressed(coupling, 0.0, wall)
    scales = scales_of(recording)
    found = effort_transparency(recording, scales.force)
    assert found.ratio == pytest.approx(ratio, abs=0.01)
    assert found.unexplained < 0.01
    # Asked for in the tool's units it is the scale.
    assert effort_transparency(recording).ratio == pytest.approx(ratio * scales.force, rel=0.01)


@pytest.mark.parametrize("delay", [0.0, 0.05])
def test_free_motion_of_pd_costs_both_dampers_and_the_spring_over_the_delay(delay: float) -> None:
    """At rest in its own frame: K (x_m - x_s) = B v at the slave, a delay more at the master."""
    scenario = made("!PositionDamping {}", delay)
    scenario.environment.surfaces = []
    operator: Any = scenario.operator
    operator.times, operator.targets = [0.5, 6.5], [[0.0, 0.0, 0.0], [0.0, -0.06, 0.0]]
    recording = simulate(scenario, duration=6.0)
    by_hand = 2 * 30.0 + 100.0 * 2 * (delay + 1e-3)
    assert free_resistance(recording).damping == pytest.approx(by_hand, rel=0.02)


def test_a_model_of_the_wall_costs_nothing_in_free_motion() -> None:
    assert free_resistance(pressed("!ModelMediated {}", 0.05)) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("coupling", "ratio"),
    [
        ("!PositionDamping {}", 100.0 / (100.0 + HAND)),
        ("!Tdpa {}", 1000.0 / (1000.0 + HAND)),
        ("!ModelMediated {}", 0.0),
    ],
)
def test_a_tool_that_is_pushed_moves_the_master_through_a_spring(
    coupling: str, ratio: float
) -> None:
    """A wall that comes 3 cm, slowly: the spring of the coupling against that of the hand."""
    scenario = made(coupling, 0.0, 1000.0)
    operator: Any = scenario.operator
    operator.times, operator.targets = [0.5], [[0.0, 0.0, 0.0]]
    scenario.environment.surfaces[0].motion = SineMotion(amplitude=0.03, frequency=0.04)
    found = backdrivability(simulate(scenario, duration=6.0))
    assert found.ratio == pytest.approx(ratio, abs=0.03)
    assert found.effort > 0.1


TIME = 1e-3 * np.arange(2001)


def recording(sent: np.ndarray, shown: np.ndarray) -> xr.Dataset:
    """Force (n,) at the tool that resists, and that at the master 50 ms later [N]."""
    late = 0.05 + np.zeros(TIME.size)
    columns = {"f_env_on_tool_W": -sent, "f_master": np.interp(TIME - 0.05, TIME, shown)}
    data: dict[str, Any] = {
        name: (("time", "axis"), np.stack([0 * TIME, values, 0 * TIME], axis=1))
        for name, values in columns.items()
    }
    data["delay_down"] = ("time", late)
    return xr.Dataset(data, {"time": TIME, "axis": list("xyz")})


@examples(20)
@given(force=st.floats(2.5, 10.0), wrong=st.floats(-0.5, 0.5))
def test_a_force_that_is_wrong_by_seven_percent_is_one_jnd(force: float, wrong: float) -> None:
    flat = force + 0.0 * TIME
    made = recording(flat, (1.0 + wrong) * flat)
    np.testing.assert_allclose(force_jnds(made), abs(wrong) / 0.07, atol=1e-9)
    found = noticed(made)
    assert found.mean == pytest.approx(abs(wrong) / 0.07, abs=1e-9)
    assert found.share == (abs(wrong) > 0.07)
    assert found.tested == 1.0


def test_below_the_range_the_jnd_is_a_floor_and_above_a_share() -> None:
    forces = xr.DataArray([0.0, 1.0, 2.5, 10.0, 40.0])
    np.testing.assert_allclose(force_jnd(forces), [0.175, 0.175, 0.175, 0.7, 2.8])


def test_the_share_and_the_percentile_are_those_of_the_time() -> None:
    shown = np.where(TIME < 1.8, 5.0, 5.0 * 1.21)  # three JND for the last 150 ms and a delay
    found = noticed(recording(5.0 + 0.0 * TIME, shown))
    assert found.share == pytest.approx(0.15 / 2.0, abs=1e-3)
    assert found.mean == pytest.approx(3.0 * 0.15 / 2.0, abs=2e-3)
    assert found.percentile95 == pytest.approx(3.0)
    assert noticed(recording(0.0 * TIME, 0.0 * TIME)) == (0.0, 0.0, 0.0, 0.0)


def test_a_compliance_that_is_felt_wrong() -> None:
    assert compliance_jnds(1000.0, 1000.0) == 0.0
    assert compliance_jnds(1000.0, 1150.0) == pytest.approx(1.0)
    assert compliance_jnds(1000.0, 850.0, 0.075) == pytest.approx(2.0)


@examples(20)
@given(size=st.floats(0.0, 50.0), length=st.integers(1, 1900))
def test_the_squared_force_is_force_times_force_times_time(size: float, length: int) -> None:
    force = np.where(np.arange(TIME.size) < length, size, 0.0)
    exact = size**2 * (length - 0.5) * 1e-3
    assert squared_force(recording(force, force)) == pytest.approx(exact, abs=1e-9)


def test_the_figures_of_a_run_have_them_with_their_units() -> None:
    one = pressed("!ScaledForce {}", 0.05, 200.0)
    assert scales_of(one) == Scales(1.0, 0.1)
    told = figures(one)
    assert told["displayed stiffness"][1:] == ("N/m", displayed_stiffness(one).stiffness)
    assert told["effort transparency"].value == pytest.approx(1.0, abs=0.01)
    assert told["squared force on the tool"][1:] == ("N^2 s", squared_force(one))
    assert told["force error that the hand would notice"].value == 0.0
    assert told["resistance in free motion"].value == 0.0
    # The links, a tick for each block and the limiter's lag, see `own_latency`.
    assert 50.0 < told["time offset of the tool, mean"].value < 50.0 + 12.0
    assert 50.0 < told["time offset of the force, mean"].value < 50.0 + 12.0
    names = ["force_noticed_share", "squared_force", "effort_transparency", "free_resistance",
             "displayed_stiffness", "time_offset_mean", "value_offset_rms", "force_jnd_p95",
             "backdrive_ratio"]  # fmt: skip
    values, missing = figures_of(made("!ScaledForce {}", 0.05, 200.0), one, names, 0.0)
    assert not missing
    kept = dict(zip(names, values, strict=True))
    assert kept["displayed_stiffness"] == told["displayed stiffness"].value
    assert 1e3 * kept["time_offset_mean"] == told["time offset of the tool, mean"].value
    assert all(METRICS[name].units for name in names)


def test_without_contact_there_is_none_of_a_contact() -> None:
    scenario = made("!PositionDamping {}", 0.0)
    scenario.environment.surfaces = []
    one = simulate(scenario, duration=1.0)
    for figure in (effort_transparency, displayed_stiffness, backdrivability):
        with pytest.raises(ValueError, match=r"^recording: 0 samples in contact, allowed 20 or"):
            figure(one)
    told = figures(one)
    assert "effort transparency" not in told
    assert "time offset of the force, mean" not in told
    assert "time offset of the tool, mean" in told
    held = pressed("!PositionDamping {}", 0.0).isel(time=slice(-30, -25))
    with pytest.raises(ValueError, match=r"^recording: 5 samples in contact"):
        displayed_stiffness(held)

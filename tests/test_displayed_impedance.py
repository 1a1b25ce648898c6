"""Closed forms of the displayed impedance, against the equations of their networks solved."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.coupling.direct import Direct, ScaledForce
from scara_drake.coupling.ends import Coupling
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.environment import Wall
from scara_drake.stability.displayed_impedance import (
    Way,
    displayed_impedance,
    pressed,
    through_waves,
)

Complex = np.ndarray

frequencies = st.floats(0.01, 50.0)  # [Hz]
delays = st.floats(0.0, 2.0)  # there and back [s]
walls = st.builds(Wall, stiffness=st.floats(10.0, 1e5), damping=st.floats(0.0, 200.0))


def shown(coupling: Coupling, wall: Wall, hertz: float, way: Way) -> complex:
    frequency = xr.DataArray([hertz], dims="frequency")
    return complex(displayed_impedance(coupling, wall, frequency, way).values[0])


def solved(equations: list[dict[str, complex]], hertz: float) -> complex:
    """Force at the master of a network moved with v_m = 1: each equation is a sum that is zero.

    The factor of "1" is that of the motion, so an unknown "f_m" of the solution is the impedance.
    """
    names = sorted({name for row in equations for name in row} - {"1"})
    matrix = np.array([[row.get(name, 0.0) for name in names] for row in equations])
    right = np.array([-row.get("1", 0.0) for row in equations])
    return complex(np.linalg.solve(matrix, right)[names.index("f_m")])


def wave_network(c: WaveVariables, wall: Wall, hertz: float, way: Way) -> complex:
    """The equations of the two ends as they stand in `wave_variables`, tick for tick."""
    s, h, b = 2j * np.pi * hertz, way.period, c.impedance
    root, half = np.sqrt(2.0 * b), np.exp(-s * (0.5 * way.delay + 2.0 * h))
    tick = np.exp(s * h)
    spring, end = c.damping + c.stiffness / s, c.virtual_mass * s + c.contact_damping
    return solved([
        # u of the mean velocity and the force over the tick that is over
        {"u": root, "1": -b * tick**-0.5, "f_m": -1.0 / tick},
        {"u_s": 1.0, "u": -half},
        {"v_s": b, "f_s": 1.0, "u_s": -root},
        {"f_s": 1.0, "v_s": -spring, "v": spring},
        {"f_s": 1.0, "v": -(end + wall.damping + wall.stiffness / s)},
        {"w_s": 1.0, "u_s": -1.0, "f_s": np.sqrt(2.0 / b)},
        {"w": 1.0, "w_s": -half},
        {"f_m": tick, "1": -b, "w": root},
    ], hertz)  # fmt: skip


def spring_network(c: PositionDamping, wall: Wall, hertz: float, way: Way) -> complex:
    """The two forces of P+d, in positions."""
    s, h = 2j * np.pi * hertz, way.period
    half, tick = np.exp(-s * (0.5 * way.delay + 2.0 * h)), np.exp(s * h)
    end = c.virtual_mass * s + c.contact_damping + wall.damping + wall.stiffness / s
    return solved([
        {"f_m": tick, "1": -(c.stiffness / s + c.damping), "x_far": c.stiffness},
        {"x_far": 1.0, "x": -half},
        {"x_near": 1.0, "1": -half / s},
        {"f_s": 1.0, "x_near": -c.stiffness, "x": c.stiffness + c.damping * s},
        {"f_s": 1.0, "x": -end * s},
    ], hertz)  # fmt: skip


@pytest.mark.parametrize(
    ("coupling", "network"),
    [(WaveVariables(), wave_network), (PositionDamping(), spring_network)],
    ids=["waves", "P+d"],
)
@examples(60)
@given(wall=walls, hertz=frequencies, delay=delays, period=st.sampled_from([0.0, 1e-4, 1e-3]))
def test_a_closed_form_solves_the_equations_of_its_network(
    coupling: Coupling,
    network: Callable[[Coupling, Wall, float, Way], complex],
    wall: Wall,
    hertz: float,
    delay: float,
    period: float,
) -> None:
    way = Way(delay, period)
    assert shown(coupling, wall, hertz, way) == pytest.approx(
        network(coupling, wall, hertz, way), rel=1e-6
    )


@examples(60)
@given(hertz=frequencies, delay=delays, end=st.floats(0.0, 1e5))
def test_waves_without_ticks_are_the_formula_of_hirche_and_buss(
    hertz: float, delay: float, end: float
) -> None:
    b, s = 20.0, 2j * np.pi * hertz
    lossless = np.tanh(s * 0.5 * delay)
    published = b * (end + b * lossless) / (b + end * lossless)
    assert complex(through_waves(s, end, b, Way(delay))) == pytest.approx(published, rel=1e-6)


def test_at_low_frequency_a_wall_is_softer_and_free_space_a_mass() -> None:
    # b k / (b + k T) and b T, one way: 20 * 1000 / (20 + 1000 * 0.1), 20 * 0.1 = 2 kg.
    s = 2e-4j * np.pi
    wall = complex(through_waves(s, 1000.0 / s, 20.0, Way(0.2)))
    assert (wall * s).real == pytest.approx(20.0 * 1000.0 / 120.0, rel=1e-6)
    free = complex(through_waves(s, 0.0, 20.0, Way(0.2)))
    assert (free / s).real == pytest.approx(2.0, rel=1e-6)


@examples(40)
@given(wall=walls, hertz=frequencies, delay=delays)
def test_position_and_force_show_the_wall_late_and_a_model_at_once(
    wall: Wall, hertz: float, delay: float
) -> None:
    s = 2j * np.pi * hertz
    own = wall.damping + wall.stiffness / s
    late = own * np.exp(-s * (delay + 0.012))
    way = Way(delay, 0.0, 0.012)
    assert shown(Direct(), wall, hertz, way) == pytest.approx(late, rel=1e-6)
    assert shown(ScaledForce(), wall, hertz, way) == pytest.approx(0.1 * late, rel=1e-6)
    assert shown(ModelMediated(), wall, hertz, way) == pytest.approx(own, rel=1e-6)


def test_a_press_of_three_centimetres_rests_as_deep_as_its_springs_say() -> None:
    # 150 N/m of the hand, 1000 of the coupling and 10000 of the wall in a row over 3 cm.
    force = 0.03 / (1.0 / 150.0 + 1.0 / 1000.0 + 1.0 / 1e4)
    touched = pressed(WaveVariables(), Wall(), 150.0, 0.03, Way(0.0))
    assert touched.damping == pytest.approx(100.0 * force / 1e4 / 1e-3, rel=1e-4)
    # A delay of 0.25 s one way is a spring of b / T = 80 N/m beside them.
    force = 0.03 / (1.0 / 150.0 + 1.0 / 1000.0 + 1.0 / 1e4 + 1.0 / 80.0)
    touched = pressed(WaveVariables(), Wall(), 150.0, 0.03, Way(0.5))
    assert touched.damping == pytest.approx(100.0 * force / 1e4 / 1e-3, rel=1e-4)
    assert pressed(ModelMediated(), Wall(), 1e4, 0.03, Way(0.0)) == Wall()


def test_scales_make_what_is_shown_larger() -> None:
    way, wall = Way(0.1, 1e-3), Wall()
    one = shown(WaveVariables(), wall, 1.0, way)
    scaled = dataclasses.replace(WaveVariables(), position_scale=2.0, force_scale=0.25)
    assert shown(scaled, wall, 1.0, way) == pytest.approx(0.5 * one)


def test_a_coupling_without_a_closed_form_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^coupling: !Tdpa, allowed !WaveVariables, !Position"):
        shown(Tdpa(), Wall(), 1.0, Way(0.0))

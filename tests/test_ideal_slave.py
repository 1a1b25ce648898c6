"""Position up, force down with an ideal slave: what the coupling itself can bear."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scara_drake.environment import Wall
from scara_drake.experiments.teleoperation.ideal_slave import ideal_slave, stable_delay
from scara_drake.stability.certificates import llewellyn


def test_the_wall_of_table_4_bears_3_5_ms_there_and_back() -> None:
    # From a simulation of its own, the same hand and wall: 3.5 ms, and 13.9 ms at a tenth.
    assert stable_delay() == pytest.approx(3.5e-3, abs=0.2e-3)
    assert stable_delay(force_scale=0.1) == pytest.approx(13.9e-3, abs=1.0e-3)


def test_without_damping_of_the_wall_the_linear_bound_is_near() -> None:
    # K T <= b: the device's 2 N s/m and the hand's 4 against 10 kN/m, 0.6 ms.
    assert stable_delay(wall=Wall(damping=0.0)) == pytest.approx(0.6e-3, abs=0.15e-3)


@given(omega=st.floats(0.1, 1e3), delay=st.floats(0.0, 2.0))
def test_eta_of_an_ideal_slave_is_the_cosine_of_the_delay_there_and_back(
    omega: float, delay: float
) -> None:
    eta = llewellyn(*ideal_slave(omega, delay))
    assert float(eta) == pytest.approx(np.cos(2.0 * omega * delay), abs=1e-9)


@given(damping=st.floats(0.0, 100.0), admittance=st.floats(0.0, 10.0), turns=st.floats(1e-3, 10.0))
def test_eta_is_at_least_one_for_two_dampers_between_ideal_ends(
    damping: float, admittance: float, turns: float
) -> None:
    # Re h11 Re h22 >= 0 and h12 h21 = -n^2 < 0: a lever with losses.
    assert float(llewellyn(damping, turns, -turns, admittance)) >= 1.0 - 1e-12

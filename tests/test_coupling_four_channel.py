from __future__ import annotations

import numpy as np
import pytest
from coupling_rig import E_OUT_M, F_ENV, F_M, X_M, X_S, Rig
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.common.fields import check
from scara_drake.coupling.four_channel import FourChannel
from scara_drake.stability.certificates import llewellyn


def hybrid(c: FourChannel, s: complex, delay: float) -> np.ndarray:
    """H of [f_h, -v_s] = H [v_m, f_e] from the law's forces and two ideal bodies, solved.

    The delay is there and back. Columns are the answers to a motion and to a force alone.
    """
    late = np.exp(-0.5 * s * delay)
    C = c.damping + c.stiffness / s
    device, tool = c.device_mass * s + c.device_damping, c.virtual_mass * s
    known_device = c.acceleration * c.device_mass * s + c.device_damping
    known_tool = c.acceleration * c.virtual_mass * s
    c5, c6 = c.local_slave, c.local_master
    # Unknown f_h, f_m, v_s, f_s.
    left = np.array([
        [1.0, -1.0, 0.0, 0.0],
        [c6, 1.0, (C + known_device) * late, 0.0],
        [0.0, 0.0, tool, -1.0],
        [-(1.0 + c5) * late, 0.0, C, 1.0],
    ])  # fmt: skip
    right = np.array([
        [device, 0.0],
        [C, (1.0 + c6) * late],
        [0.0, -1.0],
        [(C + known_tool) * late, -c5],
    ])  # fmt: skip
    f_h, _, v_s, _ = np.linalg.solve(left, right)
    return np.array([f_h, -v_s])


locals_ = st.floats(-0.9, 3.0)


@examples(60)
@given(
    hertz=st.floats(0.05, 50.0),
    stiffness=st.floats(0.0, 1e4),
    damping=st.floats(1.0, 200.0),
    local_master=locals_,
    local_slave=locals_,
)
def test_without_delay_and_with_ideal_bodies_the_hand_feels_the_environment(
    hertz: float, stiffness: float, damping: float, local_master: float, local_slave: float
) -> None:
    c = FourChannel(
        stiffness=stiffness, damping=damping, local_master=local_master, local_slave=local_slave,
        acceleration=1.0,
    )  # fmt: skip
    ideal = np.array([[0.0, 1.0], [-1.0, 0.0]])
    np.testing.assert_allclose(hybrid(c, 2j * np.pi * hertz, 0.0), ideal, atol=1e-7)


def test_without_the_accelerations_it_feels_half_of_device_and_tool() -> None:
    c, s = FourChannel(local_master=0.0), 2j * np.pi * 2.0
    h11 = hybrid(c, s, 0.0)[0, 0]
    # The force of the hand pushes at both ends, so it moves both bodies with twice of it.
    assert h11 == pytest.approx(0.5 * s * (c.device_mass + c.virtual_mass), rel=0.1)


def test_a_delay_makes_it_active() -> None:
    c = FourChannel(acceleration=1.0)
    eta = [float(llewellyn(*hybrid(c, 2j * np.pi * f, 0.01).ravel())) for f in (1.0, 5.0, 20.0)]
    assert min(eta) < 1.0


@pytest.mark.parametrize("delay", [0.0, 0.005, 0.0265])
def test_it_presses_with_what_the_hand_feels(delay: float) -> None:
    result = Rig().run(FourChannel(), delay, delay, 6.0)
    # Hand and wall alone in a row, K_h K / (K_h + K): no spring of a coupling is between them.
    assert -result[-1, F_M] == pytest.approx(0.03 * 150.0 / 1.015, rel=1e-3)
    assert result[-1, F_ENV] == pytest.approx(-result[-1, F_M], rel=1e-3)
    assert result[-1, X_S] == pytest.approx(result[-1, X_M], abs=1e-5)


def test_late_accelerations_make_the_press_unstable_and_the_meters_tell() -> None:
    calm = Rig().run(FourChannel(), 0.005, 0.005, 6.0)
    wild = Rig().run(FourChannel(acceleration=1.0), 0.005, 0.005, 6.0)
    assert calm[5000:, F_M].std() < 0.01
    assert wild[5000:, F_M].std() > 1.0
    assert wild[-1, E_OUT_M] > 10.0 * calm[-1, E_OUT_M]


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"c\.acceleration: 2\.0, allowed 0 to 1"):
        check(FourChannel(acceleration=2.0), "c")

from __future__ import annotations

import math

import pytest
from coupling_rig import F_M, X_M, X_S, Rig

from scara_drake.common.fields import check
from scara_drake.coupling.position_damping import PositionDamping, damping_margin


def test_the_margin_is_the_sufficient_condition() -> None:
    # 4 B^2 > (T_l^2 + T_r^2) K^2: with T = 0.3 and 0.4 s, B = K T / 2 with T^2 = 0.25 s^2.
    assert damping_margin(100.0, 25.0, 0.3, 0.4) == pytest.approx(1.0)
    assert damping_margin(100.0, 50.0, 0.3, 0.4) == pytest.approx(4.0)
    assert damping_margin(200.0, 50.0, 0.3, 0.4) == pytest.approx(1.0)
    assert damping_margin(100.0, 1.0, 0.0, 0.0) == math.inf
    assert PositionDamping(stiffness=100.0, damping=25.0).margin(0.3, 0.4) == pytest.approx(1.0)


@pytest.mark.parametrize("delay", [0.02, 0.2, lambda t: max(0.2 * math.sin(t), 0.0)])
def test_where_the_condition_holds_it_settles(delay: float) -> None:
    coupling = PositionDamping()
    assert coupling.margin(0.2, 0.2) > 1.0
    result = Rig().run(coupling, delay, delay, 14.0)
    assert abs(result[-500:, F_M]).max() < 0.01
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-4


def test_far_below_the_condition_it_does_not() -> None:
    coupling = PositionDamping(stiffness=5000.0, damping=2.0)
    assert coupling.margin(0.2, 0.2) < 0.01
    result = Rig(wall=-9.0).run(coupling, 0.2, 0.2, 14.0)
    assert abs(result[-1000:, F_M]).max() > 50.0


def test_the_spring_shows_where_the_other_end_is() -> None:
    # In the wall: hand and coupling in series, f = K_h K / (K_h + K) (x_t - x_wall), wall stiff.
    result = Rig().run(PositionDamping(), 0.0, 0.0, 6.0)
    in_series = 150.0 * 100.0 / 250.0 * 0.03
    assert -result[-1, F_M] == pytest.approx(in_series, rel=0.02)


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"c\.damping: -1\.0, allowed 0 to 10000"):
        check(PositionDamping(damping=-1.0), "c")

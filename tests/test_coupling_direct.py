from __future__ import annotations

import pytest
from coupling_rig import F_ENV, F_M, X_M, Rig

from scara_drake.coupling.direct import Direct, ScaledForce


def test_force_and_position_pass_through_with_their_scales() -> None:
    # A soft wall keeps the loop stable: hand and scaled wall share the press, K_h / (K_h + K).
    rig = Rig(stiffness=200.0, damping=20.0)
    result = rig.run(ScaledForce(), 0.01, 0.01, 6.0)
    assert result[-1, F_M] == pytest.approx(-0.1 * result[-1, F_ENV], rel=1e-6)
    depth = 0.03 * 150.0 / (150.0 + 20.0)
    assert -result[-1, X_M] == pytest.approx(0.01 + depth, rel=1e-3)


def test_a_stiff_wall_is_unstable_from_5_ms_on() -> None:
    for delay in (0.005, 0.02, 0.1):
        assert abs(Rig().run(Direct(), delay, delay, 6.0)[:, F_M]).max() > 100.0

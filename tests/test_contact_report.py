import numpy as np
import pytest
import xarray as xr

from scara_drake import joints, load_scenario, simulate
from scara_drake.kinematics import forward_kinematics
from scara_drake.metrics.contact import yielding_joints


def recording(saturation: list[list[float]], penetration: list[list[float]]) -> xr.Dataset:
    return xr.Dataset(
        {
            "saturation": (("time", "joint"), np.array(saturation, dtype=float)),
            "penetration": (("time", "surface"), np.array(penetration)),
        },
        coords={"joint": ["d1", "theta2"]},
    )


def test_the_share_of_the_contact_outside_the_layer() -> None:
    # Bits: 1 outside the layer, 2 at the effort limit. The first sample is before the touch.
    bits: list[list[float]] = [[1, 1], [0, 1], [2, 3], [1, 0], [0, 2]]
    depth: list[list[float]] = [[0, 0], [1e-3, 0], [0, 1e-3], [1e-3, 1e-3], [1e-3, 0]]
    share = yielding_joints(recording(bits, depth))
    assert share.dims == ("joint",)
    np.testing.assert_allclose(share, [0.25, 0.5])
    assert float(share.sel(joint="theta2")) == 0.5


def test_without_contact_there_is_no_share() -> None:
    assert yielding_joints(recording([[1, 1]], [[0.0]])).isnull().all()
    assert yielding_joints(recording([[1, 1]], [[]])).isnull().all()
    assert yielding_joints(recording([[1, 1]], [[np.nan]])).isnull().all()


def test_a_recording_without_saturation_is_refused() -> None:
    with pytest.raises(ValueError, match="recording: no saturation, allowed"):
        yielding_joints(recording([[1, 1]], [[0.0]]).drop_vars("saturation"))


@pytest.mark.parametrize(("rho", "expected"), [(150.0, []), (3.0, ["theta3"])])
def test_joints_yield_to_a_hard_press_where_their_robust_part_is_too_small(
    rho: float, expected: list[str]
) -> None:
    tool = forward_kinematics(joints.HOME)[:3, 3]
    pressed = simulate(
        load_scenario(
            "joint_sine",
            {
                "operator": {"_tag": "!JointMotion", "base": joints.HOME.tolist()},
                "duration": 0.3,
                "environment.surfaces": [{"point": (tool + np.array([0, 0.05, 0])).tolist()}],
                "controller.rho": [500.0, *[rho] * 5],  # the mast carries the weight
            },
        )
    )
    share = yielding_joints(pressed)
    assert [str(joint) for joint in share.joint.values if share.sel(joint=joint) > 0.5] == expected
    assert float(pressed.f_env_on_tool_W.sel(axis="y")[-1]) > 450.0

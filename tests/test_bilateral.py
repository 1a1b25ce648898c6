from __future__ import annotations

import math

import numpy as np
import pytest
from bilateral_arm import Arm
from pydrake.systems.analysis import Simulator

from scara_drake.channel.delays import ConstantDelay, DelayLaw, SineDelay
from scara_drake.channel.impairments import Loss
from scara_drake.channel.links import Channel, Link
from scara_drake.channel.packets import Packets
from scara_drake.coupling.direct import Direct
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.scenario import Coupling, Scenario
from scara_drake.wiring.bilateral import DEVICE_TICKS, FORCE_TICKS, own_latency

SAFE = [Tdpa, PositionDamping, WaveVariables, ModelMediated]
LINKS: dict[str, DelayLaw] = {
    "5 ms": ConstantDelay(0.005),
    "20 ms": ConstantDelay(0.02),
    "50 ms": ConstantDelay(0.05),
    "100 ms": ConstantDelay(0.1),
    "200 ms": ConstantDelay(0.2),
    "0.2 sin t": SineDelay(0.2, 0.0, 1.0),
    "0.1 (1 + sin t)": SineDelay(0.1, 0.1, 1.0),
    "1 + sin t": SineDelay(1.0, 1.0, 1.0),
}


def pressed(coupling: Coupling, link: str, loss: float = 0.0) -> dict[str, float]:
    """Figures of a press of 3 cm on the full arm: forces [N], drift after the release [m]."""
    delay = LINKS[link]
    carrier: Link = Packets(delay=delay, loss=Loss(in_good=loss)) if loss > 0.0 else delay
    result = Arm(coupling, Channel(up=carrier, down=carrier)).run(14.0)
    tool = result["motion_limited"][:, :3] - result["motion_limited"][0, :3]
    apart = np.linalg.norm(result["motion_master"][:, :3] - tool, axis=1)
    return {
        "peak": np.linalg.norm(result["f_master"], axis=1).max(),
        "wall": np.linalg.norm(result["f_env_on_tool_W"], axis=1).max(),
        "drift": apart[-500:].max(),
    }


def check(coupling: Coupling, link: str, limit: float, loss: float = 0.0) -> None:
    figures = pressed(coupling, link, loss)
    assert figures["wall"] > 2.0  # it did touch
    assert figures["peak"] < limit
    assert figures["drift"] < 1e-3


@pytest.mark.parametrize("kind", SAFE)
def test_the_arm_presses_and_lets_go_over_100_ms(kind: type[Coupling]) -> None:
    check(kind(), "100 ms", 40.0)


def test_without_a_coupling_the_arm_is_thrown_off_the_wall() -> None:
    assert pressed(Direct(), "5 ms")["peak"] > 100.0


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.0, 0.1])
@pytest.mark.parametrize("link", LINKS)
def test_tdpa_at_every_delay(link: str, loss: float) -> None:
    check(Tdpa(), link, 40.0, loss)
    check(Tdpa(force_scale=0.1), link, 10.0, loss)


@pytest.mark.slow
@pytest.mark.parametrize("link", LINKS)
def test_direct_at_every_delay(link: str) -> None:
    assert pressed(Direct(), link)["peak"] > 100.0


@pytest.mark.parametrize("bandwidth", [100.0, 400.0])
def test_the_loop_is_as_late_as_it_says(bandwidth: float) -> None:
    arm = Arm(Direct(), Channel(up=ConstantDelay(0.0), down=ConstantDelay(0.0)))
    arm.inverse_kinematics.bandwidth = bandwidth
    arm.master.times, arm.master.targets = [0.1, 1.5], [[0.0, 0.0, 0.0], [0.0, -0.04, 0.0]]
    result = arm.run(1.6)
    touched = np.flatnonzero(abs(result["f_env_on_tool_W"][:, 1]) > 0.0)[0]
    shown = np.flatnonzero(abs(result["f_master"][:, 1]) > 0.0)[0]
    assert shown - touched == FORCE_TICKS
    # Before the touch, the tool is behind the device by lag times speed.
    device, tool = result["motion_master"][:touched], result["motion_limited"][:touched]
    behind = device[:, 1] - (tool[:, 1] - tool[0, 1])
    lag = float(behind @ device[:, 4] / (device[:, 4] @ device[:, 4]))
    scenario = Scenario(inverse_kinematics=arm.inverse_kinematics)
    expected = own_latency(scenario) - 1e-3 * (FORCE_TICKS + DEVICE_TICKS)
    # A motion that speeds up and slows down is followed a little sooner than a steady one.
    assert lag == pytest.approx(expected, rel=0.07)


def test_motion_limited_is_the_motion_of_the_references() -> None:
    result = Arm(Tdpa(), Channel(up=ConstantDelay(0.02), down=ConstantDelay(0.02))).run(2.0)
    motion = result["motion_limited"]
    np.testing.assert_allclose(
        np.diff(motion[:, :3], axis=0) / 1e-3, motion[1:, 3:], atol=2e-4, rtol=1e-2
    )
    assert abs(motion[:, 3:]).max() > 0.02


def test_a_cloned_context_goes_on_bit_for_bit() -> None:
    arm = Arm(Tdpa(), Channel(up=Packets(loss=Loss(in_good=0.1)), down=ConstantDelay(0.05)))
    diagram = arm.diagram(log=False)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.8)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(2.1)
    again = Simulator(diagram, clone)
    again.AdvanceTo(2.1)
    first, second = (
        diagram.GetSubsystemByName("coupling_slave").GetMyContextFromRoot(s.get_context())
        for s in (simulator, again)
    )
    for group in range(first.num_discrete_state_groups()):
        one, two = (c.get_discrete_state(group).value() for c in (first, second))
        assert one.tobytes() == two.tobytes()
    assert math.isfinite(one.sum())

from __future__ import annotations

import math

import numpy as np
import pytest
from coupling_rig import E_IN_M, E_OUT_M, F_APPLIED, X_M, Rig
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import outputs, ports, tick

from scara_drake.common.fields import check
from scara_drake.common.motion import limit_motion
from scara_drake.coupling.direct import Direct, ScaledForce
from scara_drake.coupling.ends import Coupling
from scara_drake.coupling.four_channel import FourChannel
from scara_drake.coupling.kernels import admit, meter, receive, slave_tick
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.tdpa import UP, Tdpa
from scara_drake.coupling.wave_variables import WaveVariables

KINDS = [Direct, ScaledForce, PositionDamping, FourChannel, WaveVariables, Tdpa, ModelMediated]
FIRST = np.array([0.8, -1.04, 3.0, 1.0, 0.0, 0.0, 0.0, 3.0])


def test_the_newest_packet_is_kept_whatever_the_order() -> None:
    newest = np.zeros(2)
    order = [3.0, 1.0, 2.0, 5.0, 5.0, 4.0]
    progress = [receive(np.array([n, 10.0 * n]), newest) for n in order]
    assert progress == [3.0, 0.0, 0.0, 2.0, 0.0, 0.0]
    assert newest.tolist() == [5.0, 50.0]


def test_a_meter_never_falls() -> None:
    energy = np.zeros(6)
    for work in (1.0, -3.0, 2.0):
        meter(energy, 1, work)
    assert energy.tolist() == [0.0, 3.0, 0.0, 0.0, 3.0, 0.0]


@settings(deadline=None, max_examples=50)
@given(
    force=st.floats(-5.0, 5.0),
    speed=st.floats(-0.1, 0.1),
    bandwidth=st.floats(20.0, 200.0),
    mass=st.floats(0.5, 5.0),
)
def test_the_limiter_moves_as_the_virtual_mass(
    force: float, speed: float, bandwidth: float, mass: float
) -> None:
    # Through the limiter of the inverse kinematics, the tool accelerates by f / M.
    coupling = PositionDamping(virtual_mass=mass)
    end = coupling.make_slave(1e-3, np.zeros(8), bandwidth).declaration
    constants, memory = end.parameters["constants"], np.array(end.memory["memory"].initial)
    packet = np.zeros(coupling.exchange().up_size)
    x, rate = np.zeros(3), np.array([speed, 0.0, 0.0])
    command, speeds = np.zeros(3), []
    command[0] = 1e-3 * speed + 2.0 / bandwidth * speed
    for _ in range(20):
        motion = np.concatenate([x, rate])
        was = command.copy()
        at = slave_tick(packet, np.zeros(3), motion, constants, memory, packet.copy())
        admit(0, force, at, command)
        limit_motion(was - x, rate, 10.0, 1e3, bandwidth, 1e-3)
        x += 1e-3 * rate
        speeds.append(rate[0])
    assert np.diff(speeds)[12:] == pytest.approx(1e-3 * force / mass, rel=0.05, abs=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_ends_fit_together(kind: type[Coupling]) -> None:
    coupling = kind()
    master, slave = coupling.make_master(1e-3), coupling.make_slave(1e-3, FIRST)
    inputs, made = ports(master)
    far_inputs, far_made = ports(slave)
    assert made["packet_to_slave"] == far_inputs["packet_from_master"]
    assert far_made["packet_to_master"] == inputs["packet_from_slave"]
    assert (made["f_master"], made["energy_master"]) == (3, 6)
    assert (far_made["tool_command"], far_made["energy_slave"]) == (8, 6)
    assert (far_inputs["f_env_on_tool_W"], far_inputs["motion_limited"]) == (3, 6)


@pytest.mark.parametrize("kind", KINDS)
def test_at_rest_everything_rests(kind: type[Coupling]) -> None:
    coupling = kind()
    exchange = coupling.exchange()
    slave, master = coupling.make_slave(1e-3, FIRST), coupling.make_master(1e-3)
    context = slave.CreateDefaultContext()
    slave.GetInputPort("packet_from_master").FixValue(context, np.zeros(exchange.up_size))
    slave.GetInputPort("f_env_on_tool_W").FixValue(context, np.zeros(3))
    slave.GetInputPort("motion_limited").FixValue(context, [*FIRST[:3], 0.0, 0.0, 0.0])
    for _ in range(5):
        tick(slave, context)
    np.testing.assert_allclose(slave.GetOutputPort("tool_command").Eval(context), FIRST)
    context = master.CreateDefaultContext()
    master.GetInputPort("motion_master").FixValue(context, np.zeros(6))
    master.GetInputPort("packet_from_slave").FixValue(context, np.zeros(exchange.down_size))
    tick(master, context)
    assert outputs(master, context)[1:].tolist() == [0.0] * (outputs(master, context).size - 1)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_scales_are_those_of_way_and_force(kind: type[Coupling], scale: float) -> None:
    # At 10 mm of the master and no delay the tool is at scale times that, in free space.
    rig = Rig(wall=-9.0)
    rig.master.times, rig.master.targets = [1.0], [[0.0, -0.01, 0.0]]
    coupling = kind(position_scale=scale, force_scale=0.2)
    result = rig.run(coupling, 0.0, 0.0, 6.0)
    assert result[-1, 3] == pytest.approx(-0.01 * scale, abs=5e-5 * scale)


@pytest.mark.parametrize("kind", KINDS)
def test_the_meter_at_the_device_is_the_work_of_its_force(kind: type[Coupling]) -> None:
    result = Rig().run(kind(), 0.02, 0.02, 4.0)
    steps = np.diff(result[:, X_M], prepend=0.0)
    work = np.cumsum(result[:, F_APPLIED] * steps)
    # The meter reads the device one tick later.
    metered = result[:, E_IN_M] - result[:, E_OUT_M]
    np.testing.assert_allclose(metered[1:], work[:-1], atol=1e-9)


def test_a_packet_that_is_not_finite_stops_the_run() -> None:
    system = Tdpa().make_slave(1e-3, FIRST)
    system.set_name("coupling_slave")
    context = system.CreateDefaultContext()
    system.GetInputPort("packet_from_master").FixValue(context, np.zeros(1 + UP.size))
    system.GetInputPort("f_env_on_tool_W").FixValue(context, [0.0, math.nan, 0.0])
    system.GetInputPort("motion_limited").FixValue(context, np.zeros(6))
    with pytest.raises(RuntimeError, match=r"slave: port 'f_env_on_tool_W' .*\[1\] is nan"):
        tick(system, context)


@pytest.mark.parametrize("kind", KINDS)
def test_wrong_fields_are_named(kind: type[Coupling]) -> None:
    check(kind(), "coupling")
    with pytest.raises(ValueError, match=r"c\.force_scale: 0\.0, allowed 1e-06 to 100"):
        check(kind(force_scale=0.0), "c")
    with pytest.raises(ValueError, match=r"c\.virtual_mass: nan, allowed"):
        check(kind(virtual_mass=math.nan), "c")

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from leaf import ports, tick
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from scara_drake.common.fields import check
from scara_drake.operator.hand import Sweep, hand_target_at
from scara_drake.operator.master import Master, SimulatedMaster, move_device

PERIOD = 1e-3


def moved(master: Master, forces: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Motion (n, 2) of the x axis under forces (n,) and the hand's targets (n + 1,)."""
    motion, target, f_hand = np.zeros(6), np.zeros(3), np.zeros(3)
    target[0] = targets[0]
    device = master.parameters(PERIOD)
    rows = []
    for force, after in zip(forces, targets[1:], strict=True):
        f_master, target_next = np.array([force, 0.0, 0.0]), np.array([after, 0.0, 0.0])
        move_device(device, f_master, target_next, motion, target, f_hand)
        rows.append(motion[[0, 3]].copy())
    return np.array(rows)


@settings(deadline=None, max_examples=30)
@given(
    mass=st.floats(0.1, 5.0),
    damping=st.floats(0.0, 10.0),
    stiffness=st.floats(1.0, 10000.0),
    force=st.floats(-20.0, 20.0),
)
def test_a_constant_force_gives_the_closed_form(
    mass: float, damping: float, stiffness: float, force: float
) -> None:
    master = Master(mass=mass, damping=damping, hand_stiffness=stiffness, hand_damping=1.0)
    n = 300
    motion = moved(master, np.full(n, force), np.zeros(n + 1))
    # x = x_end (1 - Re[...]) with the roots of m s^2 + b s + K.
    b = damping + 1.0
    r1, r2 = np.roots(np.array([mass, b, stiffness], dtype=complex))
    if abs(r1 - r2) < 1e-3 * abs(r1):
        return
    t = PERIOD * np.arange(1, n + 1)
    end = -force / stiffness
    x = end * (1.0 + (r2 * np.exp(r1 * t) - r1 * np.exp(r2 * t)) / (r1 - r2)).real
    np.testing.assert_allclose(motion[:, 0], x, atol=1e-9 + 1e-7 * abs(end))


def test_a_moving_target_is_followed_as_the_law_says() -> None:
    # A ramp of the target: steady lag of v b_device / K, as the hand's damper moves with it.
    master = Master(damping=3.0, hand_stiffness=150.0)
    targets = 0.1 * PERIOD * np.arange(4001)
    motion = moved(master, np.zeros(4000), targets)
    assert targets[-1] - motion[-1, 0] == pytest.approx(0.1 * 3.0 / 150.0, rel=1e-6)
    assert motion[-1, 1] == pytest.approx(0.1, rel=1e-6)


def test_no_energy_appears_by_integration() -> None:
    # A free device without friction and hand: the work on it is its kinetic energy, to rounding.
    master = Master(damping=0.0, hand_stiffness=0.0, hand_damping=0.0, actuator_limit=1e6)
    forces = np.random.default_rng(0).normal(0.0, 100.0, 5000)
    motion = moved(master, forces, np.zeros(5001))
    steps = np.diff(motion[:, 0], prepend=0.0)
    work = np.cumsum(-forces * steps)
    np.testing.assert_allclose(work, 0.5 * master.mass * motion[:, 1] ** 2, rtol=1e-8, atol=1e-9)
    # A very stiff hand does not gain energy: m v^2 + K x^2 is kept without friction.
    stiff = Master(damping=0.0, hand_stiffness=1e4, hand_damping=0.0)
    motion = moved(stiff, np.array([30.0] + [0.0] * 20000), np.zeros(20002))
    energy = 0.5 * stiff.mass * motion[:, 1] ** 2 + 0.5e4 * motion[:, 0] ** 2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)


def test_the_actuators_saturate() -> None:
    strong, weak = (
        moved(Master(actuator_limit=f), np.full(9, 50.0), np.zeros(10)) for f in (50, 5)
    )
    np.testing.assert_allclose(strong, 10.0 * weak, rtol=1e-12)


def target_at(master: Master, t: float) -> np.ndarray:
    target = np.empty(3)
    hand_target_at(t, master.waypoints(), master.sweep.parameters(), target)
    return target


def test_the_hand_goes_from_target_to_target_with_minimum_jerk() -> None:
    master = Master(times=[1.0, 3.0, 4.0], targets=[[0, 0, 0], [0.1, 0, -0.2], [0.1, 0, -0.2]])
    assert not target_at(master, 0.5).any()
    for t, share in ((1.0, 0.0), (2.0, 0.5), (1.5, 0.103515625), (3.0, 1.0), (99.0, 1.0)):
        np.testing.assert_allclose(target_at(master, t), share * np.array([0.1, 0.0, -0.2]))
    # A first target of later is reached from the centre, from t = 0 on.
    early = Master(times=[2.0], targets=[[0.1, 0.0, 0.0]])
    assert target_at(early, 1.0)[0] == pytest.approx(0.05)
    assert not target_at(early, 0.0).any()


def test_a_sweep_rises_from_its_low_to_its_high_frequency() -> None:
    sweep = Sweep(axis=2, amplitude=0.01, low=0.5, high=5.0, start=1.0, duration=40.0)
    master = Master(times=[], targets=[], sweep=sweep)
    t = np.arange(0.0, 45.0, 1e-3)
    z = np.array([target_at(master, s)[2] for s in t])
    crossings = t[1:][np.diff(np.sign(z)) > 0]
    half = 1.0 / np.diff(crossings)
    middle = math.sqrt(0.5 * 5.0)  # exponential: the geometric mean in the middle
    index = np.searchsorted(crossings, 21.0)
    assert half[index] == pytest.approx(middle, rel=0.05)
    assert half[-1] == pytest.approx(5.0, rel=0.05)
    assert abs(z).max() == pytest.approx(0.01, rel=1e-3)
    assert not z[t < 1.0].any()
    assert not z[t > 41.0].any()
    plain = Sweep(amplitude=0.01, low=2.0, high=2.0, duration=10.0)
    master = Master(times=[], targets=[], sweep=plain)
    assert target_at(master, 5.125)[1] == pytest.approx(0.01)


def test_ports_and_one_tick() -> None:
    system = SimulatedMaster(Master())
    assert ports(system) == (
        {"f_master": 3},
        {"motion_master": 6, "hand_target": 3, "f_hand": 3},
    )
    context = system.CreateDefaultContext()
    system.get_input_port().FixValue(context, [3.0, 0.0, 0.0])
    tick(system, context)
    x, v = system.GetOutputPort("motion_master").Eval(context)[[0, 3]]
    assert v == pytest.approx(-3.0 / 0.3 * PERIOD, rel=0.02)
    f_hand = system.GetOutputPort("f_hand").Eval(context)[0]
    assert f_hand == pytest.approx(-150.0 * x - 4.0 * v)


def test_a_cloned_context_goes_on_bit_for_bit() -> None:
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource(np.array([1.0, -2.0, 0.5])))
    master = builder.AddSystem(SimulatedMaster(Master()))
    builder.Connect(source.get_output_port(), master.get_input_port())
    builder.ExportOutput(master.GetOutputPort("motion_master"))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.2)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(2.0)
    again = Simulator(diagram, clone)
    again.AdvanceTo(2.0)
    first, second = (s.get_context() for s in (simulator, again))
    port = diagram.get_output_port()
    assert port.Eval(first).tobytes() == port.Eval(second).tobytes()


def test_a_force_that_is_not_finite_stops_the_run() -> None:
    system = SimulatedMaster(Master())
    system.set_name("master")
    context = system.CreateDefaultContext()
    system.get_input_port().FixValue(context, [0.0, math.nan, 0.0])
    with pytest.raises(RuntimeError, match=r"master: port 'f_master' .* f_master\[1\] is nan"):
        tick(system, context)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"mass": 0.0}, "m.mass: 0.0, allowed 0.01 to 100"),
        ({"times": [1.0]}, "m.times: 1 entries, allowed 4"),
        ({"times": [1.0, 1.0, 2.0, 3.0]}, r"m.times\[1\]: 1.0, allowed above 1"),
        ({"targets": [[0.0, 0.0]] * 4}, r"m.targets\[0\]: 2 entries, allowed 3"),
        ({"targets": [[0.0, 0.0, 9.0]] * 4}, r"m.targets\[0\]\[2\]: 9.0, allowed -2"),
        ({"sweep": Sweep(axis=3)}, "m.sweep.axis: '3', allowed 0, 1, 2"),
        ({"sweep": Sweep(low=2.0, high=1.0)}, "m.sweep.high: 1.0, allowed 2 to 100"),
        ({"hand_stiffness": math.inf}, "m.hand_stiffness: inf, allowed 0 to 10000"),
    ],
)
def test_wrong_fields_are_named(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check(Master(**fields), "m")

"""The device in a hand: Coulomb friction, the ends of the workspace, and what the encoders show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.common.fields import check
from scara_drake.operator.device_encoder import DeviceEncoder, show_motion
from scara_drake.operator.kinesthetic_devices import DEVICES, OWN
from scara_drake.operator.master import Master, move_device

PERIOD = 1e-3
FREE = Master(damping=0.0, hand_stiffness=0.0, hand_damping=0.0, actuator_limit=1e6)


def moved(
    master: Master, forces: np.ndarray, targets: np.ndarray, start: float = 0.0, v: float = 0.0,
    period: float = PERIOD,
) -> np.ndarray:  # fmt: skip
    """Motion (n + 1, 2) of the y axis under forces (n,) and the hand's targets (n + 1,)."""
    device = master.parameters(period)
    motion, target, f_hand = np.array([0, start, 0, 0, v, 0.0]), np.zeros(3), np.zeros(3)
    target[1] = targets[0]
    rows = [motion[[1, 4]].copy()]
    for force, after in zip(forces, targets[1:], strict=True):
        nxt = np.array([0.0, after, 0.0])
        move_device(device, np.array([0.0, force, 0.0]), nxt, motion, target, f_hand)
        rows.append(motion[[1, 4]].copy())
    return np.array(rows)


def test_friction_holds_up_to_its_force_and_not_beyond() -> None:
    stuck = replace(FREE, friction=0.26, mass=0.045)
    held = moved(stuck, np.full(500, 0.2599), np.zeros(501))
    assert not held.any()
    pushed = moved(stuck, np.full(500, -0.2601), np.zeros(501))
    t = PERIOD * np.arange(501)
    np.testing.assert_allclose(pushed[:, 0], 0.5 * 1e-4 / 0.045 * t**2, rtol=1e-9, atol=1e-15)


def test_a_device_that_slides_stops_where_the_friction_has_its_energy() -> None:
    # Within a tick, too: 0.5 m v^2 / f_c of way, and then rest to the last bit.
    rough = replace(FREE, friction=0.5, mass=0.1)
    slid = moved(rough, np.zeros(200), np.zeros(201), v=0.7712)
    end = 0.5 * 0.1 * 0.7712**2 / 0.5
    stop = math.ceil(0.1 * 0.7712 / 0.5 / PERIOD)
    np.testing.assert_allclose(slid[stop:, 0], end, rtol=1e-12)
    assert not slid[stop:, 1].any()
    assert (slid[: stop - 1, 1] > 0.0).all()


def test_a_swing_on_the_spring_loses_the_same_way_each_half_period() -> None:
    # Dry friction alone: each turn is 2 f_c / K nearer, until it rests within f_c / K.
    spring = replace(FREE, hand_stiffness=200.0, friction=0.3, mass=0.2)
    swung = moved(spring, np.zeros(3000), np.zeros(3001), start=0.02)
    turns, step = [0.02], 2.0 * 0.3 / 200.0
    while abs(turns[-1]) > 0.3 / 200.0:
        turns.append(-math.copysign(1.0, turns[-1]) * (abs(turns[-1]) - step))
    half = math.pi * math.sqrt(0.2 / 200.0)
    for k, turn in enumerate(turns[1:-1], 1):
        index = round(k * half / PERIOD)
        assert swung[index, 0] == pytest.approx(turn, abs=3e-6)
    np.testing.assert_allclose(swung[-500:, 0], turns[-1], rtol=1e-9)
    assert not swung[-500:, 1].any()


def test_a_hand_pulls_a_device_off_when_its_spring_has_the_friction() -> None:
    rough = replace(FREE, hand_stiffness=150.0, friction=0.26, mass=0.045)
    speed = 0.0137  # [m/s] of the target; the spring has 0.26 N after 0.26 / (150 speed)
    off = 0.26 / (150.0 * speed)
    n = 300
    motion = moved(rough, np.zeros(n), speed * PERIOD * np.arange(n + 1))
    first = math.ceil(off / PERIOD)
    assert not motion[:first].any()
    omega = math.sqrt(150.0 / 0.045)
    t = PERIOD * np.arange(first, n + 1) - off
    expected = speed * (t - np.sin(omega * t) / omega)
    np.testing.assert_allclose(motion[first:, 0], expected, rtol=1e-7, atol=1e-13)


@examples(40)
@given(seed=st.integers(0, 2**32 - 1), friction=st.floats(1e-3, 5.0), mass=st.floats(0.01, 2.0))
def test_friction_never_gives_energy(seed: int, friction: float, mass: float) -> None:
    random = np.random.default_rng(seed)
    forces = random.normal(0.0, 2.0 * friction, 400).repeat(random.integers(1, 4))
    rough = replace(FREE, friction=friction, mass=mass)
    motion = moved(rough, forces, np.zeros(forces.size + 1), v=random.normal())
    ways = np.diff(motion[:, 0])
    taken = -forces * ways - np.diff(0.5 * mass * motion[:, 1] ** 2)
    scale = 1e-12 + 1e-9 * np.abs(forces * ways).max()
    assert (taken >= friction * np.abs(ways) - scale).all()
    # And no more than that, where it does not turn round.
    along = (motion[:-1, 1] * motion[1:, 1] > 0.0) & (motion[1:, 1] * ways > 0.0)
    np.testing.assert_allclose(taken[along], friction * np.abs(ways[along]), atol=scale)


@examples(40)
@given(
    seed=st.integers(0, 2**32 - 1),
    friction=st.floats(1e-3, 3.0),
    mass=st.floats(0.02, 1.0),
    stiffness=st.floats(0.0, 1e4),
    damping=st.floats(0.0, 50.0),
)
def test_a_period_is_as_exact_as_ten_of_a_tenth(
    seed: int, friction: float, mass: float, stiffness: float, damping: float
) -> None:
    random = np.random.default_rng(seed)
    rough = replace(
        FREE, friction=friction, mass=mass, hand_stiffness=stiffness, hand_damping=damping
    )
    n = 60
    forces = random.normal(0.0, 3.0 * friction, n)
    targets = np.concatenate([[0.0], np.cumsum(random.normal(0.0, 2e-4, n))])
    fine = np.interp(np.arange(10 * n + 1) / 10.0, np.arange(n + 1), targets)
    coarse = moved(rough, forces, targets)
    steps = moved(rough, forces.repeat(10), fine, period=0.1 * PERIOD)[::10]
    np.testing.assert_allclose(coarse, steps, rtol=1e-6, atol=1e-10)


def test_without_friction_nothing_is_changed_and_a_trace_of_it_changes_little() -> None:
    plain = Master()
    targets = 0.01 * np.sin(np.arange(501) * 0.02)
    forces = np.cos(np.arange(500) * 0.05)
    smooth = moved(plain, forces, targets)
    np.testing.assert_allclose(
        moved(replace(plain, friction=1e-9), forces, targets), smooth, atol=1e-9
    )


def test_the_workspace_ends_and_lets_go_at_once() -> None:
    small = replace(FREE, workspace=0.01, mass=0.1)
    forces = np.concatenate([np.full(200, -1.0), np.full(20, 1.0)])
    motion = moved(small, forces, np.zeros(221))
    assert motion[:, 0].max() == 0.01
    assert not motion[100:200, 1].any()
    np.testing.assert_allclose(motion[-1], [0.01 - 0.5 * 10.0 * 0.02**2, -10.0 * 0.02], rtol=1e-9)


def encoder_of(master: Master) -> np.ndarray:
    parameters: np.ndarray = DeviceEncoder(master, PERIOD).declaration.parameters["encoder"]
    return parameters


def test_the_encoder_shows_the_nearest_count_and_its_rate() -> None:
    touch = Master(device="touch", velocity_bandwidth=1e5)
    encoder, shown = encoder_of(touch), np.zeros(6)
    for k in range(200):
        motion = np.array([1e-4 * k, 2e-5 * math.sin(0.1 * k), -0.3e-5 * k, 0.0, 0.0, 0.0])
        before = shown.copy()
        show_motion(motion, encoder, before, shown)
        assert (abs(shown[:3] - motion[:3]) <= 0.5 * 5.5e-5 + 1e-12).all()
        np.testing.assert_allclose(shown[:3] / 5.5e-5, np.rint(shown[:3] / 5.5e-5), atol=1e-9)
        np.testing.assert_allclose(shown[3:], (shown[:3] - before[:3]) / PERIOD, atol=1e-12)
    slow = replace(touch, velocity_bandwidth=50.0)
    encoder, shown = encoder_of(slow), np.zeros(6)
    for k in range(400):
        show_motion(np.full(6, 5.5e-5 * k), encoder, shown.copy(), shown)
    assert shown[3] == pytest.approx(0.055, rel=1e-6)


@pytest.mark.parametrize("name", DEVICES)
def test_a_named_device_has_its_own_figures(name: str) -> None:
    made = Master(device=name)
    check(made, "operator")
    device = made.hardware()
    assert device == DEVICES[name]
    assert all(
        device.source_of(figure)
        for figure in ("force", "stiffness", "damping", "workspace", "mass", "friction")
    )
    motion = moved(made, np.full(4, 1e6), np.zeros(5))
    pushed = replace(made, device=OWN, mass=device.mass, damping=device.viscous,
        friction=device.friction, actuator_limit=device.force)  # fmt: skip
    np.testing.assert_array_equal(motion, moved(pushed, np.full(4, 1e6), np.zeros(5)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"device": "tuch"}, r"operator\.device: 'tuch', allowed own, touch, .*"),
        (
            {"device": "touch", "mass": 0.5},
            r"operator\.mass: 0\.5, allowed with device: own .*",
        ),
        ({"device": "touch", "friction": 1.0}, r"operator\.friction: 1\.0, allowed with device.*"),
        (
            {"device": "touch", "targets": [[0.0, -0.08, 0.0]], "times": [1.0]},
            r"operator\.targets\[0\]: 0\.08 m from the centre .*, allowed up to 0\.075 m, .*",
        ),
        ({"workspace": 0.03}, r"operator\.targets\[1\]: 0\.04 m from .*, allowed up to 0\.03 m.*"),
        ({"friction": -1.0}, r"operator\.friction: -1.*, allowed .*"),
        ({"resolution": 1.0}, r"operator\.resolution: 1.*, allowed .*"),
    ],
)
def test_what_does_not_fit_the_device_is_said_in_one_line(changes: dict, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$") as told:
        check(Master(**changes), "operator")
    assert "\n" not in str(told.value)

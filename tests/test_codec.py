"""The dead-band codec: what it sends, and that no energy comes of what it does not send."""

from __future__ import annotations

import math

import numpy as np
import pytest
from coupling_rig import (
    E_IN_M,
    E_OUT_M,
    E_OUT_S,
    F_M,
    PERIOD,
    RX_M,
    RX_S,
    SENT_DOWN,
    SENT_UP,
    X_M,
    X_S,
    Rig,
    energy_left,
)
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import examples
from strategies.channels import Conditions, conditions
from strategies.hands import hands

from scara_drake import load_scenario
from scara_drake.channel.codec import Codec, DeadBand, ask, encode, step_codec
from scara_drake.coupling import tdpa, wave_variables
from scara_drake.coupling.ends import Coupling
from scara_drake.coupling.layouts import METERS
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.operator.master import Master

FELT, SIZE = ((slice(1, 4), "speed"),), 5  # a number, three velocities, and a sum
DURATION = 2.0
STEPS = round(DURATION / PERIOD)


def coded(
    config: DeadBand, packets: np.ndarray, send_period: float = PERIOD
) -> tuple[np.ndarray, np.ndarray]:
    """Which of some packets (ticks, SIZE) are sent (ticks,), and as what (ticks, SIZE)."""
    is_ = Codec(config, "up", FELT, SIZE, PERIOD, send_period).declaration
    memory, given = np.array(is_.memory["sent"].initial), dict(is_.parameters)
    transmit, packet = np.zeros(1), np.zeros(SIZE)
    asked, sent = np.zeros(len(packets), dtype=bool), np.zeros_like(packets)
    for k, one in enumerate(packets):
        ask(one, **given, sent=memory, transmit=transmit)
        encode(one, given["bands"], memory, packet)
        step_codec(one, **given, sent=memory)
        asked[k], sent[k] = transmit[0] > 0.5, packet
    return asked, sent


def packets_of(velocity: np.ndarray) -> np.ndarray:
    """Packets (ticks, SIZE) with a velocity (ticks,) on one axis."""
    made = np.zeros((velocity.size, SIZE))
    made[:, 0] = np.arange(velocity.size)
    made[:, 2] = velocity
    made[:, 4] = np.cumsum(velocity**2)
    return made


@examples(50)
@given(
    k=st.floats(0.0, 0.5),
    speed=st.floats(1e-4, 0.1),
    keep_alive=st.integers(1, 60),
    size=st.floats(1e-3, 1.0),
    seed=st.integers(0, 2**31),
)
def test_what_the_receiver_has_is_within_the_band(
    k: float, speed: float, keep_alive: int, size: float, seed: int
) -> None:
    packets = np.zeros((400, SIZE))
    steps = np.random.default_rng(seed).normal(size=(400, 4)) * size
    packets[:, 1:] = np.cumsum(steps, axis=0)
    config = DeadBand(k_up=k, speed=speed, keep_alive=keep_alive * PERIOD)
    asked, sent = coded(config, packets)
    assert asked[0]
    assert np.diff(np.flatnonzero(asked)).max(initial=0) <= keep_alive
    known = np.zeros(SIZE)
    for k_now, packet in enumerate(packets):
        band = max(k * float(np.linalg.norm(known[1:4])), speed)
        off = float(np.linalg.norm(packet[1:4] - known[1:4]))
        assert asked[k_now] or off <= band
        if asked[k_now]:
            known = sent[k_now]
            assert np.linalg.norm(packet[1:4] - known[1:4]) <= band + 1e-12
            assert known[0] == packet[0]
            assert known[4] == packet[4]  # the sum is sent as it is


@pytest.mark.parametrize("k", [0.05, 0.1, 0.2, 0.4])
def test_a_decay_is_sent_once_for_each_share_k(k: float) -> None:
    # From 1 to 1e-3 by steps of less than a thousandth: ln(1000) / -ln(1 - k) packets.
    velocity = np.exp(-np.arange(20_000) * math.log(1e3) / 20_000)
    asked, _ = coded(DeadBand(k_up=k, speed=1e-6, keep_alive=10.0), packets_of(velocity))
    expected = math.log(1e3) / -math.log(1.0 - k)
    # A packet is sent when the bound has been passed, up to a tick late, and the first is sent too.
    assert expected * 0.985 <= asked.sum() <= expected + 2


@pytest.mark.parametrize("keep_alive", [0.01, 0.05, 0.25])
def test_noise_below_the_floor_sends_keep_alives_only_and_those_are_zero(keep_alive: float) -> None:
    noise = 5e-4 * np.random.default_rng(1).uniform(-1.0, 1.0, 1000)
    asked, sent = coded(DeadBand(speed=1e-3, keep_alive=keep_alive), packets_of(noise))
    assert asked.sum() == math.ceil(1.0 / keep_alive)
    assert not sent[:, 1:4].any()


def test_what_is_not_felt_on_an_axis_is_not_sent_with_another() -> None:
    packets = packets_of(np.linspace(0.0, 1.0, 200))
    packets[:, 3] = 5e-4 * np.sin(np.arange(200))
    asked, sent = coded(DeadBand(), packets)
    assert asked.sum() > 10
    assert not sent[:, 3].any()


def test_nothing_is_asked_for_between_the_packets_of_a_link() -> None:
    asked, _ = coded(DeadBand(k_up=0.0, keep_alive=0.02), packets_of(np.arange(100.0)), 5e-3)
    assert np.flatnonzero(asked).tolist() == list(range(0, 100, 5))
    # A keep-alive is sent with the last packet that is not too late.
    asked, _ = coded(DeadBand(keep_alive=0.018), packets_of(np.ones(100)), 5e-3)
    assert np.diff(np.flatnonzero(asked)).tolist() == [15] * 6


def test_a_sample_that_is_not_sent_keeps_its_energy() -> None:
    rig = Rig(codec=DeadBand())
    result = rig.run(Tdpa(), 0.0, 0.0, 8.0, tdpa.UP.slices["e_in"], tdpa.DOWN.slices["e_in"])
    sent = result[:, SENT_UP] > 0.5
    assert 0.02 < sent.mean() < 0.2
    # The packet of tick k is on the port at k + 1: what came in over all the ticks until then.
    newest = np.maximum.accumulate(np.where(sent, np.arange(sent.size), -1))
    told = np.where(newest >= 0, result[newest, E_IN_M], 0.0)
    np.testing.assert_array_equal(result[1:, RX_S], told[:-1])
    assert result[-1, RX_S] > 0.02
    assert result[-1, E_IN_M] - result[-1, RX_S] < 1e-6  # at rest nothing is left untold


@examples(200)
@given(
    hand=hands(DURATION),
    up=conditions(0.4),
    down=conditions(0.4),
    k_up=st.floats(0.0, 0.5),
    k_down=st.floats(0.0, 0.5),
    keep_alive=st.sampled_from([0.005, 0.05, 0.5]),
    reserve=st.floats(0.005, 0.1),
)
def test_tdpa_gives_no_more_than_the_receiver_knows_of(
    hand: Master,
    up: Conditions,
    down: Conditions,
    k_up: float,
    k_down: float,
    keep_alive: float,
    reserve: float,
) -> None:
    rig = Rig(master=hand, codec=DeadBand(k_up, k_down, keep_alive=keep_alive))
    coupling = Tdpa(reserve=reserve)
    result = rig.run(
        coupling, up.shown(STEPS), down.shown(STEPS), DURATION, tdpa.UP.slices["e_in"],
        tdpa.DOWN.slices["e_in"],
    )  # fmt: skip
    # The bound is for hands of that kind.
    assume(abs(np.diff(result[:, X_M], 2)).max() < coupling.turn * PERIOD**2)
    arrived_s = np.maximum.accumulate(result[:, RX_S])
    arrived_m = np.maximum.accumulate(result[:, RX_M])
    assert np.all(result[:, E_OUT_S] <= arrived_s + reserve + 1e-12)
    assert np.all(result[:, E_OUT_M] <= arrived_m + reserve + 1e-12)
    # What it knows of has come in, and in truth there is more.
    assert np.all(arrived_s[1:] <= result[:-1, E_IN_M])
    assert energy_left(result).min() + coupling.reserves() >= -1e-12


@examples(40)
@given(
    hand=hands(DURATION),
    up=conditions(0.4),
    down=conditions(0.4),
    k=st.floats(0.0, 0.5),
    reserve=st.floats(0.002, 0.05),
)
def test_waves_are_not_played_twice(
    hand: Master, up: Conditions, down: Conditions, k: float, reserve: float
) -> None:
    rig, coupling = Rig(master=hand, codec=DeadBand(k, k)), WaveVariables(reserve=reserve)
    result = rig.run(coupling, up.shown(STEPS), down.shown(STEPS), DURATION)
    assume(abs(np.diff(result[:, X_M], 2)).max() < coupling.turn * PERIOD**2)
    assert energy_left(result).min() + coupling.reserves() >= -1e-12


def test_a_wave_that_stands_is_played_with_the_energy_that_came_and_no_more() -> None:
    coupling = WaveVariables(drift_gain=0.0)
    end = coupling.make_slave(PERIOD, np.zeros(8), 100.0, hold=1.0).declaration
    constants, memory = end.parameters["constants"], np.array(end.memory["memory"].initial)
    packet = np.zeros(coupling.exchange().up_size)
    packet[0], packet[1], packet[4] = 1.0, 1.0, 0.5 * PERIOD  # one tick of a wave of 1
    command, energy, sent = np.zeros(8), np.zeros(METERS.size), np.zeros(7)
    assert end.update is not None
    for _ in range(100):
        end.update(packet, np.zeros(3), np.zeros(6), constants, memory, sent, command, energy)
    kind = wave_variables.SLAVE_MEMORY.unpack(memory[coupling.exchange().up_size :])
    assert kind.played[0] == pytest.approx(0.5 * PERIOD)


@pytest.mark.parametrize("kind", [Tdpa, ModelMediated])
@pytest.mark.parametrize("hold", [0.0, 0.05])
def test_a_received_velocity_stands_up_to_the_keep_alive(kind: type[Coupling], hold: float) -> None:
    coupling = kind()
    end = coupling.make_slave(PERIOD, np.zeros(8), 400.0, hold).declaration
    constants, memory = end.parameters["constants"], np.array(end.memory["memory"].initial)
    exchange = coupling.exchange()
    packet, (felt, _) = np.zeros(exchange.up_size), exchange.felt("up")[0]
    packet[0], packet[felt.start + 1] = 1.0, 0.1
    motion, sent = np.zeros(6), np.zeros(exchange.down_size)
    command, energy = np.zeros(8), np.zeros(METERS.size)
    speeds: list[float] = []
    assert end.update is not None
    assert exchange.slave_memory is not None
    tool = exchange.up_size + exchange.slave_memory.slices["x_d"].start + 1
    for _ in range(200):
        was = memory[tool]
        motion[1], motion[4] = memory[tool], speeds[-1] if speeds else 0.0  # it follows
        end.update(packet, np.zeros(3), motion, constants, memory, sent, command, energy)
        speeds.append((memory[tool] - was) / PERIOD)
    until = 1 + round(hold / PERIOD)
    assert speeds[:until] == pytest.approx([0.1] * until)
    # Then it fades, with the time constant of 20 ms, and the position is where it was told.
    assert abs(speeds[until + 100]) < 0.02
    assert speeds[until + 3] < 0.1


def test_a_press_needs_a_tenth_of_the_packets_and_is_the_same() -> None:
    every, few = Rig(), Rig(codec=DeadBand())
    full, coded_ = every.run(Tdpa(), 0.1, 0.1), few.run(Tdpa(), 0.1, 0.1)
    assert coded_[:, SENT_UP].mean() < 0.2
    assert coded_[:, SENT_DOWN].mean() < 0.2
    assert full[:, SENT_UP].all()
    held = slice(5000, 6000)
    force = [abs(result[held, F_M]).mean() for result in (full, coded_)]
    assert force[1] == pytest.approx(force[0], rel=0.1)
    assert abs(coded_[-500:, X_M] - coded_[-500:, X_S]).max() < 1e-3


@pytest.mark.parametrize(
    ("scenario", "changes", "said"),
    [
        ("bilateral", {"channel.codec": "{}"}, "channel.codec: set, allowed where channel.up is"),
        (
            "bilateral",
            {"channel.preset": "5g", "channel.codec.k_up": 1.0},
            "channel.codec.k_up: 1.0, allowed 0 to 0.9",
        ),
        (
            "bilateral",
            {"channel.preset": "5g", "channel.codec.speed": 0.0},
            "channel.codec.speed: 0.0, allowed above 0, up to 1",
        ),
        (
            "bilateral",
            {"channel.preset": "5g", "channel.codec.keep_alive": "-1"},
            "channel.codec.keep_alive: -1.0, allowed above 0",
        ),
        (
            "bilateral",
            {"channel.preset": "5g", "channel.codec.keep_alive": "1e-4"},
            "channel.codec.keep_alive: 0.0001 s, allowed from 0.001 s",
        ),
        ("bilateral", {"channel.preset": "5g", "channel.codec.k": 0.1}, "channel.codec.k"),
        (
            "teleoperation",
            {"channel.preset": "5g", "channel.codec": "{}"},
            "channel.codec: set, allowed with a Master only",
        ),
    ],
)
def test_wrong_fields_are_named(scenario: str, changes: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said.replace("[", r"\[")) as told:
        load_scenario(scenario, changes)
    assert "\n" not in str(told.value)

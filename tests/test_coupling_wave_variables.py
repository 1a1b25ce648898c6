from __future__ import annotations

import math

import numpy as np
import pytest
from coupling_rig import (
    F_ENV,
    F_M,
    PERIOD,
    X_M,
    X_S,
    Rig,
    arrivals,
    energy_left,
)
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples
from strategies.channels import Conditions, conditions
from strategies.hands import BRISK, hands, to_and_fro

from scara_drake.common.fields import check
from scara_drake.coupling.layouts import METERS
from scara_drake.coupling.wave_variables import (
    SLAVE_MEMORY,
    UP,
    WaveVariables,
    affordable,
    wave_slave,
)
from scara_drake.operator.master import Master

VARYING = [lambda t: max(0.2 * math.sin(t), 0.0), lambda t: 0.1 * (1.0 + math.sin(t))]


@examples(25)
@given(up=st.floats(0.0, 0.5), down=st.floats(0.0, 0.5), impedance=st.floats(5.0, 40.0))
def test_a_constant_delay_is_passive(up: float, down: float, impedance: float) -> None:
    coupling = WaveVariables(impedance=impedance)
    result = Rig().run(coupling, up, down, 10.0)
    assert energy_left(result).min() + coupling.reserves() >= -1e-12


@examples(60)
@given(
    hand=hands(6.0),
    up=st.one_of(st.just(Conditions()), conditions()),
    down=st.one_of(st.just(Conditions()), conditions()),
    impedance=st.floats(5.0, 40.0),
    limit=st.sampled_from([5.0, 40.0, np.inf]),
    integrals=st.booleans(),
)
def test_it_is_passive_for_brisk_hands_over_any_channel(
    hand: Master,
    up: Conditions,
    down: Conditions,
    impedance: float,
    limit: float,
    integrals: bool,
) -> None:
    coupling = WaveVariables(impedance=impedance, integrals=integrals)
    result = Rig(master=hand, limit=limit).run(coupling, up.shown(6000), down.shown(6000), 6.0)
    assert abs(np.diff(result[:, X_M], 2)).max() < coupling.turn * PERIOD**2
    assert energy_left(result).min() + coupling.reserves() >= -1e-12


@pytest.mark.parametrize("motion", BRISK)
def test_a_brisk_hand_takes_no_more_than_the_reserve_without_delay(
    motion: tuple[float, float],
) -> None:
    result = Rig(master=to_and_fro(*motion, 6.0)).run(WaveVariables(), 0.0, 0.0, 6.0)
    assert energy_left(result).min() + WaveVariables().reserves() >= -1e-12
    assert abs(result[:, F_M]).max() > 3.0  # it is felt


def test_without_delay_and_in_free_space_the_slave_follows() -> None:
    result = Rig(wall=-9.0).run(WaveVariables(), 0.0, 0.0, 6.0)
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-4
    assert abs(result[-500:, F_M]).max() < 0.01


@pytest.mark.parametrize("loss", [0.0, 0.1])
@pytest.mark.parametrize("delay", [*VARYING, 0.2])
def test_varying_delay_and_loss_neither_diverge_nor_drift(delay: float, loss: float) -> None:
    up, down = (arrivals(delay, 16_000, loss, seed) for seed in (1, 2))
    result = Rig().run(WaveVariables(), up, down, 16.0)
    assert abs(result[:, F_M]).max() < 10.0
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() < 1e-3
    assert energy_left(result).min() + WaveVariables().reserves() >= -1e-12


def test_drift_without_the_position_term() -> None:
    up, down = (arrivals(VARYING[0], 16_000, 0.1, seed) for seed in (1, 2))
    result = Rig().run(WaveVariables(drift_gain=0.0), up, down, 16.0)
    assert abs(result[-500:, X_M] - result[-500:, X_S]).max() > 5e-3


def test_with_integrals_what_was_lost_in_between_is_not_lost_for_ever() -> None:
    up, down = (arrivals(0.02, 16_000, 0.1, seed) for seed in (1, 2))
    left = {}
    for integrals in (False, True):
        coupling = WaveVariables(drift_gain=0.0, integrals=integrals)
        result = Rig().run(coupling, up, down, 16.0)
        left[integrals] = abs(result[-500:, X_M] - result[-500:, X_S]).max()
    assert left[False] > 3e-4
    assert left[True] < 1e-6


def test_with_integrals_jitter_takes_neither_the_contact_nor_the_position() -> None:
    up, down = (
        Conditions(delay=0.008, jitter="exponential", spread=0.002, seed=seed).shown(6000)
        for seed in (1, 2)
    )
    error, contact = {}, {}
    for integrals in (False, True):
        result = Rig().run(WaveVariables(integrals=integrals), up, down, 6.0)[5000:]
        error[integrals] = abs(result[:, X_M] - result[:, X_S]).mean()
        contact[integrals] = (result[:, F_ENV] > 0.0).mean()
    assert contact[False] < 0.7
    assert contact[True] == 1.0
    assert error[True] < 0.5 * error[False]


@pytest.mark.parametrize("growth", [0.2, 0.5, 0.9])
def test_a_growing_delay_is_the_gain_of_lozano(growth: float) -> None:
    # A wave of 1 whose packets arrive stretched: played at the root mean square of 1 - tau'.
    coupling = WaveVariables(drift_gain=0.0)
    end = coupling.make_slave(PERIOD, np.zeros(8), 100.0).declaration
    constants = end.parameters["constants"]
    memory = np.array(end.memory["memory"].initial)
    played = SLAVE_MEMORY.unpack(memory[1 + UP.size :]).played
    command, energy, sent = np.zeros(8), np.zeros(METERS.size), np.zeros(7)
    total, count = 0.0, 2000
    for k in range(1, count + 1):
        number = (1.0 - growth) * k
        packet = np.zeros(10)
        packet[0], packet[1], packet[4] = number, 1.0, 0.5 * PERIOD * number
        before = played[0]
        wave_slave(packet, np.zeros(3), np.zeros(6), constants, memory, sent, command, energy)
        total += math.sqrt(2.0 * (played[0] - before) / PERIOD)
    assert total / count == pytest.approx(math.sqrt(1.0 - growth), rel=1e-6)


def test_a_wave_is_cut_to_the_energy_that_is_there() -> None:
    assert affordable(3.0, 1.0, 0.0, 1e-3) == 3.0
    assert affordable(-3.0, 1.002, 1.0, 1e-3) == pytest.approx(-2.0)
    assert affordable(3.0, 0.0, 1.0, 1e-3) == 0.0


def test_wrong_fields_are_named() -> None:
    with pytest.raises(ValueError, match=r"c\.impedance: 0\.0, allowed 0\.1 to 1000"):
        check(WaveVariables(impedance=0.0), "c")

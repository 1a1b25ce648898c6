"""What a supervised run says of itself: the states, the stops in words, the verdict, its status."""

import numpy as np
import pytest

import scara_drake as sd
from scara_drake.cli.recorded import ARM_LOST, FAILED_RUN, status_of
from scara_drake.metrics.judgement import Verdict
from scara_drake.metrics.supervision import state_shares, stops
from scara_drake.safety import Reason, State


@pytest.fixture(scope="module")
def plain():
    return sd.simulate(sd.load_scenario("joint_sine"), duration=0.1)


def supervised(recording, pairs, side="robot"):
    """The recording with states and reasons that change at equal times."""
    each = -(-recording.sizes["time"] // len(pairs))
    codes = np.repeat(np.array(pairs, dtype=float), each, axis=0)[: recording.sizes["time"]]
    return recording.assign(
        {f"{side}_state": ("time", codes[:, 0]), f"{side}_reason": ("time", codes[:, 1])}
    )


def test_shares_and_stops_are_those_of_the_codes(plain):
    run = supervised(plain, [(0, 0), (1, 0), (3, 20), (1, 0)])
    shares = state_shares(run)
    assert shares["idle"] == pytest.approx(0.25, abs=0.02)
    assert shares["active"] == pytest.approx(0.5, abs=0.02)
    assert sum(shares.values()) == pytest.approx(1.0)
    (stop,) = stops(run)
    assert (stop.state, stop.open) == (State.HOLD, False)
    assert str(stop).startswith("robot HOLD: no command arrives at the robot, from 0.05 s to 0.0")
    verdict = sd.verdict(run)
    assert verdict.good
    assert str(stop) in verdict.remarks
    assert any("hold" in remark and "% active" in remark for remark in verdict.remarks)
    assert state_shares(plain) == {}
    assert stops(plain) == []


@pytest.mark.parametrize("side", ["robot", "operator"])
@pytest.mark.parametrize(
    ("state", "reason"),
    [
        (State.FAULT, Reason.OVER_FORCE),
        (State.ESTOP, Reason.ESTOP_PRESSED),
        (State.HOLD, Reason.COMMAND_LOST),
        (State.HOLD, Reason.DEVICE_LOST),
    ],
)
def test_a_run_that_ends_in_a_fault_or_lost_is_no_success(plain, side, state, reason):
    verdict = sd.verdict(supervised(plain, [(1, 0), (state, reason)], side))
    assert not verdict.good
    assert str(verdict).startswith(f"ended in {side} ")
    assert status_of(verdict) == ARM_LOST == 3
    over = sd.verdict(supervised(plain, [(1, 0), (state, reason), (0, 0), (1, 0)], side))
    assert over.good
    assert status_of(over) == 0


def test_a_broken_limit_alone_keeps_its_status():
    assert status_of(Verdict(("speed limit broken",), ())) == FAILED_RUN == 1
    assert status_of(Verdict(("arm lost",), (), lost=True)) == ARM_LOST


def test_a_run_that_is_released_at_its_end_is_a_success(plain):
    run = supervised(plain, [(1, 0), (State.HOLD, Reason.HELD)])
    assert sd.verdict(run).good

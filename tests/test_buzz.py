"""What is told through the motors: each reason its pattern, once, over the force."""

from __future__ import annotations

import numpy as np
import pytest

from scara_drake.operator.buzz import (
    BUZZING,
    PERIOD,
    QUIET_TICKS,
    Buzz,
    buzz_step,
    sample_buzzes,
    scale_force,
)
from scara_drake.safety import BUZZES, MEANINGS, Reason, Severity, State
from scara_drake.vectors import LIVE_SETTINGS, NEUTRAL_SETTINGS, ROBOT_REPORT, SUPERVISOR_STATUS

PULSES, LENGTHS, RANKS = sample_buzzes()


class Told:
    """A buzz, tick by tick."""

    def __init__(self) -> None:
        self.buzzing, self.rumble = BUZZING.zeros(tick=QUIET_TICKS), np.zeros(2)

    def run(
        self,
        seconds: float,
        reason: Reason = Reason.NONE,
        state: State = State.ACTIVE,
        robot: Reason = Reason.NONE,
        force: float = 0.0,
    ) -> np.ndarray:
        """The levels (n, 2) of a time."""
        mine = SUPERVISOR_STATUS.pack(state=state, reason=reason, engagements=0, faults=0)
        its = SUPERVISOR_STATUS.pack(state=State.IDLE, reason=robot, engagements=0, faults=0)
        report, levels = ROBOT_REPORT.zeros(status=its), []
        for _ in range(round(seconds / PERIOD)):
            buzz_step(
                np.full(2, force), mine, report, PULSES, LENGTHS, RANKS, self.buzzing, self.rumble
            )
            levels.append(self.rumble.copy())
        return np.array(levels)


@pytest.mark.parametrize("side", ["operator", "robot"])
@pytest.mark.parametrize("reason", [reason for reason in Reason if reason])
def test_each_reason_is_felt_as_the_table_says_and_the_motors_stop_by_themselves(
    reason: Reason, side: str
) -> None:
    told = Told()
    if side == "operator":
        levels = told.run(2.0, reason=reason, state=State.HOLD)
    else:
        levels = told.run(2.0, robot=reason)
    if side == "robot" and reason < Reason.COMMAND_LOST:
        assert not levels.any(), "what the robot repeats from the operator"
        return
    buzz = BUZZES[MEANINGS[reason].buzz]
    seconds = sum(pulse[2] for pulse in buzz)
    for motor in range(2):
        strength = sum(pulse[motor] * pulse[2] for pulse in buzz)
        assert levels[:, motor].sum() * PERIOD == pytest.approx(strength, abs=1e-9)
        assert levels[:, motor].max() == max((pulse[motor] for pulse in buzz), default=0.0)
    assert not levels[round(seconds / PERIOD) :].any()


def test_it_is_told_once_and_not_again_at_every_touch_of_a_limit() -> None:
    told = Told()
    first = told.run(0.2, robot=Reason.JOINT_LIMIT)
    assert first.any()
    assert not told.run(0.1).any()
    assert not told.run(0.1, robot=Reason.JOINT_LIMIT).any()
    told.run(1.0)
    np.testing.assert_array_equal(told.run(0.2, robot=Reason.JOINT_LIMIT), first)


def test_a_graver_reason_breaks_in_and_a_lighter_one_waits() -> None:
    told = Told()
    told.run(0.04, robot=Reason.WORKSPACE)
    levels = told.run(0.1, reason=Reason.ESTOP_PRESSED, state=State.ESTOP)
    assert levels.max() == 1.0
    assert MEANINGS[Reason.WORKSPACE].severity < Severity.ESTOP
    lighter = told.run(0.4, Reason.ESTOP_PRESSED, State.ESTOP, robot=Reason.WORKSPACE)
    assert (lighter == 1.0).all(), "the stop is told to its end"


@pytest.mark.parametrize("state", list(State))
def test_the_force_is_felt_while_the_arm_follows_and_no_longer(state: State) -> None:
    levels = Told().run(0.2, state=state, force=0.5)
    assert (levels == (0.5 if state in (State.ACTIVE, State.CLUTCH) else 0.0)).all()


def test_the_larger_of_force_and_buzz_is_felt() -> None:
    levels = Told().run(0.1, robot=Reason.WORKSPACE, force=0.2)
    assert (levels == 0.3).all()


def test_codes_that_nobody_knows_are_not_felt() -> None:
    for code in (np.nan, -3.0, 99.0):
        mine = SUPERVISOR_STATUS.pack(state=1.0, reason=code, engagements=0, faults=0)
        buzzing, rumble = BUZZING.zeros(tick=QUIET_TICKS), np.zeros(2)
        report = ROBOT_REPORT.zeros()
        buzz_step(np.zeros(2), mine, report, PULSES, LENGTHS, RANKS, buzzing, rumble)
        assert not rumble.any()


def test_the_felt_force_is_scaled() -> None:
    settings = LIVE_SETTINGS.pack(**NEUTRAL_SETTINGS._replace(force_scale=0.5)._asdict())
    felt = np.zeros(3)
    scale_force(np.array([1.0, -2.0, 4.0]), settings, felt)
    np.testing.assert_array_equal(felt, [0.5, -1.0, 2.0])


def test_without_anything_connected_it_is_silent() -> None:
    buzz = Buzz()
    context = buzz.CreateDefaultContext()
    context.SetDiscreteState(buzz.EvalUniquePeriodicDiscreteUpdate(context))
    np.testing.assert_array_equal(buzz.GetOutputPort("rumble").Eval(context), [0.0, 0.0])

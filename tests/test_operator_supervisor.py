"""Every fault of the operator's side: what it does, how fast, in which words, and the way back."""

from __future__ import annotations

import numpy as np
import pytest
from operator_rig import PERIOD, SAMPLE, OperatorRig

from scara_drake.operator.stick_filter import StickFilter
from scara_drake.operator.supervision import OperatorSupervision
from scara_drake.operator.supervisor import OperatorSupervisor
from scara_drake.safety import MEANINGS, Reason, Severity, State, words

NAN = float("nan")


def active(**config: object) -> OperatorRig:
    rig = OperatorRig(OperatorSupervision(**config)).run(0.15).engage()  # type: ignore[arg-type]
    assert (rig.state, rig.reason, rig.engagements) == (State.ACTIVE, Reason.NONE, 1)
    return rig


def reaction(rig: OperatorRig, **fault: float) -> float:
    """Time [s] from a fault to the end of ACTIVE."""
    start = rig.time
    while rig.state == State.ACTIVE:
        rig.run(PERIOD, **fault)
        assert rig.time - start < 5.0
    return rig.time - start


# What happens, the words for it, the state, how soon, what mends it, and what brings IDLE or HOLD
# back before the operator engages again.
FAULTS = [
    ({"connected": 0.0}, "gone", State.HOLD, PERIOD, {"connected": 1.0}),
    ({"age": 0.11}, "silent", State.HOLD, PERIOD, {"age": 0.0}),
    ({"age": NAN}, "silent", State.HOLD, PERIOD, {"age": 0.0}),
    ({"age": -5.0}, "silent", State.HOLD, 0.1 + 2 * PERIOD, {"age": 0.0}),
    ({"x": NAN}, "no number", State.FAULT, 2 * SAMPLE + PERIOD, {"x": 0.0}),
    ({"mast_axis": 1.06}, "out of range", State.FAULT, 2 * SAMPLE + PERIOD, {"mast_axis": 0.0}),
    ({"yaw": -np.inf}, "no number", State.FAULT, 2 * SAMPLE + PERIOD, {"yaw": 0.0}),
    ({"bad_samples": 3.0}, "no number", State.FAULT, PERIOD, {"bad_samples": 0.0}),
    ({"bad_samples": NAN}, "no number", State.FAULT, PERIOD, {"bad_samples": 0.0}),
    ({"clutch": NAN}, "no number", State.FAULT, 2 * SAMPLE + PERIOD, {"clutch": 0.0}),
    ({"engage": 0.0}, "dead-man", State.HOLD, PERIOD, {}),
    ({"hold": 1.0}, "held by the operator", State.HOLD, PERIOD, {"hold": 0.0}),
    ({"estop": 1.0}, "emergency stop", State.ESTOP, PERIOD, {"estop": 0.0}),
    ({"silence": 0.51}, "nothing arrives", State.HOLD, PERIOD, {"silence": 0.0}),
    ({"robot_faults": NAN}, "nothing arrives", State.HOLD, PERIOD, {"robot_faults": 0.0}),
    (
        {"robot_state": State.HOLD, "robot_reason": Reason.COMMAND_LOST, "robot_faults": 1.0},
        "no command",
        State.HOLD,
        PERIOD,
        {},
    ),
    (
        {"robot_state": State.FAULT, "robot_reason": Reason.OVER_FORCE, "robot_faults": 1.0},
        "force was too large",
        State.FAULT,
        PERIOD,
        {"robot_state": State.IDLE, "robot_reason": Reason.NONE},
    ),
]


@pytest.mark.parametrize(("fault", "says", "state", "within", "mended"), FAULTS)
def test_a_fault_stops_says_why_and_ends_when_the_operator_engages(
    fault: dict[str, float], says: str, state: State, within: float, mended: dict[str, float]
) -> None:
    rig = active()
    assert reaction(rig, **fault) <= within + 1e-9
    assert rig.state == state
    assert says in words(rig.state, rig.reason)
    assert rig.faults == (rig.reason not in (Reason.RELEASED, Reason.HELD))
    # The fault goes, and the button is still held: nothing moves.
    rig.run(0.5, **mended)
    assert rig.state == state
    if state >= State.FAULT:
        assert rig.engage().state == state, "latched"
        assert rig.press("reset").state == State.IDLE, "and a held button does not engage"
    assert rig.engage().state == State.ACTIVE
    assert rig.engagements == 2


@pytest.mark.parametrize(("fault", "says", "state", "within", "mended"), FAULTS)
def test_while_its_cause_is_there_no_button_leaves_a_stop(
    fault: dict[str, float], says: str, state: State, within: float, mended: dict[str, float]
) -> None:
    rig = active().run(0.2, **fault)
    if mended and "robot_state" not in fault:  # of others the cause is over, or the robot keeps it
        rig.press("reset").engage(**fault)
    assert rig.state == state


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ({"connected": 0.0}, Reason.DEVICE_LOST),
        ({"age": 1.0}, Reason.DEVICE_STALE),
        ({"silence": 1.0}, Reason.REPORT_LOST),
        ({"robot_state": State.FAULT, "robot_reason": Reason.TRACKING}, Reason.TRACKING),
    ],
)
def test_nobody_engages_an_arm_that_cannot_follow(fault: dict[str, float], reason: Reason) -> None:
    rig = OperatorRig().run(0.15, **fault).engage()
    assert rig.state in (State.IDLE, State.FAULT)
    assert rig.reason == reason
    rig.run(0.1, connected=1.0, age=0.0, silence=0.0, robot_state=State.IDLE)
    assert rig.state != State.ACTIVE, "a button held since before does not engage"


def test_the_severity_of_the_table_is_what_happens() -> None:
    for fault, _, state, _, _ in FAULTS:
        rig = active().run(0.2, **fault)
        severity = MEANINGS[rig.reason].severity
        assert state.name == severity.name, (fault, severity)
    assert MEANINGS[Reason.SPIKE].severity == Severity.INFORM


def test_a_button_held_from_the_start_or_through_a_loss_is_no_press() -> None:
    # At the start a device says nothing yet, and then that the button is down.
    rig = OperatorRig().run(0.01).run(1.0, engage=1.0)
    assert rig.state == State.IDLE
    assert OperatorRig(live=False).run(0.01, engage=1.0).state == State.ACTIVE, "a trace"
    assert rig.engage().state == State.ACTIVE
    # Lost while the button was up, back with the button down: a hand on it, no press of it.
    rig.run(0.1, engage=0.0).run(0.1, connected=0.0)
    assert rig.run(0.5, connected=1.0, engage=1.0).state == State.HOLD
    assert rig.engage().state == State.ACTIVE


def test_the_clutch_is_part_of_an_engagement() -> None:
    rig = active()
    assert rig.run(0.1, clutch=1.0).state == State.CLUTCH
    assert rig.reason == Reason.CLUTCHED
    assert rig.run(0.1, clutch=0.0).state == State.ACTIVE
    assert (rig.engagements, rig.faults) == (1, 0)
    assert rig.run(0.1, clutch=1.0).run(0.1, engage=0.0).state == State.HOLD
    assert rig.reason == Reason.RELEASED


def test_without_a_dead_man_a_press_engages_and_another_stops() -> None:
    rig = active(dead_man=False)
    assert rig.run(1.0, engage=0.0).state == State.ACTIVE
    assert rig.run(0.1, engage=1.0).state == State.HOLD
    assert rig.run(1.0, engage=0.0).state == State.HOLD
    assert rig.run(0.1, engage=1.0).state == State.ACTIVE
    assert reaction(rig, connected=0.0) <= PERIOD + 1e-9


OUTAGES = [
    ({"age": 1.0}, {"age": 0.0}),
    ({"silence": 1.0}, {"silence": 0.0}),
    ({"robot_state": 3.0, "robot_reason": 20.0, "robot_faults": 1.0}, {}),
]


@pytest.mark.parametrize(("outage", "over"), OUTAGES)
def test_after_an_outage_a_held_button_resumes_only_where_that_was_chosen(
    outage: dict[str, float], over: dict[str, float]
) -> None:
    assert active().run(0.3, **outage).run(0.3, **over).state == State.HOLD
    rig = active(after_outage="resume").run(0.3, **outage).run(0.3, **over)
    assert (rig.state, rig.engagements) == (State.ACTIVE, 2), "a new engagement: the arm's place"


@pytest.mark.parametrize(
    "also",
    [
        {"connected": 0.0},
        {"hold": 1.0},
        {"robot_state": 3.0, "robot_faults": 2.0, "robot_reason": 28.0},
    ],
)
def test_what_is_no_outage_never_resumes(also: dict[str, float]) -> None:
    rig = active(after_outage="resume")
    rig.run(0.2, silence=1.0).run(0.2, **also)
    # A pad that is plugged in again has been silent.
    rig.run(0.1, connected=1.0, hold=0.0, age=1.0).run(0.5, age=0.0, silence=0.0)
    assert rig.state == State.HOLD
    rig = active(after_outage="resume").run(0.2, silence=1.0).run(0.1, engage=0.0)
    assert rig.run(0.1, engage=1.0).run(0.2, silence=0.0).state == State.HOLD


def test_a_stop_of_the_robot_that_was_answered_is_not_taken_twice() -> None:
    rig = active().run(
        0.1, robot_state=State.HOLD, robot_reason=Reason.COMMAND_LOST, robot_faults=1
    )
    rig.engage()
    # The report on the way still tells the old hold.
    assert rig.run(1.0).state == State.ACTIVE
    rig.run(0.1, robot_state=State.ACTIVE, robot_reason=Reason.NONE)
    assert reaction(rig, robot_state=State.HOLD, robot_reason=Reason.COMMAND_LOST) <= PERIOD + 1e-9


def test_a_stop_that_the_robot_repeats_from_the_operator_is_no_stop_of_its_own() -> None:
    rig = active().press("estop").press("reset").engage()
    rig.run(0.5, robot_state=State.ESTOP, robot_reason=Reason.ESTOP_PRESSED, robot_faults=1)
    assert rig.state == State.ACTIVE, "an echo of what was reset"


def test_a_reset_that_the_robot_did_not_take_can_be_given_again() -> None:
    fault = {"robot_state": State.FAULT, "robot_reason": Reason.TRACKING, "robot_faults": 1.0}
    rig = active().run(0.1, **fault).press("reset")
    assert (rig.state, rig.reason) == (State.IDLE, Reason.TRACKING)
    assert rig.engage().state == State.IDLE
    states = {rig.press("reset").state, rig.press("reset").state}
    assert states == {State.FAULT, State.IDLE}


def test_an_emergency_stop_is_above_a_fault_and_above_a_bad_sample() -> None:
    rig = active().run(0.1, x=NAN)
    assert rig.run(0.01, estop=1.0).state == State.ESTOP
    rig = active()
    assert rig.run(PERIOD, x=NAN, estop=1.0).state == State.ESTOP
    # A reset while the button is down is refused, and one that is held says nothing later.
    rig.run(0.1, x=0.0, reset=1.0).run(0.1, estop=0.0)
    assert rig.state == State.ESTOP


def test_two_bad_samples_are_left_out() -> None:
    rig = active().run(0.2, x=0.4)
    for _ in range(20):
        rig.run(2 * SAMPLE, x=NAN).run(SAMPLE, x=0.4)
    assert rig.state == State.ACTIVE
    assert rig.operator_input[0] == 0.4


@pytest.mark.parametrize("spike", [-1.0, 1.0])
@pytest.mark.parametrize("axis", ["x", "mast_hat", "yaw"])
def test_a_spike_of_one_sample_never_gets_through_and_is_told(axis: str, spike: float) -> None:
    rig = active()
    column = list(rig.now).index(axis)
    seen = []
    for value in [0.1] * 10 + [spike] * 10 + [0.1] * 40:
        rig.run(PERIOD, **{axis: value})
        seen.append(rig.operator_input[column])
    assert 0.0 <= min(seen) <= max(seen) <= 0.1
    assert (rig.state, rig.reason) == (State.ACTIVE, Reason.SPIKE)
    assert rig.run(1.0).reason == Reason.NONE


def test_a_step_of_the_stick_is_no_spike_and_comes_one_sample_late() -> None:
    rig = active().run(SAMPLE, x=1.0)
    assert rig.operator_input[0] == 0.0
    assert rig.run(SAMPLE).operator_input[0] == 1.0
    assert rig.run(0.1).reason == Reason.NONE


def test_a_clock_that_jumps_and_a_simulation_that_is_late_are_told_and_stop_nothing() -> None:
    rig = active().run(0.01, age=-1.0)
    assert (rig.state, rig.reason) == (State.ACTIVE, Reason.CLOCK_JUMP)
    rig.run(1.0, age=0.0, lateness=2.0).run(0.3, lateness=0.0)
    assert (rig.state, rig.reason) == (State.ACTIVE, Reason.CLOCK_JUMP)
    rig.run(0.9, lateness=0.15)
    assert rig.reason == Reason.NONE
    assert rig.run(0.2).reason == Reason.OVERRUN
    assert rig.run(1.0, lateness=0.0).reason == Reason.NONE


@pytest.mark.parametrize("period", [1e-3, 5e-4, 2e-3])
def test_the_blocks_take_any_period(period: float) -> None:
    assert StickFilter(0.01, period=period).declaration.period == period
    assert OperatorSupervisor(OperatorSupervision(), period=period).declaration.period == period


def test_bad_settings_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"operator.stale_after: 0.*allowed"):
        OperatorSupervisor(OperatorSupervision(stale_after=0.0))
    with pytest.raises(ValueError, match=r"operator\.after_outage"):
        OperatorSupervisor(OperatorSupervision(after_outage="go"))
    with pytest.raises(ValueError, match="spike"):
        StickFilter(spike=3.0)

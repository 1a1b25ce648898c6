"""Each condition of the table: when it is told, in which words, what it bounds, how it ends."""

from typing import Any

import numpy as np
import pytest
from robot_rig import DT, Rig, command_at, moved

from scara_drake import joints, kinematics
from scara_drake.safety import MEANINGS, Reason, State, words
from scara_drake.supervision.arm_watch import HISTORY, ArmWatch, watch_arm
from scara_drake.supervision.config import RobotSupervision
from scara_drake.supervision.energy import ChannelEnergy, measure_energy
from scara_drake.supervision.layouts import ARM_CONDITION
from scara_drake.supervision.link_watch import LinkWatch, watch_link
from scara_drake.vectors import SERVO_STATE, TOOL_COMMAND

AT_REST = np.concatenate([joints.HOME, np.zeros(6)])


class Watched:
    """The watch over an arm that stands, with what its controller shows."""

    def __init__(self):
        is_ = ArmWatch(RobotSupervision(), command_at(joints.HOME), DT).declaration
        self.bounds = is_.parameters["bounds"]
        self.condition = np.array(is_.memory["arm_condition"].initial)
        self.history = np.zeros(HISTORY.size)

    def step(self, ticks, v=0.0, tau=lambda tick: 0.0, bits=0.0):
        """Advance; return the warnings (ticks,)."""
        told = []
        for tick in range(ticks):
            desired = np.concatenate([joints.HOME, np.full(6, v) * joints.MAX_SPEED])
            watch_arm(
                AT_REST, desired, np.zeros(3), tau(tick) * joints.EFFORT, np.full(6, bits),
                self.bounds, self.history, self.condition,
            )  # fmt: skip
            told.append(float(ARM_CONDITION.unpack(self.condition).warning))
        return np.array(told)


WARNINGS: dict[Reason, tuple[dict[str, Any], float]] = {
    Reason.EFFORT_LIMIT: ({"bits": 2.0}, 0.05),
    Reason.WINDUP: ({"bits": 1.0}, 0.05),
    Reason.SPEED_LIMIT: ({"v": 1.0}, 0.05),
    # 0.4 of the limit a millisecond is 400 / s; averaged over 0.1 s it is 50 / s after 13 ms.
    Reason.CHATTER: ({"tau": lambda tick: 0.2 * (-1) ** tick}, -0.1 * np.log(1.0 - 50.0 / 400.0)),
}


@pytest.mark.parametrize("reason", WARNINGS)
def test_a_warning_comes_in_time_stops_nothing_and_goes(reason):
    shown, after = WARNINGS[reason]
    watched = Watched()
    assert not watched.step(100).any()
    told = watched.step(200, **shown)
    assert np.flatnonzero(told)[0] * DT == pytest.approx(after, abs=3 * DT)
    assert (told[told > 0.0] == reason).all()
    assert ARM_CONDITION.unpack(watched.condition).fault == 0.0
    assert words(State.ACTIVE, reason) == f"ACTIVE: {MEANINGS[reason].says}"
    assert not watched.step(400)[-100:].any()


def test_a_short_one_is_not_told():
    watched = Watched()
    for _ in range(5):
        assert not watched.step(45, bits=3.0).any()
        watched.step(1)


def followed(rig):
    """Where the tool is, and the joints, of all ticks (n, 3), (n, 6)."""
    return np.array(rig.limiters)[:, SERVO_STATE.slices["p"]], np.array(rig.references)[:, :6]


def lead(rig, ticks, way=(0.0, 0.0, 0.0), mast=0.0):
    """Command a motion at some speeds [m/s]; return the reasons (ticks,)."""
    for _ in range(ticks):
        rig.command = moved(rig.command, np.multiply(way, DT), mast * DT)
        rig.step()
    return np.array(rig.statuses)[-ticks:, 1]


def engaged(q=joints.HOME, **bounds):
    rig = Rig(q=q, config=RobotSupervision(**bounds))
    rig.engage()
    rig.step(2)
    return rig


def test_the_box_holds_what_leads_out_and_nothing_else():
    low, high = [-20.0] * 3, [20.0] * 3
    start = TOOL_COMMAND.unpack(command_at(joints.HOME)).p.copy()
    high[2] = start[2] + 0.03
    rig = engaged(box_lower=low, box_upper=high)
    told = lead(rig, 800, way=(0.0, 0.1, 0.1))
    assert Reason.WORKSPACE in told
    # From where the command is beyond the box; the limiter is behind it.
    assert np.flatnonzero(told == Reason.WORKSPACE)[0] * DT == pytest.approx(0.3, abs=0.02)
    p, _ = followed(rig)
    assert p[:, 2].max() <= high[2] + 1e-4
    assert p[-1, 1] - start[1] == pytest.approx(0.08, abs=0.015)
    assert rig.status[0] == State.ACTIVE
    lead(rig, 900, way=(0.0, 0.0, -0.1))
    assert (lead(rig, 500) == Reason.NONE).all()
    np.testing.assert_allclose(followed(rig)[0][-1] - start, [0.0, 0.08, -0.01], atol=1e-3)


def test_an_arm_that_starts_within_a_margin_moves_inwards_only():
    q = joints.HOME.copy()
    q[0] = joints.UPPER[0] - 0.01
    rig = engaged(q)
    told = lead(rig, 300, mast=0.1)
    assert (told[50:] == Reason.JOINT_LIMIT).all()
    assert followed(rig)[1][:, 0].max() <= q[0] + 1e-6
    told = lead(rig, 600, mast=-0.1)
    assert followed(rig)[1][-1, 0] < q[0] - 0.02
    assert (told[-200:] == Reason.NONE).all()


def smallest(q):
    """Smallest singular value of the tool point by the joints that follow it."""
    return np.linalg.svd(kinematics.jacobian(q)[3:, 1:], compute_uv=False)[-1]


def test_near_a_singular_posture_the_arm_slows_down_and_comes_back_at_once():
    config = RobotSupervision(reach_share=1.0, singularity_slow=0.3, singularity_stop=0.2)
    rig = Rig(config=config)
    rig.engage()
    rig.step(2)
    p = TOOL_COMMAND.unpack(command_at(joints.HOME)).p
    told = lead(rig, 2000, way=(-0.5, 0.0, 0.0))
    assert Reason.SINGULARITY in told
    least = min(smallest(q) for q in followed(rig)[1][::50])
    assert 0.19 < least < 0.3
    lead(rig, 2000, way=(0.5, 0.0, 0.0))
    assert (lead(rig, 300) == Reason.NONE).all()
    np.testing.assert_allclose(followed(rig)[0][-1], p, atol=1e-3)


def account(delay, cycles, stiffness=1000.0, amplitude=0.02, rate=10.0, bound=10.0):
    """Faults (n,) and energy [J] of a channel between a hand that goes to and fro and a spring."""
    energy = ChannelEnergy(np.zeros(8), DT).declaration
    watch = LinkWatch(RobotSupervision(energy_bound=bound), DT).declaration
    ends, sums = np.zeros(6), np.zeros(2)
    condition, forgiven, faults = np.zeros(2), np.zeros(1), []

    def at(t):
        return amplitude * np.sin(rate * t)

    for tick in range(round(cycles * 2.0 * np.pi / rate / DT)):
        t = tick * DT
        sent, there, felt, force = np.zeros(8), np.zeros(8), np.zeros(3), np.zeros(3)
        sent[0], there[0] = at(t), at(t - delay)
        force[0], felt[0] = -stiffness * at(t - delay), -stiffness * at(t - 2.0 * delay)
        measure_energy(sent, felt, there, force, ends, sums)
        watch_link(np.zeros(1), np.zeros(1), sums, watch.parameters["bounds"], forgiven, condition)
        faults.append(condition[1])
    assert energy.period == DT
    return np.array(faults), sums[1] - sums[0]


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.05])
def test_a_delay_gives_the_energy_that_it_has_to(delay):
    """By the integral over a cycle: pi k A² sin(2 w T)."""
    _, given = account(delay, 4, bound=1e6)
    expected = 4.0 * np.pi * 1000.0 * 0.02**2 * np.sin(2.0 * 10.0 * delay)
    assert given == pytest.approx(expected, abs=0.2)


def test_too_much_of_it_is_a_fault_of_one_tick_after_which_it_is_counted_afresh():
    faults, given = account(0.05, 36)
    at = np.flatnonzero(faults)
    assert (faults[at] == Reason.CHANNEL_ENERGY).all()
    assert at.size == int(given / 10.0)
    assert (np.diff(at) > 1000).all()
    none, _ = account(0.0, 36)
    assert not none.any()


def test_a_reset_lets_the_arm_go_on_after_a_channel_that_gave_energy():
    rig = engaged()
    rig.link_fault = Reason.CHANNEL_ENERGY
    assert rig.step()[:2] == (State.FAULT, Reason.CHANNEL_ENERGY)
    rig.link_fault = Reason.NONE  # it was of one tick
    assert rig.step(50)[:2] == (State.FAULT, Reason.CHANNEL_ENERGY)
    for operator in (State.FAULT, State.IDLE):
        rig.operator = operator
        rig.step()
    rig.engage()
    assert rig.step()[0] == State.ACTIVE

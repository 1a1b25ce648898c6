"""What a supervisor tells through the motors of a device: short patterns over the force."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydrake.systems.framework import Context

from scara_drake.common.block import Block, Declaration, Input, Memory, Output
from scara_drake.common.layout import Cell, Layout
from scara_drake.operator.devices import Device
from scara_drake.operator.haptics import PUBLISH_OFFSET, PULSE
from scara_drake.operator.supervisor import ACTIVE, CLUTCH, FROM_ROBOT
from scara_drake.safety import BUZZES, MEANINGS, Reason
from scara_drake.vectors import (
    LIVE_SETTINGS,
    NEUTRAL_SETTINGS,
    ROBOT_REPORT,
    SUPERVISOR_STATUS,
    live_settings_of,
    robot_report_of,
    supervisor_status_of,
)

Array = NDArray[np.float64]

PERIOD: Final = 0.02  # [s], 50 Hz
QUIET_TICKS: Final = 25.0  # for which the same reason is not told again: one that comes and goes
FOLLOWING: Final = SUPERVISOR_STATUS.pack(state=ACTIVE, reason=0.0, engagements=0.0, faults=0.0)
NO_REPORT: Final = (0.0,) * ROBOT_REPORT.size


class Buzzing(NamedTuple):
    """Memory of the buzz.

    Attributes:
        operator: reason of the operator's supervisor at the last tick.
        robot: the robot's own.
        told: the reason that was told last.
        tick: since it began to be told.
    """

    operator: Cell
    robot: Cell
    told: Cell
    tick: Cell


BUZZING = Layout(Buzzing, operator=(), robot=(), told=(), tick=())
buzzing_of = BUZZING.reader()


def sample_buzzes() -> tuple[Array, Array, Array]:
    """Return the buzz of each reason in ticks of `PERIOD`.

    Returns:
        pulses (codes, ticks, 2): levels of the low and the high motor, 0 to 1.
        lengths (codes,): ticks until it is over.
        ranks (codes,): a reason breaks into the buzz of one of no higher rank.
    """
    codes = max(Reason) + 1
    ends = {name: np.cumsum([seconds for *_, seconds in buzz]) for name, buzz in BUZZES.items()}
    longest = max(round(end[-1] / PERIOD) for end in ends.values() if end.size)
    pulses, lengths, ranks = np.zeros((codes, longest, 2)), np.zeros(codes), np.zeros(codes)
    for reason, meaning in MEANINGS.items():
        ticks = np.round(ends[meaning.buzz] / PERIOD).astype(int)
        for start, end, (low, high, _) in zip(
            [0, *ticks], ticks, BUZZES[meaning.buzz], strict=False
        ):
            pulses[reason, start:end] = low, high
        lengths[reason], ranks[reason] = max(ticks, default=0), meaning.severity
    return pulses, lengths, ranks


@njit(cache=True)
def begins(reason: float, before: Cell, lengths: Array, ranks: Array, buzzing: Array) -> bool:
    """Whether a reason is to be told now; it becomes what it was before, in place."""
    m, new = buzzing_of(buzzing), reason != before[()]
    before[()] = reason
    if not (new and 0.0 <= reason < lengths.size) or lengths[int(reason)] == 0.0:
        return False
    told = int(m.told[()])
    if reason == told and m.tick[()] < QUIET_TICKS:
        return False
    return m.tick[()] >= lengths[told] or ranks[int(reason)] >= ranks[told]


@njit(cache=True)
def buzz_step(
    rumble_force: Array,
    operator_status: Array,
    robot_report_received: Array,
    pulses: Array,
    lengths: Array,
    ranks: Array,
    buzzing: Array,
    rumble: Array,
) -> None:
    """One tick of `Buzz`, in place."""
    m, mine = buzzing_of(buzzing), supervisor_status_of(operator_status)
    robot = supervisor_status_of(robot_report_of(robot_report_received).status)
    # A reason below is one that the robot repeats from the operator.
    its_own = robot.reason[()] if robot.reason[()] >= FROM_ROBOT else 0.0
    m.tick[()] += 1.0
    for reason, before in ((mine.reason[()], m.operator), (its_own, m.robot)):
        if begins(reason, before, lengths, ranks, buzzing):
            m.told[()], m.tick[()] = reason, 0.0
    follows = mine.state[()] in (ACTIVE, CLUTCH)
    told, tick = int(m.told[()]), int(m.tick[()])
    for motor in range(rumble.size):
        force = rumble_force[motor] if follows else 0.0
        rumble[motor] = max(force, pulses[told, tick, motor] if tick < pulses.shape[1] else 0.0)


class Buzz(Block):
    """Lays the buzz of a reason over the rumble of the force, and shakes a device.

    Ports:
        input rumble_force (2): of `HapticOutput`; zero if not connected.
        input operator_status (4): of one who follows if not connected.
        input robot_report_received (15): of a robot without a reason if not connected.
        output rumble (2): levels of the low and the high frequency motor, each 0..1.

    Update, at t = k 20 ms: where a reason of the operator's supervisor or one of the robot's own
    begins, its pattern of `safety.BUZZES` starts, unless a graver one is on, or it was told within
    the last half second. Each level is the larger of the pattern's and, while the arm follows, the
    force's. Initial: everything zero.

    Publish, 1 ms after each update, if there is a device: device.rumble(low, high, 150 ms).
    """

    def __init__(self, device: Device | None = None) -> None:
        pulses, lengths, ranks = sample_buzzes()
        super().__init__(
            Declaration(
                inputs={
                    "rumble_force": Input(2, default=(0.0, 0.0)),
                    "operator_status": Input(SUPERVISOR_STATUS.size, default=tuple(FOLLOWING)),
                    "robot_report_received": Input(ROBOT_REPORT.size, default=NO_REPORT),
                },
                memory={
                    "rumble": Memory(2, port=True),
                    "buzzing": Memory(BUZZING.zeros(tick=QUIET_TICKS)),
                },
                parameters={"pulses": pulses, "lengths": lengths, "ranks": ranks},
                period=PERIOD,
                update=buzz_step,
            )
        )
        self._device = device
        if device is not None:
            self.DeclarePeriodicPublishEvent(PERIOD, PUBLISH_OFFSET, self._shake)

    def _shake(self, context: Context) -> None:
        if self._device is not None:
            low, high = self.GetOutputPort("rumble").Eval(context)
            self._device.rumble(low, high, PULSE)


@njit(cache=True)
def scale_force(f_haptic: Array, live_settings: Array, f_felt: Array) -> None:
    """Write the force (3,) that is felt."""
    f_felt[:] = live_settings_of(live_settings).force_scale * f_haptic


class FeltForce(Block):
    """Scales the force that has come over the channel, by what the operator has set.

    Ports:
        input f_haptic (3) [N].
        input live_settings (5): of which `force_scale` counts.
        output f_felt (3) [N]: force_scale f_haptic.
    """

    def __init__(self) -> None:
        super().__init__(
            Declaration(
                inputs={
                    "f_haptic": Input(3),
                    "live_settings": Input(LIVE_SETTINGS.size, default=tuple(NEUTRAL_SETTINGS)),
                },
                outputs={"f_felt": Output(3, scale_force)},
            )
        )

"""What a supervisor can be in, and why: states, reasons, their words and how they feel.

The operator's supervisor and the robot's, the verdict, the station and the terminal read this table
and no other. A code is the number on a port and in a recording; it never changes its meaning.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple


class State(IntEnum):
    """What a supervisor lets through."""

    IDLE = 0  # nobody has engaged: the arm stands where it is
    ACTIVE = 1  # the arm follows the operator
    CLUTCH = 2  # engaged, and the operator moves his stick without the arm
    HOLD = 3  # stopped by itself: goes on when the operator engages again
    FAULT = 4  # stopped, and latched until it is reset
    ESTOP = 5  # stopped by hand, and latched until it is reset


class Reason(IntEnum):
    """Why the arm does not follow, or what it follows with a warning."""

    NONE = 0
    # the operator's side
    RELEASED = 1
    CLUTCHED = 2
    HELD = 3
    ESTOP_PRESSED = 4
    DEVICE_LOST = 5
    DEVICE_STALE = 6
    BAD_SAMPLE = 7
    SPIKE = 8
    CLOCK_JUMP = 9
    OVERRUN = 10
    REPORT_LOST = 11
    # the robot's side
    COMMAND_LOST = 20
    BAD_COMMAND = 21
    WORKSPACE = 22
    JOINT_LIMIT = 23
    SINGULARITY = 24
    UNREACHABLE = 25
    SPEED_LIMIT = 26
    EFFORT_LIMIT = 27
    TRACKING = 28
    WINDUP = 29
    CHATTER = 30
    OVER_FORCE = 31
    CHANNEL_ENERGY = 32
    BAD_MEASUREMENT = 33


class Severity(IntEnum):
    """What a reason does to the state."""

    INFORM = 0  # said, and the arm follows as far as it may
    HOLD = 1
    FAULT = 2
    ESTOP = 3


class Meaning(NamedTuple):
    """A reason in words.

    Attributes:
        severity: what it does.
        says: what has happened, after "the arm does not follow: " or by itself.
        remedy: what the operator can do.
        buzz: its pattern of rumble, one of `BUZZES`.
    """

    severity: Severity
    says: str
    remedy: str
    buzz: str


# A buzz is pulses of (low motor, high motor, seconds), once when the reason begins.
BUZZES: Final[dict[str, tuple[tuple[float, float, float], ...]]] = {
    "none": (),
    "tick": ((0.0, 0.4, 0.06),),
    "wall": ((0.3, 0.3, 0.12),),
    "hold": ((0.6, 0.0, 0.12), (0.0, 0.0, 0.08), (0.6, 0.0, 0.12)),
    "fault": (
        (1.0, 0.4, 0.18),
        (0.0, 0.0, 0.1),
        (1.0, 0.4, 0.18),
        (0.0, 0.0, 0.1),
        (1.0, 0.4, 0.18),
    ),
    "stop": ((1.0, 1.0, 0.6),),
}

_INFORM, _HOLD, _FAULT, _ESTOP = Severity
MEANINGS: Final[dict[Reason, Meaning]] = {
    Reason.NONE: Meaning(_INFORM, "", "", "none"),
    Reason.RELEASED: Meaning(
        _HOLD, "the dead-man button is not held", "hold the engage button", "none"
    ),
    Reason.CLUTCHED: Meaning(
        _INFORM, "the clutch is held: the stick moves alone", "let the clutch go", "tick"
    ),
    Reason.HELD: Meaning(_HOLD, "held by the operator", "engage again", "tick"),
    Reason.ESTOP_PRESSED: Meaning(
        _ESTOP, "the emergency stop was pressed", "reset, then engage again", "stop"
    ),
    Reason.DEVICE_LOST: Meaning(
        _HOLD, "the operator's device is gone", "plug it in, then engage again", "hold"
    ),
    Reason.DEVICE_STALE: Meaning(
        _HOLD, "the operator's device is silent", "wait for it, then engage again", "hold"
    ),
    Reason.BAD_SAMPLE: Meaning(
        _FAULT, "the device sends what is no number, or out of range", "reset", "fault"
    ),
    Reason.SPIKE: Meaning(_INFORM, "a spike of the stick was left out", "none needed", "none"),
    Reason.CLOCK_JUMP: Meaning(
        _INFORM, "the device's clock jumped: its step was bounded", "none needed", "none"
    ),
    Reason.OVERRUN: Meaning(
        _INFORM, "the simulation is behind the clock", "close viewers or other programs", "tick"
    ),
    Reason.REPORT_LOST: Meaning(
        _HOLD,
        "nothing arrives from the robot",
        "wait for the link, then engage again",
        "hold",
    ),
    Reason.COMMAND_LOST: Meaning(
        _HOLD, "no command arrives at the robot", "wait for the link, then engage again", "hold"
    ),
    Reason.BAD_COMMAND: Meaning(_FAULT, "a command that is no number arrived", "reset", "fault"),
    Reason.WORKSPACE: Meaning(
        _INFORM, "the command is outside the workspace", "move back inside", "wall"
    ),
    Reason.JOINT_LIMIT: Meaning(
        _INFORM, "a joint is at its limit", "move back from the limit", "wall"
    ),
    Reason.SINGULARITY: Meaning(
        _INFORM, "the arm is near a singular posture", "move back from it", "wall"
    ),
    Reason.UNREACHABLE: Meaning(
        _INFORM, "no posture reaches the command", "command another pose", "wall"
    ),
    Reason.SPEED_LIMIT: Meaning(_INFORM, "a joint is at its fastest", "move slower", "none"),
    Reason.EFFORT_LIMIT: Meaning(
        _INFORM, "a drive is at its effort limit", "push or move less", "tick"
    ),
    Reason.TRACKING: Meaning(
        _FAULT, "the arm is away from its reference", "clear the cause, then reset", "fault"
    ),
    Reason.WINDUP: Meaning(_INFORM, "a sliding variable is out of its layer", "move less", "none"),
    Reason.CHATTER: Meaning(_INFORM, "the effort chatters", "lower the gains", "none"),
    Reason.OVER_FORCE: Meaning(
        _FAULT, "the contact force was too large: the tool has backed off", "reset", "fault"
    ),
    Reason.CHANNEL_ENERGY: Meaning(
        _FAULT, "the channel gives more energy than it took", "reset", "fault"
    ),
    Reason.BAD_MEASUREMENT: Meaning(
        _FAULT, "a force or a joint reads what is no number", "reset", "fault"
    ),
}


def words(state: float, reason: float) -> str:
    """Return one sentence without a full stop for codes of a port or a recording.

    Raises:
        ValueError: a code that is in no table.
    """
    name, meaning = State(int(state)).name.replace("ESTOP", "E-STOP"), MEANINGS[Reason(int(reason))]
    return f"{name}: {meaning.says}" if meaning.says else name

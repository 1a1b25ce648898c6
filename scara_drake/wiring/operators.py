"""The kinds of operator: how each is wired, where it starts, and what it does not go with.

A new kind is its part in `operator/`, its wiring in a file here, a row of `OPERATORS`, and its name
in the union of `Scenario.operator`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder

from scara_drake.common import checks
from scara_drake.ik.system import FOLLOWERS, first_answer
from scara_drake.operator.external import External
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.operator.joystick import Joystick
from scara_drake.operator.master import Master
from scara_drake.operator.trainee import Trainee
from scara_drake.wiring import Signals
from scara_drake.wiring.bilateral import add_bilateral
from scara_drake.wiring.external import add_external
from scara_drake.wiring.joint_motion import add_joint_motion
from scara_drake.wiring.joystick import add_joystick
from scara_drake.wiring.trainee import add_trainee

if TYPE_CHECKING:
    from scara_drake.ik.result import IkResult
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OperatorWiring:
    """What the Diagram has to know of a kind of operator.

    Attributes:
        add: its wiring, which has to end in `state_desired` and `X_WE_desired`.
        start: first reference (12,) = (q, v) of an operator in a scenario without `q0`.
        check: raises a ValueError where the scenario has a part that the kind does not go with.
        moves_at_start: the reference moves from the first instant, wherever the arm stands.
        answer: how the inverse kinematics found `start`, of an operator that commands the tool.
        unused: fields that the kind has no use for, each with what does that for it.
    """

    add: Callable[[DiagramBuilder, Scenario, Array, Signals], Signals]
    start: Callable[[Scenario], Array]
    check: Callable[[Scenario], None]
    moves_at_start: bool = False
    answer: Callable[[Scenario], IkResult] | None = None
    unused: Mapping[str, str] = field(default_factory=dict)


def wiring_of(scenario: Scenario) -> OperatorWiring:
    """Return the row of the scenario's operator.

    Raises:
        ValueError: its kind is not in `OPERATORS`.
    """
    kind = type(scenario.operator)
    if kind not in OPERATORS:
        names = ", ".join(known.__name__ for known in OPERATORS)
        raise ValueError(f"operator: '{kind.__name__}', allowed {names}")
    return OPERATORS[kind]


def unused_settings(scenario: Scenario, keys: Iterable[str]) -> list[str]:
    """Return a sentence for each setting that the scenario's operator has no use for.

    Args:
        scenario: checked.
        keys: dotted, of the settings, such as "channel.up.delay".
    """
    kind, unused = type(scenario.operator).__name__, wiring_of(scenario).unused
    return [
        f"{key}: not used with the operator {kind}; {instead}"
        for key in keys
        for field_name, instead in unused.items()
        if f"{key}.".startswith(f"{field_name}.")
    ]


def add_operator(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the operator's side and all that leads from it to the joint references."""
    return wiring_of(scenario).add(builder, scenario, q_start, signals)


def start_posture(scenario: Scenario) -> Array:
    """Return q (6,) at t = 0: `q0`, or where the first reference is.

    Raises:
        ValueError: the first tool command cannot be reached.
    """
    if scenario.q0 is not None:
        return np.array(scenario.q0, dtype=np.float64)
    return wiring_of(scenario).start(scenario)[:6]


def start_answer(scenario: Scenario) -> IkResult | None:
    """Return the answer that the arm starts from; None with `q0`, or without a tool command.

    Raises:
        ValueError: the first tool command cannot be reached.
    """
    answer = wiring_of(scenario).answer
    return None if answer is None or scenario.q0 is not None else answer(scenario)


def first_reference(scenario: Scenario, q_start: Array) -> Array:
    """Return the joint reference (12,) = (q, v) at t = 0 of an arm that starts at `q_start`."""
    kind = wiring_of(scenario)
    return kind.start(scenario) if kind.moves_at_start else np.concatenate([q_start, np.zeros(6)])


def _answer_to_first_command(scenario: Scenario) -> IkResult:
    operator: Any = scenario.operator
    seed = scenario.seed_of("inverse_kinematics")
    return first_answer(scenario.inverse_kinematics, operator.first_command(), seed)


def _at_first_command(scenario: Scenario) -> Array:
    return np.concatenate([_answer_to_first_command(scenario).q, np.zeros(6)])


def _at_motion_start(scenario: Scenario) -> Array:
    motion: Any = scenario.operator
    return np.array(motion.start_state(), dtype=np.float64)


def _no_supervision(scenario: Scenario) -> None:
    if scenario.supervision is not None:
        raise ValueError("supervision: set, allowed with a Joystick or an External only")


def _supervised_watch(scenario: Scenario) -> None:
    """Check what a supervised command goes with.

    Raises:
        ValueError: a second watch over the command, or packets that come less often than the
            command counts as lost.
    """
    if scenario.supervision is None:
        return
    if scenario.channel.watch is not None:
        raise ValueError("channel.watch: set, allowed without supervision, which watches itself")
    period = getattr(scenario.channel.link("up"), "send_period", 0.0)
    limit = scenario.supervision.robot.age_limit
    checks.number("supervision.robot.age_limit", limit, 1.5 * period, 10.0)


def _check_external(scenario: Scenario) -> None:
    _no_codec(scenario)
    _supervised_watch(scenario)
    operator: External = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    if operator.port == "command_frame" and scenario.supervision is None:
        raise ValueError("operator.port: 'command_frame', allowed with supervision only")


def _check_joystick(scenario: Scenario) -> None:
    _no_codec(scenario)
    _supervised_watch(scenario)
    operator: Joystick = scenario.operator  # type: ignore[assignment]  # the table has chosen it
    mode, supervised = operator.mapping.mode, operator.is_live or scenario.supervision is not None
    if mode != "position" and not supervised:
        raise ValueError(f"operator.mapping.mode: '{mode}', allowed position without supervision")


def _no_device(scenario: Scenario) -> None:
    _no_supervision(scenario)
    if scenario.kinesthetic is not None:
        raise ValueError("kinesthetic: set, allowed with a Joystick or an External only")


def _no_codec(scenario: Scenario) -> None:
    if scenario.channel.codec is not None:
        raise ValueError("channel.codec: set, allowed with a Master only: it knows what is felt")


def _check_master(scenario: Scenario) -> None:
    _no_device(scenario)
    if scenario.channel.watch is not None:
        raise ValueError("channel.watch: set, allowed with a Joystick only")
    if scenario.governor is not None:
        raise ValueError(
            "governor: set, allowed without a Master only: its coupling has to see every limit of "
            "the motion, and the governor comes after it"
        )
    checks.choice("inverse_kinematics.method", scenario.inverse_kinematics.method, FOLLOWERS)
    exchange = scenario.coupling.exchange()
    if scenario.channel.codec is not None and not (exchange.felt_up and exchange.felt_down):
        raise ValueError(
            "channel.codec: set, allowed with a coupling whose exchange says what is felt "
            "(felt_up, felt_down)"
        )


def _check_trainee(scenario: Scenario) -> None:
    _no_codec(scenario)
    if scenario.task is None:
        raise ValueError("operator: !Trainee, allowed in a scenario with a task")
    if scenario.supervision is not None:
        raise ValueError("supervision: set, allowed without a Trainee: he presses no buttons")


NEEDS_MASTER = "a coupling needs 'operator: !Master {}', as in the scenario bilateral"

OPERATORS: dict[type, OperatorWiring] = {
    Joystick: OperatorWiring(
        add_joystick,
        _at_first_command,
        _check_joystick,
        answer=_answer_to_first_command,
        unused={"coupling": NEEDS_MASTER},
    ),
    External: OperatorWiring(
        add_external,
        _at_first_command,
        _check_external,
        answer=_answer_to_first_command,
        unused={"coupling": NEEDS_MASTER},
    ),
    Trainee: OperatorWiring(
        add_trainee,
        _at_first_command,
        _check_trainee,
        answer=_answer_to_first_command,
        unused={"coupling": NEEDS_MASTER},
    ),
    Master: OperatorWiring(
        add_bilateral,
        _at_first_command,
        _check_master,
        answer=_answer_to_first_command,
        unused={"haptics": "the force on the hand is that of 'coupling'"},
    ),
    JointMotion: OperatorWiring(
        add_joint_motion,
        _at_motion_start,
        _no_device,
        moves_at_start=True,
        unused={
            "channel": "a delay that the controller feels is 'process_delay', such as "
            "'process_delay={reference: !ConstantDelay {delay: 0.1}}'",
            "inverse_kinematics": "the joints are commanded; a tool is commanded by a Joystick",
            "coupling": NEEDS_MASTER,
            "haptics": "a joystick that shakes needs 'operator: !Joystick {}'",
        },
    ),
}

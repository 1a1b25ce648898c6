"""Operators who react: they move a master's hand by a picture that is late and by what they feel.

What they know is the picture of the tool as it came over its link, with its age, and what is local:
the force in the hand and where the hand is. The numbers are those of people without any delay: a
reaction of 0.2 s; 7 % of a force as what is just noticed (Pang, Tan and Durlach, 1991); an aim that
scatters in proportion to the way (Schmidt et al., 1979); a loop that is closed at about 3 rad/s by
who follows without a pause (McRuer and Jex, 1967).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.common import checks
from scara_drake.common.block import Block, Declaration, Input, Kernel, Memory, Output
from scara_drake.common.checks import ABOVE_ZERO
from scara_drake.common.fields import number, rows, vector
from scara_drake.kinematics import REACH
from scara_drake.operator.continuous import follow
from scara_drake.operator.move_and_wait import move_and_wait
from scara_drake.operator.moves import DONE, MIND, OWN_LAG, WAITING
from scara_drake.operator.policy_sense import (
    SENSE,
    STAGE,
    WORKER,
    show_aim,
    show_state,
    start_looking,
)
from scara_drake.vectors import POLICY_STATE

Array = NDArray[np.float64]

LOOK = 0.01  # [s], from look to look
SEEDS = 2**53  # seeds are kept beside numbers, and these are exact
_BACK_AND_FORTH = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.0]]


def _check_places(name: str, places: list[list[float]]) -> None:
    if not places:
        raise ValueError(f"{name}.places: [], allowed one row or more")


@dataclass
class Reach:
    """Bring the tool to places, one after the other, as Ferrell's operators did.

    Attributes:
        places: rows x, y, z: way of the tool from its start, in W's axes and the master's units.
        tolerance: how near the tool has to be.
        stay: how long it is to look so.
    """

    places: list[list[float]] = rows(_BACK_AND_FORTH, "m", -REACH, REACH)
    tolerance: float = number(0.004, "m", 1e-4, 0.1)
    stay: float = number(0.0, "s", 0.0, 60.0)

    def check_together(self, name: str) -> None:
        """Check that there is something to do.

        Raises:
            ValueError: there is no place.
        """
        _check_places(name, self.places)

    def stages(self) -> Iterator[Array]:
        """Yield the stages of the work, rows of `STAGE`."""
        for place in self.places:
            yield STAGE.zeros(place=place, tolerance=self.tolerance, stay=self.stay)


@dataclass
class Press:
    """At each place go into the surface until a force is felt, hold it, and come back.

    Attributes:
        places: rows x, y, z before the surface, as those of `Reach`.
        tolerance: how near the tool has to be to a place.
        normal: out of the surface, of any length.
        force: to press with, in the hand.
        share: of the force, by how much it may be off.
        hold: for how long it is to be right.
    """

    places: list[list[float]] = rows([[0.0, 0.0, 0.0]], "m", -REACH, REACH)
    tolerance: float = number(0.004, "m", 1e-4, 0.1)
    normal: list[float] = vector([0.0, 1.0, 0.0], "1", -1e3, 1e3)
    force: float = number(3.0, "N", ABOVE_ZERO, 100.0)
    share: float = number(0.15, "1", 1e-3, 1.0)
    hold: float = number(0.5, "s", 0.0, 60.0)

    def check_together(self, name: str) -> None:
        """Check that there is a place, and that the normal is one.

        Raises:
            ValueError: there is none, or the normal has no length.
        """
        _check_places(name, self.places)
        if not math.hypot(*self.normal) > 0.0:
            raise ValueError(f"{name}.normal: {self.normal}, allowed all but zero")

    def stages(self) -> Iterator[Array]:
        """Yield the stages of the work, rows of `STAGE`."""
        normal = np.array(self.normal) / math.hypot(*self.normal)
        within = self.share * self.force
        for place in self.places:
            there = STAGE.zeros(place=place, tolerance=self.tolerance)
            yield there
            yield STAGE.pack(
                place=place, normal=normal, force=self.force, tolerance=within, stay=self.hold
            )
            yield there


Work = Reach | Press


@dataclass
class Person:
    """What operators of both strategies are.

    A picture that stands still for as long as their reaction stops their hand.

    Attributes:
        work: what they do.
        reaction: until they act on what they see or feel.
        trust: in the picture: where the tool is taken to be, from 0, where their own hand is, to 1,
            where it is seen; and for how much of the lag of the picture they wait.
        weber_view: of a distance that is seen, standard deviation of what it is taken for.
        weber_force: the same of a force that is felt.
        aim: standard deviation of the end of the shortest move.
        spread: the same of a move's length, in proportion.
        max_speed: of the hand.
    """

    work: Work = field(default_factory=Reach)
    reaction: float = number(0.2, "s", 0.05, 1.0)
    trust: float = number(1.0, "1", 0.0, 1.0)
    weber_view: float = number(0.03, "1", 0.0, 1.0)
    weber_force: float = number(0.07, "1", 0.0, 1.0)
    aim: float = number(0.0005, "m", 0.0, 0.1)
    spread: float = number(0.05, "1", 0.0, 1.0)
    max_speed: float = number(0.25, "m/s", 1e-3, 2.0)

    def numbers(self) -> dict[str, float]:
        """Return what `WORKER` has of the person, by name."""
        names = ("reaction", "trust", "weber_view", "weber_force", "aim", "spread", "max_speed")
        own = {name: getattr(self, name) for name in names}
        return own | {"caution": 0.0, "approach": 0.0}


@dataclass
class MoveAndWait(Person):
    """Moves, waits until the picture has shown the move and rests, and moves again (Ferrell, 1965).

    How long moves take to be seen is learned from those that are made.

    Attributes:
        correction: of what is missing: how much of it a move takes off.
        caution: force of the hand that a move may make which nobody has seen: the moves towards a
            surface are so long, by the stiffness that was last met.
    """

    correction: float = number(1.0, "1", 0.1, 2.0)
    caution: float = number(1.0, "N", 1e-2, 100.0)

    def kernel(self) -> Kernel:
        """Return the update of `OperatorPolicy`."""
        return move_and_wait

    def numbers(self) -> dict[str, float]:
        """Return what `WORKER` has of the person, by name."""
        return super().numbers() | {"gain": self.correction, "caution": self.caution}


@dataclass
class Continuous(Person):
    """Follows what is missing without a pause, as people do where nothing is late.

    Attributes:
        gain: speed of the hand for a way that is missing; a force that is missing counts as the way
            in which the hand would make it.
        approach: speed towards a surface before it is felt.
    """

    gain: float = number(2.5, "1/s", 0.01, 50.0)
    approach: float = number(0.01, "m/s", 1e-4, 1.0)

    def kernel(self) -> Kernel:
        """Return the update of `OperatorPolicy`."""
        return follow

    def numbers(self) -> dict[str, float]:
        """Return what `WORKER` has of the person, by name."""
        return super().numbers() | {"gain": self.gain, "approach": self.approach}


Policy = MoveAndWait | Continuous


class OperatorPolicy(Block):
    """Moves the hand of a master, see `MoveAndWait` and `Continuous`.

    Ports:
        input tool_seen (3): p_WE as it came over the link of the picture [m].
        input age_seen (1): of that picture [s].
        input motion_master (6): of the device in the hand [m, m/s].
        input f_hand (3): force of the hand on the device [N].
        output hand_wanted (3): where the hand is to be a period later [m].
        output policy_state (3): see `vectors.PolicyState`.

    Update, at t = k period: `move_and_wait` or `follow`. Initial: the tool has been seen where it
    is, and the hand is at zero.

    Args:
        policy: who it is.
        first: p_WE at the start (3,) [m].
        position_scale: of the coupling.
        hand_stiffness: of the hand [N/m].
        period: [s].
        seed: of all that scatters.

    Raises:
        ValueError: the period or `first` is out of its bounds.
    """

    def __init__(
        self,
        policy: Policy,
        first: ArrayLike,
        position_scale: float = 1.0,
        hand_stiffness: float = 150.0,
        period: float = 1e-3,
        seed: int = 0,
    ) -> None:
        checks.number("period", period, 1e-4, 0.1)
        plan = list(policy.work.stages())
        samples = max(math.ceil(policy.reaction / LOOK), 1)
        mind = MIND.zeros(
            phase=WAITING if plan else DONE,
            lag=policy.reaction + OWN_LAG,
            timed=-1.0,
            arrived=-1.0,
            history=np.zeros(6 * samples),
        )
        others: dict[str, Any] = {
            "first": first,
            "scale": position_scale,
            "hand_stiffness": max(hand_stiffness, 1.0),
            "period": period,
            "ticks": max(round(LOOK / period), 1),
            "seed": seed % SEEDS,
            "plan": np.ravel(plan),
        }
        sense = SENSE.zeros(stamp=-np.inf, done_at=-1.0, stiffness=others["hand_stiffness"])
        super().__init__(
            Declaration(
                inputs={
                    "tool_seen": Input(3, finite=True),
                    "age_seen": Input(1),
                    "motion_master": Input(6),
                    "f_hand": Input(3),
                },
                memory={"mind": Memory(mind), "sense": Memory(sense)},
                outputs={
                    "hand_wanted": Output(3, show_aim),
                    "policy_state": Output(POLICY_STATE.size, show_state),
                },
                parameters={"worker": WORKER.pack(**policy.numbers(), **others)},
                period=period,
                update=policy.kernel(),
                initialize=start_looking,
            )
        )

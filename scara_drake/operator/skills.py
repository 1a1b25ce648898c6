"""What a scripted operator knows of his work, and how well he does it: data for `trainee`.

He works off a plan of legs, the same kind for all tasks. The numbers of the skills are chosen for
people as the literature has them: a reaction of 0.2 s to what is seen, hand tremor near 9 Hz
(Stiles, 1976), an aim that scatters in proportion to the way (Schmidt et al., 1979).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.fields import number
from scara_drake.common.layout import Layout

Array = NDArray[np.float64]


class Leg(NamedTuple):
    """One leg of a plan: bring the tool to a point, on a straight line from where it began.

    Attributes:
        p: the point, in W (3,) [m].
        normal: out of the surface that the tool presses on, in W (3,); zero in free space.
        force: to press with [N]; without a normal, the force that stops the advance.
        tolerance: how near the tool has to be [m].
        stride: longest single move [m].
        stay: how long the tool is to stay there [s].
        speed: at most, of a move [m/s].
    """

    p: Array
    normal: Array
    force: float
    tolerance: float
    stride: float
    stay: float = 0.0
    speed: float = 10.0


LEG = Layout(Leg, p=3, normal=3)
leg_of = LEG.reader()
WHOLE: Final = 10.0  # [m], a stride beyond the reach: one move all the way
FREE: Final = np.zeros(3)


def plan_of(legs: Iterable[Leg]) -> Array:
    """Return a plan (n, `LEG.size`) as the trainee's kernel reads it."""
    rows = [LEG.pack(**leg._asdict()) for leg in legs]
    return np.array(rows, dtype=np.float64).reshape(-1, LEG.size)


@dataclass
class Skill:
    """How well a scripted operator works.

    Attributes:
        reaction: until he acts on what he sees or feels.
        max_speed: of a move far from a surface.
        near_speed: of a move that presses or cuts.
        approach: of a surface: the longest move towards it once it is near.
        haste: of the moves of the plan: how much longer and faster than it has them.
        patience: of the time that moves take to be seen, as he has met it: how much of it he
            waits after a move before he makes the next; from 1 on, also until the tool rests.
        correction: of the error that he sees: how much of it a move takes off.
        spread: of a move's length: the standard deviation of its end.
        aim: the same of the shortest move.
        tremor: amplitude, of the tool.
        force_gain: how deep he presses for a force that is missing.
        heed: of the force: how much of it he minds while he advances.
    """

    reaction: float = number(0.2, "s", 0.0, 1.0)
    max_speed: float = number(0.25, "m/s", 1e-3, 2.0)
    near_speed: float = number(0.05, "m/s", 1e-3, 2.0)
    approach: float = number(0.0025, "m", 1e-5, 0.1)
    haste: float = number(1.0, "1", 0.1, 10.0)
    patience: float = number(1.0, "1", 0.0, 2.0)
    correction: float = number(0.95, "1", 0.1, 3.0)
    spread: float = number(0.05, "1", 0.0, 1.0)
    aim: float = number(0.0005, "m", 0.0, 0.1)
    tremor: float = number(0.0001, "m", 0.0, 0.01)
    force_gain: float = number(5e-5, "m/N", 0.0, 1e-2)
    heed: float = number(1.0, "1", 0.0, 1.0)

    def parameters(self, centre: ArrayLike, scale: float, dead_zone: float) -> Array:
        """Return the skill and the stick in his hand as `person_of` reads them, see `Person`."""
        own = {each.name: getattr(self, each.name) for each in fields(self)}
        return PERSON.pack(**own, centre=centre, scale=scale, dead_zone=dead_zone)


class Person(NamedTuple):
    """The numbers of a `Skill`, by the same names, and what the stick's mapping makes of it.

    Attributes:
        centre: tool point of the centred stick, in W (3,) [m].
        scale: travel of the tool at full stick [m].
        dead_zone: of the stick's travel.
    """

    reaction: float
    max_speed: float
    near_speed: float
    approach: float
    haste: float
    patience: float
    correction: float
    spread: float
    aim: float
    tremor: float
    force_gain: float
    heed: float
    centre: Array
    scale: float
    dead_zone: float


PERSON = Layout(Person, centre=3)
person_of = PERSON.reader()

# The good one is slow near contact, waits for what comes back, and presses by the force. The bad
# one is hasty, corrects what is already on its way, minds no force and aims badly.
SKILLS: Final[dict[str, Skill]] = {
    "good": Skill(),
    "bad": Skill(
        max_speed=0.5,
        near_speed=0.2,
        approach=0.01,
        haste=2.5,
        patience=0.75,
        correction=1.1,
        spread=0.12,
        aim=0.003,
        tremor=0.0004,
        force_gain=2e-4,
        heed=0.0,
    ),
}

"""The plan that a scripted operator makes of the drawing of his task, a file of legs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.environment.compliance import Compliance
from scara_drake.environment.surfaces import Environment, surface_distance, surface_row
from scara_drake.operator.skills import FREE, WHOLE, Leg, plan_of
from scara_drake.tasks.cut_pipe import CutPipe
from scara_drake.tasks.reach_into import ReachInto
from scara_drake.tasks.touch_points import TouchPoints
from scara_drake.tasks.trace_line import TraceLine

Array = NDArray[np.float64]

ABOVE: Final = 0.05  # [m], over a surface, where there is nothing to touch
PASSING: Final = 0.02  # [m], as near to a place that is only passed
PIECE: Final = 0.05  # [m], of a line on a surface, each with its own normal
STEP: Final = 0.015  # [m], along a line under force
LONGER: Final = 1.2  # times as long as is asked for, to be sure of it
NUDGE: Final = 10.0  # [N], where nothing is to be touched: back
CLEAR: Final = 0.04  # [m], of the blade before the pipe
BEHIND: Final = 0.008  # [m], of the blade's rim behind it
FEED: Final = 0.003  # [m], a move into the pipe
FEED_SPEED: Final = 0.008  # [m/s], the fastest of it
LOAD: Final = 0.4  # of the blade's stalling load, that is fed with
FIRM: Final = 3.0  # times the least force of a touch, to be sure of it


def plan_for(task: Any, environment: Environment, start: ArrayLike) -> Array:
    """Return the plan (n, `LEG.size`) of a task, for a tool that starts at a point (3,) [m]."""
    return plan_of(PLANS[type(task)](task, environment, np.asarray(start, dtype=np.float64)))


def normal_at(surface: Compliance, p_W: ArrayLike) -> Array:
    """Return the normal (3,) in W out of a surface at its place nearest to a point (3,) [m]."""
    X_WS, normal = surface.pose(), np.empty(3)
    p_S = X_WS.inverse().multiply(np.asarray(p_W, dtype=np.float64))
    surface_distance(surface_row(surface), p_S, normal)
    return np.asarray(X_WS.rotation().multiply(normal))


def _named(environment: Environment, name: str) -> Compliance:
    return next(surface for surface in environment.surfaces if surface.name == name)


def _touch(task: TouchPoints, environment: Environment, start: Array) -> Iterator[Leg]:
    surface = _named(environment, task.surface)
    for point in np.array(task.points):
        normal = normal_at(surface, point)
        over = point + ABOVE * normal
        yield Leg(over, FREE, NUDGE, PASSING, WHOLE)
        yield Leg(point, normal, FIRM * task.least_force, 0.7 * task.tolerance, WHOLE)
        yield Leg(over, FREE, 0.0, PASSING, WHOLE)


def _trace(task: TraceLine, environment: Environment, start: Array) -> Iterator[Leg]:
    surface, points = _named(environment, task.surface), np.array(task.points)
    normal = normal_at(surface, points[0])
    yield Leg(points[0] + ABOVE * normal, FREE, NUDGE, PASSING, WHOLE)
    yield Leg(points[0], normal, task.force, task.tolerance, WHOLE)
    for begin, end in pairwise(points):
        pieces = max(int(np.ceil(np.linalg.norm(end - begin) / PIECE)), 1)
        for share in np.arange(1, pieces + 1) / pieces:
            place = begin + share * (end - begin)
            normal = normal_at(surface, place)
            yield Leg(place, normal, task.force, 0.8 * task.tolerance, STEP)
    yield Leg(points[-1] + ABOVE * normal, FREE, 0.0, PASSING, WHOLE)


def _reach(task: ReachInto, environment: Environment, start: Array) -> Iterator[Leg]:
    opening, goal, outward = (np.array(each) for each in (task.opening, task.goal, task.outward))
    before = opening + 2.0 * ABOVE * outward
    # Straight in behind the opening, to the depth of the goal, and then across to it.
    inside = opening - (task.depth_of(goal) / 2.0) * outward
    yield Leg(before, FREE, NUDGE, PASSING, WHOLE)
    yield Leg(inside, FREE, NUDGE, PASSING, WHOLE)
    yield Leg(goal, FREE, NUDGE, 0.6 * task.tolerance, WHOLE, LONGER * task.stay)
    yield Leg(inside, FREE, NUDGE, PASSING, WHOLE)
    yield Leg(before, FREE, NUDGE, PASSING, WHOLE)


def _cut(task: CutPipe, environment: Environment, start: Array) -> Iterator[Leg]:
    pipe = environment.cut
    if pipe is None:  # the scenario has been checked
        return
    axis = np.array(pipe.direction)
    mark = np.array(pipe.point) + task.mark * axis
    feed = mark - start
    feed -= (feed @ axis) * axis
    feed /= np.linalg.norm(feed)
    before = mark - (pipe.radius + CLEAR) * feed
    through = mark + (pipe.radius + BEHIND) * feed
    load = LOAD * pipe.blade.feed_ratio * pipe.blade.stall_force()
    yield Leg(before, FREE, NUDGE, PASSING / 4.0, WHOLE)
    yield Leg(through, FREE, load, BEHIND / 2.0, FEED, speed=FEED_SPEED)
    yield Leg(before, FREE, 0.0, PASSING, WHOLE)


PLANS: Final[dict[type, Callable[[Any, Environment, Array], Iterator[Leg]]]] = {
    TouchPoints: _touch,
    TraceLine: _trace,
    ReachInto: _reach,
    CutPipe: _cut,
}

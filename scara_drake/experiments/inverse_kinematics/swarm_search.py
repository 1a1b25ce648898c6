"""The search for Table 7: population Monte Carlo over coefficients and readings.

Each candidate is run, and its distance is the sum of the misfits of the statements. A generation
proposes around the candidates of the one before it, and keeps those nearer than a quantile of what
that one kept (approximate Bayesian computation with importance weights). Numbers of trials are
given, not times: a seed gives the same bits on every machine.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.experiments.inverse_kinematics.swarm_law import Coefficients, Law
from scara_drake.experiments.inverse_kinematics.swarm_reported import STATEMENTS
from scara_drake.experiments.inverse_kinematics.swarm_statements import (
    COUNTS,
    Size,
    least,
    misfits,
    of_pso,
    sample,
    statistics,
)

Array = NDArray[np.float64]


class Range(NamedTuple):
    """What a coefficient is searched in, evenly, or evenly in its logarithm."""

    low: float
    high: float
    log: bool = False


RANGES: Final[dict[str, Range]] = {
    "inertia": Range(0.3, 1.2),
    "damping": Range(0.9, 0.999, True),  # evenly in log(1 - damping)
    "personal": Range(0.0, 3.0),
    "social": Range(0.1, 4.0),
    "speed": Range(0.005, 1.0, True),
    "after": Range(-50, 100),  # below zero: the swarm stops at once, as the text says
    "patience": Range(5, 150, True),
}
LITERAL_SPEED: Final = Range(0.05, 2.0, True)  # v_max as the bound of rand
LAWS: Final = tuple(
    Law(literal, millimetres, angles, one_turn, at_once, particles)
    for literal, millimetres, angles, one_turn, at_once in product((False, True), repeat=5)
    for particles in (40, 48, 80)
)
FLIP: Final = 0.08  # chance that a proposal changes each of the readings
WIDER: Final = 2.0  # variance of a proposal, of that of the generation before it
HOPELESS: Final = 2.5  # of 4 that PSO by itself can miss; the first generation ends there
NEARER: Final = 0.3  # quantile of the distances below which a generation proposes
FEWEST: Final = 8  # candidates that a generation goes on from


class Candidate(NamedTuple):
    """A set of coefficients under a reading, and how it fared.

    Attributes:
        law: reading of the swarm.
        place: (7,) in the unit cube of RANGES.
        misfits: (counts, statements), see `misfits`.
        distance: sum of the misfits that are searched for, under the nearest count.
        weight: in the posterior.
    """

    law: Law
    place: Array
    misfits: Array
    distance: float
    weight: float

    @property
    def coefficients(self) -> Coefficients:
        """Its coefficients."""
        return coefficients_at(self.place, self.law)

    @property
    def nearest(self) -> int:
        """The reading of COUNTS under which it is nearest to all statements."""
        return int(np.argmin(self.misfits.sum(axis=1)))


def coefficients_at(place: Array, law: Law) -> Coefficients:
    """Return the coefficients at a place (7,) in the unit cube."""

    def at(one: Range, u: float, mirrored: bool = False) -> float:
        low, high = (1.0 - one.high, 1.0 - one.low) if mirrored else (one.low, one.high)
        value = low * (high / low) ** u if one.log else low + u * (high - low)
        return 1.0 - value if mirrored else value

    ranges = {**RANGES, "speed": LITERAL_SPEED} if law.literal else RANGES
    values = {
        name: at(one, float(u), name == "damping")
        for (name, one), u in zip(ranges.items(), place, strict=True)
    }
    after, patience = max(0, round(values.pop("after"))), round(values.pop("patience"))
    return Coefficients(**values, after=after, patience=patience)


def candidate(
    law: Law, place: Array, seed: int, size: Size, enough: float, only: Array
) -> Candidate | None:
    """Run a candidate; None where it is sure to be further than `enough`.

    Args:
        law: reading.
        place: (7,).
        seed: of its runs.
        size: of them.
        enough: distance.
        only: weights (s,) of the statements in the distance.
    """
    c = coefficients_at(place, law)
    single = of_pso(law, c, seed, size)
    if only.all() and enough < np.inf and least(single) > enough:
        return None
    runs = sample(law, c, seed, size, single)
    found = np.array([misfits(statistics(runs, count)) for count in COUNTS])
    return Candidate(law, place, found, float((found @ only).min()), 1.0)


def first_generation(
    seed: int, each: int, size: Size, laws: Sequence[Law] = LAWS, stops: bool = False
) -> tuple[list[Candidate], list[Candidate]]:
    """Run candidates drawn evenly from RANGES.

    Args:
        seed: of draws and runs.
        each: how many for each reading.
        size: of their runs.
        laws: the readings.
        stops: whether all of them stop inside the tolerances.

    Returns:
        Those that are run to their end, and those that HOPELESS ends behind PSO, nothing met.
    """
    rng, everything = np.random.default_rng(seed), np.ones(len(STATEMENTS))
    nothing = np.ones((len(COUNTS), len(STATEMENTS)))
    kept, ended = [], []
    for law in laws:
        for _ in range(each):
            place = rng.random(len(RANGES))
            if stops:
                place[list(RANGES).index("after")] = 0.0
            one = candidate(law, place, _seed(rng), size, HOPELESS, everything)
            if one is None:
                ended.append(Candidate(law, place, nothing, float(len(STATEMENTS)), 1.0))
            else:
                kept.append(one)
    return kept, ended


def search(
    seed: int,
    start: list[Candidate],
    trials: int,
    generations: int,
    size: Size,
    only: Iterable[str] = STATEMENTS,
    laws: Sequence[Law] = LAWS,
) -> Iterator[list[Candidate]]:
    """Search on from some candidates; yield those of each generation that were run to their end.

    The last that is yielded is the posterior, weighted.

    Args:
        seed: of draws and runs.
        start: the first generation.
        trials: proposals of each later one.
        generations: at most so many.
        size: of the runs of a candidate.
        only: statements that make up the distance.
        laws: readings that are searched.
    """
    rng, names = np.random.default_rng(seed), set(only)
    weights = np.array([float(name in names) for name in STATEMENTS])
    near = [one._replace(distance=float((one.misfits @ weights).min())) for one in start]
    for _ in range(generations):
        enough = float(np.quantile([one.distance for one in near], NEARER))
        parents = [one for one in near if one.distance <= enough]
        spread = np.sqrt(WIDER) * np.std([one.place for one in parents], axis=0) + 1e-3
        proposals = [_proposal(parents, spread, rng, laws) for _ in range(trials)]
        tried = [candidate(law, u, _seed(rng), size, enough, weights) for law, u in proposals]
        found = [one for one in tried if one is not None and one.distance <= enough]
        if len(found) < FEWEST:
            return
        near = _weighted(found, parents, spread)
        yield near


def _seed(rng: np.random.Generator) -> int:
    return int(rng.integers(2**31))


def _proposal(
    parents: list[Candidate], spread: Array, rng: np.random.Generator, laws: Sequence[Law]
) -> tuple[Law, Array]:
    shares = np.array([one.weight for one in parents])
    while True:
        parent = parents[rng.choice(len(parents), p=shares / shares.sum())]
        law = _flipped(parent.law, rng)
        if law in laws:
            break
    while True:
        place = parent.place + spread * rng.standard_normal(len(spread))
        if ((place >= 0.0) & (place <= 1.0)).all():
            return law, place


def _flipped(law: Law, rng: np.random.Generator) -> Law:
    for name, value in law._asdict().items():
        others = [40, 48, 80] if name == "particles" else [False, True]
        if rng.random() < FLIP:
            others.remove(value)
            values: dict[str, Any] = {name: others[int(rng.integers(len(others)))]}
            law = law._replace(**values)
    return law


def _weighted(near: list[Candidate], parents: list[Candidate], spread: Array) -> list[Candidate]:
    """Weigh candidates by the even prior over the density that they were proposed with."""
    shares = np.array([one.weight for one in parents])
    places = np.array([one.place for one in parents])
    weights = []
    for one in near:
        kernel = np.exp(-0.5 * (((one.place - places) / spread) ** 2).sum(axis=1))
        for parent, other in enumerate(parents):
            for name, value in one.law._asdict().items():
                same = getattr(other.law, name) == value
                change = FLIP / (2 if name == "particles" else 1)
                kernel[parent] *= 1.0 - FLIP if same else change
        weights.append(1.0 / max(float(shares @ kernel), 1e-300))
    total = sum(weights)
    return [one._replace(weight=w / total) for one, w in zip(near, weights, strict=True)]

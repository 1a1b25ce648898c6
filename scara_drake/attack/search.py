"""The search for the largest harm.

In this order: the scenario as it is; each field alone, at the ends of its range; then rounds, each
of which begins with points of a Sobol sequence, which leave no large part of the space out, and
goes on by a tree of Parzen estimators (TPE) from what these have found. Rounds know nothing of each
other, so a search does not stay where it was lucky once.

A seed gives the same attack whatever the number of jobs: runs are asked for, and told, in batches
of the same size in a fixed order.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
import optuna
from numpy.typing import NDArray
from optuna.trial import TrialState, create_trial
from scipy.stats import qmc

from scara_drake.attack.bounds import Attack, Bound, shares_of
from scara_drake.attack.trial import Problem, Trial, tried
from scara_drake.common import checks
from scara_drake.common.parallel import side_by_side

Array = NDArray[np.float64]

BATCH: Final = 8  # runs that are asked for before their harm is known
ROUND: Final = 500  # runs of an estimator, which slows down as they grow
SOBOL: Final = 0.25  # share of a round that is a Sobol sequence
ALONE: Final = 0.5  # share of all runs that the fields alone may take, at most
LEFT: Final = -0.25  # a draw below zero, down to this, leaves its field alone


@dataclass(frozen=True)
class Plan:
    """How a search goes.

    Attributes:
        runs: in all.
        seed: of the search.
        jobs: side by side; all cores if None. They change nothing but the time.
        first: whether it ends with the batch that has the first breach.
    """

    runs: int = 200
    seed: int = 0
    jobs: int | None = None
    first: bool = False

    def check(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: one is out of its bounds.
        """
        checks.number("runs", self.runs, 1, 1_000_000)
        checks.number("seed", self.seed, 0, 2**31 - 1)


def search(
    problem: Problem, plan: Plan, show: Callable[[Sequence[Trial]], None] = lambda trials: None
) -> list[Trial]:
    """Return the runs of a search, in order.

    Args:
        problem: what is attacked.
        plan: how.
        show: is called after each batch with the runs so far.

    Raises:
        ValueError: a number of the plan is out of its bounds.
    """
    plan.check()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    trials: list[Trial] = []
    for batch, tell in _batches(problem.bounds, plan):
        made = list(side_by_side(partial(tried, problem), batch, plan.jobs))
        tell(made)
        trials += made
        show(trials)
        if plan.first and any(trial.breach for trial in made):
            break
    return trials


Batch = tuple[list[Attack], Callable[[Sequence[Trial]], None]]


def _batches(bounds: Sequence[Bound], plan: Plan) -> Iterator[Batch]:
    """Yield attacks, and what is to be told of their runs."""
    alone: list[Trial] = []
    singles = [{}, *alone_attacks(bounds)][: max(round(ALONE * plan.runs), 1)]
    for begin in range(0, len(singles), BATCH):
        yield singles[begin : begin + BATCH], alone.extend
    done, sobol = len(singles), qmc.Sobol(len(bounds), rng=plan.seed)
    for number in range(plan.runs):
        count = min(ROUND, plan.runs - done)
        if count <= 0:
            return
        yield from _Round(bounds, alone, plan.seed, number).batches(count, sobol)
        done += count


def alone_attacks(bounds: Sequence[Bound]) -> list[Attack]:
    """Return attacks on each field alone: at its high end first, then at its low end.

    Of words, each.
    """
    ends = [[*bound.words, None] if bound.words else [bound.high, bound.low] for bound in bounds]
    depth = max(map(len, ends))
    return [
        {bound.label: values[place]}
        for place in range(depth)
        for bound, values in zip(bounds, ends, strict=True)
        if place < len(values) and values[place] is not None
    ]


class _Round:
    """An Optuna study in memory; what it draws of a field is its share of the range."""

    def __init__(
        self, bounds: Sequence[Bound], alone: Sequence[Trial], seed: int, number: int
    ) -> None:
        self._bounds = bounds
        self._space: dict[str, Any] = {
            bound.label: optuna.distributions.FloatDistribution(LEFT, 1.0) for bound in bounds
        }
        draws = np.random.SeedSequence([seed, number]).generate_state(1)
        sampler = optuna.samplers.TPESampler(seed=int(draws[0]), n_startup_trials=0)
        self._study = optuna.create_study(direction="maximize", sampler=sampler)
        for trial in alone if number == 0 else []:
            self._study.add_trial(self._known(trial))

    def batches(self, count: int, sobol: qmc.Sobol) -> Iterator[Batch]:
        """Yield `count` attacks in batches."""
        points = max(round(SOBOL * count), 1)
        for row in _rows(sobol, points):
            drawn = LEFT + (1.0 - LEFT) * row
            self._study.enqueue_trial(dict(zip(self._space, drawn.tolist(), strict=True)))
        for begin in range(0, count, BATCH):
            asked = [self._study.ask(self._space) for _ in range(min(BATCH, count - begin))]
            yield [self._attack(trial.params) for trial in asked], partial(self._tell, asked)

    def _attack(self, draws: dict[str, float]) -> Attack:
        pairs = zip(self._bounds, draws.values(), strict=True)
        return {bound.label: bound.value(draw) for bound, draw in pairs if draw >= 0.0}

    def _tell(self, asked: Sequence[optuna.Trial], made: Sequence[Trial]) -> None:
        for trial, result in zip(asked, made, strict=True):
            if result.counts:
                self._study.tell(trial, result.harm)
            else:
                self._study.tell(trial, state=TrialState.PRUNED)

    def _known(self, trial: Trial) -> optuna.trial.FrozenTrial:
        shares = shares_of(self._bounds, trial.attack)
        draws = np.where(np.isnan(shares), 0.5 * LEFT, shares.clip(0.0, 1.0))
        return create_trial(
            params=dict(zip(self._space, draws.tolist(), strict=True)),
            distributions=self._space,
            value=trial.harm if trial.counts else None,
            state=TrialState.COMPLETE if trial.counts else TrialState.PRUNED,
        )


def _rows(sobol: qmc.Sobol, count: int) -> Array:
    """Return the next points of the sequence; it warns of a count that is no power of two."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(sobol.random(count))

"""Search of a controller's gains: the lowest cost of a scenario, within the chatter rule.

The cost is that of `tuning.cost`, in which the start gains cost 1 + w; the gains and their ranges
are those of `tuning.space`, where every trial obeys the rule.
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import optuna
from optuna.trial import FrozenTrial, Trial, TrialState
from sqlalchemy.exc import SQLAlchemyError

from scara_drake.common import checks
from scara_drake.scenario import Scenario, check_scenario, dump_scenario
from scara_drake.simulation.interrupt import DeferredInterrupt
from scara_drake.tuning.cost import DEFAULT_AIM, Aim, Cost, Figures
from scara_drake.tuning.space import candidate, search_space, start_point
from scara_drake.tuning.trials import Simulators, simulators

STUDY_NAME: Final = "gains"


@dataclass(frozen=True)
class Tuned:
    """What a search found.

    Attributes:
        scenario: the start scenario with the best gains.
        start, best: figures of the start and of the best gains.
        start_cost, best_cost: J.
        trials: how many gains were tried, with those of earlier runs of the study.
        failed: how many of them had no cost, because the run broke off.
        interrupted: whether an interrupt (Ctrl-C) ended the search.
    """

    scenario: Scenario
    start: Figures
    best: Figures
    start_cost: float
    best_cost: float
    trials: int
    failed: int
    interrupted: bool


def tune(
    scenario: Scenario,
    trials: int = 100,
    seed: int = 0,
    duration: float | None = None,
    study: Path | None = None,
    aim: Aim = DEFAULT_AIM,
    jobs: int = 1,
    show: Callable[[int, float], None] = lambda trials, cost: None,
) -> Tuned:
    """Search the gains of a scenario's controller by a tree of Parzen estimators (TPE).

    The first trial is the start, so the result is never worse. The draws of a trial depend on the
    seed and on how many trials there were before: a study that is continued goes on as if it had
    never stopped (with one job; several are told of each other's results in rounds). An interrupt
    (Ctrl-C) ends the search with what was found.

    Args:
        scenario: from `load_scenario`; it is not changed.
        trials: how many gains to try in all, those that the study already has included.
        seed: of the search; the scenario keeps its own.
        duration: of a run [s], in place of the scenario's.
        study: SQLite file that keeps the trials, to go on later; it may exist.
        aim: what the cost is made of.
        jobs: how many runs go side by side: in threads, or in processes where they need Drake. With
            more than one, a script of your own calls this under ``if __name__ == "__main__":``.
        show: is called after every trial with the number of trials and the lowest cost.

    Raises:
        ValueError: a value is out of its bounds, the controller has no gains to search, the
            operator is a live device, or the study is of another search.
        RuntimeError: the run with the start gains fails.
        KeyboardInterrupt: Ctrl-C before the start had been simulated.
    """
    checks.number("trials", trials, 1, 1_000_000)
    checks.number("seed", seed, 0, 2**63 - 1)
    checks.number("jobs", jobs, 1, 64)
    aim.check()
    trial_scenario = _trial_scenario(scenario, duration)
    cost = Cost(aim.tracking, aim.effort_weight, trial_scenario.duration)
    search = _Search(trial_scenario, cost, seed, study)
    interrupted = False
    with DeferredInterrupt() as interrupt, simulators(jobs) as simulate_all:
        try:
            while (done := len(search.finished())) < trials and not interrupt.pressed:
                # The costs of all others are in units of the start's.
                count = min(jobs, trials - done) if search.has_start() else 1
                for _ in search.step(count, simulate_all):
                    show(len(search.finished()), _value(search.best()))
        except KeyboardInterrupt:
            interrupted = True
    if not search.has_start():
        raise KeyboardInterrupt
    return search.result(scenario, interrupted or interrupt.pressed)


def _trial_scenario(scenario: Scenario, duration: float | None) -> Scenario:
    """Return the scenario that the trials run, of a duration [s]."""
    operator = scenario.operator
    if getattr(operator, "is_live", False):
        device = getattr(operator, "device", type(operator).__name__)
        raise ValueError(
            f"operator.device: '{device}', allowed trace: the trials are to be of the same motion"
        )
    trial_scenario = replace(scenario)
    trial_scenario.duration = scenario.duration if duration is None else duration
    trial_scenario.logging = replace(scenario.logging, period=max(scenario.time_step, 1e-3))
    check_scenario(trial_scenario)
    return trial_scenario


class _Search:
    """An Optuna study of the gains of one scenario, in memory or in a file.

    A trial that has a cost is COMPLETE, one whose run failed is PRUNED; one that was cut off is
    marked FAIL, which the sampler passes over, and not counted.
    """

    def __init__(self, scenario: Scenario, cost: Cost, seed: int, path: Path | None):
        self._scenario, self._cost, self._seed = scenario, cost, seed
        part, period = scenario.controller, scenario.time_step
        self._space = search_space(part, period)
        if not self._space:
            raise ValueError(f"controller: {type(part).__name__}, allowed one with lists of gains")
        # Optuna would tell of every trial, and of features of its own that are experimental.
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._study = _open_study(path, self._problem())
        for trial in self._study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            self._study.tell(trial.number, state=TrialState.FAIL)

    def finished(self) -> list[FrozenTrial]:
        """Return the trials that count, the oldest first."""
        states = (TrialState.COMPLETE, TrialState.PRUNED)
        return self._study.get_trials(deepcopy=False, states=states)

    def has_start(self) -> bool:
        """Whether the start has been simulated; it is the first trial that counts."""
        return bool(self.finished())

    def start(self) -> FrozenTrial:
        """Return the trial of the start gains."""
        return self.finished()[0]

    def best(self) -> FrozenTrial:
        """Return the trial of the lowest cost, of equal ones the first."""
        return min(self.finished(), key=_value)

    def gains(self, trial: FrozenTrial | Trial) -> Any:
        """Return the controller of a trial; of the start, the very part it is."""
        if not self.has_start() or trial.number == self.start().number:
            return self._scenario.controller
        return candidate(self._scenario.controller, trial.params, self._scenario.time_step)

    def result(self, scenario: Scenario, interrupted: bool) -> Tuned:
        """Return what was found, `scenario` being the start."""
        finished, start, best = self.finished(), self.start(), self.best()
        found = replace(scenario)
        found.controller = copy.deepcopy(self.gains(best))
        return Tuned(
            scenario=found,
            start=_stored_figures(start),
            best=_stored_figures(best),
            start_cost=_value(start),
            best_cost=_value(best),
            trials=len(finished),
            failed=sum(trial.state == TrialState.PRUNED for trial in finished),
            interrupted=interrupted,
        )

    def step(self, count: int, simulate_all: Simulators) -> Iterator[Trial]:
        """Ask for `count` trials, simulate them, and yield each when its cost is known."""
        starting = not self.has_start()
        trials = [self._ask(index) for index in range(count)]
        tasks = []
        for trial in trials:
            scenario = replace(self._scenario)
            scenario.controller = self.gains(trial)
            tasks.append((scenario, self._cost, starting))
        for trial, figures in zip(trials, simulate_all(tasks), strict=True):
            if figures is None:
                self._study.tell(trial, state=TrialState.PRUNED, skip_if_finished=True)
            else:
                trial.set_user_attr("tracking", figures.tracking.tolist())
                trial.set_user_attr("effort", figures.effort.tolist())
                start = figures if starting else _stored_figures(self.start())
                self._study.tell(trial, self._cost(figures, start), skip_if_finished=True)
            yield trial

    def _ask(self, index: int) -> Trial:
        done = len(self.finished())
        if done == 0:
            part, period = self._scenario.controller, self._scenario.time_step
            self._study.enqueue_trial(start_point(part, period), skip_if_exists=True)
        draws = np.random.SeedSequence([self._seed, done + index]).generate_state(1)
        self._study.sampler = optuna.samplers.TPESampler(seed=int(draws[0]))
        return self._study.ask({**self._space})

    def _problem(self) -> str:
        """Describe all that a cost depends on."""
        space = {name: repr(distribution) for name, distribution in self._space.items()}
        description = {
            "scenario": dump_scenario(self._scenario),
            "tracking": self._cost.tracking,
            "effort_weight": self._cost.effort_weight,
            "space": space,
        }
        return json.dumps(description)


def _open_study(path: Path | None, problem: str) -> optuna.Study:
    storage = None
    if path is not None:
        if path.suffix != ".db" or path.is_dir() or "?" in str(path):
            raise ValueError(f"study: '{path}', allowed a file that ends in .db")
        path.parent.mkdir(parents=True, exist_ok=True)
        storage = f"sqlite:///{path}"
    try:
        study = optuna.create_study(storage=storage, study_name=STUDY_NAME, load_if_exists=True)
    except (SQLAlchemyError, RuntimeError) as error:
        reason = str(error).partition("\n")[0]
        raise ValueError(f"study: '{path}', allowed a file of this command ({reason})") from None
    if study.user_attrs.setdefault("problem", problem) != problem:
        raise ValueError(
            f"study: '{path}' is of another scenario, duration or cost, allowed the same ones, or "
            "another file"
        )
    study.set_user_attr("problem", problem)
    return study


def _value(trial: FrozenTrial) -> float:
    """Return the cost of a trial, infinite if its run failed."""
    return math.inf if trial.value is None else trial.value


def _stored_figures(trial: FrozenTrial) -> Figures:
    attributes = trial.user_attrs
    return Figures(np.array(attributes["tracking"]), np.array(attributes["effort"]))

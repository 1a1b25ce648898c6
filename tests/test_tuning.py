from dataclasses import dataclass, field, make_dataclass, replace

import numpy as np
import optuna
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import joints, load_scenario, robot
from scara_drake.common import fields
from scara_drake.common.fields import check
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.inverse_dynamics import InverseDynamics
from scara_drake.control.pid import Pid
from scara_drake.control.sliding_mode import SlidingMode
from scara_drake.scenario import check_scenario
from scara_drake.simulation import many
from scara_drake.tuning import trials as tuning
from scara_drake.tuning.cost import Aim, Cost, Figures, itae, rms
from scara_drake.tuning.search import tune
from scara_drake.tuning.space import FACTOR, candidate, search_space, smallest_layer, start_point

TS = 1e-3
SHORT = 0.05  # [s]


@dataclass
class QuickRule(IntegralSlidingMode):
    """A rule that takes no time to check: that of a drive with its nominal inertia alone."""

    def check_sampling(self, name, period, model=None):
        if (period * (np.divide(self.rho, self.phi) + self.k) >= 2.0).any():
            raise ValueError("chatters")


def short(**overrides):
    scenario = load_scenario("joint_sine", {"duration": SHORT, **overrides})
    scenario.controller = QuickRule(**vars(scenario.controller))
    return scenario


def recording(time, error, effort):
    """A recording of six equal joints."""
    six = {"joint": list(joints.JOINT_NAMES)}
    error, effort = (np.repeat(np.asarray(a)[:, None], 6, axis=1) for a in (error, effort))
    return xr.Dataset(
        {
            "q_desired": (("time", "joint"), error),
            "q_measured": (("time", "joint"), np.zeros_like(error)),
            "tau_applied": (("time", "joint"), effort),
        },
        coords={"time": time, **six},
    )


# The cost.


def test_figures_of_signals_whose_figures_are_known():
    time = np.linspace(0.0, 1.0, 1001)[:, None]
    np.testing.assert_allclose(rms(time[:, 0], np.sin(2 * np.pi * time[:-1])), 0.5**0.5, rtol=1e-6)
    # int t |e| dt of a constant is |e| T² / 2, of a ramp e = -t it is T³ / 3.
    np.testing.assert_allclose(itae(time[:, 0], np.full_like(time, -3.0)), 1.5, rtol=1e-12)
    np.testing.assert_allclose(itae(time[:, 0], -time), 1.0 / 3.0, rtol=1e-5)


def test_figures_count_from_the_first_second_on():
    time = np.linspace(0.0, 3.0, 3001)
    late = time >= 1.0 - 1e-9
    error = np.where(late, 0.25, 99.0)
    # A zigzag of 5 after the first second: 2000 steps of 5.
    effort = np.where(late, 5.0 * (np.arange(3001) % 2), 1e3 * np.arange(3001))
    for tracking, figure in (("rmse", 0.25), ("itae", 0.25 * 2.0**2 / 2.0)):
        figures = Cost(tracking, 0.1, 3.0).figures(recording(time, error, effort))
        np.testing.assert_allclose(figures.tracking, figure, rtol=1e-9)
        np.testing.assert_allclose(figures.effort, 2000 * 5.0, rtol=1e-12)


def test_figures_of_a_short_run_count_from_its_middle():
    time = np.linspace(0.0, 0.5, 501)
    error = np.where(time >= 0.25 - 1e-9, 1e-3, 7.0)
    figures = Cost("rmse", 0.1, 0.5).figures(recording(time, error, error))
    np.testing.assert_allclose(figures.tracking, 1e-3)


@pytest.mark.parametrize("tracking", ["rmse", "itae"])
def test_the_start_costs_one_and_the_weight(tracking):
    cost = Cost(tracking, 0.3, 3.0)
    start = Figures(np.array([1e-3, 2e-3, 0.0, 1e-12, 5.0, 1.0]), np.array([0, 1e4, 1, 2, 3, 4.0]))
    assert cost(start, start) == pytest.approx(1.3, rel=1e-12)


def test_cost_by_hand():
    cost = Cost("rmse", 0.5, 3.0)
    start = Figures(np.full(6, 9e-6), 9e-3 * joints.EFFORT)
    # Errors of 4 µm + 1 µm over 9 µm + 1 µm, variations of 2.9 % + 0.1 % over 0.9 % + 0.1 %.
    assert cost(Figures(np.full(6, 4e-6), 2.9e-2 * joints.EFFORT), start) == pytest.approx(
        0.5 + 0.5 * 3.0, rel=1e-12
    )
    # A joint that errs less than the resolution at the start may err by it without much cost.
    still = Figures(np.zeros(6), np.zeros(6))
    assert cost(Figures(np.full(6, 1e-6), np.zeros(6)), still) == pytest.approx(2.5, rel=1e-12)


# The space.


def drake_number(gain, period):
    """T_s lambda_max(M^-1 diag(gain)), the largest of a few hundred postures, by Drake."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    largest = 0.0
    for q in np.random.default_rng(7).uniform(joints.LOWER, joints.UPPER, (300, 6)):
        plant.SetPositions(context, q)
        ratio = np.linalg.solve(plant.CalcMassMatrix(context), np.diag(gain))
        largest = max(largest, np.abs(np.linalg.eigvals(ratio)).max())
    return period * largest


@settings(deadline=None, max_examples=8)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_every_candidate_is_within_the_chatter_rule(seed, extreme):
    part = IntegralSlidingMode(k=[300.0] * 6)
    rng = np.random.default_rng(seed)
    parameters = {}
    for name, distribution in search_space(part, TS).items():
        low, high = np.log(distribution.low), np.log(distribution.high)
        share = rng.integers(0, 2) if extreme else rng.uniform()
        parameters[name] = float(np.exp(low + share * (high - low)))
    parameters["margin"] = min(parameters["margin"], 1.0)
    found = candidate(part, parameters, TS)
    found.check_sampling("controller", TS)
    slope = np.divide(found.rho, found.phi) + found.k
    assert drake_number(robot.nominal_inertias() * slope, TS) < 2.0


def test_the_parameters_of_the_start_give_the_start():
    part = IntegralSlidingMode()
    found = candidate(part, start_point(part, TS), TS)
    for gain in ("c", "k", "rho", "phi"):
        np.testing.assert_allclose(getattr(found, gain), getattr(part, gain), rtol=1e-12)
    space = search_space(part, TS)
    assert len(space) == 19
    assert all(space[name].low <= value <= space[name].high for name, value in
               start_point(part, TS).items())  # fmt: skip


def test_the_full_margin_is_the_smallest_layer():
    part = IntegralSlidingMode()
    parameters = start_point(part, TS) | {"margin": 1.0}
    found = candidate(part, parameters, TS)
    thinner = replace(found, phi=[phi / 1.06 for phi in found.phi])
    with pytest.raises(ValueError, match="chatters"):
        thinner.check_sampling("controller", TS)
    assert 1.0 <= smallest_layer(found, TS) * 1.05 <= 1.06


def test_a_start_outside_the_rule_is_searched_inside():
    part = IntegralSlidingMode(phi=[1e-4] * 6, allow_chatter=True)
    found = candidate(part, start_point(part, TS), TS)
    assert not found.allow_chatter
    found.check_sampling("controller", TS)


@dataclass
class OwnGains:
    """A controller part of the user's own, with a rule about its first gain."""

    p: list[float] = field(default_factory=lambda: [10.0, 20.0])
    d: list[float] = field(default_factory=lambda: [0.0, 3.0])
    kinds: list[str] = field(default_factory=lambda: ["a", "b"])
    on: list[bool] = field(default_factory=lambda: [True, False])
    scalar: float = 1.0

    def check_sampling(self, name, period, model=None):
        if self.p[0] > 15.0:
            raise ValueError("too stiff")


def test_the_gains_of_a_part_of_ones_own():
    part = OwnGains()
    space = search_space(part, TS)
    assert list(space) == ["p[0]", "p[1]", "d[1]"]  # a gain of zero stays zero
    assert (space["p[1]"].low, space["p[1]"].high) == (20.0 / FACTOR, 20.0 * FACTOR)
    parameters = {"p[0]": 40.0, "p[1]": 5.0, "d[1]": 12.0}
    found = candidate(part, parameters, TS)
    # All gains go back on the way to the start, to a quarter: 10 * 4^0.25 = 14.1 < 15.
    np.testing.assert_allclose(found.p, [10 * 4**0.25, 20 * 4**-0.25])
    np.testing.assert_allclose(found.d, [0.0, 3 * 4**0.25])
    assert (found.kinds, found.on, found.scalar) == (["a", "b"], [True, False], 1.0)
    assert candidate(part, parameters | {"p[0]": 11.0}, TS).p == [11.0, 5.0]


@pytest.mark.parametrize(
    ("part", "names"),
    [
        (SlidingMode(), ["c", "margin", "rho"]),
        (Pid(), ["kd", "ki", "kp"]),
        (InverseDynamics(), ["kd", "ki", "kp"]),
    ],
)
def test_other_controllers_are_searched_within_their_rules(part, names):
    space = search_space(part, TS)
    assert sorted({name.partition("[")[0] for name in space}) == names
    rng = np.random.default_rng(5)
    for _ in range(4):
        found = candidate(part, {n: rng.uniform(d.low, d.high) for n, d in space.items()}, TS)
        check(found, "controller")
        found.check_sampling("controller", TS)
        assert found != part
    scenario = short()
    scenario.controller = part
    result = tune(scenario, trials=2)
    assert result.trials == 2
    assert result.start_cost == pytest.approx(1.1)


# The search.


def test_the_result_is_never_worse_and_the_start_is_the_first_trial():
    costs = []
    scenario = short()
    gains = replace(scenario.controller)
    result = tune(scenario, trials=5, show=lambda done, cost: costs.append((done, cost)))
    assert costs[0] == (1, pytest.approx(1.1, rel=1e-12))
    assert [done for done, _ in costs] == [1, 2, 3, 4, 5]
    assert result.best_cost == costs[-1][1] < result.start_cost == costs[0][1]
    cost = Cost("rmse", 0.1, SHORT)
    assert result.best_cost == pytest.approx(cost(result.best, result.start), rel=1e-12)
    assert (result.trials, result.failed, result.interrupted) == (5, 0, False)
    assert scenario.controller == gains
    again = tune(result.scenario, trials=1)
    np.testing.assert_array_equal(again.start.tracking, result.best.tracking)
    np.testing.assert_array_equal(again.start.effort, result.best.effort)


def test_one_trial_is_the_start():
    scenario = short()
    result = tune(scenario, trials=1, aim=Aim(effort_weight=0.0))
    assert result.scenario == scenario
    assert result.best_cost == pytest.approx(1.0, rel=1e-12)


def same(first, second):
    return (first.scenario, first.best_cost) == (second.scenario, second.best_cost)


@pytest.fixture
def tried(monkeypatch):
    """The controllers that are simulated, in order."""
    controllers, simulated = [], tuning.simulate_task

    def simulate_task(task, *engine):
        controllers.append(task[0].controller)
        return simulated(task, *engine)

    monkeypatch.setattr(tuning, "simulate_task", simulate_task)
    return controllers


def test_a_study_goes_on_as_if_it_had_never_stopped(tmp_path, tried):
    path, scenario = tmp_path / "deep" / "study.db", short()
    # More than the ten trials that are drawn at random before the estimators begin.
    at_once = tune(scenario, trials=12, seed=3)
    for trials in (1, 3, 12):
        in_parts = tune(scenario, trials=trials, seed=3, study=path)
    assert same(at_once, in_parts)
    assert tried[:12] == tried[12:]
    assert len({str(controller) for controller in tried}) == 12
    # A study that has enough trials is not simulated again.
    assert same(tune(scenario, trials=2, seed=3, study=path), at_once)
    assert len(tried) == 24


@pytest.mark.parametrize("done", [0, 2])
def test_a_trial_that_was_cut_off_does_not_count(tmp_path, monkeypatch, done):
    path, scenario = tmp_path / "study.db", short()
    calls = []
    simulated = tuning.simulate_task

    def killed(task, *engine):
        calls.append(task)
        if len(calls) > done:
            raise SystemExit
        return simulated(task, *engine)

    monkeypatch.setattr(tuning, "simulate_task", killed)
    with pytest.raises(SystemExit):
        tune(scenario, trials=4, study=path)
    monkeypatch.undo()
    result = tune(scenario, trials=4, study=path)
    assert result.trials == 4
    study = optuna.load_study(study_name=None, storage=f"sqlite:///{path}")
    states = [trial.state.name for trial in study.get_trials()]
    assert (states.count("COMPLETE"), states.count("FAIL"), len(states)) == (4, 1, 5)
    assert same(result, tune(scenario, trials=4))


def test_seeds_differ(tried):
    for seed in (0, 1):
        tune(short(), trials=3, seed=seed)
    assert tried[0] == tried[3]  # the start
    assert all(first != second for first, second in zip(tried[1:3], tried[4:], strict=True))


def test_a_study_of_something_else_is_refused(tmp_path):
    path = tmp_path / "study.db"
    tune(short(), trials=1, study=path)
    for scenario, options in (
        (short(**{"controller.k": 40.0}), {}),
        (short(), {"duration": 0.06}),
        (short(), {"aim": Aim("itae")}),
        (short(), {"aim": Aim(effort_weight=0.2)}),
    ):
        with pytest.raises(ValueError, match=r"study: .* is of another scenario"):
            tune(scenario, trials=1, study=path, **options)


def test_a_file_that_is_no_study_is_refused_and_left_alone(tmp_path):
    path = tmp_path / "notes.db"
    path.write_text("not a database, but notes " * 100)
    with pytest.raises(ValueError, match="allowed a file of this command"):
        tune(short(), trials=1, study=path)
    assert path.read_text().startswith("not a database")


def test_a_run_that_fails_has_no_cost(tmp_path, monkeypatch):
    simulated, count = many.run, 0

    def run(*arguments, **more):
        nonlocal count
        count += 1
        if count == 2:
            raise RuntimeError("controller: state[3] is nan")
        return simulated(*arguments, **more)

    monkeypatch.setattr(many, "run", run)
    result = tune(short(), trials=4)
    assert (result.trials, result.failed) == (4, 1)
    assert np.isfinite(result.best_cost)


def test_a_start_that_fails_is_an_error(monkeypatch):
    def run(*arguments, **more):
        raise RuntimeError("controller: state[3] is nan")

    monkeypatch.setattr(many, "run", run)
    with pytest.raises(RuntimeError, match=r"state\[3\] is nan"):
        tune(short(), trials=4)


def test_an_interrupt_ends_the_search_with_the_best_so_far(monkeypatch):
    simulated, count = many.run, 0

    def run(*arguments, **more):
        nonlocal count
        count += 1
        result = simulated(*arguments, **more)
        return replace(result, ended_by="interrupt") if count == stop else result

    monkeypatch.setattr(many, "run", run)
    stop = 3
    result = tune(short(), trials=50)
    assert result.interrupted
    assert result.trials == 2
    count, stop = 0, 1
    with pytest.raises(KeyboardInterrupt):
        tune(short(), trials=50)


@pytest.mark.slow
def test_two_processes_simulate_alike():
    scenario = load_scenario("joint_sine", {"duration": SHORT})
    result = tune(scenario, trials=5, jobs=2)
    assert result.trials == 5
    again = tune(result.scenario, trials=1)
    np.testing.assert_array_equal(again.start.tracking, result.best.tracking)


def test_optuna_says_nothing(capfd):
    optuna.logging.set_verbosity(optuna.logging.INFO)
    tune(short(), trials=2)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"trials": 0}, "trials: 0, allowed 1 to"),
        ({"seed": -1}, "seed: -1, allowed 0 to"),
        ({"jobs": 0}, "jobs: 0, allowed 1 to 64"),
        ({"aim": Aim("mae")}, "tracking: 'mae', allowed rmse, itae"),
        ({"aim": Aim(effort_weight=float("nan"))}, "effort_weight: nan, allowed 0 to"),
        ({"duration": 0.0}, "duration: 0.0, allowed 0.001 to"),
    ],
)
def test_bad_values_are_refused(tmp_path, options, message):
    with pytest.raises(ValueError, match=message):
        tune(short(), study=tmp_path / "study.db", **options)
    assert not list(tmp_path.iterdir())


def test_a_live_device_is_refused():
    scenario = load_scenario("teleoperation", {"operator.device": "auto"})
    with pytest.raises(ValueError, match=r"operator.device: 'auto', allowed trace"):
        tune(scenario, trials=1)


@dataclass
class NoGains:
    def make_system(self, period):
        return None


def test_a_controller_without_gains_is_refused():
    scenario = short()
    scenario.controller = NoGains()
    with pytest.raises(ValueError, match="controller: NoGains, allowed one with lists of gains"):
        tune(scenario, trials=1)


@pytest.mark.slow
def test_the_gains_of_the_sines_get_much_better():
    result = tune(load_scenario("joint_sine"), trials=40, duration=3.0)
    assert result.best_cost < 0.7 * result.start_cost
    check_scenario(result.scenario)


Declared = make_dataclass(
    "Declared",
    [
        ("k", list[float], fields.vector([10.0, 50.0], "1/s", fields.ABOVE_ZERO, 60.0)),
        ("m", list[float], fields.vector([2.0, 0.0], "kg", 1.0, 8.0)),
        ("offset", list[float], fields.vector([1.0, 2.0], "m")),
        ("sense", list[str], fields.words(["a", "b"], ("a", "b"))),
        ("plain", list[float], field(default_factory=lambda: [3.0])),
    ],
)


def test_the_ranges_keep_to_the_bounds_of_the_fields():
    space = search_space(Declared(), TS)
    ranges = {name: (found.low, found.high) for name, found in space.items()}
    assert ranges == {
        "k[0]": (2.5, 40.0),
        "k[1]": (12.5, 60.0),
        "m[0]": (1.0, 8.0),
        "plain[0]": (0.75, 12.0),
    }

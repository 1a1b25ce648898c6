"""The red team: what it may do, what it finds, how small it makes it, and what it says."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from faulty_couplings import Credulous, Forgetful
from hypothesis import given
from hypothesis import strategies as st
from kinds import of_kind
from strategies import examples

from scara_drake import load_scenario, simulate
from scara_drake.attack.bounds import BOUNDS, Bound, bounds_of
from scara_drake.attack.coverage import coverage_of
from scara_drake.attack.objectives import OBJECTIVES, energy_accounts, thresholds_of
from scara_drake.attack.report import Report, save_smallest
from scara_drake.attack.search import Plan, alone_attacks, search
from scara_drake.attack.shrink import shrink
from scara_drake.attack.space import DURATION, attacked, shortened
from scara_drake.attack.trial import Problem, Trial, tried
from scara_drake.channel.packets import Packets
from scara_drake.cli.main import main
from scara_drake.coupling.tdpa import Tdpa
from scara_drake.scenario import check_scenario
from scara_drake.studies.figures import METRICS

CALM: dict[str, Any] = {  # direct, with a tenth of the force and a soft wall
    "coupling": "!Direct {force_scale: 0.1}",
    "environment.surfaces.0.stiffness": 1000.0,
    "channel.up.delay": 0.0,
    "channel.down.delay": 0.0,
}
WAVES: dict[str, Any] = {
    "coupling": "!WaveVariables {}",
    "channel.up.delay": 0.01,
    "channel.down.delay": 0.01,
}


def problem(
    objective: str,
    overrides: dict[str, Any] | None = None,
    coupling: Tdpa | None = None,
    duration: float = 3.0,
    bounds: tuple[str, ...] = (),
) -> Problem:
    scenario = load_scenario("bilateral", overrides)
    if coupling is not None:
        scenario.coupling = coupling
    scenario = shortened(scenario, duration)
    return Problem(scenario, bounds_of(scenario, bounds), thresholds_of(scenario, [objective]))


def attack(case: Problem, seed: int = 0, runs: int = 199, first: bool = True) -> Report:
    plan = Plan(runs, seed, 2, first)
    trials = search(case, plan)
    shrunk = shrink(case, trials, 2) if any(trial.breach for trial in trials) else None
    return Report(case, plan, trials, shrunk, 0.0)


@cache
def of_direct() -> Report:
    return attack(problem("unrest", CALM))


def smallest(report: Report) -> dict[str, Any]:
    """The fields of the smallest attack, without the duration."""
    assert report.shrunk is not None
    return {name: v for name, v in report.shrunk.trial.attack.items() if name != DURATION}


# The space.


@pytest.mark.parametrize("bound", BOUNDS, ids=lambda bound: bound.label)
def test_a_field_alone_changes_the_scenario_and_left_alone_it_does_not(bound: Bound) -> None:
    scenario = shortened(load_scenario("bilateral"), 3.0)
    as_it_is = attacked(scenario, {})
    depends = {  # says how, not whether
        "channel.swing_rate": {"channel.swing": 0.1},
        "channel.spread": {"channel.jitter": 0.01},
        "channel.distribution": {"channel.jitter": 0.01},
        "channel.burst": {"channel.loss": 0.1},
        "channel.outage_at": {"channel.outage": 0.1},
        "channel.side": {"channel.loss": 0.1},
        "hand.sweep_rate": {"hand.sweep": 0.01},
    }.get(bound.label, {})
    assert attacked(scenario, {bound.label: bound.own(scenario)}) == as_it_is
    beside = attacked(scenario, depends)
    assert attacked(scenario, {**depends, bound.label: bound.value(1.0)}) != beside
    assert scenario == shortened(load_scenario("bilateral"), 3.0)


def test_the_links_as_packets_change_no_bit() -> None:
    scenario = shortened(load_scenario("bilateral"), 0.3)
    packets = attacked(scenario, {})
    assert isinstance(packets.channel.up, Packets)
    before, after = simulate(scenario), simulate(packets)
    for name in ("x_master", "f_master", "energy_slave_out", "q_measured"):
        np.testing.assert_array_equal(before[name], after[name])


@examples(100)
@given(st.lists(st.none() | st.floats(0.0, 1.0), min_size=len(BOUNDS), max_size=len(BOUNDS)))
def test_every_attack_within_the_bounds_is_a_scenario(shares: list[float | None]) -> None:
    scenario = shortened(load_scenario("bilateral"), 3.0)
    pairs = zip(bounds_of(scenario), shares, strict=True)
    values = {bound.label: bound.value(share) for bound, share in pairs if share is not None}
    check_scenario(attacked(scenario, values))


@given(share=st.floats(0.0, 1.0))
@examples(20)
def test_a_share_of_a_range_is_found_again(share: float) -> None:
    for bound in BOUNDS:
        value = bound.value(share)
        assert value in bound.words if bound.words else bound.low <= float(value) <= bound.high
        steps = len(bound.words) - 1 if bound.words else bound.high if bound.whole else 1e6
        assert bound.share(value) == pytest.approx(share, abs=0.51 / steps + 1e-6)


def test_packets_are_lost_in_bursts_of_the_length_and_share_that_are_asked_for() -> None:
    case = shortened(load_scenario("bilateral"), 3.0)
    loss = of_kind(
        Packets, attacked(case, {"channel.loss": 0.3, "channel.burst": 20.0}).channel.up
    ).loss
    # Of a chain of two states: the share of time in the bad one, and the mean stay there.
    assert loss.to_bad / (loss.to_bad + loss.to_good) == pytest.approx(0.3)
    assert 1.0 / loss.to_good == 20.0
    assert (loss.in_good, loss.in_bad) == (0.0, 1.0)


# What counts.


def test_the_account_of_an_end_is_what_the_packet_in_use_told() -> None:
    delay, period = 0.05, 1e-3
    scenario = shortened(load_scenario("bilateral", {"channel.up.delay": delay}), 1.5)
    recording = simulate(attacked(scenario, {}))
    (_, told), _ = energy_accounts(recording, period)
    came_in = recording.energy_master_in.transpose("time", "axis").values
    # A tick to the port of the channel and one to the slave, which meters at the end of its own.
    ticks = round(delay / period) + 2
    assert came_in[-1].max() > 0.01
    np.testing.assert_array_equal(told[ticks:], came_in[:-ticks])
    np.testing.assert_array_equal(told[:ticks], 0.0)


def test_a_hand_beyond_what_the_coupling_promises_does_not_count() -> None:
    case = problem("energy", {"coupling": "!Tdpa {turn: 1.0}"}, duration=1.0)
    trial = tried(case, {"hand.sweep": 0.02, "hand.sweep_rate": 20.0})
    assert not trial.counts
    assert not trial.breach
    assert "above turn" in trial.note


def test_what_is_found_is_told_by_number_and_a_search_without_runs_covers_nothing() -> None:
    case = problem("energy")
    trials = [Trial({}, {"energy": value}, value / 1e-3) for value in (0.0, 2e-3, 5e-3)]
    report = Report(case, Plan(), trials, None, 0.0)
    assert report.found_at == 2
    assert report.best("energy") == (5e-3, 3)
    none = coverage_of(case.bounds, trials)
    assert all(field.gap == 1.0 and field.attacked == 0.0 for field in none.fields.values())
    assert none.pairs == 0.0


def test_the_limit_of_a_device_that_exists_is_its_own() -> None:
    scenario = load_scenario("bilateral", {"operator.device": "touch"})
    assert thresholds_of(scenario, ["peak"]) == {"peak": 3.3}


def test_the_coverage_is_that_of_the_runs_that_count() -> None:
    case = problem("energy", bounds=("only=channel.delay,channel.loss",))
    runs = [Trial({"channel.delay": 0.075, "channel.loss": 0.25}, {"energy": 0.0}, 0.5)]
    runs += [Trial({"channel.delay": 0.3}, note="refused")]
    coverage = coverage_of(case.bounds, runs)
    assert coverage.fields["channel.delay"].high == 0.075
    assert coverage.fields["channel.delay"].gap == pytest.approx(0.75)
    assert coverage.pairs == pytest.approx(0.01)


# The search.


def test_a_seed_gives_the_same_attack_with_any_number_of_jobs() -> None:
    case = problem("energy", duration=0.2)
    runs = [search(case, Plan(24, 5, jobs)) for jobs in (1, 3)]
    assert [trial.attack for trial in runs[0]] == [trial.attack for trial in runs[1]]
    assert [trial.values for trial in runs[0]] == [trial.values for trial in runs[1]]
    other = search(case, Plan(24, 6, 2))
    assert [trial.attack for trial in other[12:]] != [trial.attack for trial in runs[0][12:]]


def test_each_field_is_tried_alone_at_both_ends() -> None:
    scenario = shortened(load_scenario("bilateral"), 3.0)
    bounds = bounds_of(scenario)
    tried_alone = alone_attacks(bounds)
    for bound in bounds:
        ends: set[float | str] = {*bound.words} if bound.words else {bound.low, bound.high}
        assert {one[bound.label] for one in tried_alone if bound.label in one} == ends


def test_the_instability_of_the_direct_coupling_is_found_and_is_one() -> None:
    report = of_direct()
    assert report.trials[0].harm < 0.1  # calm as it is
    assert len(report.trials) < 200
    assert len(smallest(report)) == 1
    scenario = report.smallest("found")
    assert not METRICS["stable"].of(scenario, simulate(scenario))
    as_it_is = attacked(report.problem.scenario, {})
    assert METRICS["stable"].of(as_it_is, simulate(as_it_is))


def test_what_remains_is_needed() -> None:
    report = of_direct()
    assert report.shrunk is not None
    for name, harm in report.shrunk.without.items():
        assert harm < 1.0
        fewer = {each: v for each, v in report.shrunk.trial.attack.items() if each != name}
        assert tried(report.problem, fewer).harm == harm


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_the_file_that_is_written_replays_to_the_bit(engine: str, tmp_path: Path) -> None:
    report = of_direct()
    assert report.shrunk is not None
    save_smallest(report, tmp_path / "found.yaml", "scara-drake attack")
    text = (tmp_path / "found.yaml").read_text()
    assert text.startswith("# ripple of the force")
    assert f"# run it: scara-drake run {tmp_path / 'found.yaml'}" in text
    duration = 0.5 if engine == "drake" else None
    runs: list[xr.Dataset] = [
        simulate(load_scenario(tmp_path / "found.yaml"), duration, engine=engine) for _ in range(2)
    ]
    xr.testing.assert_identical(runs[0].drop_attrs(), runs[1].drop_attrs())
    if engine == "compiled":
        (value,) = report.shrunk.trial.values.values()
        scenario = load_scenario(tmp_path / "found.yaml")
        assert OBJECTIVES["unrest"].of(scenario, runs[0]) == value


def test_jitter_and_nothing_else_is_what_hurts_waves_without_a_buffer() -> None:
    case = problem("press", WAVES, duration=6.0, bounds=("only=channel.delay,channel.jitter",))
    report = attack(case)
    assert report.trials[0].harm < 0.5
    assert [*smallest(report)] == ["channel.jitter"]
    # Twenty times as much delay, without jitter, is no breach.
    delay = 20.0 * smallest(report)["channel.jitter"]
    assert not tried(case, {"channel.delay": delay}).breach


def test_energy_that_is_counted_twice_behind_a_lost_packet_is_found() -> None:
    case = problem("invariant", coupling=Forgetful(), bounds=("only=channel.delay,channel.loss",))
    report = attack(case)
    assert report.trials[0].values["invariant"] < 0.0  # nothing is lost as it is
    assert report.found_at is not None
    assert report.found_at < 200
    assert [*smallest(report)] == ["channel.loss"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_what_is_planted_is_found_within_all_bounds(seed: int) -> None:
    for coupling in (Forgetful(), Credulous()):
        report = attack(problem("invariant", coupling=coupling), seed)
        assert report.found_at is not None
        assert report.found_at < 200
    waves = attack(problem("press", WAVES, duration=6.0), seed)
    assert [*smallest(waves)] == ["channel.jitter"]


@pytest.mark.slow
def test_no_breach_of_the_invariant_is_found() -> None:
    report = attack(problem("invariant"), runs=1000, first=False)
    assert report.found_at is None
    assert max(trial.values["invariant"] for trial in report.trials if trial.counts) < 0.0


# The command line.


def line(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    status = main(["attack", *words])
    told = capsys.readouterr()
    return status, told.out, told.err


def test_the_command_tells_what_it_tried_and_its_status_whether_it_found(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    few = ("--runs", "4", "--duration", "0.5", "--jobs", "1", "--bound", "only=channel.jitter")
    status, out, _ = line(capsys, "bilateral", *few)
    assert status == 0
    assert "No breach in these runs, within these bounds. That is no proof." in out
    told = json.loads(Path("runs/bilateral_attack.json").read_text())
    assert (told["runs"], told["found_at"], told["smallest"]) == (4, None, None)
    assert told["fields"]["channel.jitter"]["allowed"] == [0.0, 0.05]
    assert not Path("runs/bilateral_attack.yaml").exists()
    direct = ("--set", "coupling=!Direct {}", "--threshold", "peak=1", "--objective", "peak")
    status, out, _ = line(capsys, "bilateral", *few, *direct, "--output", "found/it.yaml")
    assert status == 1
    assert "Breach at run 1" in out
    scenario = load_scenario("found/it.yaml")
    assert OBJECTIVES["peak"].of(scenario, simulate(scenario)) > 1.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--bound", "channel.dely=0:1"], "did you mean 'channel.delay'?"),
        (["--bound", "channel.delay=1"], "allowed channel.delay=LOW:HIGH or off"),
        (["--bound", "channel.delay=0:5"], "--bound channel.delay: "),
        (["--bound", "channel.delay=0.2:0.1"], "--bound channel.delay, high: 0.1"),
        (["--bound", "channel.side=left"], "'left', allowed both, up, down"),
        (["--bound", "hand.stiffness=-1:3"], "--bound hand.stiffness, low: -1.0, allowed above 0"),
        (["--bound", "hand.stiffness=nan:3"], "allowed above 0"),
        (["--objective", "harm"], "--objective: 'harm', allowed energy, peak"),
        (["--threshold", "peak=1"], "--threshold: 'peak', allowed energy"),
        (["--threshold", "energy=-1"], "--threshold energy: -1.0, allowed above 0"),
        (["--runs", "0"], "runs: 0, allowed 1 to"),
        (["--seed", "-1"], "seed: -1, allowed 0 to"),
        (["--jobs", "0"], "jobs: 0, allowed 1 to"),
        (["--duration", "0"], "duration: 0.0, allowed 0.1 to"),
        (["--output", "found.txt"], "--output: 'found.txt', allowed a file that ends in .yaml"),
        (
            ["--set", "coupling=!Direct {}", "--objective", "invariant"],
            "coupling: !Direct, allowed !Tdpa with the objective invariant",
        ),
    ],
)
def test_bad_input_gets_one_line_and_nothing_is_run(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    status, _, err = line(capsys, "bilateral", *words)
    assert status == 2
    assert said in " ".join(err.split())
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_only_a_master_is_attacked(capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = line(capsys, "teleoperation")
    assert status == 2
    assert "operator: !Joystick, allowed !Master" in err


def test_the_bounds_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = line(capsys, "bilateral", "--show-bounds", "--bound", "channel.delay=0:0.4")
    assert status == 0
    assert "0 to 0.4 s" in out

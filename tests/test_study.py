"""Studies: how they unfold, and what is refused before anything runs."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from small_study import small_study
from strategies import examples

import scara_drake as sd
from scara_drake.channel.delays import ConstantDelay
from scara_drake.cli.main import main
from scara_drake.common.schema import build, data_of, yaml_of
from scara_drake.common.yaml_text import read_yaml
from scara_drake.studies.figures import METRICS
from scara_drake.studies.parameters import Normal, Range, Values, text_of
from scara_drake.studies.runs import Runs
from scara_drake.studies.study import Study, load_study, study_names

BASE = """
scenario: joint_sine
duration: 0.05
parameters:
  - !Range {paths: robot.payload_mass, name: payload, low: 0.0, high: 10.0, count: 2}
metrics: [tool_error_rms]
"""


def drawn(parameters, samples, seed, design="latin_hypercube"):
    return Runs(
        small_study(parameters=parameters, samples=samples, seed=seed, design=design, repeats=1)
    )


# Grids.


@examples(30)
@given(
    st.lists(st.integers(1, 4), min_size=1, max_size=4), st.integers(1, 3), st.integers(0, 2**40)
)
def test_a_grid_has_every_combination_once_with_the_seeds_of_all(counts, repeats, seed):
    if math.prod(counts) * repeats == 1:
        counts = [2]
    parameters = [
        Range([f"controller.{name}"], name, 1.0, 2.0, count)
        for name, count in zip("abcd", counts, strict=False)
    ]
    runs = Runs(small_study(parameters=parameters, repeats=repeats, seed=seed))
    assert len(runs) == math.prod(counts) * repeats
    seen = {(*runs.values(n).values(), runs.seed(n)) for n in range(len(runs))}
    assert len(seen) == len(runs)
    for index, parameter in enumerate(parameters):
        assert {row[index] for row in seen} == set(parameter.points())
    assert {row[-1] for row in seen} == {seed + each for each in range(repeats)}
    # The order is that of the array: the last dimension is the fastest.
    places = np.arange(len(runs)).reshape(tuple(runs.dims.values()))
    last = runs.values(int(places.flat[-1]))
    assert list(last.values()) == [parameter.points()[-1] for parameter in parameters]


@examples(50)
@given(
    st.floats(-1e6, 1e6),
    st.floats(1e-3, 1e6),
    st.integers(2, 50),
    st.sampled_from(["linear", "log"]),
)
def test_a_range_is_even_from_end_to_end(low, width, count, scale):
    low = abs(low) + 1e-3 if scale == "log" else low
    points = Range(["x"], "x", low, low + width, count, scale).points()
    assert (points[0], points[-1]) == (low, low + width)
    assert len(points) == count
    even = np.linspace if scale == "linear" else np.geomspace
    np.testing.assert_allclose(points, even(low, low + width, count), rtol=1e-9, atol=1e-9 * width)


def test_a_point_of_a_grid_is_found_under_its_name():
    assert Range(["x"], "x", 0.0, 0.2, 9).points()[3] == 0.075


# Draws.


@examples(30)
@given(st.integers(2, 40), st.integers(1, 4), st.integers(0, 2**40))
def test_a_latin_hypercube_has_one_sample_in_each_stratum(samples, count, seed):
    parameters = [Range([f"controller.{name}"], name, 0.0, 1.0) for name in "abcd"[:count]]
    runs = drawn(parameters, samples, seed)
    values = np.array([list(runs.values(number).values()) for number in range(samples)])
    strata = np.floor(values * samples).astype(int)
    for column in strata.T:
        assert sorted(column) == list(range(samples))


@examples(20)
@given(st.integers(2, 40), st.integers(0, 2**40), st.sampled_from(["random", "latin_hypercube"]))
def test_the_same_seed_draws_the_same_runs(samples, seed, design):
    parameters = [
        Range(["robot.payload_mass"], "payload", 1.0, 20.0, scale="log"),
        Normal(["controller.phi"], "phi", 1.0, 0.1),
        Values(["coupling"], "coupling", ["!Tdpa {}", "!Direct {}"]),
    ]
    runs, again = (drawn(parameters, samples, seed, design) for _ in range(2))
    other = drawn(parameters, samples, seed + 1, design)
    rows = [[(r.values(n), r.seed(n)) for n in range(samples)] for r in (runs, again, other)]
    assert rows[0] == rows[1]
    assert [values for values, _ in rows[0]] != [values for values, _ in rows[2]]
    # Each run that is drawn has noise of its own.
    assert [number for _, number in rows[0]] == [seed + number for number in range(samples)]


def test_draws_have_the_distributions_that_are_asked_for():
    runs = drawn(
        [Range(["a"], "a", 1.0, 100.0, scale="log"), Normal(["b"], "b", 3.0, 2.0)], 400, 5, "random"
    )
    a, b = np.array([list(runs.values(number).values()) for number in range(400)]).T
    assert stats.kstest(np.log10(a) / 2.0, "uniform").pvalue > 1e-3
    assert stats.kstest(b, "norm", args=(3.0, 2.0)).pvalue > 1e-3


def test_a_run_s_scenario_has_its_values_and_its_seed():
    runs = Runs(small_study())
    scenario = runs.scenario(7)  # payload 10, the second controller, the second seed: 1 * 4 + 3
    assert runs.values(7)["payload"] == scenario.robot.payload_mass == 10.0
    assert type(scenario.controller).__name__ == "IntegralSlidingMode"
    assert (scenario.seed, scenario.duration) == (1, 0.05)


def test_one_value_goes_to_all_paths_of_a_parameter():
    delay = Range(["channel.up.delay", "channel.down.delay"], "delay", 0.0, 0.2, 3)
    runs = Runs(small_study(scenario="bilateral", parameters=[delay], repeats=1))
    channel = runs.scenario(1).channel
    assert channel.up == channel.down == ConstantDelay(0.1)
    assert runs.coordinates(runs.check())["delay"].attrs["units"] == "s"


# YAML.


@pytest.mark.parametrize("name", study_names())
def test_shipped_studies_load_and_their_first_values_are_allowed(name):
    study = load_study(name)
    assert study.description
    runs = Runs(study)
    runs.check()
    runs.scenario(len(runs) - 1)


def test_a_study_is_read_as_it_was_written():
    study = load_study("coupling_stability")
    assert build(Study, read_yaml(yaml_of(study), "again")) == study
    assert [p["_tag"] for p in data_of(study)["parameters"]] == ["!Values", "!Range", "!Range"]


def test_a_scenario_beside_the_study_is_found(tmp_path):
    (tmp_path / "mine.yaml").write_text("operator: !JointMotion {}\n")
    path = tmp_path / "study.yaml"
    path.write_text(BASE.replace("joint_sine", "mine.yaml"))
    assert Runs(load_study(path)).scenario(1).name == "mine"


def test_what_stands_for_a_part_says_what_it_sets():
    assert text_of(read_yaml("!Tdpa {force_scale: 0.1}", "x")) == "Tdpa force_scale 0.1"
    values = Values(["coupling"], "", ["!Direct {}", "!Tdpa {}"], ["plain", "passive"])
    assert [values.shown_as(value) for value in values.points()] == ["plain", "passive"]


# What is refused.

WRONG = {
    "unknown field": ("duration: 0.05", "durations: 0.05", "durations: unknown field"),
    "unknown path": ("payload_mass", "payload", r"robot\.payload: unknown field.*payload_mass"),
    "unknown part": ("robot.payload_mass", "robo.mass", "robo: unknown field"),
    "out of bounds": ("high: 10.0", "high: 1e6", r"robot\.payload_mass: 1000000.* 0 to 500"),
    "backwards": ("low: 0.0", "low: 20.0", r"parameters\[0\]\.high: 10, allowed above"),
    "empty": ("count: 2", "count: 0", r"parameters\[0\]\.count: 0, allowed 1 to"),
    "no values": ("!Range {", "!Values {values: [], labels: [], ", "low: unknown field"),
    "no metric": ("[tool_error_rms]", "[]", "metrics: 0 entries, allowed 1 or more of score"),
    "unknown metric": ("tool_error_rms", "tool_error_rmse", "did you mean 'tool_error_rms'"),
    "metric twice": ("[tool_error_rms]", "[energy, energy]", "metrics: 'energy' twice"),
    "unknown design": ("duration:", "design: sobol\nduration:", "design: 'sobol', allowed grid"),
    "unknown scenario": ("joint_sine", "joint_cosine", "scenario: 'joint_cosine', allowed"),
    "a normal in a grid": (
        "!Range {paths: robot.payload_mass, name: payload, low: 0.0, high: 10.0, count: 2}",
        "!Normal {paths: robot.payload_mass, mean: 1.0}", "!Normal in a grid",
    ),
    "a seed": ("robot.payload_mass", "seed", "seed: a field to set"),
    "a taken name": ("name: payload", "name: failed", "name 'failed', allowed another"),
    "no path": ("paths: robot.payload_mass, ", "", r"parameters\[0\]\.paths"),
    "too many": ("count: 2", "count: 99999}\n  - !Range {paths: seed, name: x, count: 99999",
                 "runs of the grid|seed: a field"),
    "compiled, with what is not": (
        "duration:", "overrides: {controller: !InverseDynamics {}}\nengine: compiled\nduration:",
        "engine: .*allowed auto, drake",
    ),
    "not a map": (BASE, "3", "allowed a map of a study"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_bad_input_is_one_line_and_nothing_is_written(what, tmp_path, capsys):
    old, new, message = WRONG[what]
    assert old in BASE
    path, store = tmp_path / "study.yaml", tmp_path / "out" / "store.nc"
    path.write_text(BASE.replace(old, new))
    with pytest.raises(ValueError, match=message) as error:
        sd.sweep(path, store)
    assert "\n" not in str(error.value)
    assert main(["sweep", str(path), "--store", str(store)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not store.parent.exists()


def test_an_empty_grid_is_refused():
    with pytest.raises(ValueError, match=r"parameters\[0\]\.values: 0 entries, allowed 1 or more"):
        sd.sweep(small_study(parameters=[Values(["controller.phi"], "phi", [])]))
    with pytest.raises(ValueError, match="parameters: 0 entries, allowed 1 or more, or repeats"):
        sd.sweep(small_study(parameters=[], repeats=1))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"backend": "slurm"}, "backend: 'slurm', allowed local, dask, ray"),
        (
            {"address": "127.0.0.1:1"},
            "address: '127.0.0.1:1', allowed with the backend",
        ),
        ({"jobs": 0}, "jobs: 0, allowed 1 to"),
    ],
)
def test_where_it_cannot_run_is_refused(arguments, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        sd.sweep(small_study(), tmp_path / "out" / "store.nc", **arguments)
    assert not list(tmp_path.rglob("*.*"))


def test_every_metric_says_what_it_is():
    for name, metric in METRICS.items():
        assert metric.units, name
        assert metric.long_name, name


def test_the_page_names_every_metric():
    page = (Path(__file__).parents[1] / "docs" / "studies.md").read_text()
    joints = {f"{joint}_error_rms" for joint in ("d1", *(f"theta{n}" for n in range(2, 7)))}
    assert [name for name in METRICS if f"`{name}`" not in page and name not in joints] == []

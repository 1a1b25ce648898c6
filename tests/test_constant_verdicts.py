"""The experiments with test files of their own: is a verdict that is a constant noticed there?"""

import importlib

import pytest
from mutants import survivors

JUDGED = {  # the file, what runs the experiment there, what judges other data
    "table_7": ("test_table_7", "experiment", "test_it_judges_what_it_is_given"),
    "table_10": ("test_table_10", "experiment", "test_it_judges_what_it_is_given"),
    "figures_16_17": ("test_figures_16_17", "experiment", "test_it_judges_what_it_is_given"),
    "figures_18_19": ("test_figures_18_19", "experiment", "test_it_judges_what_it_is_given"),
    "figures_29_30": ("test_figures_29_30", "experiment", "test_it_judges_what_it_is_given"),
    "perturbation_observer": (
        "test_experiment_observer", "experiment", "test_it_judges_what_it_is_given",
    ),
    "stability": ("test_stability_experiment", "experiment", "test_it_judges_what_it_is_given"),
    "equivalent_control": (
        "test_equivalent_control", "experiment", "test_it_judges_what_it_is_given",
    ),
    "operators_under_delay": (
        "test_operators_experiment", "experiment", "test_it_judges_what_it_is_given",
    ),
    "couplings": (
        "test_couplings_experiment", "small", "test_a_run_that_throws_the_device_breaks_the_claims",
    ),
    "quantised_wall": ("test_quantised_wall", "experiment", "test_it_judges_what_it_is_given"),
    "devices": ("test_devices_experiment", "experiment", "test_it_judges_what_it_is_given"),
    "delay_against_loss": (
        "test_delay_against_loss", "experiment", "test_it_judges_what_it_is_given",
    ),
    "certificates": (
        "test_certificates_experiment", "experiment", "test_it_judges_what_it_is_given",
    ),
    "displayed_impedance": (
        "test_displayed_impedance_experiment", "experiment", "test_it_judges_what_it_is_given",
    ),
    "standard_cases": ("test_standard_cases", "experiment", "test_it_judges_what_it_is_given"),
    "delayed_wall": ("test_delayed_wall", "experiment", "test_it_judges_what_it_is_given"),
    "dead_band": ("test_dead_band", "experiment", "test_it_judges_what_it_is_given"),
    **{
        name: ("test_stated_numbers", name, f"test_{name}_judges_what_it_is_given")
        for name in ("table_1", "table_2", "table_3", "table_4", "table_11", "table_12")
    },
}  # fmt: skip
# Held by tests of other forms, which are not run here.
ELSEWHERE = {
    "windup": "test_experiment_windup.py",
    "figures_20_27": "test_figures_20_28.py",
    "figure_28": "test_figures_20_28.py",
}
# What takes tens of seconds is done at night.
LONG = {
    "couplings",
    "dead_band",
    "delay_against_loss",
    "devices",
    "displayed_impedance",
    "figures_29_30",
    "operators_under_delay",
    "perturbation_observer",
    "stability",
    "standard_cases",
    "table_7",
    "table_10",
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in JUDGED]
)
def test_a_verdict_that_is_a_constant_would_be_noticed(name):
    file, run, judge = JUDGED[name]
    module = importlib.import_module(file)
    claims = getattr(module, run)().claims
    # Beside other data, the verdicts on the data of the experiment itself.
    judges = [getattr(module, test) for test in (judge, "test_verdicts") if hasattr(module, test)]
    assert survivors(claims, *judges) == []

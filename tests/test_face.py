"""What a user types and sees: the names of the package, fields that are none, readable values."""

import importlib
import pkgutil
import sys
from types import ModuleType

import pytest

import scara_drake as sd
from scara_drake import metrics
from scara_drake.scenario import check_scenario, scenario_names


def test_tab_shows_what_users_type_and_nothing_else():
    assert dir(sd) == sorted(sd.__all__)
    for name in sd.__all__:
        assert getattr(sd, name) is not None
    assert sd.metrics is metrics
    assert isinstance(sd.plotting, ModuleType)
    for name in ("Path", "nothing"):
        assert name not in dir(sd)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        importlib.import_module("scara_drake").__getattr__("nothing")


@pytest.mark.parametrize("package", ["", ".metrics", ".recordings", ".common", ".environment"])
def test_no_function_hides_a_module(package):
    where = importlib.import_module(f"scara_drake{package}")
    for module in pkgutil.iter_modules(where.__path__, f"{where.__name__}."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
            found = getattr(where, module.name.rpartition(".")[2])
            assert found is sys.modules[module.name], module.name


def test_a_field_that_is_none_is_refused_when_it_is_set():
    scenario = sd.load_scenario("joint_sine")
    with pytest.raises(AttributeError, match=r"^scenario\.duratoin: .* did you mean 'duration'\?$"):
        scenario.duratoin = 3.0
    scenario.duration = 3.0
    assert sd.load_scenario("joint_sine", {"duration": 3.0}) == scenario


@pytest.mark.parametrize(
    ("part", "name"), [("controller", "ph"), ("channel", "upp"), ("operator", "startt")]
)
def test_a_field_of_a_part_that_is_none_is_refused_before_anything_runs(part, name):
    scenario = sd.load_scenario("joint_sine")
    setattr(getattr(scenario, part), name, 1.0)
    with pytest.raises(ValueError, match=rf"^{part}\.{name}: unknown field, .* did you mean"):
        check_scenario(scenario)


@pytest.mark.parametrize("name", scenario_names())
def test_a_scenario_is_shown_in_short_lines_of_what_is_its_own(name):
    shown = repr(sd.load_scenario(name))
    assert shown.startswith(f"Scenario {name}\n")
    assert max(len(line) for line in shown.splitlines()) <= 120
    assert len(shown.splitlines()) <= 120
    assert "\ndescription: " in shown


def test_the_defaults_are_shown_too():
    assert repr(sd.Scenario()) == "Scenario"

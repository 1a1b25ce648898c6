"""Whatever a scenario's text is, it is answered in one short line or it builds."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinds import of_kind
from strategies import examples
from strategies.scenarios import NASTY, bomb, settings_within_bounds, tampered

from scara_drake.cli.main import main
from scara_drake.common.resources import resource
from scara_drake.common.yaml_text import read_yaml
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.diagram import make_diagram
from scara_drake.scenario import dump_scenario, load_scenario, parse_overrides, scenario_names

LONGEST = 700  # characters of a message; the list of the fields allowed is most of it

shipped = st.sampled_from(scenario_names())


def answered(load):
    """Return what loads, or None where it was refused in one line."""
    try:
        return load()
    except ValueError as error:
        message = str(error)
    assert message.isprintable(), message
    assert len(message) <= LONGEST, message
    return None


def loads_again(scenario, folder):
    """A scenario that was accepted is written as one that is accepted and equal."""
    path = folder / "again.yaml"
    path.write_text(dump_scenario(scenario), encoding="utf-8")
    assert load_scenario(path) == scenario


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("scenarios")


@examples(150)
@given(st.data(), shipped)
def test_a_text_that_was_tampered_with_is_answered_in_one_line_or_loads(folder, data, name):
    text = data.draw(tampered(resource("diagrams", f"{name}.yaml").read_text()))
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8", errors="replace")
    scenario = answered(lambda: load_scenario(path))
    if scenario is not None:
        loads_again(scenario, folder)


@examples(150)
@given(shipped, settings_within_bounds())
def test_any_field_within_its_bounds_is_answered_in_one_line_or_loads(folder, name, settings):
    scenario = answered(lambda: load_scenario(name, settings))
    if scenario is not None:
        loads_again(scenario, folder)


@examples(8)
@given(st.sampled_from(["joint_sine", "mast_step"]), settings_within_bounds(2))
def test_what_loads_builds_or_is_refused_in_one_line(name, settings):
    scenario = answered(lambda: load_scenario(name, settings))
    if scenario is not None:
        answered(lambda: make_diagram(scenario))


@pytest.mark.parametrize("value", NASTY, ids=range(len(NASTY)))
@pytest.mark.parametrize("key", ["duration", "operator", "controller.k", "channel.up", "name"])
def test_a_nasty_setting_is_answered_in_one_line(key, value):
    answered(lambda: load_scenario("teleoperation", parse_overrides([f"{key}={value}"])))
    answered(lambda: load_scenario("teleoperation", {f"{key}.{value}": 1}))


@pytest.mark.parametrize("levels", [2, 7, 60])
def test_aliases_that_write_out_to_much_are_refused_at_once(tmp_path, capsys, levels):
    path = tmp_path / "bomb.yaml"
    path.write_text(bomb(levels))
    start = time.process_time()
    assert main(["run", str(path), "--no-meshcat", "--no-realtime"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert len(error) <= LONGEST
    assert time.process_time() - start < 5.0  # it was half a minute and more; no race


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2\na: 3", r"^x: not YAML, line 3: key 'a' twice, allowed once$"),
        ("a: {b: 1, b: 1}", r"key 'b' twice"),
        ("a: {_tag: {}}", r"key '_tag', allowed a tag such as !Name$"),
        ("a: !Pid 3", r"^x: not YAML, line 1: tag '!Pid' on what is no map"),
        ("a: &a [*a]", r"^x: too deep"),
        ("[" * 2000, r"^x: too deep"),
        ("a: 2001-99-99", r"^x: not YAML, line 1: month must be in 1\.\.12"),
        ("a: " + "9" * 5000, r"^x: not YAML, line 1: Exceeds the limit"),
        (" " * 1_000_001, r"^x: 1000001 characters, allowed up to 1000000$"),
    ],
)
def test_what_is_no_plain_data_is_named(text, message):
    with pytest.raises(ValueError, match=message):
        read_yaml(text, "x")


def test_an_anchor_that_is_used_a_few_times_is_fine():
    text = "base: &b {k: 1}\none: *b\ntwo: {<<: *b, c: !Pid {k: 2}}"
    assert read_yaml(text, "x") == {
        "base": {"k": 1},
        "one": {"k": 1},
        "two": {"k": 1, "c": {"_tag": "!Pid", "k": 2}},
    }


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        (
            "duration=1" + "0" * 400,
            r"^duration: a whole number of 1329 bits, allowed a number",
        ),
        ("seed=1" + "0" * 400, r"^seed: a whole number of 1329 bits, allowed 0 to 9"),
        ("name='a\"b'", r"^name: 'a\"b', allowed a word"),
        ("name='a]b'", r"^name: 'a\]b', allowed a word"),
        (r"name='a\b'", r"^name: 'a\\b', allowed a word"),
        ('name="a\\eb"', r"^name: 'a b', allowed a word"),
        ("environment.surfaces.0.name=a]b", r"^environment\.surfaces\[0\]\.name: 'a\]b', allowed"),
        ("environment.surfaces.1.stiffness=1", r"no entry '1', allowed 0 to 0$"),
        ("environment.surfaces.x.stiffness=1", r"no entry 'x', allowed 0 to 0$"),
        ("controller.k.6=1", r"^controller\.k\.6: no entry '6', allowed 0 to 5$"),
        ("controller=Pid", r"; did you mean '!Pid \{\}'\?$"),
        ("controller=!Pdi {}", r"; did you mean '!Pid \{\}'\?$"),
        ("controler.k=1", r"; did you mean 'controller'\?$"),
        ("channel.up.dealy=1", r"; did you mean 'delay'\?$"),
        ("description=" + "x" * 4000, r"^description: 'x+\.\.\.', allowed one line of up to 500"),
    ],
)
def test_the_field_and_what_is_near_is_named(setting, message):
    with pytest.raises(ValueError, match=message):
        load_scenario("teleoperation", parse_overrides([setting]))


def test_an_entry_of_a_list_is_set_by_its_index():
    scenario = load_scenario(
        "teleoperation",
        parse_overrides(
            ["environment.surfaces.0.stiffness=3000", "controller.k.2=7", "q0=[3,0,0,0,0,0]",
             "q0.0=4.5"]
        ),
    )  # fmt: skip
    assert scenario.environment.surfaces[0].stiffness == 3000
    assert of_kind(IntegralSlidingMode, scenario.controller).k == [150, 100, 7, 75, 40, 20]
    assert scenario.q0 == [4.5, 0, 0, 0, 0, 0]

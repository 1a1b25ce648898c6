import copy
import dataclasses

import numpy as np
import pytest
from kinds import of_kind

from scara_drake import load_scenario, make_diagram
from scara_drake.channel.delays import SineDelay
from scara_drake.channel.packets import Packets
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.operator.joystick import Joystick
from scara_drake.plant.perturbation import JointPerturbation
from scara_drake.scenario import Scenario, check_scenario, dump_scenario, scenario_names


@pytest.mark.parametrize("name", scenario_names())
def test_shipped_scenarios_load_and_survive_a_round_trip(name, tmp_path):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.description
    path = tmp_path / "again.yaml"
    path.write_text(dump_scenario(scenario))
    assert load_scenario(path) == scenario


def test_the_defaults_are_a_valid_scenario():
    check_scenario(Scenario())


@pytest.mark.parametrize("name", ["teleoperation", "joint_sine"])
def test_building_changes_nothing_in_the_scenario(name):
    scenario = load_scenario(name)
    before = copy.deepcopy(scenario)
    make_diagram(scenario)
    assert scenario == before


def test_overrides():
    scenario = load_scenario(
        "teleoperation",
        {
            "controller.phi": 0.5,
            "controller.k": [1, 2, 3, 4, 5, 6],
            "channel.up": "!SineDelay {offset: 0.1, amplitude: 0.05, frequency: 2}",
            "duration": "2.5",
            "operator.mapping.scale": 0.25,
        },
    )
    gains = of_kind(IntegralSlidingMode, scenario.controller)
    assert gains.phi == [0.5] * 6
    assert gains.k == [1, 2, 3, 4, 5, 6]
    assert scenario.channel.up == SineDelay(offset=0.1, amplitude=0.05, frequency=2)
    assert scenario.duration == 2.5
    assert of_kind(Joystick, scenario.operator).mapping.scale == 0.25


def test_the_tables_of_the_paper():
    table_11 = of_kind(IntegralSlidingMode, load_scenario("joint_sine").controller)
    assert table_11 == load_scenario("mast_step").controller
    assert table_11.k == [150, 50, 35, 25, 20, 20]
    assert table_11.c == [50, 20, 20, 15, 10, 10]
    assert table_11.rho == [300, 150, 150, 120, 100, 100]
    table_12 = of_kind(IntegralSlidingMode, load_scenario("teleoperation").controller)
    assert table_12.k == [150, 100, 100, 75, 40, 20]
    assert table_12.c == [50, 50, 50, 40, 10, 10]
    assert table_12.rho == [500, 150, 150, 120, 100, 100]
    wall = load_scenario("teleoperation").environment.surfaces[0]
    assert (wall.stiffness, wall.damping) == (1e4, 100.0)  # Table 4
    motion = load_scenario("joint_sine").operator
    assert isinstance(motion, JointMotion)
    np.testing.assert_array_equal(np.nonzero(np.array(motion.amplitude))[0], [1, 3])
    assert {motion.amplitude[1], motion.amplitude[3]} == {0.7854}
    assert {motion.frequency[1], motion.frequency[3]} == {1.25}


BAD = [
    ({"controler.phi": 1}, r"^controler: unknown field, allowed name, "),
    ({"controller.phy": 1}, r"^controller\.phy: unknown field, allowed c, k, rho, phi, mode"),
    ({"operator.mapping.sclae": 1}, r"^operator\.mapping\.sclae: unknown field, allowed centre"),
    ({"controller.k": -1.0}, r"^controller\.k\[0\]: -1\.0, allowed 0 or more, finite$"),
    ({"controller.rho": float("nan")}, r"^controller\.rho\[0\]: nan, allowed 0 or more"),
    ({"controller.k": [1.0, 2.0]}, r"^controller\.k: 2 entries, allowed 6$"),
    (
        {"controller": "!Magic {}"},
        r"^controller: 'Magic', allowed IntegralSlidingMode, ObserverSlidingMode",
    ),
    (
        {"operator": "!Magic {}"},
        r"^operator: 'Magic', allowed Joystick, External, Trainee, Master, JointMotion$",
    ),
    ({"channel.up": "!ConstantDelay {delay: 9}"}, r"^channel\.up.*9 s, allowed 0 to 2\.5 s"),
    ({"channel.up": "!ConstantDelay {delay: -1}"}, r"^channel\.up\.delay: -1"),
    ({"operator.trace": "none.csv"}, r"none\.csv.*allowed a CSV file that exists"),
    (
        {"operator.device": "mouse"},
        r"^operator\.device: 'mouse', allowed trace, auto, joystick, keyboard, spacemouse, ",
    ),
    ({"inverse_kinematics.method": "magic"}, r"^inverse_kinematics\.method: 'magic', allowed "),
    ({"q0": [1.0, 0, 0, 0, 0, 0]}, r"^q0: d1 = 1 m, allowed 2\.5 to 10 m$"),
    ({"q0": [3.0, 0, 0, 9, 0, 0]}, r"^q0: theta4 = 9 rad, allowed -2\.356 to 2\.356 rad$"),
    ({"duration": "abc"}, r"^duration: abc, allowed a number$"),
    ({"duration": -1}, r"^duration: -1"),
    ({"duration": None}, r"^duration: empty, allowed float$"),
    ({"seed": 1.5}, r"^seed: 1\.5, allowed a whole number$"),
    ({"environment.surfaces": 3}, r"^environment\.surfaces: 3, allowed a list$"),
    ({"duration.x": 3}, r"^duration\.x: 'duration' has no fields"),
]


@pytest.mark.parametrize(("overrides", "message"), BAD)
def test_bad_values_are_refused_in_one_line(overrides, message):
    with pytest.raises(ValueError, match=message) as caught:
        load_scenario("teleoperation", overrides)
    assert "\n" not in str(caught.value)


def test_bad_files_are_refused_in_one_line(tmp_path):
    with pytest.raises(ValueError, match=r"^scenario: 'nope', allowed bilateral, free_motion"):
        load_scenario("nope")
    with pytest.raises(ValueError, match="allowed a YAML file that exists"):
        load_scenario(tmp_path / "nope.yaml")
    path = tmp_path / "bad.yaml"
    for text, message in (("[1, 2", "bad.yaml: not YAML"), ("[1, 2]", "allowed a map")):
        path.write_text(text)
        with pytest.raises(ValueError, match=message) as caught:
            load_scenario(path)
        assert "\n" not in str(caught.value)


def test_a_trace_beside_the_scenario_is_taken(tmp_path):
    header, *rows = "time,x,y,z,mast_axis,mast_hat\n0,0,0,0,0,0\n1,0.5,0,0,0,0\n".splitlines()
    (tmp_path / "mine.csv").write_text("\n".join([header, *rows]))
    (tmp_path / "mine.yaml").write_text("operator: !Joystick {trace: mine.csv}\n")
    operator = of_kind(Joystick, load_scenario(tmp_path / "mine.yaml").operator)
    assert operator.trace_path() == tmp_path / "mine.csv"
    (tmp_path / "mine.csv").write_text("\n".join([header.replace("mast_hat", "hat"), *rows]))
    with pytest.raises(ValueError, match="mast_hat"):
        load_scenario(tmp_path / "mine.yaml")


def test_a_part_of_your_own_is_written_under_its_own_tag():
    @dataclasses.dataclass
    class Mine:
        gain: float = 2.5

        def check_together(self, name):
            """Accept anything."""

    scenario = load_scenario("joint_sine")
    scenario.controller = Mine()  # type: ignore[assignment] # the user's own, no kind of ours
    text = dump_scenario(scenario)
    assert "controller: !Mine" in text
    assert "gain: 2.5" in text


def test_a_number_with_an_exponent_is_a_number():
    scenario = load_scenario("joint_sine", {"controller.phi": "5e-1", "time_step": "1e-3"})
    assert of_kind(IntegralSlidingMode, scenario.controller).phi == [0.5] * 6
    assert scenario.time_step == 1e-3


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"controller.phi": ""}, r"^controller\.phi: empty, allowed list"),
        (
            {"operator.trace": "nothing.csv"},
            r"^operator\.trace: 'nothing\.csv', allowed a CSV",
        ),
        ({"name": "../out"}, r"^name: '\.\./out', allowed a word of up to 100 letters"),
        (
            {"channel.up": "!Packets {send_period: 0.0015}"},
            r"^channel\.up\.send_period: 0\.0015 s, allowed a multiple of 0\.001 s$",
        ),
        (
            {"channel.up": "!Packets {}", "channel.max_delay": 1},
            r"^channel\.up\.longest: 2\.5, allowed 0 to 1$",
        ),
        (
            {"perturbation": "{offset: much}"},
            r"^perturbation\.offset\[0\]: much, allowed a",
        ),
    ],
)
def test_what_was_easily_missed_is_refused_in_one_line_too(overrides, message):
    with pytest.raises(ValueError, match=message):
        load_scenario("teleoperation", overrides)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"governor": "{}"}, r"^governor: set, allowed without a Master only"),
        ({"kinesthetic": "{}"}, r"^kinesthetic: set, allowed with a Joystick or an External only$"),
        ({"inverse_kinematics.method": "dpso"}, r"^inverse_kinematics\.method: 'dpso', allowed"),
    ],
)
def test_what_does_not_go_with_a_master_is_refused(overrides, message):
    with pytest.raises(ValueError, match=message):
        load_scenario("bilateral", overrides)


def test_exponents_are_numbers_at_any_depth():
    link = "!Packets {send_period: 2e-3, jitter: {distribution: gamma, mean: 1e-3, std: 1e-3}}"
    scenario = load_scenario("teleoperation", {"channel.up": link, "perturbation": "{offset: 1e1}"})
    packets = of_kind(Packets, scenario.channel.up)
    assert packets.send_period == 2e-3
    assert packets.jitter.std == 1e-3
    assert of_kind(JointPerturbation, scenario.perturbation).offset == [10.0] * 6

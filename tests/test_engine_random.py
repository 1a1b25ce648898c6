"""Random scenarios: the compiled engine agrees with Drake, or says what it cannot do."""

from __future__ import annotations

import pytest
from engine_cases import CASES, CONTROLLERS, COUPLINGS, JITTER, PRESS
from engines import FREE, IN_CONTACT, differences, grown, touches
from hypothesis import event, given, note
from hypothesis import strategies as st
from kinds import of_kind
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from strategies import examples
from strategies.scenarios import settings_near, settings_within_bounds
from strategies.surfaces import surfaces

from scara_drake import joints, load_scenario, make_diagram, simulate
from scara_drake.engine.errors import LeftTheModelError, NotCompilableError
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.scenario import scenario_names

pytestmark = pytest.mark.filterwarnings("ignore::scara_drake.scenario.UnusedSetting")


def loaded(base, settings):
    """The scenario, or None where the settings do not go together."""
    note(f"{base} {settings}")
    try:
        return load_scenario(base, settings)
    except ValueError:
        return None


def ran(scenario, engine):
    """A recording, or the error that ended the run; None where the scenario is refused."""
    try:
        return simulate(scenario, engine=engine)
    except (NotCompilableError, LeftTheModelError, RuntimeError) as error:
        return error
    except ValueError:
        return None  # refused before it ran


def agrees_or_says_why(scenario):
    ours = ran(scenario, "compiled")
    event(type(ours).__name__)
    if ours is None:
        return
    if isinstance(ours, NotCompilableError):
        systems = {system.get_name() for system in make_diagram(scenario).GetSystems()}
        assert str(ours).partition(":")[0] in systems
        return
    if isinstance(ours, LeftTheModelError):
        is_at_the_end_of_the_model(scenario, ours)
        return
    theirs = ran(scenario, "drake")
    if isinstance(ours, RuntimeError):
        assert str(ours) == str(theirs)
        return
    bound = IN_CONTACT if touches(theirs) else FREE
    found = differences(ours, theirs)
    worst = max(found, key=found.__getitem__)
    if found[worst] > bound:
        assert found[worst] < 100.0 * grown(scenario, ours)[worst], f"{worst}: {found[worst]:.2g}"


def is_at_the_end_of_the_model(scenario, error):
    """In Drake's run, there is a joint near its limit or a link that touches at that time."""
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    plant = of_kind(MultibodyPlant, diagram.GetSubsystemByName("plant"))
    context = simulator.get_context()
    own = plant.GetMyContextFromRoot(context)
    simulator.AdvanceTo(max(error.time - 0.5 * scenario.time_step, 0.0))
    if "limit" in str(error):
        joint = next(i for i, name in enumerate(joints.JOINT_NAMES) if name in error.what)
        before, h = plant.GetPositionsAndVelocities(own), scenario.time_step
        simulator.AdvanceTo(error.time + 1.5 * h)
        after = plant.GetPositionsAndVelocities(own)
        speed = max(abs(before[6 + joint]), abs(after[6 + joint]))
        gap = min(joints.UPPER[joint] - before[joint], before[joint] - joints.LOWER[joint])
        assert gap < 4.0 * h * speed + 1e-3
    else:
        results = plant.get_contact_results_output_port().Eval(own)
        query = plant.get_geometry_query_input_port().Eval(own)
        simulator.AdvanceTo(error.time + 0.5 * scenario.time_step)
        later = plant.get_geometry_query_input_port().Eval(own)
        assert (
            results.num_point_pair_contacts()
            + len(query.ComputePointPairPenetration())
            + len(later.ComputePointPairPenetration())
        )


@st.composite
def changed(draw):
    """A base and settings, some parts of other kinds, and numbers near those that it has."""
    base, settings = draw(
        st.sampled_from([("bilateral", PRESS), ("teleoperation", {}), ("joint_sine", {})])
    )
    settings = dict(settings)
    if base == "bilateral":
        settings["coupling"] = f"!{draw(st.sampled_from(COUPLINGS))} {{}}"
    if base != "joint_sine":
        for way in ("up", "down"):
            settings[f"channel.{way}"] = draw(
                st.sampled_from([JITTER, "!ConstantDelay {delay: 0.01}"])
            )
    settings["controller"] = draw(st.sampled_from(CONTROLLERS))
    for part in draw(st.sets(st.sampled_from(["drives.lag", "drives.friction", "perturbation"]))):
        settings[part] = "{}"
    settings["time_step"] = draw(st.sampled_from([1e-3, 1e-3, 0.5e-3, 0.7e-3, 2e-3]))
    scenario = loaded(base, settings)
    if scenario is None:
        return base, settings
    return base, {**settings, **draw(settings_near(scenario))}


@examples(8)
@given(st.data(), st.sampled_from(["bilateral", "joint_sine"]))
def test_a_scenario_near_a_shipped_one_agrees(data, name):
    base, settings = CASES["Tdpa, constant delay" if name == "bilateral" else name]
    near = data.draw(settings_near(load_scenario(base, settings)))
    scenario = loaded(base, {**settings, **near, "duration": 0.15})
    if scenario is not None:
        agrees_or_says_why(scenario)


@pytest.mark.slow
@pytest.mark.timeout(3600)  # most examples are compiled anew
@examples(40)
@given(changed(), st.floats(0.3, 0.6))
def test_a_scenario_of_other_parts_agrees(case, duration):
    base, settings = case
    scenario = loaded(base, {**settings, "duration": duration})
    if scenario is not None:
        agrees_or_says_why(scenario)


@pytest.mark.slow
@pytest.mark.timeout(3600)  # most examples are compiled anew
@examples(30)
@given(st.sampled_from(scenario_names()), settings_within_bounds(3))
def test_a_scenario_anywhere_within_its_bounds_agrees_or_says_why(name, settings):
    scenario = loaded(name, {**settings, "duration": 0.5})
    if scenario is not None:
        agrees_or_says_why(scenario)


@pytest.mark.slow
@pytest.mark.timeout(3600)  # most examples are compiled anew
@examples(30)
@given(surfaces(), st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_an_arm_among_surfaces_agrees_or_touches(surface, move):
    """The joints go up to 0.1 m and 0.2 rad within 0.5 s, into whatever is there."""
    scenario = load_scenario("joint_sine", {"duration": 0.5})
    scenario.environment.surfaces = [surface]
    scenario.operator = JointMotion(
        base=list(joints.HOME),
        displacement=[0.1 * move[0], *(0.2 * way for way in move[1:])],
        start=0.0,
        move_duration=0.5,
    )
    agrees_or_says_why(scenario)

"""Profiles: what an input makes of an axis, which profile a model gets, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.common.fields import check
from scara_drake.operator.devices.inputs import LAYOUTS, SHORTEST, Use
from scara_drake.operator.devices.profiles import (
    DEFAULT_PROFILES,
    AxisMap,
    choose_profile,
    load_profile,
    profile_names,
)
from scara_drake.operator.devices.sample import is_good
from scara_drake.scenario import load_scenario

unit = st.floats(-1.0, 1.0)


@st.composite
def uses(draw: st.DrawFn) -> Use:
    rest = draw(unit)
    low = draw(st.floats(-1.0, rest - SHORTEST)) if rest > SHORTEST - 1.0 else rest
    high = draw(st.floats(rest + SHORTEST, 1.0)) if rest < 1.0 - SHORTEST else rest
    ends = draw(st.sampled_from([(low, high), (rest, high), (low, rest)]))
    low, high = ends if ends[0] < ends[1] else (low, high)
    return Use(
        "axis0",
        low,
        rest,
        high,
        draw(st.booleans()),
        draw(st.floats(0.0, 0.9)),
        draw(st.floats(0.0, 1.0)),
    )


@examples(200)
@given(use=uses(), first=unit, second=unit)
def test_an_axis_is_monotone_continuous_and_reaches_its_ends(
    use: Use, first: float, second: float
) -> None:
    assume(min(w for w in (use.rest - use.low, use.high - use.rest) if w) >= SHORTEST)  # rounding
    check(use, "use")
    sign = -1.0 if use.invert else 1.0
    assert use.value(use.rest) == 0.0
    if use.high > use.rest:
        assert sign * use.value(use.high) == pytest.approx(1.0)
    if use.low < use.rest:
        assert sign * use.value(use.low) == pytest.approx(-1.0)
    low, high = sorted((first, second))
    rise = sign * (use.value(high) - use.value(low))
    assert rise >= -1e-12
    # The steepest is the end of a cube, over the part of the travel beside the dead zone.
    spans = [span for span in (use.high - use.rest, use.rest - use.low) if span > 1e-9]
    steepest = (1.0 + 2.0 * use.expo) / (1.0 - use.dead_zone) / min(spans)
    assert rise <= steepest * (high - low) * (1.0 + 1e-9) + 1e-9
    assert abs(use.value(first)) <= 1.0


@examples(100)
@given(use=uses(), share=unit)
def test_within_the_dead_zone_there_is_nothing(use: Use, share: float) -> None:
    way = share * use.dead_zone
    span = use.high - use.rest if way > 0.0 else use.rest - use.low
    assert use.value(use.rest + way * span) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("use", "raw", "value"),
    [
        (Use("axis0"), 0.3, 0.3),
        (Use("axis0", dead_zone=0.1), 0.55, 0.5),
        (Use("axis0", dead_zone=0.1), -0.1, 0.0),
        (Use("axis0", expo=1.0), -0.5, -0.125),
        (Use("axis0", expo=0.5, invert=True), 0.5, -0.3125),
        (Use("axis0", low=-1.0, rest=-1.0), -1.0, 0.0),  # a trigger
        (Use("axis0", low=-1.0, rest=-1.0), 0.0, 0.5),
        (Use("axis0", low=0.0, rest=0.0, high=0.5), 0.9, 1.0),
    ],
)
def test_values_by_hand(use: Use, raw: float, value: float) -> None:
    assert use.value(raw) == pytest.approx(value)


@pytest.mark.parametrize("raw", [np.nan, np.inf, -np.inf, 1.06])
def test_what_is_no_value_reaches_the_sample(raw: float) -> None:
    sample = load_profile("flight_stick").sample(0.0, {"axis1": raw, "axis0": 0.5})
    np.testing.assert_equal(sample.axes[1], raw)
    assert not is_good(sample)


def test_inputs_that_share_an_axis_add_up() -> None:
    profile = load_profile("game_controller")
    roll = [
        profile.sample(0.0, {"righttrigger": right, "lefttrigger": left}).orientation[0]
        for right, left in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.0, 0.0))
    ]
    np.testing.assert_allclose(roll, [1.0, -1.0, 0.0, 0.0])


def test_every_shipped_profile_is_right_and_has_a_dead_man_button() -> None:
    assert set(DEFAULT_PROFILES.values()) <= set(profile_names())
    assert set(DEFAULT_PROFILES) == set(LAYOUTS)
    for name in profile_names():
        profile = load_profile(name)
        assert profile.name == name
        assert profile.buttons.engage
        assert profile.buttons.clutch
        at_rest = profile.sample(0.0, dict.fromkeys(profile.inputs(), 0.0))
        assert not np.concatenate(at_rest[2:5]).any()


@pytest.mark.parametrize(
    ("name", "layouts", "profile"),
    [
        ("Microsoft X-Box 360 pad", ("game_controller", "joystick"), "xbox"),
        ("Sony DualSense Wireless Controller", ("game_controller", "joystick"), "playstation"),
        ("Sony DualSense Wireless Controller", ("joystick",), "flight_stick"),
        ("8BitDo Pro 2", ("game_controller", "joystick"), "game_controller"),
        ("Extreme 3D pro", ("joystick",), "flight_stick"),
    ],
)
def test_the_profile_is_that_of_the_model_or_of_the_layout(
    name: str, layouts: tuple[str, ...], profile: str
) -> None:
    assert choose_profile(name, "", layouts).name == profile


def test_a_scenario_changes_single_axes() -> None:
    profile = load_profile("flight_stick").changed(AxisMap(z=4, x=-1, mast_hat=1))
    assert profile.axes.z == [Use("axis4")]
    assert profile.axes.x == []
    assert profile.axes.y == [Use("axis1")]
    assert profile.axes.mast_hat == [Use("hat1_y")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "axes: {x: [{input: axis0, dead_zone: 1.0}]}",
            r"axes\.x\[0\]\.dead_zone: 1.0, allowed",
        ),
        ("axes: {x: [{input: axis64}]}", r"axes\.x\[0\]\.input: 'axis64', allowed axis0"),
        ("axes: {x: [{input: leftx}]}", r"axes\.x\[0\]\.input: 'leftx', allowed axis0, button0"),
        ("axes: {q: []}", r"axes\.q: unknown field, allowed x, y, z"),
        ("axes: {x: [{input: axis0, rest: 1.0, high: 0.5}]}", "allowed low <= rest <= high"),
        ("axes: {x: [{input: axis0, low: -0.01}]}", "each end at rest or 0.05 away"),
        ("buttons: {engage: [throttle]}", r"buttons\.engage\[0\]: 'throttle', allowed axis0"),
        ("buttons: {engage: button0}", r"buttons\.engage: button0, allowed a list"),
        ("layout: wheel", "layout: 'wheel', allowed joystick, game_controller"),
        ("[1, 2]", "allowed a map with the fields of a profile"),
        ("layout: [", "line 1: "),
        ("layout: joystick\nlayout: joystick", "layout"),
    ],
)
def test_what_is_wrong_in_a_profile_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message) as error:
        load_scenario("free_motion", {"operator.profile": str(path)})
    assert "mine.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_profile_lists_those_there_are() -> None:
    with pytest.raises(ValueError, match=r"profile: 'xbux', allowed flight_stick, .*xbox"):
        load_scenario("free_motion", {"operator.profile": "xbux"})


def test_a_profile_beside_the_scenario_is_found(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("layout: joystick\n", encoding="utf-8")
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("operator: !Joystick {profile: mine.yaml}\n", encoding="utf-8")
    operator = load_scenario(scenario).operator
    assert operator.profile == str(tmp_path / "mine.yaml")  # type: ignore[union-attr]  # a Joystick

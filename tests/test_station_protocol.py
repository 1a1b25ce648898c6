"""What a page may say: nothing else is taken, and nothing crashes who reads it."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.station.protocol import MAX_MESSAGE, MAX_NAME, SETTINGS
from scara_drake.station.requests import (
    ControlRequest,
    Drawn,
    Input,
    ProtocolError,
    Setting,
    View,
    parse,
)
from scara_drake.vectors import BUTTON_NAMES

KINDS = ("input", "setting", "control", "view", "drawn")
FIELDS = ("type", "axes", "orientation", "buttons", "device", "name", "value", "action", "to")
leaves = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.sampled_from(KINDS)
)
values = st.recursive(
    leaves,
    lambda inner: st.lists(inner) | st.dictionaries(st.sampled_from(FIELDS), inner),
    max_leaves=12,
)
axis = st.floats(-1.0, 1.0)
no_axis = (
    st.floats().filter(lambda x: not -1.0 <= x <= 1.0)
    | st.booleans()
    | st.text()
    | st.none()
    | st.integers(min_value=2)
    | st.integers(max_value=-2)
)


@examples(100)
@given(values)
def test_any_json_is_a_request_or_refused(data: Any) -> None:
    with suppress(ProtocolError):
        found = parse(json.dumps(data))
        assert isinstance(found, Input | Setting | ControlRequest | View | Drawn)


@examples(100)
@given(st.text() | st.binary())
def test_any_text_is_a_request_or_refused(text: str | bytes) -> None:
    with pytest.raises(ProtocolError):
        parse(text)


@examples(100)
@given(
    st.lists(axis, min_size=5, max_size=5),
    st.lists(axis, min_size=3, max_size=3),
    st.dictionaries(st.sampled_from(BUTTON_NAMES), st.booleans()),
    st.text(),
)
def test_an_input_arrives_as_it_was_said(
    axes: list[float], orientation: list[float], buttons: dict[str, bool], device: str
) -> None:
    said = {"type": "input", "axes": axes, "orientation": orientation, "buttons": buttons}
    found = parse(json.dumps({**said, "device": device[:MAX_NAME]}))
    assert isinstance(found, Input)
    assert list(found.axes) == axes
    assert list(found.orientation) == orientation
    assert {n: bool(v) for n, v in zip(BUTTON_NAMES, found.buttons, strict=True)} == {
        name: buttons.get(name, False) for name in BUTTON_NAMES
    }
    assert found.device.isprintable()


@examples(100)
@given(st.lists(axis, min_size=5, max_size=5), st.integers(0, 4), no_axis)
def test_an_axis_out_of_range_is_refused(axes: list[Any], place: int, wrong: object) -> None:
    axes[place] = wrong
    with pytest.raises(ProtocolError, match=r"axes|JSON|NaN|Infinity"):
        parse(json.dumps({"type": "input", "axes": axes}))


@pytest.mark.parametrize("name", SETTINGS)
def test_a_setting_is_taken_within_its_bounds_only(name: str) -> None:
    low, high = SETTINGS[name].lower, SETTINGS[name].upper
    for value in (low, high):
        assert parse(json.dumps({"type": "setting", "name": name, "value": value})) == (name, value)
    wrong: list[Any] = [math.nextafter(low, -1.0), math.nextafter(high, 100.0), True, None, "1"]
    for value in wrong:
        with pytest.raises(ProtocolError, match=name):
            parse(json.dumps({"type": "setting", "name": name, "value": value}))


@pytest.mark.parametrize(
    "text",
    [
        "[" * MAX_MESSAGE,
        '{"type":"view","delayed":' + "[" * 4000,
        " " * MAX_MESSAGE + "{}",
        '{"type":"setting","name":"force_scale","value":1e999}',
        '{"type":"setting","name":"force_scale","value":NaN}',
        '{"type":"setting","name":"force_scale","value":' + "9" * 4000 + "}",
        '{"type":"drawn","frame":-1}',
        '{"type":"drawn","frame":1.0}',
        '{"type":"drawn","frame":true}',
        '{"type":"view","delayed":1}',
        '{"type":"control","action":"give"}',
        '{"type":"control","action":"seize"}',
        '{"type":"control","action":["take"]}',
        '{"type":["input"]}',
        '{"type":"input","buttons":{"eject":true}}',
        '{"type":"input","buttons":{"engage":1}}',
        '{"type":"input","axes":[0,0,0,0]}',
        '{"type":"input","more":0}',
        '{"type":"input","device":7}',
        '{"type":"\\ud800"}',
    ],
)
def test_what_is_no_message_is_refused(text: str) -> None:
    with pytest.raises(ProtocolError):
        parse(text)


def test_control_names_a_client_only_to_give_it() -> None:
    assert parse('{"type":"control","action":"take"}') == ("take", None)
    assert parse('{"type":"control","action":"give","to":3}') == ("give", 3)


@examples(20)
@given(st.text(min_size=1, max_size=50))
def test_the_name_of_a_device_is_one_line(name: str) -> None:
    found = parse(json.dumps({"type": "input", "device": name + "\n\x1b[31m" + "x" * 300}))
    assert isinstance(found, Input)
    assert len(found.device) <= MAX_NAME
    assert found.device.isprintable() or not found.device

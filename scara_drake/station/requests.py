"""Reads what a page says, see `protocol`: all that comes in from outside passes here."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple, NoReturn

from scara_drake.station.protocol import MAX_MESSAGE, MAX_NAME, MAX_NUMBER, SETTINGS
from scara_drake.vectors import BUTTON_NAMES, ORIENTATION_NAMES, STICK_NAMES


class ProtocolError(ValueError):
    """A message that is none; says in one line what is wrong with it."""


class Input(NamedTuple):
    """What the page's device says: axes (5), orientation (3), buttons (6) and its name."""

    axes: tuple[float, ...]
    orientation: tuple[float, ...]
    buttons: tuple[float, ...]
    device: str


class Setting(NamedTuple):
    """A setting, see `SETTINGS`, and its new value."""

    name: str
    value: float


class ControlRequest(NamedTuple):
    """Who asks to take or release control, or to give it to a client."""

    action: str
    to: int | None


class View(NamedTuple):
    """Whether the pictures are as old as the force that the operator feels."""

    delayed: bool


class Drawn(NamedTuple):
    """The number of a picture that is on the screen."""

    frame: int


Request = Input | Setting | ControlRequest | View | Drawn


def parse(text: str | bytes) -> Request:
    """Return what a page says.

    Raises:
        ProtocolError: it is too long, no JSON, or not one of the messages above.
    """
    if len(text) > MAX_MESSAGE:
        raise ProtocolError(f"message: {len(text)} long, allowed {MAX_MESSAGE}")
    try:
        data = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError):
        raise ProtocolError("message: no JSON") from None
    kind = data.get("type") if isinstance(data, dict) else None
    if not isinstance(kind, str) or kind not in _READERS:
        raise ProtocolError(f"type: allowed {', '.join(_READERS)}")
    reader, fields = _READERS[kind]
    if unknown := data.keys() - {"type", *fields}:
        raise ProtocolError(f"{kind}: {len(unknown)} unknown fields, allowed {', '.join(fields)}")
    return reader(data)


def _refuse_constant(name: str) -> NoReturn:
    raise ProtocolError(f"message: {name}")


def _input(data: Mapping[str, Any]) -> Input:
    buttons = data.get("buttons", {})
    if not isinstance(buttons, dict) or buttons.keys() - set(BUTTON_NAMES):
        raise ProtocolError(f"buttons: allowed {', '.join(BUTTON_NAMES)}")
    return Input(
        _axes(data, "axes", len(STICK_NAMES)),
        _axes(data, "orientation", len(ORIENTATION_NAMES)),
        tuple(float(_flag(buttons.get(name, False), name)) for name in BUTTON_NAMES),
        _name(data.get("device", "")),
    )


def _setting(data: Mapping[str, Any]) -> Setting:
    name = data.get("name")
    if not isinstance(name, str) or name not in SETTINGS:
        raise ProtocolError(f"name: allowed {', '.join(SETTINGS)}")
    bounds = SETTINGS[name]
    return Setting(name, _number(data.get("value"), name, bounds.lower, bounds.upper))


def _control(data: Mapping[str, Any]) -> ControlRequest:
    action, to = data.get("action"), data.get("to")
    if not isinstance(action, str) or action not in ("take", "release", "give"):
        raise ProtocolError("action: allowed take, release, give")
    return ControlRequest(action, _count(to, "to") if action == "give" else None)


def _view(data: Mapping[str, Any]) -> View:
    return View(_flag(data.get("delayed"), "delayed"))


def _drawn(data: Mapping[str, Any]) -> Drawn:
    return Drawn(_count(data.get("frame"), "frame"))


_READERS: Final[dict[str, tuple[Callable[[Mapping[str, Any]], Request], tuple[str, ...]]]] = {
    "input": (_input, ("axes", "orientation", "buttons", "device")),
    "setting": (_setting, ("name", "value")),
    "control": (_control, ("action", "to")),
    "view": (_view, ("delayed",)),
    "drawn": (_drawn, ("frame",)),
}


def _axes(data: Mapping[str, Any], name: str, count: int) -> tuple[float, ...]:
    values = data.get(name, [0.0] * count)
    if not isinstance(values, list) or len(values) != count:
        raise ProtocolError(f"{name}: allowed a list of {count} numbers")
    return tuple(_number(value, name, -1.0, 1.0) for value in values)


def _number(value: object, name: str, lower: float, upper: float) -> float:
    """Return a number within its bounds; NaN, infinity and a truth value are none."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not lower <= value <= upper:  # type: ignore[operator]  # it is a number
        raise ProtocolError(f"{name}: allowed a number from {lower:g} to {upper:g}")
    return float(value)  # type: ignore[arg-type]  # it is a number


def _count(value: object, name: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= MAX_NUMBER:
        raise ProtocolError(f"{name}: allowed a whole number from 0 to {MAX_NUMBER}")
    return value


def _flag(value: object, name: str) -> bool:
    if not isinstance(value, bool):
        raise ProtocolError(f"{name}: allowed true, false")
    return value


def _name(value: object) -> str:
    """Return the name of a device: its printable characters, and not too many of them."""
    if not isinstance(value, str):
        raise ProtocolError("device: allowed a text")
    return "".join(letter for letter in value[:MAX_NAME] if letter.isprintable())

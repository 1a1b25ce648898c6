"""A profile of one's own device, by one movement after another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import yaml

from scara_drake.common.fields import check
from scara_drake.common.schema import build
from scara_drake.operator.devices.profiles import Profile
from scara_drake.vectors import BUTTON_NAMES

TICK = 0.02  # [s], from reading to reading
REST = 0.5  # [s] of the reading at rest, and of having let go after a movement
FAR = 0.5  # of the range of an input: this is meant, and no wobble
NEAR = 0.15  # of it: let go again
ONE_SIDED = 0.2  # of it: what goes less far the other way has no other way, as a trigger
DEAD_ZONE = 0.05  # share of the travel, at least

AXES_ASKED: Final[dict[str, str]] = {
    "x": "right, then left",
    "y": "back (towards you), then forth",
    "z": "up, then down",
    "mast_hat": "mast up, then down",
    "yaw": "turn left, then right",
}

Read = Callable[[], Mapping[str, float]]


class Calibration:
    """Asks for movements, and sees which input made each.

    Args:
        read: returns the inputs that there are, by the names of layout joystick.
        tick: lets `TICK` pass.
        say: shows a line to the operator.
        patience: for a movement that does not come [s]; it is then left out.
    """

    def __init__(
        self, read: Read, tick: Callable[[], None], say: Callable[[str], None], patience: float
    ) -> None:
        self._read, self._tick, self._say = read, tick, say
        self._patience = max(round(patience / TICK), 1)
        self._rest: dict[str, float] = {}
        self._noise: dict[str, float] = {}
        self._taken: set[str] = set()

    def profile(self, guid: str = "") -> dict[str, Any]:
        """Return the data of a profile, see `profiles.Profile`, checked.

        Raises:
            ValueError: nothing has moved at all.
        """
        self._say("Let go of everything.")
        self._learn_rest()
        axes, buttons = {}, {}
        for name, movement in AXES_ASKED.items():
            self._say(f"Axis {name}: all the way {movement}, then let go.")
            use = self._axis()
            if use is not None:
                axes[name] = [use]
        for name in BUTTON_NAMES:
            self._say(f"Button {name}: press it and let go.")
            pressed = self._button()
            if pressed is not None:
                buttons[name] = [pressed]
        if not axes and not buttons:
            raise ValueError("calibration: nothing has moved, allowed a device that is moved")
        data: dict[str, Any] = {"layout": "joystick"}
        if guid:
            data["guids"] = [guid]
        data |= {"axes": axes, "buttons": buttons}
        check(build(Profile, data), "")
        return data

    def _learn_rest(self) -> None:
        rows = []
        for _ in range(round(REST / TICK)):
            self._tick()
            rows.append(self._read())
        for name in rows[0]:
            values = sorted(row[name] for row in rows)
            self._rest[name] = values[len(values) // 2]
            self._noise[name] = values[-1] - values[0]

    def _first(self, button: bool) -> str | None:
        """Return the input, not taken yet, that first goes far from rest; None if none does."""
        for _ in range(self._patience):
            self._tick()
            for name, value in self._read().items():
                fits = name.startswith("button") == button and name not in self._taken
                if fits and abs(value - self._rest[name]) >= FAR:
                    self._taken.add(name)
                    return name
        self._say("  nothing has moved: left out")
        return None

    def _axis(self) -> dict[str, Any] | None:
        name = self._first(button=False)
        if name is None:
            return None
        rest = self._rest[name]
        first = low = high = self._read()[name]
        still = 0
        for _ in range(10 * self._patience):
            self._tick()
            value = self._read()[name]
            low, high = min(low, value), max(high, value)
            still = still + 1 if abs(value - rest) <= NEAR else 0
            if still >= round(REST / TICK):
                break
        self._say(f"  {name}: {low:.2f} to {high:.2f}, rests at {rest:.2f}")
        use: dict[str, Any] = {"input": name}
        use["low"] = round(low, 3) if rest - low > ONE_SIDED else round(rest, 3)
        use["rest"] = round(rest, 3)
        use["high"] = round(high, 3) if high - rest > ONE_SIDED else round(rest, 3)
        if first < rest:
            use["invert"] = True
        if not name.startswith("hat"):
            span = min(side for side in (high - rest, rest - low) if side > ONE_SIDED)
            use["dead_zone"] = round(min(max(DEAD_ZONE, self._noise[name] / span), 0.9), 3)
        return use

    def _button(self) -> str | None:
        name = self._first(button=True)
        if name is None:
            return None
        for _ in range(self._patience):
            if self._read()[name] < FAR:
                break
            self._tick()
        self._say(f"  {name}")
        return name


def text_of(data: dict[str, Any], name: str) -> str:
    """Return a profile's data as YAML text, with the device's name in its first line."""
    plain = " ".join(name.split())
    return f"# {plain}, by scara-drake devices --calibrate.\n" + yaml.safe_dump(
        data, sort_keys=False, default_flow_style=None, width=100
    )

"""The inputs of a device: how each layout calls them, and how one moves an axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from scara_drake.common.fields import number
from scara_drake.operator.devices.sample import AXIS_LIMIT

MAX_INDEX = 63  # of an axis, a button or a hat: more than any joystick has
REST_ZONE = 0.1  # of the travel: where an axis counts as let go; worn sticks rest at up to 0.08
SHORTEST = 0.05  # way of an input from rest to its end
DOWN = 0.5  # an input from here on is a pressed button

_JOYSTICK = r"axis\d{1,2}|button\d{1,2}|hat\d{1,2}_[xy]"
# SDL's names, see SDL_GameControllerGetStringForAxis and its like for buttons.
CONTROLLER_AXES: Final = ("leftx", "lefty", "rightx", "righty", "lefttrigger", "righttrigger")
CONTROLLER_BUTTONS: Final = (
    *("a", "b", "x", "y", "back", "guide", "start", "leftstick", "rightstick"),
    *("leftshoulder", "rightshoulder", "dpup", "dpdown", "dpleft", "dpright"),
)
# What the inputs of a layout may be called, in words and as a pattern.
LAYOUTS: Final[dict[str, tuple[str, str]]] = {
    "joystick": ("axis0, button0, hat0_x, hat0_y and so on", _JOYSTICK),
    "game_controller": (
        f"{', '.join((*CONTROLLER_AXES, *CONTROLLER_BUTTONS))}, or those of a joystick",
        "|".join((*CONTROLLER_AXES, *CONTROLLER_BUTTONS, _JOYSTICK)),
    ),
    "keyboard": ("names of keys: a, 1, space, left, kp8 and so on", r"[a-z0-9_]{1,16}"),
    "spacemouse": (
        "x, y, z, roll, pitch, yaw, button0 and so on",
        r"[xyz]|roll|pitch|yaw|button\d+",
    ),
}


@dataclass
class Use:
    """An input and how it moves an axis: 0 at rest, to 1 at `high` and to -1 at `low`.

    Attributes:
        input: its name, see `LAYOUTS`.
        low: what it reads at one end; where it rests there, as a trigger does, it moves one way.
        rest: what it reads when it is let go.
        high: what it reads at the other end.
        invert: the other way round.
        dead_zone: share of the travel around rest that does nothing; the others fill its place.
        expo: 0 is linear, 1 the cube: fine around rest, the ends as before.
    """

    input: str = ""
    low: float = number(-1.0, "1", -1.0, 1.0)
    rest: float = number(0.0, "1", -1.0, 1.0)
    high: float = number(1.0, "1", -1.0, 1.0)
    invert: bool = False
    dead_zone: float = number(0.0, "1", 0.0, 0.9)
    expo: float = number(0.0, "1", 0.0, 1.0)

    def check_together(self, name: str) -> None:
        """Check that rest is between the ends, and not so near one that the axis would step.

        Raises:
            ValueError: it is not, or there is no way to go.
        """
        ways = (self.rest - self.low, self.high - self.rest)
        if not (all(way == 0.0 or way >= SHORTEST for way in ways) and any(ways)):
            raise ValueError(
                f"{name}: low {self.low:g}, rest {self.rest:g}, high {self.high:g}, allowed "
                f"low <= rest <= high, each end at rest or {SHORTEST:g} away, and not both at rest"
            )

    def value(self, raw: float) -> float:
        """Return the axis, -1 to 1, for what the input reads; what is none is passed on as it is.

        With ``v`` the share of the way to the end, ``w = (|v| - dead_zone) / (1 - dead_zone)``
        beyond the dead zone and 0 within, it is ``sign(v) ((1 - expo) w + expo w^3)``.
        """
        if not abs(raw) <= AXIS_LIMIT:  # NaN too
            return raw
        way = raw - self.rest
        span = self.high - self.rest if way > 0.0 else self.rest - self.low
        share = min(abs(way) / span, 1.0) if span > 0.0 else 0.0
        share = max(share - self.dead_zone, 0.0) / (1.0 - self.dead_zone)
        share = (1.0 - self.expo) * share + self.expo * share**3
        return math.copysign(share, -way if self.invert else way)

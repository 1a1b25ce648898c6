"""What the page and the server say to each other, and the bounds of all of it.

Everything is below ``http[s]://HOST:PORT/TOKEN/``, so every relative address of the page carries
the token; without it there is nothing (404)::

    (empty)     page/index.html        viewer.js   the Meshcat viewer
    NAME        page/NAME              ws          the websocket

On the websocket each text message is a JSON object with a `type`. From the server: `Hello` once and
first, then `Telemetry` at most `TELEMETRY_RATE` times a second, `Control` whenever who is there or
who holds control changes, `Event`, `Refused`, and `Ended` last. From the page::

    {"type": "input", "axes": [x, y, z, mast_axis, mast_hat], "orientation": [roll, pitch, yaw],
     "buttons": {"engage": true, ...}, "device": "what the browser calls it"}
    {"type": "setting", "name": "force_scale", "value": 0.5}
    {"type": "control", "action": "take" | "release" | "give", "to": 3}     "to" with "give" only
    {"type": "view", "delayed": true}
    {"type": "drawn", "frame": 17}

Axes are in [-1, 1]; a button that is not named is up; `settings` of `Hello` has the bounds of a
value. The page that holds control sends `input` at least `INPUT_RATE` times a second, changed or
not: its silence is a device that is stale, its end one that is lost. Input and settings of another
page are not obeyed. Control can be taken while nobody holds it, released, and given by its holder.

Each binary message is one picture: the number of its frame, then Meshcat's commands one after the
other, each as its length and its bytes (msgpack, for `viewer.handle_command_bytearray`); numbers
are unsigned, 32 bit, little-endian. The page answers `drawn` once a picture is on the screen, and
the server sends no more than `FRAMES_IN_FLIGHT` that are not: a page that draws slowly gets fewer
pictures, never old ones.

A message that is anything else closes the connection of its sender, with `BAD_MESSAGE`; `requests`
reads them.
"""

from __future__ import annotations

from typing import Final, NamedTuple, TypedDict

from scara_drake.vectors import NEUTRAL_SETTINGS

VERSION: Final = 1
TELEMETRY_RATE: Final = 30.0  # [Hz]
INPUT_RATE: Final = 20.0  # [Hz]
FRAMES_IN_FLIGHT: Final = 2
MAX_MESSAGE: Final = 4096  # of a page [bytes]
MAX_NAME: Final = 120  # of a device [characters]
MAX_NUMBER: Final = 2**32 - 1  # of a frame or a client
SLOW_SCENE: Final = 0.2  # lag of the pictures that is told [s]

# Codes of a websocket's end.
BAD_MESSAGE: Final = 4400
TOO_SLOW: Final = 4408
TOO_MANY: Final = 4429


class Bounds(NamedTuple):
    """A setting that an operator may change during a run.

    Attributes:
        unit: of its value.
        lower: smallest value.
        upper: largest value.
        neutral: the value that changes nothing.
        words: what it is.
    """

    unit: str
    lower: float
    upper: float
    neutral: float
    words: str


SETTINGS: Final[dict[str, Bounds]] = {
    "delay_up": Bounds("s", 0.0, 2.0, NEUTRAL_SETTINGS.delay_up, "delay of the command, added"),
    "delay_down": Bounds("s", 0.0, 2.0, NEUTRAL_SETTINGS.delay_down, "delay of the force, added"),
    "force_scale": Bounds("1", 0.0, 4.0, NEUTRAL_SETTINGS.force_scale, "force that is felt"),
    "motion_scale": Bounds("1", 0.05, 1.0, NEUTRAL_SETTINGS.motion_scale, "travel of the tool"),
    "gain_scale": Bounds("1", 0.25, 2.0, NEUTRAL_SETTINGS.gain_scale, "gains of the controller"),
}


class JointFacts(TypedDict):
    """A joint: its range in `unit`, its effort limit in `effort_unit`."""

    name: str
    unit: str
    lower: float
    upper: float
    effort: float
    effort_unit: str


class SettingFacts(TypedDict):
    """A setting, its bounds and its value at the start, see `Bounds`."""

    name: str
    words: str
    unit: str
    lower: float
    upper: float
    value: float


class CameraView(TypedDict):
    """A place for the camera, z up [m].

    `frame` is the path of what carries it, such as "/meshcat/robot/tool", or "" for the world.
    """

    name: str
    eye: list[float]
    target: list[float]
    up: list[float]
    zoom: float
    frame: str


class Client(TypedDict):
    """One who is there: his number, and what the browser calls his device."""

    id: int
    name: str


class Control(TypedDict):
    """`type` "control": who is there, who holds control (None: nobody), and whether it is you."""

    type: str
    you: int
    holder: int | None
    mine: bool
    clients: list[Client]


class Hello(TypedDict):
    """`type` "hello": what does not change during a run; `duration` [s] of the scenario."""

    type: str
    version: int
    scenario: str
    duration: float
    axes: list[str]
    orientation: list[str]
    buttons: list[str]
    joints: list[JointFacts]
    settings: list[SettingFacts]
    views: list[CameraView]
    delayed: bool  # what `view` is at the start
    slow_scene: float  # lag that is to be shown [s]
    max_force: float | None  # from which on the robot's supervisor backs off [N]
    control: Control


class Status(TypedDict):
    """A supervisor: codes, names and words of `safety`; `sentence` has state and words."""

    state: int
    name: str  # IDLE, ACTIVE, CLUTCH, HOLD, FAULT or E-STOP
    reason: int
    words: str
    remedy: str
    sentence: str
    engagements: int
    faults: int


class Telemetry(TypedDict):
    """`type` "telemetry": the run now. A number that is not known is None."""

    type: str
    t: float  # simulated [s]
    realtime_factor: float | None
    lateness: float | None  # behind the clock, now [s]
    late_ticks: int
    p99: float | None  # of the lateness [s]
    operator: Status
    robot: Status
    delay_up: float | None  # [s]
    delay_down: float | None  # [s]
    force: list[float | None]  # (3) of the environment on the tool, in W, as it is felt [N]
    force_size: float | None  # [N]
    tool_error: float | None  # from the desired to the real tool point [m]
    q: list[float | None]  # (6) [m, rad]
    effort_share: list[float | None]  # (6) of the limit, in [-1, 1]
    tool: list[float | None]  # p_WE (3) [m], quaternion w x y z (4)
    rumble: list[float]  # low and high motor, in [0, 1]: what the holder's device is to do now
    settings: dict[str, float]
    lag: float | None  # how old the picture on your screen is beyond the delay of the view [s]
    dropped: int  # pictures that were not sent to you
    clients: int
    holder: int | None
    task: str  # one line, or ""


class Event(TypedDict):
    """`type` "event": a supervisor came to another state or reason at `t` [s]."""

    type: str
    t: float
    side: str  # "operator" or "robot"
    state: int
    reason: int
    sentence: str
    remedy: str
    severity: int  # of the reason: 0 said only, 1 hold, 2 fault, 3 emergency stop


class Refused(TypedDict):
    """`type` "refused": why what you asked for is not done."""

    type: str
    words: str


class Ended(TypedDict):
    """`type` "ended": the run is over; the lines of its summary, and the files it wrote."""

    type: str
    good: bool
    lines: list[str]
    files: list[str]

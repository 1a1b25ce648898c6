"""How things look: colours, sizes and the camera, of the live scene, the replay and the plots.

numpy only, because the replay draws where Drake has no wheel.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Color = tuple[float, float, float, float]  # red, green, blue, opacity

DESIRED: Final[Color] = (0.95, 0.05, 0.75, 0.70)
MEASURED: Final[Color] = (0.05, 0.62, 0.45, 1.0)
FORCE: Final[Color] = (0.90, 0.04, 0.04, 0.99)  # not opaque: drawn after the translucent wall
SURFACE: Final[Color] = (0.42, 0.58, 0.74, 0.30)
TASK: Final[Color] = (1.0, 0.50, 0.0, 1.0)
CUT: Final[Color] = (0.06, 0.06, 0.07, 1.0)
PIPE: Final[Color] = (0.55, 0.57, 0.60, 0.85)
EDGE: Final[Color] = (0.20, 0.29, 0.40, 1.0)
AXES: Final[tuple[Color, Color, Color]] = (
    (0.9, 0.1, 0.1, 1.0),
    (0.1, 0.75, 0.1, 1.0),
    (0.1, 0.3, 0.95, 1.0),
)
DEVICE: Final[Color] = (0.30, 0.22, 0.55, 1.0)
HAND: Final[Color] = (0.95, 0.80, 0.25, 0.60)
SKY: Final = {"top_color": [0.78, 0.86, 0.94], "bottom_color": [0.99, 0.99, 0.99]}
SKY_LOST: Final = {"top_color": [0.93, 0.45, 0.35], "bottom_color": [1.0, 0.85, 0.6]}

# Of plots only, as matplotlib writes them.
COMMANDED: Final = "0.6"  # greys: what was given,
LIMIT: Final = "0.5"  # what is allowed,
LAW: Final = "0.15"  # what an equation says
FIRST: Final = "#2f6fb0"  # of two of a kind, side by side
SECOND: Final = "#e0962a"

# Of block diagrams.
BOX_FILL: Final = "#fff4e6"
BOX_EDGE: Final = "#b35900"
ARROW: Final = "#444444"

# Of verdicts, from good to none, behind black text.
VERDICTS: Final = ("#d9f2e6", "#fff3cd", "#f8d7da", "#e9ecef")

TRAIL_RADIUS: Final = 0.008  # [m]
EDGE_WIDTH: Final = 0.03  # of the frame around a wall [m]

SMALLEST_FORCE: Final = 1.0  # below it no arrow is drawn [N]
METRES_PER_NEWTON: Final = 1.0 / 400.0
LONGEST_SHAFT: Final = 0.9  # [m]
HEAD: Final = 0.14  # length of the arrow head [m]

VIEW: Final = np.array([1.0, 0.6, 0.5])  # from the scene to the camera
ZOOM: Final = 2.2  # a longer lens than the default 75 degrees, so that the picture is less bent
# The arm at home and the foot of its mast, which is always in the picture [m].
ARM: Final = np.array([[-0.3, 0.5, 3.0], [0.0, 0.0, 3.9], [1.3, -0.6, 3.0], [0.6, 0.6, 2.6]])
# The ground, the mast drawn in and the girders: the whole crane.
WHOLE: Final = np.array([[5.0, 2.6, 0.0], [5.0, -2.6, 0.0], [-5.0, 2.6, 0.0], [-5.0, -2.6, 0.0],
                         [0.0, 0.0, 14.4]])  # fmt: skip
_HALF_HEIGHT = np.tan(np.deg2rad(75.0 / 2)) / ZOOM  # of the picture, one metre from the camera
_ASPECT = 1.5  # width to height; a wider window shows more
_FILL = 0.9  # part of the picture that the scene fills


class Part(NamedTuple):
    """A shape of something drawn.

    Attributes:
        name: of its own.
        shape: box, cylinder, cone or sphere.
        size: x, y, z of a box; radius and length of a cylinder along z, and of a cone that points
            to z; radius of a sphere [m].
        X: pose (4, 4) of its middle in the frame of the whole.
        color: of its surface.
    """

    name: str
    shape: str
    size: tuple[float, ...]
    X: Array
    color: Color


def at(x: float, y: float, z: float) -> Array:
    """Return the pose (4, 4) of a place [m] without a turn."""
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


def _along(axis: int, distance: float) -> Array:
    """Pose whose z is an axis, a distance [m] away on it."""
    X = np.eye(4)
    X[:3, :3] = np.roll(np.eye(3), 2 - axis, axis=1)
    X[axis, 3] = distance
    return X


# The desired tool, of which the real one, where it is in it, stays visible: a thin rod to a ball at
# the tool point, with the frame's axes, and rings around.
GHOST: Final[tuple[Part, ...]] = (
    Part("rod", "cylinder", (0.012, 0.62), at(0.0, 0.0, -0.36), DESIRED),
    Part("tip", "sphere", (0.03,), np.eye(4), DESIRED),
    *(
        Part(f"ring_{index}", "cylinder", (0.085, 0.014), at(0.0, 0.0, z), DESIRED)
        for index, z in enumerate((-0.55, -0.37, -0.19))
    ),
    *(
        Part(f"axis_{axis}", "cylinder", (0.009, 0.25), _along(axis, 0.125), color)
        for axis, color in enumerate(AXES)
    ),
)
# An arrow along z that ends at the origin: it pushes on the tool, whose body hides no part of it.
# The shaft is one metre long, to be scaled and placed; the head keeps its size.
SHAFT: Final = Part("shaft", "cylinder", (0.028, 1.0), np.eye(4), FORCE)
TIP: Final = Part("head", "cone", (0.07, HEAD), at(0.0, 0.0, -HEAD / 2), FORCE)


# The operator's device and the place where his hand wants it, on their own board; at its middle
# both are in the middle of the workspace.
BOARD_PLACE: Final = np.array([1.1, 0.45, 2.65])  # [m], at the operator's side of the scene
BOARD_SCALE: Final = 3.0  # of the motions, which are centimetres
BOARD: Final = Part("board", "box", (0.5, 0.5, 0.015), at(0.0, 0.0, -0.1), EDGE)
HELD: Final[dict[str, Part]] = {  # by signal
    "motion_master": Part("device", "sphere", (0.05,), np.eye(4), DEVICE),
    "hand_target": Part("hand", "sphere", (0.075,), np.eye(4), HAND),
}


def on_board(x: ArrayLike) -> Array:
    """Return where on the board (..., 3) [m] a place (..., 3) [m] in the workspace is drawn."""
    return BOARD_SCALE * np.asarray(x)


def shaft_length(newtons: ArrayLike) -> Array:
    """Return the lengths (...) [m] of the shafts of arrows for forces (...) [N]."""
    return np.minimum(np.asarray(newtons) * METRES_PER_NEWTON, LONGEST_SHAFT)


def shaft_middle(length: ArrayLike) -> Array:
    """Return where the middles of shafts of some lengths (...) [m] are on the arrow's z [m]."""
    return -HEAD - np.asarray(length) / 2


def edge_frame(size: ArrayLike, thickness: float) -> list[Part]:
    """Return four bars around a block of a size (2,) [m], in the frame of its middle."""
    width, height = np.asarray(size, dtype=np.float64).tolist()
    x, y = (width + EDGE_WIDTH) / 2, (height + EDGE_WIDTH) / 2
    flat = (width + 2 * EDGE_WIDTH, EDGE_WIDTH, thickness)
    upright = (EDGE_WIDTH, height, thickness)
    bars = [(flat, (0, y)), (flat, (0, -y)), (upright, (x, 0)), (upright, (-x, 0))]
    return [
        Part(f"edge_{index}", "box", bar, at(*middle, 0.0), EDGE)
        for index, (bar, middle) in enumerate(bars)
    ]


def camera(points: ArrayLike) -> tuple[Array, Array]:
    """Return where the camera stands and where it looks (3,) [m], so that it sees some points.

    It stands on the operator's side and sees the arm and the points (n, 3) [m] with little around.
    """
    seen = np.vstack([ARM, np.reshape(points, (-1, 3))])
    target = (seen.min(axis=0) + seen.max(axis=0)) / 2
    # The camera's axes; the nearest distance from which each point falls within the picture.
    back = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0.0, 0.0, 1.0], back) / np.hypot(back[0], back[1])
    up = np.cross(back, right)
    offsets = seen - target
    high, wide = np.abs(offsets @ up), np.abs(offsets @ right) / _ASPECT
    distance = float(np.max(offsets @ back + np.maximum(high, wide) / (_FILL * _HALF_HEIGHT)))
    return target + distance * back, target

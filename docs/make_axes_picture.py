"""Makes docs/axes.png, our Figure 2: the axes of the joints drawn on the robot.

python docs/make_axes_picture.py
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]  # no stubs
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]  # no stubs
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from scara_drake.common.resources import resource
from scara_drake.common.urdf import LinkTree, Visual, read_visuals
from scara_drake.display import look
from scara_drake.joints import HOME, JOINT_NAMES

Array = NDArray[np.float64]

PATH: Final = Path(__file__).parent / "axes.png"
TOP: Final = 3.75  # where the mast is cut off [m]
HALF_AXIS, TRIAD = 0.55, 0.2  # lengths drawn [m]
LIGHT: Final = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
# A joint's axis is z of the link that it moves. Joints 1 and 2 have the same.
LABELS: Final = {"link_1": "d1, θ2", **{f"link_{n}": f"θ{n}" for n in range(3, 7)}}

AT_THE_FOOT: Final = ("link_1", "link_3", "link_6")  # labels there cover no link


def corners(visual: Visual) -> Array:
    """Return points (n, 3) [m] in the link's frame whose hull is a visual, a box or a cylinder."""
    if visual.shape == "box":
        points = np.array(list(product((-0.5, 0.5), repeat=3))) * visual.size
    else:
        radius, length = visual.size
        angle = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
        ring = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(36)])
        points = np.concatenate([ring - [0.0, 0.0, half] for half in (length / 2, -length / 2)])
    return np.asarray(points @ visual.X_LV[:3, :3].T + visual.X_LV[:3, 3])


def add_solid(ax: Axes3D, points: Array, color: tuple[float, ...]) -> None:
    """Add the hull of points (n, 3) [m], each face as bright as it faces the light."""
    hull = ConvexHull(points)
    brightness = 0.6 + 0.4 * np.clip(hull.equations[:, :3] @ LIGHT, 0.0, 1.0)
    faces = np.clip(brightness[:, np.newaxis] * np.array(color[:3]), 0.0, 1.0)
    ax.add_collection3d(Poly3DCollection(points[hull.simplices], facecolors=faces))


def main() -> None:
    """Make docs/axes.png."""
    urdf = ET.fromstring(resource("models", "scara6.urdf").read_bytes())
    X_WL = LinkTree(urdf).poses(dict(zip(JOINT_NAMES, HOME, strict=True)))
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    ax = figure.add_subplot(projection="3d", computed_zorder=False)
    seen = []
    for visual in read_visuals(urdf):
        X = X_WL[visual.link]
        points = corners(visual) @ X[:3, :3].T + X[:3, 3]
        if visual.link == "base" or points[:, 2].min() >= TOP:
            continue
        points[:, 2] = np.minimum(points[:, 2], TOP)
        add_solid(ax, points, visual.color)
        seen.append(points)
    for link, text in LABELS.items():
        origin, z = X_WL[link][:3, 3], X_WL[link][:3, 2]
        ends = np.stack([origin - HALF_AXIS * z, origin + HALF_AXIS * z])
        ax.plot(*ends.T, color=look.FORCE[:3], linewidth=1.6, zorder=5)
        place = origin + (HALF_AXIS + 0.1) * (-z if link in AT_THE_FOOT else z)
        ax.text(*place, text, fontsize=13, ha="center", va="center", zorder=6)
    for link in (*LABELS, "tool"):
        for axis, color in zip(X_WL[link][:3, :3].T, look.AXES, strict=True):
            ends = np.stack([X_WL[link][:3, 3], X_WL[link][:3, 3] + TRIAD * axis])
            ax.plot(*ends.T, color=color, linewidth=3.0, zorder=4)
    shown = np.concatenate(seen)
    low, high = shown.min(axis=0), shown.max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low, zoom=1.3)
    ax.view_init(elev=22.0, azim=-60.0)
    ax.set_axis_off()
    figure.savefig(PATH, dpi=100)


if __name__ == "__main__":
    main()

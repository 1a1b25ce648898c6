"""The camera of a Meshcat and what is around the scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pydrake.geometry import Meshcat

from scara_drake.display import look
from scara_drake.environment import Environment


def show_whole(meshcat: Meshcat) -> None:
    """Look at the whole crane, from the ground to the top of the mast."""
    meshcat.SetCameraPose(*look.camera(look.WHOLE))


def set_camera(meshcat: Meshcat, environment: Environment, places: ArrayLike = ()) -> None:
    """Look at the arm, the foot of the mast, the surfaces and some more places (n, 3) [m].

    From the operator's side.
    """
    corners = [surface.corners() for surface in environment.surfaces]
    if environment.cut is not None:
        corners.append(environment.cut.corners())
    eye, target = look.camera(np.vstack([np.reshape(places, (-1, 3)), *corners]))
    meshcat.SetCameraPose(eye, target)
    meshcat.SetProperty("/Cameras/default/rotated/<object>", "zoom", look.ZOOM)
    for name, color in look.SKY.items():
        meshcat.SetProperty("/Background/<object>", name, color)
    meshcat.SetProperty("/Axes", "visible", False)

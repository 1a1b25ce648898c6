"""Makes the pictures of docs/training.md, each of a run of a training scene (needs chromium).

python docs/make_training_pictures.py
"""

from __future__ import annotations

import numpy as np
from make_pictures import FOLDER, save_scene
from pydrake.geometry import Meshcat

import scara_drake as sd

# Of each scene: when [s], where the camera stands and where it looks [m].
SHOTS = {
    "touch_points": (4.8, [1.9, 0.9, 3.7], [0.7, -0.75, 3.0]),
    "trace_line": (20.0, [1.9, 0.9, 3.9], [0.7, -0.9, 3.0]),
    "reach_into_box": (8.0, [1.8, 0.4, 3.9], [0.75, -1.0, 3.0]),
    "cut_pipe": (26.0, [1.5, -0.55, 3.45], [0.78, -0.95, 3.0]),
}


def main() -> None:
    """Make docs/training_SCENE.png of all scenes."""
    for name, (end, eye, target) in SHOTS.items():
        meshcat = Meshcat()
        sd.simulate(sd.load_scenario(name), end, meshcat=meshcat)
        meshcat.SetCameraPose(np.array(eye), np.array(target))
        save_scene(meshcat, FOLDER / f"training_{name}.png")


if __name__ == "__main__":
    main()

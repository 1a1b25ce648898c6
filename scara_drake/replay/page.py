"""The animation of a replay, for a page that plays without Python."""

from __future__ import annotations

import meshcat
import numpy as np
from meshcat.animation import Animation, AnimationClip, AnimationTrack
from meshcat.transformations import quaternion_from_matrix

from scara_drake.replay.scene import Poses


def animation_of(viewer: meshcat.Visualizer, poses: Poses, fps: float) -> Animation:
    """Tracks of position, rotation and scale, with keys only where something changes."""
    animation = Animation()
    for path, X in poses.items():
        clip, scale = AnimationClip(fps=fps), np.linalg.norm(X[:, :3, :3], axis=1)
        rotation = (X[:, :3, :3] / scale[:, None]).reshape(-1, 9)
        for name, values in (("position", X[:, :3, 3]), ("scale", scale), ("quaternion", rotation)):
            changes = (values[1:] != values[:-1]).any(axis=1)
            keys = np.flatnonzero(np.append(changes, False) | np.insert(changes, 0, False))
            kind, values = "vector3", values[keys]
            if name == "quaternion":  # x, y, z, w
                kind, matrices = name, values.reshape(-1, 3, 3)
                values = np.array([np.roll(quaternion_from_matrix(R), -1) for R in matrices])
            if keys.size:
                clip.tracks[name] = AnimationTrack(name, kind, keys.tolist(), values.tolist())
        if clip.tracks:
            animation.clips[viewer[path].path] = clip
    return animation

"""Postures and tool poses: over the whole range, at the limits, at singularities, out of reach."""

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from scara_drake import kinematics
from scara_drake.joints import LOWER, UPPER

Array = NDArray[np.float64]

# Angles at which the arm loses a direction: the forearm along or across the beam, the tool axis
# vertical or along the forearm.
SPECIAL_ANGLES = [k * np.pi / 4 for k in range(-8, 9)]


def _joint(j: int) -> st.SearchStrategy[float]:
    low, high = float(LOWER[j]), float(UPPER[j])
    limits = st.sampled_from([low, high])
    special = st.sampled_from([a for a in SPECIAL_ANGLES if low <= a <= high] if j else [low, 5.0])
    # Close to a special value is where rounding decides.
    near = st.builds(
        lambda a, e: min(max(a + e, low), high),
        st.one_of(limits, special),
        st.sampled_from([1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3]),
    )
    return st.one_of(st.floats(low, high), limits, special, near)


def postures() -> st.SearchStrategy[Array]:
    """Postures (6,) inside the joint ranges, limits and singularities among them."""
    return st.tuples(*(_joint(j) for j in range(6))).map(np.array)


def at_limits() -> st.SearchStrategy[Array]:
    """Postures (6,) with at least one joint on its limit."""

    def put(q: Array, joints: frozenset[int], upper: bool) -> Array:
        held = q.copy()
        for j in joints:
            held[j] = (UPPER if upper else LOWER)[j]
        return held

    return st.builds(put, postures(), st.frozensets(st.integers(0, 5), min_size=1), st.booleans())


def singular() -> st.SearchStrategy[Array]:
    """Postures (6,) where the forearm is along the beam's axis or the tool above the mast.

    cos θ4 = 0 puts the forearm along the beam, where θ3 turns nothing but the tool.
    """

    def stretch(q: Array, up: bool) -> Array:
        bent = q.copy()
        bent[3] = np.pi / 2 if up else -np.pi / 2
        return bent

    return st.builds(stretch, postures(), st.booleans())


def reachable() -> st.SearchStrategy[tuple[Array, Array]]:
    """Postures (6,) of all kinds, each with its tool pose (4, 4)."""
    return st.one_of(postures(), at_limits(), singular()).map(
        lambda q: (q, kinematics.forward_kinematics(q))
    )


def rotations() -> st.SearchStrategy[Array]:
    """Rotations (3, 3)."""
    angle = st.one_of(st.floats(-np.pi, np.pi), st.sampled_from(SPECIAL_ANGLES))
    return st.tuples(angle, angle, angle).map(
        lambda rpy: kinematics.rotation_from_intrinsic_xyz(np.array(rpy))
    )


def unreachable() -> st.SearchStrategy[Array]:
    """Poses (4, 4) beyond the arm's reach at every height of the mast, up to what is allowed."""

    def pose(distance: float, azimuth: float, z: float, R: Array) -> Array:
        X = np.eye(4)
        X[:3, :3] = R
        X[:3, 3] = distance * np.cos(azimuth), distance * np.sin(azimuth), z
        return X

    beyond = kinematics.REACH + 0.01
    return st.builds(
        pose,
        st.one_of(st.floats(beyond, 10.0), st.floats(10.0, 7e5)),
        st.floats(-np.pi, np.pi),
        st.one_of(st.floats(0.0, 12.0), st.floats(-7e5, 7e5)),
        rotations(),
    )

"""Vectors of three as tuples, and spatial inertias, for kernels: they stay in registers."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Vector = tuple[float, float, float]


@njit(cache=True, error_model="numpy")
def cross(a: Vector, b: Vector) -> Vector:
    """Cross product of two vectors."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@njit(cache=True, error_model="numpy")
def dot(a: Vector, b: Vector) -> float:
    """Scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def plus(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@njit(cache=True, error_model="numpy")
def times(a: float, b: Vector) -> Vector:
    """A number times a vector."""
    return (a * b[0], a * b[1], a * b[2])


@njit(cache=True, error_model="numpy")
def rotated(R: Array, i: int, a: Vector) -> Vector:
    """Matrix i of some (n, 3, 3) times a vector."""
    return (
        R[i, 0, 0] * a[0] + R[i, 0, 1] * a[1] + R[i, 0, 2] * a[2],
        R[i, 1, 0] * a[0] + R[i, 1, 1] * a[1] + R[i, 1, 2] * a[2],
        R[i, 2, 0] * a[0] + R[i, 2, 1] * a[1] + R[i, 2, 2] * a[2],
    )


@njit(cache=True, error_model="numpy")
def row_of(R: Array, i: int, row: int) -> Vector:
    """A row of matrix i of some (n, 3, 3)."""
    return (R[i, row, 0], R[i, row, 1], R[i, row, 2])


@njit(cache=True, error_model="numpy")
def vector(rows: Array, i: int, start: int) -> Vector:
    """Three entries of row i, from `start`; a view of them would cost more than to read them."""
    return (rows[i, start], rows[i, start + 1], rows[i, start + 2])


@njit(cache=True, error_model="numpy")
def momentum(inertia: Array, i: int, w: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Angular and linear part of spatial inertia i times a spatial vector."""
    mass, first = inertia[i, 0], vector(inertia, i, 1)
    xx, yy, zz = vector(inertia, i, 4)
    xy, xz, yz = vector(inertia, i, 7)
    turned = (
        xx * w[0] + xy * w[1] + xz * w[2],
        xy * w[0] + yy * w[1] + yz * w[2],
        xz * w[0] + yz * w[1] + zz * w[2],
    )
    return plus(turned, cross(first, v)), plus(times(mass, v), cross(w, first))

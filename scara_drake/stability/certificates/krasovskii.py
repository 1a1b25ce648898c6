r"""A constant delay: a Lyapunov-Krasovskii functional, found by semidefinite programming.

For a loop :math:`\dot x = A x + b\,y(t - h)`, :math:`y = c^T x`, with the moments
:math:`\Omega_k = \int_{t-h}^t L_k\,y`, over Legendre's polynomials of the last h, of order 0 to
N - 1,

.. math::

    V = \begin{pmatrix} x \\ \Omega \end{pmatrix}^T P \begin{pmatrix} x \\ \Omega \end{pmatrix}
        + S \int_{t-h}^t y^2 + h R \int_{t-h}^t (s - t + h)\,\dot y(s)^2\,ds

By Bessel's inequality V is positive and falls if two matrices are definite (Seuret and Gouaisbaut,
Systems and Control Letters 81, 2015, 1); N = 1 is Wirtinger's inequality (Automatica 49, 2013,
2860). The first matrix rises as h falls and the second is convex in h, so one P, S, R that is
right for two delays is right for all between. A chain of such intervals from no delay on proves all
delays up to its end. Each link is verified with `exact`, so the proof is one for the coefficients
as the machine has them, and trusts no solver.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.stability.certificates.exact import exact, is_positive_definite
from scara_drake.stability.certificates.loop import Loop, is_stable
from scara_drake.stability.certificates.semidefinite import propose

Array = NDArray[np.float64]

ORDER = 2  # N
CLOSE = 5e-3  # length of the last interval that is tried, relative to what is proven
FIRST = 0.1  # of the slowest time that a step is tried with


class Functional(NamedTuple):
    """P (n + N, n + N), S and R of the functional."""

    p: Any
    s: Any
    r: Any


def falls(loop: Loop, h: Any, functional: Functional, order: int) -> Any:
    """Return minus the matrix of V' (n + 1 + N, n + 1 + N), in x, y(t - h) and Omega / h.

    Its entries are of the kind of what is given, numbers or fractions.
    """
    n = loop.a.shape[0]
    kind = loop.a.dtype
    moments = _moments(loop, order)
    rate = np.concatenate([np.zeros((n, n + 1 + order), dtype=kind), moments[:-1]])
    rate[:n, :n], rate[:n, n : n + 1] = loop.a, loop.b
    place = np.zeros((n + order, n + 1 + order), dtype=kind)  # of x and Omega
    place[range(n), range(n)] = 1
    place[range(n, n + order), range(n + 1, n + 1 + order)] = h
    y, y_late = np.zeros((2, n + 1 + order), dtype=kind)
    y[:n], y_late[n] = loop.c[0], 1
    y_rate = loop.c[0] @ rate[:n]
    half = place.T @ functional.p @ rate
    kept = functional.s * (np.outer(y, y) - np.outer(y_late, y_late))
    bessel = moments.T @ ((2 * np.arange(order + 1)[:, None] + 1) * moments)
    return -(half + half.T + kept + functional.r * (h * h * np.outer(y_rate, y_rate) - bessel))


def _moments(loop: Loop, order: int) -> Any:
    """Return the integrals of L_k y' over the last h (N + 1, n + 1 + N), from k = 0 to N.

    By parts: y - (-1)^k y(t - h) - sum of 2 (2 j + 1) Omega_j / h over the j = k - 1, k - 3, ...
    """
    n = loop.a.shape[0]
    moments = np.zeros((order + 1, n + 1 + order), dtype=loop.a.dtype)
    for k in range(order + 1):
        moments[k, :n] = loop.c[0]
        moments[k, n] = -((-1) ** k)
        for j in range(k - 1, -1, -2):
            moments[k, n + 1 + j] = -2 * (2 * j + 1)
    return moments


def holds(loop: Loop, h: Any, functional: Functional, order: int) -> Any:
    """Return h times the matrix (n + N, n + N) below V, over h, in x and Omega."""
    weights = np.concatenate([np.zeros(loop.a.shape[0], dtype=int), 2 * np.arange(order) + 1])
    return h * functional.p + functional.s * np.diag(weights)


def find(loop: Loop, low: float, high: float, order: int = ORDER) -> Functional | None:
    """Return a functional that proves all delays from low to high [s]; None if none is found.

    Args:
        loop: of one late signal, scaled, in the unit of time of the delays.
        low: [s].
        high: [s].
        order: N.
    """

    def functional(p: Array, numbers: Array) -> Functional:
        return Functional(p, numbers[0], numbers[1])

    inequalities = [
        lambda p, numbers: falls(loop, low, functional(p, numbers), order),
        lambda p, numbers: falls(loop, high, functional(p, numbers), order),
        lambda p, numbers: holds(loop, high, functional(p, numbers), order),
    ]
    found = functional(*propose(loop.a.shape[0] + order, 2, inequalities))
    return found if verify(loop, low, high, found, order) else None


def verify(loop: Loop, low: float, high: float, functional: Functional, order: int) -> bool:
    """Whether a functional proves all delays from low to high, without rounding; see `find`."""
    if not all(np.isfinite(part).all() for part in functional):
        return False
    p, s, r = functional
    precise = Functional(exact(0.5 * (p + p.T)), exact(s)[()], exact(r)[()])
    same = Loop(*(exact(part) for part in loop))
    begin, end = exact(low)[()], exact(high)[()]
    return bool(
        precise.s > 0
        and precise.r > 0
        and is_positive_definite(holds(same, end, precise, order))
        and is_positive_definite(falls(same, begin, precise, order))
        and is_positive_definite(falls(same, end, precise, order))
    )


def proven_delay(loop: Loop, longest: float = 10.0, order: int = ORDER) -> float:
    """Return a delay [s] such that the loop is proven stable for each constant one up to it.

    Zero where none is found; that it is stable without delay is then not said.

    Args:
        loop: any.
        longest: beyond which nothing is tried [s].
        order: N; a larger one proves more and takes longer.
    """
    if not is_stable(loop.undelayed()):
        return 0.0
    scaled, unit = loop.lumped().scaled()
    proven, step = 0.0, FIRST
    while step > CLOSE * max(proven, CLOSE) and proven < longest * unit:
        if find(scaled, proven, proven + step, order) is None:
            step *= 0.5
        else:
            proven += step
            step *= 1.5
    return proven / unit

r"""Delays that vary, and delays of any length: small gains, with the scaling that is best.

What arrives late differs from what is, :math:`w_i = y_i - y_i(t - \tau_i(t))`, by no more than
:math:`h_i` times the rate of y in the L2 norm, however fast a delay within 0 to :math:`h_i` varies
(Kao and Lincoln, Automatica 40, 2004, 1429). So the loop is stable if there are P and all
:math:`d_i` positive with

.. math::

    2 x^T P \dot x + \sum_i d_i (h_i^2\,\dot y_i^2 - w_i^2) < 0, \quad
    \dot x = (A + \textstyle\sum_i b_i c_i^T) x - \sum_i b_i w_i

for all x and w: the small gain theorem, scaled. A signal that is sampled, held, jittered, lost now
and then or played from a buffer has a delay that varies, so this proves those loops too, as long as
what is in use is never older than h.

With :math:`w_i = y_i(t - \tau)` and :math:`y_i^2 - w_i^2` in the place of the sum the gain around
the loop is below one, and a constant delay may be as long as it likes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.bisection import bracket
from scara_drake.stability.certificates.exact import exact, is_positive_definite
from scara_drake.stability.certificates.loop import Loop, is_stable
from scara_drake.stability.certificates.semidefinite import propose

Array = NDArray[np.float64]
Falls = Callable[[Loop, Any, Any], Any]  # of the loop, P and the scales d

CLOSE = 2e-3  # of a delay that is bisected
LEAST = 2.0**-20  # of the loop's slowest time, below which no delay is tried


def bears_any_delay(loop: Loop) -> bool:
    """Whether the loop is proven stable for constant delays of any length."""
    if not is_stable(loop.undelayed()) or not is_stable(loop.lumped().a):
        return False
    return _is_proven(loop.lumped().scaled()[0], _falls_at_any)


def varying_delay(loop: Loop, longest: float = 10.0) -> float:
    """Return a delay [s] up to which each signal may be late however that varies; zero if none.

    Args:
        loop: any.
        longest: that is tried [s].
    """
    if not is_stable(loop.undelayed()):
        return 0.0
    scaled, unit = loop.scaled()

    def proven(h: float) -> bool:
        return _is_proven(scaled, lambda loop, p, d: _falls_up_to(h, loop, p, d))

    low, high = 0.0, 2.0**-6
    while high <= longest * unit and proven(high):
        low, high = high, 2.0 * high
    return bracket(lambda h: not proven(h), low, high, CLOSE, LEAST)[0] / unit


def _falls_up_to(h: float, loop: Loop, p: Any, d: Any) -> Any:
    """Return minus the matrix of the condition for delays up to h (n + m, n + m), in x and w."""
    late = exact(h)[()] if p.dtype == object else h
    whole = np.concatenate([loop.undelayed(), -loop.b], axis=1)
    rates = loop.c @ whole
    return _falling(whole, p, d) - (late * late) * (rates.T @ (d[:, None] * rates))


def _falls_at_any(loop: Loop, p: Any, d: Any) -> Any:
    """Return minus the matrix of the condition for delays of any length (n + m, n + m)."""
    whole = np.concatenate([loop.a, loop.b], axis=1)
    sent = np.concatenate([loop.c, 0 * (loop.c @ loop.b)], axis=1)
    return _falling(whole, p, d) - sent.T @ (d[:, None] * sent)


def _falling(whole: Any, p: Any, d: Any) -> Any:
    """Return sum d w² - 2 x' P (whole (x, w)) as a matrix."""
    n, size = whole.shape
    half, scales = np.zeros((2, size, size), dtype=p.dtype)
    half[:n] = p @ whole
    scales[range(n, size), range(n, size)] = d
    return scales - half - half.T


def _is_proven(loop: Loop, falls: Falls) -> bool:
    n, m = loop.b.shape
    p, d = propose(n, m, [lambda p, d: falls(loop, p, d), lambda p, d: p])
    if not (np.isfinite(p).all() and np.isfinite(d).all() and (d > 0.0).all()):
        return False
    precise = exact(0.5 * (p + p.T))
    same = Loop(*(exact(part) for part in loop))
    return is_positive_definite(precise) and is_positive_definite(falls(same, precise, exact(d)))

r"""Loops with delays, and the delay at which they are seen to turn over.

A coupling whose ends know each other only by what arrives is one loop, linear around a state of
rest: some signals :math:`y_i` come late,

.. math::

    \dot x(t) = A\,x(t) + \sum_i b_i\,y_i(t - \tau_i), \quad y_i = c_i^T x

With two channels, there and back, and constant delays these add up, so all the delay can stand at
one of them. Then a root crosses the imaginary axis where :math:`|G(i \omega)| = 1`, with
:math:`G(s) = c^T (s I - A)^{-1} b`, and there first at the delay
:math:`\operatorname{arg} G(i \omega) / \omega`.
The frequencies are the imaginary eigenvalues of a Hamiltonian matrix, so none is missed between the
points of a grid.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import matrix_balance

Array = NDArray[np.float64]

ON_AXIS = 1e-7  # real part of an eigenvalue that counts as imaginary, relative to it


class Loop(NamedTuple):
    """A loop in continuous time, of which some signals are late.

    Attributes:
        a: A (n, n) [1/s].
        b: where each comes in (n, m).
        c: what is late (m, n).
    """

    a: Any
    b: Any
    c: Any

    def undelayed(self) -> Any:
        """Return the matrix of the loop without delays (n, n)."""
        return self.a + self.b @ self.c

    def lumped(self) -> Loop:
        """Return the loop with all of its delay at the last signal."""
        return Loop(self.a + self.b[:, :-1] @ self.c[:-1], self.b[:, -1:], self.c[-1:])

    def scaled(self) -> tuple[Loop, float]:
        """Return the loop in states of like size, and in a unit of time; with that in 1/s.

        All factors are powers of two, so it is the same loop to the last bit.
        """
        rates = np.abs(self.a) + np.abs(self.b) @ np.abs(self.c)
        _, (size, _) = matrix_balance(rates, permute=False, separate=True)
        slowest = np.abs(np.linalg.eigvals(self.undelayed())).min()
        unit = float(2.0 ** np.round(np.log2(slowest)))
        c = self.c * size
        share = 2.0 ** np.round(np.log2(np.abs(c).max(axis=1)))
        b = self.b / size[:, None] / unit * share
        return Loop(self.a * size / size[:, None] / unit, b, c / share[:, None]), unit


def is_stable(matrix: Array) -> bool:
    """Whether all eigenvalues of a matrix are to the left."""
    return bool(np.linalg.eigvals(matrix).real.max() < 0.0)


def seen_delay(loop: Loop) -> float:
    """Return the least delay [s] of all signals together at which a root is on the imaginary axis.

    Zero where the loop is unstable without a delay, infinite where none makes it so.
    """
    if not is_stable(loop.undelayed()):
        return 0.0
    (a, b, c), unit = loop.lumped().scaled()
    # |G(iw)| = 1 where iw is an eigenvalue of this matrix.
    roots = np.linalg.eigvals(np.block([[a, b @ b.T], [-c.T @ c, -a.T]]))
    crossing = (np.abs(roots.real) <= ON_AXIS * np.abs(roots)) & (roots.imag > 0.0)
    least = np.inf
    for omega in roots.imag[crossing]:
        gain = (c @ np.linalg.solve(1j * omega * np.eye(a.shape[0]) - a, b))[0, 0]
        least = min(least, float(np.angle(gain) % (2.0 * np.pi)) / omega)
    return float(least / unit)

"""Linear matrix inequalities for Drake's `MathematicalProgram`, solved with Clarabel.

An inequality is a function of a matrix variable and some numbers, linear in them, that returns a
symmetric matrix; its coefficients are found by asking it. The solution is only a proposal: whoever
uses it has to verify it, see `exact`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.solvers import ClarabelSolver, MathematicalProgram, SolverOptions

Array = NDArray[np.float64]
# Of P (n, n) and numbers (m,); positive definite where the inequality holds.
Inequality = Callable[[Array, Array], Array]


def propose(size: int, numbers: int, inequalities: Sequence[Inequality]) -> tuple[Array, Array]:
    """Return P (n, n), symmetric, and numbers (m,) for which inequalities are met by most.

    With the trace of P and the sum of the numbers 1, the least eigenvalue of all is the largest.

    Args:
        size: n.
        numbers: m; each is positive, which need not be said.
        inequalities: each linear in both.
    """
    upper = np.triu_indices(size)
    program = MathematicalProgram()
    unknown = program.NewContinuousVariables(upper[0].size + numbers + 1)
    margin = unknown[-1]
    units = np.eye(unknown.size - 1)

    def apart(x: Array) -> tuple[Array, Array]:
        p = np.zeros((size, size))
        p[upper] = x[: upper[0].size]
        return p + np.triu(p, 1).T, x[upper[0].size :]

    for inequality in inequalities:
        parts = [inequality(*apart(unit)) for unit in units]
        zero = np.zeros_like(parts[0])
        program.AddLinearMatrixInequalityConstraint(
            [zero, *(0.5 * (part + part.T) for part in parts), -np.eye(zero.shape[0])], unknown
        )
    total = np.concatenate([np.eye(size)[upper], np.ones(numbers)])
    program.AddLinearEqualityConstraint(total[None, :], np.ones(1), unknown[:-1])
    program.AddBoundingBoxConstraint(0.0, 1.0, unknown[upper[0].size : -1])
    program.AddLinearCost(-margin)
    result = ClarabelSolver().Solve(program, None, SolverOptions())
    return apart(result.GetSolution(unknown)[:-1])

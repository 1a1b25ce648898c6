"""What the paper reports about its swarms, each with how far from it is still the same."""

from __future__ import annotations

from typing import Final, NamedTuple

from scara_drake.experiments.inverse_kinematics.postures import NUMBERS


class Statement(NamedTuple):
    """What the paper says, and how far from it still counts as the same.

    Attributes:
        text: in our words.
        place: in the paper.
        paper: its values.
        unit: of the values.
        factor: a value may be so many times the paper's, or that part of it; 0 for a bound.
        bound: 1 where the values must not be below the paper's, -1 not above, 0 with a factor.
        names: of the values, where there are several.
        chance: whether it is a probability, whose powers of ten count.
    """

    text: str
    place: str
    paper: tuple[float, ...]
    unit: str
    factor: float = 0.0
    bound: tuple[int, ...] = ()
    names: tuple[str, ...] = ()
    chance: bool = False


POSTURES: Final = tuple(f"posture {number}" for number in NUMBERS)
ERRORS: Final = ("mm", "rad")
STATEMENTS: Final[dict[str, Statement]] = {
    "pso_iterations": Statement(
        "PSO takes 66 iterations, mean of the postures", "VI-A", (66,), "iterations", 1.1
    ),
    "dpso_iterations": Statement(
        "DPSO takes 52 iterations, mean of the postures", "VI-A", (52,), "iterations", 1.1
    ),
    "solved": Statement(
        "all eight solutions are inside the tolerances: not less likely than 5 %",
        "Table 8", (5,), "%", bound=(1,), chance=True,
    ),
    "pso_errors": Statement(
        "errors of PSO, median of the postures", "Table 8", (0.095, 0.00185), "", 3.0, names=ERRORS
    ),
    "dpso_errors": Statement(
        "errors of DPSO, median of the postures", "Table 8", (0.515, 0.0015), "", 3.0, names=ERRORS
    ),
    "times": Statement(
        "work of DPSO over PSO at each posture",
        "Table 8", (1.343, 1.381, 0.76, 0.786), "", 1.25, names=POSTURES,
    ),
    "second": Statement(
        "PSO-2 suffices in half of the runs or more at postures 3 and 4, in fewer at 1 and 2",
        "VI-A", (50, 50, 50, 50), "%", bound=(-1, -1, 1, 1), names=POSTURES,
    ),
    "damping": Statement(
        "PSO does not converge before (53): in 10 % of the runs or fewer",
        "VI-A", (10,), "%", bound=(-1,),
    ),
    "fewer": Statement("M < N in 90 % of the runs or more", "III-C", (90,), "%", bound=(1,)),
    "population": Statement(
        "a mean population of 80 along a trajectory", "VI-A", (80,), "particles", 1.1
    ),
    "path_iterations": Statement(
        "a mean of 55 iterations along a trajectory", "VI-A", (55,), "iterations", 1.1
    ),
    "path_work": Statement(
        "work of a point of the trajectory over that of a posture of Table 8",
        "Tables 8, 9", (2.89 / 50 / 0.256,), "", 1.5,
    ),
}  # fmt: skip

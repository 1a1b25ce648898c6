"""What the paper reports about its swarms, each with how far from it is still the same."""

from __future__ import annotations

from statistics import fmean, median
from typing import Final, NamedTuple

from scara_drake.experiments.inverse_kinematics.paths import POINTS
from scara_drake.experiments.inverse_kinematics.postures import NUMBERS

ITERATIONS: Final = {"PSO": 66, "DPSO": 52}  # mean of the postures, VI-A
# At each posture, Table 8.
TIMES: Final = {"PSO": (0.242, 0.21, 0.25, 0.28), "DPSO": (0.325, 0.29, 0.19, 0.22)}  # [s]
POSITION_ERRORS: Final = {"PSO": (0.14, 0.05, 0.04, 0.15), "DPSO": (0.45, 0.88, 0.58, 0.28)}  # [mm]
ROTATION_ERRORS: Final = {  # [rad]
    "PSO": (0.0013, 0.0023, 0.0022, 0.0015),
    "DPSO": (0.005, 0.0002, 0.0025, 0.0005),
}
PATH_PARTICLES, PATH_ITERATIONS = 80, 55  # means along a trajectory of POINTS points, VI-A
PATH_TIME: Final = 2.89  # of DPSO for it, Table 9 [s]


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


def _medians(swarm: str) -> tuple[float, ...]:
    return median(POSITION_ERRORS[swarm]), median(ROTATION_ERRORS[swarm])


# Time of DPSO over that of PSO.
WORK: Final = tuple(
    round(dual / single, 3) for single, dual in zip(TIMES["PSO"], TIMES["DPSO"], strict=True)
)
POSTURES: Final = tuple(f"posture {number}" for number in NUMBERS)
ERRORS: Final = ("mm", "rad")
STATEMENTS: Final[dict[str, Statement]] = {
    "pso_iterations": Statement(
        f"PSO takes {ITERATIONS['PSO']} iterations, mean of the postures",
        "VI-A", (ITERATIONS["PSO"],), "iterations", 1.1,
    ),
    "dpso_iterations": Statement(
        f"DPSO takes {ITERATIONS['DPSO']} iterations, mean of the postures",
        "VI-A", (ITERATIONS["DPSO"],), "iterations", 1.1,
    ),
    "solved": Statement(
        "all eight solutions are inside the tolerances: not less likely than 5 %",
        "Table 8", (5,), "%", bound=(1,), chance=True,
    ),
    "pso_errors": Statement(
        "errors of PSO, median of the postures", "Table 8", _medians("PSO"), "", 3.0, names=ERRORS
    ),
    "dpso_errors": Statement(
        "errors of DPSO, median of the postures", "Table 8", _medians("DPSO"), "", 3.0, names=ERRORS
    ),
    "times": Statement(
        "work of DPSO over PSO at each posture",
        "Table 8", WORK, "", 1.25, names=POSTURES,
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
        f"a mean population of {PATH_PARTICLES} along a trajectory",
        "VI-A", (PATH_PARTICLES,), "particles", 1.1,
    ),
    "path_iterations": Statement(
        f"a mean of {PATH_ITERATIONS} iterations along a trajectory",
        "VI-A", (PATH_ITERATIONS,), "iterations", 1.1,
    ),
    "path_work": Statement(
        "work of a point of the trajectory over that of a posture of Table 8",
        "Tables 8, 9", (PATH_TIME / POINTS / round(fmean(TIMES["DPSO"]), 3),), "", 1.5,
    ),
}  # fmt: skip

"""Ferrell (1965), Hannaford and Kim (1989): what a delay costs an operator who sees and feels.

Virtual operators do two pieces of work over a robot that is where it should be, see
`virtual_operator`. Their numbers are people's without a delay (`operator.policy`), the same for
all; none of them is fitted to what a delay does. That holds for the numbers and not for the rule of
who moves and waits: it is what Ferrell saw people do over a delay, so his law tests whether the
rest of the loop adds anything to a delay a move. To reach places, as Ferrell's operators did,
nothing is felt. To press with a force and hold it, in kind the contact tasks of Hannaford and Kim,
force comes back by wave variables, whose swinging is a part of what a delay costs here; their
shared compliance, a robot that yields at its wrist, is a spring in series with the wall. Their
delays went from 2 to 4096 ms, and of their results the laws alone are compared, no number.

Intervals are of 95 %, by the bootstrap over the seeds: all delays of a seed are drawn together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake.environment import Wall
from scara_drake.experiments.claim import Experiment
from scara_drake.experiments.literature.operators_claims import claims
from scara_drake.experiments.literature.virtual_operator import Outcome, work
from scara_drake.operator.policy import Continuous, MoveAndWait, Press, Reach

Array = NDArray[np.float64]

SEEDS: Final = 30
REACH_DELAYS: Final = (0.0, 0.5, 1.0, 2.0)  # [s], there and back, as all of them
PRESS_DELAYS: Final = (0.0, 0.128, 0.256, 0.512, 1.024)
FOLLOW_DELAYS: Final = (0.0, 0.256, 0.512)
TOLERANCES: Final = {"coarse": 0.008, "fine": 0.003}  # [m]
WALL: Final = Wall(stiffness=1e4, damping=100.0)  # Table 4
WRIST: Final = 200.0  # [N/m], of the robot that yields
WALLS: Final = {
    "stiff": WALL,
    "compliant": Wall(stiffness=1.0 / (1.0 / WRIST + 1.0 / WALL.stiffness), damping=100.0),
}
PLACES: Final = [[0.0, 0.0, 0.15], [0.0, 0.0, 0.0], [0.0, 0.0, 0.15], [0.0, 0.0, 0.0]]  # [m]
BEFORE: Final = [[0.0, -0.04, 0.0]]  # [m], a centimetre before the wall
PATIENCE: Final = 40.0  # [s], of who follows without a pause
UNITS: Final = {"seconds": "s", "moves": "1", "squared_force": "N^2 s", "peak_force": "N"}
NAMES: Final = {
    "seconds": "until the work was done",
    "moves": "moves that were begun",
    "squared_force": "integral of the squared force on the tool",
    "peak_force": "largest force on the tool",
}


def run(
    seed: int = 0,
    seeds: int = SEEDS,
    reach_delays: Sequence[float] = REACH_DELAYS,
    press_delays: Sequence[float] = PRESS_DELAYS,
) -> Experiment:
    """Let the operators work.

    Args:
        seed: of the first operator.
        seeds: operators of each kind.
        reach_delays: of the reaching, the first zero [s].
        press_delays: of the pressing, the first zero [s].
    """
    people = np.arange(seed, seed + seeds)
    parts: dict[str, xr.DataArray] = {}

    def over(
        name: str, kinds: Sequence[str], delays: Sequence[float], job: Callable[..., Outcome]
    ) -> None:
        done = np.array([[[job(k, d, p) for p in people] for d in delays] for k in kinds])
        coords = {f"{name}_kind": list(kinds), f"{name}_delay": list(delays), "person": people}
        for index, field in enumerate(Outcome._fields):
            attrs = {"units": UNITS[field], "long_name": f"{name}: {NAMES[field]}"}
            parts[f"{name}_{field}"] = xr.DataArray(
                done[..., index], coords, tuple(coords), attrs=attrs
            )

    def reach(kind: str, delay: float, person: int) -> Outcome:
        task = Reach(places=PLACES, tolerance=TOLERANCES[kind])
        return work(MoveAndWait(work=task), delay, int(person))

    def press(kind: str, delay: float, person: int) -> Outcome:
        return work(MoveAndWait(work=Press(places=BEFORE)), delay, int(person), WALLS[kind])

    def follow(kind: str, delay: float, person: int) -> Outcome:
        task = Reach(places=PLACES, tolerance=TOLERANCES[kind])
        return work(Continuous(work=task), delay, int(person), longest=PATIENCE)

    over("reach", list(TOLERANCES), reach_delays, reach)
    over("press", list(WALLS), press_delays, press)
    over("follow", ["coarse"], FOLLOW_DELAYS, follow)
    data = xr.Dataset(parts)
    for name in ("reach_delay", "press_delay", "follow_delay"):
        data[name].attrs.update(units="s", long_name="delay there and back")
    data.attrs["seed"] = seed
    return Experiment("Operators under delay", data, claims(data))

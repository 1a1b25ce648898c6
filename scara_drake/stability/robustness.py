"""A robustness map: tracking while the robot, the drives and the sensors are not ideal.

Each cell is a short run of a scenario with one variation and one controller, which knows nothing of
the variation. The runs are independent, so they go side by side.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from scara_drake import joints, metrics
from scara_drake.common import checks
from scara_drake.common.parallel import side_by_side
from scara_drake.control.controller import EFFORT_LIMIT
from scara_drake.recordings.labels import labelled
from scara_drake.scenario import load_scenario
from scara_drake.simulation.run import simulate

Array = NDArray[np.float64]
Overrides = Mapping[str, Any]

SETTLE = 1.0  # [s]: before it the drives take up the weight of the robot
LOST = 0.1  # [m, rad]: a joint further away than this does not follow
LIMITED = 0.2  # share of samples at a drive's limit: a loop that is lost bangs between both

CONTROLLERS: Final[dict[str, Overrides]] = {
    "ISMC": {"controller": "!IntegralSlidingMode {}"},
    "SMC": {"controller": "!SlidingMode {}"},
    "PID": {"controller": "!Pid {}"},
}


def _payload(mass: float, offset: float = 0.0) -> Overrides:
    return {"robot.payload_mass": mass, "robot.payload_offset": [offset, 0.0, 0.0]}


_ENCODER: Overrides = {"drives.encoder": {}}
_LAG: Overrides = {"drives.lag": {}}
_FRICTION: Overrides = {"drives.friction": {}}
VARIATIONS: Final[dict[str, Overrides]] = {
    "nominal": {},
    "payload 10 kg": _payload(10.0),
    "payload 25 kg": _payload(25.0),
    "payload 25 kg, 0.2 m beside": _payload(25.0, 0.2),
    "links x 0.5": {"robot.mass_scale": 0.5},
    "links x 0.75": {"robot.mass_scale": 0.75},
    "links x 1.5": {"robot.mass_scale": 1.5},
    "links x 1.8": {"robot.mass_scale": 1.8},
    "encoders": _ENCODER,
    "encoders, 15 bit": {"drives.encoder.resolution": [1e-5] + [2.0 * np.pi / 2**15] * 5},
    "encoders, noise 2 µm, µrad": {"drives.encoder.noise": 2e-6},
    "encoders, noise 10 µm, µrad": {"drives.encoder.noise": 1e-5},
    "encoders, velocity 200 rad/s": {"drives.encoder.velocity_bandwidth": 200.0},
    "lag 0.3 ms": _LAG,
    "lag 1 ms": {"drives.lag.time_constant": 1e-3},
    "lag 3 ms": {"drives.lag.time_constant": 3e-3},
    "lag 10 ms": {"drives.lag.time_constant": 1e-2},
    "friction": _FRICTION,
    "friction x 3": {"drives.friction.coulomb": [900.0, 480.0, 180.0, 180.0, 30.0, 6.0]},
    "all drives": {**_ENCODER, **_LAG, **_FRICTION},
    "all drives, 25 kg, links x 1.5": {
        **_ENCODER, **_LAG, **_FRICTION, **_payload(25.0), "robot.mass_scale": 1.5,
    },
}  # fmt: skip


def robustness_map(
    variations: Mapping[str, Overrides] = VARIATIONS,
    controllers: Mapping[str, Overrides] = CONTROLLERS,
    scenario: str = "joint_sine",
    duration: float = 3.0,
    jobs: int | None = None,
) -> xr.Dataset:
    """Run every variation with every controller.

    A cell is stable where the run ends, no joint is further than 0.1 m or rad from its reference
    after the first second, and no drive is at its limit for 20 % of the time. Where a run
    breaks down, its numbers are NaN.

    Args:
        variations: overrides of the scenario by their name.
        controllers: overrides that choose a controller, by its name.
        scenario: name or path.
        duration: of each run [s].
        jobs: how many runs side by side; all cores if None.

    Returns:
        rmse, peak, chatter and limited (variation, controller, joint), stable (variation,
        controller); all after the first second. `chatter` is the mean change of the effort from
        sample to sample.

    Raises:
        ValueError: a wrong override, or a duration of a second or less.
    """
    checks.number("duration", duration, SETTLE + 0.1)
    cells = [
        (scenario, {**varied, **chosen}, duration)
        for varied, chosen in product(variations.values(), controllers.values())
    ]
    for name, overrides, _ in cells:
        load_scenario(name, overrides)  # refuses before anything runs
    results = list(side_by_side(_run, cells, jobs))
    values = np.array(results).reshape(len(variations), len(controllers), 4, 6)
    coordinates = {"variation": list(variations), "controller": list(controllers)}
    attributes = {"scenario": str(scenario), "duration": duration}
    return _labelled(values, coordinates).assign_attrs(attributes)


def _labelled(values: Array, coordinates: dict[str, list[str]]) -> xr.Dataset:
    """Label rmse, peak, chatter and limited (variation, controller, 4, joint)."""
    rmse, peak, chatter, limited = np.moveaxis(values, 2, 0)
    follows = (peak < LOST) & (limited < LIMITED)  # NaN does not
    dims = ("variation", "controller", "joint")
    positions, efforts = "m for d1, rad for the others", "N for d1, N m for the others"
    return xr.Dataset(
        {
            "rmse": labelled(dims, rmse, positions, "root mean square of the tracking error"),
            "peak": labelled(dims, peak, positions, "largest tracking error"),
            "chatter": labelled(dims, chatter, efforts, "mean change of the effort in a tick"),
            "limited": labelled(dims, limited, "1", "share of samples with the drive at its limit"),
            "stable": labelled(dims[:2], follows.all(axis=2), "1", "whether all joints follow"),
        },
        coords={**coordinates, "joint": list(joints.JOINT_NAMES)},
    )


def _run(cell: tuple[str, Overrides, float]) -> Array:
    """Return rmse, peak, chatter and limited (4, 6) of one run; NaN where it breaks down."""
    name, overrides, duration = cell
    scenario = load_scenario(name, dict(overrides))
    try:
        recording = simulate(scenario, duration=duration)
    except RuntimeError:  # a state that is not finite stops the plant or the controller
        return np.full((4, 6), np.nan)
    late = recording.sel(time=slice(SETTLE, None))
    error, tau = metrics.tracking_error(late), late.tau_applied
    if "saturation" in late:
        limited = (late.saturation >= EFFORT_LIMIT).mean("time")
    else:  # a controller of the user's own
        limited = (late.tau_applied != late.tau_commanded).mean("time")
    rows = (metrics.rmse(error), metrics.peak(error), metrics.chatter(tau), limited)
    return np.stack([row.values for row in rows])

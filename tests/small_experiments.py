"""The experiments at a size for tests, each run once in a process."""

from functools import cache
from typing import Any

from scara_drake.experiments import EXPERIMENTS, Experiment
from scara_drake.stability.robustness import VARIATIONS

SMALL: dict[str, dict[str, Any]] = {
    "table_5": {"orders": ("xyz, turning axes", "xzy, turning axes"), "order_starts": 8},
    "table_6": {"starts": 6},
    "table_7": {"draws": 3, "paths": 2},
    "table_8": {"draws": 6},
    "figures_8_9": {"draws": 6},
    "table_9": {"paths": 3},
    "figures_10_11": {"paths": 3},
    "figures_12_15": {"paths": 4},
    "orientation_drift": {"paths": 6},
    "figure_22": {"duration": 1.8},
    "figures_20_27": {"duration": 4.0},
    "figure_28": {"duration": 19.0},
    "equivalent_control": {"duration": 1.5},
    "figures_29_30": {"duration": 5.0},
    "stability": {
        "postures": 4,
        "every": 400,
        "duration": 1.2,
        "variations": {
            name: VARIATIONS[name] for name in ("nominal", "payload 25 kg", "lag 10 ms")
        },
    },
    "couplings": {
        "couplings": ("direct", "TDPA"),
        "presets": ("5 ms",),
        "times": (0.1, 0.2, 0.4, 0.5),
        "duration": 0.7,
        "sweep_duration": 0.0,
    },
    "quantised_wall": {"walls": ("viscous", "counts"), "users": 2},
    "devices": {
        "devices": ("own", "touch"),
        "couplings": ("direct", "TDPA"),
        "presets": ("none",),
    },
    "delay_against_loss": {
        "couplings": ("wave variables", "waves without drift term", "TDPA"),
        "delays": (0.008, 0.272),
        "losses": (0.0, 0.25),
        "seeds": 1,
    },
    "certificates": {
        "cases": {
            "direct, force x 0.03": "!ScaledForce {force_scale: 0.03}",
            "waves": "!WaveVariables {}",
        },
        "longest": 0,
    },
    "standard_cases": {"delays": (0.1,)},
    "delayed_wall": {"delays": (0.0, 0.002), "duration": 6.0},
    "dead_band": {"bands": (-1.0, 0.1, 0.2, 0.4), "duration": 10.0},
    "operators_under_delay": {
        "seeds": 3,
        "reach_delays": (0.0, 0.5),
        "press_delays": (0.0, 0.256, 0.512),
    },
    "perturbation_observer": {"duration": 3.0, "contact_duration": 19.0},
}


@cache
def small(name: str) -> Experiment:
    """Return an experiment of that size, with the seed 0."""
    return EXPERIMENTS[name](seed=0, **SMALL.get(name, {}))

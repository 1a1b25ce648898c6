"""A study of a few short runs, and how often each of its runs was done."""

from __future__ import annotations

from typing import Any

from scara_drake.studies.parameters import Range, Values
from scara_drake.studies.study import Study


def small_study(**changed: Any) -> Study:
    """Twelve runs of 50 ms: payload, controller and two seeds."""
    fields: dict[str, Any] = {
        "name": "small",
        "scenario": "joint_sine",
        "duration": 0.05,
        "parameters": [
            Range(["robot.payload_mass"], "payload", 0.0, 20.0, 3),
            Values(["controller"], "controller", ["!Pid {}", "!IntegralSlidingMode {}"]),
        ],
        "repeats": 2,
        "metrics": ["tool_error_rms", "energy", "followed"],
    }
    return Study(**fields | changed)

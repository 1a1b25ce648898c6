"""What a recording says of itself: its attributes, beside its variables."""

from __future__ import annotations

from typing import Final

ATTRIBUTES: Final[dict[str, str]] = {
    "scenario_name": "name of the scenario",
    "scenario": "the whole scenario as YAML text: a file of it runs again",
    "seed": "of all random draws",
    "versions": "of Python and of the packages that made it, JSON",
    "engine": "what ran the Diagram: `drake` or `compiled`",
    "engine_reason": "why it was not the other, where there is a reason",
    "device": "the operator's device, or the trace in its place",
    "packet_numbers_up": "how many numbers are in a packet up, with all that the receiver gets",
    "packet_numbers_down": "the same of a packet down",
    "score": "of its task, 0 to 100, see [training](training.md)",
    "score_table": "its criteria with values, bounds and points, JSON",
    "ended_by": "what ended the run: `duration`, an interrupt, an error, `cut off`, damage",
    "ended_at": "when it ended [s]",
    "ticks": "of a run in real time: how many there were",
    "late_ticks": "of these, how many were done more than 1 ms behind the clock",
    "lateness_p99": "99 % of the ticks were less behind the clock [s]; below zero, it waited",
    "lateness_p999": "the same of 99.9 % [s]",
    "lateness_worst": "the largest [s]",
    "overruns": "how often the real-time factor was below 0.9 for a second",
    "clock_restarts": "how often the pacing began afresh, 0.2 s behind",
    "time_given_up": "how much time was given up in these [s]",
    "pictures_dropped": "how many pictures of the scene gave way, as the run was behind",
    "first_posture_method": "who found the posture that the arm started from, if one was searched",
    "first_posture_evaluations": "in how many evaluations",
    "first_posture_seconds": "in which time [s]; it differs from run to run",
    "Conventions": "of the metadata: CF",
    "format_version": "of the files; those of before are read too",
    "comment": "on units and frames",
}

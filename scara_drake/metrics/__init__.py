"""Figures of merit of recordings, and the verdict on them; `bilateral` for a hand that feels."""

from scara_drake.metrics.command import command_error, status_shares
from scara_drake.metrics.contact import yielding_joints
from scara_drake.metrics.judgement import Verdict, verdict
from scara_drake.metrics.limits import beyond_range, saturated_share, speed_ratio
from scara_drake.metrics.links import Traffic, traffic
from scara_drake.metrics.policy import completion_time, move_count
from scara_drake.metrics.scores import Criterion, Score, score
from scara_drake.metrics.tracking import (
    Value,
    chatter,
    contact_force,
    energy,
    iae,
    ise,
    itae,
    lag,
    outside_layer,
    overshoot,
    peak,
    percentile95,
    rise_time,
    rmse,
    settling_time,
    steady_state,
    tool_error,
    total_variation,
    tracking_error,
    work,
)

__all__ = [
    "Criterion",
    "Score",
    "Traffic",
    "Value",
    "Verdict",
    "beyond_range",
    "chatter",
    "command_error",
    "completion_time",
    "contact_force",
    "energy",
    "iae",
    "ise",
    "itae",
    "lag",
    "move_count",
    "outside_layer",
    "overshoot",
    "peak",
    "percentile95",
    "rise_time",
    "rmse",
    "saturated_share",
    "score",
    "settling_time",
    "speed_ratio",
    "status_shares",
    "steady_state",
    "tool_error",
    "total_variation",
    "tracking_error",
    "traffic",
    "verdict",
    "work",
    "yielding_joints",
]

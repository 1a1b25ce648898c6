"""Experiments: the paper's tables and figures, and what others found; each a file and a line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from scara_drake.experiments import stated_numbers
from scara_drake.experiments.claim import (
    IN_KIND,
    NOT_COMPARABLE,
    NOT_REPRODUCED,
    REPRODUCED,
    VERDICTS,
    Claim,
    Criterion,
    Experiment,
)
from scara_drake.experiments.control import (
    equivalent_control,
    figures_16_17,
    figures_18_19,
    figures_29_30,
    perturbation_observer,
    stability,
    table_10,
    windup,
)
from scara_drake.experiments.inverse_kinematics import (
    figures_8_9,
    figures_10_11,
    figures_12_15,
    orientation_drift,
    table_5,
    table_6,
    table_7,
    table_8,
    table_9,
)
from scara_drake.experiments.literature import (
    certificates,
    dead_band,
    delay_against_loss,
    delayed_wall,
    displayed_impedance,
    operators_under_delay,
    quantised_wall,
    standard_cases,
)
from scara_drake.experiments.teleoperation import (
    couplings,
    devices,
    figure_22,
    figure_28,
    figures_20_27,
)

EXPERIMENTS: Final[dict[str, Callable[..., Experiment]]] = {
    "table_1": stated_numbers.table_1,
    "table_2": stated_numbers.table_2,
    "table_3": stated_numbers.table_3,
    "table_4": stated_numbers.table_4,
    "table_5": table_5.run,
    "table_6": table_6.run,
    "table_7": table_7.run,
    "table_8": table_8.run,
    "figures_8_9": figures_8_9.run,
    "table_9": table_9.run,
    "figures_10_11": figures_10_11.run,
    "figures_12_15": figures_12_15.run,
    "orientation_drift": orientation_drift.run,
    "table_10": table_10.run,
    "table_11": stated_numbers.table_11,
    "table_12": stated_numbers.table_12,
    "equivalent_control": equivalent_control.run,
    "figures_16_17": figures_16_17.run,
    "figures_18_19": figures_18_19.run,
    "figures_20_27": figures_20_27.run,
    "figure_22": figure_22.run,
    "figure_28": figure_28.run,
    "figures_29_30": figures_29_30.run,
    "windup": windup.run,
    "perturbation_observer": perturbation_observer.run,
    "couplings": couplings.run,
    "devices": devices.run,
    "quantised_wall": quantised_wall.run,
    "displayed_impedance": displayed_impedance.run,
    "stability": stability.run,
    "delay_against_loss": delay_against_loss.run,
    "delayed_wall": delayed_wall.run,
    "dead_band": dead_band.run,
    "certificates": certificates.run,
    "standard_cases": standard_cases.run,
    "operators_under_delay": operators_under_delay.run,
}

__all__ = [
    "EXPERIMENTS",
    "IN_KIND",
    "NOT_COMPARABLE",
    "NOT_REPRODUCED",
    "REPRODUCED",
    "VERDICTS",
    "Claim",
    "Criterion",
    "Experiment",
]

"""The kernels of a scenario, compiled before it runs."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import Any

from pydrake.systems.analysis import Simulator

from scara_drake.diagram import make_diagram
from scara_drake.scenario import Scenario


def compile_kernels(scenario: Scenario) -> None:
    """Run two ticks of a scenario, so that its kernels are compiled; its device is left alone.

    Raises:
        ValueError: the scenario is not valid, or its first tool command cannot be reached.
    """
    operator: Any = scenario.operator
    if getattr(operator, "is_live", False):
        recorded = replace(operator, device="trace", trace=type(operator)().trace)
        scenario = replace(scenario, operator=recorded)
    before = logging.root.manager.disable
    logging.disable(logging.INFO)  # who commands here is nobody's business
    try:
        Simulator(make_diagram(scenario)).AdvanceTo(2.5 * scenario.time_step)
    finally:
        logging.disable(before)

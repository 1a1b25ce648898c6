"""The kernels of a scenario, compiled before it runs."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import Any, Final

from pydrake.systems.analysis import Simulator

from scara_drake.diagram import make_diagram
from scara_drake.operator.devices import ScriptedDevice, at_rest
from scara_drake.scenario import Scenario

# In which every block has been updated, also those of the device and of its motors [s].
LONG_ENOUGH: Final = 0.11


def compile_kernels(scenario: Scenario) -> None:
    """Run some ticks of a scenario, so that its kernels are compiled; its device is left alone.

    In the place of a live device is one that nobody touches, so that what reads it is compiled too.

    Raises:
        ValueError: the scenario is not valid, or its first tool command cannot be reached.
    """
    operator: Any = scenario.operator
    if getattr(operator, "is_live", False):
        untouched = replace(operator)
        untouched.lend(ScriptedDevice([(0.0, at_rest(0.0))]))
        scenario = replace(scenario, operator=untouched)
    before = logging.root.manager.disable
    logging.disable(logging.INFO)  # who commands here is nobody's business
    try:
        Simulator(make_diagram(scenario)).AdvanceTo(LONG_ENOUGH)
    finally:
        logging.disable(before)

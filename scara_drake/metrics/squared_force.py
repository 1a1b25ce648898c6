"""Sum of squared forces: how hard a task was done, light and brief contacts counting little.

Hannaford and Kim ("Force reflection, shared control, and time delay in telemanipulation", JPL,
1989) judged teleoperated tasks by their time and by this sum. Times the period, as here, it does
not grow with the rate of the samples.
"""

from __future__ import annotations

import numpy as np
import xarray as xr


def squared_force(recording: xr.Dataset, force: str = "f_env_on_tool_W") -> float:
    """Integral of the squared size of a force over the time [N² s]; over the contact, at the tool.

    Args:
        recording: of a run.
        force: the variable (time, axis) [N]; where it is missing it counts as zero.
    """
    squares = (recording[force].fillna(0.0) ** 2).sum("axis")
    return float(np.trapezoid(squares.values, recording.time.values))

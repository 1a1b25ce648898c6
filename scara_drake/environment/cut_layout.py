"""What the kernels of a cut read."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scara_drake.common.layout import REST, Layout

Array = NDArray[np.float64]


class Cut(NamedTuple):
    """A pipe and the blade that cuts it.

    Attributes:
        p_WS: middle of the pipe (3,) [m].
        R_WS: its frame (3, 3), z along the axis.
        inner: radius [m].
        outer: radius [m].
        half_length: [m].
        energy: u [J/m³].
        around: cells, by angle.
        through: cells, by depth.
        radius: of the blade [m].
        kerf: w [m].
        clearance: to each side [m].
        speed: v_0 [m/s].
        turn: 1 or -1, about y of the tool.
        stall_force: F_s [N].
        stalled_below: share of v_0.
        feed_ratio: r.
        stiffness: k [N/m²].
        damping: d [s/m].
        side_stiffness: K_s [N/m].
        side_damping: B_s [N s/m].
        friction: mu.
        circle: cosine and sine of each angle of the cells (2 around,).
    """

    p_WS: Array
    R_WS: Array
    inner: float
    outer: float
    half_length: float
    energy: float
    around: float
    through: float
    radius: float
    kerf: float
    clearance: float
    speed: float
    turn: float
    stall_force: float
    stalled_below: float
    feed_ratio: float
    stiffness: float
    damping: float
    side_stiffness: float
    side_damping: float
    friction: float
    circle: Array


CUT = Layout(Cut, p_WS=3, R_WS=(3, 3), circle=REST)
cut_of = CUT.reader()

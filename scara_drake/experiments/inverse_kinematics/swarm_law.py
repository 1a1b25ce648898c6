"""What Table 7 may have held, and the readings of the text that a swarm follows."""

from __future__ import annotations

from typing import NamedTuple


class Coefficients(NamedTuple):
    """What Table 7 may have held.

    Attributes:
        inertia: omega of (18) and (24).
        damping: omega_d of (53).
        personal: c1.
        social: c2.
        speed: v_max, as a share of the joint's range; with a literal rand, its bound.
        after: iterations that the last swarm runs on once it is inside the tolerances.
        patience: iterations that PSO-2 is given before the single swarm takes over.
    """

    inertia: float
    damping: float
    personal: float
    social: float
    speed: float
    after: int
    patience: int


class Law(NamedTuple):
    """One reading of the text.

    Attributes:
        literal: rand in [-v_max, v_max] and no other bound; else in [0, 1), the speed bounded.
        millimetres: |P_d - P| of (25) in mm, else in m.
        angles: |O_d - O| as the difference of roll, pitch and yaw, else the angle of the rotation.
        one_turn: the first draw within ±pi, else in the whole range.
        at_once: a particle that finds a better place leads the next one already, else the next
            iteration.
        particles: N.
    """

    literal: bool
    millimetres: bool
    angles: bool
    one_turn: bool
    at_once: bool
    particles: int

r"""The laws by which a surface pushes back, as kernels.

A surface is a signed distance with its gradient, which is the normal n out of it. With the depth d
below it and its rate :math:`\dot d = n \cdot (v_{\text{surface}} - v_{\text{tool}})`, it pushes the
tool along n with the impedance of equation (52) of the paper, made unilateral,

.. math::

    f = \max(0,\; K d + b(d)\,B \dot d), \quad b(d) = \min(d / \text{blend},\, 1)
    \quad \text{where } d > 0, \text{ else } f = 0

or with the law of Hunt and Crossley (1975), whose damping grows with the depth by itself:

.. math::

    f = K d^n \max(0,\; 1 + \tfrac{3}{2}\,\alpha\,\dot d)

The raw equation (52) steps by B d' at touch and pulls the tool back on a fast retreat. The blend b
lets the damping grow over the first millimetre, so the force starts at zero; the clamp never pulls.
Of either law (f - K dⁿ) d' >= 0, so a surface at rest never gives energy in continuous time. Held
over a period, the spring alone gives K/2 sum (Δd)², half the stiffness times the squared steps of
the depth: of K d² / 2, at most the share 2 v T / d of a press to the depth d at the speed v. The
damping takes b B / T times the same sum, so it makes up for it where b B > K T / 2: with 100 N s/m,
10 kN/m and 1 ms, beyond a twentieth of the blend.

A law is a kernel of a surface, the depth [m] and its rate [m/s], and a line in `LAWS`.
"""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common.choose import chooser
from scara_drake.common.layout import Layout

Array = NDArray[np.float64]


class SurfaceRow(NamedTuple):
    """A surface in a kernel.

    Attributes:
        kind: number of its class in the table of surfaces.
        law: number of its law in `LAWS`.
        p_WS: where its frame S is without its motion (3,) [m].
        R_WS: how that frame is turned (3, 3).
        half: half its lengths (3,) [m], as its kind has them.
        edge: radius of its edges, within the sharp shape [m].
        stiffness: K.
        damping: B.
        blend: see the module [m].
        exponent: n.
        alpha: [s/m].
        direction: of its motion in W (3,).
        speed: along the direction [m/s].
        amplitude: of a sine along the direction [m].
        omega: of the sine [rad/s].
        phase: of the sine [rad].
    """

    kind: float
    law: float
    p_WS: Array
    R_WS: Array
    half: Array
    edge: float
    stiffness: float
    damping: float
    blend: float
    exponent: float
    alpha: float
    direction: Array
    speed: float
    amplitude: float
    omega: float
    phase: float


SURFACE = Layout(SurfaceRow, p_WS=3, R_WS=(3, 3), half=3, direction=3)
surface_of = SURFACE.reader()


@njit(cache=True)
def course_at(s: SurfaceRow, t: float) -> tuple[float, float]:
    """Way [m] and speed [m/s] of a surface along its direction, t [s] after the start."""
    angle = s.omega * t + s.phase
    offset = s.speed * t + s.amplitude * np.sin(angle)
    speed = s.speed + s.amplitude * s.omega * np.cos(angle)
    return offset, speed


@njit(cache=True)
def impedance(s: SurfaceRow, depth: float, rate: float) -> float:
    """Force [N] of equation (52), blended in and never pulling."""
    damping = s.damping * min(depth / s.blend, 1.0)
    return max(s.stiffness * depth + damping * rate, 0.0)


@njit(cache=True)
def hunt_crossley(s: SurfaceRow, depth: float, rate: float) -> float:
    """Force [N] of Hunt and Crossley."""
    spring = s.stiffness * depth**s.exponent
    return spring * max(1.0 + 1.5 * s.alpha * rate, 0.0)


@njit(cache=True)
def elsewhere(s: SurfaceRow, depth: float, rate: float) -> float:
    """No force: the plant's own contact has it."""
    return 0.0


LAWS: Final[dict[str, Callable[[SurfaceRow, float, float], float]]] = {
    "impedance": impedance,
    "hunt_crossley": hunt_crossley,
    "drake": elsewhere,
}
NUMBERS: Final = {name: number for number, name in enumerate(LAWS)}
DRAKE: Final = NUMBERS["drake"]
force_by: Any = chooser(list(LAWS.values()))


@njit(cache=True)
def normal_force(surface: Array, depth: float, rate: float) -> float:
    """Force [N] of a surface, a row of `SURFACE`, at a depth [m] that grows with a rate [m/s]."""
    if depth <= 0.0:
        return 0.0
    s = surface_of(surface)
    return force_by(s.law, s, depth, rate)

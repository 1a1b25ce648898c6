r"""The impedance that a coupling displays over a constant delay: closed forms.

An impedance is force over velocity at the frequency of :math:`s = j \omega`. The displayed one is
that of the force which the coupling has at the device; the device itself is not in it. A tool in
firm contact is

.. math::

    Z_t = M s + D + Z_w, \quad Z_w = B + K / s

with the virtual mass M and its contact damping D of `Coupling`. With the delay T there and back of
the channel, the period h of the ticks and :math:`z = e^{s h}`, the hand is shown

.. math::

    \text{wave variables} &: \quad b\,\frac{1 - R z^{-1/2}}{z + R z^{-1}}, \quad
        R = \frac{b - Z_e}{b + Z_e}\,e^{-s (T + 4 h)}, \quad
        \frac{1}{Z_e} = \frac{1}{B_c + K_c / s} + \frac{1}{Z_t} \\
    \text{P+d} &: \quad z^{-1} \left(B + \frac{K}{s}
        \left(1 - \frac{K / s}{Z_t + B + K / s}\,e^{-s (T + 4 h)}\right)\right) \\
    \text{position up, force down} &: \quad e^{-s (T + T_{\text{own}})}\,Z_w \\
    \text{model-mediated} &: \quad z^{-1} Z_w

The first, with h = 0, is :math:`b\,(Z_e + b \tanh s T / 2) / (b + Z_e \tanh s T / 2)` of Hirche and
Buss (Human perceived transparency with time delay, 2007): at low frequency a wall k is felt as
:math:`b k / (b + k T / 2)`, and free space as a mass :math:`b T / 2`. What the ticks add: a wave is
made of the velocity of half a tick ago and the force of a tick ago, crosses a block in each of four
ticks, and the force is shown in the next one. The third takes the slave's lag as a delay,
`own_latency` of the wiring without the tick in which the device moves.

These are linear, per axis, so in the master's units all are times `impedance_scale`. TDPA has no
such form: what it lets through hangs on the energy that has come in, so the same motion meets
another force a second time. Nor has a delay that varies: a sine comes back as several. Where it
varies slowly, the mean of a figure over the delays is what such a form can say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from scara_drake.coupling.direct import Direct, ScaledForce
from scara_drake.coupling.ends import Coupling
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.environment.wall import Wall

Complex = NDArray[np.complex128]

BLOCKS = 4  # that a signal crosses there and back: each end and each link has it for a tick
SLOW = 1e-6  # [Hz], where only springs are left of an impedance


class Way(NamedTuple):
    """The way there and back.

    Attributes:
        delay: of the channel [s].
        period: of the ticks; 0 for ends without any [s].
        own: delay of a loop that follows positions, its ticks included [s].
    """

    delay: float
    period: float = 0.0
    own: float = 0.0

    def crossed(self, s: ArrayLike) -> Complex:
        """What a signal is when it comes back."""
        return np.exp(-np.asarray(s) * (self.delay + BLOCKS * self.period))

    def late(self, s: ArrayLike, ticks: float) -> Complex:
        """What a signal is so many ticks later."""
        return np.exp(-np.asarray(s) * ticks * self.period)


def spring_and_damper(s: ArrayLike, stiffness: float, damping: float) -> Complex:
    """Impedance B + K / s [N s/m] of a spring [N/m] beside a damper [N s/m]."""
    return np.asarray(damping + stiffness / np.asarray(s, dtype=np.complex128))


def in_series(one: ArrayLike, other: ArrayLike) -> Complex:
    """Impedance of two that have the same force and share the motion."""
    one, other = np.asarray(one), np.asarray(other)
    return np.asarray(one * other / (one + other))


def through_waves(s: ArrayLike, end: ArrayLike, impedance: float, way: Way) -> Complex:
    """Impedance of an end [N s/m] as it is felt through waves of the impedance b [N s/m]."""
    end = np.asarray(end)
    back = (impedance - end) / (impedance + end) * way.crossed(s)
    lost = 1.0 - back * way.late(s, 0.5)
    return np.asarray(impedance * lost / (way.late(s, -1.0) + back * way.late(s, 1.0)))


def through_springs(
    s: ArrayLike, end: ArrayLike, stiffness: float, damping: float, way: Way
) -> Complex:
    """Impedance of an end [N s/m] as it is felt through the springs and dampers of P+d."""
    spring = spring_and_damper(s, stiffness, 0.0)
    moved = spring / (np.asarray(end) + damping + spring) * way.crossed(s)
    return np.asarray((damping + spring * (1.0 - moved)) * way.late(s, 1.0))


def tool(s: ArrayLike, coupling: Coupling, wall: ArrayLike) -> Complex:
    """Impedance of the virtual tool [N s/m] in firm contact with a wall of that impedance."""
    mass = coupling.virtual_mass * np.asarray(s)
    return np.asarray(mass + coupling.contact_damping + np.asarray(wall))


def _waves(coupling: WaveVariables, s: Complex, wall: Complex, way: Way) -> Complex:
    spring = spring_and_damper(s, coupling.stiffness, coupling.damping)
    end = in_series(spring, tool(s, coupling, wall))
    return through_waves(s, end, coupling.impedance, way)


def _springs(coupling: PositionDamping, s: Complex, wall: Complex, way: Way) -> Complex:
    end = tool(s, coupling, wall)
    return through_springs(s, end, coupling.stiffness, coupling.damping, way)


def _force(coupling: Direct, s: Complex, wall: Complex, way: Way) -> Complex:
    return np.asarray(wall * np.exp(-s * (way.delay + way.own)))


def _model(coupling: ModelMediated, s: Complex, wall: Complex, way: Way) -> Complex:
    return np.asarray(wall * way.late(s, 1.0))


FORMS: Final[dict[type[Coupling], Callable[[Any, Complex, Complex, Way], Complex]]] = {
    WaveVariables: _waves,
    PositionDamping: _springs,
    Direct: _force,
    ScaledForce: _force,
    ModelMediated: _model,
}


def has_closed_form(coupling: Coupling) -> bool:
    """Whether the kind of a coupling is in `FORMS`."""
    return type(coupling) in FORMS


def displayed_impedance(
    coupling: Coupling, wall: Wall, frequency: xr.DataArray, way: Way
) -> xr.DataArray:
    """Return what a coupling displays of a wall (frequency) [N s/m], complex.

    Args:
        coupling: of a kind in `FORMS`.
        wall: its stiffness and damping, see `pressed`.
        frequency: [Hz].
        way: there and back.

    Raises:
        ValueError: the kind has no closed form, see the module.
    """
    form = FORMS.get(type(coupling))
    if form is None:
        kinds = ", ".join(f"!{kind.__name__}" for kind in FORMS)
        raise ValueError(f"coupling: !{type(coupling).__name__}, allowed {kinds}")
    s = 2j * np.pi * frequency.values
    shown = form(coupling, s, spring_and_damper(s, wall.stiffness, wall.damping), way)
    return xr.DataArray(
        coupling.impedance_scale * shown,
        coords={"frequency": frequency},
        dims="frequency",
        attrs={"units": "N s/m"},
    )


def pressed(coupling: Coupling, wall: Wall, hand_stiffness: float, depth: float, way: Way) -> Wall:
    """Return a wall with the damping that it has where a hand's press rests.

    Over the first of its depth the damping of a wall grows, see `environment/law.py`.

    Args:
        coupling: of a kind in `FORMS`.
        wall: that is pressed.
        hand_stiffness: [N/m].
        depth: to which the hand wants the device beyond the surface [m].
        way: there and back.
    """
    slow = xr.DataArray([SLOW], dims="frequency")
    shown = displayed_impedance(coupling, wall, slow, way).values[0]
    stiffness = float((2j * np.pi * SLOW * shown).real)
    force = depth * hand_stiffness * stiffness / (hand_stiffness + stiffness)
    share = force / coupling.force_scale / wall.stiffness / wall.blend
    return replace(wall, damping=wall.damping * min(share, 1.0))

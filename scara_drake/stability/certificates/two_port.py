r"""Llewellyn: is a coupling stable between any two passive ends? Its two-ports, by frequency.

A two-port, with its forces and with its velocities into it, as impedances or as hybrid parameters
p, is absolutely stable where the real parts of :math:`p_{11}` and :math:`p_{22}` are nowhere
negative and

.. math::

    \eta = \frac{2\,\Re p_{11} \Re p_{22} - \Re(p_{12} p_{21})}{|p_{12} p_{21}|} \ge 1

(Llewellyn 1952; Adams and Hannaford 1999 for haptics). It is for constant delays, and looked at on
a grid: evidence between its points, not a proof.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scara_drake.common.bisection import bracket
from scara_drake.coupling.direct import Direct
from scara_drake.coupling.ends import Coupling
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.operator.master import Master

Array = NDArray[np.float64]

OMEGA: Final = np.geomspace(1e-3, 1e4, 4000)  # [rad/s]
ROUNDING = 1e-9
LONGEST, CLOSE = 10.0, 1e-4  # [s], and relative, of a delay that is looked for
LEAST = 1e-6  # [s], below which it is none


class TwoPort(NamedTuple):
    """Parameters at each frequency, complex."""

    p11: Any
    p12: Any
    p21: Any
    p22: Any


def llewellyn(p11: ArrayLike, p12: ArrayLike, p21: ArrayLike, p22: ArrayLike) -> Array:
    """Return eta of Llewellyn, at each frequency.

    Args:
        p11: complex, like the others; all impedances, or all hybrid parameters.
        p12: from the second port to the first.
        p21: from the first port to the second.
        p22: of the second port.
    """
    crossing = np.multiply(p12, p21)
    losses = 2.0 * np.real(p11) * np.real(p22)
    return np.asarray((losses - np.real(crossing)) / np.abs(crossing))


def is_absolutely_stable(ports: TwoPort) -> bool:
    """Whether a two-port is stable between any passive ends, at the frequencies that it has."""
    passive = min(np.real(ports.p11).min(), np.real(ports.p22).min())
    return bool(passive >= -ROUNDING and llewellyn(*ports).min() >= 1.0 - ROUNDING)


def two_port(
    coupling: Coupling, master: Master, bandwidth: float, delay: float, omega: ArrayLike = OMEGA
) -> TwoPort | None:
    """Return the two-port from the hand to the tool in the master's units; None of other kinds.

    Args:
        coupling: of `Direct`, `ScaledForce`, `PositionDamping` or `WaveVariables`.
        master: whose device is in it.
        bandwidth: of the limiter, which is in it where positions are commanded [1/s].
        delay: of each direction [s].
        omega: angular frequencies [rad/s].
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    for kind, make in _PORTS.items():
        if isinstance(coupling, kind):
            device = master.hardware()
            return make(coupling, device.mass * s + device.viscous, bandwidth, delay, s)
    return None


def absolute_delay(coupling: Coupling, master: Master, bandwidth: float) -> float | None:
    """Return the longest delay there and back [s] of absolute stability; None as `two_port`.

    Zero where it is not so even without a delay, infinite where it is up to `LONGEST`.
    """

    def stable(delay: float) -> bool:
        ports = two_port(coupling, master, bandwidth, 0.5 * delay)
        return ports is not None and is_absolutely_stable(ports)

    if two_port(coupling, master, bandwidth, 0.0) is None:
        return None
    if stable(LONGEST):
        return np.inf
    return bracket(lambda delay: not stable(delay), 0.0, LONGEST, CLOSE, LEAST)[0]


def _direct(coupling: Any, device: Any, bandwidth: float, delay: float, s: Any) -> TwoPort:
    late, limiter = np.exp(-s * delay), (bandwidth / (s + bandwidth)) ** 2
    return TwoPort(device, late, -late * limiter, 0.0 * s)  # hybrid; the scales cancel


def _position_damping(
    coupling: Any, device: Any, bandwidth: float, delay: float, s: Any
) -> TwoPort:
    scale = coupling.impedance_scale
    spring, damper = scale * coupling.stiffness / s, scale * coupling.damping
    across = spring * np.exp(-s * delay)
    mass = scale * coupling.virtual_mass * s
    return TwoPort(device + spring + damper, across, across, mass + spring + damper)


def _waves(coupling: Any, device: Any, bandwidth: float, delay: float, s: Any) -> TwoPort:
    scale = coupling.impedance_scale
    b, mass = scale * coupling.impedance, scale * coupling.virtual_mass * s
    spring = scale * (coupling.stiffness / s + coupling.damping)
    # A chain (f, v) -> (f, v): the device, the line, the spring between, the tool.
    forth, back = np.cosh(s * delay), np.sinh(s * delay)
    f_f, f_v, v_f, v_v = forth, b * back, back / b, forth
    f_f, v_f = f_f + f_v / spring, v_f + v_v / spring
    f_v, v_v = f_v + f_f * mass, v_v + v_f * mass
    return TwoPort(device + f_f / v_f, 1.0 / v_f, 1.0 / v_f, v_v / v_f)


_PORTS: Final[dict[type[Coupling], Callable[..., TwoPort]]] = {
    Direct: _direct,
    PositionDamping: _position_damping,
    WaveVariables: _waves,
}

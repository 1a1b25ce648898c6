r"""The loops that the couplings of a scenario make, one axis, linear around rest, by contact.

The damping of a surface is blended in, so it is looked at twice: firmly touched, deeper than the
blend, and lightly, with one newton, from which on the couplings count a contact as firm. Free, the
tool touches nothing. All is in the master's units, as in the couplings' kernels. The limiter of the
commands is :math:`\ddot x + 2 \omega \dot x + \omega^2 x = \omega^2 x_c`. Where an end answers its
own motion some ticks later, that is Pade's first approximant. The joints follow the limiter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from scara_drake.coupling.direct import Direct
from scara_drake.coupling.ends import FIRM, Coupling
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.operator.master import Master
from scara_drake.scenario import Scenario
from scara_drake.stability.certificates.loop import Loop
from scara_drake.wiring.bilateral import COMMAND_TICKS, DEVICE_TICKS, FORCE_TICKS

Array = NDArray[np.float64]

HOLD_TICKS = 1  # a force and a command are each held for a tick, half of one on average
OWN_TICKS = 1.5  # from the motion at an end to the force with which it answers, which is held
FELT_TICKS = 3.5  # from the tool's motion to the contact, the slave, the limiter
FREE: Final = "free"
LIGHTLY: Final = ", lightly"


@dataclass(frozen=True)
class Touch:
    """What the tool touches.

    Attributes:
        name: of the surface, or "free".
        stiffness: [N/m].
        damping: [N s/m].
    """

    name: str = FREE
    stiffness: float = 0.0
    damping: float = 0.0


def touches(scenario: Scenario) -> list[Touch]:
    """Return what the tool of a scenario may touch: nothing, and each surface that is linear."""
    found = [Touch()]
    for surface in scenario.environment.surfaces:
        if getattr(surface, "law", "") == "impedance" and surface.stiffness > 0.0:
            share = min(FIRM / (surface.stiffness * surface.blend), 1.0)
            for how, damping in (("", 1.0), (LIGHTLY, share)):
                name = f"{surface.name}{how}"
                found.append(Touch(name, surface.stiffness, damping * surface.damping))
    return found


def own_ticks() -> int:
    """Ticks that the loop is late beside its channel, and its limiter."""
    return COMMAND_TICKS + FORCE_TICKS + DEVICE_TICKS + HOLD_TICKS


def loop_of(scenario: Scenario, touch: Touch) -> Loop | None:
    """Return the loop of a scenario; None where nothing comes back, or its coupling has no form.

    Its late signals are what goes to the slave and what comes from there.
    """
    master = scenario.operator
    if not isinstance(master, Master):
        return None
    for kind, make in _LOOPS.items():
        if isinstance(scenario.coupling, kind):
            bandwidth = scenario.inverse_kinematics.bandwidth
            return make(master, scenario.coupling, touch, bandwidth, scenario.time_step)
    return None


def _direct(
    master: Master, coupling: Any, touch: Touch, bandwidth: float, period: float
) -> Loop | None:
    if touch.name == FREE:
        return None
    scale = coupling.impedance_scale
    a, b, c = np.zeros((4, 4)), np.zeros((4, 2)), np.zeros((2, 4))  # x, v; x, v of the tool
    _device(a, master)
    a[2, 3] = 1.0
    a[3, 2:] = -(bandwidth**2), -2.0 * bandwidth
    b[3, 0], c[0, 0] = bandwidth**2, 1.0
    b[1, 1] = -1.0 / master.hardware().mass
    c[1, 2:] = scale * touch.stiffness, scale * touch.damping
    return Loop(a, b, c)


def _position_damping(
    master: Master, coupling: Any, touch: Touch, bandwidth: float, period: float
) -> Loop:
    scale = coupling.impedance_scale
    spring, damper = scale * coupling.stiffness, scale * coupling.damping
    mass, device = scale * coupling.virtual_mass, master.hardware().mass
    grip = 0.0 if touch.name == FREE else coupling.contact_damping
    answer = np.array([spring, damper])
    a, b, c = np.zeros((7, 7)), np.zeros((7, 2)), np.zeros((2, 7))
    # x, v and own force of the device; x, v, own and felt force of the tool
    _device(a, master)
    a[3, 4] = 1.0
    _answer(a, 0, 2, answer, OWN_TICKS * period, device)
    _answer(a, 3, 5, answer + scale * grip * np.array([0.0, 1.0]), OWN_TICKS * period, mass)
    felt = np.array([touch.stiffness, touch.damping])
    _answer(a, 3, 6, scale * felt, FELT_TICKS * period, mass)
    b[4, 0], c[0, 0] = spring / mass, 1.0
    b[1, 1], c[1, 3] = spring / device, 1.0
    return Loop(a, b, c)


def _device(a: Array, master: Master) -> None:
    """Write the motion of the device in its hand into the first two rows."""
    device = master.hardware()
    a[0, 1] = 1.0
    a[1, 0] = -master.hand_stiffness / device.mass
    a[1, 1] = -(device.viscous + master.hand_damping) / device.mass


def _answer(a: Array, at: int, q: int, impedance: Array, late: float, mass: float) -> None:
    """Let a mass feel the force g = impedance (x, v) of some time ago: q - g in its place.

    q' = 2 / late (2 g - q). Its x, v are at `at` and behind it, the new state at `q`.
    """
    x_v = slice(at, at + 2)
    a[q, x_v] = 4.0 / late * impedance
    a[q, q] = -2.0 / late
    a[at + 1, x_v] += impedance / mass
    a[at + 1, q] -= 1.0 / mass


_LOOPS: Final[dict[type[Coupling], Callable[..., Loop | None]]] = {
    Direct: _direct,
    PositionDamping: _position_damping,
}
KINDS: Final = tuple(_LOOPS)

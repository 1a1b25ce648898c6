"""What theory proves of a scenario: every rule that knows its coupling, gathered."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_drake.channel.delays import ConstantDelay
from scara_drake.channel.links import Link
from scara_drake.channel.packets import Packets
from scara_drake.coupling.model_mediated import ModelMediated
from scara_drake.coupling.position_damping import PositionDamping
from scara_drake.coupling.wave_variables import WaveVariables
from scara_drake.operator.master import Master
from scara_drake.scenario import Scenario
from scara_drake.stability.certificates import krasovskii, linear_couplings, small_gain, two_port
from scara_drake.stability.certificates.loop import Loop, seen_delay
from scara_drake.stability.certificates.result import (
    ANY,
    CONSTANT,
    VARYING,
    Certificate,
    Certificates,
    Seen,
)

LONGEST = 2.0  # [s] there and back, up to which a delay is proven
LINEAR = "linear: the contact lasts, no limit is met, the joints follow their commands"
PASSIVE = "any passive hand and wall; without ticks inside the ends"


def certify(scenario: Scenario) -> Certificates:
    """Return what is proven of the stability of a bilateral scenario, and what is seen.

    Args:
        scenario: with a simulated master.

    Raises:
        ValueError: it has no such operator.
    """
    master, coupling = scenario.operator, scenario.coupling
    if not isinstance(master, Master):
        kind = type(master).__name__
        raise ValueError(f"operator: !{kind}, allowed !Master, whose loop is closed")
    own = linear_couplings.own_ticks() * scenario.time_step
    links = [scenario.channel.link(way) for way in ("up", "down")]
    up, down = (_oldest(link, scenario.channel.codec is not None) for link in links)
    proven, seen = [*_of_any_ends(scenario, master, own)], []
    for touch in linear_couplings.touches(scenario):
        loop = linear_couplings.loop_of(scenario, touch)
        if loop is not None:
            proven += _of_loop(loop, touch.name, own)
            seen.append(Seen(touch.name, max(seen_delay(loop) - own, 0.0)))
    return Certificates(
        type(coupling).__name__,
        up,
        down,
        all(isinstance(link, ConstantDelay) for link in links),
        own,
        tuple(proven),
        tuple(seen),
        tuple(_notes(scenario, master, max(up, down))),
    )


def _oldest(link: Link, dead_band: bool) -> float:
    """Return the largest age [s] of what a link shows; infinite where some never come."""
    if dead_band:
        return np.inf
    if isinstance(link, Packets):
        lost = link.loss.in_good > 0.0 or (link.loss.in_bad > 0.0 and link.loss.to_bad > 0.0)
        return np.inf if lost or link.outages else link.maximum() + link.send_period
    return float(link.maximum())


def _of_loop(loop: Loop, contact: str, own: float) -> Iterator[Certificate]:
    """Yield what semidefinite programs prove of a linear loop."""
    if small_gain.bears_any_delay(loop):
        yield Certificate("small gain", contact, CONSTANT, np.inf, LINEAR, exact=True)
    else:
        delay = krasovskii.proven_delay(loop, LONGEST + own)
        yield Certificate(
            "Lyapunov-Krasovskii", contact, CONSTANT, max(delay - own, 0.0), LINEAR, exact=True
        )
    each = small_gain.varying_delay(loop, 0.5 * (LONGEST + own))
    yield Certificate(
        "scaled small gain",
        contact,
        VARYING,
        max(2.0 * each - own, 0.0),
        f"{LINEAR}; half of it each way, ages at use",
        exact=True,
    )


def _of_any_ends(scenario: Scenario, master: Master, own: float) -> Iterator[Certificate]:
    """Yield what is known of a coupling between any passive hand and wall."""
    coupling = scenario.coupling
    if isinstance(coupling, PositionDamping) and coupling.stiffness > 0.0:
        longest = 2.0 * coupling.damping / coupling.stiffness
        yield Certificate(
            "4 B_l B_r > (T_l + T_r)² K_l K_r", ANY, VARYING, max(longest - own, 0.0), PASSIVE
        )
    if isinstance(coupling, WaveVariables):
        yield Certificate(
            "passivity of the waves",
            ANY,
            VARYING,
            np.inf,
            "any passive hand and wall; energy is bounded, a place may drift; for a hand within "
            "`turn`",
        )
    bandwidth = scenario.inverse_kinematics.bandwidth
    delay = two_port.absolute_delay(coupling, master, bandwidth)
    if delay is not None:
        yield Certificate(
            "Llewellyn",
            ANY,
            CONSTANT,
            max(delay - own, 0.0),
            f"{PASSIVE}; on a grid of frequencies",
        )


def colgate_bound(damping: float, virtual_damping: float, period: float) -> float:
    """Return the largest passive stiffness [N/m] of a sampled virtual wall: b > K T / 2 + |B|.

    Args:
        damping: b of the device [N s/m].
        virtual_damping: B of the wall [N s/m].
        period: T [s].
    """
    return 2.0 * (damping - abs(virtual_damping)) / period


def _notes(scenario: Scenario, master: Master, age: float) -> Iterator[str]:
    if isinstance(scenario.coupling, ModelMediated):
        viscous = master.hardware().viscous
        bound = colgate_bound(viscous, 0.0, scenario.time_step)
        yield (
            f"Colgate: a spring rendered at the device is passive up to {bound:.0f} N/m, and the "
            f"model's damping up to {viscous:g} N s/m less K T / 2"
        )
    if np.isinf(age):
        yield "what is lost, or not sent, is held: its age has no bound"
    hardware = master.hardware()
    if hardware.friction > 0.0 or hardware.resolution > 0.0:
        yield "Coulomb friction and encoder of the device are left out"
    if not isinstance(scenario.coupling, linear_couplings.KINDS):
        kind = type(scenario.coupling).__name__
        yield f"no linear loop: {kind} is not linear, or its form is not known here"
    yield f"{1e3 * linear_couplings.own_ticks() * scenario.time_step:g} ms of ticks are taken off"

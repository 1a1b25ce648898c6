"""From an attack to the scenario that it makes of another."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

import numpy as np

from scara_drake.attack.bounds import OUTAGE_AT, SPREAD, SWEEP_RATE, SWING_RATE, Attack
from scara_drake.channel.delays import ConstantDelay, DelayLaw, SineDelay
from scara_drake.channel.impairments import Jitter, Loss
from scara_drake.channel.links import Link
from scara_drake.channel.packets import Packets
from scara_drake.common import checks
from scara_drake.operator.hand import Sweep
from scara_drake.operator.master import Master
from scara_drake.scenario import Scenario

LONGEST: Final = 1.0  # [s]; travel of a packet: the same in all runs, which so share their code
DURATION: Final = "run.duration"  # of an attack: that of the run [s]
TREMOR: Final = 0.8  # share of the run that a tremor lasts, so that it is over at the end


def shortened(scenario: Scenario, duration: float) -> Scenario:
    """Return a scenario of a press that lasts `duration` [s]: the hand's times shrink with it.

    Raises:
        ValueError: the operator is no master, or the duration is out of its bounds.
    """
    master = scenario.operator
    if not isinstance(master, Master):
        raise ValueError(f"operator: !{type(master).__name__}, allowed !Master")
    checks.number("duration", duration, 0.1, 3600.0)
    made = replace(scenario)
    factor = duration / scenario.duration
    times = [float(f"{factor * time:.6g}") for time in master.times]
    made.operator = replace(master, times=times)
    made.duration = duration
    # Samples at every tick, as far as a recording may have them: an invariant holds at each.
    made.logging = replace(scenario.logging, period=max(scenario.time_step, 1e-3))
    return made


def attacked(scenario: Scenario, attack: Attack) -> Scenario:
    """Return the scenario that an attack makes of another, which is not changed."""
    made = replace(scenario)
    made.duration = attack.get(DURATION, scenario.duration)
    made.seed = int(attack.get("channel.seed", scenario.seed))
    own = scenario.channel
    up, down = (_attacked_link(scenario, name, attack) for name in ("up", "down"))
    longest = max(own.max_delay, up.maximum(), down.maximum())
    made.channel = replace(own, up=up, down=down, preset="", playout="own", max_delay=longest)
    made.operator = _attacked_hand(scenario, attack)
    if scenario.environment.surfaces:
        first, *others = scenario.environment.surfaces
        surfaces = [_attacked_wall(first, attack), *others]
        made.environment = replace(scenario.environment, surfaces=surfaces)
    return made


def _attacked_link(scenario: Scenario, direction: str, attack: Attack) -> Packets:
    """Return a link as packets; of a delay of whole ticks this alone changes no bit."""
    own: Link = scenario.channel.link(direction)
    link = own if isinstance(own, Packets) else Packets(delay=own)
    made = replace(
        link, delay=_attacked_delay(link.delay, attack), longest=max(link.longest, LONGEST)
    )
    if "channel.send_period" in attack:
        ticks = max(round(attack["channel.send_period"] / scenario.time_step), 1)
        made = replace(made, send_period=float(f"{ticks * scenario.time_step:.9g}"))
    if attack.get("channel.side", direction) not in ("both", direction):
        return made
    return replace(
        made,
        jitter=_attacked_jitter(link.jitter, attack),
        loss=_attacked_loss(link.loss, attack),
        outages=_attacked_outages(link.outages, attack, scenario.duration),
    )


def _attacked_delay(own: DelayLaw, attack: Attack) -> DelayLaw:
    law = ConstantDelay(attack["channel.delay"]) if "channel.delay" in attack else own
    swing = attack.get("channel.swing", 0.0)
    if swing == 0.0:
        return law
    return SineDelay(swing, law.at(0.0), attack.get("channel.swing_rate", SWING_RATE))


def _attacked_jitter(own: Jitter, attack: Attack) -> Jitter:
    if not {"channel.jitter", "channel.spread", "channel.distribution"} & attack.keys():
        return own
    mean = attack.get("channel.jitter", own.mean)
    if mean <= 0.0:
        return Jitter()
    spread = attack.get("channel.spread", own.std / own.mean if own.mean > 0.0 else SPREAD)
    kind = attack.get(
        "channel.distribution", own.distribution if own.distribution != "none" else "gamma"
    )
    if kind == "uniform":  # none of it is negative
        spread = min(spread, 0.999 / math.sqrt(3.0))
    return Jitter(kind, mean, spread * mean)


def _attacked_loss(own: Loss, attack: Attack) -> Loss:
    if not {"channel.loss", "channel.burst"} & attack.keys():
        return own
    share, burst = attack.get("channel.loss", own.in_good), attack.get("channel.burst", 1.0)
    if share <= 0.0 or burst <= 1.0:
        return replace(own, in_good=share)
    # Gilbert: all are lost while the link is bad, where it is for that share of the time.
    return Loss(0.0, 1.0, min(share / (1.0 - share) / burst, 1.0), 1.0 / burst)


def _attacked_outages(own: list[float], attack: Attack, duration: float) -> list[float]:
    length = attack.get("channel.outage", 0.0)
    if length <= 0.0:
        return own
    begin = attack.get("channel.outage_at", OUTAGE_AT) * duration
    return [float(f"{begin:.6g}"), float(f"{begin + length:.6g}")]


def _attacked_hand(scenario: Scenario, attack: Attack) -> Master:
    own: Any = scenario.operator
    pace, reach = attack.get("hand.pace", 1.0), attack.get("hand.reach", 1.0)
    made = replace(
        own,
        hand_stiffness=attack.get("hand.stiffness", own.hand_stiffness),
        hand_damping=attack.get("hand.damping", own.hand_damping),
        times=[time / pace for time in own.times],
        targets=[[reach * each for each in row] for row in own.targets],
    )
    amplitude = attack.get("hand.sweep", 0.0)
    if amplitude > 0.0:
        along = int(np.argmax(np.abs(own.targets).max(axis=0)))
        rate = attack.get("hand.sweep_rate", SWEEP_RATE)
        lasting = TREMOR * scenario.duration
        made = replace(made, sweep=Sweep(along, amplitude, rate, rate, 0.0, lasting))
    return made


def _attacked_wall(own: Any, attack: Attack) -> Any:
    changed: dict[str, Any] = {
        name: attack[f"wall.{name}"]
        for name in ("stiffness", "damping")
        if f"wall.{name}" in attack
    }
    if "wall.shift" in attack:
        moved = np.array(own.point) + attack["wall.shift"] * np.array(own.normal)
        changed["point"] = [float(f"{each:.9g}") for each in moved]
    return replace(own, **changed)

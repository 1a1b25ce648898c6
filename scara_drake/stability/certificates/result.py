"""What is proven of a scenario, under which assumptions, and beside it what is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from scara_drake.common.html import card, line, table

CONSTANT, VARYING = "constant", "varying"
ANY = "any"  # contact: whatever is touched


@dataclass(frozen=True)
class Certificate:
    """One statement that theory gives.

    Attributes:
        rule: that was used.
        contact: what the tool touches, "free", or "any".
        delays: for which it holds: constant ones, or also varying ones.
        delay: of the channel there and back [s], up to which the loop is stable; 0 where nothing
            is proven, infinite where any delay is borne.
        assumptions: under which that is so.
        exact: whether it has been verified without rounding; else it is a formula or a grid.
    """

    rule: str
    contact: str
    delays: str
    delay: float
    assumptions: str
    exact: bool = False


@dataclass(frozen=True)
class Seen:
    """The delay of the channel there and back [s] at which a loop turns over, and who saw it."""

    contact: str
    delay: float
    by: str = "rightmost roots of the linear loop"


@dataclass(frozen=True)
class Certificates:
    """All that theory gives for a scenario.

    Attributes:
        coupling: its kind.
        up: largest age of what arrives at the slave [s].
        down: of what arrives at the master [s].
        constant: whether that is the delay at all times.
        own: of the loop itself, which has been taken from all delays here [s].
        proven: the certificates.
        seen: what contradicts or bounds them.
        notes: what else is to be known.
    """

    coupling: str
    up: float
    down: float
    constant: bool
    own: float
    proven: tuple[Certificate, ...]
    seen: tuple[Seen, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @property
    def channel(self) -> float:
        """Delay there and back [s]; where it varies, twice the longer way."""
        return self.up + self.down if self.constant else 2.0 * max(self.up, self.down)

    @property
    def contacts(self) -> tuple[str, ...]:
        """What the tool may touch, as far as anything is proven or seen of it."""
        names = [*(one.contact for one in self.proven), *(one.contact for one in self.seen)]
        return tuple(dict.fromkeys(name for name in names if name != ANY)) or (ANY,)

    def proven_delay(self, contact: str, delays: str = CONSTANT) -> float:
        """Return the longest delay there and back [s] that is proven for a contact."""
        fits = [
            one.delay
            for one in self.proven
            if one.contact in (contact, ANY) and delays in (one.delays, CONSTANT)
        ]
        return max(fits, default=0.0)

    def seen_delay(self, contact: str) -> float:
        """Return the least delay there and back [s] at which a contact was seen to turn over."""
        return min((one.delay for one in self.seen if one.contact == contact), default=math.inf)

    def contradictions(self) -> list[str]:
        """Return a sentence for each contact that turns over at a delay that is proven."""
        return [
            f"{contact}: proven up to {told(self.proven_delay(contact))}, "
            f"seen unstable at {told(self.seen_delay(contact))}"
            for contact in self.contacts
            if 0.0 < self.proven_delay(contact) > self.seen_delay(contact)
        ]

    def covers(self) -> bool:
        """Whether the scenario's own channel is within what is proven, for each contact."""
        kind = CONSTANT if self.constant else VARYING
        proven = [self.proven_delay(contact, kind) for contact in self.contacts]
        return bool(proven) and all(one >= self.channel and one > 0.0 for one in proven)

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        verdict = "proven stable" if self.covers() else "not proven"
        head = (
            f"{self.coupling}, channel of {told(self.channel)} there and back"
            f"{'' if self.constant else ', varying'}: {verdict}"
        )
        return [head, *(_told_of(self, contact) for contact in self.contacts), *self.notes]

    def __str__(self) -> str:
        """Return the lines as one text."""
        return "\n".join(self.lines())

    def _repr_html_(self) -> str:
        rows = [
            (one.rule, one.contact, one.delays, told(one.delay), one.assumptions)
            for one in self.proven
        ]
        return card(
            "Certificates",
            *(line(one) for one in self.lines()),
            table(rows, ["rule", "touching", "delays", "there and back", "assumes"]),
        )


def told(delay: float) -> str:
    """Return a delay [s] in words."""
    if math.isinf(delay):
        return "any delay"
    return f"{1e3 * delay:.3g} ms"


def _told_of(found: Certificates, contact: str) -> str:
    proven, seen = found.proven_delay(contact), found.seen_delay(contact)
    varying = found.proven_delay(contact, VARYING)
    gap = f", {seen / proven:.3g} times that" if proven > 0.0 and math.isfinite(seen) else ""
    turns = "never seen unstable" if math.isinf(seen) else f"seen unstable from {told(seen)}{gap}"
    what = told(proven) if proven > 0.0 else "no delay"
    return f"touching {contact}: proven up to {what}, varying up to {told(varying)}; {turns}"

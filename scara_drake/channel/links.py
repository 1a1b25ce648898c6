"""The communication channel of a scenario: what carries the command up and the force down."""

from dataclasses import dataclass, field, replace

from scara_drake.channel.codec import DeadBand
from scara_drake.channel.delays import LONGEST, ConstantDelay, DelayLaw
from scara_drake.channel.packets import Packets
from scara_drake.channel.presets import PRESETS
from scara_drake.channel.watch import CommandWatch
from scara_drake.common import checks, fields
from scara_drake.common.fields import choice, number

Link = DelayLaw | Packets
PLAYOUTS = ("own", "recommended")


def received_by(link: Link, uses_late: bool) -> Link:
    """Return a link whose buffer does with late packets what the receiver wants, if left to it."""
    if not isinstance(link, Packets) or link.playout is None or link.playout.late != "coupling":
        return link
    return replace(link, playout=replace(link.playout, late="use" if uses_late else "drop"))


@dataclass
class Channel:
    """The two directions: `up` carries the command to the robot, `down` the force back.

    Attributes:
        up: link to the robot.
        down: link to the operator.
        preset: a name of `PRESETS`, which then stands for both links; empty for none.
        playout: buffer of its links, as they are or as the preset recommends.
        max_delay: longest that either may reach.
        watch: when the command counts as lost, and what follows; for an `up` of packets.
        codec: which packets are sent, of a coupling whose links both carry packets.
    """

    up: Link = field(default_factory=ConstantDelay)
    down: Link = field(default_factory=ConstantDelay)
    preset: str = ""
    playout: str = choice("own", PLAYOUTS)
    max_delay: float = number(2.5, "s", 0.0, LONGEST)
    watch: CommandWatch | None = None
    codec: DeadBand | None = None

    def check_together(self, name: str) -> None:
        """Check the preset, and the links that stand against max_delay.

        Raises:
            ValueError: an unknown preset, a link whose delay exceeds max_delay, or a watch over a
                link without packets, or a codec before one or with less than a send period to
                be silent.
        """
        if self.preset:
            checks.choice(f"{name}.preset", self.preset, PRESETS)
        if self.playout == "recommended" and (
            not self.preset or PRESETS[self.preset].playout is None
        ):
            known = ", ".join(key for key, preset in PRESETS.items() if preset.playout is not None)
            raise ValueError(
                f"{name}.playout: 'recommended', allowed with {name}.preset one of {known}"
            )
        for direction in ("up", "down"):
            link = self.link(direction)
            if link.maximum() > self.max_delay:
                if isinstance(link, Packets) and link.longest > self.max_delay:
                    checks.number(f"{name}.{direction}.longest", link.longest, 0.0, self.max_delay)
                raise ValueError(
                    f"{name}.{direction}: a delay of up to {link.maximum():g} s, allowed 0 to "
                    f"{self.max_delay:g} s ({name}.max_delay)"
                )

        if self.watch is not None and not isinstance(self.link("up"), Packets):
            raise ValueError(f"{name}.watch: set, allowed where {name}.up is !Packets")
        for direction in ("up", "down"):
            link = self.link(direction)
            if self.codec is None:
                continue
            if not isinstance(link, Packets):
                raise ValueError(f"{name}.codec: set, allowed where {name}.{direction} is !Packets")
            if self.codec.keep_alive < link.send_period:
                raise ValueError(
                    f"{name}.codec.keep_alive: {self.codec.keep_alive:g} s, allowed from "
                    f"{link.send_period:g} s, the send period of {name}.{direction}"
                )

    def check_sampling(self, name: str, period: float) -> None:
        """Check that the links that stand suit the time step `period` [s].

        Raises:
            ValueError: packets are not sent at its ticks.
        """
        for direction in ("up", "down"):
            fields.check_sampling(self.link(direction), f"{name}.{direction}", period)

    def link(self, direction: str) -> Link:
        """Return the link "up" or "down", that of the preset if one is named."""
        if self.preset:
            preset = PRESETS[self.preset]
            return preset.buffered() if self.playout == "recommended" else preset.link
        link: Link = getattr(self, direction)
        return link

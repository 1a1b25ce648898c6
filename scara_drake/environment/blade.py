"""The saw blade at the tool: a disc, its motor, and how it rests on what it cuts."""

from dataclasses import dataclass

from scara_drake.common import checks
from scara_drake.common.fields import ABOVE_ZERO, number


@dataclass
class Blade:
    """A disc that runs whenever it is not stalled; the tool point is the foremost point of its rim.

    Its axis is y of the tool frame. The motor is one of constant field: its speed falls with the
    load, v = v_0 (1 - F / F_s), so it gives the most power, P = v_0 F_s / 4, at half the speed.

    Attributes:
        radius: of the disc.
        kerf: width of the slot that its teeth cut.
        body: thickness behind the teeth; half of what it is thinner than the kerf is clearance.
        speed: v_0 of the rim without load; negative turns the other way.
        power: P, the most that the motor gives.
        stalled_below: share of v_0 below which the blade stops: its motor no longer turns it.
        feed_ratio: of the force that feeds the blade to the force that cuts; blunt teeth need more.
        stiffness: of the rim against uncut material, per area of overlap.
        damping: of the rim; the force on an approach at a speed v is 1 + damping v times as large.
        side_stiffness: against bending the whole blade out of its kerf.
        side_damping: of that bending.
        friction: of the blade's body on the sides of its kerf, dry steel on steel.
    """

    radius: float = number(0.14, "m", 0.01, 1.0)
    kerf: float = number(0.003, "m", 2e-4, 0.05)
    body: float = number(0.0022, "m", 1e-4, 0.05)
    speed: float = number(5.0, "m/s", -100.0, 100.0)
    power: float = number(750.0, "W", 1.0, 1e5)
    stalled_below: float = number(0.2, "1", 0.01, 0.5)
    feed_ratio: float = number(0.5, "1", 0.05, 5.0)
    stiffness: float = number(1e7, "N/m^2", 1e4, 1e9)
    damping: float = number(5.0, "s/m", 0.0, 100.0)
    side_stiffness: float = number(2e5, "N/m", 0.0, 1e7)
    side_damping: float = number(1e3, "N s/m", 0.0, 1e5)
    friction: float = number(0.5, "1", 0.0, 2.0)

    def check_together(self, name: str) -> None:
        """Check the body and the speed.

        Raises:
            ValueError: the body is thicker than the kerf, or the blade does not turn.
        """
        checks.number(f"{name}.body", self.body, ABOVE_ZERO, self.kerf)
        if abs(self.speed) < 1e-2:
            raise ValueError(f"{name}.speed: {self.speed:g}, allowed 0.01 m/s or more either way")

    def stall_force(self) -> float:
        """Return F_s [N], at the rim, with which the motor stands still."""
        return 4.0 * self.power / abs(self.speed)

"""What the paper leaves open, and what follows from each way to read it, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from scara_drake.experiments.quantity import Value


@dataclass(frozen=True)
class Reading:
    """One way to read it.

    Attributes:
        name: such as "0.2 sin t, cut at zero".
        meaning: what it does to the simulation, a sentence.
        consequences: what was measured under it, by name; the same names for all readings of a
            question.
        verdict: what the claim becomes under it, one of VERDICTS; "" where it cannot be judged.
        chosen: whether it is the one that the claims of the experiment are judged by.
    """

    name: str
    meaning: str
    consequences: Mapping[str, Value]
    verdict: str = ""
    chosen: bool = False


@dataclass(frozen=True)
class OpenQuestion:
    """A question that the paper's text does not answer.

    Attributes:
        question: such as "Which delay is t_d = 0.2 sin t, called 0 to 2 s?".
        claim: the statement whose verdict hangs on it.
        readings: the ways to read it, exactly one of them chosen.

    Raises:
        ValueError: not one chosen, or consequences under other names.
    """

    question: str
    claim: str
    readings: tuple[Reading, ...]

    def __post_init__(self) -> None:
        """Check that the readings can stand in one table."""
        chosen = [reading.name for reading in self.readings if reading.chosen]
        if len(chosen) != 1:
            raise ValueError(f"chosen: {', '.join(chosen) or 'none'}, allowed one reading")
        columns = list(self.readings[0].consequences)
        for reading in self.readings:
            if list(reading.consequences) != columns:
                got = ", ".join(reading.consequences)
                raise ValueError(
                    f"consequences of {reading.name}: {got}, allowed {', '.join(columns)}"
                )

    def _repr_html_(self) -> str:
        from scara_drake.experiments.cards import of_question

        return of_question(self)

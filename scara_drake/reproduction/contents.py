"""What a report says, and in which order; `markdown` and `page` write it down."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final

from scara_drake.common.resources import resource
from scara_drake.experiments import EXPERIMENTS, VERDICTS
from scara_drake.experiments.claim import OURS, PAPER
from scara_drake.reproduction.baseline import SEED, Difference
from scara_drake.reproduction.index import NUMBERED, Entry
from scara_drake.reproduction.run import DRAWN, Outcome
from scara_drake.reproduction.selection import Selection, experiment_of

BESIDE: Final = "Beside the paper"
PACKAGES: Final = ("scara-drake", "drake", "numpy", "numba", "xarray")
SOURCE_WORDS: Final = {PAPER: "statements of the paper", OURS: "criteria of our own"}
TITLE: Final = "The paper, reproduced"
DIFFERENT: Final = f"Other than the known verdicts, those of seed {SEED}:"
INTRODUCTION: Final = (
    "Each table, figure and equation of the paper with what it states, in our words, and what "
    "became of it here. A verdict follows from a criterion by number. *Reproduced*: the criterion "
    "is met in its strict form. *Reproduced in kind*: in its weaker form, such as an order in "
    "place of a value. *Not reproduced*: in neither. *Not comparable*: there is nothing to "
    "compare with. Tables 1 to 4, 11 and 12 are given to the model, so that *reproduced* says "
    "there that their numbers are kept."
)


@dataclass(frozen=True)
class Image:
    """A picture of a section.

    Attributes:
        name: of its file, such as "figure_16.png".
        caption: what is seen.
        shipped: the file that is shipped with the project; None where `data` is the picture.
        data: PNG.
    """

    name: str
    caption: str
    shipped: Path | None = None
    data: bytes = b""

    def content(self) -> bytes:
        """Return the bytes of the file."""
        return self.shipped.read_bytes() if self.shipped else self.data


@dataclass(frozen=True)
class Section:
    """A table, figure or equation, or an experiment beside the paper.

    Attributes:
        heading: such as "Figures 16 and 17".
        title: what it is.
        entry: of the index; None beside the paper.
        outcome: of its experiment, where it is told here.
        told: heading of the section that tells of its experiment instead, or "".
        counts: of the verdicts of its experiment, wherever that is told.
        images: its pictures.
    """

    heading: str
    title: str
    entry: Entry | None
    outcome: Outcome | None
    told: str
    counts: Mapping[str, int]
    images: tuple[Image, ...]

    @property
    def anchor(self) -> str:
        """Where links to it lead."""
        return slug(self.heading)


@dataclass(frozen=True)
class Contents:
    """All that is reported.

    Attributes:
        chapters: their sections by title.
        outcomes: of the experiments that were run, by name.
        differences: from the known verdicts.
        seed: of all that is drawn.
    """

    chapters: Mapping[str, Sequence[Section]]
    outcomes: Mapping[str, Outcome]
    differences: Sequence[Difference]
    seed: int

    @property
    def failed(self) -> list[Outcome]:
        """Experiments that broke off, or a picture of which did."""
        return [outcome for outcome in self.outcomes.values() if outcome.error]


def contents(
    selection: Selection,
    outcomes: Mapping[str, Outcome],
    differences: Sequence[Difference],
    seed: int,
) -> Contents:
    """Return what is reported of some outcomes, each told in the section it belongs to."""
    homes = _homes(selection)
    sections = [_of_entry(entry, outcomes, homes) for entry in selection.entries]
    chapters = {
        f"{kind.capitalize()}s": [s for s in sections if s.entry and s.entry.kind == kind]
        for kind in NUMBERED
    }
    chapters[BESIDE] = [
        _beside(name, outcomes[name]) for name in selection.experiments if name not in homes
    ]
    kept = {title: each for title, each in chapters.items() if each}
    return Contents(kept, outcomes, differences, seed)


def slug(heading: str) -> str:
    """Return the anchor that Markdown gives to a heading."""
    return re.sub(r"[^\w-]", "", heading.lower().replace(" ", "-"))


def counts(*outcomes: Outcome | None, source: str = "") -> Counter[str]:
    """Return how many claims got each verdict; of one source, if it is named."""
    return Counter(
        claim.verdict
        for outcome in outcomes
        if outcome and outcome.experiment
        for claim in outcome.experiment.claims
        if source in ("", claim.source)
    )


def told_counts(found: Mapping[str, int]) -> str:
    """Return such counts in words: "2 reproduced, 1 not reproduced"."""
    return ", ".join(f"{found[verdict]} {verdict}" for verdict in VERDICTS if found.get(verdict))


def counts_table(found: Contents) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of the counts: of the paper's statements, of our criteria, of all."""
    outcomes = found.outcomes.values()
    kinds = {words: counts(*outcomes, source=source) for source, words in SOURCE_WORDS.items()}
    kinds["all"] = counts(*outcomes)
    rows = [
        [words, *(str(each[verdict]) for verdict in VERDICTS), str(each.total())]
        for words, each in kinds.items()
    ]
    return ["claims", *VERDICTS, "all"], rows


def versions(seed: int) -> str:
    """Return with what it was made, and the seed."""
    return ", ".join([f"{name} {version(name)}" for name in PACKAGES] + [f"seed {seed}"])


def _homes(selection: Selection) -> dict[str, Entry]:
    """Return the entry that tells of each experiment: that with its file, else the first."""
    found: dict[str, Entry] = {}
    best: dict[str, bool] = {}
    for entry in selection.entries:
        name = experiment_of(entry, EXPERIMENTS)
        own = any(Path(path).stem == name for path in entry.where)
        if name and (name not in found or (own and not best[name])):
            found[name], best[name] = entry, own
    return found


def _of_entry(entry: Entry, outcomes: Mapping[str, Outcome], homes: dict[str, Entry]) -> Section:
    outcome = outcomes.get(experiment_of(entry, EXPERIMENTS))
    told = homes[outcome.name].heading if outcome else ""
    shown = [
        Image(
            f"{slug(entry.heading)}{Path(path).suffix}",
            f"Here, in the place of {entry.heading}.",
            resource(path),
        )
        for path in entry.pictures
    ]
    for number in entry.numbers:
        name = f"{entry.kind}_{number}"
        drawn = next((o.pictures[name] for o in outcomes.values() if name in o.pictures), b"")
        if drawn:
            caption = DRAWN[entry.kind][number].caption
            shown.append(
                Image(f"{name}.png", f"{entry.kind.capitalize()} {number}. {caption}", None, drawn)
            )
    return Section(
        entry.heading,
        entry.title,
        entry,
        outcome if told == entry.heading else None,
        "" if told == entry.heading else told,
        counts(outcome),
        tuple(shown),
    )


def _beside(name: str, outcome: Outcome) -> Section:
    title = outcome.experiment.name if outcome.experiment else name
    text = (sys.modules[EXPERIMENTS[name].__module__].__doc__ or "").partition("\n\n")[0]
    said = " ".join(text.split()).rstrip(".")
    return Section(title, said, None, outcome, "", counts(outcome), ())

"""The verdicts as they are known to be, and what differs from them.

The file has them by experiment and statement. A verdict that gets worse, gets better, comes or goes
is a difference, and has to be looked at before it is accepted.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import yaml

from scara_drake import experiments
from scara_drake.common.files import write_whole
from scara_drake.common.yaml_text import read_yaml
from scara_drake.experiments import IN_KIND, NOT_REPRODUCED, REPRODUCED, VERDICTS, Experiment

PATH: Final = Path(experiments.__file__).with_name("baseline.yaml")
SEED: Final = 0  # for which it is
HEAD: Final = (
    "# The verdict on each claim, by experiment. Made by `scara-drake reproduce --accept`.\n"
)
RANKS: Final = (NOT_REPRODUCED, IN_KIND, REPRODUCED)  # from worst to best

Verdicts = dict[str, dict[str, str]]  # by experiment and statement


@dataclass(frozen=True)
class Difference:
    """A verdict that is not the known one.

    Attributes:
        kind: "lost", "better", "changed", "new" or "gone".
        experiment: its name in EXPERIMENTS.
        statement: of the claim.
        before: the known verdict, "" if there is none.
        now: the verdict now, "" if there is none.
    """

    kind: str
    experiment: str
    statement: str
    before: str
    now: str

    def __str__(self) -> str:
        """Return it as a line."""
        verdicts = " -> ".join(verdict for verdict in (self.before, self.now) if verdict)
        return f"{self.kind}: {self.experiment}: {self.statement} ({verdicts})"


def verdicts_of(done: Mapping[str, Experiment]) -> Verdicts:
    """Return the verdicts of some experiments.

    Raises:
        ValueError: an experiment makes a statement twice.
    """
    found: Verdicts = {}
    for name, experiment in done.items():
        found[name] = {claim.statement: claim.verdict for claim in experiment.claims}
        if len(found[name]) < len(experiment.claims):
            raise ValueError(f"{name}: a statement twice, allowed once")
    return found


def read(path: Path = PATH) -> Verdicts:
    """Return the known verdicts; none if there is no file.

    Raises:
        ValueError: the file is not of that form, or has a word that is no verdict.
    """
    data = read_yaml(path.read_text(encoding="utf-8"), path.name) if path.exists() else {}
    for name, claims in data.items():
        for statement, verdict in claims.items():
            if verdict not in VERDICTS:
                raise ValueError(
                    f"{path.name}: {name}: {statement}: {verdict}, allowed {', '.join(VERDICTS)}"
                )
    return data


def write(known: Verdicts, now: Verdicts, names: Iterable[str], path: Path = PATH) -> None:
    """Write the known verdicts anew, with those of some experiments as they are now.

    Args:
        known: the known ones.
        now: those of the experiments that were run.
        names: all experiments, in order; what is of no other is dropped.
        path: of the file.

    Raises:
        OSError: it cannot be written.
    """
    merged = {**known, **now}
    kept = {name: merged[name] for name in names if name in merged}
    text = yaml.safe_dump(kept, sort_keys=False, width=1000, allow_unicode=True)
    write_whole(path, HEAD + text)


def differences(known: Verdicts, now: Verdicts) -> list[Difference]:
    """Return what differs, in the order of what is now, and then what is gone.

    Args:
        known: the known verdicts, of the experiments that `now` could have.
        now: those that were found.
    """
    found = []
    for name, claims in now.items():
        for statement, verdict in claims.items():
            before = known.get(name, {}).get(statement, "")
            if verdict != before:
                found.append(Difference(_kind(before, verdict), name, statement, before, verdict))
    for name, claims in known.items():
        for statement, verdict in claims.items():
            if statement not in now.get(name, {}):
                found.append(Difference("gone", name, statement, verdict, ""))
    return found


def _kind(before: str, now: str) -> str:
    if not before:
        return "new"
    if before not in RANKS or now not in RANKS:
        return "changed"
    return "better" if RANKS.index(now) > RANKS.index(before) else "lost"

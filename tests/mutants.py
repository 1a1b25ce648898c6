"""Do the tests of an experiment notice a verdict that no longer depends on its data?"""

from collections import defaultdict
from collections.abc import Callable, Iterable

import pytest

from scara_drake.experiments.claim import VERDICTS, Claim

Judge = Callable[[], object]


def survivors(claims: Iterable[Claim], *judges: Judge) -> list[str]:
    """Return the claims whose criterion could be a constant without a test noticing.

    Each criterion is replaced by each verdict that the tests see of it. A test that sees one
    verdict only cannot tell.

    Args:
        claims: of the experiment; those without a criterion are left out.
        judges: tests of how it judges what it is given.
    """
    judged = [claim.statement for claim in claims if claim.criterion is not None]
    seen: dict[str, set[str]] = defaultdict(set)

    def watched(claim: Claim) -> str:
        seen[claim.statement].add(verdict_of(claim))
        return verdict_of(claim)

    assert not _noticed(watched, judges), "the tests fail as they are"
    return [
        statement
        for statement in judged
        if not seen[statement]
        or not all(_noticed(_constant(statement, one), judges) for one in seen[statement])
    ]


def verdict_of(claim: Claim) -> str:
    """Return the verdict as it is defined."""
    return claim.criterion.verdict(claim.paper) if claim.criterion else VERDICTS[-1]


def _constant(statement: str, verdict: str) -> Callable[[Claim], str]:
    return lambda claim: verdict if claim.statement == statement else verdict_of(claim)


def _noticed(verdict: Callable[[Claim], str], judges: Iterable[Judge]) -> bool:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Claim, "verdict", property(verdict))
        for judge in judges:
            try:
                judge()
            except AssertionError:
                return True
    return False

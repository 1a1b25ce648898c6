"""Do the tests of an experiment notice a verdict that no longer depends on its data?"""

import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from scara_drake.experiments.claim import VERDICTS, Claim

Judge = Callable[[], object]


def survivors(claims: Iterable[Claim], *judges: Judge) -> list[str]:
    """Return the claims whose criterion could be a constant without a test noticing.

    Each criterion is replaced by each verdict that the tests see of it. A test that sees one
    verdict only cannot tell. Only verdicts are replaced, so the claims that a test makes of its
    data are worked out once.

    Args:
        claims: of the experiment; those without a criterion are left out.
        judges: tests of how it judges what it is given.
    """
    judged = [claim.statement for claim in claims if claim.criterion is not None]
    seen: dict[str, set[str]] = defaultdict(set)

    def watched(claim: Claim) -> str:
        seen[claim.statement].add(verdict_of(claim))
        return verdict_of(claim)

    with _worked_out_once() as begin:
        again = [_from_the_beginning(judge, begin, place) for place, judge in enumerate(judges)]
        assert not _noticed(watched, again), "the tests fail as they are"
        return [
            statement
            for statement in judged
            if not seen[statement]
            or not all(_noticed(_constant(statement, one), again) for one in seen[statement])
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


@contextmanager
def _worked_out_once() -> Iterator[Callable[[int], None]]:
    """Keep what each function `claims` of the experiments returns, by judge and turn.

    A judge asks in the same order of the same data whenever it runs.

    Yields:
        What is to be called with the number of a judge before it runs.
    """
    made: dict[tuple[int, int], Any] = {}
    judge = turn = depth = 0

    def begin(place: int) -> None:
        nonlocal judge, turn
        judge, turn = place, 0

    def kept(claims: Callable[..., Any]) -> Callable[..., Any]:
        def answer(*arguments: Any) -> Any:
            nonlocal turn, depth
            if depth:  # one such function may be made of another
                return claims(*arguments)
            turn += 1
            if (judge, turn) not in made:
                depth += 1
                try:
                    made[judge, turn] = claims(*arguments)
                finally:
                    depth -= 1
            return made[judge, turn]

        return answer

    with pytest.MonkeyPatch.context() as patch:
        for name, module in sorted(sys.modules.items()):
            if name.startswith("scara_drake.experiments.") and hasattr(module, "claims"):
                patch.setattr(module, "claims", kept(module.claims))
        yield begin


def _from_the_beginning(judge: Judge, begin: Callable[[int], None], place: int) -> Judge:
    def judged() -> object:
        begin(place)
        return judge()

    return judged

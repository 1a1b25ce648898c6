"""The page of the supervisor says what the table of the code says."""

from pathlib import Path

from scara_drake.safety import MEANINGS, Reason, State

PAGE = Path(__file__).parents[1] / "docs" / "supervisor.md"


def row(reason: Reason) -> str:
    """The row of a reason in the page's table."""
    meaning = MEANINGS[reason]
    does = meaning.severity.name.replace("ESTOP", "E-STOP").replace("INFORM", "is told")
    return f"| {int(reason)} | {meaning.says} | {does} | {meaning.remedy} | {meaning.buzz} |"


def test_every_reason_and_state_is_on_the_page_as_in_the_code() -> None:
    text = PAGE.read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.startswith("| ") and line[2].isdigit()]
    assert lines == [row(reason) for reason in Reason if reason]
    for state in State:
        assert f"| {state.name.replace('ESTOP', 'E-STOP')} |" in text

"""The scenarios that are shipped, by name."""

from __future__ import annotations

from pathlib import Path

from scara_drake.common import checks
from scara_drake.common.resources import resource


def scenario_names() -> list[str]:
    """Return the names of the shipped scenarios, but for those of `training_names`."""
    return sorted(path.stem for path in resource("diagrams").glob("*.yaml"))


def training_names() -> list[str]:
    """Return the names of the shipped scenarios that have a task for an operator."""
    return sorted(path.stem for path in resource("diagrams", "training").glob("*.yaml"))


def find_scenario(name_or_path: str | Path) -> Path:
    """Return the path of a scenario, shipped or one's own.

    Raises:
        ValueError: there is none of that name, or no such file.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        if not path.is_file():
            shown = checks.shown(str(path))
            raise ValueError(f"scenario: {shown}, allowed a YAML file that exists")
        return path
    training = training_names()
    checks.choice("scenario", str(name_or_path), [*scenario_names(), *training])
    folder = ("diagrams", "training") if str(name_or_path) in training else ("diagrams",)
    return resource(*folder, f"{name_or_path}.yaml")

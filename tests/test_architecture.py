"""What the house forbids, held over the import graph and over every function of the package."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "scara_drake"
FILES = sorted(PACKAGE.rglob("*.py"))
STATIONS = {
    "operator",
    "channel",
    "coupling",
    "ik",
    "control",
    "plant",
    "environment",
    "supervision",
}
GROUND = {"joints", "kinematics", "vectors", "cut_state", "safety", "robot", "dynamics", "common"}
LOOK = "display.look"  # colours and scales alone, for whatever draws
LONGEST_FILE, LONGEST_FUNCTION, MOST_PARAMETERS = 300, 60, 8


def module_of(path: Path) -> str:
    """The module's name below the package, such as "ik.solve"; "" for the package itself."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in FILES}


def is_for_types_only(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)


def statements(tree: ast.AST) -> list[ast.AST]:
    """All nodes but those under `if TYPE_CHECKING`, which nobody executes."""
    found = []
    for node in ast.iter_child_nodes(tree):
        if not is_for_types_only(node):
            found += [node, *statements(node)]
    return found


def imports_of(path: Path) -> set[str]:
    """Modules of the package, and other top-level packages, that a file imports anywhere."""
    found = set()
    for node in statements(ast.parse(path.read_text())):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: relative import"
            whole = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [
                name if name.partition(".")[2] in MODULES else str(node.module) for name in whole
            ]
        for name in names:
            top, _, rest = name.partition(".")
            found.add(f"scara_drake.{rest}" if top == "scara_drake" else top)
    return found


IMPORTS = {name: imports_of(path) for name, path in MODULES.items()}
OURS = {
    name: {found.partition(".")[2] for found in imports if found.startswith("scara_drake.")}
    for name, imports in IMPORTS.items()
}


def room(module: str) -> str:
    return module.partition(".")[0]


def edges() -> list[tuple[str, str]]:
    return [(name, found) for name, imports in OURS.items() for found in sorted(imports)]


def test_the_graph_is_read():
    assert len(MODULES) > 100
    assert "common.block" in OURS["operator.haptics"]
    assert "pydrake" in IMPORTS["robot"]


# The controller's own loop has delays; a supervisor knows the arm that it stops, and has the
# operator's bounds in its part of a scenario.
NEIGHBOURS = {("control", "channel"), ("supervision", "ik"), ("supervision", "operator")}


def test_no_station_imports_another_but_for_what_it_stands_on():
    wrong = [
        (name, found)
        for name, found in edges()
        if {room(name), room(found)} <= STATIONS and room(name) != room(found)
    ]
    assert [(n, f) for n, f in wrong if (room(n), room(f)) not in NEIGHBOURS] == []


def test_stations_stand_on_the_ground_floor_only():
    wrong = [
        (name, found)
        for name, found in edges()
        if room(name) in STATIONS and room(found) not in STATIONS | GROUND and found != LOOK
    ]
    assert wrong == []


def test_common_imports_nothing_of_ours():
    assert [edge for edge in edges() if room(edge[0]) == "common" != room(edge[1])] == []


def test_recordings_know_names_not_solvers():
    allowed = GROUND - {"robot", "dynamics"} | {"recordings"}
    wrong = [e for e in edges() if room(e[0]) == "recordings" and room(e[1]) not in allowed]
    assert wrong == []


def test_nothing_imports_the_command_line():
    wrong = [e for e in edges() if room(e[1]) == "cli" and room(e[0]) not in ("cli", "__main__")]
    assert wrong == []


def reachable(module: str) -> set[str]:
    found, waiting = set(), [module]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += OURS[name]
            waiting += [".".join(name.split(".")[:k]) for k in range(1, name.count(".") + 1)]
    return found


def needs_drake(path: Path) -> bool:
    """Whether a module imports Drake when it is imported, not when a function of it runs."""
    body = ast.parse(path.read_text()).body
    top = [node for node in body if isinstance(node, ast.Import | ast.ImportFrom)]
    return any(ast.unparse(node).split()[1].startswith("pydrake") for node in top)


@pytest.mark.parametrize("module", [name for name in MODULES if room(name) == "replay"])
def test_the_replay_never_imports_drake(module):
    assert needs_drake(MODULES["robot"])
    assert [name for name in sorted(reachable(module)) if needs_drake(MODULES[name])] == []


def test_the_station_s_server_never_imports_drake():
    found = reachable("station.server_process")
    assert "station.hub" in found
    assert [name for name in sorted(found) if needs_drake(MODULES[name])] == []


def test_no_test_reaches_into_the_tree_beside_the_package():
    assert [name for name, found in IMPORTS.items() if {"tests", "benchmarks"} & found] == []


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_files_and_functions_stay_small(path):
    text = path.read_text()
    assert text.count("\n") <= LONGEST_FILE
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            assert (node.end_lineno or 0) - node.lineno + 1 <= LONGEST_FUNCTION, node.name
            arguments = node.args
            named = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
            named = [argument for argument in named if argument.arg not in ("self", "cls")]
            assert len(named) <= MOST_PARAMETERS, (node.name, len(named))


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_kinds_of_operator_are_told_apart_in_their_table_only(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "isinstance":
            assert not ast.unparse(node.args[0]).endswith("operator"), node.lineno

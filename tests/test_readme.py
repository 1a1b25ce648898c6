import re
import shlex
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
import yaml

from scara_drake.cli.parser import make_parser
from scara_drake.operator.devices.profiles import load_profile
from scara_drake.replay import player
from scara_drake.scenario import load_scenario, parse_overrides
from scara_drake.studies.runs import Runs
from scara_drake.studies.study import load_study

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "scara_drake"
PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "models" / "README.md",
        ROOT / "examples" / "README.md",
        *(ROOT / "docs").glob("*.md"),
        *(ROOT / "benchmarks" / "results").glob("*.md"),
    ]
)
PROGRAMS = ("scara-drake", "python", "pip", "make", "ruff", "mypy")
# Commands that a page gives for the error they end with.
REFUSED = {"scara-drake run joint_sine --set controller.phi=0.02": "controller: chatters"}


def code_blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


def spans(page):
    """Code within a line."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    return re.findall(r"`([^`\n]+)`", text)


def commands(page):
    """Commands of a page, in blocks and in lines, without the folder of the program."""
    lines = [line for block in code_blocks(page, "sh") for line in block.splitlines()]
    lines += [span for span in spans(page) if " " in span]
    parts = [part.strip().removeprefix(".venv/bin/") for line in lines for part in line.split("&&")]
    found = [part for part in parts if part.partition(" ")[0] in PROGRAMS and "NAME" not in part]
    return list(dict.fromkeys(found))


LISTINGS = [(page, code) for page in PAGES for code in code_blocks(page, "python")]
COMMANDS = [(page, command) for page in PAGES for command in commands(page)]


def names(listings):
    return [f"{page.relative_to(ROOT)}-{index}" for index, (page, _) in enumerate(listings)]


def test_readme_has_listings_and_commands():
    assert sum(page.name == "README.md" for page, _ in LISTINGS) >= 3
    assert sum(page == ROOT / "README.md" for page, _ in COMMANDS) >= 8


@pytest.mark.parametrize(("page", "code"), LISTINGS, ids=names(LISTINGS))
def test_listing_runs_as_printed(page, code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    # dataclasses look their module up, so the namespace is that of a script.
    exec(compile(code, str(page), "exec"), {"__name__": "__main__"})
    plt.close("all")


def try_scara_drake(page, arguments):
    if len(arguments) == 1:  # within a line, the name of a command
        assert arguments[0] in make_parser().format_help()
        return
    options = make_parser().parse_args(arguments)
    if arguments[0] == "replay":
        assert player.play(options) == 2  # it is understood, but there is no such file
    if arguments[0] == "sweep":
        Runs(load_study(options.study)).check()
    if arguments[0] not in ("run", "tune", "attack"):
        return
    if Path(options.scenario).suffix:  # what another command of the page has written
        assert f"--output {options.scenario}" in page.read_text()
        return
    overrides = parse_overrides(options.set)
    refused = REFUSED.get(shlex.join(["scara-drake", *arguments]))
    if refused is None:
        load_scenario(options.scenario, overrides)
    else:
        with pytest.raises(ValueError, match=refused):
            load_scenario(options.scenario, overrides)


def try_python(page, arguments):
    if arguments[0] == "-m" and arguments[1] == "pytest":
        files = [ROOT / each for each in arguments[2:] if each.endswith(".py")]
        for word in arguments[arguments.index("-k") + 1 :] if "-k" in arguments else []:
            assert any(re.search(rf"def test_\w*{word}", file.read_text()) for file in files), word
        assert all(file.is_file() for file in files)
    elif arguments[0] == "-m":
        assert find_spec(arguments[1]) is not None
    else:
        script = ROOT / arguments[0]
        assert script.is_file()
        options = [each for each in arguments[1:] if each.startswith("-")]
        if options:
            told = subprocess.run(
                [sys.executable, str(script), "--help"], capture_output=True, text=True, check=True
            ).stdout
            assert set(options) <= set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", told))


def try_make(page, arguments):
    makefile = (ROOT / "Makefile").read_text()
    for target in arguments:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def try_pip(page, arguments):
    if arguments[1] == "--no-deps":  # without Drake: what else is needed is named beside it
        assert arguments == ["install", "--no-deps", "-e", "."]
        return
    if arguments[1:3] == ["-c", "constraints.txt"] and arguments[3] != "-e":
        known = (ROOT / "constraints.txt").read_text().lower()
        assert all(f"\n{name.lower()}==" in f"\n{known}" for name in arguments[3:])
        return
    assert arguments[:4] == ["install", "-c", "constraints.txt", "-e"]
    assert (ROOT / "constraints.txt").is_file()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    (extras,) = re.findall(r"^\.\[([\w,]+)\]$", arguments[4])
    assert set(extras.split(",")) <= set(project["optional-dependencies"])


def try_checker(page, arguments):
    assert arguments in ([], ["check", "."], ["format", "."])  # as `make lint` has them


TRIED = {
    "scara-drake": try_scara_drake,
    "python": try_python,
    "make": try_make,
    "pip": try_pip,
    "ruff": try_checker,
    "mypy": try_checker,
}


@pytest.mark.parametrize(
    ("page", "command"), COMMANDS, ids=[f"{page.stem}: {command}" for page, command in COMMANDS]
)
def test_command_is_understood(page, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program, *arguments = shlex.split(command)
    TRIED[program](page, arguments)


def test_commands_of_every_kind_are_found():
    assert {command.partition(" ")[0] for _, command in COMMANDS} == set(PROGRAMS)
    pages = {page.name for page, _ in COMMANDS}
    assert {"CONTRIBUTING.md", "bilateral.md", "control.md", "architecture.md"} <= pages


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_are_named_exist(page):
    for span in spans(page):
        if re.fullmatch(r"[a-z_]+/[\w/]*(\.(py|md|yaml|txt))?", span) and "NAME" not in span:
            assert any((folder / span).exists() for folder in (ROOT, PACKAGE)), span


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_name_stands_in_the_file_that_is_said_to_have_it(page):
    said = re.findall(r"`(\w+)`,? (?:in|of) `([\w/]+\.py)`", page.read_text())
    for name, file in said:
        text = next(f for f in (ROOT / file, PACKAGE / file) if f.exists()).read_text()
        assert re.search(rf"^ *(class |def )?{name}\b", text, re.MULTILINE), (name, file)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_exist(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if not re.match(r"[a-z]+:|#", link):
            assert (page.parent / link.split("#")[0]).exists(), link


def test_every_dependency_is_explained():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = chain(project["dependencies"], *project["optional-dependencies"].values())
    names = {re.findall(r"^[\w-]+", line)[0] for line in wanted} - {"scara-drake"}
    page = (ROOT / "docs" / "dependencies.md").read_text()
    packages = " ".join(re.findall(r"^\| (.+?) \|", page, re.MULTILINE))
    assert names <= set(re.findall(r"[\w-]+", packages))


def test_paper_is_the_one_that_is_cited():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    readme = (ROOT / "README.md").read_text()
    for reference in citation["references"]:
        assert f'"{reference["title"]}", {reference["journal"]}, {reference["year"]}' in readme


def test_the_rooms_of_the_house_hold_what_its_table_says():
    page = (ROOT / "docs" / "architecture.md").read_text()
    rows = re.findall(r"^\| `([a-z_]+)/`(?:, `([a-z_]+)/`)? \| (.*) \|$", page, re.MULTILINE)
    assert len(rows) > 12
    for first, second, held in rows:
        for name in re.findall(r"`([a-z_]+)`", held):
            places = [PACKAGE / room / name for room in (first, second) if room]
            assert any(p.is_dir() or p.with_suffix(".py").is_file() for p in places), (first, name)


def test_scenario_of_every_yaml_block_is_read(tmp_path):
    for page in PAGES:
        for block in code_blocks(page, "yaml"):
            if block.startswith("scenario:"):
                file = tmp_path / "study.yaml"
                file.write_text(block)
                Runs(load_study(file)).check()
                continue
            if block.startswith("layout:"):
                file = tmp_path / "profile.yaml"
                file.write_text(block)
                load_profile(str(file))
                continue
            for line in block.splitlines():  # each a choice
                file = tmp_path / "choice.yaml"
                file.write_text(line)
                load_scenario(file)

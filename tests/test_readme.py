import re
import shlex
import tomllib
from itertools import chain
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
import yaml

from scara_drake.cli.parser import make_parser
from scara_drake.scenario import load_scenario

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", ROOT / "models" / "README.md", *(ROOT / "docs").glob("*.md")])


def code_blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


LISTINGS = [(page, code) for page in PAGES for code in code_blocks(page, "python")]
COMMANDS = [
    line
    for block in code_blocks(ROOT / "README.md", "sh")
    for line in block.splitlines()
    if "scara-drake" in line
]


def names(listings):
    return [f"{page.relative_to(ROOT)}-{index}" for index, (page, _) in enumerate(listings)]


def test_readme_has_listings_and_commands():
    assert sum(page.name == "README.md" for page, _ in LISTINGS) >= 3
    assert len(COMMANDS) >= 3


@pytest.mark.parametrize(("page", "code"), LISTINGS, ids=names(LISTINGS))
def test_listing_runs_as_printed(page, code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    # dataclasses look their module up, so the namespace is that of a script.
    exec(compile(code, str(page), "exec"), {"__name__": "__main__"})
    plt.close("all")


@pytest.mark.parametrize("command", COMMANDS)
def test_command_is_understood(command):
    program, *arguments = shlex.split(command)
    assert program == ".venv/bin/scara-drake"
    options = make_parser().parse_args(arguments)
    if arguments[0] == "run":
        load_scenario(options.scenario, dict(pair.split("=") for pair in options.set))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_exist(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if not re.match(r"[a-z]+:|#", link):
            assert (page.parent / link.split("#")[0]).exists(), link


def test_make_targets_of_the_readme_exist():
    makefile = (ROOT / "Makefile").read_text()
    for target in set(re.findall(r"make (\w+)", (ROOT / "README.md").read_text())) - {"and"}:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


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

"""The site is built once, strictly, and read as a browser would without a network."""

from __future__ import annotations

import argparse
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import make_cli_reference
import make_site
import pytest
from latex2mathml.converter import convert

from scara_drake.cli.parser import make_parser

ROOT = Path(__file__).parents[1]
LOADED = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href"}
WITHIN = re.compile("data:|about:blank$")
FORM = "search.html"  # not linked to: the field on each page sends to it
AS_PRINTED = {"code", "pre", "script", "style", "math", "svg"}


@dataclass
class Page(HTMLParser):
    """What a page refers to, and what it says outside code and equations."""

    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)
    text: list[str] = field(default_factory=list)
    equations: int = 0
    depth: int = 0  # of elements that are shown as they were written

    def __post_init__(self) -> None:
        HTMLParser.__init__(self)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attributes}
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if tag in LOADED and LOADED[tag] in found:
            self.loaded.append(found[LOADED[tag]])
        self.equations += tag == "math"
        if tag in AS_PRINTED:
            self.depth += 1

    def handle_endtag(self, tag: str) -> None:
        if tag in AS_PRINTED:
            self.depth -= 1

    def handle_data(self, data: str) -> None:
        if self.depth == 0:
            self.text.append(data)


@dataclass(frozen=True)
class Site:
    folder: Path
    pages: dict[Path, Page]

    def target(self, page: Path, link: str) -> tuple[Path, str]:
        """File and anchor that a link of a page leads to."""
        path, _, anchor = unquote(link).partition("#")
        return ((page.parent / path).resolve() if path else page), anchor


def read(path: Path) -> Page:
    page = Page()
    page.feed(path.read_text())
    return page


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site").resolve()
    html = folder / "html"
    # In a process of its own, as it reads the kernels without compiling them.
    built = subprocess.run(
        [
            sys.executable,
            make_site.__file__,
            "--source",
            str(folder / "source"),
            "--site",
            str(html),
        ],
        capture_output=True,
        text=True,
    )
    assert built.returncode == 0, built.stderr  # no warning either
    return Site(html, {path: read(path) for path in html.rglob("*.html")})


def is_outside(link):
    return re.match(r"[a-z]+:|//", link) is not None


def test_every_link_leads_somewhere(site):
    broken = []
    for path, page in site.pages.items():
        for link in page.links:
            if is_outside(link):
                continue
            target, anchor = site.target(path, link)
            there = target.is_file() and (
                not anchor or target not in site.pages or anchor in site.pages[target].anchors
            )
            if not there:
                broken.append(f"{path.relative_to(site.folder)}: {link}")
    assert broken == []


def test_nothing_is_loaded_from_another_host(site):
    loaded = {link for page in site.pages.values() for link in page.loaded}
    assert [link for link in loaded if is_outside(link) and not WITHIN.match(link)] == []
    for path in site.folder.rglob("*.css"):
        assert re.findall(r"(?:url\(|@import )[\"']?(?:https?:)?//[^)]*", path.read_text()) == []


def test_what_is_loaded_is_there(site):
    for path, page in site.pages.items():
        for link in page.loaded:
            if not is_outside(link):
                target, _ = site.target(path, link.partition("?")[0])
                assert target.is_file(), (path, link)


def test_every_page_is_reached_from_the_first(site):
    first = site.folder / "index.html"
    reached, waiting = {first}, [first]
    while waiting:
        path = waiting.pop()
        for link in site.pages[path].links:
            target, _ = site.target(path, link)
            if not is_outside(link) and target in site.pages and target not in reached:
                reached.add(target)
                waiting.append(target)
    missed = {path.relative_to(site.folder).as_posix() for path in site.pages.keys() - reached}
    assert missed == {FORM}


def test_every_page_and_notebook_of_the_repository_is_there(site):
    for file in make_site.pages():
        page = (site.folder / make_site.place(file)).with_suffix(".html")
        assert page in site.pages, file


def test_equations_are_set(site):
    for path, page in site.pages.items():
        if "source" in path.relative_to(site.folder).parts:
            continue
        raw = re.findall(r"\$[^$\n]+\$|\\[a-zA-Z]+|:math:", "".join(page.text))
        assert raw == [], path
    for name in ("api_controllers", "api_couplings", "api_contact", "contact", "passivity"):
        assert site.pages[site.folder / f"{name}.html"].equations > 2, name


def test_no_command_of_an_equation_is_left(site):
    for path in site.pages:
        for equation in re.findall(r"<math .*?</math>", path.read_text(), re.DOTALL):
            assert "\\" not in equation, path
    assert "\\" in convert(r"\unknown")  # so that one would be seen


def test_the_site_can_be_searched(site):
    index = (site.folder / "searchindex.js").read_text()
    for word in ("passiv", "chatter", "symbols", "api_controllers"):
        assert word in index
    assert (site.folder / "search.html") in site.pages


def test_the_reference_has_what_users_type(site):
    import scara_drake as sd

    pages = [page for path, page in site.pages.items() if path.name.startswith("api")]
    told = set().union(*(page.anchors for page in pages))
    modules = {"ik", "kinematics", "metrics", "plotting", "__version__", "Scenario"}
    for name in set(sd.__all__) - modules:
        assert f"scara_drake.{name}" in told, name
    for module in ("kinematics", "plotting", "stability.lyapunov"):
        assert f"module-scara_drake.{module}" in told, module


def test_the_reference_has_every_system_with_its_ports(site):
    from scara_drake import systems

    text = (site.folder / "api_systems.html").read_text()
    for name in systems.__all__:
        assert f'<span class="pre">{name}</span>' in text, name


def test_links_lead_to_the_same_on_the_site(tmp_path):
    page = ROOT / "docs" / "faq.md"
    wanted: list[Path] = []
    text = (
        "[a](contact.md#the-law) [b](../README.md) [c](../examples) [d](../examples/step_loop.py)"
    )
    text += " [e](https://drake.mit.edu) ![f](../diagrams/bilateral.svg) [g](#here)\n"
    text += "```\n[a](../README.md)\n```\n"
    expected = "[a](contact.md#the-law) [b](readme.md) [c](examples.md)"
    expected += " [d](source/examples/step_loop.py.md) [e](https://drake.mit.edu)"
    expected += " ![f](diagrams/bilateral.svg) [g](#here)\n```\n[a](../README.md)\n```\n"
    assert make_site.relinked(text, page, wanted) == expected
    assert ROOT / "examples" / "step_loop.py" in wanted


def test_only_a_folder_of_its_own_is_laid_out(tmp_path):
    other = tmp_path / "docs"
    other.mkdir()
    (other / "thesis.md").write_text("mine")
    for wrong in (other, other / "thesis.md"):
        with pytest.raises(ValueError, match=r"^--source: .*, allowed a folder that is new, "):
            make_site.lay_out(wrong)
    assert [file.name for file in other.iterdir()] == ["thesis.md"]
    own = tmp_path / "own"
    make_site.lay_out(own)
    (own / "gone.md").write_text("a page that is no more")
    make_site.lay_out(own)
    assert not (own / "gone.md").exists()
    assert (own / "index.md").exists()


def test_the_command_line_page_is_that_of_the_parser():
    assert make_cli_reference.PAGE.read_text() == make_cli_reference.page(), (
        "run python docs/make_cli_reference.py"
    )


def test_the_command_line_page_has_every_command_and_option():
    text = make_cli_reference.PAGE.read_text()
    names = []
    for name, _, parser in make_cli_reference.commands():
        names.append(name)
        section = text.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        for action in make_cli_reference.actions(parser):
            assert all(f"{option}" in section for option in action.option_strings), (name, action)
        if parser.epilog:
            lines = [line.strip() for line in parser.epilog.splitlines()]
            for line in lines:
                if line.startswith("scara-drake "):
                    make_parser().parse_args(shlex.split(line)[1:])
    (group,) = [a for a in make_parser()._actions if isinstance(a, argparse._SubParsersAction)]
    assert names == list(group.choices)

"""Builds the site: ``python docs/make_site.py`` writes build/site/, to be opened from a file.

The pages stay where they are in the repository, and their links lead to files of the repository.
Here they are laid out flat in build/site_source/, each link rewritten to where its target stands on
the site: a page, a notebook, a picture, or a page that shows the file. Sphinx makes the site of it,
with warnings as errors.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
SOURCE: Final = ROOT / "build" / "site_source"
SITE: Final = ROOT / "build" / "site"
EXECUTED: Final = ROOT / "build" / "notebooks"
MARK: Final = ".laid_out"  # in a folder that was laid out, whose other files may be removed

# Pages that do not stand in docs/, and their names on the site.
OUTSIDE: Final = {
    "README.md": "readme.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "models/README.md": "model.md",
    "examples/README.md": "examples.md",
}
PICTURES: Final = (".png", ".svg", ".jpg", ".gif")
LANGUAGES: Final = {
    ".py": "python",
    ".yaml": "yaml",
    ".cff": "yaml",
    ".urdf": "xml",
    ".xml": "xml",
    ".csv": "text",
}
LINK: Final = re.compile(r"(?<=\]\()(?![a-z]+:|#)([^)#\s]+)(#[^)\s]*)?(?=\))")
INCLUDED: Final = re.compile(r"(?<=^```{literalinclude} )\S+", re.MULTILINE)
FENCE: Final = re.compile(r"^(```+|~~~+|:::+).*?^\1$", re.MULTILINE | re.DOTALL)


def place(file: Path) -> str:
    """Return where a file or folder of the repository stands on the site, from its top."""
    name = file.relative_to(ROOT).as_posix()
    if name in OUTSIDE:
        return OUTSIDE[name]
    if f"{name}/README.md" in OUTSIDE:
        return OUTSIDE[f"{name}/README.md"]
    if file.suffix in PICTURES or file.suffix == ".md":
        return name.removeprefix("docs/")
    if file.suffix == ".ipynb":
        return f"tutorials/{file.name}"
    return f"source/{name}.md"


def relinked(text: str, page: Path, wanted: list[Path], folder: Path = SOURCE) -> str:
    """Return the text of a page with its links as they are on the site.

    Args:
        text: Markdown.
        page: its file in the repository.
        wanted: is added the files that it links to.
        folder: of the sources of the site.
    """
    here = Path(place(page)).parent

    def link(match: re.Match[str]) -> str:
        target = Path(os.path.normpath(page.parent / match[1]))
        if not target.exists():
            return match[0]  # Sphinx says so
        wanted.append(target)
        return os.path.relpath(place(target), here) + (match[2] or "")

    def include(match: re.Match[str]) -> str:
        return os.path.relpath(page.parent / match[0], folder / here)

    text = INCLUDED.sub(include, text)
    parts, end = [], 0
    for fence in FENCE.finditer(text):
        parts += [LINK.sub(link, text[end : fence.start()]), fence[0]]
        end = fence.end()
    return "".join([*parts, LINK.sub(link, text[end:])])


def shown(file: Path) -> str:
    """Return a page that shows a file, or what is in a folder."""
    name = file.relative_to(ROOT).as_posix()
    head = f"---\norphan: true\n---\n\n# {name}\n\n"
    if file.is_dir():
        files = sorted(f for f in file.iterdir() if f.is_file() and f.suffix != ".svg")
        return head + "".join(f"- [{f.name}]({os.path.relpath(f, file)})\n" for f in files)
    fence = "````"
    return f"{head}{fence}{LANGUAGES.get(file.suffix, 'text')}\n{file.read_text()}\n{fence}\n"


def pages() -> Iterator[Path]:
    """Yield the pages that are on the site whether or not another links to them."""
    yield from sorted((ROOT / "docs").glob("*.md"))
    yield from sorted((ROOT / "notebooks").glob("*.ipynb"))
    yield from (ROOT / name for name in OUTSIDE)


def content(file: Path, wanted: list[Path], folder: Path) -> bytes:
    """Return what stands on the site for a file, and add to `wanted` what it links to."""
    if file.suffix in PICTURES:
        return file.read_bytes()
    if file.suffix == ".ipynb":
        executed = EXECUTED / file.name
        notebook = json.loads((executed if executed.exists() else file).read_text())
        for cell in notebook["cells"]:
            if cell["cell_type"] == "markdown":
                cell["source"] = relinked("".join(cell["source"]), file, wanted, folder)
        return json.dumps(notebook).encode()
    if file.suffix == ".md":
        return relinked(file.read_text(), file, wanted, folder).encode()
    # A folder's links start in it.
    base = file / "README.md" if file.is_dir() else file
    text = shown(file)
    return (relinked(text, base, wanted, folder) if file.is_dir() else text).encode()


def check_own(folder: Path) -> None:
    """Accept a folder that is new, empty, or was laid out: what else is in it is removed.

    Raises:
        ValueError: otherwise.
    """
    own = folder == SOURCE or (folder / MARK).exists()
    if folder.exists() and not own and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"--source: {folder}, allowed a folder that is new, empty or its own")


def lay_out(folder: Path = SOURCE) -> None:
    """Write the sources of the site, those that have changed, and remove what is no more.

    Raises:
        ValueError: the folder has other files, which would be removed.
    """
    check_own(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / MARK).touch()
    wanted, kept = list(pages()), {folder / MARK}
    while wanted:
        file = wanted.pop()
        target = folder / place(file)
        if target in kept:
            continue
        kept.add(target)
        data = content(file, wanted, folder)
        if not target.exists() or target.read_bytes() != data:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
    for file in [f for f in folder.rglob("*") if f.is_file() and f not in kept]:
        file.unlink()


def build(source: Path = SOURCE, site: Path = SITE) -> int:
    """Build the site, two pages at a time, and return the exit status."""
    from sphinx.cmd.build import main

    lay_out(source)
    settings = ["-c", str(ROOT / "docs"), "-d", str(source.with_name(source.name + "_trees"))]
    strict = ["-b", "html", "-W", "--keep-going", "-n", "-q", "-j", "2"]
    return main([*strict, *settings, str(source), str(site)])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Build the site.")
    parser.add_argument("--source", type=Path, default=SOURCE, help="where its pages are laid out")
    parser.add_argument("--site", type=Path, default=SITE, help="where it is written")
    options = parser.parse_args()
    try:
        check_own(options.source)
    except ValueError as error:
        parser.error(str(error))
    sys.exit(build(options.source, options.site))

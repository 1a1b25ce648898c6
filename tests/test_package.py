"""Wheel and source distribution: what is in them, and that they run away from the checkout."""

from __future__ import annotations

import email
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from email.message import Message
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

import scara_drake

CHECKOUT = Path(__file__).parents[1]
SETTINGS = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())
PROJECT = SETTINGS["project"]
# Beside the package in a checkout, inside it in a wheel.
SHIPPED = SETTINGS["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
MOST = 6e6  # [B] of each file


def build(root: Path, where: Path, *kinds: str) -> None:
    """Build distributions of a tree as `python -m build` does, without its environment."""
    targets = [word for kind in kinds for word in ("--target", kind)]
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(where), *targets]
    subprocess.run(command, cwd=root, check=True, capture_output=True)


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    """The folder with wheel and source distribution of the checkout."""
    where = tmp_path_factory.mktemp("dist")
    build(CHECKOUT, where, "sdist", "wheel")
    return where


@pytest.fixture(scope="module")
def unpacked(built) -> Path:
    """The tree of the source distribution."""
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as tar:
        tar.extractall(built / "sdist", filter="data")
    (root,) = (built / "sdist").iterdir()
    return root


def files(wheel_or_folder: Path) -> dict[str, bytes]:
    """What is in a folder that holds one wheel, by name."""
    (path,) = wheel_or_folder.glob("*.whl")
    with zipfile.ZipFile(path) as wheel:
        return {name: wheel.read(name) for name in wheel.namelist()}


def metadata(built: Path) -> Message:
    (text,) = (data for name, data in files(built).items() if name.endswith("/METADATA"))
    return email.message_from_string(text.decode())


def in_checkout() -> dict[str, bytes]:
    """What the wheel has to hold, by name."""
    expected = {}
    for source, target in {"scara_drake": "scara_drake", **SHIPPED}.items():
        root = CHECKOUT / source
        for path in root.rglob("*") if root.is_dir() else (root,):
            if path.is_file() and "__pycache__" not in path.parts:
                name = (Path(target) / path.relative_to(root)).as_posix()
                expected[name] = path.read_bytes()
    return expected


def test_the_wheel_has_the_package_and_what_is_shipped_and_nothing_else(built):
    found = files(built)
    package = {name: data for name, data in found.items() if ".dist-info/" not in name}
    expected = in_checkout()
    assert sorted(package) == sorted(expected)
    assert package == expected
    for data in ("models/scara6.urdf", "station/page/index.html", "profiles/xbox.yaml", "py.typed"):
        assert f"scara_drake/{data}" in found


def test_the_source_distribution_builds_the_same_wheel(built, unpacked, tmp_path):
    build(unpacked, tmp_path, "wheel")
    assert files(tmp_path) == files(built)


def test_the_source_distribution_has_what_is_kept_and_nothing_that_is_made(unpacked):
    top = {path.name for path in unpacked.iterdir()}
    assert {"LICENSE", "README.md", "constraints.txt", "tests", "scara_drake"} <= top
    made = {"runs", "build", "dist", ".venv", ".git", "__pycache__", ".pytest_cache", ".hypothesis"}
    names = {part for path in unpacked.rglob("*") for part in path.relative_to(unpacked).parts}
    assert names & made == set()
    assert [name for name in names if name.endswith((".pyc", ".nbi", ".nbc", ".nc"))] == []


def test_both_are_small(built):
    sizes = {path.name: path.stat().st_size for path in built.iterdir() if path.is_file()}
    assert len(sizes) == 2
    assert max(sizes.values()) < MOST


def test_the_metadata_is_that_of_the_project(built):
    told = metadata(built)
    assert (told["Name"], told["Version"]) == (PROJECT["name"], PROJECT["version"])
    assert told["License-Expression"] == "BSD-3-Clause"
    assert told["License-File"] == "LICENSE"
    assert any(name.endswith("/licenses/LICENSE") for name in files(built))
    assert set(told.get_all("Provides-Extra", [])) == set(PROJECT["optional-dependencies"])
    needed = [each for each in told.get_all("Requires-Dist", []) if "extra ==" not in each]
    assert len(needed) == len(PROJECT["dependencies"])
    assert all("@" not in each for each in told.get_all("Requires-Dist", []))


def test_the_readme_of_the_package_has_no_link_into_a_checkout(built):
    told = metadata(built)
    assert told["Description-Content-Type"] == "text/markdown"
    text = told.get_payload()
    assert isinstance(text, str)
    parts = [part for block in MarkdownIt().parse(text) for part in block.children or ()]
    targets = [part.attrs.get("href", part.attrs.get("src")) for part in parts if part.attrs]
    assert targets
    assert [target for target in targets if not str(target).startswith("https://")] == []
    assert "\n!" not in text  # nor what is left of a picture
    assert listings(text) == listings((CHECKOUT / "README.md").read_text())


def listings(markdown: str) -> list[str]:
    return [token.content for token in MarkdownIt().parse(markdown) if token.type == "fence"]


@pytest.fixture(scope="module")
def environment(built, tmp_path_factory) -> Path:
    """An environment with the wheel alone, which borrows what it needs from that of the tests."""
    root = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", root], check=True)
    (wheel,) = built.glob("*.whl")
    pip = [sys.executable, "-m", "pip", "--python", str(root), "--disable-pip-version-check"]
    install = ["install", "--quiet", "--no-deps", "--no-index", "--no-compile", str(wheel)]
    subprocess.run([*pip, *install], check=True)
    (site,) = root.glob("lib/python*/site-packages")
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    run(root, root, "--help")  # begins the cache of compiled kernels
    borrow_kernels(site / "scara_drake")
    return root


def borrow_kernels(package: Path) -> None:
    """Copy the kernels that the checkout has compiled, as compiling them takes minutes."""
    own = Path(scara_drake.__file__).parent
    for kernel in own.rglob("*.nb[ci]"):
        where = package / kernel.relative_to(own)
        where.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(kernel, where)


def clean() -> dict[str, str]:
    """The variables of this process that say nothing to Python."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}


def run(environment: Path, where: Path, *arguments: str) -> str:
    """Run the command of the environment in a folder; return what it printed."""
    command = [str(environment / "bin" / "scara-drake"), *arguments]
    done = subprocess.run(
        command, cwd=where, env=clean(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_an_installed_command_works_away_from_the_checkout(environment, tmp_path):
    python, code = environment / "bin" / "python", "import scara_drake; print(scara_drake.__file__)"
    asked = [python, "-P", "-c", code]
    where = subprocess.check_output(asked, cwd=tmp_path, env=clean(), text=True)
    assert Path(where).is_relative_to(environment)
    target = ("--position", "1.2", "-0.4", "3", "--rpy", "90", "0", "20", "--angle", "deg")
    (found,) = json.loads(run(environment, tmp_path, "ik", *target, "--json"))["poses"]
    assert found["position"] == [1.2, -0.4, 3.0]
    assert all(-10.0 < q < 10.0 for q in found["answers"][0]["q"])
    quick = ("--duration", "0.2", "--no-realtime", "--no-meshcat")
    assert "arm followed" in run(environment, tmp_path, "run", "joint_sine", *quick)
    assert [path.name for path in tmp_path.rglob("*.nc")] == ["joint_sine.nc"]

import os
import subprocess
import sys
from pathlib import Path

from scara_drake.common.kernel_cache import (
    cache_folder,
    prepare_kernel_cache,
    remove_stale_kernels,
    with_importers,
)

ROOT = Path(__file__).parents[1]
INNER = "from numba import njit\n\n@njit(cache=True)\ndef inner():\n    return {value}\n"
OUTER = (
    "from numba import njit\nfrom kernels.deep.inner import inner\n\n"
    "@njit(cache=True)\ndef outer():\n    return inner() + 1\n"
)
OTHER = "from numba import njit\n\n@njit(cache=True)\ndef other():\n    return 7\n"
RUN = (
    "from pathlib import Path\nfrom scara_drake.common.kernel_cache import *\n"
    "{call}\nimport kernels.outer, kernels.other\n"
    "print(kernels.outer.outer(), kernels.other.other(),"
    " sum(kernels.other.other.stats.cache_hits.values()))"
)


def make_package(folder, value):
    package = folder / "kernels"
    (package / "deep").mkdir(parents=True, exist_ok=True)
    (package / "__init__.py").touch()
    (package / "deep" / "__init__.py").touch()
    (package / "outer.py").write_text(OUTER)
    (package / "other.py").write_text(OTHER)
    write_inner(package, value)
    return package


def write_inner(package, value):
    (package / "deep" / "inner.py").write_text(INNER.format(value=value))


def run(folder, call="remove_stale_kernels(Path('kernels'))", **variables):
    environment = {**os.environ, "PYTHONPATH": f"{folder}:{ROOT}", "NUMBA_CACHE_DIR": ""}
    environment |= {"PYTHONDONTWRITEBYTECODE": "1", **variables}
    command = [sys.executable, "-c", RUN.format(call=call)]
    result = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True
    )
    return [int(number) for number in result.stdout.split()]


def test_a_change_in_a_called_kernel_reaches_its_callers_and_no_one_else(tmp_path):
    package = make_package(tmp_path, 1)
    assert run(tmp_path) == [2, 7, 0]
    assert run(tmp_path) == [2, 7, 1]
    write_inner(package, 10)
    assert run(tmp_path, call="") == [2, 7, 1], "numba sees it by itself: this module can go"
    assert run(tmp_path) == [11, 7, 1]


def test_importers_are_found_through_modules_between(tmp_path):
    package = make_package(tmp_path, 1)
    (package / "top.py").write_text("import kernels.outer\n")
    sources = {p.relative_to(package).as_posix(): p for p in package.rglob("*.py")}
    found = with_importers(package, sources, {"deep/inner.py"})
    assert found == {"deep/inner.py", "outer.py", "top.py"}


def test_what_cannot_be_written_is_left_alone(tmp_path):
    package = make_package(tmp_path, 1)
    (package / "__pycache__").write_text("not a folder")
    remove_stale_kernels(package)
    assert (package / "__pycache__").read_text() == "not a folder"


PREPARE = "prepare_kernel_cache(Path('kernels').resolve())"


def lock(package):
    """Let nothing be written beside the sources; root may write what is only read-only."""
    for folder in (package, package / "deep"):
        (folder / "__pycache__").write_text("not a folder")


def test_on_a_read_only_mount_the_kernels_are_in_the_user_s_cache_and_stale_ones_are_noticed(
    tmp_path,
):
    package = make_package(tmp_path / "code", 1)
    lock(package)
    home = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert run(tmp_path / "code", PREPARE, **home) == [2, 7, 0]
    assert run(tmp_path / "code", PREPARE, **home) == [2, 7, 1]
    assert list((tmp_path / "cache").glob("scara_drake_*/*/*.nbc"))
    write_inner(package, 10)
    assert run(tmp_path / "code", PREPARE, **home) == [11, 7, 1]


def test_without_a_home_the_kernels_are_in_a_temporary_folder(tmp_path):
    package = make_package(tmp_path / "code", 1)
    lock(package)
    nowhere = tmp_path / "file"
    nowhere.touch()
    (tmp_path / "tmp").mkdir()
    variables = {
        "XDG_CACHE_HOME": str(nowhere / "cache"),
        "HOME": str(nowhere),
        "TMPDIR": str(tmp_path / "tmp"),
    }
    assert run(tmp_path / "code", PREPARE, **variables) == [2, 7, 0]
    assert run(tmp_path / "code", PREPARE, **variables) == [2, 7, 1]
    write_inner(package, 10)
    assert run(tmp_path / "code", PREPARE, **variables) == [11, 7, 1]


def test_a_folder_that_the_user_named_stays_and_stale_kernels_are_noticed_there(tmp_path):
    package = make_package(tmp_path / "code", 1)
    named = {"NUMBA_CACHE_DIR": str(tmp_path / "named")}
    assert run(tmp_path / "code", PREPARE, **named) == [2, 7, 0]
    write_inner(package, 10)
    assert run(tmp_path / "code", PREPARE, **named) == [11, 7, 1]
    assert list((tmp_path / "named").glob("*/*.nbc"))


def test_a_folder_that_others_could_have_filled_is_not_taken(tmp_path, monkeypatch):
    package = make_package(tmp_path / "code", 1)
    lock(package)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    own = cache_folder(package)
    assert own is not None
    assert own.parent == tmp_path / "cache"
    own.chmod(0o777)
    other = cache_folder(package)
    assert other is not None
    assert other.parent != tmp_path / "cache"


def test_a_package_that_can_be_written_keeps_its_kernels_beside_its_sources(tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    package = make_package(tmp_path, 1)
    assert cache_folder(package) is None
    prepare_kernel_cache(package)
    assert (package / "__pycache__" / "kernels.json").is_file()

import os
import subprocess
import sys
from pathlib import Path

from scara_drake.common.kernel_cache import remove_stale_kernels, with_importers

ROOT = Path(__file__).parents[1]
INNER = "from numba import njit\n\n@njit(cache=True)\ndef inner():\n    return {value}\n"
OUTER = (
    "from numba import njit\nfrom kernels.deep.inner import inner\n\n"
    "@njit(cache=True)\ndef outer():\n    return inner() + 1\n"
)
OTHER = "from numba import njit\n\n@njit(cache=True)\ndef other():\n    return 7\n"
RUN = (
    "from pathlib import Path\nfrom scara_drake.common.kernel_cache import remove_stale_kernels\n"
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


def run(folder, call="remove_stale_kernels(Path('kernels'))"):
    environment = {**os.environ, "PYTHONPATH": f"{folder}:{ROOT}", "NUMBA_CACHE_DIR": ""}
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

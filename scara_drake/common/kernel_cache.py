"""Keeps the cache of compiled kernels true, and where it can be written.

numba compiles a kernel anew when its own file has changed, but not when that of a kernel which it
calls has: after an edit or an upgrade a stale machine code would run. So when files of a package
have changed, the cached kernels of all modules that import them, directly or not, are removed.

numba keeps its cache beside the sources. Where that cannot be written, as on a read-only mount, it
is a folder of our own in the user's cache, or else a temporary one.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import json
import os
import stat
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from scara_drake.common.files import write_whole

CACHE_VARIABLE = "NUMBA_CACHE_DIR"


def prepare_kernel_cache(package: Path) -> None:
    """Choose where numba keeps the kernels of a package, and remove the stale ones there.

    To be called before any kernel is loaded. A folder that the user has named to numba stays.

    Args:
        package: its folder.
    """
    cache = cache_folder(package)
    if cache is not None:
        os.environ[CACHE_VARIABLE] = str(cache)  # for this process and its children
        if "numba" in sys.modules:
            sys.modules["numba"].config.CACHE_DIR = str(cache)
    remove_stale_kernels(package, cache)


def cache_folder(package: Path) -> Path | None:
    """Return the folder for the kernels of a package; None is beside its sources."""
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named)
    if _is_writable(package / "__pycache__"):
        return None
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    for folder in (Path(home), Path(tempfile.gettempdir())):
        own = folder / f"scara_drake_{_user()}"
        # Kernels are code: a folder that somebody else could have filled is not taken.
        if folder.is_absolute() and _is_writable(own) and _is_ours(own):
            return own
    return Path(tempfile.mkdtemp(prefix="scara_drake_"))


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else "user"


def _is_ours(folder: Path) -> bool:
    state = folder.stat()
    if not hasattr(os, "getuid"):
        return True
    return state.st_uid == os.getuid() and not state.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _is_writable(folder: Path) -> bool:
    """Whether files can be made in a folder, which is made if it is not there."""
    try:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def remove_stale_kernels(package: Path, cache: Path | None = None) -> None:
    """Remove the cached kernels of a package whose sources, or those of their callees, changed.

    It remembers size and time of the sources in ``kernels.json``. Where that cannot be written
    nothing is done.

    Args:
        package: its folder.
        cache: where its kernels are; None is in ``__pycache__``, beside each source.
    """
    sources = {path.relative_to(package).as_posix(): path for path in package.rglob("*.py")}
    stamps = {
        name: [state.st_mtime_ns, state.st_size]
        for name, state in ((name, path.stat()) for name, path in sources.items())
    }
    index = package / "__pycache__" / "kernels.json"
    if cache is not None:
        place = hashlib.sha256(str(package.resolve()).encode()).hexdigest()[:8]
        index = cache / f"kernels_{place}.json"
    known: dict[str, list[int]] = {}
    with contextlib.suppress(OSError, ValueError):
        known = json.loads(index.read_text())
    if stamps == known:
        return
    changed = {name for name in stamps if stamps[name] != known.get(name)}
    with contextlib.suppress(OSError):
        for name in with_importers(package, sources, changed):
            path = sources[name]
            pattern = f"{path.stem}.*.nb[ci]"
            if cache is None:
                kernels = (path.parent / "__pycache__").glob(pattern)
            else:  # numba names the folders there after those of the sources, and a digest
                kernels = cache.glob(f"{path.resolve().parent.name}_*/{pattern}")
            for kernel in list(kernels):
                kernel.unlink(missing_ok=True)
        index.parent.mkdir(parents=True, exist_ok=True)
        write_whole(index, json.dumps(stamps))


def with_importers(package: Path, sources: dict[str, Path], changed: Iterable[str]) -> set[str]:
    """Return the changed files and all that import them, directly or not, by relative name."""
    importers: dict[str, set[str]] = {name: set() for name in sources}
    for name, path in sources.items():
        for module in _imports(ast.parse(path.read_bytes())):
            parts = module.split(".")
            if parts[0] != package.name:
                continue
            for imported in ("/".join(parts[1:]) + ".py", "/".join([*parts[1:], "__init__.py"])):
                if imported in importers:
                    importers[imported].add(name)
    found, waiting = set(), list(changed)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting.extend(importers[name])
    return found


def _imports(tree: ast.Module) -> Iterable[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)

"""Keeps the cache of compiled kernels true.

numba compiles a kernel anew when its own file has changed, but not when that of a kernel which it
calls has: after an edit or an upgrade a stale machine code would run. So when files of a package
have changed, the cached kernels of all modules that import them, directly or not, are removed.
"""

from __future__ import annotations

import ast
import contextlib
import json
from collections.abc import Iterable
from pathlib import Path

from scara_drake.common.files import write_whole


def remove_stale_kernels(package: Path) -> None:
    """Remove the cached kernels of a package whose sources, or those of their callees, changed.

    It remembers size and time of the sources in ``__pycache__/kernels.json``. Where that cannot be
    written, as in a folder of the system, nothing is done: numba keeps its cache elsewhere then.

    Args:
        package: its folder.
    """
    sources = {path.relative_to(package).as_posix(): path for path in package.rglob("*.py")}
    stamps = {
        name: [stat.st_mtime_ns, stat.st_size]
        for name, stat in ((name, path.stat()) for name, path in sources.items())
    }
    index = package / "__pycache__" / "kernels.json"
    known: dict[str, list[int]] = {}
    with contextlib.suppress(OSError, ValueError):
        known = json.loads(index.read_text())
    if stamps == known:
        return
    changed = {name for name in stamps if stamps[name] != known.get(name)}
    with contextlib.suppress(OSError):
        for name in with_importers(package, sources, changed):
            path = sources[name]
            for cached in (path.parent / "__pycache__").glob(f"{path.stem}.*.nb[ci]"):
                cached.unlink(missing_ok=True)
        index.parent.mkdir(exist_ok=True)
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

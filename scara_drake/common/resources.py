"""Where the files beside the code are: in a checkout at its top, in a wheel inside the package."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def resource(*parts: str) -> Path:
    """Path of a shipped file or folder, such as ``resource("models", "scara6.urdf")``.

    Raises:
        ValueError: no such file is shipped.
    """
    for root in (_PACKAGE, _PACKAGE.parent):
        path = root.joinpath(*parts)
        if path.exists():
            return path
    raise ValueError(f"resource: '{'/'.join(parts)}' is not shipped with scara_drake")

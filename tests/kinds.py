"""The kind of a part that a test is about, where the type says that it may be another."""

from __future__ import annotations

from typing import TypeVar

Kind = TypeVar("Kind")


def of_kind(kind: type[Kind], part: object) -> Kind:
    """The part itself, asserted to be of the kind."""
    assert isinstance(part, kind)
    return part

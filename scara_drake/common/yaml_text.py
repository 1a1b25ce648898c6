"""YAML of a user read as plain data: bounded, every key once, and every error one line."""

from __future__ import annotations

import copy
from collections.abc import Hashable
from functools import lru_cache
from typing import Any, Final

import yaml

from scara_drake.common.checks import shown

TAG: Final = "_tag"  # under which the tag of a map is left
MOST_CHARACTERS: Final = 1_000_000  # of a text
MOST_NODES: Final = 100_000  # with every alias written out
DEEPEST: Final = 50  # maps and lists within each other


def read_yaml(text: str, name: str) -> Any:
    """Return the data of a YAML text; the tag of a map is its entry `TAG`.

    Args:
        text: one document.
        name: of the file or of the setting, for the messages.

    Raises:
        ValueError: one line: no YAML, a key twice, a value that cannot be made, or too much.
    """
    return copy.deepcopy(_read(text, name))


@lru_cache(maxsize=64)
def _read(text: str, name: str) -> Any:
    # Most texts are read again and again, such as a scenario for each run of a study.
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"{name}: {len(text)} characters, allowed up to {MOST_CHARACTERS}")
    try:
        loader = _Loader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        if _size(node, {}, 0) > MOST_NODES:
            raise ValueError(f"{name}: aliases that make it too large, allowed {MOST_NODES} nodes")
        return loader.construct_document(node)
    except yaml.YAMLError as error:
        raise ValueError(f"{name}: not YAML, {_problem(error)}") from None
    except RecursionError:
        raise ValueError(f"{name}: too deep, allowed {DEEPEST} maps and lists in a row") from None


class _Loader(yaml.SafeLoader):
    """Gives every map with a tag of its own the entry `TAG`, and refuses a key that comes twice."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep)
        except (ValueError, OverflowError) as error:  # such as a date that is none
            raise _refusal(str(error), node) from error

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen = set()
        for key, _ in node.value:
            if key.value == TAG:
                raise _refusal(f"key '{TAG}', allowed a tag such as !Name", key)
            if isinstance(key, yaml.ScalarNode):
                if (key.tag, key.value) in seen:
                    raise _refusal(f"key {shown(key.value)} twice, allowed once", key)
                seen.add((key.tag, key.value))
        return super().construct_mapping(node, deep)

    def construct_tagged(self, tag: str, node: yaml.Node) -> dict[Hashable, Any]:
        if not isinstance(node, yaml.MappingNode):
            raise _refusal(f"tag {shown(tag)} on what is no map, allowed !Name {{}}", node)
        return {**self.construct_mapping(node, deep=True), TAG: tag}


_Loader.add_multi_constructor("", _Loader.construct_tagged)


def _refusal(what: str, node: yaml.Node) -> yaml.YAMLError:
    return yaml.constructor.ConstructorError(None, None, what, node.start_mark)


def _size(node: yaml.Node, known: dict[yaml.Node, int], depth: int) -> int:
    """Nodes of a document with every alias written out, in the time of those that are there."""
    if depth > DEEPEST:
        raise RecursionError
    if node not in known:
        children: list[yaml.Node] = []
        if isinstance(node, yaml.MappingNode):
            children = [part for pair in node.value for part in pair]
        elif isinstance(node, yaml.SequenceNode):
            children = node.value
        known[node] = 1 + sum(_size(child, known, depth + 1) for child in children)
    return known[node]


def _problem(error: yaml.YAMLError) -> str:
    """What is wrong, and where, in one line."""
    mark = getattr(error, "problem_mark", None)
    what = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error)
    where = f"line {mark.line + 1}: " if mark is not None else ""
    return f"{where}{shown(what, 160, quotes=False)}"

"""The block diagram of a scenario, drawn from the Diagram itself."""

from __future__ import annotations

import re
import shutil

import pydot
from pydrake.systems.framework import Diagram

# The drawing carries its own source in a comment, so that a reader can tell whether it is current.
_MARK = "block diagram source:"


def dot_source(diagram: Diagram) -> str:
    """Return the Graphviz text of a Diagram, the same in every process.

    The plant is drawn as its inputs and its outputs, so that the loop through it reads from left to
    right. Drake numbers its nodes by a global count; here they are numbered by first appearance.
    """
    text = diagram.GetGraphvizString(max_depth=1, options={"plant/split": "I/O"})
    numbers: dict[str, str] = {}
    return re.sub(r"\bs\d+\b", lambda match: numbers.setdefault(match[0], f"s{len(numbers)}"), text)


def render_svg(diagram: Diagram) -> str:
    """Draw the block diagram of a Diagram as SVG, its source inside as a comment.

    Raises:
        ValueError: the program `dot` of Graphviz is not installed.
    """
    if shutil.which("dot") is None:
        raise ValueError("dot: not found, allowed a machine with Graphviz installed")
    source = dot_source(diagram)
    (graph,) = pydot.graph_from_dot_data(source)
    drawing = graph.create_svg().decode()
    comment = source.replace("--", "- -")
    return drawing.rstrip() + f"\n<!-- {_MARK}\n{comment}\n-->\n"


def source_of_svg(svg: str) -> str:
    """Return the Graphviz text that a drawing of `render_svg` carries; empty if it carries none."""
    match = re.search(rf"<!-- {_MARK}\n(.*)\n-->", svg, re.DOTALL)
    return match[1].replace("- -", "--") if match else ""

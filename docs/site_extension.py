"""What the site adds to Sphinx: equations as MathML, and the ports of a system as a list."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

# Code and equations, and any other bar.
BAR = re.compile(r":math:`[^`]*`?|``.*?``|`[^`]*`|\|")
HEAD = re.compile(r"(Ports|Input ports?|Output ports?)\b")


def mathml(tex: str, display: str) -> str:
    """Return an equation as MathML, which browsers set by themselves, without a network."""
    if "&" in tex and "\\begin" not in tex:
        tex = rf"\begin{{split}}{tex}\end{{split}}"
    return convert(tex, display=display)


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="equation">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def list_ports(
    app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]
) -> None:
    """Make a list of the ports in a docstring, which has one a line below "Ports:"."""
    written: list[str] = []
    below, depth = False, 0  # a head, and the indentation of its list once that has begun
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if below and indent:
            if not depth:
                depth = indent
                written.append("")
            written.append(("* " if indent == depth else "  ") + line.strip())
            continue
        if depth and line:
            written.append("")
        below = HEAD.match(line) is not None or (below and not depth and bool(line))
        depth = 0
        written.append(line)
    lines[:] = written


def escape_bars(
    app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]
) -> None:
    """Let |s| be a magnitude, which reStructuredText takes for a substitution."""
    literal: str | None = None  # the indentation that a literal block or an equation is below
    for i, line in enumerate(lines):
        indent = line[: len(line) - len(line.lstrip())]
        if literal is not None and line.strip() and len(indent) <= len(literal):
            literal = None
        if literal is None and line.strip():
            if line.rstrip().endswith("::"):
                literal = indent
            lines[i] = BAR.sub(lambda m: m[0] if m[0].startswith(("`", ":")) else r"\|", line)


def skip_fields(app: Sphinx, what: str, name: str, item: Any, skip: bool, options: Any) -> bool:
    """Leave out the fields of a NamedTuple, which the docstring of its class explains."""
    return skip or str(getattr(item, "__doc__", "")).startswith("Alias for field")


def leave_out_fields(
    app: Sphinx, what: str, name: str, item: Any, options: Any, signature: str, returned: str
) -> tuple[str, str] | None:
    """Leave the fields of a record out of its head: its docstring lists them."""
    record = dataclasses.is_dataclass(item) or hasattr(item, "_fields")
    return ("", "") if what == "class" and record else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Add them to Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("autodoc-process-docstring", list_ports, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", escape_bars, priority=401)
    app.connect("autodoc-process-signature", leave_out_fields)
    app.connect("autodoc-skip-member", skip_fields)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""The block diagram of a scenario, drawn from the Diagram itself: its systems and connections."""

from __future__ import annotations

import re
import shutil
import subprocess
from html import escape

from pydrake.systems.framework import Diagram, System
from pydrake.systems.primitives import VectorLogSink

from scara_drake.display import look
from scara_drake.recordings.recorder import SignalBundle

# The drawing carries its own source in a comment, so that a reader can tell whether it is current.
_MARK = "block diagram source:"
# The recorder listens to every signal: it would hide the loop.
_LEFT_OUT = (SignalBundle, VectorLogSink)


def dot_source(diagram: Diagram) -> str:
    """Return the Graphviz text of a Diagram, the same in every process.

    Each box is a system with its name, its class and the ports that are connected. A plant is drawn
    twice, once for its inputs and once for its outputs, so that the loop reads from left to right.
    The recorder and the exported ports are left out.
    """
    systems = [s for s in diagram.GetSystems() if not isinstance(s, _LEFT_OUT)]
    edges = sorted(
        (source.get_name(), int(output), sink.get_name(), int(port))
        for (sink, port), (source, output) in diagram.connection_map().items()
        if sink in systems and source in systems
    )
    lines = [
        f'digraph "{diagram.get_name()}" {{',
        'graph [rankdir=LR, nodesep=0.35, ranksep=0.7, fontname="Helvetica", bgcolor="white"]',
        'node [shape=plain, fontname="Helvetica", fontsize=11]',
        f'edge [color="{look.ARROW}", arrowsize=0.7]',
    ]
    for system in systems:
        name = system.get_name()
        inputs = sorted({port for _, _, sink, port in edges if sink == name})
        outputs = sorted({output for source, output, _, _ in edges if source == name})
        if name == "plant":
            lines += [_box(system, "plant_in", inputs, []), _box(system, "plant", [], outputs)]
        else:
            lines.append(_box(system, name, inputs, outputs))
    for source, output, sink, port in edges:
        target = "plant_in" if sink == "plant" else sink
        lines.append(f"{source}:y{output}:e -> {target}:u{port}:w")
    return "\n".join([*lines, "}", ""])


def _box(system: System, node: str, inputs: list[int], outputs: list[int]) -> str:
    """Return a box: a header, then a row for each connected port, inputs left, outputs right."""
    rows = []
    for index in range(max(len(inputs), len(outputs))):
        cells = ""
        for side, ports, get in (
            ("u", inputs, system.get_input_port),
            ("y", outputs, system.get_output_port),
        ):
            if index < len(ports):
                port = get(ports[index])
                cells += f'<TD PORT="{side}{ports[index]}">{escape(port.get_name())}</TD>'
            elif ports:
                cells += "<TD></TD>"
        rows.append(f"<TR>{cells}</TR>")
    span = 2 if inputs and outputs else 1
    header = (
        f'<TR><TD COLSPAN="{span}" BGCOLOR="{look.BOX_FILL}">'
        f"<B>{escape(system.get_name())}</B><BR/>"
        f'<FONT POINT-SIZE="9">{escape(type(system).__name__)}</FONT></TD></TR>'
    )
    table = f'BORDER="1" CELLBORDER="0" CELLSPACING="0" CELLPADDING="4" COLOR="{look.BOX_EDGE}"'
    return f"{node} [label=<<TABLE {table}>{header}{''.join(rows)}</TABLE>>]"


def render_svg(diagram: Diagram) -> str:
    """Draw the block diagram of a Diagram as SVG, its source inside as a comment.

    Raises:
        ValueError: the program `dot` of Graphviz is not installed.
    """
    return drawn(dot_source(diagram))


def drawn(source: str) -> str:
    """Draw a Graphviz text as SVG, the text inside as a comment.

    Raises:
        ValueError: the program `dot` of Graphviz is not installed.
    """
    if shutil.which("dot") is None:
        raise ValueError("dot: not found, allowed a machine with Graphviz installed")
    drawing = subprocess.run(
        ["dot", "-Tsvg"], input=source, capture_output=True, text=True, check=True
    ).stdout
    comment = source.replace("--", "- -")
    return drawing.rstrip() + f"\n<!-- {_MARK}\n{comment}\n-->\n"


def source_of_svg(svg: str) -> str:
    """Return the Graphviz text that a drawing of `render_svg` carries; empty if it carries none."""
    match = re.search(rf"<!-- {_MARK}\n(.*)\n-->", svg, re.DOTALL)
    return match[1].replace("- -", "--") if match else ""

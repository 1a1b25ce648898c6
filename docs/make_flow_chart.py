"""Makes the flow chart of DPSO, our Figure 3, from the parameters that are shipped (Graphviz).

python docs/make_flow_chart.py
"""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Final

from scara_drake.common.files import write_whole
from scara_drake.display import look
from scara_drake.display.block_diagram import drawn
from scara_drake.ik.kernels.search import population_kernel
from scara_drake.ik.options import PARAMETERS, Swarm
from scara_drake.ik.result import POSITION_TOLERANCE, ROTATION_TOLERANCE

PATH: Final = Path(__file__).parent / "dpso.svg"
WITHIN: Final = f"within {1e3 * POSITION_TOLERANCE:g} mm and {ROTATION_TOLERANCE:g} rad?"
ARM, FULL = population_kernel(5), population_kernel(6)
# Field of Dpso: what the stage is called, where it is drawn, and how it is sized by itself.
STAGES: Final = {
    "pso1": (
        "PSO-1, position",
        "drawn in the joint ranges; law (18), objective (22)",
        f"N = {ARM} (arm), {FULL} (with the mast), (20)",
    ),
    "pso2": (
        "PSO-2, orientation",
        "drawn within {radius:g} rad of the best of PSO-1; law (24), objective (25)",
        "M of (23), N/2 to N - 1",
    ),
    "fallback": (
        "one swarm, both",
        "drawn in the joint ranges; law (18), objective (25)",
        f"N = {ARM} (arm), {FULL} (with the mast), (20)",
    ),
}


def dot_source() -> str:
    """Return the Graphviz text of the flow chart."""
    stages = list(STAGES)
    lines = [
        "digraph dpso {",
        'graph [fontname="Helvetica", bgcolor="white", nodesep=0.5, ranksep=0.35]',
        'node [shape=box, style="rounded,filled", fillcolor="white", fontname="Helvetica", '
        f'fontsize=11, color="{look.BOX_EDGE}"]',
        f'edge [color="{look.ARROW}", arrowsize=0.7, fontname="Helvetica", fontsize=10]',
        'target [label="pose to reach, seed"]',
        'answer [label="answer"]',
        'budget [shape=diamond, style=filled, label="evaluations left?"]',
        'robust [label="best of all, not within;\\nwith polish: closed form, least squares"]',
        f"target -> {stages[0]}",
    ]
    for stage, following in zip(stages, [*stages[1:], "budget"], strict=True):
        lines += [
            _stage(stage),
            f'{stage}_met [shape=diamond, style=filled, label="{WITHIN}"]',
            f"{stage} -> {stage}_met",
            f'{stage}_met -> answer [label="yes"]',
            f'{stage}_met -> {following} [label="no"]',
        ]
    lines += [f'budget -> {stages[0]} [label="yes, a new pass"]', 'budget -> robust [label="no"]']
    return "\n".join([*lines, "}", ""])


def _stage(stage: str) -> str:
    """Return a box: the stage, what it does, and a row for each set of parameters."""
    title, does, sized = STAGES[stage]
    rows = [
        _row(name, getattr(parameters, stage), sized, parameters.squared)
        for name, parameters in PARAMETERS.items()
    ]
    radius = next(iter(PARAMETERS.values())).radius
    head = (
        f'<TR><TD COLSPAN="3" BGCOLOR="{look.BOX_FILL}"><B>{escape(title)}</B><BR/>'
        f'<FONT POINT-SIZE="9">{escape(does.format(radius=radius))}</FONT></TD></TR>'
    )
    table = f'BORDER="1" CELLBORDER="0" CELLSPACING="0" CELLPADDING="4" COLOR="{look.BOX_EDGE}"'
    return f"{stage} [shape=plain, label=<<TABLE {table}>{head}{''.join(rows)}</TABLE>>]"


def _row(name: str, swarm: Swarm, sized: str, squared: bool) -> str:
    terms = ((swarm.position_weight, "|P_d - P|"), (swarm.rotation_weight, "|O_d - O|"))
    shown = [f"{weight:.3g} {what}" for weight, what in terms if weight]
    cost = " + ".join(f"({term})²" if squared else term for term in shown)
    particles = f"{swarm.particles} particles" if swarm.particles else sized
    cells = (f"{name}:", f"{particles}, at most {swarm.iterations} iterations", cost)
    return "<TR>" + "".join(f'<TD ALIGN="LEFT">{escape(cell)}</TD>' for cell in cells) + "</TR>"


if __name__ == "__main__":
    write_whole(PATH, drawn(dot_source()))

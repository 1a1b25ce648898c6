"""The layout of `pipe_cut`, the vector that tells of a pipe that is cut; numpy only."""

from typing import Final, NamedTuple

from scara_drake.common.layout import Cell, Layout

# Of its mode.
FREE: Final = 0.0
IN_KERF: Final = 1.0
BESIDE: Final = 2.0


class PipeState(NamedTuple):
    """`pipe_cut` (11): a pipe that is cut, and its blade.

    Attributes:
        power: that the motor gives now [W].
        speed: of the rim now [m/s].
        stalled: 1 while the blade stands.
        energy: that the motor has given [J].
        energy_cut: of the material that is gone [J].
        energy_friction: heat on the sides, and of teeth that do not bite [J].
        volume: removed [m³].
        left: share of the section.
        place: of the kerf along the axis [m]; of the tool, before the first bite.
        bend: the largest beyond the clearance, now [m].
        mode: where the blade is, `FREE`, `IN_KERF` or `BESIDE` of it.
    """

    power: Cell
    speed: Cell
    stalled: Cell
    energy: Cell
    energy_cut: Cell
    energy_friction: Cell
    volume: Cell
    left: Cell
    place: Cell
    bend: Cell
    mode: Cell


PIPE_STATE = Layout(PipeState, **dict.fromkeys(PipeState._fields, ()))
pipe_state_of = PIPE_STATE.reader()

"""Cut a pipe through."""

from collections.abc import Sequence
from dataclasses import dataclass

from scara_drake.common.fields import number
from scara_drake.tasks.base import TaskBase


@dataclass
class CutPipe(TaskBase):
    """Cut the pipe of `environment.cut` through, where it is marked.

    It is through when no more than the share `left` of its section is there (`cut_left` of a
    recording), and the path error is the distance of the kerf from the mark (`kerf_place`).
    Pressing so hard that the blade stalls is a mistake (`blade_stalled`), so is bending it in the
    kerf (`blade_bend`). Every surface touched is a collision; the pipe is none of the surfaces.

    Attributes:
        mark: where along the pipe's axis it is to be cut, from the middle of the axis.
        tolerance: half the width of the mark.
        left: share of the section that may be left.
    """

    mark: float = number(0.0, "m", -50.0, 50.0)
    tolerance: float = number(0.005, "m", 1e-4, 1.0)
    left: float = number(1e-3, "1", 0.0, 0.1)

    def check_scene(self, name: str, surfaces: Sequence[str], pipe: bool) -> None:
        """Check that there is a pipe to cut.

        Raises:
            ValueError: there is none.
        """
        if not pipe:
            raise ValueError(f"{name}: CutPipe, allowed where `environment.cut` is a pipe")

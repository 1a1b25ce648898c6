"""What the operator is asked to do: the training tasks, as data."""

from scara_drake.tasks.cut_pipe import CutPipe
from scara_drake.tasks.reach_into import ReachInto
from scara_drake.tasks.touch_points import TouchPoints
from scara_drake.tasks.trace_line import TraceLine

Task = TouchPoints | TraceLine | ReachInto | CutPipe

__all__ = ["CutPipe", "ReachInto", "Task", "TouchPoints", "TraceLine"]

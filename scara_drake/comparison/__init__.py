"""Recordings beside each other: what differs, by how much, and how it looks."""

from scara_drake.comparison.comparison import Comparison, compare
from scara_drake.comparison.differences import Difference, differences

__all__ = ["Comparison", "Difference", "compare", "differences"]

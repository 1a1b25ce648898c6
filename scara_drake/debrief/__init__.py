"""What is told of a run when it is over: the after-action report, one page, made without Drake."""

from scara_drake.debrief.page import save_report

__all__ = ["save_report"]

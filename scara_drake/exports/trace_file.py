"""The stick of a recording as a trace, which played again gives the same recording."""

from scara_drake.operator.trace import save_trace as write

__all__ = ["write"]

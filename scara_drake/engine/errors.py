"""What the engine says where it cannot go on."""


class NotCompilableError(ValueError):
    """A Diagram has a part that the engine cannot run; Drake can."""


class LeftTheModelError(RuntimeError):
    """A run met what only Drake knows: a joint at its limit, or a link that touches a surface.

    Args:
        time: when [s].
        what: happened.
    """

    def __init__(self, time: float, what: str) -> None:
        super().__init__(f"t = {time:.6g} s: {what}, which only Drake computes")
        self.time, self.what = time, what

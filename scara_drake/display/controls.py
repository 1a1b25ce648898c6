"""What a user can press in Meshcat."""

from __future__ import annotations

from types import TracebackType

from pydrake.geometry import Meshcat


class StopButton:
    """A Stop button in Meshcat while the context lasts; the Escape key presses it too.

    Without a meshcat it does nothing, so a caller needs no second path.
    """

    def __init__(self, meshcat: Meshcat | None, name: str = "Stop"):
        self._meshcat, self._name = meshcat, name

    def __enter__(self) -> StopButton:
        if self._meshcat is not None:
            self._meshcat.DeleteButton(self._name, strict=False)  # left over from another run
            self._meshcat.AddButton(self._name, "Escape")
        return self

    def pressed(self) -> bool:
        """Tell whether it has been pressed since the context was entered."""
        return self._meshcat is not None and self._meshcat.GetButtonClicks(self._name) > 0

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._meshcat is not None:
            self._meshcat.DeleteButton(self._name, strict=False)

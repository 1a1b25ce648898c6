"""What a user can press in Meshcat."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Self

from pydrake.geometry import Meshcat


class Button:
    """A button in Meshcat while the context lasts; a key presses it too.

    Without a meshcat it does nothing, so a caller needs no second path.
    """

    def __init__(self, meshcat: Meshcat | None, name: str, key: str):
        self._meshcat, self._name, self._key = meshcat, name, key

    def __enter__(self) -> Self:
        if self._meshcat is not None:
            self._meshcat.DeleteButton(self._name, strict=False)  # left over from another run
            self._meshcat.AddButton(self._name, self._key)
        return self

    def clicks(self) -> int:
        """Return how often it has been pressed since the context was entered."""
        return 0 if self._meshcat is None else self._meshcat.GetButtonClicks(self._name)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._meshcat is not None:
            self._meshcat.DeleteButton(self._name, strict=False)


class StopButton(Button):
    """Ends a run, as the Escape key does."""

    def __init__(self, meshcat: Meshcat | None, name: str = "Stop"):
        super().__init__(meshcat, name, "Escape")

    def pressed(self) -> bool:
        """Tell whether it has been pressed since the context was entered."""
        return self.clicks() > 0


class OverviewButton(Button):
    """Shows the whole crane, and pressed again what was shown at first; the key O presses it too.

    Args:
        meshcat: with the scene.
        whole: turns the camera of a meshcat to the crane.
        near: turns it back.
    """

    def __init__(
        self,
        meshcat: Meshcat | None,
        whole: Callable[[Meshcat], None],
        near: Callable[[Meshcat], None],
    ):
        super().__init__(meshcat, "Overview", "KeyO")
        self._views, self._seen = (near, whole), 0

    def follow(self) -> None:
        """Turn the camera, if it has been pressed."""
        clicks = self.clicks()
        if self._meshcat is not None and clicks != self._seen:
            self._seen = clicks
            self._views[clicks % 2](self._meshcat)

"""Whether a window stands still: nothing is written, painted or worked at."""

from __future__ import annotations

from concurrent.futures import Future

from PySide6 import QtWidgets

from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.window.job import is_waiting
from paint3d.app.window.studio import StudioWindow

__all__ = ["Calm"]


class Calm:
    """Tells whether all is done that was asked for until `ask`; what only dries is calm.

    Parameters
    ----------
    window : StudioWindow
    """

    def __init__(self, window: StudioWindow) -> None:
        self._window = window
        self._thread: PaintThread | None = None
        self._done: Future[None] | None = None

    def ask(self) -> None:
        """Ask for what was done until now."""
        self._thread = self._window.stage.paint_thread
        self._done = None if self._thread is None else self._thread.post(lambda document: None)

    @property
    def hears(self) -> bool:
        """Whether the window hears a hand: while it waits for work, nothing but the bar does."""
        return not any(is_waiting(one) for one in QtWidgets.QApplication.topLevelWidgets())

    def __call__(self) -> bool:
        """Return whether it is done; False at first where something else was opened meanwhile."""
        if self._window.player.is_playing or not self.hears:
            return False
        if self._window.stage.paint_thread is not self._thread:
            self.ask()
        return self._done is None or self._done.done()

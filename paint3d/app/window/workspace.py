"""Shared by the parts of a window: the picture, the hand, the settings, the status line."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Future
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.frame import Snapshot
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.saved_settings import in_hand
from paint3d.app.model.persistence.settings import Settings, save_settings
from paint3d.app.window.files.open_result import OpenResult
from paint3d.app.window.hand.canvas import CanvasWidget
from paint3d.app.window.hand.canvas_hand import CanvasHand
from paint3d.app.window.job import JobProgress, is_waiting, run_beside
from paint3d.app.window.stage import Stage
from paint3d.app.window.theme import DARK_THEME, LIGHT_THEME, apply_theme, is_system_dark
from paint3d.app.window.wording import choose_unit, say, say_error
from paint3d.errors import Paint3DError
from paint3d.view.live_scene import DARK, LIGHT

__all__ = ["Workspace"]

_LOOK_S = 0.04  # between two checks whether work is still wanted


class Workspace(QtCore.QObject):
    """Shared by the parts of one window; it knows none of them, and tells them by signals.

    Parameters
    ----------
    window : QMainWindow
        Where dialogs and bars stand.
    app : QApplication
    settings : Settings
    dark : bool, optional
        Instead of the theme in the settings.

    Attributes
    ----------
    actions : dict of str to QAction
        The commands, by name.
    canvas : CanvasWidget
    stage : Stage
    hand : CanvasHand
    theme : Theme
    error : BaseException or None
        The last error.
    may_drop : callable
        Asks whether unsaved work beside the painting may be dropped with it.
    before_saving : callable
        Called with a document that is about to be saved, by the painting thread.
    amount : dict of str to float, or None
        How much the next dip takes up, as `DipAmount.words` says it; None: as the dip before.
    quiet : bool
        Store errors there instead of showing them.

    Signals
    -------
    said : str, str, bool
        Something for the status line; see `tell`.
    opened : OpenResult
        A painting to go on with instead of the one that is open.
    saved : ()
        The painting has another name, or nothing unsaved any more.
    held : bool
        Drawing and following pauses, or goes on.
    theme_changed : Theme
    """

    said = QtCore.Signal(str, str, bool)
    opened = QtCore.Signal(object)
    saved = QtCore.Signal()
    held = QtCore.Signal(bool)
    theme_changed = QtCore.Signal(object)

    def __init__(
        self,
        window: QtWidgets.QMainWindow,
        app: QtWidgets.QApplication,
        settings: Settings,
        dark: bool | None = None,
    ) -> None:
        super().__init__(window)
        self.window, self._app, self.settings = window, app, settings
        choose_unit(settings.unit)
        self._system_dark = is_system_dark(app)
        dark = self.wants_dark() if dark is None else dark
        self.theme = DARK_THEME if dark else LIGHT_THEME
        apply_theme(app, self.theme)
        self.actions: dict[str, QtGui.QAction] = {}
        self.canvas = CanvasWidget()
        self.canvas.setAccessibleName(say("Picture"))
        self.stage = Stage(self.canvas.pixel_size, DARK if dark else LIGHT)
        self.hand = CanvasHand(self.canvas, self.stage)
        self.error: BaseException | None = None
        self.quiet = False
        self.may_drop: Callable[[], bool] = lambda: True
        self.before_saving: Callable[[Document], None] = lambda _: None
        self.amount: Mapping[str, float] | None = None
        self._first_messages: list[str] = []

    # -- the painting -----------------------------------------------------------------------

    @property
    def paint_thread(self) -> PaintThread:
        """The painting thread, while something is open; `stage.paint_thread` may be None."""
        return self.stage.open_paint_thread

    @property
    def painting(self) -> Snapshot:
        """The painting, as it was after the last step."""
        return self.paint_thread.painting

    def show(self, opened: OpenResult) -> bool:
        """Open another painting; False if that was stopped: see `may_let_go`."""
        if not self.may_let_go():
            return False
        self.opened.emit(opened)
        if self._first_messages:  # later, or what opened the painting shows its own message last
            message, self._first_messages = "; ".join(self._first_messages), []
            QtCore.QTimer.singleShot(0, self, lambda: self.tell(message, state="bad", stays=True))
        return True

    def may_let_go(self) -> bool:
        """Halt the painting thread, waiting for its current step.

        Queued commands are not done: whoever closes a painting has saved it or does without.

        Returns
        -------
        bool
            False if the waiting was stopped, or something is not to be dropped: then the painting
            goes on, with all that waits.
        """
        paint_thread = self.stage.paint_thread
        if paint_thread is None:
            return True
        if not self.may_drop():
            return False
        paint_thread.halt()
        if paint_thread.has_halted(0.0):
            return True

        def wait(progress: JobProgress) -> None:
            while not paint_thread.has_halted(_LOOK_S):
                progress.check()

        if self.went_well(self.run(say("Finishing the current step…"), wait)):
            return True
        paint_thread.go_on()
        return False

    def post(self, command: str, *arguments: object) -> None:
        """Post a command to the painting thread; its errors are shown. Nothing, if none is open."""
        if self.stage.paint_thread is not None:
            self.stage.paint_thread.post(command, *arguments)

    def dip(self, ink: Any = None, reach: float | None = None) -> None:
        """Dip the brush in an ink or the same again, by the amount that was chosen."""
        if reach is None:
            self.post("dip", ink, None, self.amount)
        else:
            self.post("dip", ink, reach)

    # -- messages ---------------------------------------------------------------------------

    def tell(self, text: str, *, state: str = "off", stays: bool = False) -> None:
        """Show a message in the status line, marked by its state.

        Parameters
        ----------
        text : str
        state : str
            One of `theme.STATES`.
        stays : bool
            Whether it stays until the next message; if not, the next stroke removes it.
        """
        self.said.emit(text, state, stays)

    def tell_first(self, text: str) -> None:
        """Show a problem from before there was a window once the first painting is open."""
        self._first_messages.append(text)

    # -- choices ----------------------------------------------------------------------------

    def update_settings(self, **changes: Any) -> None:
        """Change settings, and save them."""
        self.settings = dataclasses.replace(self.settings, **changes)
        try:
            save_settings(self.settings)
        except Paint3DError as error:
            self.tell(say_error(error), state="bad")

    def remember_in_hand(self) -> None:
        """Remember the brush, the inks and the force for the next painting."""
        if self.stage.paint_thread is None:
            return
        chosen = in_hand(self.paint_thread.brush, list[Any](self.painting.inks))
        self.settings = dataclasses.replace(self.settings, **chosen, force_n=self.hand.force)

    def wants_dark(self) -> bool:
        """Return whether the settings ask for the dark theme."""
        dark = self.settings.theme == "dark"
        return dark or (self.settings.theme == "system" and self._system_dark)

    def set_dark(self, on: bool) -> None:
        """Change the theme."""
        self.theme = DARK_THEME if on else LIGHT_THEME
        apply_theme(self._app, self.theme)
        self.stage.set_mood(DARK if on else LIGHT)
        self.theme_changed.emit(self.theme)
        self.canvas.update()

    # -- long work --------------------------------------------------------------------------

    @property
    def is_waiting(self) -> bool:
        """True while the window waits for work."""
        return is_waiting(self.window)

    def run(
        self,
        title: str,
        work: Callable[[JobProgress], object],
        here: Callable[[], None] | None = None,
    ) -> Future[Any]:
        """Run work beside the window, with a bar to cancel it; see `run_beside`."""
        return run_beside(self.window, title, work, here)

    def went_well(self, done: Future[Any]) -> bool:
        """Return whether work succeeded; show its error."""
        error = done.exception()
        if error is None:
            return True
        self.error = error
        if isinstance(error, CancelledError):
            self.tell(say("Stopped"))
        elif not isinstance(error, Paint3DError | OSError):
            raise error
        elif not self.quiet:
            QtWidgets.QMessageBox.warning(self.window, "paint3d", say_error(error))
        return False

    def hold(self) -> None:
        """Draw and follow nothing until `go_on`."""
        self.held.emit(True)

    def go_on(self) -> None:
        """Draw and follow again."""
        self.stage.touch()
        self.held.emit(False)

"""Starting the studio: the program around the window."""

from __future__ import annotations

import logging
from concurrent.futures import CancelledError
from dataclasses import replace

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.input.devices import plug_in_mice, start_feeling
from paint3d.app.model.persistence.settings import load_settings
from paint3d.app.window.program import make_program
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language, say
from paint3d.app.window.wording import language as spoken
from paint3d.core.own_folders import fallback_folder
from paint3d.haptics.stylus_choice import check_stylus
from paint3d.pose.mouse_settings import MouseSettings

__all__ = ["make_program", "open_first", "run_studio"]

_FIRST = "bowl"

log = logging.getLogger("paint3d.start")
"""Milestones of the start, at level DEBUG, for benchmarks."""


def run_studio(
    target: str | None,
    *,
    resolution: float | None = None,
    material: str | None = None,
    language: str | None = None,
    unit: str | None = None,
    up: str | None = None,
    stylus: str | None = None,
    opening: QtWidgets.QWidget | None = None,
) -> int:
    """Open the window and stay until it is closed.

    Parameters
    ----------
    target : str or None
        A mesh, a painting or a built-in object; None: what a crash left, or the page that asks
        what to paint on (a bowl where a resolution or a material is given).
    resolution : float, optional
        Of a mesh, mm; by default what was chosen last.
    material : str, optional
        Of a mesh; by default what was chosen last.
    language : str, optional
        "en" or "zh"; by default what was chosen last, or the system's.
    unit : str, optional
        Unit of the mesh file; by default as the file says, else mm.
    up : str, optional
        The axis of the mesh that points up; by default as its file says, or guessed.
    stylus : str, optional
        The haptic stylus (`find_stylus`), from now on; by default what was chosen last.
    opening : QWidget, optional
        Shown until now, to be closed once the window is there.

    Returns
    -------
    int
        The program's exit status.

    Raises
    ------
    Paint3DError
        If there is no display, or the target cannot be opened.
    """
    app = make_program()
    settings, problem = load_settings()
    if stylus is not None:
        settings = replace(settings, stylus=check_stylus(stylus))
    choose_language(language or settings.language)
    _translate_qt(app)
    plugged = plug_in_mice(MouseSettings.from_dict(settings.mouse))
    window = StudioWindow(app, settings, plugged=plugged, feel=start_feeling)
    if problem is not None:
        window.workspace.tell(say(problem), state="bad", stays=True)
    elif (folder := fallback_folder()) is not None:
        message = say(
            "The home folder cannot be written: settings and recovery data are kept in {folder}",
            folder=folder,
        )
        window.workspace.tell(message, state="bad", stays=True)
    if log.isEnabledFor(logging.DEBUG):
        window.installEventFilter(_FirstPaint(window))
    window.show()
    window.recent.show()
    if opening is not None:
        QtCore.QTimer.singleShot(0, opening.close)
    try:
        open_first(window, target, resolution, material, unit, up)
    except BaseException:
        window.close()
        raise
    QtCore.QTimer.singleShot(0, lambda: log.debug("hears the hand"))
    return app.exec()


class _FirstPaint(QtCore.QObject):
    """Logs when a widget has been painted for the first time."""

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Log the first paint event; filter nothing."""
        if event.type() == QtCore.QEvent.Type.Paint:
            watched.removeEventFilter(self)
            QtCore.QTimer.singleShot(0, lambda: log.debug("window painted"))
        return False


def _translate_qt(app: QtWidgets.QApplication) -> None:
    """Translate Qt's own dialogs into the window's language."""
    if spoken() == "zh":
        translator = QtCore.QTranslator(app)
        folder = QtCore.QLibraryInfo.path(QtCore.QLibraryInfo.LibraryPath.TranslationsPath)
        if translator.load("qtbase_zh_CN", folder):
            app.installTranslator(translator)


def open_first(
    window: StudioWindow,
    target: str | None,
    resolution: float | None,
    material: str | None,
    unit: str | None = None,
    up: str | None = None,
) -> None:
    """Open what a crash left, else the target; without either, the window's page asks."""
    if window.recovery.offer():
        return
    if target is None and resolution is None and material is None:
        return
    if target is None and isinstance(window.workspace.error, CancelledError):
        return  # the page offers it again
    opening = window.opening
    window.workspace.quiet, opening.unit, opening.up = True, unit, up
    opened = opening.open_path(target or _FIRST, resolution, material, asked=True)
    window.workspace.quiet, opening.unit, opening.up = False, None, None
    error = window.workspace.error
    if opened:
        window.recovery.tell_unsaved()
    if not opened and error is not None and not isinstance(error, CancelledError):
        raise error

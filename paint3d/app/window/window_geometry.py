"""Size, position and panels of a window, as the settings store them."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6 import QtCore, QtWidgets

__all__ = ["first_size", "restore_window", "window_words"]

_VERSION = 1  # of the arrangement of tool bars and panels: another one is not restored
_SIZE = QtCore.QSize(1280, 800)
_FRAME = QtCore.QSize(2, 38)  # that a window manager puts around it, about


def first_size(window: QtWidgets.QMainWindow) -> QtCore.QSize:
    """Return a window's size at its first opening: no larger than its screen."""
    available = window.screen().availableGeometry().size() - _FRAME
    return _SIZE.boundedTo(available).expandedTo(window.minimumSizeHint())


def window_words(window: QtWidgets.QMainWindow) -> dict[str, object]:
    """Return the state that `restore_window` takes, as JSON can hold it."""
    return {
        "geometry": _text(window.saveGeometry()),
        "panels": _text(window.saveState(_VERSION)),
    }


def restore_window(window: QtWidgets.QMainWindow, words: Mapping[str, object]) -> None:
    """Restore a window's size, position and panels; what cannot be used is ignored.

    Qt moves what would lie beside the screens back onto one.
    """
    geometry, panels = words.get("geometry"), words.get("panels")
    if isinstance(geometry, str):
        window.restoreGeometry(_bytes(geometry))
    if isinstance(panels, str):
        window.restoreState(_bytes(panels), _VERSION)


def _text(data: QtCore.QByteArray) -> str:
    return bytes(data.toBase64().data()).decode("ascii")


def _bytes(text: str) -> QtCore.QByteArray:
    return QtCore.QByteArray.fromBase64(text.encode("utf-8", "replace"))

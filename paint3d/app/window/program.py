"""The program around the window, and its splash screen."""

from __future__ import annotations

import os
import sys

import PySide6
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.garbage import collect_here
from paint3d.errors import InputError

__all__ = ["make_program", "show_opening"]

_WIDE, _HIGH = 360, 140  # of the splash screen


def make_program() -> QtWidgets.QApplication:
    """Return the program, made once.

    Raises
    ------
    InputError
        If there is no display.
    """
    there = QtWidgets.QApplication.instance()
    if isinstance(there, QtWidgets.QApplication):
        return there
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY")
        or os.environ.get("WAYLAND_DISPLAY")
        or os.environ.get("QT_QPA_PLATFORM")
    ):
        raise InputError("there is no display to open a window on; expected DISPLAY to be set")
    if sys.version_info < (3, 12) and PySide6.__version_info__[:3] == (6, 12, 0):
        raise InputError(
            "PySide6 6.12.0 does not hold on Python before 3.12; expected another version of either"
        )
    QtGui.QGuiApplication.setHighDpiScaleFactorRoundingPolicy(
        QtCore.Qt.HighDpiScaleFactorRoundingPolicy.PassThrough
    )
    QtCore.QCoreApplication.setOrganizationName("paint3d")
    QtCore.QCoreApplication.setApplicationName("paint3d")
    program = QtWidgets.QApplication(["paint3d"])
    # every event of a hand counts; how many are joined would depend on how fast pictures are drawn.
    # Said once there is a program: on X11 Qt joins them from its start, whatever was said before
    for kind in ("AA_CompressHighFrequencyEvents", "AA_CompressTabletEvents"):
        attribute = QtCore.Qt.ApplicationAttribute[kind]
        QtCore.QCoreApplication.setAttribute(attribute, False)
    collect_here(program)
    return program


def show_opening() -> QtWidgets.QSplashScreen:
    """Show the program's name at once: what the window needs takes seconds to load."""
    screen = QtGui.QGuiApplication.primaryScreen()
    scale = screen.devicePixelRatio()
    picture = QtGui.QPixmap(round(_WIDE * scale), round(_HIGH * scale))
    picture.setDevicePixelRatio(scale)
    palette = QtGui.QGuiApplication.palette()
    picture.fill(palette.window().color())
    painter = QtGui.QPainter(picture)
    painter.setPen(palette.windowText().color())
    font = painter.font()
    font.setPointSizeF(1.8 * font.pointSizeF())
    painter.setFont(font)
    middle = QtCore.Qt.AlignmentFlag.AlignCenter
    painter.drawText(QtCore.QRect(0, 0, _WIDE, _HIGH), middle, "paint3d …")
    painter.end()
    opening = QtWidgets.QSplashScreen(screen, picture)
    opening.show()
    QtWidgets.QApplication.processEvents()
    return opening

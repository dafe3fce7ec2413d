"""Run by `test_screens` in a process of its own: the studio on one screen, told as JSON."""

from __future__ import annotations

import json

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.input.navigation import ray_at
from paint3d.app.model.persistence import settings
from paint3d.app.window.hand.steering import GRIPS
from paint3d.app.window.start import make_program
from paint3d.mesh.bvh import ClosestPoints
from tests.support.app.gestures import live, pen_stroke, wait_for
from tests.support.app.windows import draw_little, opened, settled

START, END = (0.42, 0.6), (0.58, 0.6)  # of the canvas


def main() -> None:
    """Open the sheet, paint a stroke with a leaning pen, and tell what is where."""
    settings.WET_AT_FIRST = frozenset()  # ink stays where it was put
    draw_little()  # as in the tests of the window
    with opened(make_program(), "plane", size=None) as window:
        canvas = window.canvas
        size = np.array([canvas.width(), canvas.height()])
        pen_stroke(canvas, START, END, [0.3] * 20, (30.0, 20.0))
        settled(window)
        stale = _stale(window)
        window.stage.shows_brush = False
        window.stage.touch()
        wait_for(lambda: window.stage.is_drawn)
        live(0.2)
        shown, grips = canvas.grab().toImage(), window.steering.grips
        print(json.dumps({
            "screen": _box(window.screen().availableGeometry()),
            "window": _box(window.frameGeometry()),
            "panels": [_box(_on_screen(dock)) for dock in _docks(window)],
            "ratio": canvas.devicePixelRatioF(),
            "canvas": size.tolist(),
            "picture": list(window.stage.scene.size),
            "shown": [shown.width(), shown.height()],
            "grips": [list(grips.box(name, canvas.rect()).getCoords()) for name in GRIPS],
            "off_mm": _off(window, size),
            "dark": _dark(shown),
            "stale": stale,
        }))  # fmt: skip


def _stale(window) -> int:
    """Pixels of the screen that a whole repaint changes, after parts of it were repainted."""
    if QtGui.QGuiApplication.platformName() != "xcb":
        return 0  # Wayland shows no program what is on the screen
    window.workspace.hold()
    try:
        shown = _pixels(window)
        window.canvas.update()
        anew = _pixels(window)
    finally:
        window.workspace.go_on()
    return int((shown != anew).any(axis=2).sum())


def _pixels(window) -> np.ndarray:
    """(H, W, 4) uint8: the canvas as the screen has it."""
    live(0.05)
    image = window.screen().grabWindow(window.winId()).toImage()
    image = image.convertToFormat(QtGui.QImage.Format.Format_RGB32)
    canvas, ratio = window.canvas, window.canvas.devicePixelRatioF()
    place = canvas.mapTo(window, QtCore.QPoint(0, 0))
    left, top = int(place.x() * ratio), int(place.y() * ratio)
    right, bottom = (int(n * ratio) for n in (canvas.width(), canvas.height()))
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1, 4)
    return rows[top : top + bottom, left : left + right].copy()


def _docks(window: QtWidgets.QMainWindow) -> list[QtWidgets.QWidget]:
    docks = window.findChildren(QtWidgets.QDockWidget)
    return [dock for dock in docks if dock.isVisible() and not dock.visibleRegion().isEmpty()]


def _on_screen(widget: QtWidgets.QWidget) -> QtCore.QRect:
    return QtCore.QRect(widget.mapToGlobal(QtCore.QPoint(0, 0)), widget.size())


def _box(box: QtCore.QRect) -> list[int]:
    return [box.left(), box.top(), box.right() + 1, box.bottom() + 1]


def _off(window, size: np.ndarray) -> float:
    """Measure how far the middle of the ink lies off the middle of the pen's path, mm."""
    surface = window.document.surface
    field = surface.paint_mesh.arrays
    ids = np.flatnonzero(surface.painted)
    middle = [float(part[ids].mean()) for part in (field.px, field.py, field.pz)]
    x, y = 0.5 * (np.array(START) + END) * size
    ray = ray_at(window.hand.camera, x, y, tuple(size))
    found = ClosestPoints(surface.source).cast(ray.origin[None], ray.direction[None])
    return float(np.linalg.norm(found.points[0] - middle))


def _dark(shown: QtGui.QImage) -> list[float]:
    """Locate the ink in the picture, as fractions of its size, apart from grips and plates."""
    shown = shown.convertToFormat(QtGui.QImage.Format.Format_Grayscale8)
    rows = np.frombuffer(shown.constBits(), np.uint8)
    codes = rows.reshape(shown.height(), shown.bytesPerLine())[:, : shown.width()]
    high, wide = codes.shape
    part = codes[high // 3 : 3 * high // 4, wide // 4 : 3 * wide // 4]
    y, x = np.nonzero(part < 90)
    return [float(x.mean() + wide // 4) / wide, float(y.mean() + high // 3) / high]


if __name__ == "__main__":
    main()

"""Where the screen has a ratio that is no whole number, pictures are shown pixel for pixel."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui

from paint3d.app.window.hand.canvas import Canvas
from tests.support.cases import long_but

NOTHING = (1, 2, 3)  # codes that no picture has here
PLACE = QtCore.QPoint(35, 30)


def drawn(canvas: Canvas, part: QtCore.QRect, ratio: float) -> np.ndarray:
    """(H, W, 3) codes of a screen on which a part of a widget within a window is drawn."""
    image = QtGui.QImage(760, 580, QtGui.QImage.Format.Format_RGBX8888)
    image.setDevicePixelRatio(ratio)
    image.fill(QtGui.QColor(*NOTHING))
    canvas.render(image, PLACE + part.topLeft(), QtGui.QRegion(part))
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(580, 760, 4)
    return rows[:, :, :3].copy()


def noisy(size, ratio, monkeypatch) -> tuple[Canvas, np.ndarray, np.random.Generator]:
    """A canvas on a screen of this ratio that shows noise, its pixels, and where they are from."""
    canvas, chance = Canvas(), np.random.default_rng(5)
    canvas.resize(*size)
    monkeypatch.setattr(canvas, "devicePixelRatioF", lambda: ratio)
    width, height = canvas.pixel_size
    pixels = chance.integers(8, 255, (height, width, 4)).astype(np.uint8)
    canvas.show_pixels(pixels)
    return canvas, pixels, chance


@pytest.mark.parametrize(
    ("ratio", "size"),
    long_but(
        [(1.25, (323, 241)), (1.5, (320, 240)), (1.75, (323, 241)), (2.0, (320, 240))],
        product((1.0, 1.25, 1.5, 1.75, 2.0), ((323, 241), (320, 240))),
    ),
)
def test_parts_are_shown_as_the_whole_is(program, ratio, size, monkeypatch) -> None:
    canvas, pixels, chance = noisy(size, ratio, monkeypatch)
    whole = drawn(canvas, canvas.rect(), ratio)
    shown = (whole != NOTHING).any(axis=2)
    rows, columns = np.flatnonzero(shown.any(axis=1)), np.flatnonzero(shown.any(axis=0))
    top, left = rows[0], columns[0]
    assert abs(left - ratio * PLACE.x()) <= 0.5
    assert abs(top - ratio * PLACE.y()) <= 0.5
    for found, wanted in zip((columns.size, rows.size), size, strict=True):
        assert abs(found - ratio * wanted) <= 1.0
    box = np.s_[top : top + rows.size, left : left + columns.size]
    assert shown[box].all()  # no row or column of it is left out
    assert (whole[box] == pixels[::-1][: rows.size, : columns.size, :3]).all()
    for _ in range(12):
        (x0, x1), (y0, y1) = (sorted(chance.choice(side, 2, replace=False)) for side in size)
        part = drawn(canvas, QtCore.QRect(x0, y0, x1 - x0, y1 - y0), ratio)
        changed = (part != NOTHING).any(axis=2)
        assert changed.sum() > 0
        assert (part[changed] == whole[changed]).all()


@pytest.mark.parametrize("ratio", [1.0, 1.25, 1.5, 1.75])
def test_what_has_changed_is_asked_to_be_drawn_whole(program, ratio, monkeypatch) -> None:
    canvas, pixels, chance = noisy((323, 241), ratio, monkeypatch)
    asked = list[QtCore.QRect]()
    height, width = pixels.shape[:2]
    before = drawn(canvas, canvas.rect(), ratio)
    monkeypatch.setattr(canvas, "update", lambda *rects: asked.extend(rects))
    for _ in range(12):
        (x0, x1), (y0, y1) = (
            sorted(int(edge) for edge in chance.choice(side - 1, 2, replace=False))
            for side in (width, height)
        )
        pixels[y0:y1, x0:x1] ^= 255
        canvas.show_pixels(pixels, (x0, y0, x1, y1))
        after = drawn(canvas, canvas.rect(), ratio)
        part = drawn(canvas, asked.pop(), ratio)
        changed = (after != before).any(axis=2)
        assert changed.any()
        assert (part[changed] == after[changed]).all()
        before = after

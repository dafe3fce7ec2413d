"""The column of grips over the picture, which is drawn anew when it looks otherwise."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui

from paint3d.app.window.hand import steering as module
from paint3d.app.window.hand.steering import GRIPS, Grips
from paint3d.app.window.theme import DARK_THEME, LIGHT_THEME

AREA = QtCore.QRect(0, 0, 320, 260)


def picture(grips: Grips, pixel_ratio: float = 1.0) -> QtGui.QImage:
    """What a canvas of 320 x 260 shows with them."""
    image = QtGui.QImage(AREA.size() * pixel_ratio, QtGui.QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(pixel_ratio)
    image.fill(QtGui.QColor(90, 120, 150))
    painter = QtGui.QPainter(image)
    grips.paint(painter, AREA)
    painter.end()
    return image


def test_they_are_drawn_anew_only_when_they_look_otherwise(program, monkeypatch) -> None:
    made: list[str] = []
    make = module.make_icon
    monkeypatch.setattr(module, "make_icon", lambda n, t: (made.append(n), make(n, t))[1])
    theme = [LIGHT_THEME]
    grips = Grips(lambda: theme[0])

    def look(**now: object) -> QtGui.QImage:
        for name, value in now.items():
            setattr(grips, name, value)
        first = picture(grips)
        n_made = len(made)
        assert picture(grips) == first
        assert len(made) == n_made
        return first

    seen = [look(), look(under="pan"), look(held="pan"), look(held=None, under="roll")]
    theme[0] = DARK_THEME
    seen.append(look())
    assert all(seen[i] != seen[j] for i in range(len(seen)) for j in range(i))
    assert len(made) == len(seen) * len(GRIPS)
    assert picture(grips, 2.0).size() == 2 * seen[0].size()
    assert len(made) == (len(seen) + 1) * len(GRIPS)
    grips.shown = False
    assert picture(grips).pixelColor(300, 30) == QtGui.QColor(90, 120, 150)


def test_they_lie_where_they_are_taken_hold_of(program) -> None:
    grips = Grips(lambda: LIGHT_THEME)
    bare = QtGui.QColor(90, 120, 150)
    image = picture(grips)
    for name in GRIPS:
        box = grips.box(name, AREA)
        middle = box.center()
        assert grips.at(middle.x(), middle.y(), AREA) == name
        left = next(
            x for x in range(AREA.width()) if image.pixelColor(x, round(middle.y())) != bare
        )
        assert abs(left - box.left()) <= 1.0
        column = range(round(box.top()) - 3, round(box.bottom()) + 4)
        inked = [y for y in column if image.pixelColor(round(middle.x()), y) != bare]
        assert abs(inked[0] - box.top()) <= 1.0
        assert abs(inked[-1] + 1 - box.bottom()) <= 1.0

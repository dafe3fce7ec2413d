"""Grips on the picture: turn, move, come near, roll, with nothing but a tip that touches them."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtCore, QtGui

from paint3d.app.window.icons import make_icon
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say

__all__ = ["GRIPS", "Grips"]

GRIPS = ("orbit", "pan", "dolly", "roll")
"""From the top, each by the name of its action."""

_ICONS = {"orbit": "orbit", "pan": "move", "dolly": "zoom", "roll": "roll"}
_SIZE, _GAP, _MARGIN = 36, 8, 14
_EDGE = 2  # around what is drawn, for its lines


class Grips:
    """A column of round grips in the upper right corner of a canvas.

    Parameters
    ----------
    theme : callable
        Returns the colours to use.

    Attributes
    ----------
    shown : bool
    held, under : str or None
        The grip that is held, and the one under the pointer.
    """

    def __init__(self, theme: Callable[[], Theme]) -> None:
        self._theme = theme
        self.shown = True
        self.held: str | None = None
        self.under: str | None = None
        self._looks: tuple[Theme, str | None, str | None, float] | None = None
        self._drawn = QtGui.QPixmap()

    def box(self, name: str, area: QtCore.QRect) -> QtCore.QRectF:
        """Where a grip lies in a picture."""
        top = _MARGIN + GRIPS.index(name) * (_SIZE + _GAP)
        return QtCore.QRectF(area.right() + 1 - _MARGIN - _SIZE, area.top() + top, _SIZE, _SIZE)

    def at(self, x: float, y: float, area: QtCore.QRect) -> str | None:
        """The grip at a place, or None."""
        if not self.shown:
            return None
        place = QtCore.QPointF(x, y)
        half = 0.5 * _GAP
        return next(
            (
                n
                for n in GRIPS
                if self.box(n, area).adjusted(-half, -half, half, half).contains(place)
            ),
            None,
        )

    def tool_tip(self, name: str) -> str:
        """What is said of a grip."""
        return say("grip.drag", action=say(f"action.{name}")) + {
            "roll": f"\n{say('grip.tap', action=say('action.upright'))}",
            "dolly": f"\n{say('grip.tap', action=say('action.frame_all'))}",
        }.get(name, "")

    def paint(self, painter: QtGui.QPainter, area: QtCore.QRect) -> None:
        """Draw them."""
        if not self.shown:
            return
        looks = self._theme(), self.held, self.under, painter.device().devicePixelRatioF()
        if looks != self._looks:
            self._looks, self._drawn = looks, self._draw(looks[0], looks[3])
        corner = self.box(GRIPS[0], area).topLeft()
        painter.drawPixmap(corner - QtCore.QPointF(_EDGE, _EDGE), self._drawn)

    def _draw(self, theme: Theme, pixel_ratio: float) -> QtGui.QPixmap:
        """The whole column, which every picture shows: drawing its icons takes 4 ms."""
        high = len(GRIPS) * (_SIZE + _GAP) - _GAP
        size = QtCore.QSize(_SIZE + 2 * _EDGE, high + 2 * _EDGE)
        column = QtGui.QPixmap(size * pixel_ratio)
        column.setDevicePixelRatio(pixel_ratio)
        column.fill(QtCore.Qt.GlobalColor.transparent)
        painter = QtGui.QPainter(column)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        for k, name in enumerate(GRIPS):
            box = QtCore.QRectF(_EDGE, _EDGE + k * (_SIZE + _GAP), _SIZE, _SIZE)
            marked = name in (self.held, self.under)
            fill = QtGui.QColor(theme.chosen if name == self.held else theme.panel)
            fill.setAlpha(235 if marked else 150)
            painter.setPen(QtGui.QPen(QtGui.QColor(theme.accent if marked else theme.line), 1.2))
            painter.setBrush(fill)
            painter.drawEllipse(box)
            inner = box.adjusted(8, 8, -8, -8).toRect()
            make_icon(_ICONS[name], theme).paint(painter, inner)
        painter.end()
        return column

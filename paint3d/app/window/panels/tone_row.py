"""The five tones of one ink as buttons: burnt, thick, heavy, light, clear."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.previews import Ink, ink_coat
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import language, say
from paint3d.colour.inks import TONES
from paint3d.colour.pigments import WATER

__all__ = ["ToneRow", "in_tone"]

_ICON = QtCore.QSize(26, 18)


def in_tone(parts: Mapping[Ink, float], share: float) -> dict[Ink, float]:
    """A mixture with so much of it ink, 0 to 1, and the rest water; the inks keep their ratio."""
    inked = {k: part for k, part in parts.items() if k is not WATER and k != WATER.name}
    total = sum(inked.values())
    if not total:
        return {}
    toned = {ink: share * part / total for ink, part in inked.items()}
    return {**toned, WATER.name: 1.0 - share} if share < 1.0 else toned


class ToneRow(QtWidgets.QWidget):
    """Five buttons that show a coat of the ink on xuan.

    Signals
    -------
    chosen : float
        How much of the tone is ink.
    """

    chosen = QtCore.Signal(float)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.buttons: dict[str, QtWidgets.QToolButton] = {}
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        for name, tone in TONES.items():
            button = QtWidgets.QToolButton()
            button.setObjectName(f"tone_{name}")
            button.setIconSize(_ICON)
            called = tone.chinese if language() == "zh" else say(name.capitalize())
            told = say("{tone}: {share:.0f} % ink, the rest water", tone=called,
                       share=100.0 * tone.share)  # fmt: skip
            button.setToolTip(told)
            button.setAccessibleName(called)
            button.setText(called)
            button.setToolButtonStyle(QtCore.Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
            button.setSizePolicy(
                QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Fixed
            )
            button.clicked.connect(lambda _=False, share=tone.share: self.chosen.emit(share))
            row.addWidget(button)
            self.buttons[name] = button

    def show_ink(self, parts: Mapping[Ink, float], theme: Theme) -> None:
        """Show the tones of this mixture; none where it is only water."""
        self._theme = theme
        for name, tone in TONES.items():
            toned = in_tone(parts, tone.share)
            self.buttons[name].setEnabled(bool(toned))
            self.buttons[name].setIcon(QtGui.QIcon(self._coat(toned)))

    def _coat(self, parts: Mapping[Ink, float]) -> QtGui.QPixmap:
        pixmap = QtGui.QPixmap(_ICON * 2)
        pixmap.fill(QtCore.Qt.GlobalColor.transparent)
        painter = QtGui.QPainter(pixmap)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        painter.setPen(QtGui.QPen(QtGui.QColor(self._theme.line), 2))
        painter.setBrush(QtGui.QColor(*ink_coat(parts)))
        painter.drawRoundedRect(QtCore.QRectF(pixmap.rect()).adjusted(1, 1, -1, -1), 8, 8)
        painter.end()
        pixmap.setDevicePixelRatio(2.0)
        return pixmap

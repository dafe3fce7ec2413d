"""A box to choose a font of the system in: asked for when it is first wanted."""

from __future__ import annotations

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.wording import say
from paint3d.calligraphy.fonts.font_file import list_fonts
from paint3d.errors import InputError

__all__ = ["FontBox"]


class FontBox(QtWidgets.QComboBox):
    """The families that `paint3d fonts` lists, after the lines of known characters."""

    def __init__(self) -> None:
        super().__init__()
        self.addItem(say("Characters of the copybook"), "")
        self.setSizeAdjustPolicy(
            QtWidgets.QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.setMinimumContentsLength(10)
        self._filled = False

    @property
    def font_name(self) -> str:
        """The family that is chosen; none for known characters."""
        return str(self.currentData())

    def showPopup(self) -> None:
        """List the fonts, and show them."""
        self._fill()
        super().showPopup()

    def focusInEvent(self, event: QtGui.QFocusEvent) -> None:
        """List the fonts before keys go through them."""
        self._fill()
        super().focusInEvent(event)

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Leave the wheel to what it scrolls, unless one is choosing."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def _fill(self) -> None:
        if self._filled:
            return
        self._filled = True
        try:
            families = dict.fromkeys(font.family for font in list_fonts())
        except InputError:
            return  # nobody can be asked
        with QtCore.QSignalBlocker(self):
            for family in families:
                self.addItem(family, family)

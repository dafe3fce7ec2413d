"""A box of the system's fonts, each shown in itself; they are listed when first needed."""

from __future__ import annotations

from functools import lru_cache

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.calligraphy.fonts.font_file import list_fonts
from paint3d.errors import InputError

__all__ = ["FontBox"]

_CHINESE, _LATIN = "永和九年", "Aa Bb"
_LEAST_WIDTH = 330  # pixels of the list
_SYSTEM = QtGui.QFontDatabase.WritingSystem
_HAN = (_SYSTEM.SimplifiedChinese, _SYSTEM.TraditionalChinese, _SYSTEM.Japanese)


class FontBox(QtWidgets.QComboBox):
    """The families that `paint3d fonts` lists, after a choice without any.

    Parameters
    ----------
    first : str
        Text of the choice without a font.
    """

    def __init__(self, first: str) -> None:
        super().__init__()
        self.addItem(first, "")
        self.setSizeAdjustPolicy(
            QtWidgets.QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.setMinimumContentsLength(10)
        self.setItemDelegate(_InItself(self))
        self._filled = False

    @property
    def font_name(self) -> str:
        """The chosen family; empty for the first choice."""
        return str(self.currentData())

    def show_font(self, family: str) -> None:
        """Show a family as chosen."""
        if self.findData(family) < 0:
            self._fill()
        if self.findData(family) < 0:
            self.addItem(family, family)
        self.setCurrentIndex(self.findData(family))

    def showPopup(self) -> None:
        """List the fonts, and show them."""
        self._fill()
        self.view().setMinimumWidth(_LEAST_WIDTH)
        super().showPopup()

    def focusInEvent(self, event: QtGui.QFocusEvent) -> None:
        """List the fonts before keys go through them."""
        self._fill()
        super().focusInEvent(event)

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Leave the wheel to the panel around, unless the box has the focus."""
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
            return  # the system lists no fonts
        with QtCore.QSignalBlocker(self):
            for family in families:
                if self.findData(family) < 0:
                    self.addItem(family, family)


class _InItself(QtWidgets.QStyledItemDelegate):
    """Draws a family's name as always, and beside it some characters in the font itself."""

    def paint(
        self,
        painter: QtGui.QPainter,
        option: QtWidgets.QStyleOptionViewItem,
        index: QtCore.QModelIndex | QtCore.QPersistentModelIndex,
    ) -> None:
        """Draw a row."""
        super().paint(painter, option, index)
        family = str(index.data(QtCore.Qt.ItemDataRole.UserRole) or "")
        if not family:
            return
        painter.save()
        font = QtGui.QFont(family)
        font.setPointSizeF(1.25 * option.font.pointSizeF())
        painter.setFont(font)
        right = QtCore.Qt.AlignmentFlag.AlignRight | QtCore.Qt.AlignmentFlag.AlignVCenter
        area = option.rect.adjusted(0, 0, -10, 0)
        painter.drawText(area, right, _sample(family))
        painter.restore()


@lru_cache(maxsize=1024)
def _sample(family: str) -> str:
    """Return characters that show a font: Chinese ones if it has them."""
    known = QtGui.QFontDatabase.writingSystems(family)
    return _CHINESE if any(one in known for one in _HAN) else _LATIN

"""What is cut into a seal: a text or a drawing, its style and size."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from PySide6 import QtWidgets

from paint3d.app.window.dialogs.forms import FormDialog
from paint3d.app.window.wording import say
from paint3d.calligraphy.fonts.font_file import list_fonts
from paint3d.calligraphy.seal.stone import LARGEST_MM, SMALLEST_MM
from paint3d.errors import InputError

__all__ = ["SealAsked", "SealDialog"]


class SealAsked(NamedTuple):
    """A seal as it is asked for: a text, or the path of a drawing."""

    text: str = "永和"
    drawing: str = ""
    style: str = "zhuwen"
    size_mm: float = 16.0
    font: str = ""


class SealDialog(FormDialog):
    """Ask for a seal.

    Parameters
    ----------
    parent : QWidget
    kept : SealAsked
        What was asked for last.
    """

    def __init__(self, parent: QtWidgets.QWidget, kept: SealAsked) -> None:
        super().__init__(parent, say("Press a seal…").rstrip("…"))
        self.text = QtWidgets.QLineEdit(kept.text)
        self.form.addRow(say("copybook.text"), self.text)
        families = {"": say("Lines of one width")} | {name: name for name in _families()}
        self.font_box = self.add_box(say("Font"), families, kept.font)
        self.drawing = QtWidgets.QLineEdit(kept.drawing)
        self.drawing.setPlaceholderText(say("A drawing instead of the text"))
        self.drawing.setClearButtonEnabled(True)
        self.choose = QtWidgets.QPushButton("…")
        self.choose.clicked.connect(self._choose)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.drawing, 1)
        row.addWidget(self.choose)
        self.form.addRow("SVG", row)
        styles = {"zhuwen": say("Red lines (zhuwen)"), "baiwen": say("White lines (baiwen)")}
        self.style_box = self.add_box(say("Style"), styles, kept.style)
        self.size_box = self.add_number(
            say("Longer side"), SMALLEST_MM, LARGEST_MM, kept.size_mm, "mm", 1
        )
        self.finish("OK")
        self.text.setFocus()
        self.text.selectAll()

    def _choose(self) -> None:
        dialog = QtWidgets.QFileDialog(self, say("A drawing"), filter="SVG (*.svg)")
        dialog.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
        if self.drawing.text():
            dialog.setDirectory(str(Path(self.drawing.text()).parent))
        if dialog.exec() and dialog.selectedFiles():
            self.drawing.setText(dialog.selectedFiles()[0])

    def asked(self) -> SealAsked:
        """What was asked for."""
        return SealAsked(
            self.text.text().strip(),
            self.drawing.text().strip(),
            self.style_box.currentData(),
            self.size_box.value(),
            self.font_box.currentData(),
        )


def _families() -> list[str]:
    """The families of the system's fonts; none where nobody can be asked."""
    try:
        return list(dict.fromkeys(font.family for font in list_fonts()))
    except InputError:
        return []

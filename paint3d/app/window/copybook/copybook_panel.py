"""The copybook: characters as ghosts on the object, and how well each was met."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.copybook import Copybook, Score
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say
from paint3d.calligraphy.fonts.font_file import list_fonts
from paint3d.calligraphy.page.opening import PAGE_FILES
from paint3d.errors import InputError
from paint3d.files.photographs import PHOTOGRAPH_SUFFIXES

__all__ = ["CopybookPanel", "FontBox"]

# ---- Fonts ---------------------------------------------------------------------------------------
# A box to choose a font of the system in: asked for when it is first wanted.


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


# --------------------------------------------------------------------------------------------------


_EXAMPLE = "永和九年"
_GOOD = 85  # per cent: what counts as met


class CopybookPanel(QtWidgets.QWidget):
    """Ask for a text to write; say how like it is.

    Signals
    -------
    asked : (str, float, bool, str)
        Text, em in mm, whether it runs in columns, and the font; none for known characters.
    opened : (str, float)
        A drawing or a file of strokes, and its size in mm.
    corrected : ()
        The strokes of what was laid out are to be looked at over their picture.
    hidden : ()
        The ghosts are to go.
    """

    asked = QtCore.Signal(str, float, bool, str)
    opened = QtCore.Signal(str, float)
    corrected = QtCore.Signal()
    hidden = QtCore.Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.copybook: Copybook | None = None
        self._coming: list[Future[Any]] = []
        self._scores: dict[int, Score] = {}
        self.text = QtWidgets.QLineEdit(_EXAMPLE)
        self.em = QtWidgets.QDoubleSpinBox()
        self.em.setRange(2.0, 1000.0)
        self.em.setDecimals(0)
        self.em.setValue(40.0)
        self.em.setSuffix(" mm")
        self.direction = QtWidgets.QComboBox()
        self.direction.addItem(say("Columns"), True)
        self.direction.addItem(say("Row"), False)
        self.font_box = FontBox()
        layout_text = QtWidgets.QPushButton(say("Lay out"))
        self.open_button = QtWidgets.QPushButton(say("Open a drawing, strokes or a photograph…"))
        self.open_button.clicked.connect(self.choose_file)
        self.correct_button = QtWidgets.QPushButton(say("Strokes over the picture…"))
        self.correct_button.setToolTip(
            say("Order, direction and shape of the strokes of a font, a drawing or a photograph")
        )
        self.correct_button.clicked.connect(self.corrected)
        self.correct_button.setEnabled(False)
        hide = QtWidgets.QPushButton(say("Hide"))
        layout_text.clicked.connect(self.ask)
        hide.clicked.connect(self.hidden)
        self.told = QtWidgets.QLabel()
        self.told.setObjectName("title")
        self.list = QtWidgets.QListWidget()
        self.list.setObjectName("copybook")
        form = QtWidgets.QFormLayout()
        form.addRow(say("Text"), self.text)
        form.addRow(say("Font"), self.font_box)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.em, 1)
        row.addWidget(self.direction, 1)
        form.addRow(say("Size"), row)
        buttons = QtWidgets.QHBoxLayout()
        buttons.addWidget(layout_text, 1)
        buttons.addWidget(hide, 1)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(10, 6, 10, 8)
        layout.addLayout(form)
        layout.addLayout(buttons)
        layout.addWidget(self.open_button)
        layout.addWidget(self.correct_button)
        layout.addWidget(self.told)
        layout.addWidget(self.list, 1)

    def ask(self) -> None:
        """Ask for what is written here."""
        if self.text.text().strip():
            text, columns = self.text.text().strip(), self.direction.currentData()
            self.asked.emit(text, self.em.value(), columns, self.font_box.font_name)

    def choose_file(self) -> None:
        """Ask for a drawing or a file of strokes."""
        endings = " ".join("*" + kind for kind in (*PAGE_FILES, *PHOTOGRAPH_SUFFIXES))
        kinds = f"{say('Drawings, strokes and photographs')} ({endings})"
        dialog = QtWidgets.QFileDialog(
            self, say("Open a drawing, strokes or a photograph…"), filter=kinds
        )
        dialog.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
        if dialog.exec() and dialog.selectedFiles():
            self.opened.emit(dialog.selectedFiles()[0], self.em.value())

    def show_copybook(self, copybook: Copybook | None) -> None:
        """Show another copybook, or none."""
        self.copybook, self._scores, self._coming = copybook, {}, []
        self.correct_button.setEnabled(copybook is not None and copybook.page is not None)
        self._fill()

    def expect(self, coming: Future[Any]) -> None:
        """Show the score of a stroke when it is there."""
        self._coming.append(coming)

    def follow(self) -> bool:
        """Take the scores that have come; True if there were any."""
        done = [coming for coming in self._coming if coming.done()]
        self._coming = [coming for coming in self._coming if not coming.done()]
        scores = [one.result() for one in done if one.exception() is None]
        scores = [score for score in scores if score is not None]
        for score in scores:
            self._scores[score.place] = score
        if scores:
            self._fill()
        return bool(scores)

    def percent(self, place: int) -> float | None:
        """How like its copybook a character is, 0 to 100; None before it is written."""
        score = self._scores.get(place)
        if score is None or score.likeness is None:
            return None
        return 100.0 * score.likeness.iou

    def _fill(self) -> None:
        self.list.clear()
        ghosts = self.copybook.ghosts if self.copybook is not None else ()
        for place, ghost in enumerate(ghosts):
            percent = self.percent(place)
            n = len(ghost.strokes)
            text = f"{ghost.text}   {n} / {len(ghost.glyph.strokes)}"
            if percent is not None:
                mark = "✓" if percent >= _GOOD else "·"
                message = say("{character}: {percent:.0f} %", character=ghost.text, percent=percent)
                text = f"{mark}  {message}   {ghost.seconds:.1f} s"
            item = QtWidgets.QListWidgetItem(text)
            if percent is not None and percent >= _GOOD:
                item.setForeground(QtGui.QColor(self._theme.good))
            self.list.addItem(item)
        following = self.copybook.next if self.copybook is not None else None
        if self.copybook is None:
            self.told.setText("")
        elif following is None:
            self.told.setText(say("All characters are written"))
        else:
            self.told.setText(say("Next: {character}", character=ghosts[following].text))
            self.list.setCurrentRow(following)

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        self._fill()

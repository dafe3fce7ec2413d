"""The copybook: characters as ghosts on the object, and how well each was met."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.copybook import Copybook
from paint3d.app.model.laid_text import GRIDS, LaidText
from paint3d.app.window.files.file_dialogs import look_at_names_only
from paint3d.app.window.font_box import FontBox
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say
from paint3d.calligraphy.composition import stands_in_squares
from paint3d.calligraphy.page.opening import PAGE_FILES
from paint3d.errors import InputError, Message
from paint3d.files.photographs import PHOTOGRAPH_SUFFIXES

__all__ = ["CopybookPanel"]

_EXAMPLE = "永和九年"
_FIRST = LaidText()  # the values shown when a painting is opened
_GRID_NAMES = {
    "frame": Message("Squares"),
    "mi": Message("Cross and diagonals (mi)"),
    "jiu": Message("Nine fields (jiu)"),
    "tian": Message("Cross (tian)"),
    "columns": Message("Lines between columns"),
    "none": Message("No grid"),
}


def _reads_down(text: str) -> bool | None:
    """Return whether a text is usually written in columns; None without a letter."""
    with suppress(InputError):
        return stands_in_squares(text)
    return None


class _Lines(QtWidgets.QPlainTextEdit):
    """A text of some lines, finished by Ctrl+Enter.

    Signals
    -------
    finished : ()
    """

    finished = QtCore.Signal()

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.setTabChangesFocus(True)
        high = 3 * self.fontMetrics().lineSpacing() + 14
        self.setFixedHeight(high)
        self.setToolTip(say("A line for each column or row; Ctrl+Enter lays it out"))

    def text(self) -> str:
        """Return the text."""
        return self.toPlainText()

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Finish by Ctrl+Enter."""
        enter = event.key() in (QtCore.Qt.Key.Key_Return, QtCore.Qt.Key.Key_Enter)
        if enter and event.modifiers() & QtCore.Qt.KeyboardModifier.ControlModifier:
            self.finished.emit()
        else:
            super().keyPressEvent(event)


def _side_by_side(*widgets: QtWidgets.QWidget) -> QtWidgets.QHBoxLayout:
    row = QtWidgets.QHBoxLayout()
    for widget in widgets:
        row.addWidget(widget, 1)
    return row


_LEAST_WIDTH = 60  # pixels, of a number
_GOOD = 85  # per cent: what counts as met


class CopybookPanel(QtWidgets.QWidget):
    """Asks for a text to write; shows how well each character was met.

    Signals
    -------
    asked : (dict, bool)
        The text's values, by the names of `LaidText`, and `fills`: whether it is to fill the sheet;
        and whether it is another text.
    opened : (str, float)
        A drawing or a file of strokes, and its size in mm.
    corrected : ()
        The strokes of what was laid out are to be looked at over their picture.
    hidden : ()
        The chosen text is to be removed.
    chosen : int
        The text of this number is to be chosen.
    changed : dict
        The chosen text is to have other values.
    nudged : (float, float)
        It is to be moved to the right and upwards, mm.
    moving : bool
        Texts are to be moved on the object, or no longer.
    signed : ()
        A signature is to be laid beside it.
    sealed : ()
        A seal is to be pressed.
    written : ()
        The chosen text is to be written with the brush.
    """

    asked = QtCore.Signal(object, bool)
    opened = QtCore.Signal(str, float)
    corrected = QtCore.Signal()
    hidden = QtCore.Signal()
    chosen = QtCore.Signal(int)
    changed = QtCore.Signal(object)
    nudged = QtCore.Signal(float, float)
    moving = QtCore.Signal(bool)
    signed = QtCore.Signal()
    sealed = QtCore.Signal()
    written = QtCore.Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.copybook: Copybook | None = None
        self._coming: list[Future[Any]] = []
        self.texts = QtWidgets.QComboBox()
        self.texts.setSizeAdjustPolicy(
            QtWidgets.QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.texts.activated.connect(self.chosen)
        self.text = _Lines(_EXAMPLE)
        self.text.finished.connect(self.ask)
        self._order_chosen = self._shows_signature = False
        self.em = self._number("em_mm", 2.0, 1000.0, 40.0, " mm")
        self.fill_box = QtWidgets.QCheckBox(say("Fill the sheet"))
        self.fill_box.setToolTip(
            say("Size, columns and distances are found; a number of your own takes it off")
        )
        self.fill_box.setChecked(True)
        self.around_box = QtWidgets.QCheckBox(say("All around the object"))
        self.direction = QtWidgets.QComboBox()
        self.direction.addItem(say("Columns"), True)
        self.direction.addItem(say("Row"), False)
        self.direction.activated.connect(self._choose_order)
        self.font_box = FontBox(say("Characters of the copybook"))
        self.grid_box = QtWidgets.QComboBox()
        for kind in GRIDS:
            self.grid_box.addItem(say(_GRID_NAMES[kind]), kind)
        self.grid_box.activated.connect(
            lambda _: self.changed.emit({"grid": self.grid_box.currentData()})
        )
        self.across, self.down = QtWidgets.QSpinBox(), QtWidgets.QSpinBox()
        for box, n in ((self.across, 4), (self.down, 5)):
            box.setRange(1, 40)
            box.setValue(n)
            box.setToolTip(say("Squares of a grid without a text"))
            box.setEnabled(False)
        self.text.textChanged.connect(self._suit_text)
        self.turn = self._number("turn", -180.0, 180.0, 0.0, "°", 1)
        self.around_box.toggled.connect(self.turn.setDisabled)
        self.around_box.toggled.connect(lambda on: self.changed.emit({"around": on}))
        self.gap = self._number("gap", 0.0, 500.0, 10.0, " %")
        self.between = self._number("between", 0.0, 500.0, 0.0, " %")
        self.gap.setToolTip(say("Room between columns, or rows, in parts of the size"))
        self.between.setToolTip(say("Room between characters, in parts of the size"))
        self.right, self.up = self._mover(), self._mover()
        self.right.setToolTip(say("To the right (x)"))
        self.up.setToolTip(say("Upwards (y)"))
        self.right.valueChanged.connect(lambda: self._nudge(self.right))
        self.up.valueChanged.connect(lambda: self._nudge(self.up))
        layout_text = QtWidgets.QPushButton(say("Lay out"))
        self.add_button = QtWidgets.QPushButton(say("Another"))
        self.add_button.setToolTip(say("Lay it out beside the texts that are there"))
        self.add_button.clicked.connect(lambda: self._ask(True))
        self.sign_button = QtWidgets.QPushButton(say("Signature and date…"))
        self.sign_button.clicked.connect(self.signed)
        self.seal_button = QtWidgets.QPushButton(say("Press a seal…"))
        self.seal_button.clicked.connect(self.sealed)
        self.write_button = QtWidgets.QPushButton(say("Write it with the brush"))
        self.write_button.setToolTip(
            say("The brush and the ink in hand write it, stroke by stroke; also by Shift+T")
        )
        self.write_button.clicked.connect(self.written)
        self.move_button = QtWidgets.QPushButton(say("Move on the object"))
        self.move_button.setCheckable(True)
        self.move_button.setToolTip(say("Drag, turn, scale and space texts; also by T"))
        self.move_button.toggled.connect(self.moving)
        self.open_button = QtWidgets.QPushButton(say("Open a drawing, strokes or a photograph…"))
        self.open_button.clicked.connect(self.choose_file)
        self.correct_button = QtWidgets.QPushButton(say("Strokes over the picture…"))
        self.correct_button.setToolTip(
            say("Order, direction and shape of the strokes of a font, a drawing or a photograph")
        )
        self.correct_button.clicked.connect(self.corrected)
        self.correct_button.setEnabled(False)
        hide = QtWidgets.QPushButton(say("Take the guide away"))
        layout_text.clicked.connect(self.ask)
        hide.clicked.connect(self.hidden)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setObjectName("title")
        self.list = QtWidgets.QListWidget()
        self.list.setObjectName("copybook")
        self.list.setAccessibleName(say("Characters"))
        small = QtWidgets.QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        for choice in (self.direction, self.grid_box):
            choice.setSizeAdjustPolicy(small)
            choice.setMinimumContentsLength(5)
        numbers = (self.em, self.gap, self.between, self.right, self.up, self.across, self.down)
        for number in numbers:
            number.setMinimumWidth(_LEAST_WIDTH)
        for asked, text in (
            (self.gap, say("Room between columns, or rows, in parts of the size")),
            (self.between, say("Room between characters, in parts of the size")),
            (self.right, say("To the right (x)")),
            (self.up, say("Upwards (y)")),
            (self.across, say("Squares across")),
            (self.down, say("Squares down")),
            (self.em, say("Size")),
        ):
            asked.setAccessibleName(text)
        form = QtWidgets.QFormLayout()
        form.addRow(say("Laid out"), self.texts)
        form.addRow(say("Text"), self.text)
        form.addRow(say("Font"), self.font_box)
        form.addRow(say("Size"), _side_by_side(self.em, self.direction))
        form.addRow("", self.fill_box)
        form.addRow("", self.around_box)
        form.addRow(say("Grid"), self.grid_box)
        in_numbers = QtWidgets.QFormLayout()  # below the buttons, which most ask for
        in_numbers.addRow(say("Squares"), _side_by_side(self.across, self.down))
        in_numbers.addRow(say("Apart"), _side_by_side(self.gap, self.between))
        in_numbers.addRow(say("Turned"), self.turn)
        in_numbers.addRow(say("Moved by"), _side_by_side(self.right, self.up))
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(10, 6, 10, 8)
        layout.addLayout(form)
        self._form = form
        self._offer_filling(False)
        layout.addLayout(_side_by_side(layout_text, self.add_button))
        layout.addWidget(self.write_button)
        layout.addLayout(_side_by_side(self.sign_button, self.seal_button))
        layout.addLayout(_side_by_side(self.move_button, hide))
        layout.addLayout(in_numbers)
        layout.addWidget(self.open_button)
        layout.addWidget(self.correct_button)
        layout.addWidget(self.message_label)
        layout.addWidget(self.list, 1)
        self.show_texts([], None)

    def _number(
        self, name: str, low: float, high: float, value: float, unit: str, digits: int = 0
    ) -> QtWidgets.QDoubleSpinBox:
        """Make a box for a number of the chosen text; percents are emitted as parts of 1."""
        box = QtWidgets.QDoubleSpinBox()
        box.setRange(low, high)
        box.setDecimals(digits)
        box.setValue(value)
        box.setSuffix(unit)
        box.setKeyboardTracking(False)
        part = 0.01 if unit == " %" else 1.0
        box.valueChanged.connect(lambda number: self.changed.emit({name: part * number}))
        return box

    def _mover(self) -> QtWidgets.QDoubleSpinBox:
        """Make a box for the distance that the text is moved by since it was chosen."""
        box = QtWidgets.QDoubleSpinBox()
        box.setRange(-5000.0, 5000.0)
        box.setDecimals(1)
        box.setSuffix(" mm")
        box.setKeyboardTracking(False)
        box.setProperty("before", 0.0)
        return box

    def _nudge(self, box: QtWidgets.QDoubleSpinBox) -> None:
        more = box.value() - float(box.property("before"))
        box.setProperty("before", box.value())
        self.nudged.emit(*((more, 0.0) if box is self.right else (0.0, more)))

    def show_texts(self, titles: Sequence[str], chosen: int | None) -> None:
        """Show the texts, and the chosen one."""
        before = self.texts.count(), self.texts.currentIndex()
        with QtCore.QSignalBlocker(self.texts):
            self.texts.clear()
            self.texts.addItems(list(titles))
            self.texts.setCurrentIndex(-1 if chosen is None else chosen)
        self.texts.setEnabled(bool(titles))
        if before != (self.texts.count(), self.texts.currentIndex()):
            for box in (self.right, self.up):
                with QtCore.QSignalBlocker(box):
                    box.setValue(0.0)
                box.setProperty("before", 0.0)

    def show_values(self, laid: LaidText | None) -> None:
        """Show the chosen text's values; without one they stay as they are."""
        if laid is None:
            return
        boxes = (
            self.em, self.turn, self.gap, self.between, self.across, self.down, self.around_box,
        )  # fmt: skip
        blocked = [QtCore.QSignalBlocker(box) for box in boxes]
        self.em.setValue(laid.em_mm)
        self.around_box.setChecked(laid.around)
        self.turn.setValue(laid.turn)
        self.turn.setDisabled(laid.around)
        self.gap.setValue(100.0 * laid.gap)
        self.between.setValue(100.0 * laid.between)
        self.across.setValue(laid.cells[0])
        self.down.setValue(laid.cells[1])
        del blocked
        self.direction.setCurrentIndex(self.direction.findData(laid.order == "columns"))
        self.grid_box.setCurrentIndex(self.grid_box.findData(laid.grid))
        self.font_box.show_font(laid.font)
        self._shows_signature = laid.is_signature
        self._order_chosen = _reads_down(laid.text) not in (None, laid.order == "columns")
        if not self.text.hasFocus():
            with QtCore.QSignalBlocker(self.text):
                self.text.setPlainText(laid.text)
            self._offer_squares()

    def begin_anew(self, *, on_sheet: bool) -> None:
        """Show the values of a first text; one that was typed for another painting stays.

        A signature is that painting's own.
        """
        typed = "" if self._shows_signature else self.text.text()
        self.show_values(_FIRST.moved(text=_EXAMPLE))
        if typed:
            with QtCore.QSignalBlocker(self.text):
                self.text.setPlainText(typed)
        self._order_chosen = False
        self._suit_text()
        self._offer_filling(on_sheet)

    @property
    def fills(self) -> bool:
        """True if a text that is laid out is to fill the sheet."""
        return self._form.isRowVisible(self.fill_box) and self.fill_box.isChecked()

    def _offer_filling(self, on: bool) -> None:
        """Show whether text fills the sheet, where there is one."""
        self.fill_box.setChecked(True)
        with QtCore.QSignalBlocker(self.around_box):
            self.around_box.setChecked(False)
        self.turn.setEnabled(True)
        self._form.setRowVisible(self.fill_box, on)
        self._form.setRowVisible(self.around_box, not on)

    def show_moving(self, on: bool) -> None:
        """Show whether texts are moved."""
        with QtCore.QSignalBlocker(self.move_button):
            self.move_button.setChecked(on)

    @property
    def _order(self) -> str:
        return "columns" if self.direction.currentData() else "row"

    def _suit_text(self) -> None:
        """Offer squares only without a text, and a row for letters unless an order was chosen."""
        self._offer_squares()
        columns = _reads_down(self.text.text())
        if columns is not None and not self._order_chosen:
            self.direction.setCurrentIndex(self.direction.findData(columns))

    def _offer_squares(self) -> None:
        for box in (self.across, self.down):
            box.setEnabled(not self.text.text().strip())

    def _choose_order(self) -> None:
        """Lay the chosen text the other way."""
        self._order_chosen = True
        self.changed.emit({"order": self._order})

    def ask(self) -> None:
        """Ask to lay out the text."""
        self._ask(False)

    def _ask(self, another: bool) -> None:
        values = {
            "text": self.text.text().strip(),
            "em_mm": self.em.value(),
            "order": self._order,
            "font": self.font_box.font_name,
            "grid": self.grid_box.currentData(),
            "cells": (self.across.value(), self.down.value()),
            "gap": 0.01 * self.gap.value(),
            "between": 0.01 * self.between.value(),
            "turn": 0.0 if self.around_box.isChecked() else self.turn.value(),
            "around": self.around_box.isChecked(),
            "fills": self.fills,
        }
        self.asked.emit(values, another)

    def choose_file(self) -> None:
        """Ask for a drawing or a file of strokes."""
        endings = " ".join("*" + kind for kind in (*PAGE_FILES, *PHOTOGRAPH_SUFFIXES))
        kinds = f"{say('Drawings, strokes and photographs')} ({endings})"
        dialog = QtWidgets.QFileDialog(
            self, say("Open a drawing, strokes or a photograph…"), filter=kinds
        )
        dialog.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
        look_at_names_only(dialog)
        if dialog.exec() and dialog.selectedFiles():
            self.opened.emit(dialog.selectedFiles()[0], self.em.value())

    def show_copybook(self, copybook: Copybook | None) -> None:
        """Show another copybook, or none."""
        self.copybook, self._coming = copybook, []
        self.correct_button.setEnabled(copybook is not None and copybook.page is not None)
        self.show_counts()

    def expect(self, coming: Future[Any]) -> None:
        """Show the score of a stroke when it has come."""
        self._coming.append(coming)

    def follow(self) -> bool:
        """Take the scores that have come; True if there were any."""
        done = [coming for coming in self._coming if coming.done()]
        self._coming = [coming for coming in self._coming if not coming.done()]
        scores = [one.result() for one in done if one.exception() is None]
        came = any(score is not None for score in scores)
        if came:
            self.show_counts()
        return came

    def percent(self, index: int) -> float | None:
        """Return a character's likeness to its copybook, 0 to 100; None before it is written."""
        mark = None if self.copybook is None else self.copybook.marks.get(index)
        if mark is None or mark.likeness is None:
            return None
        return 100.0 * mark.likeness.iou

    def show_counts(self) -> None:
        """Show how far each character is written."""
        self.list.clear()
        ghosts = self.copybook.ghosts if self.copybook is not None else ()
        for index, ghost in enumerate(ghosts):
            percent = self.percent(index)
            n = len(ghost.strokes)
            text = f"{ghost.text}   {n} / {len(ghost.glyph.strokes)}"
            if ghost.is_written:
                text = f"✓  {text}"
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
            self.message_label.setText("")
        elif following is None:
            self.message_label.setText(say("All characters are written"))
        else:
            summary = say(
                "{n} of {count} written; next: {character}",
                n=sum(ghost.is_written for ghost in ghosts), count=len(ghosts),
                character=ghosts[following].text,
            )  # fmt: skip
            self.message_label.setText(summary)
            self.list.setCurrentRow(following)

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        self.show_counts()

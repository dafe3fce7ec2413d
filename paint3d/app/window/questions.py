"""The questions that the window asks."""

from __future__ import annotations

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.commands import COMMANDS, GROUPS, SHORTCUTS, Shortcut
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.model.texts import load_texts
from paint3d.app.window.forms import FormDialog
from paint3d.app.window.wording import say, say_error
from paint3d.calligraphy.glyph_sources import open_glyph_folder
from paint3d.errors import Paint3DError
from paint3d.files.load import UNITS_MM

__all__ = ["Answer", "KeysDialog", "PreferencesDialog", "ask"]

_KEY_COLUMNS = 3

Answer = QtWidgets.QMessageBox.ButtonRole
"""What `ask` returns: AcceptRole, DestructiveRole or RejectRole."""


def ask(
    parent: QtWidgets.QWidget,
    text: str,
    *,
    accept: str = "",
    destroy: str = "",
    leave: str = "button.cancel",
    warns: bool = False,
) -> Answer:
    """Ask before something is lost. Escape and closing the box leave everything as it is.

    Parameters
    ----------
    parent : QWidget
    text : str
        In the language that is spoken.
    accept : str, optional
        What the button says that loses nothing, or its key; Enter presses it.
    destroy : str, optional
        What the button says that loses something, or its key.
    leave : str
        What the button says that does neither, or its key. Enter presses it where nothing is there
        to be accepted.
    warns : bool
        Whether the box bears the sign of a warning.

    Returns
    -------
    Answer
        The role of the button that was pressed.
    """
    box = QtWidgets.QMessageBox(parent)
    box.setWindowTitle("paint3d")
    box.setTextFormat(QtCore.Qt.TextFormat.PlainText)  # names of files are no marks
    box.setText(text)
    if warns:
        box.setIcon(QtWidgets.QMessageBox.Icon.Warning)
    roles = {Answer.AcceptRole: accept, Answer.DestructiveRole: destroy, Answer.RejectRole: leave}
    buttons = [box.addButton(say(words), role) for role, words in roles.items() if words]
    box.setDefaultButton(buttons[0 if accept else -1])
    box.setEscapeButton(buttons[-1])
    box.exec()
    pressed = box.clickedButton()
    box.deleteLater()
    return Answer.RejectRole if pressed is None else box.buttonRole(pressed)


class PreferencesDialog(FormDialog):
    """Ask how the program should be."""

    def __init__(self, parent: QtWidgets.QWidget, settings: Settings) -> None:
        super().__init__(parent, say("action.preferences").rstrip("…"))
        self.boxes: dict[str, QtWidgets.QComboBox] = {}
        self.numbers: dict[str, QtWidgets.QDoubleSpinBox] = {}
        rows = (
            ("language", "menu.language", "language.", ("system", "en", "zh")),
            ("theme", "menu.theme", "theme.", ("system", "light", "dark")),
            ("unit", "Lengths are shown in", "unit.", tuple(UNITS_MM)),
            ("pressure_by", "action.force", "hand.pressure_by_", ("keys", "speed")),
            ("finger", "finger.title", "finger.", ("auto", "paint", "turn")),
        )
        for name, label, prefix, choices in rows:
            texts = {choice: say(prefix + choice) for choice in choices}
            self.boxes[name] = self.add_box(say(label), texts, getattr(settings, name))
        wet = {None: say("As the material asks for"), True: say("Always"), False: say("Never")}
        self.boxes["wet"] = self.add_box(say("surface.wet"), wet, settings.wet)
        for name, label, low, high, unit in (
            ("autosave_s", "Keep a whole copy for recovery every", 10.0, 3600.0, "s"),
            ("undo_megabytes", "Memory for undo, from the next painting on", 16.0, 65536.0, "MB"),
        ):
            value = getattr(settings, name)
            self.numbers[name] = self.add_number(say(label), low, high, value, unit)
        self.glyphs = QtWidgets.QLineEdit(settings.glyphs)
        self.glyphs.setPlaceholderText(say("of hanzi-writer-data; empty: those that come along"))
        self.glyphs.setClearButtonEnabled(True)
        choose = QtWidgets.QPushButton("…")
        choose.clicked.connect(self._choose_folder)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.glyphs, 1)
        row.addWidget(choose)
        self.form.addRow(say("Folder of characters"), row)
        self.finish("button.ok")

    def _choose_folder(self) -> None:
        found = QtWidgets.QFileDialog.getExistingDirectory(
            self,
            say("Folder of characters"),
            self.glyphs.text(),
            QtWidgets.QFileDialog.Option.DontUseNativeDialog,
        )
        if found:
            self.glyphs.setText(found)

    def accept(self) -> None:
        """Agree, unless the folder of characters is none."""
        folder = self.glyphs.text().strip()
        try:
            if folder:
                open_glyph_folder(folder)
        except Paint3DError as error:
            ask(self, say_error(error), accept="button.ok", leave="")
            return
        super().accept()

    def chosen(self) -> dict[str, object]:
        """Settings by name."""
        numbers = {name: box.value() for name, box in self.numbers.items()}
        boxes = {name: box.currentData() for name, box in self.boxes.items()}
        return {**boxes, **numbers, "glyphs": self.glyphs.text().strip()}


class KeysDialog(QtWidgets.QDialog):
    """The whole key map."""

    def __init__(self, parent: QtWidgets.QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("action.shortcuts"))
        layout = QtWidgets.QVBoxLayout(self)
        area, inner = QtWidgets.QScrollArea(), QtWidgets.QWidget()
        columns = QtWidgets.QHBoxLayout(inner)
        columns.setSpacing(26)
        for groups in _balanced(_KEY_COLUMNS):
            column = QtWidgets.QVBoxLayout()
            for group in groups:
                column.addWidget(_key_table(group))
                column.addSpacing(8)
            column.addStretch(1)
            columns.addLayout(column, 1)
        area.setWidget(inner)
        area.setWidgetResizable(True)
        layout.addWidget(area)
        self.resize(min(1240, parent.width()), 660)


def _of_group(group: str) -> list[Shortcut]:
    return [one for one in SHORTCUTS if one.group == group and not one.action[-1].isdigit()]


def _balanced(n: int) -> list[list[str]]:
    """Groups in n columns of about the same length, in order."""
    total = sum(len(_of_group(group)) + 2 for group in GROUPS)
    columns: list[list[str]] = [[]]
    filled = 0
    for group in GROUPS:
        rows = len(_of_group(group)) + 2
        if filled + rows / 2 > total / n * len(columns) and len(columns) < n:
            columns.append([])
        columns[-1].append(group)
        filled += rows
    return columns


_ARROWS = {"Left": "←", "Right": "→", "Up": "↑", "Down": "↓"}


def _keys_told(one: Shortcut) -> str:
    """Keys, buttons or fingers in words, and what is done with them unless they are pressed."""
    *held, last = one.keys.replace("++", "+plus").replace("Num+", "Num ").split("+")
    words = [say("keys.space") if key == "Space" else key for key in held]
    kind, _, number = last.partition(" ")
    if kind in ("Pen", "Fingers"):
        words.append(say(f"keys.{kind.lower()}", number=number))
    elif kind == "Num":
        words.append(say("keys.num", name=number.replace("plus", "+")))
    elif one.gesture == "press":
        words.append(_ARROWS.get(last, last))
    elif f"keys.{last.lower()}" in load_texts():
        words.append(say(f"keys.{last.lower()}"))
    else:
        words.append(last)
    message = "+".join(words)
    return message if one.gesture == "press" else f"{message}  ({say('gesture.' + one.gesture)})"


def _key_table(group: str) -> QtWidgets.QWidget:
    box = QtWidgets.QWidget()
    grid = QtWidgets.QGridLayout(box)
    grid.setContentsMargins(0, 0, 0, 0)
    grid.setHorizontalSpacing(12)
    grid.setVerticalSpacing(3)
    grid.setColumnStretch(1, 1)
    head = QtWidgets.QLabel(say(f"group.{group}"))
    head.setObjectName("heading")
    grid.addWidget(head, 0, 0, 1, 2)
    top = QtCore.Qt.AlignmentFlag.AlignTop
    rows: dict[tuple[str, str], list[str]] = {}
    for one in _of_group(group):
        rows.setdefault((one.action, one.gesture), []).append(_keys_told(one))
    for k, ((action, gesture), keys) in enumerate(rows.items(), 1):
        shown = QtWidgets.QLabel(("  " if gesture == "press" else "\n").join(keys))
        shown.setObjectName("title")
        meaning = QtWidgets.QLabel(say(COMMANDS[action].label).rstrip("…"))
        grid.addWidget(shown, k, 0, top)
        grid.addWidget(meaning, k, 1, top)
    return box

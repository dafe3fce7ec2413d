"""The questions that the window asks."""

from __future__ import annotations

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.commands import COMMANDS, GROUPS, SHORTCUTS, TITLES, Shortcut
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.window.forms import FormDialog
from paint3d.app.window.wording import LANGUAGES, say, say_error, say_units
from paint3d.calligraphy.glyph_sources import open_glyph_folder
from paint3d.errors import Message, Paint3DError

__all__ = ["Answer", "KeysDialog", "PreferencesDialog", "ask"]

_KEY_COLUMNS = 3

Answer = QtWidgets.QMessageBox.ButtonRole
"""The answer of `ask`: AcceptRole, DestructiveRole or RejectRole."""


def ask(
    parent: QtWidgets.QWidget,
    text: str,
    *,
    accept: str = "",
    destroy: str = "",
    leave: str | None = None,
    warns: bool = False,
) -> Answer:
    """Ask before something is lost. Escape and closing the box leave everything as it is.

    Parameters
    ----------
    parent : QWidget
    text : str
        In the chosen language, as the others are.
    accept : str, optional
        Text of the button that loses nothing; Enter presses it.
    destroy : str, optional
        Text of the button that loses something.
    leave : str, optional
        Text of the button that does neither, by default that it cancels; empty for none. Enter
        presses it where there is no `accept`.
    warns : bool
        Whether the box bears the sign of a warning.

    Returns
    -------
    Answer
        The role of the button that was pressed.
    """
    box = QtWidgets.QMessageBox(parent)
    box.setWindowTitle("paint3d")
    box.setTextFormat(QtCore.Qt.TextFormat.PlainText)  # a file's name is no markup
    box.setText(text)
    if warns:
        box.setIcon(QtWidgets.QMessageBox.Icon.Warning)
    leave = say("Cancel") if leave is None else leave
    roles = {Answer.AcceptRole: accept, Answer.DestructiveRole: destroy, Answer.RejectRole: leave}
    buttons = [box.addButton(words, role) for role, words in roles.items() if words]
    box.setDefaultButton(buttons[0 if accept else -1])
    box.setEscapeButton(buttons[-1])
    box.exec()
    pressed = box.clickedButton()
    box.deleteLater()
    return Answer.RejectRole if pressed is None else box.buttonRole(pressed)


class PreferencesDialog(FormDialog):
    """Asks for the program's settings."""

    def __init__(self, parent: QtWidgets.QWidget, settings: Settings) -> None:
        super().__init__(parent, say("Preferences…").rstrip("…"))
        self.boxes: dict[str, QtWidgets.QComboBox] = {}
        self.numbers: dict[str, QtWidgets.QDoubleSpinBox] = {}
        rows = (
            ("language", say("Language"), {"system": say("As the system")} | LANGUAGES),
            (
                "theme",
                say("Theme"),
                {
                    "system": say("As the system"),
                    "light": say("Light theme"),
                    "dark": say("Dark theme"),
                },
            ),
            ("unit", say("Lengths are shown in"), say_units()),
            (
                "pressure_by",
                say("Force without a pen"),
                {"keys": say("Force by keys and wheel"), "speed": say("Force by speed")},
            ),
            (
                "finger",
                say("One finger"),
                {
                    "auto": say("A finger paints until a pen is used"),
                    "paint": say("A finger paints"),
                    "turn": say("A finger turns the view"),
                },
            ),
        )
        for name, label, choices in rows:
            self.boxes[name] = self.add_box(label, choices, getattr(settings, name))
        wet = {None: say("As the material asks for"), True: say("Always"), False: say("Never")}
        self.boxes["wet"] = self.add_box(say("Ink spreads and dries"), wet, settings.wet)
        for name, label, low, high, unit in (
            ("autosave_s", say("Keep a whole copy for recovery every"), 10.0, 3600.0, "s"),
            (
                "undo_megabytes",
                say("Memory for undo, from the next painting on"),
                16.0,
                65536.0,
                "MB",
            ),
        ):
            value = getattr(settings, name)
            self.numbers[name] = self.add_number(label, low, high, value, unit)
        self.glyphs = QtWidgets.QLineEdit(settings.glyphs)
        self.glyphs.setPlaceholderText(say("of hanzi-writer-data; empty: those that come along"))
        self.glyphs.setClearButtonEnabled(True)
        choose = QtWidgets.QPushButton("…")
        choose.clicked.connect(self._choose_folder)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.glyphs, 1)
        row.addWidget(choose)
        self.form.addRow(say("Folder of characters"), row)
        self.finish(say("OK"))

    def _choose_folder(self) -> None:
        folder = QtWidgets.QFileDialog.getExistingDirectory(
            self,
            say("Folder of characters"),
            self.glyphs.text(),
            QtWidgets.QFileDialog.Option.DontUseNativeDialog,
        )
        if folder:
            self.glyphs.setText(folder)

    def accept(self) -> None:
        """Accept, unless the folder has no characters."""
        folder = self.glyphs.text().strip()
        try:
            if folder:
                open_glyph_folder(folder)
        except Paint3DError as error:
            ask(self, say_error(error), accept=say("OK"), leave="")
            return
        super().accept()

    def chosen(self) -> dict[str, object]:
        """Return the settings by name."""
        numbers = {name: box.value() for name, box in self.numbers.items()}
        boxes = {name: box.currentData() for name, box in self.boxes.items()}
        return {**boxes, **numbers, "glyphs": self.glyphs.text().strip()}


class KeysDialog(QtWidgets.QDialog):
    """The whole key map."""

    def __init__(self, parent: QtWidgets.QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Keyboard shortcuts"))
        layout = QtWidgets.QVBoxLayout(self)
        area, inner = QtWidgets.QScrollArea(), QtWidgets.QWidget()
        columns = QtWidgets.QHBoxLayout(inner)
        columns.setSpacing(26)
        for groups in _key_columns(_KEY_COLUMNS):
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


def _shortcuts_of(group: str) -> list[Shortcut]:
    return [one for one in SHORTCUTS if one.group == group and not one.action[-1].isdigit()]


def _key_columns(n: int) -> list[list[str]]:
    """Return the groups in n columns of about the same length, in order."""
    total = sum(len(_shortcuts_of(group)) + 2 for group in GROUPS)
    columns: list[list[str]] = [[]]
    filled = 0
    for group in GROUPS:
        rows = len(_shortcuts_of(group)) + 2
        if filled + rows / 2 > total / n * len(columns) and len(columns) < n:
            columns.append([])
        columns[-1].append(group)
        filled += rows
    return columns


_ARROWS = {"Left": "←", "Right": "→", "Up": "↑", "Down": "↓"}
_BUTTONS = {
    "Left": Message("Left button"),
    "Middle": Message("Middle button"),
    "Right": Message("Right button"),
    "Wheel": Message("Wheel"),
    "Beside": Message("Beside the object"),
    "Space": Message("Space"),
}
_GESTURES = {"hold": Message("hold"), "drag": Message("drag"), "tap": Message("tap")}


def _format_keys(one: Shortcut) -> str:
    """Format keys, buttons or fingers, and their gesture unless they are pressed."""
    *modifiers, last = one.keys.replace("++", "+plus").replace("Num+", "Num ").split("+")
    words = [say("Space") if key == "Space" else key for key in modifiers]
    kind, _, number = last.partition(" ")
    if kind == "Pen":
        words.append(say("Pen button {number}", number=number))
    elif kind == "Fingers":
        words.append(say("Fingers: {number}", number=number))
    elif kind == "Num":
        words.append(say("Keypad {name}", name=number.replace("plus", "+")))
    elif one.gesture == "press":
        words.append(_ARROWS.get(last, last))
    else:
        words.append(say(_BUTTONS.get(last, last)))
    message = "+".join(words)
    return message if one.gesture == "press" else f"{message}  ({say(_GESTURES[one.gesture])})"


def _key_table(group: str) -> QtWidgets.QWidget:
    box = QtWidgets.QWidget()
    grid = QtWidgets.QGridLayout(box)
    grid.setContentsMargins(0, 0, 0, 0)
    grid.setHorizontalSpacing(12)
    grid.setVerticalSpacing(3)
    grid.setColumnStretch(1, 1)
    head = QtWidgets.QLabel(say(TITLES[group]))
    head.setObjectName("heading")
    grid.addWidget(head, 0, 0, 1, 2)
    top = QtCore.Qt.AlignmentFlag.AlignTop
    rows: dict[tuple[str, str], list[str]] = {}
    for one in _shortcuts_of(group):
        rows.setdefault((one.action, one.gesture), []).append(_format_keys(one))
    for k, ((action, gesture), keys) in enumerate(rows.items(), 1):
        shown = QtWidgets.QLabel(("  " if gesture == "press" else "\n").join(keys))
        shown.setObjectName("title")
        meaning = QtWidgets.QLabel(say(COMMANDS[action].text).rstrip("…"))
        grid.addWidget(shown, k, 0, top)
        grid.addWidget(meaning, k, 1, top)
    return box

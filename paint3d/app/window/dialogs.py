"""The questions that the window asks."""

from __future__ import annotations

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.commands import COMMANDS, GESTURES
from paint3d.app.window.wording import say
from paint3d.files.load import BUILT_IN_OBJECTS, UNITS_MM
from paint3d.ink.materials import material_names

__all__ = ["KeysDialog", "NewDialog", "ask_unit", "implausible"]

_SMALL_MM, _LARGE_MM = 5.0, 3000.0  # outside these an object is hardly one to paint by hand
_LIKELY_MM = 150.0


def implausible(size_mm: float) -> bool:
    """Whether an object so long was probably measured in another unit."""
    return not _SMALL_MM <= size_mm <= _LARGE_MM


def _told(size_mm: float) -> str:
    for unit, mm in (("m", 1000.0), ("cm", 10.0)):
        if size_mm >= mm * 1.5:
            return f"{size_mm / mm:.3g} {unit}"
    return f"{size_mm:.3g} mm"


def ask_unit(parent: QtWidgets.QWidget, name: str, size_mm: float) -> str | None:
    """Ask in which unit a file is measured whose object would be `size_mm` long; None: stop."""
    sizes = {unit: size_mm * mm for unit, mm in UNITS_MM.items()}
    likely = min(sizes, key=lambda unit: abs(sizes[unit] - _LIKELY_MM) / sizes[unit])
    texts = [f"{unit}   ({_told(size)})" for unit, size in sizes.items()]
    text, accepted = QtWidgets.QInputDialog.getItem(
        parent, name, say("Which unit is {name} measured in?").format(name=name), texts,
        list(sizes).index(likely), False,
    )  # fmt: skip
    return list(sizes)[texts.index(text)] if accepted else None


class NewDialog(QtWidgets.QDialog):
    """Ask what to paint on."""

    def __init__(self, parent: QtWidgets.QWidget, resolution: float) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("New painting"))
        form = QtWidgets.QFormLayout(self)
        self.object = QtWidgets.QComboBox()
        for name in BUILT_IN_OBJECTS:
            self.object.addItem(say(name), name)
        self.object.addItem(say("A mesh file…"), "")
        self.material = QtWidgets.QComboBox()
        for name in material_names():
            self.material.addItem(say(name), name)
        self.resolution = QtWidgets.QDoubleSpinBox()
        self.resolution.setRange(0.05, 10.0)
        self.resolution.setDecimals(2)
        self.resolution.setSingleStep(0.05)
        self.resolution.setSuffix(" mm")
        self.resolution.setValue(resolution)
        form.addRow(say("Object"), self.object)
        form.addRow(say("Material"), self.material)
        form.addRow(say("Finest detail"), self.resolution)
        standard = QtWidgets.QDialogButtonBox.StandardButton
        buttons = QtWidgets.QDialogButtonBox(standard.Ok | standard.Cancel)
        buttons.button(standard.Ok).setText(say("Begin"))
        buttons.button(standard.Cancel).setText(say("Cancel"))
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form.addRow(buttons)

    def chosen(self) -> tuple[str, str, float]:
        """Object ("" for a file), material and resolution (mm)."""
        return self.object.currentData(), self.material.currentData(), self.resolution.value()


class KeysDialog(QtWidgets.QDialog):
    """All keys and gestures."""

    def __init__(self, parent: QtWidgets.QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Keys and gestures"))
        self.resize(720, 560)
        columns = QtWidgets.QHBoxLayout(self)
        keyed = [(", ".join(c.keys), c.text) for c in COMMANDS if c.keys]
        half = -(-len(keyed) // 2)
        columns.addWidget(_key_table(keyed[:half]), 1)
        right = QtWidgets.QVBoxLayout()
        right.addWidget(_key_table(keyed[half:]))
        right.addSpacing(10)
        right.addWidget(_key_table(GESTURES))
        right.addStretch(1)
        columns.addLayout(right, 1)


def _key_table(rows) -> QtWidgets.QWidget:
    box = QtWidgets.QWidget()
    grid = QtWidgets.QGridLayout(box)
    grid.setHorizontalSpacing(14)
    grid.setColumnStretch(1, 1)
    for k, (keys, text) in enumerate(rows):
        shown = QtWidgets.QLabel(say(keys))
        shown.setObjectName("title")
        meaning = QtWidgets.QLabel(say(text).rstrip("…"))
        meaning.setWordWrap(True)
        top = QtCore.Qt.AlignmentFlag.AlignTop
        grid.addWidget(shown, k, 0, top)
        grid.addWidget(meaning, k, 1, top)
    grid.setRowStretch(len(rows), 1)
    return box

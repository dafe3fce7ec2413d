"""The dialog of a new painting: sheets and objects in pictures, with sizes and materials."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.persistence.saved_settings import chosen_material
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.window.forms import FormDialog, buttons
from paint3d.app.window.object.material_box import MaterialBox
from paint3d.app.window.questions import ask
from paint3d.app.window.wording import say, say_error, say_length, say_object, say_sides
from paint3d.colour.materials import Material, load_material
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import Message, Paint3DError
from paint3d.files.load import BUILT_IN_OBJECTS, read_mesh
from paint3d.mesh.sheet_mesh import drawn, fan_of
from paint3d.mesh.sheets import FORMS, Sheet, is_sheet, parse_sheet
from paint3d.view.preview import Preview

__all__ = ["NewDialog"]

_SMALL, _LARGE = 64, 300  # pixels
_CELL = QtCore.QSize(114, 122)  # or wider, by the longest words
_BESIDE_WORDS = 14
_SUITED = {"bowl": "porcelain", "plate": "porcelain", "vase": "porcelain", "sphere": "plaster",
           "plane": "xuan"}  # fmt: skip
_LABELS = {
    "rectangle": (Message("Width"), Message("Height")),
    "disc": (Message("Diameter"), Message("Height")),
    "sector": (Message("Across"), Message("Breadth")),
}
_FREE = "sheet:340x690"
_NAME = QtCore.Qt.ItemDataRole.UserRole


class NewDialog(FormDialog):
    """Asks for a sheet or an object, its material and its detail.

    Parameters
    ----------
    parent : QWidget
    settings : Settings
    """

    def __init__(self, parent: QtWidgets.QWidget, settings: Settings) -> None:
        super().__init__(parent, say("New painting…").rstrip("…"), beside=True)
        self._settings = settings
        self._last_material = chosen_material(settings)
        self._wanted = settings.resolution_mm
        self._error = ""
        self.sheets, self.objects = _Pictures(), _Pictures()
        for form in FORMS:
            self.sheets.add(form, f"{say_object(form)}\n{_format_size(_usual(form))}")
        for name in BUILT_IN_OBJECTS:
            width, depth, height = np.ptp(read_mesh(name).mesh.vertices, axis=0)
            size = say_sides(width, height or depth)  # a sheet that lies has no height
            self.objects.add(name, f"{say_object(name)}\n{size}")
        self.objects.add("", say("A mesh file…"))
        lists = QtWidgets.QVBoxLayout()
        titles = (say("Sheets"), self.sheets, 3), (say("Objects"), self.objects, 2)
        for title, pictures, stretch in titles:
            head = QtWidgets.QLabel(title)
            head.setObjectName("heading")
            lists.addWidget(head)
            lists.addWidget(pictures, stretch)
            pictures.setAccessibleName(title)
            pictures.currentItemChanged.connect(self._chooser(pictures))
            pictures.itemDoubleClicked.connect(lambda _: self._begin())
        self.picture = QtWidgets.QLabel()
        self.picture.setFixedSize(_LARGE, _LARGE)
        self.form.addRow(self.picture)
        self.width_box = self.add_number(say("Width"), 10.0, 5000.0, 340.0, "mm")
        self.height_box = self.add_number(say("Height"), 10.0, 5000.0, 690.0, "mm")
        self.margin = self.add_number(say("Margin"), 0.0, 500.0, 25.0, "mm")
        self.margin.setToolTip(say("What is kept free by text that is laid out"))
        self.mounted = self.add_check(say("Mounted, with a border of silk"), False)
        self.material = MaterialBox(self._last_material)
        self.material.failed.connect(lambda why: ask(self, why, accept=say("OK"), leave=""))
        self.material.currentIndexChanged.connect(lambda _: self._draw())
        self.form.addRow(say("Material"), self.material)
        self.wetness = QtWidgets.QLabel()
        self.wetness.setObjectName("faint")
        self.wetness.setWordWrap(True)
        self.form.addRow("", self.wetness)
        self.resolution = self.add_number(say("Detail"), 0.05, 10.0, self._wanted, "mm", 2)
        self.resolution.setSingleStep(0.05)
        self.fault = QtWidgets.QLabel()
        self.fault.setWordWrap(True)
        self.form.addRow(self.fault)
        for box in (self.width_box, self.height_box, self.margin):
            box.valueChanged.connect(lambda _: self._draw())
        self.mounted.toggled.connect(lambda _: self._draw())
        self._lay_out(lists)
        last = settings.begun_on
        self.choose(last if last in BUILT_IN_OBJECTS or is_sheet(last) else "scroll")
        self._coming = list(BUILT_IN_OBJECTS)
        QtCore.QTimer.singleShot(0, self, self._draw_next)

    def choose(self, name: str) -> None:
        """Choose an object or a sheet by its name; empty for a file."""
        pictures = self.sheets if is_sheet(name) else self.objects
        form = name.split(":")[0]
        for row in range(pictures.count()):
            if pictures.item(row).data(_NAME) == form:
                pictures.setCurrentRow(row)
        if is_sheet(name) and name != form:
            with suppress(Paint3DError):  # sizes that another version knows
                self._show(parse_sheet(name))

    def chosen(self) -> tuple[str, str, float]:
        """Return object ("" for a file), material and resolution (mm)."""
        sheet = self._sheet()
        name = self._name if sheet is None else sheet.name
        return name, str(self.material.material()), self.resolution.value()

    # -- layout -----------------------------------------------------------------------------

    def _lay_out(self, lists: QtWidgets.QVBoxLayout) -> None:
        """Lay out the pictures to the left, the form to the right, the buttons below."""
        self.form.setContentsMargins(0, 0, 0, 0)
        both = QtWidgets.QHBoxLayout()
        both.setSpacing(18)
        both.addLayout(lists, 1)
        both.addWidget(self.rows)
        whole = QtWidgets.QVBoxLayout(self)
        whole.setContentsMargins(18, 16, 18, 14)
        whole.addLayout(both, 1)
        self.buttons = buttons(self, say("Begin"))
        whole.addWidget(self.buttons)
        room = self.screen().availableGeometry().size()
        self.resize(QtCore.QSize(1190, 690).boundedTo(room))

    def _chooser(
        self, pictures: _Pictures
    ) -> Callable[[QtWidgets.QListWidgetItem | None, QtWidgets.QListWidgetItem | None], None]:
        def chosen(
            item: QtWidgets.QListWidgetItem | None, _: QtWidgets.QListWidgetItem | None
        ) -> None:
            if item is None:
                return
            other = self.objects if pictures is self.sheets else self.sheets
            with QtCore.QSignalBlocker(other):
                other.setCurrentRow(-1)
            self._name = str(item.data(_NAME))
            self._show(_usual(self._name) if is_sheet(self._name) else None)

        return chosen

    def _show(self, sheet: Sheet | None) -> None:
        """Show a sheet's numbers, or none for an object, and the material that suits it."""
        rows = (self.width_box, self.height_box, self.margin, self.mounted)
        blocked = [QtCore.QSignalBlocker(row) for row in (*rows, self.material)]
        for row in rows:
            self.form.setRowVisible(row, sheet is not None)
        material = _SUITED.get(self._name, self._last_material)
        if sheet is not None:
            shape, material = sheet.usual.shape, sheet.usual.material
            self.form.setRowVisible(self.height_box, shape != "disc")
            for box, word in zip(rows, _LABELS[shape], strict=False):
                label = self.form.labelForField(box)
                assert isinstance(label, QtWidgets.QLabel), "each number has its label"
                label.setText(say(word))
            self.width_box.setValue(sheet.width_mm)
            self.height_box.setValue(sheet.height_mm)
            self.margin.setValue(sheet.margin_mm)
            self.mounted.setChecked(sheet.mounted)
        self.material.show_material(material)
        self.resolution.setValue(max(self._wanted, 0.0 if sheet is None else sheet.detail_mm))
        del blocked
        self._draw()

    def _sheet(self) -> Sheet | None:
        """Return the chosen sheet; None without one, or if its numbers are invalid."""
        self._error = ""
        if not is_sheet(self._name):
            return None
        width, height = self.width_box.value(), self.height_box.value()
        if FORMS[self._name].shape == "disc":
            height = width
        try:
            return Sheet(self._name, width, height, self.margin.value(), self.mounted.isChecked())
        except Paint3DError as error:
            self._error = say_error(error)
            return None

    def _begin(self) -> None:
        if not self._error:
            self.accept()

    # -- pictures ---------------------------------------------------------------------------

    def _draw(self) -> None:
        sheet = self._sheet()
        made_of = self.material.material()
        known = made_of if isinstance(made_of, Material) else load_material(made_of)
        says = say("Ink stays where it is laid")
        if self._settings.wants_wet(known):
            says = say("Ink spreads on it")
        elif sheet is not None and self._settings.wants_wet(load_material("xuan")):
            says = say("Ink stays where it is laid; it spreads on xuan paper")
        self.wetness.setText(says)
        self.fault.setText(self._error)
        self.form.setRowVisible(self.fault, bool(self._error))
        ok = self.buttons.button(QtWidgets.QDialogButtonBox.StandardButton.Ok)
        ok.setEnabled(not self._error)
        if sheet is not None:
            self.picture.setPixmap(_sheet_picture(sheet, _LARGE, str(self.material.material())))
        elif self._name in BUILT_IN_OBJECTS:
            self.picture.setPixmap(_object_picture(self._name, _LARGE))
        else:
            self.picture.setPixmap(QtGui.QPixmap())

    def _draw_next(self) -> None:
        """Draw the small pictures of objects one by one: each takes some hundredths of a second."""
        if not self._coming:
            return
        name = self._coming.pop(0)
        for row in range(self.objects.count()):
            item = self.objects.item(row)
            if item.data(_NAME) == name:
                item.setIcon(QtGui.QIcon(_object_picture(name, _SMALL)))
        QtCore.QTimer.singleShot(0, self, self._draw_next)


class _Pictures(QtWidgets.QListWidget):
    """A list to choose from, each item a picture with its name below."""

    def __init__(self) -> None:
        super().__init__()
        self.setViewMode(QtWidgets.QListView.ViewMode.IconMode)
        self.setResizeMode(QtWidgets.QListView.ResizeMode.Adjust)
        self.setMovement(QtWidgets.QListView.Movement.Static)
        self.setIconSize(QtCore.QSize(_SMALL, _SMALL))
        self.setGridSize(_CELL)
        self.setTextElideMode(QtCore.Qt.TextElideMode.ElideNone)

    def focusInEvent(self, event: QtGui.QFocusEvent) -> None:
        """Choose nothing by the focus alone, as Qt would the first."""
        chosen = self.currentRow()
        with QtCore.QSignalBlocker(self):
            super().focusInEvent(event)
            if chosen < 0:
                self.setCurrentRow(-1)

    def add(self, name: str, words: str) -> None:
        """Add an item, wide enough for its words; a sheet's picture is drawn at once."""
        item = QtWidgets.QListWidgetItem(words)
        item.setData(_NAME, name)
        widest = max(map(self.fontMetrics().horizontalAdvance, words.split("\n")))
        cell = self.gridSize().expandedTo(QtCore.QSize(widest + _BESIDE_WORDS, 0))
        self.setGridSize(cell)
        item.setSizeHint(cell - QtCore.QSize(4, 4))
        item.setTextAlignment(QtCore.Qt.AlignmentFlag.AlignHCenter)
        if is_sheet(name):
            usual = _usual(name)
            item.setIcon(QtGui.QIcon(_sheet_picture(usual, _SMALL, usual.usual.material)))
        else:
            blank = QtGui.QPixmap(_SMALL, _SMALL)
            blank.fill(QtCore.Qt.GlobalColor.transparent)
            item.setIcon(QtGui.QIcon(blank))
        self.addItem(item)


def _usual(form: str) -> Sheet:
    return parse_sheet(_FREE if form == "sheet" else form)


def _format_size(sheet: Sheet) -> str:
    """Format a sheet's size; of a folding fan, the size of its paper."""
    width, height = sheet.size
    if sheet.usual.shape == "disc":
        return f"ø {say_length(width)}"
    if sheet.usual.shape == "sector":
        fan = fan_of(sheet)
        height = 2.0 * (fan.outer + fan.apex)
    pair = "2 × " if sheet.usual.panels == 2 else ""
    return f"{pair}{say_sides(width, height)}"


def _sheet_picture(sheet: Sheet, size: int, material: str) -> QtGui.QPixmap:
    """Draw a sheet from above, in the middle of a square of pixels."""
    pixels = QtGui.QPixmap(size, size)
    pixels.fill(QtCore.Qt.GlobalColor.transparent)
    parts = drawn(sheet)
    every = np.concatenate([polygon for polygon, _ in parts])
    low, high = every.min(axis=0), every.max(axis=0)
    scale = 0.92 * size / float((high - low).max())
    paper = srgb_from_reflectance(load_material(material).reflectance).tolist()
    painter = QtGui.QPainter(pixels)
    painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
    for polygon, colour in parts:
        placed = (polygon - 0.5 * (low + high)) * [scale, -scale] + 0.5 * size
        points = [QtCore.QPointF(x, y) for x, y in placed.tolist()]
        painter.setBrush(QtGui.QColor(*(paper if colour is None else colour)))
        edge = QtGui.QPen(QtGui.QColor(150, 144, 132), 1.0)
        painter.setPen(edge if colour is None else QtCore.Qt.PenStyle.NoPen)
        painter.drawPolygon(QtGui.QPolygonF(points))
    painter.end()
    return pixels


@cache
def _preview(name: str) -> Preview:
    return Preview(read_mesh(name).mesh, _LARGE)


def _object_picture(name: str, size: int) -> QtGui.QPixmap:
    """Draw a built-in object, seen from the side."""
    preview = _preview(name) if size == _LARGE else _preview(name).smaller(size)
    pixels = preview.draw(np.eye(3))
    height, width = pixels.shape[:2]
    image = QtGui.QImage(pixels.data, width, height, 3 * width, QtGui.QImage.Format.Format_RGB888)
    return QtGui.QPixmap.fromImage(image.copy())

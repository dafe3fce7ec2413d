"""The brush editor: every parameter with its unit and range, its footprints and its stroke."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.brush_commands import Ink
from paint3d.app.window.dialogs.brush_draft import (
    INPUT_RANGES,
    changed,
    points_of,
    range_of,
    value_of,
    with_curve,
    with_hairs,
)
from paint3d.app.window.dialogs.factor_curve import FactorCurve
from paint3d.app.window.dialogs.number_row import NumberRow
from paint3d.app.window.jobs.brush_drawing import PRESSES, BrushDrawing, Drawn
from paint3d.app.window.panels.brush_panel import pixmap_of, plain_name
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_error
from paint3d.brush.presets import (
    brush_names,
    check_brush_name,
    check_unlike_presets,
    load_presets,
    meaning_of,
)
from paint3d.brush.spec import HAIRS, TABLES, BristleSpec, BrushSpec
from paint3d.errors import BrushError, Paint3DError

__all__ = ["FORCE", "OF_HAIRS", "TUFT", "BrushEditor"]

_SIDE, _COLUMNS = 208, 440  # pixels of the pictures
_SHARPER = 2  # times as many are drawn
_EVEN, _RATIO, _WHOLE, _COUNT = range(4)  # how a slider goes

TUFT = (
    ("length_mm", "Length L", "mm", _RATIO), ("root_diameter_mm", "Root", "mm", _EVEN),
    ("taper", "Taper", "", _EVEN), ("point_mm", "Point", "mm", _EVEN),
    ("n_segments", "Segments n", "", _WHOLE), ("tip_segment_mm", "Tip segment l1", "mm", _EVEN),
    ("stiffness_exponent", "Stiffness exponent q", "", _EVEN),
)  # fmt: skip
FORCE = (
    ("hardness", "Hardness H", "", _EVEN), ("full_press_mm", "Full press", "mm", _EVEN),
    ("max_force", "Greatest force", "N", _RATIO), ("friction", "Friction μ", "", _EVEN),
    ("spread_by_pressure", "Spread by pressure b", "", _EVEN),
    ("spread_by_friction", "Spread by friction c", "", _EVEN),
    ("drag_fraction", "Drag", "", _EVEN), ("plasticity", "Bend that stays", "", _EVEN),
    ("load", "Ink in a full tuft", "mm²", _RATIO),
    ("transfer_per_mm", "Ink given per mm", "", _RATIO),
)  # fmt: skip
OF_HAIRS = (
    ("n_hairs", "Number of hairs", "", _COUNT), ("hair_mm", "Thickness of a hair", "mm", _RATIO),
    ("threshold_mm", "Leaves ink within", "mm", _EVEN), ("film", "Film of ink", "", _EVEN),
    ("unevenness", "Uneven lengths", "", _EVEN), ("parting", "Parting", "", _EVEN),
    ("splay", "Splay", "", _EVEN), ("appetite", "Uneven giving", "", _EVEN),
    ("levelling_mm", "Levelling", "mm", _RATIO), ("set_share", "Pressed out over", "", _EVEN),
)  # fmt: skip
_SETTINGS = {
    "stiffness": "Stiffness", "spread": "Spread", "load": "Ink given", "wetness": "Wetness"
}  # fmt: skip
_INPUTS = {
    "pressure": "pressure", "tilt": "tilt", "speed": "speed", "ink_left": "ink left",
    "curvature": "curvature",
}  # fmt: skip
_TABLES = {"energy": "Bent by least energy", "measured": "Bent as FastBrush measured"}
_UNITS = {"tilt": "°", "speed": "mm/s", "curvature": "1/mm"}

Rows = tuple[tuple[str, str, str, int], ...]


class BrushEditor(QtWidgets.QDialog):
    """Change a brush and see what it does; painting goes on beside it.

    Parameters
    ----------
    parent : QWidget
    theme : Theme
    brush : BrushSpec
        What it begins with.
    ink : Ink
        Of the stroke that is shown.

    Signals
    -------
    taken : BrushSpec
        To be painted with.
    kept : BrushSpec
        To be kept as one's own.
    """

    taken = QtCore.Signal(object)
    kept = QtCore.Signal(object)

    def __init__(self, parent: QtWidgets.QWidget, theme: Theme, brush: BrushSpec, ink: Ink) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Brush editor"))
        self.setObjectName("brush_editor")
        self._theme, self._ink = theme, ink
        self.begun = self.brush = dataclasses.replace(brush, name=plain_name(brush))
        self._hairs = brush.bristles or BristleSpec()
        self.rows: dict[str, NumberRow] = {}
        self.drawing = BrushDrawing(self, _SHARPER * _SIDE, _SHARPER * _COLUMNS)
        self.drawing.drawn.connect(self._show_drawn)
        self.tabs = QtWidgets.QTabWidget()
        self.tabs.addTab(self._tuft_page(), say("Tuft"))
        self.tabs.addTab(self._page(FORCE), say("Force, spread, ink"))
        self.tabs.addTab(self._hair_page(), say("Hairs"))
        self.tabs.addTab(self._dynamics_page(), say("Dynamics"))
        across = QtWidgets.QHBoxLayout()
        across.addWidget(self.tabs, 1)
        across.addLayout(self._make_pictures())
        whole = QtWidgets.QVBoxLayout(self)
        whole.addLayout(across, 1)
        whole.addLayout(self._make_foot())
        self._show()

    # -- making it --------------------------------------------------------------------------

    def _page(self, rows: Rows, *above: QtWidgets.QWidget) -> QtWidgets.QWidget:
        page = QtWidgets.QWidget()
        column = QtWidgets.QVBoxLayout(page)
        for widget in above:
            column.addWidget(widget)
        grid = QtWidgets.QGridLayout()
        grid.setColumnStretch(1, 1)
        column.addLayout(grid)
        column.addStretch(1)
        for name, label, unit, way in rows:
            whole, even = way in (_WHOLE, _COUNT), way in (_EVEN, _WHOLE)
            row = NumberRow(grid, name, (label, meaning_of(name)), unit, whole=whole, even=even)
            row.changed.connect(self._change)
            self.rows[name] = row
        return page

    def _tuft_page(self) -> QtWidgets.QWidget:
        self.hair = QtWidgets.QComboBox()
        for name in HAIRS:
            self.hair.addItem(say(f"brush.hair_{name}"), name)
        self.hair.activated.connect(lambda _: self._change("hair", self.hair.currentData()))
        return self._page(TUFT, self.hair)

    def _hair_page(self) -> QtWidgets.QWidget:
        self.single = QtWidgets.QCheckBox(say("Paint with single hairs"))
        self.single.toggled.connect(self._choose_single)
        self.table = QtWidgets.QComboBox()
        self.table.setToolTip(meaning_of("table"))
        self.table.activated.connect(lambda _: self._change("table", self.table.currentData()))
        return self._page(OF_HAIRS, self.single, self.table)

    def _dynamics_page(self) -> QtWidgets.QWidget:
        page = QtWidgets.QWidget()
        column = QtWidgets.QVBoxLayout(page)
        row = QtWidgets.QHBoxLayout()
        self.setting, self.input = QtWidgets.QComboBox(), QtWidgets.QComboBox()
        for box, names in ((self.setting, _SETTINGS), (self.input, _INPUTS)):
            for name, text in names.items():
                box.addItem(say(text), name)
            box.activated.connect(lambda _: self._show())
        row.addWidget(self.setting, 1)
        row.addWidget(QtWidgets.QLabel(say("by")))
        row.addWidget(self.input, 1)
        column.addLayout(row)
        self.curve = FactorCurve(self._theme)
        self.curve.changed.connect(self._change_curve)
        column.addWidget(self.curve, 1)
        self.curves = QtWidgets.QLabel()
        self.curves.setObjectName("faint")
        self.curves.setWordWrap(True)
        column.addWidget(self.curves)
        return page

    def _make_pictures(self) -> QtWidgets.QVBoxLayout:
        column = QtWidgets.QVBoxLayout()
        self.footprints, self.stroke = QtWidgets.QLabel(), QtWidgets.QLabel()
        self.footprints.setFixedSize(_SIDE, _SIDE)
        self.stroke.setFixedSize(_COLUMNS, round(_COLUMNS * 84 / 264))
        presses = ", ".join(f"{100 * press:.0f} %" for press in PRESSES)
        for text, picture in (
            (say("Footprints at {presses} of the force", presses=presses), self.footprints),
            (say("A stroke on xuan"), self.stroke),
        ):
            label = QtWidgets.QLabel(text)
            label.setObjectName("faint")
            column.addWidget(label)
            column.addWidget(picture)
        column.addStretch(1)
        return column

    def _make_foot(self) -> QtWidgets.QVBoxLayout:
        self.told = QtWidgets.QLabel()
        self.told.setObjectName("heading")
        self.told.setWordWrap(True)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(QtWidgets.QLabel(say("Name")))
        self.name_box = QtWidgets.QLineEdit(self._first_name())
        self.name_box.setMaxLength(60)
        self.name_box.textChanged.connect(lambda _: self.told.clear())
        row.addWidget(self.name_box, 1)
        self.take, self.keep = self._button("Paint with it"), self._button("Save as mine")
        self.again, self.leave = self._button("Begin anew"), self._button("Close")
        for button in (self.again, self.keep, self.take, self.leave):
            row.addWidget(button)
        self.take.clicked.connect(lambda: self._give(self.taken))
        self.keep.clicked.connect(lambda: self._give(self.kept))
        self.again.clicked.connect(self._begin_anew)
        self.leave.clicked.connect(self.close)
        column = QtWidgets.QVBoxLayout()
        column.addWidget(self.told)
        column.addLayout(row)
        return column

    def _button(self, text: str) -> QtWidgets.QPushButton:
        button = QtWidgets.QPushButton(say(text))
        button.setAutoDefault(False)
        return button

    def _first_name(self) -> str:
        name = plain_name(self.brush)
        return f"my {name}" if name in brush_names() else name

    # -- changing ---------------------------------------------------------------------------

    def _change(self, parameter: str, value: object) -> None:
        self._try(lambda brush: changed(brush, parameter, value))

    def _change_curve(self, points: tuple[tuple[float, float], ...]) -> None:
        setting, name = self.setting.currentData(), self.input.currentData()
        self._try(lambda brush: with_curve(brush, setting, name, points))

    def _choose_single(self, on: bool) -> None:
        if not on and self.brush.bristles is not None:
            self._hairs = self.brush.bristles
        self._try(lambda brush: with_hairs(brush, self._hairs if on else None))

    def _try(self, change: Callable[[BrushSpec], BrushSpec]) -> None:
        """Change the brush, or tell why not."""
        try:
            self.brush = change(self.brush)
            self.told.clear()
        except BrushError as error:
            self.told.setText(say_error(error))
        self._show()

    def _begin_anew(self) -> None:
        self._try(lambda _: self.begun)

    def _give(self, signal: QtCore.SignalInstance) -> None:
        """Hand the brush on under its name, or tell why it cannot be called so."""
        name = self.name_box.text().strip()
        try:
            check_brush_name(name)
            if dataclasses.replace(self.brush, name=name) != load_presets().get(name):
                check_unlike_presets(name, load_presets())
        except BrushError as error:
            self.tell(error)
            return
        self.told.clear()
        signal.emit(dataclasses.replace(self.brush, name=name))

    def tell(self, what: str | Paint3DError) -> None:
        """Say how it went."""
        self.told.setText(what if isinstance(what, str) else say_error(what))

    # -- showing ----------------------------------------------------------------------------

    def set_ink(self, ink: Ink) -> None:
        """Draw the stroke in another ink."""
        self._ink = ink
        self.drawing.ask(self.brush, ink)

    def _show(self) -> None:
        brush = self.brush
        for name, row in self.rows.items():
            row.show_value(value_of(brush, name), *range_of(brush, name))
        single = brush.bristles is not None
        for name, *_ in OF_HAIRS:
            self.rows[name].enable(single)
        with QtCore.QSignalBlocker(self.single):
            self.single.setChecked(single)
        self.hair.setCurrentIndex(HAIRS.index(brush.hair))
        self._show_table(single)
        self._show_curve()
        self.again.setEnabled(brush != self.begun)
        self.drawing.ask(brush, self._ink)

    def _show_table(self, single: bool) -> None:
        own = [h.table for h in (self._hairs, self.begun.bristles, self.brush.bristles) if h]
        tables = [*TABLES, *(t for t in dict.fromkeys(own) if not isinstance(t, str))]
        self.table.clear()
        for table in tables:
            text = _TABLES[table] if isinstance(table, str) else "Bent as measured, own table"
            self.table.addItem(say(text), table)
        hairs = self.brush.bristles or self._hairs
        self.table.setCurrentIndex(tables.index(hairs.table))
        self.table.setEnabled(single)

    def _show_curve(self) -> None:
        setting, name = self.setting.currentData(), self.input.currentData()
        points = points_of(self.brush, setting, name)
        low, high = INPUT_RANGES[name]
        low, high = min([low, *(x for x, _ in points)]), max([high, *(x for x, _ in points)])
        self.curve.show_points(points, low, high, _UNITS.get(name, ""))
        told = [
            f"{say(_SETTINGS[s])} {say('by')} {say(_INPUTS[i])}: "
            + ", ".join(f"{x:g} → ×{y:g}" for x, y in line)
            for s, by_input in self.brush.inputs
            for i, line in by_input
        ]
        self.curves.setText("\n".join(told) or say("Nothing drives this brush"))

    def _show_drawn(self, drawn: Drawn) -> None:
        if drawn.error is not None or drawn.footprints is None or drawn.stroke is None:
            self.tell(say_error(drawn.error or ""))
            return
        for label, pixels in ((self.footprints, drawn.footprints), (self.stroke, drawn.stroke)):
            pixmap = pixmap_of(pixels, label.size() * _SHARPER)
            pixmap.setDevicePixelRatio(float(_SHARPER))
            label.setPixmap(pixmap)

    def done(self, result: int) -> None:
        """Draw nothing more once it is closed."""
        self.drawing.close_down()
        super().done(result)

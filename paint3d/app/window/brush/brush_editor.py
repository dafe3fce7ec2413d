"""The brush editor: every parameter with its unit and range, its footprints and its stroke."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.brush_in_hand import resized, size_limits
from paint3d.app.window.brush.brush_panel import pixmap_of, plain_name
from paint3d.app.window.previews import sorted_parts
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_error, say_hair
from paint3d.brush.presets import (
    brush_names,
    check_brush_name,
    check_not_preset,
    load_presets,
    meaning_of,
)
from paint3d.brush.spec import (
    HAIRS,
    INPUTS,
    SETTINGS,
    TABLES,
    BristleSpec,
    BrushSpec,
    hair_ranges,
    parameter_ranges,
)
from paint3d.brush_engine.tuft import MOST_POINTS
from paint3d.core.arrays import AnyArray
from paint3d.errors import BrushError, Message, Paint3DError
from paint3d.painter.painter import Ink
from paint3d.view.brush_shape import draw_footprints, draw_stroke

__all__ = [
    "FORCE",
    "INPUT_RANGES",
    "OF_HAIRS",
    "PRESSES",
    "TUFT",
    "BrushDrawing",
    "BrushEditor",
    "Drawn",
    "FactorCurve",
    "NumberRow",
    "Points",
    "changed",
    "points_of",
    "range_of",
    "value_of",
    "with_curve",
    "with_hairs",
]

# ---- Pictures of the brush -----------------------------------------------------------------------
# Pictures of a brush that is being changed, drawn beside the window: always of the newest.


_LOOK_MS = 30
PRESSES = (0.25, 0.6, 1.0)
"""Pressures whose footprints are shown."""


class Drawn(NamedTuple):
    """Pictures (H, W, 3) uint8 of a brush, or what is wrong with it."""

    brush: BrushSpec
    footprints: AnyArray | None
    stroke: AnyArray | None
    error: BaseException | None


class BrushDrawing(QtCore.QObject):
    """A thread that draws; of requests made while it is busy, only the newest is drawn.

    Parameters
    ----------
    side, columns : int
        Pixels: of the footprints' picture along a side, of the stroke's from left to right.

    Signals
    -------
    drawn : Drawn
    """

    drawn = QtCore.Signal(object)

    def __init__(self, parent: QtCore.QObject, side: int, columns: int) -> None:
        super().__init__(parent)
        self._size = side, columns
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="paint3d-brush")
        self._next: tuple[BrushSpec, Ink] | None = None
        self._coming: Future[Drawn] | None = None
        self._timer = QtCore.QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)

    @property
    def is_busy(self) -> bool:
        """True if something is still to be drawn."""
        return self._next is not None or self._coming is not None

    def ask(self, brush: BrushSpec, ink: Ink) -> None:
        """Draw this brush, instead of any that waits."""
        self._next = brush, ink
        self._look()
        self._timer.start()

    def close_down(self) -> None:
        """Draw nothing more."""
        self._timer.stop()
        self._next = None
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _look(self) -> None:
        if self._coming is not None:
            if not self._coming.done():
                return
            drawn, self._coming = self._coming.result(), None
            self.drawn.emit(drawn)
        if self._next is not None:
            (brush, ink), self._next = self._next, None
            self._coming = self._worker.submit(_draw, brush, ink, *self._size)
        else:
            self._timer.stop()


def _draw(brush: BrushSpec, ink: Ink, side: int, columns: int) -> Drawn:
    try:
        parts: Any = dict(sorted_parts(ink))
        footprints = draw_footprints(brush, side, PRESSES)
        return Drawn(brush, footprints, draw_stroke(brush, parts, columns=columns), None)
    except Exception as error:  # shown in the window: nobody sees a thread's fault
        return Drawn(brush, None, None, error)


# ---- Curves --------------------------------------------------------------------------------------
# A curve to drag, by which an input of the hand drives a setting of the brush.


_GRIP, _NEAR = 5.5, 12.0
_LEAST, _MOST = 0.05, 20.0
_MARGIN = QtCore.QMarginsF(34, 12, 14, 22)
_APART = 0.01  # of the width: points lie at least so far from each other


class FactorCurve(QtWidgets.QWidget):
    """Points (input, factor) joined by straight lines; outside the first and last these hold.

    Signals
    -------
    changed : tuple of (float, float)
        All points, when one was added, moved or taken away.
    """

    changed = QtCore.Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self.points: Points = ()
        self._low, self._high, self._unit = 0.0, 1.0, ""
        self._dragged = -1
        self.setMinimumSize(250, 150)
        self.setToolTip(say("Drag points; click to add one, right-click to remove one"))

    def show_points(self, points: Points, low: float, high: float, unit: str) -> None:
        """Show other points, over inputs from low to high, without emitting a signal."""
        self.points, self._low, self._high, self._unit = points, low, high, unit
        self._dragged = self._dragged if self._dragged < len(points) else -1
        self.update()

    def place(self, x: float, y: float) -> QtCore.QPointF:
        """Return the position of an input and a factor in the widget."""
        area = QtCore.QRectF(self.rect()).marginsRemoved(_MARGIN)
        along = (x - self._low) / (self._high - self._low)
        up = math.log(y / _LEAST) / math.log(_MOST / _LEAST)
        return QtCore.QPointF(
            area.left() + min(max(along, 0.0), 1.0) * area.width(),
            area.bottom() - min(max(up, 0.0), 1.0) * area.height(),
        )

    def _value(self, position: QtCore.QPointF) -> tuple[float, float]:
        area = QtCore.QRectF(self.rect()).marginsRemoved(_MARGIN)
        along = min(max((position.x() - area.left()) / area.width(), 0.0), 1.0)
        up = min(max((area.bottom() - position.y()) / area.height(), 0.0), 1.0)
        x = self._low + along * (self._high - self._low)
        return float(f"{x:.3g}"), float(f"{_LEAST * (_MOST / _LEAST) ** up:.3g}")

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw axes, curve and points."""
        painter, theme = QtGui.QPainter(self), self.theme
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        area = QtCore.QRectF(self.rect()).marginsRemoved(_MARGIN)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1))
        painter.setBrush(QtGui.QColor(theme.field))
        painter.drawRoundedRect(area.adjusted(-5, -5, 5, 5), 6, 6)
        small = painter.font()
        small.setPointSizeF(small.pointSizeF() - 1.5)
        painter.setFont(small)
        for factor in (0.1, 0.3, 1.0, 3.0, 10.0):
            y = self.place(self._low, factor).y()
            painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 2.0 if factor == 1.0 else 1.0))
            painter.drawLine(QtCore.QPointF(area.left(), y), QtCore.QPointF(area.right(), y))
            painter.setPen(QtGui.QColor(theme.faint))
            box = QtCore.QRectF(0, y - 8, area.left() - 8, 16)
            painter.drawText(box, QtCore.Qt.AlignmentFlag.AlignRight, f"×{factor:g}")
        below = QtCore.QRectF(area.left(), area.bottom() + 5, area.width(), 16)
        painter.drawText(below, QtCore.Qt.AlignmentFlag.AlignLeft, f"{self._low:g}")
        most = f"{self._high:g} {self._unit}".rstrip()
        painter.drawText(below, QtCore.Qt.AlignmentFlag.AlignRight, most)
        if self.points:
            self._draw_curve(painter, area)
        painter.end()

    def _draw_curve(self, painter: QtGui.QPainter, area: QtCore.QRectF) -> None:
        points = [self.place(x, y) for x, y in self.points]
        ends = (
            QtCore.QPointF(area.left(), points[0].y()), QtCore.QPointF(area.right(), points[-1].y())
        )  # fmt: skip
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 2.2))
        painter.drawPolyline([ends[0], *points, ends[1]])
        painter.setBrush(QtGui.QColor(self.theme.raised))
        for point in points:
            painter.drawEllipse(point, _GRIP, _GRIP)

    def _point_at(self, position: QtCore.QPointF) -> int:
        near = [
            ((self.place(*point) - position).manhattanLength(), k)
            for k, point in enumerate(self.points)
        ]
        distance, k = min(near, default=(math.inf, -1))
        return k if distance < _NEAR else -1

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin to drag a point, add one, or remove one."""
        left = QtCore.Qt.MouseButton.LeftButton
        if event.button() != left and event.buttons() & left:
            return  # beside the button that drags one
        position = event.position()
        at = self._point_at(position)
        if event.button() == QtCore.Qt.MouseButton.RightButton:
            if at >= 0:
                self._change_points(self.points[:at] + self.points[at + 1 :])
            return
        if at < 0 and len(self.points) < MOST_POINTS:
            x, y = self._value(position)
            at = sum(point[0] < x for point in self.points)
            if self._fits(x, at, at):
                self._change_points((*self.points[:at], (x, y), *self.points[at:]))
            else:
                at = -1
        self._dragged = at

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Drag the point that was pressed, between its neighbours."""
        at = self._dragged
        if at < 0:
            return
        x, y = self._value(event.position())
        x = x if self._fits(x, at, at + 1) else self.points[at][0]
        self._change_points((*self.points[:at], (x, y), *self.points[at + 1 :]))

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """End the drag with the button that began it."""
        if not event.buttons() & QtCore.Qt.MouseButton.LeftButton:
            self._dragged = -1

    def _fits(self, x: float, at: int, after: int) -> bool:
        """Return whether an input lies between point `at` - 1 and point `after`, with a gap."""
        apart = _APART * (self._high - self._low)
        before = self.points[at - 1][0] if at > 0 else -math.inf
        behind = self.points[after][0] if after < len(self.points) else math.inf
        return before + apart <= x <= behind - apart

    def _change_points(self, points: Points) -> None:
        self.points = points
        self.update()
        self.changed.emit(points)


# ---- Numbers -------------------------------------------------------------------------------------
# A number to be chosen: its name, a slider, a box with its unit, and its range.


_STEPS = 1000
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_DIGITS = 3  # significant, of the narrower end of a range


class NumberRow(QtCore.QObject):
    """A row of a grid to choose a number: label, slider, box and range.

    Parameters
    ----------
    grid : QGridLayout
        The row is added below those that are there.
    name : str
        Name of the number, emitted with a change.
    label : (str, str)
        The label, and the tool tip.
    unit : str
    whole : bool
        Whether only whole numbers can be chosen.
    even : bool
        Whether the slider goes in even steps; if not, in even ratios.

    Signals
    -------
    changed : (str, float)
        Chosen by hand.
    """

    changed = QtCore.Signal(str, float)

    def __init__(
        self,
        grid: QtWidgets.QGridLayout,
        name: str,
        label: tuple[str, str],
        unit: str = "",
        *,
        whole: bool = False,
        even: bool = True,
    ) -> None:
        super().__init__(grid)
        self.name, self._whole, self._even = name, whole, even
        self._low, self._high, self._shown = 0.0, 1.0, 0.0
        self.label = QtWidgets.QLabel(say(label[0]))
        self.slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.slider.setRange(0, _STEPS)
        self.slider.setMinimumWidth(90)
        self.box = _PlainBox()
        self.box.setObjectName(name)
        self.box.setKeyboardTracking(False)
        self.box.setSuffix(f" {unit}" if unit else "")
        self.box.setMinimumWidth(96)
        self.range = QtWidgets.QLabel()
        self.range.setObjectName("faint")
        for widget in (self.label, self.slider, self.box):
            widget.setToolTip(label[1])
        self.slider.setAccessibleName(say(label[0]))
        self.box.setAccessibleName(say(label[0]))
        row = grid.rowCount()
        for column, one in enumerate((self.label, self.slider, self.box, self.range)):
            grid.addWidget(one, row, column)
        self.slider.valueChanged.connect(self._slid)
        self.box.valueChanged.connect(self._typed)

    def show_value(self, value: float, low: float, high: float) -> None:
        """Show a value and its range, without emitting a signal."""
        self._low, self._high, self._shown = low, high, value
        digits = 0 if self._whole else _digits_for(low, high, self._even)
        with QtCore.QSignalBlocker(self.slider), QtCore.QSignalBlocker(self.box):
            self.box.setDecimals(digits)
            self.box.setRange(low, high)
            self.box.setSingleStep(1.0 if self._whole else 10.0 ** (1 - digits))
            self.box.setValue(value)
            if self._even:
                fraction = (value - low) / (high - low)
            else:
                fraction = math.log(value / low) / math.log(high / low)
            self.slider.setValue(round(_STEPS * fraction))
        self.range.setText(f"{_format_limit(low)} – {_format_limit(high)}")

    def enable(self, on: bool) -> None:
        """Enable or disable the row."""
        for widget in (self.label, self.slider, self.box, self.range):
            widget.setEnabled(on)

    def _slid(self, step: int) -> None:
        fraction = step / _STEPS
        low, high = self._low, self._high
        value = low + fraction * (high - low) if self._even else low * (high / low) ** fraction
        self._choose(min(max(float(f"{value:.4g}"), low), high))

    def _typed(self, value: float) -> None:
        self._choose(min(max(value, self._low), self._high))

    def _choose(self, value: float) -> None:
        value = float(round(value)) if self._whole else value
        if value != self._shown:
            self.changed.emit(self.name, value)


class _PlainBox(QtWidgets.QDoubleSpinBox):
    """A box that shows no trailing zeros."""

    def textFromValue(self, value: float) -> str:
        """Format the number."""
        text = super().textFromValue(value)
        point = self.locale().decimalPoint()
        return text.rstrip("0").removesuffix(point) if point in text else text


def _format_limit(number: float) -> str:
    """Format an end of a range: three digits; powers of ten below 0.001 and from a million on."""
    if number != 0.0 and not 1e-3 <= abs(number) < 1e6:
        digits, power = f"{number:.2e}".split("e")
        digits = digits.rstrip("0").rstrip(".")
        return f"{'' if digits == '1' else digits + '·'}10{str(int(power)).translate(_RAISED)}"
    return f"{number:.3g}" if abs(number) < 1e3 else f"{number:.0f}"


def _digits_for(low: float, high: float, even: bool) -> int:
    """Return the number of decimals that tell values of a range apart."""
    span = high - low if even else low
    return min(max(_DIGITS - 1 - math.floor(math.log10(max(span, 1e-9))), 0), 7)


# ---- Drafts --------------------------------------------------------------------------------------
# A brush while its parameters are changed, one at a time, each within its range.


INPUT_RANGES = {
    "pressure": (0.0, 1.0),
    "tilt": (30.0, 90.0),
    "speed": (0.0, 600.0),
    "ink_left": (0.0, 1.0),
    "curvature": (0.0, 0.5),
}
"""Usual ranges of a hand's inputs: fractions, degrees, mm/s, 1/mm (`brush.spec`)."""

Points = tuple[tuple[float, float], ...]


def _of_hairs(parameter: str) -> bool:
    return parameter in hair_ranges()


def value_of(brush: BrushSpec, parameter: str) -> float:
    """Return a number of a brush or of its hairs; a solid tuft gives the usual hairs'."""
    owner = (brush.bristles or BristleSpec()) if _of_hairs(parameter) else brush
    return float(getattr(owner, parameter))


def range_of(brush: BrushSpec, parameter: str) -> tuple[float, float]:
    """Return the least and greatest value of a number, for a tuft of this length."""
    if _of_hairs(parameter):
        return hair_ranges()[parameter]
    if parameter == "length_mm":
        return size_limits(brush)
    return parameter_ranges(brush.length_mm)[parameter]


def changed(brush: BrushSpec, parameter: str, value: Any) -> BrushSpec:
    """Return the brush with another value; with another length, all lengths are scaled.

    Raises
    ------
    BrushError
        If it is out of its range.
    """
    if _of_hairs(parameter) or parameter == "table":
        hairs = dataclasses.replace(brush.bristles or BristleSpec(), **{parameter: value})
        return dataclasses.replace(brush, bristles=hairs)
    if parameter == "length_mm":
        return dataclasses.replace(resized(brush, value), name=brush.name)
    return dataclasses.replace(brush, **{parameter: value})


def with_hairs(brush: BrushSpec, hairs: BristleSpec | None) -> BrushSpec:
    """Return the brush with these single hairs; None: a solid tuft."""
    return dataclasses.replace(brush, bristles=hairs)


def points_of(brush: BrushSpec, setting: str, name: str) -> Points:
    """Return the points (input, factor) by which an input drives a setting; empty for none."""
    return dict(dict(brush.inputs).get(setting, ())).get(name, ())


def with_curve(brush: BrushSpec, setting: str, name: str, points: Points) -> BrushSpec:
    """Return the brush with another such curve; without points the input drives nothing.

    Raises
    ------
    BrushError
        If the points are no curve.
    """
    curves = {s: {i: points_of(brush, s, i) for i in INPUTS} for s in SETTINGS}
    curves[setting][name] = points
    by_setting = {s: {i: p for i, p in by_input.items() if p} for s, by_input in curves.items()}
    inputs: Any = {s: by_input for s, by_input in by_setting.items() if by_input}
    return dataclasses.replace(brush, inputs=inputs)


# ---- The editor ----------------------------------------------------------------------------------


_SIDE, _COLUMNS = 208, 440  # pixels of the pictures
_SHARPER = 2  # times as many are drawn
_EVEN, _RATIO, _WHOLE, _COUNT = range(4)  # scales of a slider

TUFT = (
    ("length_mm", Message("Length L"), "mm", _RATIO),
    ("root_diameter_mm", Message("Root"), "mm", _EVEN),
    ("taper", Message("Taper"), "", _EVEN),
    ("point_mm", Message("Point"), "mm", _EVEN),
    ("n_segments", Message("Segments n"), "", _WHOLE),
    ("tip_segment_mm", Message("Tip segment l1"), "mm", _EVEN),
    ("stiffness_exponent", Message("Stiffness exponent q"), "", _EVEN),
)
FORCE = (
    ("hardness", Message("Hardness H"), "", _EVEN),
    ("full_press_mm", Message("Full press"), "mm", _EVEN),
    ("max_force", Message("Greatest force"), "N", _RATIO),
    ("friction", Message("Friction μ"), "", _EVEN),
    ("spread_by_pressure", Message("Spread by pressure b"), "", _EVEN),
    ("spread_by_friction", Message("Spread by friction c"), "", _EVEN),
    ("drag_fraction", Message("Drag"), "", _EVEN),
    ("plasticity", Message("Bend that stays"), "", _EVEN),
    ("load", Message("Ink in a full tuft"), "mm²", _RATIO),
    ("transfer_per_mm", Message("Ink given per mm"), "", _RATIO),
)
OF_HAIRS = (
    ("n_hairs", Message("Number of hairs"), "", _COUNT),
    ("hair_mm", Message("Thickness of a hair"), "mm", _RATIO),
    ("threshold_mm", Message("Leaves ink within"), "mm", _EVEN),
    ("film", Message("Film of ink"), "", _EVEN),
    ("unevenness", Message("Uneven lengths"), "", _EVEN),
    ("parting", Message("Parting"), "", _EVEN),
    ("splay", Message("Splay"), "", _EVEN),
    ("appetite", Message("Uneven giving"), "", _EVEN),
    ("levelling_mm", Message("Levelling"), "mm", _RATIO),
    ("set_share", Message("Pressed out over"), "", _EVEN),
)
_SETTINGS = {
    "stiffness": Message("Stiffness"),
    "spread": Message("Spread"),
    "load": Message("Ink given"),
    "wetness": Message("Wetness"),
}
_INPUTS = {
    "pressure": Message("pressure"),
    "tilt": Message("tilt"),
    "speed": Message("speed"),
    "ink_left": Message("ink left"),
    "curvature": Message("curvature"),
}
_TABLES = {
    "energy": Message("Bent by least energy"),
    "measured": Message("Bent as FastBrush measured"),
}
_OWN_TABLE = Message("Bent as measured, own table")
_UNITS = {"tilt": "°", "speed": "mm/s", "curvature": "1/mm"}

Rows = tuple[tuple[str, str, str, int], ...]


class BrushEditor(QtWidgets.QDialog):
    """Change a brush and see what it does; painting goes on beside it.

    Parameters
    ----------
    parent : QWidget
    theme : Theme
    brush : BrushSpec
        The brush to begin with.
    ink : Ink
        Of the stroke that is shown.

    Signals
    -------
    taken : BrushSpec
        To be painted with.
    kept : BrushSpec
        To be saved as the user's own.
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

    # -- layout -----------------------------------------------------------------------------

    def _page(self, rows: Rows, *above: QtWidgets.QWidget) -> QtWidgets.QWidget:
        page = QtWidgets.QWidget()
        column = QtWidgets.QVBoxLayout(page)
        for widget in above:
            column.addWidget(widget)
        grid = QtWidgets.QGridLayout()
        grid.setColumnStretch(1, 1)
        column.addLayout(grid)
        column.addStretch(1)
        for name, label, unit, scale in rows:
            whole, even = scale in (_WHOLE, _COUNT), scale in (_EVEN, _WHOLE)
            row = NumberRow(
                grid, name, (label, say(meaning_of(name))), unit, whole=whole, even=even
            )
            row.changed.connect(self._change)
            self.rows[name] = row
        return page

    def _tuft_page(self) -> QtWidgets.QWidget:
        self.hair = QtWidgets.QComboBox()
        for name in HAIRS:
            self.hair.addItem(say_hair(name), name)
        self.hair.activated.connect(lambda _: self._change("hair", self.hair.currentData()))
        return self._page(TUFT, self.hair)

    def _hair_page(self) -> QtWidgets.QWidget:
        self.single = QtWidgets.QCheckBox(say("Paint with single hairs"))
        self.single.toggled.connect(self._choose_single)
        self.table = QtWidgets.QComboBox()
        self.table.setToolTip(say(meaning_of("table")))
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
        self.message_label = QtWidgets.QLabel()
        self.message_label.setObjectName("heading")
        self.message_label.setWordWrap(True)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(QtWidgets.QLabel(say("Name")))
        name = plain_name(self.brush)
        self.name_box = QtWidgets.QLineEdit(f"my {name}" if name in brush_names() else name)
        self.name_box.setMaxLength(60)
        self.name_box.textChanged.connect(lambda _: self.message_label.clear())
        row.addWidget(self.name_box, 1)
        self.take, self.keep = self._button(say("Paint with it")), self._button(say("Save as mine"))
        self.again, self.leave = self._button(say("Begin anew")), self._button(say("Close"))
        for button in (self.again, self.keep, self.take, self.leave):
            row.addWidget(button)
        self.take.clicked.connect(lambda: self._give(self.taken))
        self.keep.clicked.connect(lambda: self._give(self.kept))
        self.again.clicked.connect(self._begin_anew)
        self.leave.clicked.connect(self.close)
        column = QtWidgets.QVBoxLayout()
        column.addWidget(self.message_label)
        column.addLayout(row)
        return column

    def _button(self, text: str) -> QtWidgets.QPushButton:
        button = QtWidgets.QPushButton(text)
        button.setAutoDefault(False)
        return button

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
        """Change the brush, or show why not."""
        try:
            self.brush = change(self.brush)
            self.message_label.clear()
        except BrushError as error:
            self.message_label.setText(say_error(error))
        self._show()

    def _begin_anew(self) -> None:
        self._try(lambda _: self.begun)

    def _give(self, signal: QtCore.SignalInstance) -> None:
        """Emit the brush under its name, or show why it cannot have that name."""
        name = self.name_box.text().strip()
        try:
            check_brush_name(name)
            if dataclasses.replace(self.brush, name=name) != load_presets().get(name):
                check_not_preset(name, load_presets())
        except BrushError as error:
            self.show_message(error)
            return
        self.message_label.clear()
        signal.emit(dataclasses.replace(self.brush, name=name))

    def show_message(self, what: str | Paint3DError) -> None:
        """Show a message."""
        self.message_label.setText(what if isinstance(what, str) else say_error(what))

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
            text = _TABLES[table] if isinstance(table, str) else _OWN_TABLE
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
        message = [
            f"{say(_SETTINGS[s])} {say('by')} {say(_INPUTS[i])}: "
            + ", ".join(f"{x:g} → ×{y:g}" for x, y in line)
            for s, by_input in self.brush.inputs
            for i, line in by_input
        ]
        self.curves.setText("\n".join(message) or say("Nothing drives this brush"))

    def _show_drawn(self, drawn: Drawn) -> None:
        if drawn.error is not None or drawn.footprints is None or drawn.stroke is None:
            self.show_message(say_error(drawn.error or ""))
            return
        for label, pixels in ((self.footprints, drawn.footprints), (self.stroke, drawn.stroke)):
            pixmap = pixmap_of(pixels, label.size() * _SHARPER)
            pixmap.setDevicePixelRatio(float(_SHARPER))
            label.setPixmap(pixmap)

    def done(self, result: int) -> None:
        """Draw nothing more once it is closed."""
        self.drawing.close_down()
        super().done(result)

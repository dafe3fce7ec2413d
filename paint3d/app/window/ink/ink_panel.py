"""The inks as dishes: dip in one, stir several in the mixing dish, add water, rinse."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.persistence.own_pigments import check_unlike_palette
from paint3d.app.window.ink.water_scale import position_of, water_at
from paint3d.app.window.previews import ink_coat, ink_swatch, sorted_parts
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import language, say
from paint3d.brush.spec import DipAmount
from paint3d.colour.inks import TONES
from paint3d.colour.pigments import WATER, Pigment, load_palette, load_pigment
from paint3d.errors import Message
from paint3d.painter.painter import Ink

__all__ = [
    "TIP_REACH",
    "DishGrid",
    "InkPanel",
    "MixtureRow",
    "ToneRow",
    "in_tone",
    "ink_label",
    "paint_dish",
]

# ---- Tones ---------------------------------------------------------------------------------------
# The five tones of one ink as buttons: burnt, thick, heavy, light, clear.


_ICON = QtCore.QSize(26, 18)


def in_tone(parts: Mapping[str | Pigment, float], fraction: float) -> dict[str | Pigment, float]:
    """Return a mixture with this fraction of ink, 0 to 1, the rest water; inks keep their ratio."""
    inked = _without_water(parts)
    total = sum(inked.values())
    if not total:
        return {}
    toned = {ink: fraction * part / total for ink, part in inked.items()}
    return {**toned, WATER.name: 1.0 - fraction} if fraction < 1.0 else toned


def _without_water(parts: Mapping[Any, float]) -> dict[Any, float]:
    return {k: part for k, part in parts.items() if k is not WATER and k != WATER.name}


class ToneRow(QtWidgets.QWidget):
    """Five buttons that show a coat of the ink on xuan.

    Signals
    -------
    chosen : float
        Fraction of the tone that is ink.
    """

    chosen = QtCore.Signal(float)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.buttons: dict[str, QtWidgets.QToolButton] = {}
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        for name, tone in TONES.items():
            button = QtWidgets.QToolButton()
            button.setObjectName(f"tone_{name}")
            button.setIconSize(_ICON)
            button.setSizePolicy(
                QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Fixed
            )
            button.clicked.connect(lambda _=False, fraction=tone.share: self.chosen.emit(fraction))
            row.addWidget(button)
            self.buttons[name] = button

    def show_names(self, shown: bool) -> None:
        """Show the tones' names, or leave them to the tool tips."""
        style = QtCore.Qt.ToolButtonStyle
        for button in self.buttons.values():
            button.setToolButtonStyle(
                style.ToolButtonTextUnderIcon if shown else style.ToolButtonIconOnly
            )

    def show_ink(self, parts: Mapping[str | Pigment, float], theme: Theme) -> None:
        """Show the tones of this mixture; none where it is only water."""
        self._theme = theme
        inks = [ink if isinstance(ink, str) else ink.name for ink in _without_water(parts)]
        is_black = all("soot" in ink for ink in inks)  # its tones have names: no red is burnt
        for name, tone in TONES.items():
            toned, button = in_tone(parts, tone.share), self.buttons[name]
            share = 100.0 * tone.share
            called, tip = f"{share:.0f} %", say("{share:.0f} % ink, the rest water", share=share)
            if is_black:
                called = say(_TONES[name])
                tip = say("{tone}: {share:.0f} % ink, the rest water", tone=called, share=share)
            button.setText(called)
            button.setAccessibleName(called)
            button.setToolTip(tip)
            button.setEnabled(bool(toned))
            button.setIcon(QtGui.QIcon(self._coat(toned)))

    def _coat(self, parts: Mapping[str | Pigment, float]) -> QtGui.QPixmap:
        pixmap = QtGui.QPixmap(_ICON * 2)
        pixmap.fill(QtCore.Qt.GlobalColor.transparent)
        painter = QtGui.QPainter(pixmap)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        painter.setPen(QtGui.QPen(QtGui.QColor(self._theme.line), 2))
        painter.setBrush(QtGui.QColor(*ink_coat(parts)))
        painter.drawRoundedRect(QtCore.QRectF(pixmap.rect()).adjusted(1, 1, -1, -1), 8, 8)
        painter.end()
        pixmap.setDevicePixelRatio(2.0)
        return pixmap


# ---- Dishes and the panel ------------------------------------------------------------------------


_DISH, _GAP, _LABEL = 56, 8, 18
_ROW, _SEEN_ROWS = _DISH + _LABEL + _GAP, 3  # of dishes
_LOW, _LOWEST = 790, 750  # pixels of a window with little room for the panel, and with less
_SMALL_DISH, _MOST_MIXTURES = 26, 8
TIP_REACH = 0.35  # of the tuft's length, when the tip alone is dipped
_WATER_STEPS = 100  # of the slider: even in lightness
_WATER_PX = 300.0  # of a drag with the key for water, from ink to clear water
_SETTLE_MS = 150  # after which the brush is dipped in what such a drag came to
_LONG_MS = 500  # that a dish is pressed to stir
_KEY = QtCore.Qt.Key


def _parts(ink: Ink) -> dict[str, float]:
    """Return the parts of an ink by name."""
    stirred: Mapping[Any, float] = ink if isinstance(ink, Mapping) else {ink: 1.0}
    return {key if isinstance(key, str) else key.name: part for key, part in stirred.items()}


def ink_label(ink: str | Pigment) -> str:
    """Return an ink's name in the window's language."""
    pigment = load_pigment(ink) if isinstance(ink, str) else ink
    return pigment.chinese if language() == "zh" and pigment.chinese else pigment.name


def paint_dish(
    painter: QtGui.QPainter,
    box: QtCore.QRectF,
    parts: Mapping[Any, float],
    theme: Theme,
) -> None:
    """Draw a porcelain dish with ink in it: deep in the middle, a wash toward the rim."""
    painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1.2))
    rim = QtGui.QRadialGradient(box.center(), box.width() / 2)
    rim.setColorAt(0.0, QtGui.QColor("#f7f5f1"))
    rim.setColorAt(0.86, QtGui.QColor("#f3f0ea"))
    rim.setColorAt(1.0, QtGui.QColor("#d9d4cb"))
    painter.setBrush(rim)
    painter.drawEllipse(box)
    pigments = {ink: part for ink, part in parts.items() if part > 0.0}
    if not pigments:
        return
    inner = box.adjusted(*(box.width() * 0.11 * np.array([1, 1, -1, -1])))
    shades = ink_swatch(sorted_parts(pigments))
    fill = QtGui.QRadialGradient(inner.center() + QtCore.QPointF(0, 2), inner.width() / 2)
    for fraction in np.linspace(0.0, 1.0, 9):
        shade = shades[int((1.0 - fraction**3) * (len(shades) - 1))]
        fill.setColorAt(float(fraction), QtGui.QColor(*(int(c) for c in shade)))
    painter.setPen(QtCore.Qt.PenStyle.NoPen)
    painter.setBrush(fill)
    painter.drawEllipse(inner)
    shine = QtCore.QRectF(inner.left() + 0.24 * inner.width(), inner.top() + 0.14 * inner.height(),
                          0.30 * inner.width(), 0.13 * inner.height())  # fmt: skip
    painter.setBrush(QtGui.QColor(255, 255, 255, 66))
    painter.drawEllipse(shine)


_TONES = {
    "burnt": Message("Burnt"),
    "thick": Message("Thick"),
    "heavy": Message("Heavy"),
    "light": Message("Light"),
    "clear": Message("Clear"),
}
"""Names of the tones."""


def _percents(low: float, high: float, hint: str) -> QtWidgets.QDoubleSpinBox:
    """Return a box for a fraction in percent."""
    box = QtWidgets.QDoubleSpinBox()
    box.setRange(low, high)
    box.setDecimals(1)
    box.setSingleStep(5.0)
    box.setSuffix(" %")
    box.setKeyboardTracking(False)
    box.setToolTip(hint)
    return box


def _percent(part: float) -> str:
    """Format a fraction in percent: whole ones, and two digits below one."""
    return f"{100 * part:.0f}" if part >= 0.01 else f"{100 * part:.2g}"


def _paint_plus(painter: QtGui.QPainter, middle: QtCore.QPointF, theme: Theme) -> None:
    """Draw the sign that a dish has been pressed long enough to stir."""
    painter.setPen(QtCore.Qt.PenStyle.NoPen)
    painter.setBrush(QtGui.QColor(theme.accent))
    painter.drawEllipse(middle, 9.0, 9.0)
    painter.setPen(QtGui.QPen(QtGui.QColor(theme.chosen), 2.0))
    for arm in (QtCore.QPointF(5.0, 0.0), QtCore.QPointF(0.0, 5.0)):
        painter.drawLine(middle - arm, middle + arm)


class DishGrid(QtWidgets.QWidget):
    """Dishes in rows, one for each ink.

    Signals
    -------
    taken : str
        A dish was clicked.
    stirred : str
        It was clicked with the other button, with Ctrl, or pressed long: one part into the mixing
        dish. With the keys: "+".
    taken_out : str
        "-" was pressed: one part out of the mixing dish again.
    """

    taken = QtCore.Signal(str)
    stirred = QtCore.Signal(str)
    taken_out = QtCore.Signal(str)

    def __init__(self, names: Sequence[str], theme: Theme) -> None:
        super().__init__()
        self.names, self.theme, self.chosen = list(names), theme, ""
        self.pigments = {name: load_pigment(name) for name in names}
        self.setMouseTracking(True)
        self.setFocusPolicy(QtCore.Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(say("Inks"))
        self._at = -1
        self._pressed, self._pressed_ms = -1, 0
        # A millisecond later than the limit: the plus never shows before a release would stir.
        self._long = QtCore.QTimer(self, singleShot=True, interval=_LONG_MS + 1)
        self._long.setTimerType(QtCore.Qt.TimerType.PreciseTimer)
        self._long.timeout.connect(self.update)
        policy = self.sizePolicy()
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)

    @property
    def marked(self) -> str:
        """The ink of the dish under the keys' mark or the pointer; empty for none."""
        return self.names[self._at] if self._at >= 0 else ""

    def add(self, pigment: Pigment) -> None:
        """Add a dish of an ink behind the others, or replace the one of its name."""
        if pigment.name not in self.pigments:
            self.names.append(pigment.name)
        self.pigments[pigment.name] = pigment
        self._fit()

    def put_away_own(self) -> None:
        """Remove all dishes but those of the palette."""
        self.names = list(load_palette())
        self.pigments = {name: self.pigments[name] for name in self.names}
        self._at = -1
        self._fit()

    def _fit(self) -> None:
        """Take the height that the dishes need now."""
        self.setMinimumHeight(self.heightForWidth(self.width()))
        self.updateGeometry()
        self.update()

    def columns(self, width: int) -> int:
        """Return the number of dishes that fit beside each other."""
        return max(1, (width - _GAP) // (_DISH + _GAP))

    def heightForWidth(self, width: int) -> int:
        """Return the height of the rows."""
        rows = -(-len(self.names) // self.columns(width))
        return rows * _ROW + _GAP

    def sizeHint(self) -> QtCore.QSize:
        """Return the current width, and the height that it needs."""
        return QtCore.QSize(280, self.heightForWidth(max(self.width(), 200)))

    def box(self, index: int) -> QtCore.QRectF:
        """Return a dish's rectangle."""
        columns = self.columns(self.width())
        step = (self.width() - _GAP) / columns
        x = _GAP / 2 + (index % columns) * step + (step - _DISH) / 2
        y = _GAP + (index // columns) * _ROW
        return QtCore.QRectF(x, y, _DISH, _DISH)

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Take the height that the rows need."""
        super().resizeEvent(event)
        self.setMinimumHeight(self.heightForWidth(self.width()))

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw the dishes."""
        painter = QtGui.QPainter(self)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        small = painter.font()
        small.setPointSizeF(small.pointSizeF() - 1.5)
        painter.setFont(small)
        for k, name in enumerate(self.names):
            box = self.box(k)
            if name == self.chosen:
                painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 2.4))
                painter.setBrush(QtGui.QColor(self.theme.chosen))
                painter.drawRoundedRect(box.adjusted(-4, -4, 4, _LABEL + 3), 9, 9)
            elif k == self._at:
                strong = self.theme.accent if self.hasFocus() else self.theme.line
                painter.setPen(QtGui.QPen(QtGui.QColor(strong), 1.4))
                painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
                painter.drawRoundedRect(box.adjusted(-4, -4, 4, _LABEL + 3), 9, 9)
            ink = self.pigments[name]
            paint_dish(painter, box, {ink: 1.0} if ink is not WATER else {}, self.theme)
            if k == self._pressed and not self._long.isActive():
                _paint_plus(painter, box.center(), self.theme)
            painter.setPen(QtGui.QColor(self.theme.text))
            label = QtCore.QRectF(box.left() - 8, box.bottom() + 1, box.width() + 16, _LABEL)
            text = painter.fontMetrics().elidedText(
                ink_label(ink), QtCore.Qt.TextElideMode.ElideRight, int(label.width())
            )
            painter.drawText(label, QtCore.Qt.AlignmentFlag.AlignCenter, text)
        painter.end()

    def _index(self, position: QtCore.QPointF) -> int:
        for k in range(len(self.names)):
            if self.box(k).adjusted(-4, -4, 4, _LABEL).contains(position):
                return k
        return -1

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Mark the dish under the pointer, and set its tool tip."""
        at = self._index(event.position())
        if at != self._at:
            self._at = at
            self.setToolTip(_tool_tip(self.pigments[self.names[at]]) if at >= 0 else "")
            self.update()

    def leaveEvent(self, event: QtCore.QEvent) -> None:
        """Unmark the dish."""
        self._at = -1
        self.update()

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Stir with the other button or Ctrl; else begin to time the press."""
        at, left = self._index(event.position()), QtCore.Qt.MouseButton.LeftButton
        if at < 0 or (event.button() != left and event.buttons() & left):
            return
        stirs = event.button() == QtCore.Qt.MouseButton.RightButton or (
            event.modifiers() & QtCore.Qt.KeyboardModifier.ControlModifier
        )
        if stirs:
            self.stirred.emit(self.names[at])
        else:
            self._pressed, self._pressed_ms = at, event.timestamp()
            self._long.start()

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """Dip in the dish that was pressed, or stir if the press was long."""
        if event.buttons() & QtCore.Qt.MouseButton.LeftButton:
            return  # another button was released
        pressed, self._pressed = self._pressed, -1
        self._long.stop()
        self.update()
        if pressed >= 0 and self._index(event.position()) == pressed:
            # by the events' own times: a busy window gets the release of a short press late
            is_long = event.timestamp() - self._pressed_ms >= _LONG_MS
            (self.stirred if is_long else self.taken).emit(self.names[pressed])

    def focusInEvent(self, event: QtGui.QFocusEvent) -> None:
        """Mark the dish that keys act on."""
        super().focusInEvent(event)
        if self._at < 0:
            self._point(self.names.index(self.chosen) if self.chosen in self.names else 0)

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Go from dish to dish, dip with Enter or Space, stir with +, take out with -."""
        key, at = event.key(), max(self._at, 0)
        steps: dict[int, int] = {
            _KEY.Key_Left: -1, _KEY.Key_Right: 1,
            _KEY.Key_Up: -self.columns(self.width()), _KEY.Key_Down: self.columns(self.width()),
        }  # fmt: skip
        if key in steps:
            if 0 <= at + steps[key] < len(self.names):
                self._point(at + steps[key])
        elif key in (_KEY.Key_Return, _KEY.Key_Enter, _KEY.Key_Space):
            self.taken.emit(self.names[at])
        elif key in (_KEY.Key_Plus, _KEY.Key_Equal):
            self.stirred.emit(self.names[at])
        elif key == _KEY.Key_Minus:
            self.taken_out.emit(self.names[at])
        else:
            super().keyPressEvent(event)

    def event(self, event: QtCore.QEvent) -> bool:
        """Take + and - before the view's shortcuts do, while the dishes have the focus."""
        is_override = event.type() == QtCore.QEvent.Type.ShortcutOverride
        if is_override and isinstance(event, QtGui.QKeyEvent) and event.key() in (
            _KEY.Key_Plus, _KEY.Key_Equal, _KEY.Key_Minus,
        ):  # fmt: skip
            event.accept()
            return True
        return super().event(event)

    def _point(self, at: int) -> None:
        """Mark a dish, and scroll to it."""
        self._at = at
        self.setToolTip(_tool_tip(self.pigments[self.names[at]]))
        self.update()
        parent = self.parentWidget()
        area = None if parent is None else parent.parentWidget()
        if isinstance(area, QtWidgets.QScrollArea):
            middle = self.box(at).center().toPoint()
            area.ensureVisible(middle.x(), middle.y(), _DISH, _DISH)


def _tool_tip(pigment: Pigment) -> str:
    names = " ".join(filter(None, (pigment.name, pigment.chinese)))
    hint = say(
        "Click: dip. Long press, right button, Ctrl or +: stir a part into the mixing dish; "
        "− takes it out"
    )
    return f"{names}\n{hint}"


class _MixingDish(QtWidgets.QWidget):
    """A large dish that shows what has been stirred together."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self.parts: dict[str | Pigment, float] = {}
        self.fit(True)

    def fit(self, has_room: bool) -> None:
        """Take the large size, or the small one where room is short."""
        side = 74 if has_room else 60
        self.setFixedSize(side, side)

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw it."""
        painter = QtGui.QPainter(self)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        box = QtCore.QRectF(self.rect()).adjusted(3, 3, -3, -3)
        paint_dish(painter, box, self.parts, self.theme)
        painter.end()


class MixtureRow(QtWidgets.QWidget):
    """The mixtures that the brush was dipped in last as small dishes, the newest first.

    Signals
    -------
    chosen : int
        Clicked: the brush is to be dipped in it.
    asked_back : int
        Clicked with the other button or with Ctrl: it is to go back into the mixing dish.
    """

    chosen = QtCore.Signal(int)
    asked_back = QtCore.Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self.mixtures: list[dict[str, float]] = []
        self.buttons: list[QtWidgets.QToolButton] = []
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        for index in range(_MOST_MIXTURES):
            button = QtWidgets.QToolButton()
            button.setObjectName(f"mixture_{index}")
            button.setAccessibleName(say("A last mixture"))
            button.setIconSize(QtCore.QSize(_SMALL_DISH, _SMALL_DISH))
            button.setAutoRaise(True)
            button.setFixedSize(_SMALL_DISH + 2, _SMALL_DISH + 2)
            button.setContextMenuPolicy(QtCore.Qt.ContextMenuPolicy.CustomContextMenu)
            button.clicked.connect(lambda _=False, index=index: self._clicked(index))
            button.customContextMenuRequested.connect(
                lambda _, index=index: self.asked_back.emit(index)
            )
            row.addWidget(button)
            self.buttons.append(button)
        row.addStretch(1)

    def _clicked(self, index: int) -> None:
        modifiers = QtWidgets.QApplication.keyboardModifiers()
        is_back = bool(modifiers & QtCore.Qt.KeyboardModifier.ControlModifier)
        (self.asked_back if is_back else self.chosen).emit(index)

    def remember(self, parts: Mapping[str, float]) -> None:
        """Put a mixture at the head, once; the oldest goes when the row is full."""
        rounded = _rounded(parts)
        others = [other for other in self.mixtures if _rounded(other) != rounded]
        self.mixtures = [dict(parts), *others][:_MOST_MIXTURES]

    def show_mixtures(self, pigments: Mapping[str, Pigment], theme: Theme) -> None:
        """Draw the dishes; hide those of pigments that are not loaded."""
        pigments = {WATER.name: WATER, **pigments}
        for index, button in enumerate(self.buttons):
            parts = self.mixtures[index] if index < len(self.mixtures) else {}
            button.setVisible(bool(parts) and all(name in pigments for name in parts))
            if not button.isVisibleTo(self):
                continue
            pixmap = QtGui.QPixmap(2 * _SMALL_DISH, 2 * _SMALL_DISH)
            pixmap.fill(QtCore.Qt.GlobalColor.transparent)
            painter = QtGui.QPainter(pixmap)
            painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
            box = QtCore.QRectF(pixmap.rect()).adjusted(2, 2, -2, -2)
            paint_dish(painter, box, {pigments[name]: part for name, part in parts.items()}, theme)
            painter.end()
            pixmap.setDevicePixelRatio(2.0)
            button.setIcon(QtGui.QIcon(pixmap))
            total = sum(parts.values())
            called = ", ".join(
                f"{ink_label(pigments[name])} {_percent(part / total)} %"
                for name, part in parts.items()
            )
            button.setAccessibleName(called)
            hint = say("Click: dip. Right button or Ctrl: back into the mixing dish")
            button.setToolTip(f"{called}\n{hint}")


def _rounded(parts: Mapping[str, float]) -> dict[str, float]:
    """Return a mixture's fractions to a thousandth; finer differences are not seen."""
    total = sum(parts.values())
    return {name: round(part / total, 3) for name, part in parts.items() if part > 0.0}


class InkPanel(QtWidgets.QWidget):
    """Dishes, mixing dish, and what the brush can do over them.

    Signals
    -------
    dipped : (ink, reach)
        A name or parts by name; reach None for the whole tuft.
    rinsed : ()
    pickup_chosen : float
        The fraction of wet ink that the brush takes up, 1/mm.
    amount_chosen : dict of str to float, or None
        How much the next dip takes up, as `DipAmount.words` says it; None: as the dip before.
    by_itself_chosen : bool
        Whether the brush is dipped before a stroke for which little is left.
    watering : float
        Fraction of water that a drag with its key has reached.
    colour_asked, table_asked : ()
        Any colour is to be mixed, or a table of pigments to be opened.
    mixtures_changed : tuple of dict of str to float
        The mixtures that the brush was dipped in last.
    """

    dipped = QtCore.Signal(object, object)
    rinsed = QtCore.Signal()
    pickup_chosen = QtCore.Signal(float)
    amount_chosen = QtCore.Signal(object)
    by_itself_chosen = QtCore.Signal(bool)
    watering = QtCore.Signal(float)
    colour_asked = QtCore.Signal()
    table_asked = QtCore.Signal()
    mixtures_changed = QtCore.Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.ink: Ink = "pine soot"
        self._stirred: dict[str, float] = {}
        self._own_mixture: dict[str, float] = {}  # mixed elsewhere, until something is stirred in
        self.dishes = DishGrid(list(load_palette()), theme)
        self._mixing = _MixingDish(theme)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setWordWrap(True)
        self.message_label.setObjectName("faint")
        self.message_label.setTextInteractionFlags(
            QtCore.Qt.TextInteractionFlag.LinksAccessibleByMouse
            | QtCore.Qt.TextInteractionFlag.LinksAccessibleByKeyboard
        )
        self.message_label.linkActivated.connect(self._link)
        self.water = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.water.setRange(0, _WATER_STEPS)
        self.water.setAccessibleName(say("Water"))
        self.water.setToolTip(say("Even steps of lightness; V held and a drag waters the brush"))
        self._watered: float | None = None  # where a drag with the key for water has come
        self._settle = QtCore.QTimer(self, interval=_SETTLE_MS, singleShot=True)
        self._settle.timeout.connect(self._dip_watered)
        self.tip_only = QtWidgets.QCheckBox(say("Tip only"))
        self.reach = QtWidgets.QSpinBox()
        self.reach.setRange(5, 95)
        self.reach.setSuffix(" %")
        self.reach.setValue(round(100 * TIP_REACH))
        self.reach.setToolTip(say("How much of the tuft is dipped, from the tip"))
        self.reach.setAccessibleName(say("Tip only"))
        self._amount = DipAmount()  # of the dip before
        self.wetted = _percents(0.1, 100.0, say("How much of the tuft a dip wets, from the tip"))
        self.fullness = _percents(
            5.0, 300.0, say("How full that part becomes; 100 % as it is made")
        )
        self.by_itself = QtWidgets.QCheckBox(say("Dip automatically"))
        self.by_itself.setToolTip(say("Before a stroke, when less than a quarter is left"))
        self.tones = ToneRow(theme)
        self.last = MixtureRow()
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 6)
        layout.setSpacing(5)
        scroll = QtWidgets.QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setWidget(self.dishes)
        scroll.setMinimumHeight(_ROW)
        self.fold = QtWidgets.QToolButton()
        self.fold.setObjectName("fold")
        self.fold.setText(say("How the brush is dipped"))
        self.fold.setToolButtonStyle(QtCore.Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.setCheckable(True)
        self.fold.setChecked(True)
        self.fold.toggled.connect(lambda _: self._fold())
        self._folded_by_hand = False
        self._dip_box = self._make_dip_box()
        layout.addWidget(scroll, 1)
        layout.addWidget(self.last)
        layout.addWidget(self.tones)
        layout.addWidget(self._make_mixing_card())
        layout.addWidget(self.fold)
        layout.addWidget(self._dip_box)
        self._show_dip_box()
        self.tones.chosen.connect(self._dip_tone)
        self.last.chosen.connect(lambda at: self._dip(self._of_dishes(self.last.mixtures[at])))
        self.last.asked_back.connect(self._put_back)
        self.dishes.taken.connect(lambda name: self._dip(next(iter(self._of_dishes({name: 1.0})))))
        self.dishes.stirred.connect(self.stir)
        self.dishes.taken_out.connect(self.take_out)
        self.water.valueChanged.connect(lambda _: self._water_moved())
        self.show_inks([self.ink])
        self._show_mixture()

    def _make_mixing_card(self) -> QtWidgets.QFrame:
        card = QtWidgets.QFrame()
        card.setObjectName("card")
        grid = QtWidgets.QGridLayout(card)
        grid.setContentsMargins(8, 5, 8, 6)
        grid.setVerticalSpacing(4)
        grid.addWidget(self._mixing, 0, 0, 2, 1)
        grid.addWidget(self.message_label, 0, 1)
        row = QtWidgets.QHBoxLayout()
        self._water_label = QtWidgets.QLabel()
        row.addWidget(self._water_label)
        row.addWidget(self.water, 1)
        grid.addLayout(row, 1, 1)
        self._dip_button = QtWidgets.QPushButton(say("Dip"))
        empty, rinse = QtWidgets.QPushButton(say("Empty")), QtWidgets.QPushButton(say("Rinse"))
        row = QtWidgets.QHBoxLayout()
        row.setSpacing(6)
        for button in (self._dip_button, empty, rinse):
            row.addWidget(button, 1)
        grid.addLayout(row, 2, 0, 1, 2)
        grid.setColumnStretch(1, 1)
        self._dip_button.clicked.connect(self.dip_mixture)
        empty.clicked.connect(self.empty)
        rinse.clicked.connect(self.rinsed)
        return card

    def _make_dip_box(self) -> QtWidgets.QWidget:
        """Make the settings of dipping, which are set once, and folded away where room is short."""
        folded = QtWidgets.QWidget()
        column = QtWidgets.QVBoxLayout(folded)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.tip_only)
        row.addWidget(self.reach)
        row.addStretch(1)
        row.addWidget(self.by_itself)
        column.addLayout(row)
        self.by_itself.toggled.connect(self.by_itself_chosen)
        row = QtWidgets.QHBoxLayout()
        for text, box in ((say("How deep"), self.wetted), (say("How full"), self.fullness)):
            row.addWidget(QtWidgets.QLabel(text))
            row.addWidget(box, 1)
            box.setAccessibleName(text)
            box.setValue(100.0)
            self.tip_only.toggled.connect(box.setDisabled)  # a tip takes up what it needs
            box.valueChanged.connect(lambda _: self.amount_chosen.emit(self.amount().words()))
        column.addLayout(row)
        column.addLayout(self._make_sources())
        return folded

    def _make_sources(self) -> QtWidgets.QHBoxLayout:
        row = QtWidgets.QHBoxLayout()
        self.pickup = QtWidgets.QDoubleSpinBox()
        self.pickup.setRange(0.0, 1.0)
        self.pickup.setDecimals(3)
        self.pickup.setSingleStep(0.01)
        self.pickup.setKeyboardTracking(False)
        self.pickup.setButtonSymbols(QtWidgets.QAbstractSpinBox.ButtonSymbols.NoButtons)
        self.pickup.setMaximumWidth(62)
        label = QtWidgets.QLabel(say("Pick-up"))
        for widget in (label, self.pickup):
            widget.setToolTip(
                say(
                    "The share of the wet ink under it that the brush takes up per mm: a dirty "
                    "brush; 0 keeps it clean"
                )
            )
        self.pickup.setAccessibleName(say("Pick-up"))
        self.pickup.valueChanged.connect(self.pickup_chosen)
        row.addWidget(label)
        row.addWidget(self.pickup)
        for text, name, asked in (
            (say("Colour"), "choose_colour", self.colour_asked),
            (say("Pigments"), "open_pigments", self.table_asked),
        ):
            button = QtWidgets.QPushButton(text)
            button.setObjectName(name)
            button.clicked.connect(lambda _=False, asked=asked: asked.emit())
            row.addWidget(button, 1)
        return row

    def fit(self, height: int) -> None:
        """Fit the panel into a window of so many pixels.

        In a low one the settings of dipping are folded, until the user has folded or unfolded them.
        """
        self.tones.show_names(height >= _LOW)
        self._mixing.fit(height >= _LOW)
        if not self._folded_by_hand:
            with QtCore.QSignalBlocker(self.fold):
                self.fold.setChecked(height >= _LOWEST)
            self._show_dip_box()

    def _fold(self) -> None:
        self._folded_by_hand = True
        self._show_dip_box()

    def _show_dip_box(self) -> None:
        arrow = QtCore.Qt.ArrowType
        is_open = self.fold.isChecked()
        self.fold.setArrowType(arrow.DownArrow if is_open else arrow.RightArrow)
        self._dip_box.setVisible(is_open)
        self.updateGeometry()

    def heightForWidth(self, width: int) -> int:
        """Return the panel's least height: the dishes scroll by themselves."""
        layout = self.layout()
        assert layout is not None, "it was made with one"
        return layout.minimumHeightForWidth(width)

    def height_with_dishes(self, width: int) -> int:
        """Return the height at which three rows of dishes are seen, or all there are."""
        rows = min(_SEEN_ROWS, -(-len(self.dishes.names) // self.dishes.columns(width)))
        return self.heightForWidth(width) + (rows - 1) * _ROW

    def show_pickup(self, fraction: float) -> None:
        """Show how much wet ink the brush takes up, 1/mm, without emitting a signal."""
        if not self.pickup.hasFocus() and abs(self.pickup.value() - fraction) > 1e-9:
            with QtCore.QSignalBlocker(self.pickup):
                self.pickup.setRange(0.0, max(1.0, fraction))
                self.pickup.setValue(fraction)

    def amount(self) -> DipAmount:
        """Return how much the next dip takes up."""
        return DipAmount(0.01 * self.wetted.value(), 0.01 * self.fullness.value())

    def show_amount(self, amount: DipAmount, *, anew: bool = False) -> None:
        """Show how much the last dip took up: if that is other than before, or of another brush."""
        if amount == self._amount and not anew:
            return
        self._amount = amount
        for box, fraction in ((self.wetted, amount.wetted), (self.fullness, amount.fullness)):
            with QtCore.QSignalBlocker(box):
                box.setValue(100.0 * fraction)
        self.amount_chosen.emit(None)

    def show_by_itself(self, on: bool) -> None:
        """Show whether the brush is dipped by itself, without emitting a signal."""
        with QtCore.QSignalBlocker(self.by_itself):
            self.by_itself.setChecked(on)

    def show_last(self, mixtures: Iterable[Mapping[str, float]]) -> None:
        """Show the mixtures that the brush was dipped in last, the newest first."""
        self.last.mixtures = [dict(parts) for parts in mixtures][:_MOST_MIXTURES]
        self.last.show_mixtures(self.dishes.pigments, self.dishes.theme)

    def add_pigments(self, pigments: Iterable[Pigment], source: str) -> None:
        """Add the user's own pigments to the dishes.

        Raises
        ------
        PigmentError
            If one has the name of one of the palette; then none is added.
        """
        pigments = list(pigments)
        check_unlike_palette(pigments, source)
        for pigment in pigments:
            self.dishes.add(pigment)
        self.last.show_mixtures(self.dishes.pigments, self.dishes.theme)

    def put_away_own(self) -> None:
        """Remove the dishes of the user's own pigments, and a mixture with one of them."""
        if {*self._stirred, *self._own_mixture} - {*load_palette(), WATER.name}:
            self.empty()
        self.dishes.put_away_own()
        self.last.show_mixtures(self.dishes.pigments, self.dishes.theme)

    # -- stirring ---------------------------------------------------------------------------

    def stir(self, name: str) -> None:
        """Put one more part of an ink into the mixing dish."""
        self._own_mixture = {}
        self._stirred[name] = self._stirred.get(name, 0.0) + 1.0
        self._show_mixture()

    def take_out(self, name: str) -> None:
        """Take one part of an ink out of the mixing dish again."""
        self._own_mixture = {}
        left = self._stirred.get(name, 0.0) - 1.0
        if left > 0.0:
            self._stirred[name] = left
        else:
            self._stirred.pop(name, None)
        self._show_mixture()

    def _link(self, link: str) -> None:
        sign, name = link[0], link[1:]
        (self.stir if sign == "+" else self.take_out)(name)

    def empty(self) -> None:
        """Wash the mixing dish."""
        self._stirred, self._own_mixture = {}, {}
        self.water.setValue(0)
        self._show_mixture()

    def mixture(self) -> dict[str, float]:
        """Return the contents of the mixing dish: parts by name, of sum 1, water among them."""
        if self._own_mixture:
            return dict(self._own_mixture)
        total = sum(self._stirred.values())
        if not total:
            return {}
        inks = _without_water(self._stirred)
        fraction = 0.0
        if inks:
            fraction = water_at(self._of_dishes(inks), self.water.value() / _WATER_STEPS)
        parts = {name: part / total * (1.0 - fraction) for name, part in self._stirred.items()}
        return {**parts, WATER.name: fraction} if fraction else parts

    def show_mixture(self, parts: Mapping[Pigment, float]) -> None:
        """Replace the contents of the mixing dish by a mixture."""
        fractions = {ink.name: part for ink, part in parts.items()}
        inked = {name: part for name, part in fractions.items() if name != WATER.name}
        if not inked:
            return
        least = min(inked.values())
        with QtCore.QSignalBlocker(self.water):
            water = fractions.get(WATER.name, 0.0)
            self.water.setValue(round(_WATER_STEPS * position_of(self._of_dishes(inked), water)))
        self._stirred = {name: part / least for name, part in inked.items()}
        self._own_mixture = fractions
        self._show_mixture()

    def _put_back(self, at: int) -> None:
        """Put one of the last mixtures into the mixing dish."""
        pigments = {WATER.name: WATER, **self.dishes.pigments}
        self.show_mixture({pigments[name]: part for name, part in self.last.mixtures[at].items()})

    def _water_moved(self) -> None:
        self._own_mixture = {}
        self._show_mixture()

    def _of_dishes(self, parts: Mapping[str, float]) -> dict[Any, float]:
        """Return parts by name, with the user's own pigments instead of their names."""
        own = {n: p for n, p in self.dishes.pigments.items() if n not in load_palette()}
        return {own.get(name, name): part for name, part in parts.items()}

    def _show_mixture(self) -> None:
        parts = self.mixture()
        self._mixing.parts = self._of_dishes(parts)
        self._mixing.update()
        self._dip_button.setEnabled(bool(parts))
        if not parts:
            self._water_label.setText(say("Water"))
            self.message_label.setText(
                say("Mixing dish: stir inks in with a long press or the right button")
            )
            return
        water = 100.0 * parts.get(WATER.name, 0.0)
        self._water_label.setText(say("Water {share:.0f} %", share=water))
        stirred = (name for name in parts if name != WATER.name or name in self._stirred)
        self.message_label.setText("<br>".join(self._line(name, parts[name]) for name in stirred))

    def _line(self, name: str, part: float) -> str:
        """Format an ink of the mixing dish, with signs to put a part in and to take one out."""
        pigment = self.dishes.pigments.get(name, name)
        message = f"{html.escape(ink_label(pigment))} {_percent(part)} %"
        style = f"color:{self.dishes.theme.accent}; text-decoration:none"
        signs = (
            f'<a href="{sign}{html.escape(name)}" style="{style}">&nbsp;<b>{shown}</b>&nbsp;</a>'
            for sign, shown in (("-", "−"), ("+", "+"))
        )
        return f"{next(signs)} {message} {next(signs)}"

    # -- the brush --------------------------------------------------------------------------

    def dip_mixture(self) -> None:
        """Dip in what is in the mixing dish."""
        self._dip(self._of_dishes(self.mixture()))

    def _dip_tone(self, fraction: float) -> None:
        """Dip in the ink that the brush was dipped in, in one of its tones."""
        self._dip(in_tone(self.ink if isinstance(self.ink, Mapping) else {self.ink: 1.0}, fraction))

    def water_by(self, pixels: float) -> None:
        """Make the ink in hand lighter or darker by a drag; the brush is dipped where it ends."""
        parts = self.ink if isinstance(self.ink, Mapping) else {self.ink: 1.0}
        inks = _without_water(parts)
        if not inks:
            return
        if self._watered is None:
            inked = sum(inks.values()) / sum(parts.values())
            self._watered = position_of(inks, 1.0 - inked)
        self._watered = min(1.0, max(0.0, self._watered + pixels / _WATER_PX))
        self.watering.emit(water_at(inks, self._watered))
        self._settle.start()

    def _dip_watered(self) -> None:
        inks = _without_water(self.ink if isinstance(self.ink, Mapping) else {self.ink: 1.0})
        position, self._watered = self._watered, None
        if position is not None and inks:
            self._dip(in_tone(inks, 1.0 - water_at(inks, position)))

    def _dip(self, ink: Ink) -> None:
        if not ink:
            return
        reach = self.reach.value() / 100.0 if self.tip_only.isChecked() else None
        self.show_inks([ink])
        self.dipped.emit(ink, reach)
        if len(parts := _parts(ink)) > 1:
            self.last.remember(parts)
            self.last.show_mixtures(self.dishes.pigments, self.dishes.theme)
            self.mixtures_changed.emit(tuple(self.last.mixtures))

    def show_inks(self, inks: Sequence[Ink]) -> None:
        """Show the ink that the brush is dipped in."""
        self.ink = inks[0]
        parts = _parts(self.ink)
        self.dishes.chosen = next(iter(parts)) if len(parts) == 1 else ""
        self.dishes.update()
        shown = self.ink if isinstance(self.ink, Mapping) else {self.ink: 1.0}
        self.tones.show_ink(shown, self.dishes.theme)

    def ink_name(self) -> str:
        """Return the name of the ink that the brush is dipped in."""
        inks: Iterable[Any] = self.ink if isinstance(self.ink, Mapping) else (self.ink,)
        return " + ".join(ink_label(ink) for ink in inks)

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self.dishes.theme = self._mixing.theme = theme
        self._show_mixture()
        self.show_inks([self.ink])
        self.last.show_mixtures(self.dishes.pigments, theme)
        self.update()

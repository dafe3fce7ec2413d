"""The strokes of a painting: their list, a slider to go back and forth, their replay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.frame import PaintingFrame, Snapshot
from paint3d.app.model.stroke_log import ERASES
from paint3d.app.window.brush.brush_panel import plain_icon, plain_name
from paint3d.app.window.ink.ink_panel import ink_label, paint_dish
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_brush
from paint3d.errors import Message

__all__ = ["HistoryPanel"]

_ICON = 22
_SPEEDS = (("¼ x", 0.25), ("½ x", 0.5), ("1 x", 1.0), ("4 x", 4.0), ("16 x", 16.0), ("max", None))
_STROKE_EDIT_MENU = (
    ("pick", Message("Choose one on the object")),
    ("drag", Message("Move it on the object")),
    ("move", Message("Move it by numbers…")),
    ("ink", Message("Paint it in the ink in hand")),
    ("brush", Message("Paint it with the brush in hand")),
    ("time", Message("Its time…")),
    ("delete", Message("Delete it")),
)
"""Edits of a stroke, with the menu's texts."""
_SEAL_EDIT_MENU = (
    ("drag", Message("Move it on the object")),
    ("ink", Message("Press it in the ink in hand")),
    ("delete", Message("Delete it")),
)
_MOST_SEAL_ROWS = 3
_LEAST_MS = 40  # a stroke is shown at least so long


class _StrokeList(QtWidgets.QListWidget):
    """Rows that the right button does not choose: it opens a menu for one."""

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Show where the painting is, also where it has become lower."""
        super().resizeEvent(event)
        if (item := self.currentItem()) is not None:
            self.scrollToItem(item)

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Choose a row, but with the right button."""
        if event.button() == QtCore.Qt.MouseButton.RightButton:
            event.accept()
        else:
            super().mousePressEvent(event)


class HistoryPanel(QtWidgets.QWidget):
    """The history: the painting stroke by stroke.

    Signals
    -------
    asked : (int, bool)
        The painting is to be shown as it was after so many strokes; only to look at, or to go on.
    chosen : (object)
        The stroke of a row, from 0, is to be marked; None: none is any more.
    edited : (str, int)
        What is to be done with a stroke, and its row; see `StrokeEditing.ask`.
    seal_edited : (str, int)
        What is to be done with a seal ("drag", "ink", "delete"), and its index, from 0.
    exported : ()
        The strokes are to be saved as a recording.
    reported : (str)
        Something to say.
    """

    asked = QtCore.Signal(int, bool)
    chosen = QtCore.Signal(object)
    edited = QtCore.Signal(str, int)
    seal_edited = QtCore.Signal(str, int)
    exported = QtCore.Signal()
    reported = QtCore.Signal(str)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._shown: tuple[int, int] = (-1, -1)
        self._strokes: list[Any] = []
        self._wanted: int | None = None  # strokes of the state that was asked for and has not come
        self._is_playing = False
        self._marked: tuple[int, ...] = ()
        self.list = _StrokeList()
        self.list.setObjectName("strokes")
        self.list.setAccessibleName(say("Strokes"))
        self.list.setIconSize(QtCore.QSize(_ICON, _ICON))
        self.list.itemClicked.connect(lambda item: self._choose_row(self.list.row(item)))
        self.list.currentRowChanged.connect(self._choose_row)
        self.list.setContextMenuPolicy(QtCore.Qt.ContextMenuPolicy.CustomContextMenu)
        self.list.customContextMenuRequested.connect(self._show_menu)
        self.seals = _StrokeList()
        self.seals.setObjectName("seals")
        self.seals.setAccessibleName(say("Seals"))
        self.seals.setToolTip(say("Move, press anew or delete a seal by the right button"))
        self.seals.setContextMenuPolicy(QtCore.Qt.ContextMenuPolicy.CustomContextMenu)
        self.seals.customContextMenuRequested.connect(self._show_seal_menu)
        self.seals.itemActivated.connect(
            lambda item: self.seal_edited.emit("drag", self.seals.row(item))
        )
        self.seals.hide()
        self.slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.slider.setPageStep(1)
        self.slider.setAccessibleName(say("Back and forth through the strokes"))
        self.slider.valueChanged.connect(self._slide)
        self.count = QtWidgets.QLabel()
        self.count.setObjectName("faint")
        policy = QtWidgets.QSizePolicy.Policy  # numbers grow, and the picture is not to move
        self.count.setSizePolicy(policy.Ignored, policy.Preferred)
        self.pace = QtWidgets.QComboBox()
        for text, speed in _SPEEDS:
            self.pace.addItem(text, speed)
        self.pace.setCurrentIndex(2)
        self.pace.setToolTip(say("Speed"))
        self.play = QtWidgets.QPushButton(say("Replay"))
        self.edit = QtWidgets.QPushButton(say("Edit"))
        self.edit.setToolTip(say("Edit the stroke that is chosen; also by the right button"))
        self.edit.setMenu(self._menu_for(self.edit, self._row_to_edit))
        export = QtWidgets.QPushButton(say("Export…"))
        self.play.clicked.connect(self._play)
        export.clicked.connect(self.exported)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 8)
        layout.addWidget(self.list, 1)
        layout.addWidget(self.seals)
        layout.addWidget(self.slider)
        layout.addWidget(self.count)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.edit)
        row.addStretch(1)
        row.addWidget(self.pace)
        row.addWidget(self.play)
        row.addWidget(export)
        layout.addLayout(row)
        self._player = QtCore.QTimer(self)
        self._player.setSingleShot(True)
        self._player.timeout.connect(self._step)

    # -- editing ----------------------------------------------------------------------------

    def _menu_for(self, parent: QtWidgets.QWidget, row: Callable[[], int]) -> QtWidgets.QMenu:
        """Make a menu of the edits of a row's stroke."""
        menu = QtWidgets.QMenu(parent)
        menu.aboutToShow.connect(lambda: self._mark_row(row()))
        for name, text in _STROKE_EDIT_MENU:
            if name in ("drag", "delete"):
                menu.addSeparator()
            action = menu.addAction(say(text))
            action.setObjectName(name)
            action.triggered.connect(lambda _=False, name=name: self._edit(name, row()))
        return menu

    def _show_menu(self, position: QtCore.QPoint) -> None:
        item = self.list.itemAt(position)
        if item is None:
            return
        row = self.list.row(item)
        menu = self._menu_for(self.list, lambda: row)
        menu.setAttribute(QtCore.Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(self.list.viewport().mapToGlobal(position))

    def _show_seal_menu(self, position: QtCore.QPoint) -> None:
        item = self.seals.itemAt(position)
        if item is None:
            return
        index = self.seals.row(item)
        menu = QtWidgets.QMenu(self.seals)
        for name, text in _SEAL_EDIT_MENU:
            action = menu.addAction(say(text))
            action.setObjectName(name)
            action.triggered.connect(lambda _=False, name=name: self.seal_edited.emit(name, index))
        menu.setAttribute(QtCore.Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(self.seals.viewport().mapToGlobal(position))

    def show_seals(self, count: int) -> None:
        """Show so many seals, or none of them."""
        if count == self.seals.count():
            return
        self.seals.clear()
        self.seals.addItems([say("Seal {n}", n=k + 1) for k in range(count)])
        rows = min(count, _MOST_SEAL_ROWS)
        self.seals.setFixedHeight(6 + rows * max(self.seals.sizeHintForRow(0), 1))
        self.seals.setVisible(count > 0)

    def _edit(self, what: str, row: int) -> None:
        """Ask for an edit of the stroke of a row."""
        self.stop()
        if 0 <= row < len(self._strokes):
            self.edited.emit(what, row)
        else:
            self.reported.emit(say("There is no stroke to edit"))

    def _row_to_edit(self) -> int:
        """Return the row of the marked stroke, or else of the one that is shown last."""
        return self._marked[0] if self._marked else self.list.currentRow()

    def _mark_row(self, row: int) -> None:
        """Emit a row's stroke, to be marked in the picture, if there is one."""
        if 0 <= row < len(self._strokes):
            self.chosen.emit(row)

    def mark(self, rows: tuple[int, ...] | None) -> None:
        """Show that these strokes are marked in the picture, or none."""
        self._marked = rows or ()
        self._show_marked()

    def _show_marked(self) -> None:
        for k in range(self.list.count()):
            item = self.list.item(k)
            font = item.font()
            if font.bold() != (k in self._marked):
                font.setBold(k in self._marked)
                item.setFont(font)

    # -- showing ----------------------------------------------------------------------------

    def open(self, painting: Snapshot) -> None:
        """Show the strokes of another painting."""
        self.stop()
        self._wanted = None
        self._shown = (-1, -1)
        self.show_strokes(painting.strokes, painting.undone_strokes, painting.fewest_strokes)
        self.show_seals(painting.n_seals)

    def follow(self, frame: PaintingFrame) -> None:
        """Show a frame's painting."""
        painting = frame.painting
        if len(painting.strokes) == self._wanted or not frame.queue_length:
            self._wanted = None
        self.show_strokes(painting.strokes, painting.undone_strokes, painting.fewest_strokes)
        self.show_seals(painting.n_seals)

    def show_strokes(self, strokes: Sequence[Any], undone: Sequence[Any], earliest: int) -> None:
        """Show the strokes that are there; those that were undone come after them, fainter.

        Parameters
        ----------
        strokes, undone : sequence of Stroke
        earliest : int
            So many always stay.
        """
        n_done, every = len(strokes), [*strokes, *undone]
        if every != self._strokes or (n_done, earliest) != self._shown:
            self._shown = (n_done, earliest)
            self._strokes = every
            self._fill(n_done)
            seconds = sum(stroke.duration_s for stroke in strokes)
            self.count.setText(say("Strokes: {n}, {seconds:.1f} s", n=n_done, seconds=seconds))
        if self._wanted is None:
            self._choose(n_done, earliest)
        if self._is_playing and self._wanted is None and not self._player.isActive():
            self._wait(n_done)

    def _fill(self, n_done: int) -> None:
        with QtCore.QSignalBlocker(self.list):
            self.list.clear()
            for k, stroke in enumerate(self._strokes):
                ink = " + ".join(ink_label(name) for name in stroke.ink)
                brush = say_brush(plain_name(stroke.brush))
                ink = say("eraser") if stroke.tags.get(ERASES) else ink
                text = f"{k + 1}   {brush}, {ink}   {stroke.duration_s:.2f} s"
                item = QtWidgets.QListWidgetItem(_dish_icon(stroke.ink, self._theme), text)
                if k >= n_done:
                    item.setForeground(QtGui.QColor(self._theme.faint))
                    item.setToolTip(say("undone"))
                self.list.addItem(item)
            self.list.setCurrentRow(n_done - 1)
            if n_done:
                self.list.scrollToItem(self.list.item(n_done - 1))
            self._show_marked()

    def _choose(self, n_done: int, earliest: int) -> None:
        """Set row and slider to the painting's state."""
        if self.list.currentRow() != n_done - 1:
            with QtCore.QSignalBlocker(self.list):
                self.list.setCurrentRow(n_done - 1)
        with QtCore.QSignalBlocker(self.slider):
            self.slider.setRange(earliest, len(self._strokes))
            self.slider.setValue(n_done)

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        self._shown = (-1, -1)

    # -- list and slider --------------------------------------------------------------------

    def _choose_row(self, row: int) -> None:
        if row >= 0:
            self._go(row + 1)
            self.chosen.emit(row)

    def _slide(self, upto: int) -> None:
        self.chosen.emit(None)
        self._go(upto)

    def _go(self, upto: int) -> None:
        """Ask for the painting after so many strokes, once."""
        if upto in (self._wanted, self._shown[0] if self._wanted is None else None):
            return
        self.stop()
        self._ask(upto)

    def _ask(self, upto: int) -> None:
        self._wanted = upto
        self.asked.emit(upto, self._is_playing)

    def refuse(self) -> None:
        """Go back to the painting's state, as the one asked for does not come."""
        self.stop()
        self._wanted = None
        self._choose(*self._shown)

    # -- replaying --------------------------------------------------------------------------

    def speed(self) -> float | None:
        """Return the speed of replays, relative to their own time; None: as fast as it goes."""
        result: float | None = self.pace.currentData()
        return result

    @property
    def is_playing(self) -> bool:
        """True if strokes are shown one after the other."""
        return self._is_playing

    def _play(self) -> None:
        """Show the strokes one after the other, from the first, each for as long as it took."""
        if self._is_playing:
            self.stop()
            return
        if self._shown[1] >= len(self._strokes):
            self.reported.emit(say("There is no stroke to replay"))
            return
        self._is_playing = True
        self.chosen.emit(None)
        self.play.setText(say("Stop"))
        self._last: int | None = None
        if self._shown[0] == self._shown[1]:
            self._wait(self._shown[0])
        else:
            self._ask(self._shown[1])

    def stop(self) -> None:
        """Stay at the stroke that is shown."""
        self._is_playing = False
        self._player.stop()
        self.play.setText(say("Replay"))

    def give_way(self) -> None:
        """Stop for a stroke by hand, which the next that is shown would break off."""
        if self._is_playing:
            self.stop()
            self.reported.emit(say("The replay was stopped by your stroke"))

    def _wait(self, n_done: int) -> None:
        """Wait as long as the next stroke took."""
        expected = self._last is None or n_done == self._last + 1
        if n_done >= len(self._strokes) or not expected:
            self.stop()
            return
        self._last = n_done
        seconds = self._strokes[n_done].duration_s / self.speed() if self.speed() else 0.0
        self._player.start(max(_LEAST_MS, round(1e3 * seconds)))

    def _step(self) -> None:
        self._ask(0 if self._last is None else self._last + 1)


def _dish_icon(parts: dict[str, float], theme: Theme) -> QtGui.QIcon:
    pixels = QtGui.QPixmap(2 * _ICON, 2 * _ICON)
    pixels.fill(QtCore.Qt.GlobalColor.transparent)
    painter = QtGui.QPainter(pixels)
    painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
    paint_dish(painter, QtCore.QRectF(2, 2, 2 * _ICON - 4, 2 * _ICON - 4), parts, theme)
    painter.end()
    return plain_icon(pixels)

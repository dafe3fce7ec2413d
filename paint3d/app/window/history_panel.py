"""The strokes of this sitting: a list, a slider to go back and forth in, their times."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.frame import Frame
from paint3d.app.window.brush_panel import plain_icon, plain_name
from paint3d.app.window.ink_panel import ink_label, paint_dish
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say

__all__ = ["HistoryPanel"]

_ICON = 22
_SPEEDS = (("¼ x", 0.25), ("½ x", 0.5), ("1 x", 1.0), ("4 x", 4.0), ("16 x", 16.0), ("max", None))
_LEAST_MS = 40  # a stroke is shown at least so long


class HistoryPanel(QtWidgets.QWidget):
    """What was painted, stroke by stroke.

    Signals
    -------
    asked : (str, ...)
        A method of the document, and its arguments.
    exported : ()
        The strokes are to be saved as a recording.
    """

    asked = QtCore.Signal(str, object, object)
    exported = QtCore.Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._shown: tuple[int, int] = (-1, -1)
        self._strokes: list = []
        self.list = QtWidgets.QListWidget()
        self.list.setObjectName("strokes")
        self.list.setIconSize(QtCore.QSize(_ICON, _ICON))
        self.list.itemClicked.connect(lambda item: self._go(self.list.row(item) + 1))
        self.slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.slider.setPageStep(1)
        self.slider.valueChanged.connect(self._go)
        self.told = QtWidgets.QLabel()
        self.told.setObjectName("faint")
        self.pace = QtWidgets.QComboBox()
        for text, speed in _SPEEDS:
            self.pace.addItem(text, speed)
        self.pace.setCurrentIndex(2)
        self.pace.setToolTip(say("history.speed"))
        play = QtWidgets.QPushButton(say("action.replay"))
        export = QtWidgets.QPushButton(say("Export…"))
        play.clicked.connect(self._play)
        export.clicked.connect(self.exported)
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 8)
        layout.addWidget(self.list, 1)
        layout.addWidget(self.slider)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.told, 1)
        row.addWidget(self.pace)
        row.addWidget(play)
        row.addWidget(export)
        layout.addLayout(row)
        self._player = QtCore.QTimer(self)
        self._player.setSingleShot(True)
        self._player.timeout.connect(self._step)

    # -- showing ----------------------------------------------------------------------------

    def follow(self, document: Document, frame: Frame) -> None:
        """Show what a frame says."""
        strokes = list(document.strokes)
        if len(strokes) == frame.n_strokes:  # else they are about to change again
            self.show_strokes(strokes, document.oldest_stroke, can_redo=frame.can_redo)

    def show_strokes(self, strokes: Sequence, oldest: int, *, can_redo: bool) -> None:
        """Show the strokes that are there; those that were undone stay, fainter.

        Parameters
        ----------
        strokes : sequence of Stroke
        oldest : int
            How many are of earlier sittings, and stay.
        can_redo : bool
            Whether what was undone can be done again.
        """
        there = len(strokes)
        known = self._strokes[:there] == list(strokes)
        kept = self._strokes[there:] if can_redo and known else []
        if known and (there, len(kept)) == self._shown:
            return
        self._shown = (there, len(kept))
        self._strokes = [*strokes, *kept]
        self._fill(there)
        with QtCore.QSignalBlocker(self.slider):
            self.slider.setRange(oldest, len(self._strokes))
            self.slider.setValue(there)
        seconds = sum(stroke.duration_s for stroke in strokes)
        self.told.setText(say("Strokes: {n}, {seconds:.1f} s", n=there, seconds=seconds))

    def _fill(self, there: int) -> None:
        self.list.clear()
        for k, stroke in enumerate(self._strokes):
            ink = " + ".join(ink_label(name) for name in stroke.ink)
            text = f"{k + 1}   {say(plain_name(stroke.brush))}, {ink}   {stroke.duration_s:.2f} s"
            item = QtWidgets.QListWidgetItem(_dish_icon(stroke.ink, self._theme), text)
            if k >= there:
                item.setForeground(QtGui.QColor(self._theme.faint))
                item.setToolTip(say("undone"))
            self.list.addItem(item)
        if there:
            self.list.setCurrentRow(there - 1)
            self.list.scrollToItem(self.list.item(there - 1))

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = theme
        self._shown = (-1, -1)

    # -- being told -------------------------------------------------------------------------

    def _go(self, upto: int) -> None:
        self.asked.emit("replay_history", int(upto), None)

    def speed(self) -> float | None:
        """How fast things are replayed, of their own time; None for as fast as it goes."""
        return self.pace.currentData()

    def _play(self) -> None:
        """Show the strokes one after the other, from the first, each for as long as it took."""
        self.slider.setValue(self.slider.minimum())
        self._wait()

    def _wait(self) -> None:
        """Wait as long as the next stroke took."""
        at = self.slider.value()
        if at >= self.slider.maximum():
            return
        seconds = self._strokes[at].duration_s / self.speed() if self.speed() else 0.0
        self._player.start(max(_LEAST_MS, round(1e3 * seconds)))

    def _step(self) -> None:
        self.slider.setValue(self.slider.value() + 1)
        self._wait()


def _dish_icon(parts: dict[str, float], theme: Theme) -> QtGui.QIcon:
    pixels = QtGui.QPixmap(2 * _ICON, 2 * _ICON)
    pixels.fill(QtCore.Qt.GlobalColor.transparent)
    painter = QtGui.QPainter(pixels)
    painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
    paint_dish(painter, QtCore.QRectF(2, 2, 2 * _ICON - 4, 2 * _ICON - 4), parts, theme)
    painter.end()
    return plain_icon(pixels)

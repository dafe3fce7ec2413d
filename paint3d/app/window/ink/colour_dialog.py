"""Any colour, and the mixture of the inks there are that comes nearest to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.ink.ink_panel import ink_label
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_error
from paint3d.colour.nearest_mixture import Nearest, nearest_mixture
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import AnyArray

__all__ = ["ColourDialog"]

_LOOK_MS = 30
_PATCH = QtCore.QSize(86, 44)
_GOOD, _FAIR = 1.0, 3.0  # CIEDE2000: hardly seen; seen side by side


class _Picker(QtWidgets.QColorDialog):
    """Qt's dialog as a part of another one."""

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Leave Escape to the dialog around it: Qt's own would close the picker alone."""
        if event.matches(QtGui.QKeySequence.StandardKey.Cancel):
            event.ignore()
        else:
            super().keyPressEvent(event)


class ColourDialog(QtWidgets.QDialog):
    """Choose a colour; painting goes on beside it.

    Parameters
    ----------
    parent : QWidget
    theme : Theme
    ground : (31,)
        Reflectance of what is painted on.
    pigments : sequence of Pigment
        That can be mixed.

    Signals
    -------
    mixed : Nearest
        To be put into the mixing dish.
    dipped : Nearest
        To dip the brush in.
    """

    mixed = QtCore.Signal(object)
    dipped = QtCore.Signal(object)

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        theme: Theme,
        ground: AnyArray,
        pigments: Sequence[Pigment],
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Colour"))
        self._theme, self._ground, self._pigments = theme, ground, tuple(pigments)
        self.nearest: Nearest | None = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="paint3d-colour")
        self._next: QtGui.QColor | None = None
        self._coming: Future[Nearest] | None = None
        self.picker = _Picker()
        option = QtWidgets.QColorDialog.ColorDialogOption
        self.picker.setOptions(option.NoButtons | option.DontUseNativeDialog)
        self.picker.setWindowFlags(QtCore.Qt.WindowType.Widget)
        self.picker.setCurrentColor(QtGui.QColor("#b5432f"))
        column = QtWidgets.QVBoxLayout(self)
        column.addWidget(self.picker)
        column.addLayout(self._make_found())
        self._timer = QtCore.QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)
        self.picker.currentColorChanged.connect(self.ask)
        self.ask(self.picker.currentColor())

    def _make_found(self) -> QtWidgets.QGridLayout:
        grid = QtWidgets.QGridLayout()
        self.wanted, self.coat = QtWidgets.QLabel(), QtWidgets.QLabel()
        self.told = QtWidgets.QLabel()
        self.told.setWordWrap(True)
        self.told.setMinimumWidth(300)
        for column, (text, patch) in enumerate(
            ((say("Asked for"), self.wanted), (say("A coat of it"), self.coat))
        ):
            label = QtWidgets.QLabel(text)
            label.setObjectName("faint")
            grid.addWidget(label, 0, column)
            patch.setFixedSize(_PATCH)
            grid.addWidget(patch, 1, column)
        grid.addWidget(self.told, 0, 2, 2, 3)
        grid.setColumnStretch(2, 1)
        self.mix, self.dip = self._button("Into the mixing dish"), self._button("Dip the brush")
        leave = self._button("Close")
        for column, button in enumerate((self.mix, self.dip, leave)):
            grid.addWidget(button, 2, 2 + column)
        self.mix.clicked.connect(lambda: self._give(self.mixed.emit))
        self.dip.clicked.connect(lambda: self._give(self.dipped.emit))
        leave.clicked.connect(self.close)
        return grid

    def _button(self, text: str) -> QtWidgets.QPushButton:
        button = QtWidgets.QPushButton(say(text))
        button.setAutoDefault(False)
        return button

    @property
    def is_busy(self) -> bool:
        """Whether the mixture that is shown is not yet that of the colour."""
        return self._next is not None or self._coming is not None

    def ask(self, colour: QtGui.QColor) -> None:
        """Look for the mixture nearest to a colour."""
        self._next = QtGui.QColor(colour)
        self._paint(self.wanted, self._next)
        self._enable(False)
        self._look()
        self._timer.start()

    def _enable(self, on: bool) -> None:
        self.mix.setEnabled(on)
        self.dip.setEnabled(on)

    def _look(self) -> None:
        if self._coming is not None:
            if not self._coming.done():
                return
            coming, self._coming = self._coming, None
            self._show(coming)
        if self._next is not None:
            colour, self._next = self._next, None
            codes = colour.red(), colour.green(), colour.blue()
            self._coming = self._worker.submit(nearest_mixture, codes, self._ground, self._pigments)
        else:
            self._timer.stop()

    def _show(self, coming: Future[Nearest]) -> None:
        error = coming.exception()
        if error is not None:
            self.told.setText(say_error(error))
            return
        found = self.nearest = coming.result()
        self._paint(self.coat, QtGui.QColor(*found.srgb))
        parts = ", ".join(
            f"{ink_label(ink)} {100 * share:.3g} %" for ink, share in found.parts.items()
        )
        how = (
            "hardly to be seen" if found.difference < _GOOD
            else "seen side by side" if found.difference < _FAIR
            else "no mixture of these inks comes nearer"
        )  # fmt: skip
        self.told.setText(f"{parts}\nΔE00 {found.difference:.1f}, {say(how)}")
        self._enable(self._next is None)

    def _paint(self, label: QtWidgets.QLabel, colour: QtGui.QColor) -> None:
        pixmap = QtGui.QPixmap(_PATCH)
        pixmap.fill(QtCore.Qt.GlobalColor.transparent)
        painter = QtGui.QPainter(pixmap)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        painter.setPen(QtGui.QPen(QtGui.QColor(self._theme.line), 1))
        painter.setBrush(colour)
        painter.drawRoundedRect(QtCore.QRectF(pixmap.rect()).adjusted(1, 1, -1, -1), 6, 6)
        painter.end()
        label.setPixmap(pixmap)

    def _give(self, tell: Callable[[Nearest], None]) -> None:
        if self.nearest is not None:
            tell(self.nearest)

    def done(self, result: int) -> None:
        """Look for nothing more once it is closed."""
        self._timer.stop()
        self._next = None
        self._worker.shutdown(wait=False, cancel_futures=True)
        super().done(result)

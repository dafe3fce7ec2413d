"""The user's own inks: any colour as a mixture, tables of pigments, pick-up."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.persistence.own_pigments import fingerprint_of, own_pigments
from paint3d.app.window.files.file_dialogs import ask_file
from paint3d.app.window.ink.ink_panel import ink_label
from paint3d.app.window.panels import Panels
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.calligraphy.dips import LEAST_LOAD
from paint3d.colour.nearest_mixture import Nearest, nearest_mixture
from paint3d.colour.pigments import Pigment, load_pigments_csv
from paint3d.core.arrays import AnyArray
from paint3d.errors import Paint3DError

__all__ = [
    "ColourDialog",
    "InkMaking",
]

# ---- The dialog ----------------------------------------------------------------------------------


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
        Reflectance of the material painted on.
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
        column.addLayout(self._make_result())
        self._timer = QtCore.QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)
        self.picker.currentColorChanged.connect(self.ask)
        self.ask(self.picker.currentColor())

    def _make_result(self) -> QtWidgets.QGridLayout:
        grid = QtWidgets.QGridLayout()
        self.wanted, self.coat = QtWidgets.QLabel(), QtWidgets.QLabel()
        self.message_label = QtWidgets.QLabel()
        self.message_label.setWordWrap(True)
        self.message_label.setMinimumWidth(300)
        for column, (text, patch) in enumerate(
            ((say("Asked for"), self.wanted), (say("A coat of it"), self.coat))
        ):
            label = QtWidgets.QLabel(text)
            label.setObjectName("faint")
            grid.addWidget(label, 0, column)
            patch.setFixedSize(_PATCH)
            grid.addWidget(patch, 1, column)
        grid.addWidget(self.message_label, 0, 2, 2, 3)
        grid.setColumnStretch(2, 1)
        self.mix, self.dip = (
            self._button(say("Into the mixing dish")),
            self._button(say("Dip the brush")),
        )
        leave = self._button(say("Close"))
        for column, button in enumerate((self.mix, self.dip, leave)):
            grid.addWidget(button, 2, 2 + column)
        self.mix.clicked.connect(lambda: self._give(self.mixed.emit))
        self.dip.clicked.connect(lambda: self._give(self.dipped.emit))
        leave.clicked.connect(self.close)
        return grid

    def _button(self, text: str) -> QtWidgets.QPushButton:
        button = QtWidgets.QPushButton(text)
        button.setAutoDefault(False)
        return button

    @property
    def is_busy(self) -> bool:
        """True if the mixture that is shown is not yet that of the colour."""
        return self._next is not None or self._coming is not None

    def ask(self, colour: QtGui.QColor) -> None:
        """Find the mixture nearest to a colour."""
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
            self.message_label.setText(say_error(error))
            return
        nearest = self.nearest = coming.result()
        self._paint(self.coat, QtGui.QColor(*nearest.srgb))
        parts = ", ".join(
            f"{ink_label(ink)} {100 * fraction:.3g} %" for ink, fraction in nearest.parts.items()
        )
        how = (
            say("hardly to be seen") if nearest.difference < _GOOD
            else say("seen side by side") if nearest.difference < _FAIR
            else say("no mixture of these inks comes nearer")
        )  # fmt: skip
        self.message_label.setText(f"{parts}\nΔE00 {nearest.difference:.1f}, {how}")
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

    def _give(self, emit: Callable[[Nearest], None]) -> None:
        if self.nearest is not None:
            emit(self.nearest)

    def done(self, result: int) -> None:
        """Stop the search when it is closed."""
        self._timer.stop()
        self._next = None
        self._worker.shutdown(wait=False, cancel_futures=True)
        super().done(result)


# ---- The work ------------------------------------------------------------------------------------


class InkMaking:
    """Commands for the user's own inks: mixtures, tables; ``do_<action>`` for each.

    Attributes
    ----------
    dialog : ColourDialog or None
        That was opened last.
    """

    def __init__(self, workspace: Workspace, panels: Panels) -> None:
        self._workspace, self._panels = workspace, panels
        self.dialog: ColourDialog | None = None
        workspace.opened.connect(lambda _: self.close_down())  # mixed for another ground
        panels.inks.colour_asked.connect(self.do_choose_colour)
        panels.inks.table_asked.connect(self.do_open_pigments)
        panels.inks.pickup_chosen.connect(lambda fraction: workspace.post("set_pickup", fraction))
        panels.inks.amount_chosen.connect(self._choose_amount)
        panels.inks.by_itself_chosen.connect(
            lambda on: workspace.update_settings(dips_by_itself=on)
        )
        panels.inks.show_by_itself(workspace.settings.dips_by_itself)
        panels.inks.mixtures_changed.connect(
            lambda mixtures: workspace.update_settings(mixtures=mixtures)
        )
        workspace.hand.began.connect(self._dip_by_itself)
        self._load_tables()
        panels.inks.show_last(workspace.settings.mixtures)

    def _choose_amount(self, words: Mapping[str, float] | None) -> None:
        self._workspace.amount = words

    def _dip_by_itself(self) -> None:
        """Dip the brush before a stroke if little of the last dip is left and the setting is on.

        A rinsed brush stays so: it holds nothing at all, unlike one that ran dry.
        """
        workspace = self._workspace
        if not workspace.settings.dips_by_itself:
            return
        held = workspace.painting.held
        if 0.0 < held.fraction < LEAST_LOAD:
            workspace.dip()
            message = say(
                "Dipped automatically: {percent:.0f} % was left", percent=100 * held.fraction
            )
            workspace.tell(message)

    def _load_tables(self) -> None:
        """Add the pigments of the tables that were opened before to the dishes."""
        tables = self._workspace.settings.pigment_tables
        if not tables:
            return
        own = own_pigments(tables)
        self._panels.inks.add_pigments(own.pigments.values(), "settings")
        if own.tables != tables:
            self._workspace.update_settings(pigment_tables=own.tables)
        if own.problems:
            self._workspace.tell_first("; ".join(map(say_error, own.problems)))

    def do_choose_colour(self) -> None:
        """Ask for a colour, and mix the nearest."""
        self.close_down()
        workspace, inks = self._workspace, self._panels.inks
        ground = workspace.painting.material.reflectance
        dialog = self.dialog = ColourDialog(
            workspace.window, workspace.theme, ground, tuple(inks.dishes.pigments.values())
        )
        dialog.mixed.connect(self._mix)
        dialog.dipped.connect(self._dip)
        dialog.show()

    def mix_colour(self, colour: QtGui.QColor) -> None:
        """Mix the nearest to a colour."""
        self.do_choose_colour()
        assert self.dialog is not None, "it was opened"
        self.dialog.picker.setCurrentColor(colour)

    def close_down(self) -> None:
        """Close the dialog, if it is open."""
        if self.dialog is not None:
            self.dialog.close()
            self.dialog.deleteLater()
            self.dialog = None

    def _mix(self, nearest: Nearest) -> None:
        self._panels.inks.show_mixture(nearest.parts)

    def _dip(self, nearest: Nearest) -> None:
        self._mix(nearest)
        self._panels.inks.dip_mixture()

    def do_open_pigments(self) -> None:
        """Ask for a table of pigments, and add them to the dishes."""
        path = ask_file(
            self._workspace.window,
            say("Open a table of pigments…").rstrip("…"),
            f"{say('Tables of pigments')} (*.csv);;{say('All files')} (*)",
        )
        if path:
            self.open_table(path)

    def open_table(self, path: str | Path) -> bool:
        """Add a table's pigments to the dishes; show a fault; return whether that succeeded."""
        tables = self._workspace.settings.pigment_tables
        try:
            self._panels.inks.add_pigments(load_pigments_csv(path).values(), str(path))
            table = {os.path.abspath(path): fingerprint_of(path)}
            self._workspace.update_settings(pigment_tables={**tables, **table})
        except Paint3DError as error:
            self._workspace.tell(say_error(error), state="bad", stays=True)
            return False
        return True

    def do_forget_pigments(self) -> None:
        """Remove all of the user's own pigments; their tables are read no more."""
        self.close_down()
        self._panels.inks.put_away_own()
        self._workspace.update_settings(pigment_tables={})
        self._workspace.tell(say("Your own pigments are off the list; their files stay"))

"""A bar in the line of status while a recording is replayed: how far, how fast, pause, stop."""

from __future__ import annotations

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.commands import keys_of
from paint3d.app.window.jobs.player import Player
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["SPEEDS", "ReplayBar"]

SPEEDS = (
    ("¼ x", 0.25), ("½ x", 0.5), ("1 x", 1.0), ("2 x", 2.0), ("4 x", 4.0), ("16 x", 16.0),
    ("max", None),
)  # fmt: skip
_STEPS = 1000
_WIDTH = 150  # pixels


class ReplayBar(QtWidgets.QWidget):
    """For one window; seen while something is played.

    Parameters
    ----------
    workspace : Workspace
    player : Player

    Attributes
    ----------
    bar : QProgressBar
    speed : QComboBox
        How many times the hand's own; it may be changed while it is played.
    hold : QPushButton
        Pauses while it is pressed down.
    button : QPushButton
        Stops.
    """

    def __init__(self, workspace: Workspace, player: Player) -> None:
        super().__init__()
        self.bar = QtWidgets.QProgressBar()
        self.bar.setRange(0, _STEPS)
        self.bar.setTextVisible(False)
        self.bar.setFixedWidth(_WIDTH)
        self._player = player
        self.speed = QtWidgets.QComboBox()
        for text, speed in SPEEDS:
            self.speed.addItem(text, speed)
        self.speed.setToolTip(say("history.speed"))
        self.speed.activated.connect(lambda k: player.set_speed(self.speed.itemData(k)))
        self.hold = QtWidgets.QPushButton(say("Pause"))
        self.hold.setObjectName("low")
        self.hold.setCheckable(True)
        self.hold.toggled.connect(player.pause)
        self.button = QtWidgets.QPushButton(say("button.stop"))
        self.button.setObjectName("low")
        self.button.setToolTip(f"{say('button.stop')}  ({keys_of('cancel_stroke')[0]})")
        self.button.clicked.connect(player.do_stop)
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for part in (self.bar, self.speed, self.hold, self.button):
            row.addWidget(part)
        workspace.window.statusBar().addPermanentWidget(self)
        self.hide()
        player.moved.connect(self._show)

    def _show(self, share: float) -> None:
        if self.isHidden() and share >= 0.0:  # it begins
            self.speed.setCurrentIndex(self.speed.findData(self._player.speed))
            with QtCore.QSignalBlocker(self.hold):
                self.hold.setChecked(False)
        self.setVisible(share >= 0.0)
        self.bar.setValue(round(_STEPS * min(max(share, 0.0), 1.0)))

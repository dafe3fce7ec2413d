"""A bar in the line of status while a recording is replayed, and a button that stops it."""

from __future__ import annotations

from PySide6 import QtWidgets

from paint3d.app.window.commands import keys_of
from paint3d.app.window.jobs.player import Player
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["ReplayBar"]

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
    button : QPushButton
    """

    def __init__(self, workspace: Workspace, player: Player) -> None:
        super().__init__()
        self.bar = QtWidgets.QProgressBar()
        self.bar.setRange(0, _STEPS)
        self.bar.setTextVisible(False)
        self.bar.setFixedWidth(_WIDTH)
        self.button = QtWidgets.QPushButton(say("button.stop"))
        self.button.setObjectName("low")
        self.button.setToolTip(f"{say('button.stop')}  ({keys_of('cancel_stroke')[0]})")
        self.button.clicked.connect(player.do_stop)
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.bar)
        row.addWidget(self.button)
        workspace.window.statusBar().addPermanentWidget(self)
        self.hide()
        player.moved.connect(self._show)

    def _show(self, share: float) -> None:
        self.setVisible(share >= 0.0)
        self.bar.setValue(round(_STEPS * min(max(share, 0.0), 1.0)))

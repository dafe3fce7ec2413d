"""The status line: what was done or refused, and how the painting keeps up."""

from __future__ import annotations

import time

from PySide6 import QtWidgets

from paint3d.app.model.frame import Frame
from paint3d.app.window.keeping_up import keeping_up
from paint3d.app.window.theme import STATES, Theme
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["StatusLine"]

_EVERY_S = 0.25  # how the painting keeps up: oftener it cannot be read


class StatusLine:
    """At the foot of one window.

    Attributes
    ----------
    told, state : QLabel
        What was said last, and how the painting keeps up.
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.told = QtWidgets.QLabel()  # as wide as there is room for, however long the text
        policy = QtWidgets.QSizePolicy.Policy
        self.told.setSizePolicy(policy.Ignored, policy.Preferred)
        self.state = QtWidgets.QLabel()
        self.state.setObjectName("state")
        self._told_state = self._state = "off"
        self._stays = False
        self._next = 0.0
        bar = workspace.window.statusBar()
        bar.addWidget(self.told, 1)
        bar.addPermanentWidget(self.state)
        bar.setSizeGripEnabled(False)
        bar.setContentsMargins(8, 0, 12, 0)
        workspace.said.connect(self._tell)
        workspace.theme_changed.connect(self._set_theme)
        self._invite()

    def _tell(self, text: str, state: str, stays: bool) -> None:
        mark = "" if state == "off" else f"{STATES[state]}  "
        self._told_state, self._stays = state, stays
        self.told.setText(mark + text)
        self.told.setToolTip(text)
        _dress(self.told, state, self._workspace.theme)

    def _invite(self) -> None:
        self._tell(say("hint.turn"), "off", False)

    def forget_good(self) -> None:
        """Leave off what was good news; what went wrong is still to be read."""
        if self._told_state != "bad":
            self._invite()

    def forget_passing(self) -> None:
        """Leave off what was done or refused: something else is being painted."""
        if not self._stays:
            self._invite()

    def show(self, frame: Frame, picture_s: float | None) -> None:
        """Say how the painting keeps up, and how many pictures a second there are.

        Parameters
        ----------
        frame : Frame
        picture_s : float, optional
            From one picture to the next, s; None before the first.
        """
        (state, text), now = keeping_up(frame), time.perf_counter()
        if state == self._state and now < self._next:
            return
        _dress(self.state, state, self._workspace.theme)
        self._state, self._next = state, now + _EVERY_S
        seen = ""
        if picture_s is not None:
            seen = "   ·   " + say("{fps:.0f} pictures/s", fps=1.0 / picture_s)
        self.state.setText(f"{STATES[state]} {say('Painting')} {text}{seen}")

    def _set_theme(self, theme: Theme) -> None:
        for label, state in ((self.told, self._told_state), (self.state, self._state)):
            _dress(label, state, theme)


def _dress(label: QtWidgets.QLabel, state: str, theme: Theme) -> None:
    """Give a label the colour of a state, if it has another: the whole window is laid out then."""
    sheet = f"color: {theme.state_colour(state)}"
    if label.styleSheet() != sheet:
        label.setStyleSheet(sheet)

"""The status line: what was done or refused, and how the painting keeps up."""

from __future__ import annotations

import time

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.commands import COMMANDS
from paint3d.app.model.frame import PaintingFrame
from paint3d.app.window.playing.player import Player
from paint3d.app.window.theme import STATES, Theme
from paint3d.app.window.wording import say, say_left
from paint3d.app.window.workspace import Workspace

__all__ = ["SPEEDS", "ReplayBar", "StatusLine", "keeping_up"]

# ---- Keeping up ----------------------------------------------------------------------------------
# Whether the painting keeps up with the hand, as a state and a text.


_SLOW_S = 0.4  # what was painted last had waited so long: seen, and not over with the next frame


def keeping_up(frame: PaintingFrame | None) -> tuple[str, str]:
    """Return one of `theme.STATES` and a text; before the first frame it keeps up."""
    lag_s = 0.0 if frame is None else frame.lag_s
    if frame is None or lag_s <= _SLOW_S:
        return "good", say("keeps up, {ms:.1f} ms", ms=1e3 * lag_s)
    if frame.queue_length > 0:
        return "slow", say("is catching up with your strokes, {s:.1f} s", s=lag_s)
    return "good", say("has caught up")


# ---- The status line -----------------------------------------------------------------------------


_EVERY_S = 0.25  # how the painting keeps up: oftener it cannot be read


class _OneLine(QtWidgets.QLabel):
    """A line as wide as its place allows; a longer text ends in an ellipsis."""

    def __init__(self) -> None:
        super().__init__()
        policy = QtWidgets.QSizePolicy.Policy
        self.setSizePolicy(policy.Ignored, policy.Preferred)

    @property
    def shown(self) -> str:
        """The text that is seen."""
        end = QtCore.Qt.TextElideMode.ElideRight
        return self.fontMetrics().elidedText(self.text(), end, self.contentsRect().width())

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw what fits."""
        painter = QtWidgets.QStylePainter(self)
        painter.drawItemText(
            self.contentsRect(), self.alignment(), self.palette(), self.isEnabled(), self.shown,
            self.foregroundRole(),
        )  # fmt: skip


class StatusLine:
    """The status line of one window.

    Attributes
    ----------
    message_label, state : QLabel
        The last message, and whether the painting keeps up.
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.message_label = _OneLine()
        self.state = QtWidgets.QLabel()
        self.state.setObjectName("state")
        self._message_state = self._state = "off"
        self._stays = False
        self._next = 0.0
        bar = workspace.window.statusBar()
        bar.addWidget(self.message_label, 1)
        bar.addPermanentWidget(self.state)
        bar.setSizeGripEnabled(False)
        bar.setContentsMargins(8, 0, 12, 0)
        workspace.said.connect(self._tell)
        workspace.theme_changed.connect(self._set_theme)
        self._invite()

    def _tell(self, text: str, state: str, stays: bool) -> None:
        mark = "" if state == "off" else f"{STATES[state]}  "
        self._message_state, self._stays = state, stays
        self.message_label.setText(mark + text)
        self.message_label.setToolTip(text)
        _set_colour(self.message_label, state, self._workspace.theme)

    def _invite(self) -> None:
        self._tell(
            say(
                "Paint with the left button, a pen or a finger; turn by a drag beside the object, "
                "with Space held, or by the grips"
            ),
            "off",
            False,
        )

    def forget_good(self) -> None:
        """Remove a message unless it is an error, which is still to be read."""
        if self._message_state != "bad":
            self._invite()

    def forget_passing(self) -> None:
        """Remove a message that does not stay: something else is being painted."""
        if not self._stays:
            self._invite()

    def show(self, frame: PaintingFrame, picture_s: float | None, *, plays: bool = False) -> None:
        """Show whether the painting keeps up, and the pictures a second.

        Parameters
        ----------
        frame : PaintingFrame
        picture_s : float, optional
            From one picture to the next, s; None before the first.
        plays : bool
            Whether a recording is played or a text written: no hand waits for the painting.
        """
        (state, text), now = keeping_up(frame), time.perf_counter()
        if plays:
            state, text = "good", say("goes on")
        if state == self._state and now < self._next:
            return
        _set_colour(self.state, state, self._workspace.theme)
        self._state, self._next = state, now + _EVERY_S
        seen = ""
        if picture_s is not None and not plays:
            seen = "   ·   " + say("{fps:.0f} pictures/s", fps=1.0 / picture_s)
        self.state.setText(f"{STATES[state]} {say('Painting')} {text}{seen}")

    def _set_theme(self, theme: Theme) -> None:
        for label, state in ((self.message_label, self._message_state), (self.state, self._state)):
            _set_colour(label, state, theme)


def _set_colour(label: QtWidgets.QLabel, state: str, theme: Theme) -> None:
    """Give a label the colour of a state, if it has another: that lays out the whole window."""
    sheet = f"color: {theme.state_colour(state)}"
    if label.styleSheet() != sheet:
        label.setStyleSheet(sheet)


# ---- Replay --------------------------------------------------------------------------------------
# A bar in the status line while a recording is replayed: progress, speed, pause, stop.


SPEEDS = (
    ("¼ x", 0.25), ("½ x", 0.5), ("1 x", 1.0), ("2 x", 2.0), ("4 x", 4.0), ("16 x", 16.0),
    ("max", None),
)  # fmt: skip
_STEPS = 1000
_WIDTH = 110  # pixels
_LONG_S = 40.0  # time left from which `still` is offered


class ReplayBar(QtWidgets.QWidget):
    """Bar that pauses, stops and speeds up a replay, with the time left; shown meanwhile.

    Parameters
    ----------
    workspace : Workspace
    player : Player

    Attributes
    ----------
    bar : QProgressBar
    speed : QComboBox
        A multiple of the hand's own; it may be changed during the replay.
    hold : QPushButton
        Pauses while it is pressed down.
    button : QPushButton
        Stops.
    left : QLabel
        The time left, once that is known.
    still : QPushButton
        Writes a text on without its ink spreading; shown where that takes long.
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
        self.speed.setToolTip(say("Speed"))
        self.speed.activated.connect(lambda k: player.set_speed(self.speed.itemData(k)))
        self.hold = QtWidgets.QPushButton(say("Pause"))
        self.hold.setObjectName("low")
        self.hold.setCheckable(True)
        self.hold.toggled.connect(player.pause)
        self.button = QtWidgets.QPushButton(say("Stop"))
        self.button.setObjectName("low")
        self.button.setToolTip(f"{say('Stop')}  ({COMMANDS['cancel_stroke'].keys[0]})")
        self.button.clicked.connect(player.do_stop)
        self.left = QtWidgets.QLabel()
        self.still = QtWidgets.QPushButton(say("Write without spreading"))
        self.still.setObjectName("low")
        self.still.setToolTip(say("The rest is written on, only faster: ink no longer spreads"))
        self.still.clicked.connect(player.stop_spreading)
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for part in (self.bar, self.left, self.still, self.speed, self.hold, self.button):
            row.addWidget(part)
        workspace.window.statusBar().addPermanentWidget(self)
        self.hide()
        player.moved.connect(self._show)

    def _show(self, fraction: float) -> None:
        if self.isHidden() and fraction >= 0.0:  # it begins
            self.speed.setCurrentIndex(self.speed.findData(self._player.speed))
            with QtCore.QSignalBlocker(self.hold):
                self.hold.setChecked(False)
        self.setVisible(fraction >= 0.0)
        self.bar.setValue(round(_STEPS * min(max(fraction, 0.0), 1.0)))
        left = self._player.left_s
        self.left.setText("" if left is None else say_left(left))
        self.still.setVisible(self._player.is_spreading and (left or 0.0) > _LONG_S)

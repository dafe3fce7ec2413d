"""Seals: asked for in a dialog, then pressed where one clicks."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any, cast

from PySide6 import QtCore, QtGui

from paint3d.app.model.input import navigation
from paint3d.app.window.dialogs.seal_dialog import SealAsked, SealDialog
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.calligraphy.seal.asked import cut_seal
from paint3d.calligraphy.seal.stone import Seal
from paint3d.core.types import AnyArray
from paint3d.view.camera import picture_axes

__all__ = ["Sealing"]

_KIND = QtCore.QEvent.Type
_PRESSES = (_KIND.MouseButtonPress, _KIND.TabletPress)
_MOVES = (_KIND.MouseMove, _KIND.TabletMove)
_LIFTS = (_KIND.MouseButtonRelease, _KIND.TabletRelease)
_LOOK_MS = 40


class Sealing(QtCore.QObject):
    """For one window.

    Attributes
    ----------
    seal : Seal or None
        What is pressed with the next click on the object.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace.window)
        self._workspace = workspace
        self._kept = SealAsked()
        self.seal: Seal | None = None
        self._pressing = False  # a press was taken, its lift is still to come
        self._done: Future[Any] | None = None
        self._timer = QtCore.QTimer(self)
        self._timer.timeout.connect(self._follow)
        workspace.canvas.installEventFilter(self)
        workspace.opened.connect(lambda _: self.let_be())

    def do_seal(self) -> None:
        """Ask for a seal, and let the next click on the object press it."""
        workspace = self._workspace
        self.let_be()
        dialog = SealDialog(workspace.window, self._kept)
        if not dialog.exec():
            return
        asked = self._kept = dialog.asked()
        if not asked.text and not asked.drawing:
            return

        def work(_: Progress) -> Seal:
            text = None if asked.drawing else asked.text
            drawing = asked.drawing or None
            font = asked.font or None
            return cut_seal(text, drawing, asked.style, asked.size_mm, font=font)

        done = workspace.run(say("Cutting the seal…"), work)
        if workspace.went_well(done):
            self.seal = done.result()
            workspace.canvas.setCursor(QtCore.Qt.CursorShape.PointingHandCursor)
            workspace.canvas.setFocus()
            workspace.tell(say("Click where the seal goes; Esc lets it be"), stays=True)

    def let_be(self) -> None:
        """Press nothing."""
        if self.seal is not None:
            self.seal = None
            self._workspace.canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)

    # -- the click --------------------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Take the click that presses the seal; everything else goes on to the picture."""
        if watched is not self._workspace.canvas:
            return False
        kind = event.type()
        if self._pressing and kind in (*_MOVES, *_LIFTS):
            self._pressing = kind not in _LIFTS
            return True
        if self.seal is None:
            return False
        if kind in (_KIND.KeyPress, _KIND.ShortcutOverride):
            return self._take_key(cast(QtGui.QKeyEvent, event))
        return kind in _PRESSES and self._take_press(cast(QtGui.QSinglePointEvent, event))

    def _take_key(self, event: QtGui.QKeyEvent) -> bool:
        if event.key() != QtCore.Qt.Key.Key_Escape:
            return False
        event.accept()
        self.let_be()
        self._workspace.tell(say("No seal was pressed"))
        return True

    def _take_press(self, event: QtGui.QSinglePointEvent) -> bool:
        if event.button() != QtCore.Qt.MouseButton.LeftButton or event.modifiers():
            return False  # it steers
        place = self._place(event.position())
        if place is None:
            return False
        event.accept()
        self._pressing = True
        self._press(place)
        return True

    def _place(self, at: QtCore.QPointF) -> AnyArray | None:
        """(3,) the place on the object at a pixel, or None."""
        canvas, hand = self._workspace.canvas, self._workspace.hand
        if hand.camera is None:
            return None
        size = canvas.width(), canvas.height()
        ray = navigation.ray_at(hand.camera, at.x(), at.y(), size)
        hits = hand.surface.cast(ray.origin[None], ray.direction[None])
        return hits.points[0] if hits.hit[0] else None

    def _press(self, place: AnyArray) -> None:
        """Press it there, upright in the picture."""
        workspace, seal = self._workspace, self.seal
        assert seal is not None
        up = picture_axes(workspace.hand.open_camera)[1]
        rings = [ring.tolist() for ring in seal.rings]
        self.let_be()
        self._done = workspace.easel.post("press_seal", rings, place.tolist(), up.tolist())
        self._timer.start(_LOOK_MS)

    def _follow(self) -> None:
        """Say how much of it touched, once it is pressed; a fault is told as all are."""
        if self._done is None or not self._done.done():
            return
        self._timer.stop()
        done, self._done = self._done, None
        if not done.cancelled() and done.exception() is None:
            percent = 100.0 * done.result()
            told = say("The seal is pressed; {percent:.0f} % of it touches", percent=percent)
            self._workspace.tell(told, state="good")

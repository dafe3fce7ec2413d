"""Moving, turning, scaling and spacing laid texts by mouse, pen, finger and keys."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from PySide6 import QtCore, QtGui

from paint3d.app.model.copybook import Copybook
from paint3d.app.model.laid_text import LaidText
from paint3d.app.window.hand.canvas_tool import CanvasTool, draw_grip
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray
from paint3d.errors import Message, Paint3DError
from paint3d.mesh.chart import SurfaceFrame, frame_at

__all__ = ["ChosenText", "TextMover"]

_KEY = QtCore.Qt.Key
_GRIP, _REACH = 7.0, 14.0  # pixels: half of a grip, and how near it is taken
_AWAY = 30.0  # pixels from the text to the ring that turns it
_STEP_MM, _FAR_MM, _DEGREES, _GROWS, _APART = 1.0, 10.0, 1.0, 1.02, 0.02
_PATIENCE_MS = 450  # after the last key
_LINES = "moving text"
_HOW = Message(
    "Drag a text to move it, its corner to scale it, the ring to turn it; arrows move, "
    "with Ctrl turn and scale, with Alt space; Esc ends"
)
_ARROWS = {
    _KEY.Key_Left: (-1, 0), _KEY.Key_Right: (1, 0), _KEY.Key_Up: (0, 1), _KEY.Key_Down: (0, -1),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class ChosenText:
    """The text that drags and keys act on.

    Attributes
    ----------
    laid : LaidText
        As it lies on the object.
    book : Copybook
    shape : (int, int)
        Characters across and down; (1, 1) where that is not known.
    """

    laid: LaidText
    book: Copybook
    shape: tuple[int, int]


class TextMover(CanvasTool):
    """Waits for drags and keys that move a text; the brush does not paint meanwhile.

    Parameters
    ----------
    workspace : Workspace
    chosen_text : callable
        Returns the `ChosenText`, or None.
    choose : callable
        Chooses the text at a point (3,) of the object; False where there is none.

    Signals
    -------
    changed : dict
        Other values of the text.
    removed : ()
    """

    changed = QtCore.Signal(object)
    removed = QtCore.Signal()
    keys = frozenset({*_ARROWS, _KEY.Key_Delete})

    def __init__(
        self,
        workspace: Workspace,
        chosen_text: Callable[[], ChosenText | None],
        choose: Callable[[AnyArray], bool],
    ) -> None:
        super().__init__(workspace)
        self._chosen_text, self._choose = chosen_text, choose
        self._grip = ""  # that is dragged
        self._is_refused = False  # and said so: the next move puts that away
        self._from = QtCore.QPointF()
        self._start: AnyArray | None = None  # of the object, where the drag began
        self._changes: dict[str, Any] = {}
        self._timer = QtCore.QTimer(self, interval=_PATIENCE_MS, singleShot=True)
        self._timer.timeout.connect(self._commit)

    def begin(self) -> None:
        """Make drags and keys move texts, until `end`."""
        self.turn_on(say(_HOW))

    def end(self) -> None:
        """Paint again with the next drag; what keys have changed stays."""
        if self.is_on:
            self._commit()
            super().end()

    # -- keys -------------------------------------------------------------------------------

    def press_key(self, event: QtGui.QKeyEvent) -> None:
        """Move by arrows, remove by Delete."""
        if event.key() == _KEY.Key_Delete:
            self._changes = {}
            self.removed.emit()
        else:
            self._nudge(*_ARROWS[_KEY(event.key())], event.modifiers())

    def _nudge(self, right: int, up: int, keys: QtCore.Qt.KeyboardModifier) -> None:
        """Change the text by one key; it is laid out when no further one comes."""
        chosen = self._chosen_text()
        if chosen is None:
            return
        modifier = QtCore.Qt.KeyboardModifier
        laid = chosen.laid.moved(**self._changes)
        frame = chosen.book.block.frame
        changes: dict[str, Any] = {"point": self._point(chosen)}
        if keys & modifier.ControlModifier:
            if right and laid.around:
                return
            if right:
                changes["turn"] = _wrap_degrees(laid.turn - right * _DEGREES)
            else:
                changes["em_mm"] = laid.em_mm * _GROWS**up
        elif keys & modifier.AltModifier:
            name = _spacing_name(laid, bool(right))
            changes[name] = max(0.0, getattr(laid, name) + (right + up) * _APART)
        else:
            step = _FAR_MM if keys & modifier.ShiftModifier else _STEP_MM
            shift = step * (right * frame.x_axis + up * frame.y_axis)
            ground = self._workspace.hand.surface
            point = ground.find((np.array(changes["point"]) + shift)[None]).points[0]
            changes["point"] = tuple(point.tolist())
        self._try(chosen, self._changes | changes)
        self._timer.start()

    def _point(self, chosen: ChosenText) -> tuple[float, float, float]:
        """Return the text's middle, with the changes since it was laid."""
        middle = self._changes.get("point", tuple(chosen.book.block.frame.origin.tolist()))
        x, y, z = middle
        return float(x), float(y), float(z)

    def _try(self, chosen: ChosenText, changes: dict[str, Any]) -> None:
        """Show the effect of changes; ignore those that no text can have."""
        try:
            chosen.laid.moved(**changes)
        except Paint3DError:
            return
        if self._is_refused:
            self._is_refused = False
            self._workspace.tell(say(_HOW))
        self._changes = changes
        self._show(chosen)

    def _commit(self) -> None:
        self._timer.stop()
        changes, self._changes = self._changes, {}
        self._show(None)
        if changes:
            self.changed.emit(changes)

    # -- the hand ---------------------------------------------------------------------------

    def takes(self, at: QtCore.QPointF) -> bool:
        """Return whether a grip or the object is there; elsewhere a drag turns the view."""
        return bool(self._grip_at(at)) or self._on_object(at.x(), at.y()) is not None

    def _on_object(self, x: float, y: float) -> AnyArray | None:
        return self._workspace.hand.place_at(x, y)

    def let_go(self, at: QtCore.QPointF) -> None:
        """End the drag, and lay the text there."""
        self.drag(at)
        self._grip = ""
        self._canvas.setCursor(self.cursor)
        self._commit()

    def take_hold(self, at: QtCore.QPointF, *, adds: bool) -> None:
        """Begin to drag a grip, or the text there."""
        self._commit()
        self._grip = self._grip_at(at)
        self._start = self._on_object(at.x(), at.y())
        if not self._grip:
            if self._start is None or not self._choose(self._start):
                self._is_refused = True
                self._workspace.tell(say("There is no text there"), state="bad")
                return
            self._grip = "move"
        self._from = at
        self._canvas.setCursor(QtCore.Qt.CursorShape.ClosedHandCursor)

    def drag(self, at: QtCore.QPointF) -> None:
        """Show the effect of the drag so far."""
        chosen = self._chosen_text()
        if chosen is None or not self._grip or at == self._from:
            return
        frame = chosen.book.block.frame
        changes: dict[str, Any] = {"point": tuple(frame.origin.tolist())}
        if self._grip == "move":
            point = self._on_object(at.x(), at.y())
            if point is None or self._start is None:
                return
            target = frame.origin + point - self._start
            target_point = self._workspace.hand.surface.find(target[None]).points[0]
            changes["point"] = tuple(target_point.tolist())
        else:
            ahead = self._in_plane(frame, at)
            before = self._in_plane(frame, self._from)
            if ahead is None or before is None:
                return
            changes |= self._grip_changes(chosen, before, ahead)
        self._try(chosen, changes)

    def _grip_changes(
        self, chosen: ChosenText, before: AnyArray, ahead: AnyArray
    ) -> dict[str, Any]:
        """Return the changes by dragging a grip between two points of the text's plane."""
        laid, (across, down) = chosen.laid, chosen.shape
        if self._grip == "scale":
            least = max(float(np.linalg.norm(before)), 1e-6)
            return {"em_mm": laid.em_mm * float(np.linalg.norm(ahead)) / least}
        if self._grip == "turn":
            turn = math.atan2(ahead[1], ahead[0]) - math.atan2(before[1], before[0])
            return {"turn": _wrap_degrees(laid.turn + math.degrees(turn))}
        level = self._grip == "across"
        n = across if level else down
        inward = before[0] - ahead[0] if level else before[1] - ahead[1]
        name = _spacing_name(laid, level)
        more = 2.0 * float(inward) / (laid.em_mm * (n - 1))
        return {name: max(0.0, getattr(laid, name) + more)}

    def _in_plane(self, frame: SurfaceFrame, at: QtCore.QPointF) -> AnyArray | None:
        """Return the point at the pointer in a frame's tangent plane, (2,) mm from its origin."""
        ray = self._workspace.hand.ray_at(at.x(), at.y())
        falls = float(ray.direction @ frame.normal)
        if abs(falls) < 1e-6:
            return None
        away = float((frame.origin - ray.origin) @ frame.normal) / falls
        off = ray.origin + away * ray.direction - frame.origin
        return np.array([off @ frame.x_axis, off @ frame.y_axis])

    def drop(self) -> None:
        """Drop the grip and the changes."""
        self._grip, self._changes = "", {}
        self._show(None)

    # -- the picture ------------------------------------------------------------------------

    def grips(self) -> dict[str, QtCore.QPointF]:
        """Return each grip's position in the picture, pixels; none without a chosen text."""
        chosen = self._chosen_text()
        if chosen is None:
            return {}
        upper_left, upper_right, lower_right, lower_left = self._corners(chosen)
        middle = 0.25 * (upper_left + upper_right + lower_right + lower_left)

        def beyond(at: AnyArray, pixels: float) -> AnyArray:
            away = at - middle
            farther: AnyArray = at + away * (pixels / max(float(np.linalg.norm(away)), 1e-6))
            return farther

        positions = {"scale": beyond(lower_right, _GRIP)}
        across, down = chosen.shape
        if across > 1:
            positions["across"] = beyond(0.5 * (upper_left + lower_left), _REACH)
        if down > 1:
            positions["down"] = beyond(0.5 * (lower_left + lower_right), _REACH)
        if not chosen.laid.around:
            positions["turn"] = beyond(0.5 * (upper_left + upper_right), _AWAY)
        return {name: QtCore.QPointF(*at.tolist()) for name, at in positions.items()}

    def _corners(self, chosen: ChosenText) -> list[AnyArray]:
        corners = self._moved(chosen, chosen.book.block.corners)
        return list(self._workspace.hand.pixels_of(corners))

    def _grip_at(self, at: QtCore.QPointF) -> str:
        near = {
            name: math.hypot(grip.x() - at.x(), grip.y() - at.y())
            for name, grip in self.grips().items()
        }
        best = min(near, key=lambda name: near[name], default="")
        return best if best and near[best] <= _REACH else ""

    def _moved(self, chosen: ChosenText, points: AnyArray) -> AnyArray:
        """Return points (N, 3) of the text as they will lie, as if it were a stiff sheet."""
        changes, frame = self._changes, chosen.book.block.frame
        if not changes:
            return points
        laid = chosen.laid
        now = laid.moved(**changes)
        to = frame_at(self._workspace.hand.surface, np.array(self._point(chosen)), frame.y_axis)
        flat = (points - frame.origin) @ np.stack(
            [frame.x_axis, frame.y_axis, frame.normal], axis=1
        )
        flat[:, :2] *= now.em_mm / laid.em_mm
        for axis, level in ((0, True), (1, False)):
            name = _spacing_name(laid, level)
            n = chosen.shape[axis]
            more = (n - 1) * (getattr(now, name) - getattr(laid, name)) * now.em_mm
            size = float(np.ptp(flat[:, axis]))
            flat[:, axis] *= (size + more) / max(size, 1e-6)
        turn = math.radians(now.turn - laid.turn)
        c, s = math.cos(turn), math.sin(turn)
        x, y = c * flat[:, 0] - s * flat[:, 1], s * flat[:, 0] + c * flat[:, 1]
        moved: AnyArray = (
            to.origin + np.outer(x, to.x_axis) + np.outer(y, to.y_axis)
            + np.outer(flat[:, 2], to.normal)
        )  # fmt: skip
        return moved

    def _show(self, chosen: ChosenText | None) -> None:
        """Draw the text where it would lie; None: draw it no longer."""
        stage = self._workspace.stage
        if stage.paint_thread is None:
            return
        lines: list[AnyArray] = []
        if chosen is not None:
            every = chosen.book.grid("frame", columns=True)
            points = self._moved(chosen, np.concatenate(every))
            lines = np.split(points, np.cumsum([len(line) for line in every])[:-1])
        accent = QtGui.QColor(self._workspace.theme.accent)
        stage.show_lines(_LINES, lines, (accent.red(), accent.green(), accent.blue(), 200), 1.6)
        self._canvas.update()

    def paint(self, painter: QtGui.QPainter) -> None:
        """Draw the text's outline and its grips."""
        chosen = self._chosen_text()
        if chosen is None:
            return
        accent = QtGui.QColor(self._workspace.theme.accent)
        corners = [QtCore.QPointF(*at.tolist()) for at in self._corners(chosen)]
        painter.setPen(QtGui.QPen(accent, 1.2, QtCore.Qt.PenStyle.DashLine))
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.drawPolygon(QtGui.QPolygonF(corners))
        painter.setPen(QtGui.QPen(QtGui.QColor("#ffffff"), 1.5))
        painter.setBrush(accent)
        for name, at in self.grips().items():
            draw_grip(painter, name, at, _GRIP)


def _spacing_name(laid: LaidText, level: bool) -> str:
    """Return the name of the distance of characters side by side, or one above the other."""
    return "gap" if level == (laid.order == "columns") else "between"


def _wrap_degrees(degrees: float) -> float:
    """Return an angle within -180 to 180 degrees."""
    return (degrees + 180.0) % 360.0 - 180.0

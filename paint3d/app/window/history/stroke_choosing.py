"""Choosing several strokes in the picture, and moving, turning and scaling them there as one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui

from paint3d.app.window.hand.canvas_tool import CLICK, CanvasTool, draw_grip
from paint3d.app.window.history.stroke_mark import StrokeMark, ways_of
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray

__all__ = ["StrokeChooser"]

_REACH, _GRIP, _AWAY, _FRAME = 14.0, 6.0, 26.0, 10.0  # pixels
_INSIDE = 0.5  # fraction of a stroke's path within the loop
_LEAST, _MOST = 0.1, 10.0  # of a scale by one drag


class StrokeChooser(CanvasTool):
    """Tool that chooses strokes: while it is on, drags choose and move them and do not paint.

    Parameters
    ----------
    workspace : Workspace
    mark : StrokeMark
        Has the strokes that are chosen.

    Signals
    -------
    edited : dict
        An edit of them; see `score_edits.apply_stroke_edit`.
    """

    edited = QtCore.Signal(object)
    cursor = QtCore.Qt.CursorShape.PointingHandCursor

    def __init__(self, workspace: Workspace, mark: StrokeMark) -> None:
        super().__init__(workspace)
        self._mark = mark
        self._doing = ""  # "loop", "move", or a grip
        self._adds = False
        self._loop: list[QtCore.QPointF] = []
        self._start: AnyArray | None = None  # of the object, where the drag began
        mark.changed.connect(lambda _: self._canvas.update())

    def begin(self) -> None:
        """Make drags choose and move strokes until `end`."""
        self._workspace.stage.hide_brush()
        self.turn_on(
            say(
                "Draw a loop around strokes, or click them; drag them, their corner or their ring; "
                "Del deletes; Esc ends"
            )
        )

    def end(self) -> None:
        """Paint again with the next drag; no stroke stays chosen."""
        if self.is_on:
            super().end()
            self._mark.choose(None)

    # -- the hand ---------------------------------------------------------------------------

    def drop(self) -> None:
        """Drop the loop, or what is dragged."""
        self._doing, self._loop = "", []

    def take_hold(self, at: QtCore.QPointF, *, adds: bool) -> None:
        """Begin at a grip, at a chosen stroke, or with a loop."""
        self._loop, self._adds = [at], adds
        self._start = self._workspace.hand.place_at(at.x(), at.y())
        self._doing = self._grip_at(at)
        if not self._doing:
            index = None if self._start is None or adds else self._mark.stroke_at(self._start)
            self._doing = "move" if index is not None and index in self._mark.indices else "loop"

    def drag(self, at: QtCore.QPointF) -> None:
        """Go on with a loop, or with what is dragged."""
        self._loop.append(at)

    def let_go(self, at: QtCore.QPointF) -> None:
        """Choose what was clicked or lies within the loop, or edit what was dragged."""
        if not self._loop:
            return
        self._loop.append(at)
        doing, path = self._doing, self._loop
        first, last = path[0], path[-1]
        start = self._start
        reach = max(math.hypot((p - first).x(), (p - first).y()) for p in path)
        change = self._change() if reach >= CLICK else {}
        self.drop()
        if reach < CLICK:
            self._click(start)
        elif doing == "loop":
            self._choose_within(path)
        elif doing == "move":
            there = self._workspace.hand.place_at(last.x(), last.y())
            if there is None or start is None:
                self._workspace.tell(say("That is beside the object"), state="bad")
            else:
                self.edited.emit({"do": "move", "to": [start.tolist(), there.tolist()]})
        elif doing == "turn":
            self.edited.emit({"do": "move", "turn_deg": math.degrees(change["turn"])})
        elif doing == "scale":
            self.edited.emit({"do": "scale", "factor": change["scale"]})

    def _click(self, point: AnyArray | None) -> None:
        """Add the stroke at a point to the chosen ones, or remove it; choose none beside all."""
        index = None if point is None else self._mark.stroke_at(point)
        self._mark.choose_all(() if index is None else {*self._mark.indices} ^ {index})
        self._tell_chosen()

    def _choose_within(self, path: list[QtCore.QPointF]) -> None:
        """Choose the strokes of which the greater part lies within a loop, and is seen."""
        loop = np.array([[p.x(), p.y()] for p in path])
        ground = self._workspace.hand.surface
        indices = set(self._mark.indices) if self._adds else set()
        for index, stroke in enumerate(self._workspace.painting.strokes):
            paths = ways_of(stroke, ground)
            if not paths:
                continue
            points = np.concatenate(paths)
            inside = _within(self._workspace.hand.pixels_of(points), loop)
            if (
                inside.mean() >= _INSIDE
                and self._workspace.hand.sees(points[inside]).mean() >= _INSIDE
            ):
                indices.add(index)
        self._mark.choose_all(indices)
        self._tell_chosen()

    def _tell_chosen(self) -> None:
        n = len(self._mark.indices)
        self._workspace.tell(
            say("{n} stroke is chosen", "{n} strokes are chosen", n=n)
            if n
            else say("No stroke is chosen")
        )

    # -- the picture ------------------------------------------------------------------------

    def grips(self) -> Mapping[str, QtCore.QPointF]:
        """Return each grip's position in the picture, pixels; none without a chosen stroke."""
        box = self._box()
        if box is None:
            return {}
        middle = box.center()
        return {
            "scale": box.bottomRight(),
            "turn": QtCore.QPointF(middle.x(), box.top() - _AWAY),
        }

    def _box(self) -> QtCore.QRectF | None:
        lines = self._lines()
        if not lines:
            return None
        points = np.concatenate(lines)
        (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
        box = QtCore.QRectF(x0, y0, x1 - x0, y1 - y0)
        return box.adjusted(-_FRAME, -_FRAME, _FRAME, _FRAME)

    def _lines(self) -> list[AnyArray]:
        """Return the paths (K, 2) of the chosen strokes in the picture, pixels."""
        if self._workspace.hand.camera is None or not self._mark.indices:
            return []
        lines = [self._workspace.hand.pixels_of(path) for path in self._mark.ways()]
        return [line for line in lines if np.isfinite(line).all()]

    def _grip_at(self, at: QtCore.QPointF) -> str:
        for name, grip in self.grips().items():
            if math.hypot(grip.x() - at.x(), grip.y() - at.y()) <= _REACH:
                return name
        return ""

    def _change(self) -> dict[str, Any]:
        """Return how far the drag moves, turns (rad, to the left) or scales the chosen strokes."""
        box = self._box()
        if box is None or len(self._loop) < 2 or self._doing in ("", "loop"):
            return {}
        start, now, middle = self._loop[0], self._loop[-1], box.center()
        if self._doing == "move":
            return {"move": now - start}
        before, after = start - middle, now - middle
        if self._doing == "turn":
            turn = math.atan2(-after.y(), after.x()) - math.atan2(-before.y(), before.x())
            return {"turn": (turn + math.pi) % (2.0 * math.pi) - math.pi}
        ratio = math.hypot(after.x(), after.y()) / max(1.0, math.hypot(before.x(), before.y()))
        return {"scale": min(max(ratio, _LEAST), _MOST)}

    def paint(self, painter: QtGui.QPainter) -> None:
        """Draw the loop, the grips, and where the strokes would come to lie."""
        accent = QtGui.QColor(self._workspace.theme.accent)
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(accent, 1.2, QtCore.Qt.PenStyle.DashLine))
        if self._doing == "loop":
            painter.drawPolygon(QtGui.QPolygonF(self._loop))
        box = self._box()
        if box is None:
            return
        painter.drawRect(box)
        change, middle = self._change(), box.center()
        if change:
            painter.save()
            painter.translate(middle + change.get("move", QtCore.QPointF()))
            painter.rotate(-math.degrees(change.get("turn", 0.0)))
            painter.scale(change.get("scale", 1.0), change.get("scale", 1.0))
            painter.translate(-middle)
            pen = QtGui.QPen(accent, 2.0)
            pen.setCosmetic(True)
            painter.setPen(pen)
            for line in self._lines():
                painter.drawPolyline(QtGui.QPolygonF([QtCore.QPointF(x, y) for x, y in line]))
            painter.restore()
        painter.setPen(QtGui.QPen(QtGui.QColor("#ffffff"), 1.5))
        painter.setBrush(accent)
        for name, at in self.grips().items():
            draw_grip(painter, name, at, _GRIP)


def _within(points: AnyArray, loop: AnyArray) -> NDArray[np.bool_]:
    """Return whether points (N, 2) lie within a closed line (K, 2), by the even-odd rule."""
    x, y = points[:, 0, None], points[:, 1, None]
    x0, y0 = loop[:, 0], loop[:, 1]
    x1, y1 = np.roll(x0, -1), np.roll(y0, -1)
    crosses = (y0 <= y) != (y1 <= y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    inside: NDArray[np.bool_] = (crosses & (x < at)).sum(axis=1) % 2 == 1
    return inside

"""The chosen strokes, marked in the picture by a band along the path of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from operator import is_

import numpy as np
from PySide6 import QtCore, QtGui

from paint3d.app.model.stroke_log import Stroke
from paint3d.app.window.hand.canvas_tool import CLICK, CanvasTool
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length, resample_to
from paint3d.mesh.bvh import ClosestPoints
from paint3d.recording.score_edits import pressed_positions

__all__ = ["StrokeDrag", "StrokeMark", "ways_of"]

_STEP_MM = 0.4  # between the points of a path
_MOST = 4000  # points of a piece
_LIFT_MM = 0.1  # of each band above the one below
_DOT_MM, _ROUND = 0.8, 24  # the ring around a stroke that went nowhere, and its points
_LEAST_REACH_MM = 1.0  # from a stroke's path, within which it is hit, however thin its brush
_BANDS = (("chosen glow", 13.0, 80), ("chosen rim", 7.0, 235), ("chosen way", 3.0, 255))
"""Bands, the lowest first: name, width in pixels, density."""
_OTHER_SCALE = 1.5  # change of the view's scale after which the bands are drawn anew


def ways_of(stroke: Stroke, ground: ClosestPoints) -> list[AnyArray]:
    """Return the pieces (K, 3) of a stroke in which its brush pressed, on the surface, mm.

    Parameters
    ----------
    stroke : Stroke
    ground : ClosestPoints
        Of the object.
    """
    points, pressed = pressed_positions(stroke.recording())
    edges = np.flatnonzero(np.diff(np.concatenate([[False], pressed, [False]]).astype(np.int8)))
    return [_line_on(points[a:b], ground) for a, b in edges.reshape(-1, 2)]


def _line_on(points: AnyArray, ground: ClosestPoints) -> AnyArray:
    """Return a line through points, on the surface; a ring where they are one point."""
    length = line_length(points)
    if length < 0.5 * _DOT_MM:
        return _ring_on(points[0], ground)
    n = int(np.clip(np.ceil(length / _STEP_MM), 1, _MOST)) + 1
    return ground.find(resample_to(points, n)).points


def _ring_on(point: AnyArray, ground: ClosestPoints) -> AnyArray:
    foot = ground.find(point[None])
    normal = foot.normals[0]
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    angle = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)[:, None]
    ring = np.cos(angle) * first + np.sin(angle) * np.cross(normal, first)
    return ground.find(foot.points[0] + _DOT_MM * ring).points


def _bands(
    lines: Sequence[AnyArray], ground: ClosestPoints, width_mm: float, lift_mm: float
) -> tuple[AnyArray, AnyArray]:
    """Return bands along lines (K, 3) on the surface: points (N, 3), mm, and faces (L, 3)."""
    points, faces, first = [], [], 0
    for line in lines:
        feet = ground.find(line)
        ahead = np.gradient(line, axis=0)
        side = np.cross(feet.normals, ahead)
        side *= 0.5 * width_mm / np.maximum(np.linalg.norm(side, axis=1), 1e-9)[:, None]
        for edge in (side, -side):
            there = ground.find(feet.points + edge)
            points.append(there.points + lift_mm * there.normals)
        k = first + np.arange(len(line) - 1)
        n = len(line)
        faces += [np.stack([k, k + 1, k + n], axis=1), np.stack([k + 1, k + n + 1, k + n], axis=1)]
        first += 2 * n
    if not points:
        return np.empty((0, 3)), np.empty((0, 3), np.int32)
    return np.concatenate(points), np.concatenate(faces).astype(np.int32)


class StrokeMark(QtCore.QObject):
    """Marks one stroke, several, or none.

    Signals
    -------
    changed : (object)
        The indices (tuple of int) of the strokes that are marked, from 0; None for none.

    Attributes
    ----------
    indices : tuple of int
        Of those that are marked.
    """

    changed = QtCore.Signal(object)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._workspace = workspace
        self._marked: list[Stroke] = []
        self._was_there = False
        self._pixel_mm = 0.0  # for which it was drawn
        self.indices: tuple[int, ...] = ()
        workspace.opened.connect(lambda _: self.choose(None))
        workspace.hand.began.connect(lambda: self.choose(None))
        workspace.theme_changed.connect(lambda _: self._draw())

    def choose(self, index: int | None) -> None:
        """Mark this stroke of the history, from 0, those that were undone among them; or none."""
        self.choose_all(() if index is None else (index,))

    def choose_all(self, indices: Iterable[int]) -> None:
        """Mark these strokes and no other; see `choose`."""
        strokes = self._strokes() if indices else []
        indices = sorted({index for index in indices if 0 <= index < len(strokes)})
        marked = [strokes[index] for index in indices]
        if len(marked) == len(self._marked) and all(map(is_, marked, self._marked)):
            return
        self._marked, self.indices = marked, tuple(indices)
        self._was_there = False
        self._draw()
        self.changed.emit(self.indices or None)

    def follow(self) -> None:
        """Drop the mark when its stroke is undone, deleted, or painted anew."""
        if not self._marked:
            return
        scale = self._workspace.stage.scene.nearest_mm() / self._pixel_mm
        if not 1.0 / _OTHER_SCALE < scale < _OTHER_SCALE:
            self._draw()
        there = {id(one) for one in self._workspace.painting.strokes}
        known = {id(one) for one in self._strokes()}
        if all(id(one) in there for one in self._marked):
            self._was_there = True
        elif self._was_there or any(id(one) not in known for one in self._marked):
            self.choose(None)

    def stroke_at(self, point: AnyArray) -> int | None:
        """Return the index of the stroke nearest to a point (3,), None if none is near enough."""
        best, nearest = np.inf, None
        for index, stroke in enumerate(self._workspace.painting.strokes):
            paths = ways_of(stroke, self._workspace.hand.surface)
            near = min(
                (float(np.linalg.norm(path - point, axis=1).min()) for path in paths),
                default=np.inf,
            )
            reach = max(_LEAST_REACH_MM, 0.5 * stroke.brush.root_diameter_mm)
            if near <= min(best, reach):  # of two that are as near the upper one
                best, nearest = near, index
        return nearest

    def ways(self) -> list[AnyArray]:
        """Return the paths (K, 3) of the marked strokes, on the surface, mm."""
        ground = self._workspace.hand.surface
        return [way for stroke in self._marked for way in ways_of(stroke, ground)]

    def _strokes(self) -> Sequence[Stroke]:
        painting = self._workspace.painting
        return [*painting.strokes, *painting.undone_strokes]

    def _draw(self) -> None:
        stage, theme = self._workspace.stage, self._workspace.theme
        if stage.paint_thread is None:
            return
        ground, lines = self._workspace.hand.surface, self.ways()
        pixel = self._pixel_mm = stage.scene.nearest_mm()
        inner, rim = QtGui.QColor(theme.accent), QtGui.QColor("#ffffff")
        colours = (inner, rim, inner)
        for k, ((name, width, dense), colour) in enumerate(zip(_BANDS, colours, strict=True)):
            points, faces = _bands(lines, ground, width * pixel, (1 + k) * _LIFT_MM)
            srgb = colour.red(), colour.green(), colour.blue()
            stage.show_faces(name, points, faces, (*srgb, dense))


# ---- Dragging ------------------------------------------------------------------------------------
# A stroke that is dragged from one point of the object to another.


_RADIUS, _WIDTH = 6.0, 2.0  # of what is drawn, pixels


class StrokeDrag(CanvasTool):
    """A tool for one drag over the picture by mouse, pen or finger, which does not paint.

    Parameters
    ----------
    workspace : Workspace
    stroke_at : callable
        Returns the index of the stroke at a point (3,) of the object, from 0, or None.

    Signals
    -------
    chosen : int
        The stroke that is dragged, where none was named.
    dragged : (int, object)
        The stroke, and two points (2, 3) of the object: where the drag began and where it ended.
    """

    chosen = QtCore.Signal(int)
    dragged = QtCore.Signal(int, object)

    def __init__(
        self,
        workspace: Workspace,
        stroke_at: Callable[[AnyArray], int | None],
    ) -> None:
        super().__init__(workspace)
        self._stroke_at = stroke_at
        self._named_index: int | None = None  # the stroke that is to be moved
        self._dragged_index: int | None = None  # the one that is dragged
        self._from: tuple[QtCore.QPointF, AnyArray] | None = None
        self._now = QtCore.QPointF()

    def begin(self, index: int | None = None) -> None:
        """Make the next drag move this stroke, or the one at which it begins."""
        self.end()
        self._named_index = index
        self.turn_on(
            say("Click a stroke on the object, or drag it to its new place; Esc cancels")
            if index is None
            else say("Drag stroke {n} to its new place; Esc cancels", n=index + 1)
        )

    def drop(self) -> None:
        """Drop the stroke."""
        self._dragged_index = self._from = None
        self._canvas.setCursor(self.cursor)

    def _point(self) -> AnyArray | None:
        return self._workspace.hand.place_at(self._now.x(), self._now.y())

    def take_hold(self, at: QtCore.QPointF, *, adds: bool) -> None:
        """Begin to drag the stroke there, or the one that was named."""
        self._now = at
        point = self._point()
        if point is None:
            self._workspace.tell(say("That is beside the object"), state="bad")
            return
        self._dragged_index = (
            self._stroke_at(point) if self._named_index is None else self._named_index
        )
        if self._dragged_index is None:
            self._workspace.tell(say("There is no stroke there"), state="bad")
            return
        if self._named_index is None:
            self.chosen.emit(self._dragged_index)
        self._from = self._now, point
        self._canvas.setCursor(QtCore.Qt.CursorShape.ClosedHandCursor)

    def drag(self, at: QtCore.QPointF) -> None:
        """Draw how far it is dragged."""
        self._now = at

    def let_go(self, at: QtCore.QPointF) -> None:
        """End the drag, and move the stroke there."""
        self._now = at
        start, point, index = self._from, self._point(), self._dragged_index
        if start is None or index is None:
            return
        shift = self._now - start[0]
        if self._named_index is None and abs(shift.x()) + abs(shift.y()) < CLICK:
            self.drop()
        elif point is None:
            self.drop()
            self._workspace.tell(say("That is beside the object"), state="bad")
        else:
            self.end()
            self.dragged.emit(index, (start[1], point))

    def paint(self, painter: QtGui.QPainter) -> None:
        """Draw how far it is dragged."""
        if self._from is None:
            return
        theme = self._workspace.theme
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.accent), _WIDTH))
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.drawEllipse(self._from[0], _RADIUS, _RADIUS)
        painter.drawLine(self._from[0], self._now)
        painter.setBrush(QtGui.QColor(theme.accent))
        painter.drawEllipse(self._now, 0.5 * _RADIUS, 0.5 * _RADIUS)

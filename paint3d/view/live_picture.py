"""Progressive rendering of a scene: no picture takes long, and in the end all of it is fine.

While the view moves, an object of many triangles is drawn coarsely (on a graphics card only if it
is too slow otherwise) and, in software, at reduced resolution if that is still too slow. Once the
view stands still, every triangle is drawn, cell by cell of the picture, a few cells at a time; and
once nothing moves any more, software renderers smooth edges in the same way. Changes come first: a
hand never waits for more than one such step.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.view.live_layers import Box, joined_box
from paint3d.view.live_scene import LiveScene

__all__ = ["LivePicture"]

_CELL = 160  # side of a cell, pixels
_PART = 640  # side of a part in `draw_by_parts`, pixels
_FINE, _PLAIN, _ROUGH = 0, 1, 2  # states of a cell: smooth edges; every triangle; coarse
_BEST = _FINE  # that software draws; a graphics card smooths edges by itself
_SETTLED_S = 0.15  # time after the view moved until all triangles are drawn
_CALM_S = 0.35  # time after anything changed until edges are smoothed
_STEP_S = 0.025  # longest time spent at once on such improvements
_MANY = 120_000  # triangles above which the object is drawn coarsely while the view moves
_Levels = tuple[tuple[float, float], ...]
# Levels of detail while the view moves: most triangles, and fraction of the pixels per side.
_LEVELS: _Levels = (
    (_MANY, 1.0), (60_000, 1.0), (60_000, 2 / 3), (30_000, 2 / 3), (30_000, 0.5),
)  # fmt: skip
_CARD_LEVELS: _Levels = (  # on a graphics card: every triangle while that is fast enough
    (math.inf, 1.0), (_MANY, 1.0), (60_000, 1.0), (30_000, 1.0),
)  # fmt: skip
_LONG_S, _SHORT_S = 0.018, 0.016  # picture times above, and below, which the level is changed
_CARD_LONG_S, _CARD_SHORT_S = 0.012, 0.010  # so that a card reaches 60 pictures a second in all
_SOON, _LATE = 2, 64  # least and greatest number of fast judgements before a better level is tried
_JUDGED = 5  # pictures per judgement, of which the median counts
_MANY_PIECES = 60  # patches above which the object is drawn coarsely while the view moves
_RECENT = 20  # pictures averaged in `picture_s`
_APART = 1.5  # two boxes are joined if the joint one has at most so many times their pixels


class LivePicture:
    """The picture of a scene, updated step by step as the scene changes.

    Parameters
    ----------
    scene : LiveScene
    prepare : callable
        Called with the most triangles that a coarse object may have; sets such an object
        (`LiveScene.set_coarse`) and returns whether it could.

    Attributes
    ----------
    picture_s : float
        Mean duration of the last pictures with something new, s; 0 before the first.
    changed : Box or None
        Pixels in which the last picture differs from the one before.
    """

    def __init__(self, scene: LiveScene, prepare: Callable[[int], bool]) -> None:
        self._scene, self._prepare = scene, prepare
        self._stale, self._turns = True, False
        self._object: list[Box] = []
        self._front: list[Box] = []
        self._cells = np.zeros((0, 0), np.uint8)
        self._front_is_fine = True
        self._turned, self._moved = -math.inf, time.perf_counter()
        self._took: deque[float] = deque(maxlen=_RECENT)
        soft = scene.is_software
        self._levels = _LEVELS if soft else _CARD_LEVELS
        self._long_s = _LONG_S if soft else _CARD_LONG_S
        self._short_s = _SHORT_S if soft else _CARD_SHORT_S
        self._level, self._wholes = 0, list[float]()
        self._well, self._wait, self._is_tried = 0, _SOON, False
        self.changed: Box | None = None

    @property
    def picture_s(self) -> float:
        """Mean duration of the last pictures with something new, s; 0 before the first."""
        return sum(self._took) / len(self._took) if self._took else 0.0

    def touch(self) -> None:
        """Mark everything for redrawing: the camera or the appearance has changed."""
        self._stale = self._turns = True

    def touch_object(self, box: Box | None) -> None:
        """Mark the object for redrawing within a box."""
        if box is not None:
            self._object.append(box)

    def touch_front(self, box: Box | None) -> None:
        """Mark what is in front of the object for redrawing within a box."""
        if box is not None:
            self._front.append(box)

    def is_done(self) -> bool:
        """Return whether nothing is left to draw."""
        return not (self._stale or self._object or self._front or self._left().any())

    def draw(self) -> NDArray[np.uint8] | None:
        """Do one step; return (H, W, 4) uint8 pixels, bottom row first, or None if unchanged."""
        started, scene = time.perf_counter(), self._scene
        if self._stale:
            moves = self._turns and self._is_moving(started)
            self._stale = self._turns = False
            self._turned = self._moved = started
            pixels = self._draw_all(started, moves=moves)
            self._judge(scene.frame_s)
            return pixels
        if scene.is_lost and (self._object or self._front or self._is_settled(started)):
            # Stay at reduced detail while the view moves, or the picture flickers between the two.
            moves = self._is_reduced() and self._is_moving(started)
            return self._draw_all(started, moves=moves)
        boxes = self._take_boxes()
        for box in boxes:
            scene.draw_object(box)
            # Its cells are now plain at best; a cell that is rough in other parts stays so.
            x0, y0, x1, y1 = box
            part = self._cells[y0 // _CELL : -(-y1 // _CELL), x0 // _CELL : -(-x1 // _CELL)]
            np.maximum(part, _PLAIN, out=part)
        boxes += self._front
        self._front.clear()
        if boxes:
            self._moved = started
        fine = not boxes and started - self._moved >= _CALM_S
        boxes += self._improve(started, fine)
        if fine and not boxes and not self._front_is_fine:
            boxes = [scene.whole]
        if not boxes:
            return None
        return self._show(joined_box(boxes), started, fine=fine)

    def draw_whole(self, *, fine: bool) -> NDArray[np.uint8]:
        """Redraw everything at full detail; return (H, W, 4) uint8 pixels."""
        pixels = self._scene.draw(fine=fine)
        self._stale = True
        return pixels

    def draw_by_parts(self, *, fine: bool) -> Iterator[tuple[float, AnyArray]]:
        """Redraw everything as `draw_whole` does, but yield after each part, so it can be aborted.

        Yields
        ------
        float
            The fraction that is drawn, up to 1.
        (H, W, 4) uint8
            Pixels; the next part changes them.
        """
        width, height = self._scene.size
        corners = [(x, y) for y in range(0, height, _PART) for x in range(0, width, _PART)]
        for k, (x, y) in enumerate(corners):
            box = x, y, min(x + _PART, width), min(y + _PART, height)
            self._scene.draw_object(box, fine=fine)
            pixels = self._scene.show(box, fine=fine)
            self._stale = True
            yield (k + 1) / len(corners), pixels

    def _show(
        self, box: Box | None, started: float, *, fine: bool = False, keep: bool = True
    ) -> AnyArray:
        pixels = self._scene.show(box, fine=fine, keep=keep)
        self._front_is_fine = fine and box == self._scene.whole
        self.changed = box
        if not fine:
            self._took.append(time.perf_counter() - started)
        return pixels

    def _is_settled(self, now: float) -> bool:
        """Return whether the view has stood still for a while."""
        return now - self._turned >= _SETTLED_S

    def _is_moving(self, now: float) -> bool:
        """Return whether the view moves."""
        return not self._is_settled(now)

    def _is_reduced(self) -> bool:
        """Return whether a moving view is drawn with less detail than one at rest."""
        if self._scene.is_software:
            return self._levels[self._level][1] < 1.0
        return self._level > 0

    def _draw_all(self, started: float, *, moves: bool = False) -> AnyArray:
        """Redraw everything; of a moving view the picture is not kept, as the next will differ."""
        scene, (many, share) = self._scene, self._levels[self._level]
        share = share if moves else 1.0
        self._object.clear()
        self._front.clear()
        n_triangles, n_pieces = scene.seen()
        heavy = n_triangles > many or (n_pieces > _MANY_PIECES and many < math.inf)
        coarse = (scene.is_software or moves) and heavy and self._prepare(int(many))
        scene.draw_object(coarse=coarse, share=share)
        columns, rows = (-(-pixels // _CELL) for pixels in scene.size)
        rough = coarse or share < 1.0
        self._cells = np.full((rows, columns), _ROUGH if rough else _PLAIN, np.uint8)
        return self._show(None, started, keep=not moves)

    def _judge(self, took_s: float) -> None:
        """Adapt the level of detail of a moving view to the time that its pictures take.

        A better level is tried after some fast pictures; each failed trial doubles the wait for
        the next.
        """
        self._wholes.append(took_s)
        if len(self._wholes) < _JUDGED:
            return
        middle = sorted(self._wholes)[_JUDGED // 2]
        self._wholes.clear()
        self._well = self._well + 1 if middle < self._short_s else 0
        if middle > self._long_s:
            self._level = min(self._level + 1, len(self._levels) - 1)
            if self._is_tried:
                self._wait = min(2 * self._wait, _LATE)
            self._is_tried = False
        elif self._is_tried:
            self._wait, self._is_tried = _SOON, False
        elif self._level > 0 and self._well >= self._wait:
            self._level, self._well, self._is_tried = self._level - 1, 0, True

    def _improve(self, started: float, fine: bool) -> list[Box]:
        """Redraw some cells at a better state; return their boxes."""
        scene, left = self._scene, self._left()
        if not left.any() or not self._is_settled(started):
            return []
        rough = self._cells == _ROUGH
        if rough.any():
            if scene.seen()[0] <= _MANY or not scene.is_software:
                scene.draw_object()
                self._cells[:] = _PLAIN
                return [scene.whole]
            return self._step(rough, started, _PLAIN)
        return self._step(left, started, _FINE) if fine else []

    def _step(self, cells: AnyArray, started: float, state: int) -> list[Box]:
        """Draw cells until the time of a step is used up."""
        boxes = []
        width, height = self._scene.size
        for row, column in np.argwhere(cells):
            x, y = column * _CELL, row * _CELL
            box = x, y, min(x + _CELL, width), min(y + _CELL, height)
            draw = self._scene.smooth if state == _FINE else self._scene.draw_object
            draw(box)
            self._cells[row, column] = state
            boxes.append(box)
            if time.perf_counter() - started > _STEP_S:
                break
        return boxes

    def _left(self) -> NDArray[np.bool_]:
        """Return which cells (R, C) can still be improved."""
        return self._cells > (_BEST if self._scene.is_software else _PLAIN)

    def _take_boxes(self) -> list[Box]:
        """Return and clear the boxes in which to redraw the object, joining near ones."""
        taken, self._object = self._object, []
        joined: list[Box] = []
        for box in taken:
            for k, other in enumerate(joined):
                around = joined_box((box, other))
                if around is not None and _pixels(around) <= _APART * (
                    _pixels(box) + _pixels(other)
                ):
                    joined[k] = around
                    break
            else:
                joined.append(box)
        return joined


def _pixels(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])

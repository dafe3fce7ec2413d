"""What of a scene to draw next, so that no picture takes long and all of it is fine in the end.

While the view moves, an object of many triangles is drawn coarsely, by a graphics card only where
that takes long, and in software by fewer pixels where it still does. Where it stands still, it is
drawn to the last triangle, cell by cell of the picture, a few at a time; and once nothing moves any
more, software renderers smooth its edges in the same way. What changes meanwhile comes first: a
hand never waits for more than one step.
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

_CELL = 160  # pixels
_PART = 640  # pixels of a picture that is drawn part by part
_FINE, _PLAIN, _ROUGH = 0, 1, 2  # edges smoothed; every triangle; coarse
_SETTLED_S = 0.15  # after the view moved: then all triangles are drawn,
_CALM_S = 0.35  # and after anything moved: then edges are smoothed
_STEP_S = 0.025  # what may be spent on that at once
_MANY = 120_000  # triangles: more are drawn coarsely while the view moves,
_TOO_MANY = 700_000  # and of more the edges are not smoothed
_Levels = tuple[tuple[float, float], ...]
_LEVELS: _Levels = (  # while the view moves: triangles that may be drawn, share of pixels per side
    (_MANY, 1.0), (60_000, 1.0), (60_000, 2 / 3), (30_000, 2 / 3), (30_000, 0.5),
)  # fmt: skip
_CARD_LEVELS: _Levels = (  # where a card draws: all of them while that is quick enough
    (math.inf, 1.0), (_MANY, 1.0), (60_000, 1.0), (30_000, 1.0),
)  # fmt: skip
_LONG_S, _SHORT_S = 0.018, 0.016  # that such a picture may take, and may well take;
_CARD_LONG_S, _CARD_SHORT_S = 0.012, 0.010  # so that a card gives 60 a second, all else included
_SOON, _LATE = 2, 64  # judgements that were well, after which a better level is tried again
_JUDGED = 5  # pictures, of which the middle one counts
_MANY_PIECES = 60
_RECENT = 20  # pictures
_APART = 1.5  # boxes are drawn one by one if the one around both has more pixels than so


class LivePicture:
    """The picture of a scene, kept up with what changes in it.

    Parameters
    ----------
    scene : LiveScene
    prepare : callable
        Called with how many triangles may be drawn where the object is drawn coarsely; gives
        the scene a coarse object that fits (`LiveScene.set_coarse`), and tells whether it could.

    Attributes
    ----------
    picture_s : float
        What a picture takes that shows something new, s: the mean of the last ones.
    changed : Box or None
        What the last picture shows otherwise than the one before.
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
        """See above; 0 before the first."""
        return sum(self._took) / len(self._took) if self._took else 0.0

    def touch(self) -> None:
        """Have everything drawn anew: it is seen from elsewhere, or otherwise."""
        self._stale = self._turns = True

    def touch_object(self, box: Box | None) -> None:
        """Have the object drawn anew within a box."""
        if box is not None:
            self._object.append(box)

    def touch_front(self, box: Box | None) -> None:
        """Have what is in front of the object drawn anew within a box."""
        if box is not None:
            self._front.append(box)

    def is_done(self) -> bool:
        """Whether nothing is left to draw."""
        return not (self._stale or self._object or self._front or self._left().any())

    def draw(self) -> NDArray[np.uint8] | None:
        """(H, W, 4) uint8 pixels, the first row at the bottom; None if nothing has changed."""
        started, scene = time.perf_counter(), self._scene
        if self._stale:
            moves = self._turns and self._is_moving(started)
            self._stale = self._turns = False
            self._turned = self._moved = started
            pixels = self._draw_all(started, moves=moves)
            self._judge(scene.frame_s)
            return pixels
        if scene.is_lost and (self._object or self._front or self._is_settled(started)):
            moves = self._draws_less() and self._is_moving(started)
            return self._draw_all(started, moves=moves)  # or it is now blurred, now sharp
        boxes = self._take_boxes()
        for box in boxes:
            scene.draw_object(box)
            self._mark(box, _PLAIN)
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
        """(H, W, 4) uint8 pixels, all of them drawn anew to the last triangle."""
        pixels = self._scene.draw(fine=fine)
        self._stale = True
        return pixels

    def draw_by_parts(self, *, fine: bool) -> Iterator[tuple[float, AnyArray]]:
        """Draw all anew as `draw_whole` does, and yield after each part, so that it can be left.

        Yields
        ------
        float
            The share that is drawn, up to 1.
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
        """Whether the view has stood still for a while."""
        return now - self._turned >= _SETTLED_S

    def _is_moving(self, now: float) -> bool:
        """Whether the view moves."""
        return not self._is_settled(now)

    def _draws_less(self) -> bool:
        """Whether a view that moves is drawn by less than the same one at rest, cells aside."""
        if self._scene.is_software:
            return self._levels[self._level][1] < 1.0
        return self._level > 0

    def _draw_all(self, started: float, *, moves: bool = False) -> AnyArray:
        """Draw all anew; of a view that moves soon again, so it is not kept."""
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
        """Draw less while the view moves if pictures take long, more if they do not.

        Whether more can be drawn is found by trying, and ever more seldom where it could not.
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
        """Draw some cells better than they are; return where."""
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
        """Draw cells for as long as a step may last."""
        boxes = []
        for row, column in np.argwhere(cells):
            box = self._cell_box(row, column)
            self._scene.draw_object(box, fine=state == _FINE)
            self._cells[row, column] = state
            boxes.append(box)
            if time.perf_counter() - started > _STEP_S:
                break
        return boxes

    def _left(self) -> NDArray[np.bool_]:
        """(R, C) bool: the cells that can be drawn better than they are."""
        best = _FINE
        if not self._scene.is_software or self._scene.seen()[0] > _TOO_MANY:
            best = _PLAIN
        return self._cells > best

    def _cell_box(self, row: int, column: int) -> Box:
        width, height = self._scene.size
        x, y = column * _CELL, row * _CELL
        return x, y, min(x + _CELL, width), min(y + _CELL, height)

    def _mark(self, box: Box, state: int) -> None:
        """Note that a box was drawn anew; cells of which a part is rough stay so."""
        x0, y0, x1, y1 = box
        part = self._cells[y0 // _CELL : -(-y1 // _CELL), x0 // _CELL : -(-x1 // _CELL)]
        np.maximum(part, state, out=part)

    def _take_boxes(self) -> list[Box]:
        """The boxes in which the object is to be drawn anew, those near each other joined."""
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

"""The hand over the canvas: it paints, hovers, steers the view, sizes the brush."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui

from paint3d.app.model.hand import Hand, PointerInput
from paint3d.app.window.canvas import Canvas
from paint3d.app.window.orbit import Orbit, pixel_ray
from paint3d.app.window.stage import Stage
from paint3d.app.window.touch import Touch
from paint3d.mesh.closest import ClosestPoints
from paint3d.view.camera import Camera

__all__ = ["CanvasHand"]

_SIZE_A_PIXEL = 1.006  # growth of the brush a pixel of a drag with F
_DOLLY = 0.02  # notches a pixel of a drag with the right button


class CanvasHand(QtCore.QObject):
    """Joins the canvas's events to the easel.

    Signals
    -------
    sized : float
        The brush is to be so many times as large.
    began, ended : ()
        Of a stroke.
    """

    sized = QtCore.Signal(float)
    began = QtCore.Signal()
    ended = QtCore.Signal()

    def __init__(self, canvas: Canvas, stage: Stage) -> None:
        super().__init__(canvas)
        self._canvas, self._stage = canvas, stage
        self.orbit: Orbit | None = None
        self.hand: Hand | None = None
        self.in_stroke = False
        self.sizing = False
        self._surface: ClosestPoints | None = None
        self._place: Touch | None = None
        self._from = QtCore.QPointF()
        self._notches = 0.0
        canvas.touched.connect(self.touch)
        canvas.steered.connect(self._steer)
        canvas.wheeled.connect(self._wheel)
        canvas.left.connect(self._leave)

    # -- the view ---------------------------------------------------------------------------

    def open(self) -> None:
        """Take another object in hand."""
        source = self._stage.easel.document.surface.source
        self.orbit = Orbit(source.vertices, self._aspect())
        self._surface = ClosestPoints(source)
        settings = self.hand.settings if self.hand is not None else None
        self.hand = Hand(self._surface, settings)
        self.in_stroke, self._place = False, None
        self._canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
        self._look()

    def frame(self, side: str | None = None) -> None:
        """See the whole object, from a side if one is named."""
        if self.orbit is not None:
            self.orbit.frame(side)
            self._look()

    def resized(self) -> None:
        """The canvas has another size."""
        if self.orbit is not None:
            self.orbit.aspect = self._aspect()
            self._look()

    @property
    def camera(self) -> Camera:
        """Where it looks from."""
        return self.orbit.camera

    def _look(self) -> None:
        self._stage.set_camera(self.orbit.camera)

    def _aspect(self) -> float:
        return self._canvas.width() / max(1, self._canvas.height())

    def _steer(self, what: str, event: QtGui.QMouseEvent) -> None:
        if self.orbit is None:
            return
        if what == "begin":
            self._from = event.position()
            self._canvas.setCursor(QtCore.Qt.CursorShape.ClosedHandCursor)
            return
        if what == "end":
            self._canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
            return
        moved, self._from = event.position() - self._from, event.position()
        if event.modifiers() & QtCore.Qt.KeyboardModifier.ShiftModifier:
            self.orbit.shift(moved.x(), moved.y(), self._canvas.height())
        elif event.buttons() & QtCore.Qt.MouseButton.RightButton:
            self.orbit.nearer(_DOLLY * (moved.x() - moved.y()))
        else:
            self.orbit.turn(moved.x(), moved.y())
        self._look()

    def _wheel(self, notches: float, x: float, y: float) -> None:
        if self.orbit is None:
            return
        if self.in_stroke:
            self._notches += notches
            return
        self.orbit.nearer(notches, self.point_at(x, y))
        self._look()

    def point_at(self, x: float, y: float) -> NDArray | None:
        """(3,) the place on the object seen at a pixel of the canvas, or None."""
        size = self._canvas.width(), self._canvas.height()
        origin, direction = pixel_ray(self.camera, size, x, y)
        hits = self._surface.cast(origin[None], direction[None])
        return hits.points[0] if hits.hit[0] else None

    # -- the brush --------------------------------------------------------------------------

    def touch(self, touch: Touch) -> None:
        """Follow the pen or mouse: paint while it is down, else show where it would."""
        easel = self._stage.easel
        if easel is None or self.orbit is None:
            return
        before, self._place = self._place, touch
        if self.sizing:
            if before is not None:
                self.sized.emit(_SIZE_A_PIXEL ** (touch.x - before.x))
            return
        event, brush = self._input(touch), easel.document.painter.brush
        if self.in_stroke and touch.down:
            easel.feed(self.hand.move(event, brush))
        elif self.in_stroke:
            self.lift()
        elif touch.down:
            self._begin(event)
        else:
            sample = self.hand.hover(event, brush)
            if sample is None:
                self._stage.hide_brush()
            else:
                easel.hover(sample)

    def _input(self, touch: Touch) -> PointerInput:
        camera = self.camera
        size = self._canvas.width(), self._canvas.height()
        origin, direction = pixel_ray(camera, size, touch.x, touch.y)
        right = np.cross(camera.focus - camera.position, camera.up)
        notches, self._notches = self._notches, 0.0
        return PointerInput(
            touch.time_ns,
            origin=origin,
            direction=direction,
            right=right / np.linalg.norm(right),
            up=camera.up,
            pressure=touch.pressure,
            x_tilt=math.degrees(touch.tilt_x),
            y_tilt=math.degrees(touch.tilt_y),
            rotation=math.degrees(touch.twist) if touch.twist else None,
            wheel=notches,
        )

    def _begin(self, event: PointerInput) -> None:
        easel = self._stage.easel
        samples = self.hand.begin(event, easel.document.painter.brush)
        if not samples:
            return
        self.in_stroke = True
        easel.post("begin_stroke")
        easel.feed(samples)
        self.began.emit()

    def lift(self) -> None:
        """End the stroke that is going on."""
        if not self.in_stroke:
            return
        self.in_stroke = False
        easel = self._stage.easel
        easel.feed(self.hand.end(self._place.time_ns, easel.document.painter.brush))
        easel.post("end_stroke")
        self.ended.emit()

    def cancel(self) -> None:
        """Take the stroke that is going on back."""
        if self.in_stroke:
            self.in_stroke = False
            self.hand.end(self._place.time_ns, self._stage.easel.document.painter.brush)
            self._stage.easel.post("cancel_stroke")
            self.ended.emit()

    def pick(self) -> None:
        """Dip the brush in what lies under the pointer."""
        if self._place is None or self._surface is None:
            return
        found = self.point_at(self._place.x, self._place.y)
        if found is None:
            return
        with self._stage.easel.paused() as document:
            away = document.surface.paint_mesh.vertices - found.astype(np.float32)
        nearest = int(np.argmin(np.einsum("ij,ij->i", away, away)))
        self._stage.easel.post("pick_colour", nearest)

    def _leave(self) -> None:
        if not self.in_stroke and self._stage.easel is not None:
            self._stage.hide_brush()

"""The hand over the canvas: it paints, hovers, steers the view, sizes the brush."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore

from paint3d.app.model.input import navigation
from paint3d.app.model.input.hand import Hand, HandSettings, PointerInput
from paint3d.app.window.hand.canvas import CanvasWidget, Touch
from paint3d.app.window.stage import Stage
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.sample import DeviceSample
from paint3d.mesh.bvh import ClosestPoints
from paint3d.view.camera import Camera, View, fit_camera, is_flat, picture_axes, studio_axes

__all__ = ["ADJUSTED", "CanvasHand"]

ADJUSTED = frozenset({"size", "force", "water", "lamp"})
"""Names of what a drag changes while a key is down."""

_SIZE_A_PIXEL = 1.006  # growth of the brush a pixel of a drag with F
_FORCE_A_PIXEL = 0.02  # N a pixel of a drag with Shift+F
_FIRST_VIEW = View((0.12, -1.0, 0.62))
_FLAT_VIEW = np.array([0.0, -0.45, 1.0])  # in the sheet's own axes
_BENDS_PX = 6.0  # a motion that gives the direction of the tuft's bend
_CLOSE = 0.75  # tuft lengths that are seen around the point under the pointer
_LEAST_SEEN_MM, _MOST_OBJECTS = 0.5, 10.0  # a picture is as high at least, and as high at most
_AT = 1.0 + 1e-6
_HIDDEN_MM = 1.0  # that the object may lie before a point that still counts as seen
_STAYS_PX = 6.0  # that a pointer moves which stays where it was


class CanvasHand(QtCore.QObject):
    """Joins the canvas's events to the painting thread.

    Signals
    -------
    sized : float
        Factor by which the brush is to be larger.
    watered : float
        Pixels of a drag by which its ink is to be lighter.
    lamp_turned : float
        Pixels of a drag by which the lamp is turned to the right.
    began : ()
        A stroke begins; emitted before it is posted to the painting thread.
    ended : Future
        Of `end_stroke`, by which the painting thread ends it.
    """

    sized = QtCore.Signal(float)
    watered = QtCore.Signal(float)
    lamp_turned = QtCore.Signal(float)
    began = QtCore.Signal()
    ended = QtCore.Signal(object)

    def __init__(self, canvas: CanvasWidget, stage: Stage) -> None:
        super().__init__(canvas)
        self._canvas, self._stage = canvas, stage
        self.camera: Camera | None = None
        self._whole: Camera | None = None
        self.hand: Hand | None = None
        self.settings = HandSettings()
        self._first_force = 1.5  # N, of a mouse
        self.in_stroke = False
        self.held: set[str] = set()
        self.adjusted = False
        self.erases = False  # whatever end of the pen
        self._surface: ClosestPoints | None = None
        self._last_touch: Touch | None = None
        self._spent = False  # a stroke was taken back whose pen is still down
        self._notches = 0.0
        self._under: tuple[float, float] | None = None  # where the brush is in a stroke, pixels
        self._bends_from: tuple[float, float] | None = None  # and since the mouse turns its bend
        self._bend: AnyArray | None = None  # direction that its tip is to point in, object's frame
        self._aside = (0.0, 0.0)  # pixels from the pointer to the brush that turned in place
        self._near: tuple[Camera, Touch, float] | None = None  # what `show_place` did last
        canvas.touched.connect(self.touch)
        canvas.taken_back.connect(self._take_back)
        canvas.resized.connect(self._resized)
        canvas.left.connect(self.leave)

    @property
    def open_camera(self) -> Camera:
        """`camera`, while something is open."""
        assert self.camera is not None, "something is open"
        return self.camera

    @property
    def surface(self) -> ClosestPoints:
        """The object's, while something is open."""
        assert self._surface is not None, "something is open"
        return self._surface

    @property
    def _open_hand(self) -> Hand:
        assert self.hand is not None, "something is open"
        return self.hand

    @property
    def force(self) -> float:
        """Force of a mouse, N."""
        return self._first_force if self.hand is None else self.hand.force

    def set_force(self, newtons: float) -> None:
        """Set a mouse's force, as far as a brush can be pressed."""
        self._first_force = min(MAX_FORCE_N, max(0.0, newtons))
        if self.hand is not None:
            self.hand.force = self._first_force

    # -- the view ---------------------------------------------------------------------------

    def open(self, surface: ClosestPoints) -> None:
        """Take another object in hand, the one on stage."""
        self._surface = surface
        self.hand = Hand(surface, self.settings, self.force)
        self.in_stroke = self._spent = False
        self._last_touch = None
        self._canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
        self.show_all()

    def set_settings(self, **changes: Any) -> None:
        """Change how the hand is read; see `HandSettings`."""
        self.settings = dataclasses.replace(self.settings, **changes)
        if self.hand is not None:
            self.hand.settings = self.settings

    def show_all(self) -> None:
        """Show the whole object, from where it is painted best."""
        points = self._stage.points
        view = _FIRST_VIEW
        if is_flat(points):
            axes = studio_axes(points, View((0.0, -0.6, 1.0)))
            view = View(axes.T @ _FLAT_VIEW, axes[1])
        self.look(fit_camera(points, view, self._aspect()))
        self._whole = self.camera

    def _resized(self) -> None:
        """Show the whole object again, unless the user has painted or moved the view since."""
        if self.camera is not None and self.camera is self._whole:
            self.show_all()

    def show_place(self) -> None:
        """Show the point under the pointer from near; asked again there, do nothing."""
        point, touch = self.place(), self._last_touch
        if point is None or touch is None:
            return
        radius = _CLOSE * self._stage.open_paint_thread.brush.length_mm
        if self._near is not None:
            camera, at, seen = self._near
            moved = math.hypot(touch.x - at.x, touch.y - at.y)
            if (self.camera, radius) == (camera, seen) and moved <= _STAYS_PX:
                return  # by now something else is under the pointer
        self.look(navigation.approach(self.open_camera, point, radius, self._aspect()))
        self._near = self.open_camera, touch, radius

    def look_from(self, side: str) -> None:
        """Show the whole object from one of `navigation.SIDES`."""
        view = View(*navigation.SIDES[side])
        self.look(fit_camera(self._stage.points, view, self._aspect()))

    def look(self, camera: Camera) -> None:
        """Move the camera, no nearer than a vertex and no farther than ten objects."""
        camera = self._within_reach(camera)
        self.camera = camera
        self._stage.set_camera(camera)

    def _within_reach(self, camera: Camera) -> Camera:
        """Return the camera, no nearer and no farther than there is something to see."""
        points = self._stage.points
        if not len(points):
            return camera
        distance = float(np.linalg.norm(camera.position - camera.focus))
        tall = 2.0 * math.tan(0.5 * camera.view_angle)  # of what is seen, over the distance
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        nearest, farthest = _LEAST_SEEN_MM / tall, _MOST_OBJECTS * size / tall
        if nearest <= distance <= farthest:
            return camera
        before = self.camera
        if before is not None:  # further in the same way nothing moves
            was = float(np.linalg.norm(before.position - before.focus))
            if (distance < nearest and was <= nearest * _AT) or (distance > farthest <= was * _AT):
                return before
        return navigation.dolly(camera, distance / min(max(distance, nearest), farthest))

    def _aspect(self) -> float:
        return self._canvas.width() / max(1, self._canvas.height())

    def _size(self) -> tuple[int, int]:
        return self._canvas.width(), self._canvas.height()

    def take_wheel(self, notches: float) -> bool:
        """Press by the wheel, during a stroke; False where there is none."""
        if self.in_stroke:
            self._notches += notches
        return self.in_stroke

    def meets(self, points: AnyArray) -> NDArray[np.bool_]:
        """Return (N,) bool: whether the object is seen at points (N, 2) of the picture, pixels."""
        assert self._surface is not None, "something is open"
        rays = [navigation.ray_at(self.open_camera, x, y, self._size()) for x, y in points]
        origins = np.array([ray.origin for ray in rays])
        return self._surface.cast(origins, np.array([ray.direction for ray in rays])).hit

    def place(self) -> AnyArray | None:
        """Return the point (3,) of the object under the pointer, or None."""
        return (
            None
            if self._last_touch is None
            else self.place_at(self._last_touch.x, self._last_touch.y)
        )

    def place_at(self, x: float, y: float) -> AnyArray | None:
        """Return the object's point (3,) at a point of the picture (pixels, y down), or None."""
        if self._surface is None:
            return None
        ray = navigation.ray_at(self.open_camera, x, y, self._size())
        hits = self._surface.cast(ray.origin[None], ray.direction[None])
        return hits.points[0] if hits.hit[0] else None

    def ray_at(self, x: float, y: float) -> navigation.Ray:
        """Return the ray of sight through a point of the picture (pixels, y down)."""
        return navigation.ray_at(self.open_camera, x, y, self._size())

    def sees(self, points: AnyArray) -> NDArray[np.bool_]:
        """Return (N,) bool: whether nothing of the object lies before points (N, 3) of it, mm."""
        eye = self.open_camera.position
        away = points - eye
        far = np.linalg.norm(away, axis=1)
        hits = self.surface.cast(np.tile(eye, (len(points), 1)), away / far[:, None])
        seen: NDArray[np.bool_] = np.linalg.norm(hits.points - eye, axis=1) > far - _HIDDEN_MM
        return seen | ~hits.hit

    def pixels_of(self, points: AnyArray) -> AnyArray:
        """Project points (N, 3), mm, onto the picture: (N, 2) pixels, y down."""
        return navigation.pixels_of(self.open_camera, points, self._size())

    # -- the brush --------------------------------------------------------------------------

    def touch(self, touch: Touch) -> None:
        """Follow the pen or mouse: paint while it is down, else show the brush there."""
        paint_thread = self._stage.paint_thread
        if paint_thread is None or self.camera is None:
            return
        before, self._last_touch = self._last_touch, touch
        self._spent = self._spent and touch.down
        if self._spent:
            return
        if before is not None and self.held & ADJUSTED and not self.in_stroke:
            self._adjust(touch.x - before.x)
            return
        event, brush = self._input(self._bent(touch)), paint_thread.brush
        if self.in_stroke and touch.down:
            paint_thread.feed(self._open_hand.move(event, brush))
        elif self.in_stroke:
            self.end_stroke(event)
        elif touch.down:
            self._begin(event, erase=self.erases or touch.eraser)
        else:
            sample = self._open_hand.hover(event, brush)
            if sample is None:
                self._stage.hide_brush()
            else:
                paint_thread.hover(sample)

    def _bent(self, touch: Touch) -> Touch:
        """Return the touch of the brush: with Shift the mouse turns its bend, and it stays.

        The pointer's motion meanwhile remains an offset between them until the stroke ends.
        """
        if not self.in_stroke:
            self._under, self._bends_from, self._bend, self._aside = None, None, None, (0.0, 0.0)
            if not touch.down:
                return touch
        x, y = touch.x + self._aside[0], touch.y + self._aside[1]
        stays = self._under or (x, y)
        if touch.bends and touch.down:
            start = self._bends_from = self._bends_from or stays
            across, down = x - start[0], y - start[1]
            if math.hypot(across, down) >= _BENDS_PX:
                right, up, _ = picture_axes(self.open_camera)
                self._bend = across * right - down * up
            x, y = stays
        elif self._bends_from is not None:
            if touch.down:
                self._bends_from = self._bend = None
            self._aside = (stays[0] - touch.x, stays[1] - touch.y)
            x, y = stays
        self._under = (x, y)
        return replace(touch, x=x, y=y)

    def _adjust(self, pixels: float) -> None:
        """Change by a drag what a key that is down names."""
        self.adjusted = True
        if "size" in self.held:
            self.sized.emit(_SIZE_A_PIXEL**pixels)
        elif "water" in self.held:
            self.watered.emit(pixels)
        elif "lamp" in self.held:
            self.lamp_turned.emit(pixels)
        else:
            self.set_force(self.force + _FORCE_A_PIXEL * pixels)

    def _input(self, touch: Touch) -> PointerInput:
        ray = navigation.ray_at(self.open_camera, touch.x, touch.y, self._size())
        right, up, _ = picture_axes(self.open_camera)
        notches, self._notches = self._notches, 0.0
        return PointerInput(
            touch.time_ns,
            origin=ray.origin,
            direction=ray.direction,
            right=right,
            up=up,
            pressure=touch.pressure,
            x_tilt=math.degrees(touch.tilt_x),
            y_tilt=math.degrees(touch.tilt_y),
            rotation=math.degrees(touch.twist) if touch.twist else None,
            wheel=notches,
            harder="harder" in self.held,
            softer="softer" in self.held,
            bend=self._bend,
        )

    def _begin(self, event: PointerInput, *, erase: bool) -> None:
        paint_thread = self._stage.open_paint_thread
        samples = self._open_hand.begin(event, paint_thread.brush)
        if samples is None:
            return
        self.in_stroke, self._whole = True, None
        self.began.emit()
        paint_thread.post("begin_stroke", **({"erase": True} if erase else {}))
        paint_thread.feed(samples)

    def end_stroke(self, event: PointerInput | None = None) -> None:
        """End the current stroke, where the pen was lifted if that is known."""
        if not self.in_stroke:
            return
        self.in_stroke = False
        paint_thread = self._stage.open_paint_thread
        paint_thread.feed(self._end_in_hand(event))
        self.ended.emit(paint_thread.post("end_stroke"))

    def _end_in_hand(self, event: PointerInput | None = None) -> list[DeviceSample]:
        """End the hand's stroke where the pointer was last; return samples still to be painted."""
        assert self._last_touch is not None, "a stroke goes on"
        return self._open_hand.end(
            self._last_touch.time_ns, self._stage.open_paint_thread.brush, event
        )

    def interrupt(self) -> None:
        """End the current stroke where it is; a pen that stays down begins no other."""
        if self.in_stroke:
            self.end_stroke()
            self._spent = True

    def cancel(self) -> None:
        """Take back the current stroke."""
        if self.in_stroke:
            self.in_stroke, self._spent = False, True
            self._end_in_hand()
            self._stage.open_paint_thread.post("cancel_stroke")

    def _take_back(self) -> None:
        """Take back a finger's stroke that became a gesture: the next touch paints again."""
        self.cancel()
        self._spent = False

    def leave(self) -> None:
        """Hide the brush until the pointer moves over the picture again."""
        if not self.in_stroke and self._stage.paint_thread is not None:
            self._stage.hide_brush()

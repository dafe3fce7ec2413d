"""The stage: the painted object, the brush and the camera, kept up with the painting thread.

Here alone the painting thread's document and the renderer meet: between two of its steps
the document is held still while what has changed is copied, patch by patch; then it paints on while
the renderer works.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.frame import BrushView, PaintingFrame, view_brush
from paint3d.app.model.mask import Stencil
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder
from paint3d.app.window.files.open_result import OpenResult
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.device.sample import DeviceSample
from paint3d.pose.brush_pose import object_poses
from paint3d.view.brush_shape import BrushStand
from paint3d.view.camera import Camera
from paint3d.view.live_brush import LiveBrush
from paint3d.view.live_layers import Box
from paint3d.view.live_light import BakedLight, LiveLight
from paint3d.view.live_object import LiveObject
from paint3d.view.live_picture import LivePicture
from paint3d.view.live_scene import LIGHT, Background, LiveScene
from paint3d.view.studio import Gloss
from paint3d.view.vtk_parts import DrawnMesh

__all__ = ["Stage"]

_PATIENCE_S = 0.02  # that the picture waits for a step of the painting
_NONE = np.empty(0, np.int32)
_NOWHERE = object()
_NO_POINTS = np.empty((0, 3))
_APART_MM, _JUMP_MM = 1.0, 60.0  # between points of a stroke; farther is another stroke
_MOST_POINTS = 300
_LITTLE = 0.03  # of the picture, that changed lines may cover before all of it is drawn again
_LIVELY_S = 5.0  # after the hand has rested so long, ink that runs by itself is drawn less often:
_LEAST, _RAREST_S = 0.008, 30.0  # in a fraction of the time that falls with the square of the rest


class Stage:
    """A scene that follows one document at a time.

    Parameters
    ----------
    size : (int, int)
        Width and height, pixels.
    mood : Background

    Attributes
    ----------
    paint_thread : PaintThread or None
    frame : PaintingFrame or None
        The last one.
    points : (N, 3) float32
        Of the object, to place the camera by, mm.
    light : (str, float)
        See `LiveLight.setting`.
    as_filmed : bool
        Whether the next brush is drawn for those who look on; see `LiveBrush`.
    """

    def __init__(self, size: tuple[int, int], mood: Background = LIGHT) -> None:
        self.scene = LiveScene(size, mood)
        self.paint_thread: PaintThread | None = None
        self.frame: PaintingFrame | None = None
        self.points: AnyArray = np.empty((0, 3), np.float32)
        self.shows_brush = self.shows_mask = True
        self.as_filmed = False
        self._stencil: Stencil | None = None
        self._object: LiveObject | None = None
        self._brush: LiveBrush | None = None
        self._brush_spec: BrushSpec | None = None
        self._lines: dict[str, DrawnMesh] = {}
        self._line_parts: dict[str, dict[tuple[Any, ...], AnyArray]] = {}
        self._baker = ThreadPoolExecutor(1, thread_name_prefix="paint3d-light")
        self._baking: Future[BakedLight] | None = None
        self._unlit: LiveLight | None = None
        self.light: tuple[str, float] = ("studio", 0.0)
        self._drawn = LivePicture(self.scene, self._prepare_coarse)
        self._pending: list[AnyArray] = []
        self._brush_state: tuple[Any, ...] = ()
        self._taken_s = self._cost_s = 0.0  # when the last frame was taken, and what it took since
        self._seen: BrushView | None = None
        self._seen_at: DeviceSample | None = None
        self._seen_from: PaintingFrame | None = None
        self._left_at: DeviceSample | object = _NOWHERE
        self._painted: list[AnyArray] = []  # points where the brush was pressed last, mm
        self._brush_camera: Camera | None = None

    # -- one document -----------------------------------------------------------------------

    def open(
        self,
        opened: OpenResult,
        *,
        wet: bool = False,
        recovery: RecoveryFolder | None = None,
        autosave_interval_s: float = 120.0,
    ) -> None:
        """Put another document on stage, and close the one before.

        Parameters
        ----------
        opened : OpenResult
        wet : bool
            Let ink spread and dry in real time.
        recovery : RecoveryFolder, optional
            The painting is saved there until it has a file.
        autosave_interval_s : float
            See `PaintThread`.
        """
        self.close_document()
        self.points = opened.points
        shown = self._object = opened.shown
        material = opened.document.surface.material
        grain = material.grain if material.tooth_mm > 0.0 else 0.0
        paper = Gloss.of(material).paper
        gloss = Gloss(material.roughness, material.coat, grain, material.wave_mm, paper)
        self.scene.clear(shown.centre, shown.radius, gloss, solid=shown.is_solid)
        self.scene.apply(opened.uploads)
        self._unlit = shown.light
        self.light = shown.light.setting
        self.paint_thread = PaintThread(opened.document, wet, recovery, autosave_interval_s)
        self.touch()

    def close_document(self) -> None:
        """Empty the stage; what still waits is not painted any more."""
        if self.paint_thread is not None:
            self.paint_thread.stop(finish=False)
        if self._brush is not None:
            self._brush.remove()
        for name in list(self._lines):
            self.show_lines(name, (), (0, 0, 0, 0))
        self.paint_thread = self.frame = self._object = self._brush = None
        self._brush_spec, self._brush_state, self._pending = None, (), []
        self._stencil = self._unlit = self._baking = None
        self._seen = self._seen_at = self._seen_from = None
        self._left_at = _NOWHERE
        self._painted = []

    def close(self) -> None:
        """Release everything."""
        self.close_document()
        self._baker.shutdown(wait=True, cancel_futures=True)
        self.scene.close()

    @property
    def open_paint_thread(self) -> PaintThread:
        """`paint_thread`, while something is open."""
        assert self.paint_thread is not None, "something is open"
        return self.paint_thread

    @property
    def _open_object(self) -> LiveObject:
        assert self._object is not None, "something is open"
        return self._object

    @property
    def is_lit(self) -> bool:
        """True if the soft light has been computed."""
        return self._baking is None and self._unlit is None

    # -- frame by frame ---------------------------------------------------------------------

    def set_camera(self, camera: Camera) -> None:
        """Draw from another camera."""
        self.scene.set_camera(camera)
        self.touch()

    def set_size(self, size: tuple[int, int]) -> None:
        """Draw in another size, pixels."""
        if size != self.scene.size:
            self.scene.set_size(size)
            self.touch()

    def set_mood(self, mood: Background) -> None:
        """Change the colours around the object."""
        self.scene.set_mood(mood)
        self.touch()

    def set_light(self, kind: str, turn: float) -> None:
        """Show the object in another light: at once, and with soft shadows when they are baked."""
        if (kind, turn) != self.light and self._object is not None:
            self.light = kind, turn
            self._object.change_light(self.light)
            self._unlit = self._object.light
            self._pending.append(_NONE)
            self.touch()

    def touch(self) -> None:
        """Draw all again with the next picture."""
        self._drawn.touch()

    @property
    def rested_s(self) -> float:
        """Time since the last command of the painting or motion of the hand, s."""
        if self.paint_thread is None or self.paint_thread.is_behind:
            return 0.0
        return time.monotonic() - self.paint_thread.last_asked_s

    def follow(self) -> PaintingFrame | None:
        """Take what the painting thread has done since the last time; None if nothing.

        The longer the hand has rested, the slower wet ink runs, and the less often it is taken.
        """
        started = time.thread_time()
        try:
            return self._follow()
        finally:
            self._cost_s += time.thread_time() - started

    def _follow(self) -> PaintingFrame | None:
        if self.paint_thread is None:
            return None
        self._take_light()
        self._take_mask()
        if self.paint_thread.wet and not self._pending:
            now, rested_s = time.monotonic(), max(_LIVELY_S, self.rested_s)
            fraction = max(_LEAST, (_LIVELY_S / rested_s) ** 2)
            pause_s = min(self._cost_s / fraction, _RAREST_S)
            if rested_s > _LIVELY_S and now - self._taken_s < pause_s:
                return None
            self._taken_s, self._cost_s = now, 0.0
        frame = self.paint_thread.take_frame()
        if frame is None:
            if self._pending:
                self._upload_changes()
            return None
        self._pending.append(frame.vertex_ids)
        if self._pending[1:] or len(frame.vertex_ids) or frame.has_grown:
            self._upload_changes()
        else:
            self._pending.clear()
        self.frame = frame
        return frame

    def draw(self) -> NDArray[np.uint8] | None:
        """Return (H, W, 4) uint8 pixels, the first row at the bottom; None if nothing has changed.

        The brush is drawn where the hand is now, also where the painting has not come there yet.
        """
        started = time.thread_time()
        self._place_brush()
        pixels = self._drawn.draw()
        self._cost_s += time.thread_time() - started
        return pixels

    @property
    def changed(self) -> Box | None:
        """The pixels in which the last picture differs from the one before."""
        return self._drawn.changed

    @property
    def brush_box(self) -> Box | None:
        """The pixels that the brush is seen in; None where it is not in the picture."""
        return None if self._brush is None else self._brush.screen_box()

    @property
    def picture_s(self) -> float:
        """Time that a picture takes that shows something new, s; see `LivePicture`."""
        return self._drawn.picture_s

    @property
    def is_drawn(self) -> bool:
        """True if the last picture is complete and as fine as it becomes."""
        return self._drawn.is_done()

    def picture(self, *, fine: bool = True) -> NDArray[np.uint8]:
        """Return (H, W, 4) uint8 pixels as they are now, the first row at the bottom."""
        self._place_brush()
        return self._drawn.draw_whole(fine=fine)

    def picture_by_parts(self, *, fine: bool = True) -> Iterator[tuple[float, AnyArray]]:
        """Yield the same part by part, with the fraction drawn; nothing else is drawn meanwhile."""
        self._place_brush()
        return self._drawn.draw_by_parts(fine=fine)

    def _upload_changes(self) -> None:
        """Copy what has changed, or leave it for later while a step of the painting lasts."""
        with self.open_paint_thread.paused(_PATIENCE_S) as document:
            if document is None:
                return
            ids = np.concatenate([*self._pending, document.refresh()])
            uploads = self._open_object.uploads(ids)
            coarse = self._open_object.repaint_coarse()
        self._pending.clear()
        for points in self.scene.apply(uploads):
            self._drawn.touch_object(self.scene.screen_box(points))
        if coarse is not None:
            self.scene.recolour_coarse()

    def _prepare_coarse(self, n_triangles: int) -> bool:
        """Prepare a coarse object for the scene; return whether there is one."""
        if self._pending:
            self._upload_changes()
        pixel_mm = self.scene.nearest_mm()
        if self._open_object.coarse_fits(pixel_mm, n_triangles):
            return True
        with self.open_paint_thread.paused(_PATIENCE_S) as document:
            if document is None or self._pending:
                return self.scene.has_coarse
            coarse = self._open_object.coarse_for(pixel_mm, n_triangles)
        if coarse is not None:
            self.scene.set_coarse(coarse)
        return self.scene.has_coarse  # none yet where painting has just added vertices

    def _take_light(self) -> None:
        """Show soft light once it is baked, which begins when the first picture is there."""
        if self._unlit is not None and self._baking is None:
            self._baking, self._unlit = self._baker.submit(self._unlit.bake), None
        if self._baking is None or not self._baking.done():
            return
        baked, self._baking = self._baking.result(), None
        if baked.setting != self.light:
            return  # another one was chosen meanwhile
        self._open_object.relight(baked)
        self.scene.set_ground(baked)
        self._pending.append(_NONE)
        self.touch()

    def _take_mask(self) -> None:
        """Hatch the object where another mask than before covers it."""
        stencil = self.open_paint_thread.painting.stencil if self.shows_mask else None
        if stencil is self._stencil:
            return
        self._stencil = stencil
        self._open_object.veil(None if stencil is None else stencil.covers)
        self._pending.append(_NONE)
        self.touch()

    # -- lines on the object ----------------------------------------------------------------

    def show_lines(
        self, name: str, lines: Sequence[AnyArray], colour: tuple[int, ...], width: float = 1.5
    ) -> None:
        """Draw lines (K, 3), mm, on the object, instead of those of that name.

        Parameters
        ----------
        name : str
        lines : sequence of (K, 3)
            Empty to remove them.
        colour : (4,) of 0 to 255
            sRGB and density.
        width : float
            Pixels.
        """
        drawn = None
        if len(lines):
            drawn = DrawnMesh()
            drawn.set_lines(lines)
            drawn.set_colours(np.tile(np.array(colour, np.uint8), (sum(map(len, lines)), 1)))
            drawn.actor.GetProperty().SetLineWidth(width)
        self._show_on_object(name, drawn, lines, (colour, width))

    def show_faces(
        self, name: str, points: AnyArray, faces: AnyArray, colour: tuple[int, ...]
    ) -> None:
        """Draw triangles on the object, instead of those of that name.

        Parameters
        ----------
        name : str
        points : (K, 3)
            mm.
        faces : (L, 3)
            Empty to remove them.
        colour : (4,) of 0 to 255
            sRGB and density.
        """
        drawn = None
        if len(faces):
            drawn = DrawnMesh()
            drawn.set_shape(points, faces)
            drawn.set_colours(np.tile(np.array(colour, np.uint8), (len(points), 1)))
        self._show_on_object(name, drawn, [points] if len(faces) else [], (colour, faces.tobytes()))

    def _show_on_object(
        self, name: str, drawn: DrawnMesh | None, parts: Sequence[AnyArray], look: tuple[Any, ...]
    ) -> None:
        """Show this, or nothing, instead of what has that name.

        Of its parts (K, 3), mm, those that are new or gone, or of another look, are drawn again.
        """
        old = self._lines.pop(name, None)
        if old is not None:
            self.scene.remove(old)
        if drawn is not None:
            self._lines[name] = drawn
            drawn.actor.GetProperty().LightingOff()
            drawn.actor.ForceTranslucentOn()
            drawn.draw_before()
            self.scene.add(drawn)
        before = self._line_parts.pop(name, {})
        now = self._line_parts[name] = {(look, part.tobytes()): part for part in parts}
        self._touch_near([(before | now)[key] for key in before.keys() ^ now.keys()])

    def _touch_near(self, parts: Sequence[AnyArray]) -> None:
        """Draw again around some points; where that is much of the picture, all of it."""
        boxes = [box for box in map(self.scene.screen_box, parts) if box is not None]
        width, height = self.scene.size
        if sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in boxes) > _LITTLE * width * height:
            self.touch()
        for box in boxes:
            self._drawn.touch_object(box)

    # -- the brush --------------------------------------------------------------------------

    def _place_brush(self) -> None:
        """Place the brush for the next picture."""
        if self.frame is not None:
            self._show_brush(self._brush_now(self.frame))

    def _brush_now(self, frame: PaintingFrame) -> BrushView | None:
        """Return the brush where the hand was last, bent anew unless the painting is busy."""
        seen, newest = frame.brush, self.open_paint_thread.newest
        if newest is self._left_at:
            return None
        if seen is None or newest is None:
            return seen
        if newest is self._seen_at and frame is self._seen_from:
            return self._seen
        self._seen_from = frame
        pose = object_poses([newest])
        shift = pose.position[0] - seen.position
        if not shift.any() and np.array_equal(pose.orientation[0], seen.orientation):
            self._seen, self._seen_at = seen, newest
        if newest is not self._seen_at:
            with self.open_paint_thread.paused(0.0) as document:
                if document is not None:
                    self._seen = view_brush(document, newest)
                else:  # it paints: the brush as it was bent, moved
                    pressed = seen.pressed
                    if pressed is not None:
                        pressed = dataclasses.replace(pressed, origin=pressed.origin + shift)
                    self._seen = dataclasses.replace(
                        seen, position=seen.position + shift, pressed=pressed
                    )
            self._seen_at = newest
        return self._seen

    def _show_brush(self, seen: BrushView | None) -> None:
        """Draw the brush, if its position, its bend or its look has changed."""
        painting = self.open_paint_thread.painting
        state: tuple[Any, ...] = (painting.brush, self.shows_brush)
        if seen is not None:
            look = (seen.pressure, seen.load, *seen.srgb, seen.painting)
            state += (*seen.position, *seen.orientation, *look)
            state += seen.pressed.numbers if seen.pressed is not None else ()
        if state == self._brush_state and self._brush_camera is self.scene.camera:
            return
        self._brush_state, self._brush_camera = state, self.scene.camera
        if self._brush is None or self._brush_spec != painting.brush:
            if self._brush is not None:
                self._drawn.touch_front(self.brush_box)
                self._brush.remove()
            spec = painting.brush
            self._brush = LiveBrush(
                self.scene, painting.tuft, spec.hair, painting.bristles, self.as_filmed
            )
            self._brush_spec = painting.brush
        self._drawn.touch_front(self._brush.screen_box())
        if seen is None or not self.shows_brush:
            self._brush.hide()
            return
        if seen.painting and seen.pressed is not None:
            self._add_painted(seen.pressed.origin)
        axes = matrices_from_quaternions(seen.orientation[None])[0]
        stand = BrushStand.of(painting.tuft, seen.position, axes, seen.pressed)
        red, green, blue = (int(code) for code in seen.srgb)
        self._brush.show(
            stand,
            painting.contact_tree,
            self._open_object.light.axes,
            (red, green, blue),
            seen.load,
            np.concatenate(self._painted) if self._painted else _NO_POINTS,
        )
        self._drawn.touch_front(self._brush.screen_box())

    def _add_painted(self, point: AnyArray) -> None:
        """Add a point that is painted now, which the brush is not to hide."""
        last = self._painted[-1][-1] if self._painted else point
        distance = float(np.linalg.norm(point - last))
        if self._painted and distance < _APART_MM:
            return
        n = max(1, round(distance / _APART_MM)) if distance < _JUMP_MM else 1
        fractions = np.arange(1, n + 1)[:, None] / n
        self._painted.append(last + fractions * (point - last))
        del self._painted[:-_MOST_POINTS]

    def hide_brush(self) -> None:
        """Hide the brush until the hand moves again."""
        if self.paint_thread is not None:
            self._left_at = self.paint_thread.newest

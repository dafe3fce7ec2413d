"""A painting in the studio: the object, the brush, its strokes, and the way back.

No window, no thread and no clock: whoever calls says when. `paint3d.app.model.easel` runs one of
these in a thread of its own.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.brush_size import resized, scaled, stepped
from paint3d.app.model.image_painter import ImagePainter
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.stroke_log import Stroke, StrokeLog, weights_of
from paint3d.app.model.symmetry import Symmetry
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.errors import ExportError, InputError, SessionError
from paint3d.files.export import check_export_path, export
from paint3d.files.load import load_mesh
from paint3d.files.session import Session, is_session_path, load_session, save_session
from paint3d.ink.materials import Material
from paint3d.ink.pigments import Pigment
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.stroke.engine import Painter
from paint3d.surface.layer_stack import Layer, LayerStack
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import MEMORY_BUDGET, UndoHistory

__all__ = ["Document"]

Ink = str | Pigment | Mapping
_BRUSH, _INKS = "full", ("pine soot", "cinnabar")


class Document:
    """One painting, with everything that can be done to it.

    Make it with `Document.new` or `Document.open`.

    Attributes
    ----------
    surface : PaintedSurface
    painter : Painter
    path : Path or None
        The session's file, once there is one.
    unit : str
        Of lengths as they are shown: "mm", "cm", "m" or "in".
    inks : list of two inks
        The one the brush is dipped in, and the one that `swap_inks` takes.
    symmetry : Symmetry
        Images of every stroke; see `set_symmetry`.
    mask : Mask
        Where paint is taken; see `set_mask`.
    settings : dict
        Anything else that is to be kept with the painting, as JSON holds it.
    modified : bool
        Whether something changed since it was saved.
    """

    def __init__(
        self,
        surface: PaintedSurface,
        painter: Painter,
        path: Path | None = None,
        saved: Session | None = None,
        unit: str = "mm",
        undo_bytes: int = MEMORY_BUDGET,
    ) -> None:
        self.surface = surface
        self.painter = painter
        self.path = path
        self.unit = unit
        self.settings = dict(saved.settings if saved else {})
        self.inks: list[Ink] = list(self.settings.get("inks", [painter.dipped, _INKS[1]]))
        self.modified = False
        self._recordings = tuple(saved.recordings if saved else ())
        self._log = StrokeLog(saved.strokes if saved else (), self.settings.get("brushes", {}))
        surface.use_layers()
        self._undo = UndoHistory(surface, undo_bytes, painter.keep, painter.restore)
        self.symmetry = Symmetry()
        self.mask = Mask()
        self._stencil: Stencil | None = None
        self._images: list[ImagePainter] = []
        self._pending: list[NDArray] = []
        self._dipped = True

    # -- opening and saving -----------------------------------------------------------------

    @classmethod
    def new(
        cls,
        mesh: str | os.PathLike[str] | TriangleMesh,
        resolution: float | None = 0.4,
        material: str | Material = "porcelain",
        *,
        unit: str | None = None,
        brush: str | BrushSpec = _BRUSH,
        ink: Ink = _INKS[0],
    ) -> Document:
        """Start a painting on a mesh, its file, or a built-in object.

        Raises
        ------
        MeshError, InputError
            If the mesh, the resolution or the material cannot be used.
        """
        if not isinstance(mesh, TriangleMesh):
            mesh = load_mesh(mesh, unit)
        surface = PaintedSurface(mesh, resolution, material)
        return cls(surface, Painter(surface, brush, ink), unit=unit or "mm")

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        resolution: float | None = 0.4,
        material: str | Material = "porcelain",
        *,
        unit: str | None = None,
    ) -> Document:
        """Open a saved session (.p3d) to go on with, or a mesh to start on.

        Resolution, material and unit are for meshes; a session has its own.

        Raises
        ------
        SessionError, MeshError
            If the file cannot be used.
        """
        if not is_session_path(path):
            return cls.new(path, resolution, material, unit=unit)
        session = load_session(path)
        surface, settings = session.surface, session.settings
        brush = _brush_of(settings.get("brush"))
        ink = None if surface.pigments else _ink_named(settings.get("ink"))
        azimuth = settings.get("azimuth", "commanded")
        painter = Painter(surface, brush, ink, azimuth)
        if "dipped" in settings:
            _remember_dip(painter, settings["dipped"])
        return cls(surface, painter, Path(path), session, str(settings.get("unit", "mm")))

    def save(self, path: str | os.PathLike[str] | None = None) -> None:
        """Save everything to a session, by default to the one it came from.

        Raises
        ------
        ExportError
            If there is no path, or the file cannot be written.
        """
        path = self.path if path is None else Path(path)
        if path is None:
            raise ExportError("this painting has no file yet; expected where to save it")
        if not is_session_path(path):
            raise ExportError(f"{path}: a painting is saved as .p3d; other formats are exported")
        self._gather()
        save_session(self._session(), path)
        self.path, self.modified = path, False

    def _session(self) -> Session:
        settings = {**self.settings, "brush": asdict(self.painter.brush)}
        settings |= {"ink": self.painter.ink.name, "unit": self.unit}
        settings["azimuth"] = self.painter.azimuth
        settings["dipped"] = weights_of(self.painter.dipped)
        settings["inks"] = [weights_of(ink) for ink in self.inks]
        settings["brushes"] = {s.brush.name: asdict(s.brush) for s in self.strokes}
        strokes = tuple(stroke.recording() for stroke in self.strokes)
        return Session(self.surface, self._recordings, settings, strokes)

    def export(self, path: str | os.PathLike[str], **options: object) -> None:
        """Write the painting in the format that the suffix names; see `paint3d.export`.

        Raises
        ------
        ExportError, InputError
            If the suffix, an option or the file is no good.
        """
        check_export_path(path)
        self._gather()
        if is_session_path(path):
            save_session(self._session(), path)
        else:
            export(self.surface, path, **options)

    # -- brush and ink ----------------------------------------------------------------------

    def set_brush(self, brush: str | BrushSpec | Mapping) -> None:
        """Take another brush, dipped in the same ink.

        Raises
        ------
        InputError
            If a stroke is going on, or there is no such brush.
        """
        self._refuse_in_stroke("another brush")
        self.painter.change_brush(BrushSpec(**brush) if isinstance(brush, Mapping) else brush)

    def scale_brush(self, factor: float) -> None:
        """Take the brush so many times as large; see `brush_size.scaled`."""
        self.set_brush(scaled(self.painter.brush, factor))

    def resize_brush(self, length_mm: float) -> None:
        """Take the brush with a tuft of this length."""
        self.set_brush(resized(self.painter.brush, length_mm))

    def step_brush(self, steps: int) -> None:
        """Take the brush larger or smaller by some presses of ] or [, as far as it goes."""
        self.set_brush(stepped(self.painter.brush, steps))

    def dip(self, ink: Ink | None = None, reach: float | None = None) -> None:
        """Dip the brush; see `Painter.dip`. During a stroke it is dipped where it is."""
        self.painter.dip(ink, reach)
        self._dipped = True
        if ink is not None:
            self.inks[0] = ink

    def rinse(self) -> None:
        """Wash the brush out."""
        self.painter.rinse()

    def wipe(self, share: float = 0.5) -> None:
        """Wipe a share of the ink off the brush, 0 to 1."""
        self.painter.wipe(share)

    def swap_inks(self) -> None:
        """Dip the brush in the other ink."""
        self._refuse_in_stroke("another ink")
        self.inks.reverse()
        self.dip(self.inks[0])

    def pick_colour(self, vertex_id: int) -> dict[str, float] | None:
        """Dip the brush in what is on a vertex, as it is mixed there; what that is.

        Returns
        -------
        dict or None
            Parts of the inks by name, of sum 1; None where there is no paint, and nothing is
            done.

        Raises
        ------
        InputError
            If there is no such vertex.
        """
        surface = self.surface
        if not 0 <= vertex_id < surface.n_vertices:
            raise InputError(f"vertex {vertex_id}; expected 0 to {surface.n_vertices - 1}")
        parts = surface.parts_at(vertex_id)
        if not parts.any():
            return None
        parts /= parts.sum()
        found = {p: float(w) for p, w in zip(surface.pigments, parts, strict=True) if w > 1e-3}
        self.dip(found)
        return {pigment.name: part for pigment, part in found.items()}

    # -- strokes ----------------------------------------------------------------------------

    @property
    def in_stroke(self) -> bool:
        """Whether a stroke is going on."""
        return self._log.current is not None

    @property
    def strokes(self) -> Sequence[Stroke]:
        """What was painted by hand and is there, in order; those of earlier sittings first."""
        return self._log.strokes

    def begin_stroke(self) -> None:
        """Start a stroke: a step that can be undone.

        Raises
        ------
        InputError
            If one is going on, or the layer is locked or hidden.
        """
        self._refuse_in_stroke("a stroke")
        layer = self._paintable()
        painter = self.painter
        stroke = self._log.begin(painter.brush, painter.dipped, layer.name, self._dipped)
        self._dipped = False
        self._undo.begin(stroke)
        self._images = [ImagePainter(painter, image) for image in self.symmetry.images()]

    def feed(self, samples: Sequence[DeviceSample]) -> None:
        """Paint samples of both hands, in the order of time; the last two wait for more.

        Raises
        ------
        InputError
            If no stroke was begun, or the samples cannot follow those before; none of them is
            painted then, and the stroke goes on.
        """
        if not self.in_stroke:
            raise InputError("samples came without a stroke; expected begin_stroke first")
        if not samples:
            return
        self._log.check(samples)
        self._log.append(samples)
        self.painter.advance(samples)
        for image in self._images:
            image.advance(samples)
        self._wipe_stencil()
        self.modified = True

    def end_stroke(self) -> None:
        """Paint what still waits, and lift the brush."""
        if not self.in_stroke:
            return
        self.painter.finish()
        self._lift_images()
        self._wipe_stencil()
        stroke = self._log.end()
        if stroke is None:
            self._note(self._undo.revert())

    def cancel_stroke(self) -> None:
        """Take the stroke that is going on back, as if it had never begun."""
        if not self.in_stroke:
            return
        self.painter.abandon()
        self._images = []
        self._log.cancel()
        self._note(self._undo.revert())

    def set_symmetry(self, symmetry: Symmetry) -> None:
        """Paint every stroke's images as well, from now on.

        Raises
        ------
        InputError
            If a stroke is going on.
        """
        self._refuse_in_stroke("another symmetry")
        self.symmetry = symmetry

    def set_mask(self, mask: Mask) -> None:
        """Take paint only where the mask allows, from now on.

        Raises
        ------
        InputError
            If it names a face that is not there, or a stroke is going on.
        """
        self._refuse_in_stroke("another mask")
        self._stencil = None if mask.is_open else Stencil(self.surface, mask)
        self.mask = mask

    @property
    def tags(self) -> dict[str, object]:
        """What every stroke from now on says as well; see `set_tags`."""
        return dict(self._log.tags)

    def set_tags(self, **tags: object) -> None:
        """Have every stroke from now on say this as well, as JSON holds it; none: no more."""
        self._log.tags = dict(tags)

    def _wipe_stencil(self) -> None:
        if self._stencil is not None:
            self._stencil.wipe(self._undo.before)

    def _lift_images(self) -> None:
        for image in self._images:
            image.finish()
        self._images = []

    def _refuse_in_stroke(self, what: str) -> None:
        if self.in_stroke:
            raise InputError(f"{what} was asked for during a stroke; expected its end first")

    # -- layers -----------------------------------------------------------------------------

    @property
    def layers(self) -> tuple[Layer, ...]:
        """What is said of each layer, the lowest first."""
        return self.surface.layers.layers

    @property
    def active_layer(self) -> int:
        """Place of the layer that is painted on, from 0 for the lowest."""
        return self.surface.layers.active

    def select_layer(self, place: int) -> None:
        """Paint on another layer from now on.

        Raises
        ------
        InputError
            If there is none at that place, or a stroke is going on.
        """
        self._restack(None, lambda stack: stack.activate(place))

    def add_layer(self, name: str | None = None, place: int | None = None) -> None:
        """Put an empty layer above the one that is painted on, or at a place, and paint on it.

        Raises
        ------
        InputError
            If the name or the place is none, or there are too many.
        """
        names = {layer.name for layer in self.layers}
        name = name or next(str(n) for n in count(1) if str(n) not in names)
        place = self.active_layer + 1 if place is None else place
        self._restack("add layer", lambda stack: stack.add(name, place))

    def remove_layer(self, place: int) -> None:
        """Take a layer away with what is on it: a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that place, it is the only one, or a stroke is going on.
        """
        self._restack("remove layer", lambda stack: stack.remove(place))

    def move_layer(self, place: int, to: int) -> None:
        """Put a layer at another place: a step that can be undone.

        Raises
        ------
        InputError
            If there is no such place, or a stroke is going on.
        """
        self._restack("move layer", lambda stack: stack.move(place, to))

    def rename_layer(self, place: int, name: str) -> None:
        """Name a layer."""
        self.surface.layers.describe(place, name=name)
        self.modified = True

    def set_visible(self, place: int, visible: bool = True) -> None:
        """Show or hide a layer.

        Raises
        ------
        InputError
            If there is none at that place, or a stroke is going on.
        """
        self._refuse_in_stroke("showing or hiding a layer")
        self.surface.layers.describe(place, visible=bool(visible))
        self.surface.touch(self.surface.layers.painted_ids())
        self.modified = True

    def set_locked(self, place: int, locked: bool = True) -> None:
        """Refuse painting on a layer, or allow it again."""
        self.surface.layers.describe(place, locked=bool(locked))
        self.modified = True

    def _restack(self, step: str | None, action: Callable[[LayerStack], None]) -> None:
        """Change which layers there are; ink that goes or comes with them is no longer loaded."""
        self._refuse_in_stroke("another order of layers")
        surface, painter = self.surface, self.painter
        stack = surface.layers
        self._gather()
        if step is not None:
            self._undo.begin(step)
        before, shown = surface.wet_ink() + surface.dry_ink(), stack.painted_ids()
        self._undo.change(stack.state, lambda: action(stack))
        painter.loaded += surface.wet_ink() + surface.dry_ink() - before
        if step is not None:
            surface.touch(np.union1d(shown, stack.painted_ids()).astype(np.int32))
        self.modified = True

    def _paintable(self) -> Layer:
        """The layer that is painted on."""
        layer = self.layers[self.active_layer]
        for state, why in ((layer.locked, "locked"), (not layer.visible, "hidden")):
            if state:
                raise InputError(f"the layer {layer.name!r} is {why}; expected another one")
        return layer

    # -- time -------------------------------------------------------------------------------

    def let_time_pass(self, seconds: float) -> None:
        """Let wet ink spread and dry; see `PaintedSurface.diffuse`."""
        self.surface.diffuse(seconds)
        if self._stencil is not None and self.in_stroke:
            self._undo.seal()  # what runs by itself is not the stencil's

    def dry(self) -> None:
        """Let all wet paint dry at once: a step that can be undone."""
        self._refuse_in_stroke("drying")
        self._paintable()
        self._undo.begin("dry")
        self.surface.dry()
        self.modified = True

    @property
    def steps(self) -> UndoHistory:
        """What can be undone, step by step."""
        return self._undo

    # -- the way back -----------------------------------------------------------------------

    @property
    def can_undo(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._undo.done)

    @property
    def can_redo(self) -> bool:
        """Whether there is something to do again."""
        return bool(self._undo.undone)

    def undo(self) -> NDArray:
        """Take back the last step; the brush stays the one that was chosen last.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.
        """
        self.end_stroke()
        chosen = self.painter.brush, self.painter.dipped
        touched = self._undo.undo()
        if (self.painter.brush, self.painter.dipped) != chosen:
            self.painter.change_brush(chosen[0])
            self.painter.dip(chosen[1])
        return self._stepped(touched)

    def redo(self) -> NDArray:
        """Do again what was undone last; returns as `undo`."""
        self.end_stroke()
        return self._stepped(self._undo.redo())

    def _stepped(self, touched: NDArray) -> NDArray:
        self._log.follow([label for label in self._undo.done if isinstance(label, Stroke)])
        self.modified = True
        self._note(touched)
        return touched

    @property
    def oldest_stroke(self) -> int:
        """How many strokes were there when this was opened, which cannot be undone."""
        return self._log.n_before

    def replay_history(self, upto: int) -> NDArray:
        """Show the painting as it was after so many strokes, by undo and redo.

        Parameters
        ----------
        upto : int
            From `oldest_stroke`, those of earlier sittings, to as many as there are with those
            that were undone.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError
            If there are not so many.
        """
        undone = sum(isinstance(label, Stroke) for label in self._undo.undone)
        most = len(self.strokes) + undone
        if not self.oldest_stroke <= upto <= most:
            raise InputError(
                f"stroke {upto} of the history; expected {self.oldest_stroke} to {most}"
            )
        touched = [np.empty(0, np.int32)]
        while len(self.strokes) > upto:
            touched.append(self.undo())
        while len(self.strokes) < upto:
            touched.append(self.redo())
        return np.unique(np.concatenate(touched)).astype(np.int32)

    def replayed(self, upto: int | None = None) -> Document:
        """The first strokes painted once more on the bare object, as another document.

        This leads back before the painting was opened, where undo cannot. Layers are those of the
        strokes' names in the order in which they come; what was dried, moved, or let run meanwhile
        is not repeated.

        Parameters
        ----------
        upto : int, optional
            How many; by default all.

        Raises
        ------
        InputError
            If there are not so many.
        """
        upto = len(self.strokes) if upto is None else upto
        if not 0 <= upto <= len(self.strokes):
            raise InputError(f"stroke {upto} of the history; expected 0 to {len(self.strokes)}")
        surface = self.surface
        again = Document.new(surface.source, surface.resolution, surface.material)
        known = {pigment.name: pigment for pigment in surface.pigments}
        for stroke in self.strokes[:upto]:
            again.repeat(stroke, known)
        return again

    def repeat(self, stroke: Stroke, inks: Mapping[str, Pigment] | None = None) -> None:
        """Paint a stroke again, with its brush and on the layer of its name, which is made.

        Parameters
        ----------
        stroke : Stroke
        inks : mapping, optional
            Inks that the palette does not know, by name.
        """
        names = [layer.name for layer in self.layers]
        if not self.strokes and stroke.layer not in names:
            self.rename_layer(0, stroke.layer)
        elif stroke.layer not in names:
            self.add_layer(stroke.layer, len(names))
        else:
            self.select_layer(names.index(stroke.layer))
        if stroke.brush != self.painter.brush:
            self.set_brush(stroke.brush)
        if stroke.dipped:
            self.dip({(inks or {}).get(name, name): part for name, part in stroke.ink.items()})
        self.begin_stroke()
        self.feed(stroke.samples)
        self.end_stroke()

    def recording(self, first: int = 0) -> Recording | None:
        """The strokes from number `first` on as one recording in the object's frame, with dips.

        None if there are none.
        """
        return self._log.recording(self.surface.source.name, first)

    # -- what is shown ----------------------------------------------------------------------

    def refresh(self) -> NDArray:
        """Bring the colours up to date; (N,) int32 vertices that changed since the last call."""
        self._gather()
        pending, self._pending = self._pending, []
        if len(pending) == 1:
            return pending[0]
        return np.unique(np.concatenate([np.empty(0, np.int32), *pending])).astype(np.int32)

    def _gather(self) -> None:
        """Remember what a refresh finds, whoever asks for colours."""
        self._note(self.surface.refresh())

    def _note(self, vertex_ids: NDArray) -> None:
        if len(vertex_ids):
            self._pending.append(vertex_ids)


def _remember_dip(painter: Painter, saved: object) -> None:
    """Let a brush that lies there know what it was dipped in last."""
    known = {pigment.name: pigment for pigment in painter.surface.pigments}
    try:
        dipped = {known.get(name, name): float(weight) for name, weight in saved.items()}
    except (AttributeError, TypeError, ValueError):
        raise SessionError(f"the brush was dipped in {saved!r:.60}; expected inks") from None
    painter.restore({**painter.keep(), "_dipped": dipped})


def _brush_of(saved: object) -> BrushSpec:
    if isinstance(saved, Mapping):
        return BrushSpec(**saved)
    return load_brush(saved if isinstance(saved, str) else _BRUSH)


def _ink_named(saved: object) -> str:
    return saved if isinstance(saved, str) else _INKS[0]

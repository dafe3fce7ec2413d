"""A painting in the studio: the object, the brush, its strokes, and its undo history.

No window, no thread and no clock: whoever calls says when. `paint3d.app.model.paint_thread` runs
one of these in a thread of its own.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from paint3d.app.model.brush_in_hand import ToolOverride, resized, scaled, stepped
from paint3d.app.model.commands import COMMANDS, decode_arguments
from paint3d.app.model.edit_history import (
    EditHistory,
    Turned,
    Version,
    first_difference,
    locate_strokes,
    without_refusals,
)
from paint3d.app.model.input.symmetry import Symmetry
from paint3d.app.model.laid_text import LaidText, pack_texts, unpack_texts
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.persistence.brush_words import brush_from_words, brush_words, hair_words
from paint3d.app.model.persistence.saved_history import MOST_BYTES, restore_history, saved_history
from paint3d.app.model.persistence.saved_settings import (
    DEFAULT_BRUSH,
    PURE_INKS,
    saved_inks,
    saved_painter,
    saved_unit,
)
from paint3d.app.model.score.codecs import InkTable, Vocabulary, encode_brush
from paint3d.app.model.score.recorder import ScoreRecorder, recorded
from paint3d.app.model.score.stepping import play
from paint3d.app.model.seal_press import PASTE, SealPress
from paint3d.app.model.stroke_log import (
    ERASES,
    Stroke,
    StrokeLog,
    check_pairs,
    names_apart,
    parts_of,
    strokes_of,
    weights_of,
)
from paint3d.app.model.stroke_painter import StrokePainter
from paint3d.app.model.stroke_recall import StrokeRecall, dips_of, named_dips
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray, as_number
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.errors import ExportError, InputError, LayerError, Message, Paint3DError, SessionError
from paint3d.files.export import (
    PreparedExport,
    check_export_path,
    prepare_export,
)
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.files.progress import Progress, part_of
from paint3d.files.project.session import Session, is_session_path, load_session, save_session
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.ink_time import LOOKAHEAD
from paint3d.painter.painter import Ink, Painter
from paint3d.painter.recorded_tools import LEAST_INK
from paint3d.recording.score import Score
from paint3d.recording.score_edits import apply_seal_edit, apply_stroke_edit
from paint3d.recording.score_steps import follow_steps
from paint3d.surface.ink_store import union
from paint3d.surface.layer_stack import Layer, LayerStack
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import MEMORY_BUDGET, UndoHistory
from paint3d.view.pressed_tuft import TuftFollower

__all__ = ["Document", "FileState"]

_BLOT_FRACTION = 0.8  # of wet ink, that blotting paper lifts
_MOST_PICKUP = 1000.0  # 1/mm, as in recordings
_MANY_OUTDATED = 1024  # vertices, above which their colours are computed while nobody paints
_EDIT_STEP = COMMANDS["edit_strokes"].undo_label
# Label of a step of an edit that no stroke begins: it is taken back with the step before it, and
# done again with the one after it.

FileState = tuple[int, int, int]
"""Inode, mtime (ns) and size of a file: they change when somebody writes it."""


class Document:
    """A painting, with everything that can be done to it.

    Make it with `Document.new` or `Document.open`. Methods that change the painting are `recorded`;
    `paint3d.app.model.commands` says what else belongs to them.

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
    properties : dict
        Anything else that is to be saved with the painting, as JSON holds it.
    tuft_follower : TuftFollower
        Finds how the tuft lies on the surface, for drawing it.
    modified : bool
        Whether it is otherwise than it was saved; undo and redo may lead back there.
    left_out : bool
        True if the file had no capacity for some steps when it was saved last.
    looks_back : bool
        Whether strokes were undone by `replay_history` and not done again since.
    edits : EditHistory
        Edits of strokes and seals, which undo and redo lead over.
    recorder : ScoreRecorder or None
        Writes down what is asked, to be played again; None where how it began is not known.
    check_access : callable
        Raises RuntimeError where the thread that calls a method may not use the document.
    progress : callable or None
        Called with the fraction that is done while strokes are painted again; what it raises stops
        that, and everything is as it was.
    refused_history : Message or None
        Why the steps that were saved with it could not be used; empty where they could.
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
        self._file_state = _stat(path)
        self.unit = unit
        self.properties: dict[str, Any] = dict(saved.settings if saved else {})
        at_hand = saved_inks(surface, self.properties)
        self.inks: list[Ink] = list(at_hand or (painter.dipped, PURE_INKS[1]))
        self.progress: Callable[[float], None] | None = None
        self.check_access: Callable[[], None] = lambda: None
        self.modified = False
        self._saved_at: int | None = 0
        self.left_out = False
        self._recordings = tuple(saved.recordings if saved else ())
        self._texts = unpack_texts(self.properties.pop("texts", []))
        self._log = StrokeLog(saved.strokes if saved else (), self.properties.get("brushes", {}))
        surface.use_layers()
        self._dipped_since_stroke = self.properties.get("fresh", True) is not False
        self._undo = UndoHistory(surface, undo_bytes, self._capture_state, self._restore_state)
        self._strokes = StrokePainter(painter, self._undo)
        self._override: ToolOverride | None = None
        self._refused = False  # the stroke whose samples come
        self._press = SealPress(painter, self._undo)
        self.edits = EditHistory(self._undo)
        self._is_repainting = False
        self._is_previewing = False  # strokes were undone only to look at what was before
        self.looks_back = False
        self.recorder: ScoreRecorder | None
        if saved is None:
            self.recorder = ScoreRecorder.begin(surface, painter)
        else:
            self.recorder = ScoreRecorder.going_on(saved)
        self.refused_history = self._restore_history(saved)
        self._saved_at = self._undo.next_undo
        surface.keeps_up = self.properties.pop("behind", False) is not True
        self._pending: list[AnyArray] = []
        self.tuft_follower = TuftFollower()

    @property
    def score(self) -> Score | None:
        """The score; None where it is not known from the beginning.

        `score.playing.score_of_strokes` then makes one of the strokes alone.
        """
        recorder = self.recorder
        if recorder is None or not recorder.is_whole:
            return None
        return recorder.score(self.surface.source.name)

    def _restore_history(self, saved: Session | None) -> Message | None:
        """Restore the saved undo history; return why that failed, or None."""
        if saved is None or saved.history is None:
            return None
        try:
            undone = strokes_of(saved.undone, self.properties.get("brushes"))
            log = self._log
            n_restored = restore_history(
                self.surface, self._undo, saved.history, log.strokes, undone
            )
        except SessionError as error:
            return error.message
        self._log.hold(n_restored)
        return None

    def _capture_state(self) -> dict[str, object]:
        """State that undo restores besides the surface."""
        texts = pack_texts(self._texts)
        return {"painter": self.painter.keep(), "dipped": self._dipped_since_stroke, "texts": texts}

    def _restore_state(self, state: Any) -> None:
        self.painter.restore(state["painter"])
        self._dipped_since_stroke = state["dipped"]
        self._texts = unpack_texts(state["texts"])

    # -- opening and saving ---------------------------------------------------------------

    @classmethod
    def new(
        cls,
        mesh: str | os.PathLike[str] | TriangleMesh,
        resolution: float | None = 0.4,
        material: str | Material = "porcelain",
        *,
        unit: str | None = None,
        brush: str | BrushSpec = DEFAULT_BRUSH,
        ink: Ink = PURE_INKS[0],
        undo_bytes: int = MEMORY_BUDGET,
    ) -> Document:
        """Start a painting on a mesh, its file, or a built-in object.

        Parameters
        ----------
        mesh : path-like or TriangleMesh
        resolution : float or None
            mm.
        material : str or Material
        unit : {"mm", "cm", "m", "in"}, optional
            Of a file.
        brush, ink
            In the hand.
        undo_bytes : int
            Of undo steps in memory; more go to the disk.

        Raises
        ------
        MeshError, InputError
            If the mesh, the resolution or the material cannot be used.
        """
        if not isinstance(mesh, TriangleMesh):
            mesh = load_mesh(mesh, unit)
        surface = PaintedSurface(mesh, resolution, material)
        painter = Painter(surface, brush, ink)
        return cls(surface, painter, unit=unit or "mm", undo_bytes=undo_bytes)

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        resolution: float | None = 0.4,
        material: str | Material = "porcelain",
        *,
        unit: str | None = None,
        undo_bytes: int = MEMORY_BUDGET,
        progress: Progress | None = None,
    ) -> Document:
        """Open a saved session (.p3d) to go on with, or a mesh to start on.

        Resolution, material and unit are for meshes; a session has its own. `progress` is called
        with the fraction done, now and then; what it raises stops it.

        Raises
        ------
        SessionError, MeshError
            If the file cannot be used.
        """
        if not is_session_path(path):
            return cls.new(path, resolution, material, unit=unit, undo_bytes=undo_bytes)
        state = _stat(path)
        session = load_session(path, progress)
        try:
            painter = saved_painter(session.surface, session.settings)
            unit = saved_unit(session.settings)
            opened = cls(session.surface, painter, Path(path), session, unit, undo_bytes)
            opened._file_state = state
            return opened
        except Paint3DError as cause:
            raise SessionError("{file}: {cause}", file=path, cause=cause) from None

    def save(
        self, path: str | os.PathLike[str] | None = None, *, progress: Progress | None = None
    ) -> None:
        """Save everything to a session, by default to the one it came from.

        `progress` is called with the fraction done, and with 1 before the file takes its place;
        what it raises leaves everything as it was.

        Raises
        ------
        ExportError
            If there is no path, or the file cannot be written.
        """
        path = self.path if path is None else Path(path)
        if path is None:
            raise ExportError("this painting has no file yet; give a path to save it to")
        if not is_session_path(path):
            raise ExportError(
                "{file}: a painting is saved as .p3d; other formats are exported",
                file=path,
            )
        self.save_copy(path, progress)
        self.set_file(path)
        self.modified, self._saved_at = False, self._undo.next_undo

    def save_copy(self, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
        """Write everything to a session that is not the painting's own; see `save`."""
        self._refresh_colours()
        save_session(self._make_session(), path, progress)

    def _make_session(self) -> Session:
        settings = {**self.properties, "brush": brush_words(self.painter.brush)}
        settings |= {"ink": self.painter.ink.name, "unit": self.unit}
        settings["azimuth"] = self.painter.azimuth
        if self._texts:
            settings["texts"] = [text.words() for text in self._texts]
        settings["hairs"] = hair_words(self.painter)
        settings["dipped"] = weights_of(self.painter.dipped)
        settings["amount"] = self.painter.amount.words()
        settings["dips"] = [[weights_of(ink), reach] for ink, reach in self.painter.dips]
        settings["fresh"] = self._dipped_since_stroke
        if not self.surface.keeps_up:
            settings["behind"] = True
        settings["inks"] = [weights_of(ink) for ink in self.inks]
        history, gone = saved_history(self.surface, self._undo, self._log.current, MOST_BYTES)
        n_kept, steps = len(history["done"]) + len(history["undone"]), self._undo
        self.left_out = n_kept < len(steps.done) + len(steps.undone)
        names = names_apart(stroke.brush for stroke in (*self.strokes, *gone))
        settings["brushes"] = {name: brush_words(brush) for brush, name in names.items()}
        strokes = tuple(stroke.recording(names[stroke.brush]) for stroke in self.strokes)
        undone = tuple(stroke.recording(names[stroke.brush]) for stroke in gone)
        session = Session(self.surface, self._recordings, settings, strokes, undone, history)
        recorder = self.recorder
        if recorder is None or self.in_stroke:  # what of it is painted, nobody could say
            return session
        score = recorder.score(self.surface.source.name)
        return replace(session, score=score) if recorder.is_whole else replace(session, later=score)

    def set_file(self, path: Path | None, state: FileState | None = None) -> None:
        """Make a file the session's own.

        Parameters
        ----------
        path : Path or None
        state : FileState, optional
            Its `file_state` when it was last written or read; by default its state on disk now.
        """
        self.path, self._file_state = path, state or _stat(path)

    @property
    def file_state(self) -> FileState | None:
        """State of the session's file when it was opened or saved here; None without a file."""
        return self._file_state

    @property
    def file_changed_on_disk(self) -> bool:
        """True if the session's file was changed since it was opened or saved here."""
        now = _stat(self.path)
        return now is not None and now != self._file_state

    def mark_modified(self) -> None:
        """Mark the painting as modified, whatever is undone."""
        self.modified, self._saved_at = True, None

    def export(
        self,
        path: str | os.PathLike[str],
        *,
        progress: Progress | None = None,
        **options: Any,
    ) -> None:
        """Write the painting in the format that the suffix names; see `paint3d.export`.

        `progress` is called with the fraction done, and with 1 before the file takes its place;
        what it raises leaves everything as it was.

        Raises
        ------
        ExportError, InputError
            If the suffix, an option or the file is no good.
        """
        check_export_path(path)
        if is_session_path(path):
            self.save_copy(path, progress)
            return
        prepared = self.prepare_export(path, ExportOptions(**options), part_of(progress, 0.0, 0.6))
        prepared.write(part_of(progress, 0.6, 1.0))

    def prepare_export(
        self, path: str | os.PathLike[str], options: ExportOptions, progress: Progress | None = None
    ) -> PreparedExport:
        """Take what an export needs, to be written while painting goes on.

        See `paint3d.files.export.prepare_export`.
        """
        self._refresh_colours()
        return prepare_export(self.surface, path, options, progress)

    # -- how it is looked at ----------------------------------------------------------------

    def set_reference(self, reference: Mapping[str, Any] | None = None) -> None:
        """Store the reference picture and how it is shown with the painting; None: none."""
        if self._set_property("reference", reference):
            self.mark_modified()

    def set_views(self, views: Mapping[str, Mapping[str, Any]]) -> None:
        """Store named views of the painting with it."""
        if self._set_property("views", views):
            self.mark_modified()

    def set_light(self, kind: str, turn: float) -> None:
        """Store the light the painting is seen in, one of `LIVE_LIGHTS`, turned by rad.

        That is no reason to save it.
        """
        self._set_property("light", {"kind": kind, "turn": turn})

    def _set_property(self, name: str, value: Mapping[str, Any] | None) -> bool:
        """Set or remove one of `properties`; return whether it changed."""
        self.check_access()
        before = self.properties.pop(name, None)
        if value is not None:
            self.properties[name] = dict(value)
        return bool(before != value)

    # -- brush and inks ---------------------------------------------------------------------

    @recorded
    def set_brush(self, brush: str | BrushSpec | Mapping[str, Any]) -> None:
        """Take another brush, dipped in the same ink.

        Raises
        ------
        InputError
            If a stroke is going on, or there is no such brush.
        """
        self._refuse_in_stroke(Message("changing the brush"))
        if isinstance(brush, Mapping):
            brush = brush_from_words(brush)
        elif isinstance(brush, str):  # it may be that of a session, which names no file
            brush = load_brush(brush, own_files=False)
        self.painter.change_brush(brush)
        self._dipped_since_stroke = True

    @recorded
    def scale_brush(self, factor: float) -> None:
        """Take the brush so many times as large; see `brush_in_hand.scaled`."""
        self.set_brush(scaled(self.painter.brush, factor))

    @recorded
    def resize_brush(self, length_mm: float) -> None:
        """Take the brush with a tuft of this length."""
        self.set_brush(resized(self.painter.brush, length_mm))

    @recorded
    def step_brush(self, steps: int) -> None:
        """Take the brush larger or smaller by some presses of ] or [, as far as it goes."""
        self.set_brush(stepped(self.painter.brush, steps))

    @recorded
    def set_azimuth(self, azimuth: str) -> None:
        """Turn the tuft by the pose's roll ("commanded"), or as the surface drags it ("dragged").

        Raises
        ------
        InputError
            If it is neither, or a stroke is going on.
        """
        self._refuse_in_stroke(Message("changing the azimuth"))
        if azimuth not in ("commanded", "dragged"):
            raise InputError(
                "azimuth is {azimuth!r}; expected 'commanded' or 'dragged'",
                azimuth=azimuth,
            )
        self.painter.azimuth = azimuth

    @recorded
    def set_pickup(self, pickup: float) -> None:
        """Take up wet ink with the brush: this fraction per mm of path at full pressure.

        Raises
        ------
        InputError
            If it is below 0 or over 1000, or a stroke is going on.
        """
        self._refuse_in_stroke(Message("changing the pick-up"))
        fraction = as_number(pickup, "pickup (1/mm)", 0.0, _MOST_PICKUP)
        self.surface.ink.transfer["pickup"] = fraction

    @property
    def pickup(self) -> float:
        """Fraction of the wet ink under the brush that it takes up per mm at full pressure."""
        return float(self.surface.ink.transfer["pickup"].item())

    @recorded
    def dip(
        self,
        ink: Ink | None = None,
        reach: float | None = None,
        amount: Mapping[str, float] | None = None,
    ) -> None:
        """Dip the brush; see `Painter.dip`. During a stroke it is dipped where it is.

        `amount` is what `DipAmount.words` gives.
        """
        self.painter.dip(ink, reach, None if amount is None else DipAmount.of(amount))
        self._dipped_since_stroke = True
        if ink is not None:
            self.inks[0] = ink

    @recorded
    def rinse(self) -> None:
        """Wash the brush out."""
        self.painter.rinse()

    @recorded
    def wipe(self, share: float = 0.5) -> None:
        """Wipe a fraction of the ink off the brush, 0 to 1."""
        self.painter.wipe(share)

    @recorded
    def swap_inks(self) -> None:
        """Dip the brush in the other ink."""
        self._refuse_in_stroke(Message("changing the ink"))
        self.inks.reverse()
        self.dip(self.inks[0])

    @recorded
    def pick_colour(self, vertex_id: int) -> dict[str, float] | None:
        """Dip the brush in the mixture on a vertex; return it.

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
            raise InputError(
                "vertex_id is {vertex_id}; expected 0 to {last}",
                vertex_id=vertex_id,
                last=surface.n_vertices - 1,
            )
        parts = surface.parts_at(vertex_id)
        if not parts.any():
            return None
        parts /= parts.sum()
        ink = {p: float(w) for p, w in zip(surface.pigments, parts, strict=True) if w > 1e-3}
        self.dip(ink)
        return {pigment.name: part for pigment, part in ink.items()}

    # -- strokes ----------------------------------------------------------------------------

    @property
    def in_stroke(self) -> bool:
        """True if a stroke is going on."""
        return self._log.current is not None

    @property
    def unpainted(self) -> tuple[list[DeviceSample], bool]:
        """The current stroke's samples that are not painted yet, for drawing the brush.

        They are preceded by the last painted one, if there is one; and whether there is one.
        """
        stroke = self._log.current
        if stroke is None:
            return [], False
        return stroke.samples[-LOOKAHEAD - 1 :], len(stroke.samples) > LOOKAHEAD + 1

    @property
    def strokes(self) -> Sequence[Stroke]:
        """Strokes that are there, in order; those of earlier sessions first."""
        return self._log.strokes

    @property
    def current_stroke(self) -> Stroke | None:
        """The stroke that is going on."""
        return self._log.current

    @recorded
    def begin_stroke(
        self,
        time_s: float | None = None,
        brush: BrushSpec | None = None,
        ink: Ink | None = None,
        loads: Sequence[tuple[int, float]] = (),
        strengths: Sequence[tuple[int, float]] = (),
        *,
        erase: bool = False,
    ) -> None:
        """Start a stroke: a step that can be undone.

        Parameters
        ----------
        time_s : float, optional
            When it began, s since 1970; now by default.
        brush, ink : optional
            Of this stroke alone: another brush, dipped in the ink or in the same as the one in
            hand; without a brush, as much of the ink as the brush holds. What is in hand comes back
            with the stroke's end.
        loads : sequence of (int, float)
            How much the brush comes to hold at samples of the stroke, counted from 0: a fraction, 0
            to 1, of what a dip gives.
        strengths : sequence of (int, float)
            As `loads`, but the fraction of ink in water, until the next dip.
        erase : bool
            Take paint off the layer with a full brush, instead of putting ink on it; see `Eraser`.

        Raises
        ------
        InputError
            If one is going on, the layer is locked or hidden, or loads or strengths are no such
            pairs. In that case samples are passed over until `end_stroke` or `cancel_stroke`: they
            belong to the stroke that was refused.
        """
        self._refuse_in_stroke(Message("beginning another stroke"))
        self._end_preview()
        self._refused = True
        loads = check_pairs("loads", loads)
        strengths = check_pairs("strengths", strengths, LEAST_INK)
        layer = self._require_paintable()
        painter = self.painter
        stroke = self._log.begin(
            painter.brush,
            painter.dipped,
            layer.name,
            self._dipped_since_stroke,
            time_s,
            painter.amount,
        )
        stroke.loads, stroke.strengths = loads, strengths
        self._undo.begin(stroke)
        if erase:
            brush, ink = brush or painter.brush, ink or painter.dipped  # never an empty brush
            stroke.tags[ERASES] = True
        if brush is not None or ink is not None:
            try:
                self._override = ToolOverride(painter, brush, ink)
            except BaseException:
                self._log.cancel()
                self._queue_changed(self._undo.revert())
                raise
            stroke.brush, stroke.ink = painter.brush, parts_of(painter.dipped)
            stroke.dipped_since_stroke = True
        self._refused = self._dipped_since_stroke = False
        self._strokes.begin(loads, strengths, erase=erase)

    def feed(self, samples: Sequence[DeviceSample]) -> None:
        """Paint samples of both hands, in the order of time; the last two wait for more.

        Raises
        ------
        InputError
            If no stroke was begun, or the samples cannot follow those before; none of them is
            painted then, and the stroke goes on.
        """
        self.check_access()
        if self._refused:
            return
        if not self.in_stroke:
            raise InputError("samples came without a stroke; expected begin_stroke first")
        if not samples:
            return
        self._log.check(samples)
        self._log.append(samples)
        self._strokes.advance(samples)
        self.modified = True
        if self.recorder is not None and not self.recorder.is_suspended:
            self.recorder.feed(samples)

    @recorded
    def lift(self) -> None:
        """Paint what still waits of a stroke that goes on elsewhere: the pen is up meanwhile."""
        if self.in_stroke:
            self._strokes.lift()

    @recorded
    def end_stroke(self) -> Stroke | None:
        """Paint what still waits, and lift the brush.

        Returns
        -------
        Stroke or None
            None where it was refused, has ended already, or had no sample.
        """
        self._refused = False
        if not self.in_stroke:
            return None
        self._strokes.finish()
        if self._override is not None:
            self._override.end()
            self._override = None
        stroke = self._log.end()
        if stroke is None:
            self._queue_changed(self._undo.revert())
            self.update_modified()
        return stroke

    def break_off(self) -> None:
        """End the stroke that is going on now; ignore what its hand still sends."""
        if self.in_stroke:
            self.end_stroke()
            self._refused = True

    @recorded
    def cancel_stroke(self) -> None:
        """Take the stroke that is going on back, as if it had never begun."""
        self._refused = False
        if not self.in_stroke:
            return
        self._strokes.abandon()
        self._override = None  # what was in hand comes back with the step
        self._log.cancel()
        self._queue_changed(self._undo.revert())
        self.update_modified()

    @recorded
    def set_symmetry(self, symmetry: Symmetry) -> None:
        """Paint every stroke's images as well, from now on.

        Raises
        ------
        InputError
            If a stroke is going on.
        """
        self._refuse_in_stroke(Message("changing the symmetry"))
        self._strokes.symmetry = symmetry

    @recorded
    def set_mask(self, mask: Mask) -> None:
        """Take paint only where the mask allows, from now on.

        Raises
        ------
        InputError
            If it names a face that is not there, or a stroke is going on.
        """
        self._refuse_in_stroke(Message("changing the mask"))
        self._strokes.set_mask(mask)

    @property
    def symmetry(self) -> Symmetry:
        """Images of every stroke; see `set_symmetry`."""
        return self._strokes.symmetry

    @property
    def mask(self) -> Mask:
        """Mask that says where paint is taken; see `set_mask`."""
        return self._strokes.mask

    @property
    def stencil(self) -> Stencil | None:
        """The mask as it lies on the surface; None where paint is taken everywhere."""
        return self._strokes.stencil

    @property
    def tags(self) -> dict[str, object]:
        """Tags that every stroke gets from now on; see `set_tags`."""
        return dict(self._log.tags)

    @recorded
    def set_tags(self, /, **tags: object) -> None:
        """Give every stroke these tags from now on, as JSON holds them; none by default."""
        self._log.tags = dict(tags)

    def _refuse_in_stroke(self, what: Message) -> None:
        if self.in_stroke:
            raise InputError(
                "{what} is not possible during a stroke; end the stroke first", what=what
            )

    def prepare_next_stroke(self) -> None:
        """Prepare ahead what the next stroke would wait for; paint nothing."""
        if not self.in_stroke:
            self.surface.grow_ahead()
            if self.surface.n_outdated > _MANY_OUTDATED:  # wet ink looks at them at every step
                self._refresh_colours()

    @recorded
    def follow_time(self, seconds: float) -> bool:
        """Advance wet ink by `seconds`, by 0 s while it lags behind; return whether it keeps up."""
        keeps_up = self.surface.follow_time(seconds)
        self._end_undo_part()
        return keeps_up

    @recorded
    def let_time_pass(self, seconds: float) -> bool:
        """Advance wet ink by `seconds`, also while it lags behind; return whether it keeps up."""
        keeps_up = self.surface.follow_flow(seconds)
        self._end_undo_part()
        return keeps_up

    def _end_undo_part(self) -> None:
        """Close the part of the undo step, so that the mask does not wipe ink that flowed."""
        if self.stencil is not None and self.in_stroke:
            self._undo.end_part()

    @recorded
    def dry(self) -> None:
        """Dry all wet paint at once: a step that can be undone."""
        self._refuse_in_stroke(Message("drying"))
        self._end_preview()
        self._require_paintable()
        self._undo.begin(COMMANDS["dry"].undo_label)
        self.surface.dry()
        self.modified = True

    @recorded
    def blot(self, share: float = _BLOT_FRACTION) -> None:
        """Lay blotting paper on what is wet, and take it up: a step that can be undone.

        It lifts the water and a fraction of the ink, 0 to 1, where the mask allows; the rest dries.

        Raises
        ------
        InputError
            If a stroke is going on, the layer is locked or hidden, or it is no such fraction.
        """
        self._refuse_in_stroke(Message("blotting"))
        share = as_number(share, "share", 0.0, 1.0)
        self._end_preview()
        self._require_paintable()
        self._undo.begin(COMMANDS["blot"].undo_label)
        surface = self.surface
        surface.drop_flow()
        before = surface.wet_ink()
        ids = np.flatnonzero(surface.ink.coverage > 0.0).astype(np.int32)
        if self.stencil is not None:
            ids = ids[~self.stencil.covers(ids)]
        surface.ink.amounts[ids] *= np.float32(1.0 - share)
        self.painter.loaded += surface.wet_ink() - before
        surface.touch(ids)
        surface.dry()
        self.modified = True

    # -- layers -----------------------------------------------------------------------------

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Properties of each layer, the lowest first."""
        return self.surface.use_layers().layers

    @property
    def active_layer(self) -> int:
        """Index of the layer that is painted on, from 0 for the lowest."""
        return self.surface.use_layers().active

    @recorded
    def select_layer(self, place: int) -> None:
        """Paint on another layer from now on.

        Raises
        ------
        InputError
            If there is none at that index, or a stroke is going on.
        """
        self._restack("select_layer", lambda stack: stack.activate(place))

    @recorded
    def add_layer(self, name: str | None = None, place: int | None = None) -> None:
        """Put an empty layer above the one that is painted on, or at an index, and paint on it.

        Raises
        ------
        InputError
            If the name or the index is none, or there are too many.
        """
        name = name or _first_free(layer.name for layer in self.layers)
        place = self.active_layer + 1 if place is None else place
        self._restack("add_layer", lambda stack: stack.add(name, place))

    @recorded
    def remove_layer(self, place: int) -> None:
        """Take a layer away with what is on it: a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that index, it is the only one, or a stroke is going on.
        """
        self._restack("remove_layer", lambda stack: stack.remove(place))

    @recorded
    def move_layer(self, place: int, to: int, within: int | None = None) -> None:
        """Put a layer at another index, or into a group or out of it: a step that can be undone.

        Parameters
        ----------
        place, to : int
        within : int, optional
            Place of a layer whose group it joins, -1 for none; see `LayerStack.move`.

        Raises
        ------
        InputError
            If there is no such index, a group would lie in two parts, or a stroke is going on.
        """
        self._restack("move_layer", lambda stack: stack.move(place, to, within))

    # A group is named by the index of any of its layers.

    @recorded
    def add_group(self, place: int, last: int | None = None, name: str | None = None) -> None:
        """Make a group of the layers from an index to the last: a step that can be undone.

        Raises
        ------
        InputError
            If there is no such layer, the name is none, another group would lie in two parts, or a
            stroke is going on.
        """
        last = place if last is None else last
        name = name or self._free_group_name()
        self._restack("add_group", lambda stack: stack.group(place, last, name))

    @recorded
    def ungroup(self, place: int) -> None:
        """Dissolve a group; its layers stay: a step that can be undone.

        Raises
        ------
        InputError
            If there is no layer at that index, it is in no group, or a stroke is going on.
        """
        self._restack("ungroup", lambda stack: stack.ungroup(place))

    @recorded
    def duplicate_group(self, place: int, name: str | None = None) -> None:
        """Put a copy of a group above it, and paint on its uppermost: a step that can be undone.

        Raises
        ------
        InputError
            If there is no layer at that index, it is in no group, the name is none, there are too
            many, or a stroke is going on.
        """
        name = name or self._free_group_name()
        self._restack("duplicate_group", lambda stack: stack.duplicate_group(place, name))

    @recorded
    def move_group(self, place: int, to: int) -> None:
        """Put a group so that its lowest layer is at an index: a step that can be undone.

        Raises
        ------
        InputError
            If there is no such index, the layer is in no group, another group would lie in two
            parts, or a stroke is going on.
        """
        self._restack("move_group", lambda stack: stack.move_group(place, to))

    @recorded
    def remove_group(self, place: int) -> None:
        """Take a group away with what is on its layers: a step that can be undone.

        Raises
        ------
        InputError
            If there is no layer at that index, it is in no group, no other layer would stay, or a
            stroke is going on.
        """
        self._restack("remove_group", lambda stack: stack.remove_group(place))

    @recorded
    def set_group_opacity(self, place: int, opacity: float) -> None:
        """Set how much of a group shows, 0 to 1: a step that can be undone.

        Raises
        ------
        InputError
            If there is no layer at that index, it is in no group, the opacity is out of range, or
            a stroke is going on.
        """
        self._restack(
            "set_group_opacity", lambda stack: stack.set_group_properties(place, opacity=opacity)
        )

    @recorded
    def set_group_blend(self, place: int, blend: str) -> None:
        """Set how a group blends, "normal" or "multiply": a step that can be undone.

        Raises
        ------
        InputError
            If there is no layer at that index, it is in no group, it is neither, or a stroke is
            going on.
        """
        self._restack(
            "set_group_blend", lambda stack: stack.set_group_properties(place, blend=blend)
        )

    @recorded
    def rename_group(self, place: int, name: str) -> None:
        """Name a group."""
        self.surface.use_layers().set_group_properties(place, name=name)
        self.mark_modified()

    @recorded
    def set_group_visible(self, place: int, visible: bool = True) -> None:
        """Show or hide a group.

        Raises
        ------
        InputError
            If there is no layer at that index, it is in no group, or a stroke is going on.
        """
        self._refuse_in_stroke(Message("showing or hiding a layer"))
        self.surface.use_layers().set_group_properties(place, visible=bool(visible))
        self.surface.touch(self.surface.use_layers().painted_ids())
        self.mark_modified()

    @recorded
    def set_group_folded(self, place: int, folded: bool = True) -> None:
        """List a group without its layers, or with them again."""
        self.surface.use_layers().set_group_properties(place, folded=bool(folded))
        self.mark_modified()

    def _free_group_name(self) -> str:
        return _first_free(layer.group.name for layer in self.layers if layer.group is not None)

    @recorded
    def duplicate_layer(self, place: int, name: str | None = None) -> None:
        """Put a copy of a layer above it, and paint on it: a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that index, the name is none, there are too many, or a stroke is
            going on.
        """
        name = name or _first_free(layer.name for layer in self.layers)
        self._restack("duplicate_layer", lambda stack: stack.duplicate(place, name))

    @recorded
    def merge_layer(self, place: int) -> None:
        """Make one layer of this and the one below, which dry: a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that index or below it, one of them is locked or hidden, or a stroke
            is going on.
        """
        stack = self.surface.use_layers()
        both = [k for k in (place - 1, place) if 0 <= k < len(stack)]
        for k in both:
            self._require_paintable(k)

        def merge(stack: LayerStack) -> None:
            for k in both if len(both) == 2 else ():
                self._undo.change(stack.state, partial(stack.activate, k))
                self.surface.dry()
            # a part of its own: undo comes to the layer that dried last before it takes that back
            self._undo.change(stack.state, lambda: stack.merge(place, self.surface.glaze))

        self._restack("merge_layer", merge)

    @recorded
    def set_opacity(self, place: int, opacity: float) -> None:
        """Set how much of a layer shows, 0 to 1: a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that index, the opacity is out of range, or a stroke is going on.
        """
        self._restack("set_opacity", lambda stack: stack.set_properties(place, opacity=opacity))

    @recorded
    def set_blend(self, place: int, blend: str) -> None:
        """Set how a layer blends, "normal" or "multiply": a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that index, it is neither, or a stroke is going on.
        """
        self._restack("set_blend", lambda stack: stack.set_properties(place, blend=blend))

    @recorded
    def rename_layer(self, place: int, name: str) -> None:
        """Name a layer."""
        self.surface.use_layers().set_properties(place, name=name)
        self.mark_modified()

    @recorded
    def set_visible(self, place: int, visible: bool = True) -> None:
        """Show or hide a layer.

        Raises
        ------
        InputError
            If there is none at that index, or a stroke is going on.
        """
        self._refuse_in_stroke(Message("showing or hiding a layer"))
        self.surface.use_layers().set_properties(place, visible=bool(visible))
        self.surface.touch(self.surface.use_layers().painted_ids())
        self.mark_modified()

    @recorded
    def set_locked(self, place: int, locked: bool = True) -> None:
        """Refuse painting on a layer, or allow it again."""
        self.surface.use_layers().set_properties(place, locked=bool(locked))
        self.mark_modified()

    def _restack(self, command: str, action: Callable[[LayerStack], None]) -> None:
        """Change which layers there are; ink that goes or comes with them is no longer loaded."""
        self._refuse_in_stroke(Message("changing the layers"))
        step = COMMANDS[command].undo_label
        if step and self._is_previewing:
            raise InputError(
                "“{step}” is not possible during a replay; end the replay first", step=step
            )
        surface, painter = self.surface, self.painter
        stack = surface.use_layers()
        self._refresh_colours()
        if step:
            self._undo.begin(step)
        before, shown = surface.wet_ink() + surface.dry_ink(), stack.painted_ids()
        try:
            self._undo.change(stack.state, lambda: action(stack))
        except BaseException:
            if step:
                self._queue_changed(self._undo.revert())
            raise
        painter.loaded += surface.wet_ink() + surface.dry_ink() - before
        if step:
            surface.touch(self._union([shown, stack.painted_ids()]))
            self.modified = True
        else:
            self.mark_modified()

    def _require_paintable(self, place: int | None = None) -> Layer:
        """Return the active layer, or the one at `place`; LayerError if it is locked or hidden."""
        layer = self.layers[self.active_layer if place is None else place]
        name = Message("Layer {number}", number=layer.name) if layer.name.isdigit() else layer.name
        if layer.locked:
            raise LayerError(
                "“{layer}” is locked; unlock it, or paint on another layer", layer=name
            )
        if not layer.visible:
            raise LayerError("“{layer}” is hidden; show it, or paint on another layer", layer=name)
        if not layer.is_seen:
            raise LayerError(
                "the group of “{layer}” is hidden; show it, or paint on another layer", layer=name
            )
        return layer

    # -- texts ------------------------------------------------------------------------------

    @property
    def texts(self) -> tuple[LaidText, ...]:
        """Texts that lie on the object to be written after."""
        return self._texts

    @recorded
    def lay_text(self, text: Mapping[str, Any], number: int | None = None) -> None:
        """Lay a text on the object to be written after: a step that can be undone.

        Parameters
        ----------
        text : mapping
            What `LaidText.words` gives.
        number : int, optional
            Of the text, from 0, which it replaces; by default it lies beside those there are.

        Raises
        ------
        InputError
            If it says no text, there is none of that number, or a stroke is going on.
        """
        laid = LaidText.of(text)
        self._change_texts("lay_text", number, (laid,))

    @recorded
    def remove_text(self, number: int) -> None:
        """Take a text off the object: a step that can be undone.

        Raises
        ------
        InputError
            If there is none of that number, or a stroke is going on.
        """
        self._change_texts("remove_text", number, ())

    def _change_texts(self, command: str, number: int | None, by: tuple[LaidText, ...]) -> None:
        self._refuse_in_stroke(Message("laying text"))
        count = len(self._texts)
        if number is None:
            number = count
        elif not 0 <= number < count:
            raise InputError(
                "text number is {number}; there are {count}, counted from 0",
                number=number,
                count=count,
            )
        changed = (*self._texts[:number], *by, *self._texts[number + 1 :])
        unpack_texts([text.words() for text in changed])  # not too many
        self._end_preview()
        self._undo.begin(COMMANDS[command].undo_label)
        self._texts = changed
        self._undo.end_part()
        self.modified = True

    # -- seals ------------------------------------------------------------------------------

    @recorded
    def press_seal(
        self,
        rings: Sequence[ArrayLike],
        at: ArrayLike,
        up: ArrayLike = (0.0, 0.0, 1.0),
        ink: Ink = PASTE,
        coats: float = 1.3,
        pad_mm: float = 3.0,
        wear: float = 1.0,
        seed: int = 1,
    ) -> float:
        """Press a seal onto the layer that is painted on: a step that can be undone.

        What is wet under the paste dries first; the paste lies on it and does not run.

        Parameters
        ----------
        rings : sequence of (N, 2) array_like
            What of the stone takes paste, mm from its middle, y upwards, by the even-odd rule.
        at : (3,) array_like
            Where the middle of the stone goes: the surface's closest point to it, mm.
        up : (3,) array_like
            What is up on the stone; not along the surface's normal.
        ink : ink or mixture
            The paste.
        coats, pad_mm, wear, seed
            See `calligraphy.seal.impression.Pressing`.

        Returns
        -------
        float
            How much of the stone's ink met the surface, 0 to 1.

        Raises
        ------
        InputError
            If a stroke is going on, the layer is locked or hidden, the rings are none, or the
            surface falls away from the stone.
        MeshError
            If the surface ends within the stone.
        """
        self._refuse_in_stroke(Message("pressing a seal"))
        seal = self._press.check(rings, coats, pad_mm, wear, seed)
        self._end_preview()
        self._require_paintable()
        touched = self._press.press(seal, at, up, ink, self.stencil)
        self.modified = True
        return touched

    # -- history ----------------------------------------------------------------------------

    @property
    def steps(self) -> UndoHistory:
        """Steps that can be undone."""
        return self._undo

    @property
    def can_undo(self) -> bool:
        """True if there is something to undo."""
        return bool(self._undo.done) or self.fewest_strokes < self.n_strokes_without_undo

    @property
    def can_redo(self) -> bool:
        """True if there is something to do again."""
        return bool(self._undo.undone) or self._can_edit_again

    @recorded
    def undo(self) -> AnyArray:
        """Take back the last step or edit; the brush stays the one that was chosen last.

        Where a stroke is the last that was done and no step takes it back, all are painted again
        first; see `recall_strokes`.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.
        """
        self.break_off()
        if not self._is_repainting and self.edits.ends_here:
            return self._exchange_edit(self.edits.undo)
        return self._undo_step()

    def _undo_step(self) -> AnyArray:
        self._is_previewing = self.looks_back = False
        if not self._undo.done and self.can_undo:
            self.recall_strokes()
        painter, steps = self.painter, self._undo
        brush, dipped, amount = painter.brush, painter.dipped, painter.amount
        touched = []
        while steps.done and steps.done[-1] == _EDIT_STEP:
            touched.append(steps.undo())
        touched.append(steps.undo())
        now = painter.brush, weights_of(painter.dipped), painter.amount
        if now != (brush, weights_of(dipped), amount):
            painter.change_brush(brush)
            painter.dip(dipped, amount=amount)
            self._dipped_since_stroke = True
        return self._follow_steps(touched)

    @recorded
    def redo(self) -> AnyArray:
        """Do again what was undone last; returns as `undo`."""
        self.break_off()
        if self._can_edit_again:
            return self._exchange_edit(self.edits.redo)
        return self._redo_step()

    def _redo_step(self) -> AnyArray:
        self._is_previewing = self.looks_back = False
        steps = self._undo
        touched = [steps.redo()]
        while steps.undone and steps.done[-1] == _EDIT_STEP:
            touched.append(steps.redo())
        return self._follow_steps(touched)

    def _follow_log(self) -> None:
        """Update the strokes that are there from the steps that are done."""
        self._log.follow([label for label in self._undo.done if isinstance(label, Stroke)])

    def _follow_steps(self, touched: Sequence[AnyArray]) -> AnyArray:
        """Update strokes, `modified` and changed vertices after steps were undone or redone."""
        self._follow_log()
        self.update_modified()
        vertex_ids = self._union(touched)
        self._queue_changed(vertex_ids)
        return vertex_ids

    def update_modified(self) -> None:
        """Set `modified` by whether the current undo step is the saved one."""
        self.modified = self._undo.next_undo != self._saved_at

    @property
    def undone_strokes(self) -> list[Stroke]:
        """Strokes that were taken back and can be done again, the next one first."""
        return [label for label in reversed(self._undo.undone) if isinstance(label, Stroke)]

    @recorded
    def replay_history(self, upto: int, passing: bool = False) -> AnyArray:
        """Show the painting as it was before the next stroke began, by undo and redo.

        Strokes that no step takes back are painted again where that is needed; see
        `recall_strokes`.

        Parameters
        ----------
        upto : int
            After how many strokes: from `fewest_strokes` to as many as there are with those that
            were undone.
        passing : bool
            Only to look at: what is painted next comes after all strokes, not in their stead.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError
            If there are not so many, or they lie over a recording.
        """
        self.break_off()
        most = len(self.strokes) + len(self.undone_strokes)
        if not self.fewest_strokes <= upto <= most:
            raise InputError(
                "the history cannot go to stroke {upto}; expected {fewest} to {most}",
                upto=upto,
                fewest=self.fewest_strokes,
                most=most,
            )
        touched: list[AnyArray] = []
        if upto < self.n_strokes_without_undo:
            touched.append(self.recall_strokes())
        while len(self.strokes) > upto:
            touched.append(self._undo_step())
        while len(self.strokes) < upto or self._next_redo_is_no_stroke():
            touched.append(self._redo_step())
        self._is_previewing, self.looks_back = passing, upto < most
        return self._union(touched)

    def _end_preview(self) -> None:
        """Do all again that was undone only to look at what was before."""
        if self._is_previewing:
            self.replay_history(len(self.strokes) + len(self.undone_strokes))

    def _next_redo_is_no_stroke(self) -> bool:
        """Return whether what can be done again next is drying, or a change of the layers."""
        undone = self._undo.undone
        return bool(undone) and not isinstance(undone[-1], Stroke)

    def recording(self, first: int = 0) -> Recording | None:
        """The strokes from index `first` on as one recording in the object's frame, with dips.

        None if there are none.
        """
        return self._log.recording(self.surface.source.name, first)

    # -- strokes that no step takes back ----------------------------------------------------

    @property
    def n_strokes_without_undo(self) -> int:
        """Number of first strokes that have no undo step; `recall_strokes` gives them steps."""
        return self._log.n_before

    @property
    def fewest_strokes(self) -> int:
        """Smallest number of strokes that `replay_history` can go back to.

        Strokes over a recording cannot be painted again: what it painted is no stroke.
        """
        return self.n_strokes_without_undo if self._recordings else 0

    def recall_strokes(self) -> AnyArray:
        """Paint the strokes that no step takes back once more, so that all can be taken back.

        The painting stays as it is, to the bit. Layers are those of the strokes' names in the order
        in which they come; what was dried, moved, mirrored, masked, or let run meanwhile is not
        repeated.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed meanwhile.

        Raises
        ------
        InputError
            If a stroke is going on, or there is a recording under the strokes.
        """
        self._refuse_in_stroke(Message("undoing earlier strokes"))
        count = self.n_strokes_without_undo
        if not count:
            return self._union([])
        if self.fewest_strokes:
            raise InputError(
                "the first {count} strokes lie over a recording and cannot be repainted; choose "
                "stroke {count} or a later one",
                count=count,
            )
        self._refresh_colours()
        painter = self.painter
        brush, since_dip = painter.brush, self._dipped_since_stroke
        amount, dips = painter.amount, dips_of(painter)
        n_done = len(self._undo.done)
        touched = [self._undo.undo() for _ in range(n_done)]
        touched.append(self.surface.use_layers().painted_ids())
        strokes = self.strokes[:count]
        try:
            recall = StrokeRecall(painter, self._undo, self.progress)
            self._undo.prepend(lambda: recall.make_bare(strokes[0]), lambda: recall.repeat(strokes))
            self._log.hold(len(self.strokes))
            if self._saved_at == 0:  # before all steps that there were
                self._saved_at = self._undo.next_undo
        finally:
            touched += [self._undo.redo() for _ in range(n_done)]
            now = painter.brush, named_dips(dips_of(painter)), painter.amount
            if now != (brush, named_dips(dips), amount):
                painter.change_brush(brush)
                for ink, reach in dips:  # the belly, and then the tip
                    painter.dip(ink, reach, amount if reach is None else None)
            self._dipped_since_stroke = since_dip
            vertex_ids = self._union(touched)
            self.surface.touch(vertex_ids)
            self._queue_changed(vertex_ids)
        self.recorder = None  # what is painted again is not what was
        return vertex_ids

    # -- edits of strokes -------------------------------------------------------------------

    # Neither edit is `recorded`: the edited score replaces the one that was recorded.

    def edit_strokes(self, indices: Sequence[int], edit: Mapping[str, Any]) -> AnyArray:
        """Edit strokes, several as one, and paint everything after the first anew: one undo step.

        Strokes that were undone to look at what was before come back first.

        Parameters
        ----------
        indices : sequence of int
            Of the strokes among `strokes` and, after them, `undone_strokes`.
        edit : mapping
            See `score_edits.apply_stroke_edit`; the ink may be one in hand, the brush a
            `BrushSpec`, and the brushes of strokes that are scaled are theirs, scaled.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError, RecordingError
            If no stroke is named or there is no such stroke, it is not known from the beginning
            what was painted, or the edit cannot be done; everything is as it was then.
        """
        chosen = sorted(dict.fromkeys(indices))
        if not chosen:
            raise InputError("no stroke is chosen; expected one or several")
        score = self._score_to_edit()
        spans = locate_strokes(score, len(self.strokes), len(self.undone_strokes))
        for index in chosen:
            self._check_index(index, len(self.strokes))
        words = self._serialize_edit(edit, score)
        if edit.get("do") == "scale" and "factor" in edit:
            brushes = [scaled(self.strokes[k].brush, edit["factor"]) for k in chosen]
            words = {**words, "brushes": [encode_brush(brush) for brush in brushes]}
        edited = apply_stroke_edit(score, [spans[k][0] for k in chosen], words, self.surface.source)
        first = first_difference(score, edited)
        back = max((k for k, (_, begin) in enumerate(spans) if begin <= first), default=0)
        back = min([back, *chosen])
        self._check_index(back, len(self.strokes))
        return self._repaint_from(
            edited, lambda: len(self.strokes) > back, min(spans[back][1], first)
        )

    @property
    def n_seals(self) -> int:
        """Number of seals that undo steps take back."""
        return self._undo.done.count(COMMANDS["press_seal"].undo_label)

    def pressed_seals(self) -> list[dict[str, Any]]:
        """Commands of the seals that are there, as lines of the score."""
        score = self.score
        if score is None:
            return []
        lines = [score.events[seal.begin] for seal in follow_steps(score).seals]
        return [dict(line) for line in lines if not isinstance(line, Recording)]

    def edit_seal(self, index: int, edit: Mapping[str, Any]) -> AnyArray:
        """Edit a seal, and paint everything after it anew: a step that can be undone.

        Parameters
        ----------
        index : int
            Of the seal among those that are there.
        edit : mapping
            See `score_edits.apply_seal_edit`; the ink may be one in hand.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError, RecordingError
            If there is no such seal, no step leads back to it, or the edit cannot be done;
            everything is as it was then.
        """
        score = self._score_to_edit()
        seals = follow_steps(score).seals
        n_seals = self.n_seals
        if not 0 <= index < len(seals) or len(seals) != n_seals:
            raise InputError(
                "seal {number} cannot be edited: the score has {count} seals, undo reaches {steps}",
                number=index + 1,
                count=len(seals),
                steps=n_seals,
            )
        words = self._serialize_edit(edit, score)
        edited = apply_seal_edit(score, index + 1, words)
        step = COMMANDS["press_seal"].undo_label
        return self._repaint_from(
            edited, lambda: self._undo.done.count(step) > index, seals[index].begin
        )

    def _score_to_edit(self) -> Score:
        """The score, during no stroke, with all done again that was undone to look back."""
        self.check_access()
        self.break_off()
        if self.recorder is None or not self.recorder.is_whole:
            raise InputError(
                "only the strokes of this painting are known, not the commands between them, so "
                "they cannot be edited; save the strokes as a whole painting and replay it"
            )
        if self.looks_back:
            self.replay_history(len(self.strokes) + len(self.undone_strokes))
        score = self.score
        assert score is not None, "it is kept"
        return score

    def _check_index(self, index: int, count: int) -> None:
        if not 0 <= index < count:
            if count <= index < count + len(self.undone_strokes):
                raise InputError(
                    "stroke {number} is undone; expected 1 to {count}",
                    number=index + 1,
                    count=count,
                )
            raise InputError(
                "there is no stroke {number}; expected 1 to {count}",
                number=index + 1,
                count=count,
            )
        if index < self.n_strokes_without_undo:
            raise InputError(
                "undo does not reach stroke {number}; choose {first} or later, or save the strokes "
                "as a whole painting and replay it",
                number=index + 1,
                first=self.n_strokes_without_undo + 1,
            )

    def _serialize_edit(self, edit: Mapping[str, Any], score: Score) -> Mapping[str, Any]:
        """An edit in the form that a score can apply."""
        if edit.get("do") == "ink" and "ink" in edit:
            inks = InkTable.of(score.header)
            return {**edit, "ink": inks.encode(edit["ink"]), "pigments": inks.table}
        if isinstance(edit.get("brush"), BrushSpec):
            return {**edit, "brush": encode_brush(edit["brush"])}
        return edit

    def _repaint_from(self, edited: Score, goes_on: Callable[[], bool], begin: int) -> AnyArray:
        """Go back while there is something to undo, and play the edited score from an event on."""
        recorder, steps = self.recorder, self._undo
        assert recorder is not None, "it was looked at"
        self._refresh_colours()
        before, last_step, n_done = self._in_hand(), steps.next_undo, len(steps.done)
        layers = self.surface.use_layers().layers
        later_step, ids = steps.lay_aside_since()
        touched = [ids]
        while goes_on():
            touched.append(steps.undo())
            self._follow_log()
        n_shared = len(steps.done)
        redo_stack = steps.exchange_undone(())
        version = Version(
            n_shared, redo_stack, n_done - n_shared, later_step, recorder, last_step, last_step, 0
        )
        try:
            with recorder.suspended(), self._restore_context(edited, begin):
                self._play_edited(edited, begin)
        except BaseException:
            with recorder.suspended():
                self.cancel_stroke()
            touched += self.edits.exchange(version)
            self.recorder = recorder
            self._follow_log()
            raise
        else:
            self.edits.add(version)
            self.recorder = ScoreRecorder(edited.header, edited.events)
            self.update_modified()
        finally:
            self._restore_layer_properties(layers)
            self._take_in_hand(before)
            vertex_ids = self._union(touched)
            self.surface.touch(vertex_ids)
            self._queue_changed(vertex_ids)
        return vertex_ids

    def _play_edited(self, edited: Score, begin: int) -> None:
        """Play a score from an event on; the first step of it must be one by itself."""
        first = edited.events[begin] if begin < len(edited.events) else {"do": ""}
        if isinstance(first, Recording) or first["do"] != "begin_stroke":
            self._undo.begin(_EDIT_STEP)
        for step in play(self, without_refusals(edited, begin), begin):
            if self.progress is not None:
                self.progress(min(step.fraction, 0.999))
        if self._log.current is not None:
            self.end_stroke()

    @contextmanager
    def _restore_context(self, score: Score, begin: int) -> Iterator[None]:
        """Restore, within, symmetry, mask and the like of then; all layers visible and unlocked."""
        stack, saved_at = self.surface.use_layers(), self._saved_at
        strokes, tags, azimuth = self._strokes, dict(self._log.tags), self.painter.azimuth
        now = strokes.symmetry, strokes.mask, strokes.stencil
        inks = list(self.inks)
        self._is_repainting = True
        self._apply_settings_at(score, begin)
        for k in range(len(stack.layers)):
            stack.set_properties(k, visible=True, locked=False)
            if stack.layers[k].group is not None:
                stack.set_group_properties(k, visible=True)
        try:
            yield
        finally:
            strokes.symmetry, strokes.mask, strokes.stencil = now
            self._log.tags, self.painter.azimuth = tags, azimuth
            self.inks, self._saved_at, self._is_repainting = inks, saved_at, False

    def _restore_layer_properties(self, layers: Sequence[Layer]) -> None:
        """Give the layers the names, visibility and locks that they had."""
        stack = self.surface.use_layers()
        if len(stack.layers) == len(layers):
            for k, layer in enumerate(layers):
                stack.set_properties(k, name=layer.name, visible=layer.visible, locked=layer.locked)
                group, now = layer.group, stack.layers[k].group
                if group is not None and now is not None:
                    stack.set_group_properties(
                        k, name=group.name, visible=group.visible, folded=group.folded
                    )

    def _apply_settings_at(self, score: Score, begin: int) -> None:
        """Set symmetry, mask, tags and azimuth as the score had them before event `begin`."""
        vocabulary = Vocabulary(self.surface, InkTable.of(score.header))
        calls: dict[str, Mapping[str, Any]] = {
            "set_symmetry": {"symmetry": Symmetry()}, "set_mask": {"mask": Mask()},
            "set_tags": {}, "set_azimuth": {"azimuth": score.header.get("azimuth", "commanded")},
        }  # fmt: skip
        for event in score.events[:begin]:
            if isinstance(event, Recording) or event.get("refused"):
                continue
            if event["do"] in calls:
                calls[event["do"]] = decode_arguments(event, vocabulary)
        for name, arguments in calls.items():
            getattr(self, name)(**arguments)

    @property
    def _can_edit_again(self) -> bool:
        return not self._is_repainting and self.edits.continues_here

    def _exchange_edit(self, turn: Callable[[ScoreRecorder | None], Turned]) -> AnyArray:
        """Exchange the painting for the other version of the last edit."""
        before = self._in_hand()
        touched, self.recorder = turn(self.recorder)
        vertex_ids = self._follow_steps(touched)
        self._take_in_hand(before)
        self._is_previewing = self.looks_back = False
        return vertex_ids

    def _in_hand(self) -> tuple[BrushSpec, Any, DipAmount]:
        return self.painter.brush, self.painter.dipped, self.painter.amount

    def _take_in_hand(self, in_hand: tuple[BrushSpec, Any, DipAmount]) -> None:
        """Restore the brush, the ink and the amount of it that were chosen last."""
        brush, dipped, amount = in_hand
        if self.painter.brush != brush:
            self.set_brush(brush)
        now = weights_of(self.painter.dipped), self.painter.amount
        if now != (weights_of(dipped), amount):
            self.dip(dipped, amount=amount.words())

    # -- what is shown --------------------------------------------------------------------

    def refresh(self) -> AnyArray:
        """Bring the colours up to date; (N,) int32 vertices that changed since the last call."""
        self.check_access()
        self._refresh_colours()
        pending, self._pending = self._pending, []
        if len(pending) == 1:
            return pending[0]
        return self._union(pending)

    def _refresh_colours(self) -> None:
        """Refresh colours; the next `refresh` returns the vertices that changed."""
        self._queue_changed(self.surface.refresh())

    def _union(self, parts: Sequence[AnyArray]) -> AnyArray:
        """Vertices of several arrays, each once."""
        return union(parts, self.surface.paint_mesh.capacity)

    def _queue_changed(self, vertex_ids: AnyArray) -> None:
        if len(vertex_ids):
            self._pending.append(vertex_ids)


def _stat(path: str | os.PathLike[str] | None) -> FileState | None:
    """Inode, mtime (ns) and size of a file; None if it is missing."""
    try:
        stat = os.stat(path) if path is not None else None
    except OSError:
        return None
    return stat and (stat.st_ino, stat.st_mtime_ns, stat.st_size)


def _first_free(names: Iterable[str]) -> str:
    """The first number, from 1, that is none of the names."""
    taken = set(names)
    return next(str(n) for n in count(1) if str(n) not in taken)

"""A painting in the studio: the object, the brush, its strokes, and the way back.

No window, no thread and no clock: whoever calls says when. `paint3d.app.model.easel` runs one of
these in a thread of its own.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from paint3d.app.model.brush_commands import BrushCommands, Ink
from paint3d.app.model.history_commands import EditCommands
from paint3d.app.model.image_painter import ImagePainter
from paint3d.app.model.input.symmetry import Symmetry
from paint3d.app.model.layer_commands import LayerCommands
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.persistence.brush_words import brush_words, hair_words
from paint3d.app.model.persistence.saved_history import MOST_BYTES, restore_history, saved_history
from paint3d.app.model.persistence.saved_settings import (
    DEFAULT_BRUSH,
    DEFAULT_INKS,
    saved_inks,
    saved_painter,
    saved_unit,
)
from paint3d.app.model.score.keeping import ScoreKeeper, keeps_score
from paint3d.app.model.seals.seal_commands import SealCommands
from paint3d.app.model.stroke_commands import StrokeCommands
from paint3d.app.model.stroke_log import StrokeLog, names_apart, strokes_of, weights_of
from paint3d.brush.spec import BrushSpec
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError, Paint3DError, SessionError
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
from paint3d.painter.painter import Painter
from paint3d.recording.score import Score
from paint3d.surface.ink_store import union
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import MEMORY_BUDGET, UndoHistory
from paint3d.view.pressed_tuft import TuftFollower

__all__ = ["Document", "FileState"]

FileState = tuple[int, int, int]
"""What becomes another one when somebody writes a file: its number, time (ns) and bytes."""


@keeps_score
class Document(BrushCommands, StrokeCommands, LayerCommands, SealCommands, EditCommands):
    """One painting, with everything that can be done to it.

    Make it with `Document.new` or `Document.open`. What can be done to it is in `brush_commands`,
    `stroke_commands`, `layer_commands`, `seals` and `history_commands`.

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
    tuft_follower : TuftFollower
        Finds how the tuft lies on the surface, for drawing it.
    modified : bool
        Whether it is otherwise than it was saved; undo and redo may lead back there.
    left_out : bool
        Whether some steps found no room in the file when it was saved last.
    keeper : ScoreKeeper or None
        Writes down what is asked, to be played again; None where how it began is not known.
    refused_history : str
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
        self._written = _written(path)
        self.unit = unit
        self.settings: dict[str, Any] = dict(saved.settings if saved else {})
        at_hand = saved_inks(surface, self.settings)
        self.inks: list[Ink] = list(at_hand or (painter.dipped, DEFAULT_INKS[1]))
        self.modified = False
        self._saved_at: int | None = 0
        self.left_out = False
        self._recordings = tuple(saved.recordings if saved else ())
        self._log = StrokeLog(saved.strokes if saved else (), self.settings.get("brushes", {}))
        surface.use_layers()
        self._dipped = self.settings.get("fresh", True) is not False
        self._undo = UndoHistory(surface, undo_bytes, self._keep, self._restore)
        self._edits, self._unedits = [], []
        self.keeper = self._keeper(saved)
        self.refused_history = self._take_history(saved)
        self._saved_at = self._undo.next_undo
        self.symmetry = Symmetry()
        self.mask = Mask()
        self._stencil: Stencil | None = None
        self._images: list[ImagePainter] = []
        self._refused = False
        surface.keeps_up = self.settings.pop("behind", False) is not True
        self._pending: list[AnyArray] = []
        self.tuft_follower = TuftFollower()

    def _keeper(self, saved: Session | None) -> ScoreKeeper | None:
        if saved is None:
            return ScoreKeeper.begin(self.surface, self.painter)
        if saved.score is None:
            return None
        return ScoreKeeper.resumed(saved.score, len(saved.strokes))

    @property
    def score(self) -> Score | None:
        """All that happened; None where that is not known from the beginning.

        `score_of_strokes` then tells of the strokes alone.
        """
        return None if self.keeper is None else self.keeper.score(self.surface.source.name)

    def _take_history(self, saved: Session | None) -> str:
        """Have the way back that was saved; why not, where it is damaged."""
        if saved is None or saved.history is None:
            return ""
        try:
            undone = strokes_of(saved.undone, self.settings.get("brushes"))
            log = self._log
            held = restore_history(self.surface, self._undo, saved.history, log.strokes, undone)
        except SessionError as error:
            return str(error)
        self._log.hold(held)
        return ""

    def _keep(self) -> dict[str, object]:
        """What undo brings back besides the surface."""
        return {"painter": self.painter.keep(), "dipped": self._dipped}

    def _restore(self, kept: Any) -> None:
        self.painter.restore(kept["painter"])
        self._dipped = kept["dipped"]

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
        ink: Ink = DEFAULT_INKS[0],
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
        with the share done, now and then; what it raises stops it.

        Raises
        ------
        SessionError, MeshError
            If the file cannot be used.
        """
        if not is_session_path(path):
            return cls.new(path, resolution, material, unit=unit, undo_bytes=undo_bytes)
        written = _written(path)
        session = load_session(path, progress)
        try:
            painter = saved_painter(session.surface, session.settings)
            unit = saved_unit(session.settings)
            opened = cls(session.surface, painter, Path(path), session, unit, undo_bytes)
            opened._written = written
            return opened
        except Paint3DError as cause:
            raise SessionError(f"{path}: {cause}") from None

    def save(
        self, path: str | os.PathLike[str] | None = None, *, progress: Progress | None = None
    ) -> None:
        """Save everything to a session, by default to the one it came from.

        `progress` is called with the share done, and with 1 before the file takes its place; what
        it raises leaves everything as it was.

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
        self.save_copy(path, progress)
        self.belong_to(path)
        self.modified, self._saved_at = False, self._undo.next_undo

    def save_copy(self, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
        """Write everything to a session that is not the painting's own; see `save`."""
        self._gather()
        save_session(self._session(), path, progress)

    def belong_to(self, path: Path | None, as_known: FileState | None = None) -> None:
        """Have this as the session's file.

        Parameters
        ----------
        path : Path or None
        as_known : FileState, optional
            What `file_state` was when it was written or read last; by default, as it lies on the
            disk now.
        """
        self.path, self._written = path, as_known or _written(path)

    @property
    def file_state(self) -> FileState | None:
        """What the session's file was when it was opened or saved here; None: it has none."""
        return self._written

    @property
    def is_written_by_others(self) -> bool:
        """Whether the session's file is another than the one that was opened or saved here."""
        now = _written(self.path)
        return now is not None and now != self._written

    def differ_from_saved(self) -> None:
        """Know that something changed that no undo takes back."""
        self.modified, self._saved_at = True, None

    def _session(self) -> Session:
        settings = {**self.settings, "brush": brush_words(self.painter.brush)}
        settings |= {"ink": self.painter.ink.name, "unit": self.unit}
        settings["azimuth"] = self.painter.azimuth
        settings["hairs"] = hair_words(self.painter)
        settings["dipped"] = weights_of(self.painter.dipped)
        settings["amount"] = self.painter.amount.words()
        settings["dips"] = [[weights_of(ink), reach] for ink, reach in self.painter.dips]
        settings["fresh"] = self._dipped
        if not self.surface.keeps_up:
            settings["behind"] = True
        settings["inks"] = [weights_of(ink) for ink in self.inks]
        history, gone = saved_history(self.surface, self._undo, self._log.current, MOST_BYTES)
        kept, steps = len(history["done"]) + len(history["undone"]), self._undo
        self.left_out = kept < len(steps.done) + len(steps.undone)
        names = names_apart(stroke.brush for stroke in (*self.strokes, *gone))
        settings["brushes"] = {name: brush_words(brush) for brush, name in names.items()}
        strokes = tuple(stroke.recording(names[stroke.brush]) for stroke in self.strokes)
        undone = tuple(stroke.recording(names[stroke.brush]) for stroke in gone)
        score = None if self.in_stroke else self.score  # what of it is painted, nobody could say
        return Session(self.surface, self._recordings, settings, strokes, undone, history, score)

    def export(
        self,
        path: str | os.PathLike[str],
        *,
        progress: Progress | None = None,
        **options: Any,
    ) -> None:
        """Write the painting in the format that the suffix names; see `paint3d.export`.

        `progress` is called with the share done, and with 1 before the file takes its place; what
        it raises leaves everything as it was.

        Raises
        ------
        ExportError, InputError
            If the suffix, an option or the file is no good.
        """
        check_export_path(path)
        if is_session_path(path):
            self.save_copy(path, progress)
            return
        self._gather()
        told = part_of(progress, 0.0, 0.6)
        prepared = prepare_export(self.surface, path, ExportOptions(**options), told)
        prepared.write(part_of(progress, 0.6, 1.0))

    def prepare_export(
        self, path: str | os.PathLike[str], options: ExportOptions, progress: Progress | None = None
    ) -> PreparedExport:
        """Take what an export needs, to be written while painting goes on.

        See `paint3d.files.export.prepare_export`.
        """
        self._gather()
        return prepare_export(self.surface, path, options, progress)

    # -- what is shown --------------------------------------------------------------------

    def refresh(self) -> AnyArray:
        """Bring the colours up to date; (N,) int32 vertices that changed since the last call."""
        self._gather()
        pending, self._pending = self._pending, []
        if len(pending) == 1:
            return pending[0]
        return union(pending, self.surface.paint_mesh.capacity)

    def _gather(self) -> None:
        """Remember what a refresh finds, whoever asks for colours."""
        self._note(self.surface.refresh())

    def _note(self, vertex_ids: AnyArray) -> None:
        if len(vertex_ids):
            self._pending.append(vertex_ids)


def _written(path: str | os.PathLike[str] | None) -> FileState | None:
    """As the file lies there now; None where there is none."""
    try:
        found = os.stat(path) if path is not None else None
    except OSError:
        return None
    return found and (found.st_ino, found.st_mtime_ns, found.st_size)

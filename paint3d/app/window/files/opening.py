"""Opening objects and paintings; compiling kernels ahead of the first stroke."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.input.hand import Hand, PointerInput
from paint3d.app.model.persistence.saved_settings import chosen_brush, chosen_inks, chosen_material
from paint3d.app.window.files.file_dialogs import ask_file
from paint3d.app.window.files.open_result import OpenResult, open_with_progress
from paint3d.app.window.files.recovery import open_elsewhere
from paint3d.app.window.files.saving import RecentFiles, Saving
from paint3d.app.window.job import JobProgress
from paint3d.app.window.object.new_dialog import NewDialog
from paint3d.app.window.object.standing import Standing
from paint3d.app.window.wording import say, say_object
from paint3d.app.window.workspace import Workspace
from paint3d.brush_engine.stroke_loop import paint_samples
from paint3d.core.kernel import is_ahead, is_compiled
from paint3d.device.sample import DeviceSample
from paint3d.files.load import MESH_SUFFIXES, is_built_in, read_mesh
from paint3d.files.progress import part_of
from paint3d.files.project.session import SESSION_SUFFIX, is_session_path
from paint3d.files.reading import Reading
from paint3d.mesh.sheets import is_sheet, parse_sheet
from paint3d.pose.brush_pose import object_poses
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.view.brush_shape import BrushStand, tuft_rings
from paint3d.view.kernels.chunks import cone_of
from paint3d.view.kernels.drape import drape_points
from paint3d.view.kernels.enlarge import enlarge
from paint3d.view.kernels.shine import add_shine
from paint3d.view.live_layers import Enlarger
from paint3d.view.live_object import LiveObject

__all__ = ["Opening", "is_first_start", "is_warm", "say_warming", "warm_up"]

# ---- Warming up ----------------------------------------------------------------------------------
# Compiling, ahead of the first stroke, what the window's own thread will run.


_MS = 1_000_000
_LOOK_S = 0.1
_warm: list[bool] = []
_one_at_a_time = threading.Lock()


def is_first_start() -> bool:
    """Return whether the kernels were never compiled here, which takes a minute."""
    return not is_compiled(paint_samples)


def is_warm() -> bool:
    """Return whether all kernels were compiled ahead and have not changed since."""
    return all(map(is_ahead, (paint_samples, drape_points, cone_of, add_shine, enlarge)))


def warm_up(progress: Callable[[float], None] = lambda _: None) -> None:
    """Paint a stroke that nobody sees; once, some tenths of a second, a minute the first time.

    Parameters
    ----------
    progress : callable
        Called with the fraction done between the steps; what it raises stops them.
    """
    while not _one_at_a_time.acquire(timeout=_LOOK_S):  # a cancelled one goes on for a while
        progress(0.0)
    try:
        if not _warm:
            _paint_unseen(progress)
            _warm.append(True)
    finally:
        _one_at_a_time.release()


def _paint_unseen(progress: Callable[[float], None]) -> None:
    document = Document.new("plane", 4.0, "xuan")
    hand, brush = Hand(document.surface.closest_points), document.painter.brush
    shown = LiveObject(document.surface)
    for upload in shown.uploads(document.refresh()):
        cone_of(upload.points, upload.faces, np.zeros(4))
    progress(0.2)
    document.begin_stroke()
    samples = hand.begin(_over(0), brush)
    assert samples is not None, "the pen is over the sheet"
    for k in range(1, 6):
        samples += hand.move(_over(k), brush)
    document.feed(samples)
    progress(0.7)
    document.end_stroke()
    document.let_time_pass(0.05)
    progress(0.9)
    shown.uploads(document.refresh())
    _draw_moving(shown)
    _place_brush(document, samples[-1])
    progress(0.98)
    document.undo()


def _over(k: int) -> PointerInput:
    """Return a pen's event over the sheet."""
    above, down = (2.0 * k, 0.0, 90.0), (0.0, 0.0, -1.0)
    return PointerInput(10 * _MS * (k + 1), origin=above, direction=down, pressure=0.5)


def _draw_moving(shown: LiveObject) -> None:
    """Run what draws while the view moves."""
    coarse = shown.coarse_for(1.0, 1000)
    assert coarse is not None, "it is asked for the first time"
    lamps, lobes, out = np.zeros((1, 6)), np.ones((3, 2)), coarse.colours.copy()
    add_shine(
        coarse.points, coarse.normals, coarse.colours, np.zeros(3), lamps, lobes, PLAIN_SHINE, out
    )
    Enlarger((1, 1), (2, 2)).enlarge(np.zeros((1, 1, 4), np.uint8), np.zeros((2, 2, 4), np.uint8))


def _place_brush(document: Document, sample: DeviceSample) -> None:
    """Run what places and bends the brush for drawing."""
    painter, tree = document.painter, document.surface.contact_tree
    pressed = document.tuft_follower.follow(painter, object_poses([sample]))
    stand = BrushStand.of(painter.tuft, sample.position, np.eye(3), pressed)
    rings, _ = tuft_rings(painter.tuft, stand)
    points = np.ascontiguousarray(rings[:, 0])
    out, landed = np.zeros((len(points), 6)), np.zeros(len(points), np.uint8)
    drape_points(tree, points, np.array([0.0, 0.0, -1.0]), 50.0, out, landed)
    stand.outline()


# ---- Opening -------------------------------------------------------------------------------------


class Opening:
    """Opens paintings and mesh files in the window, and begins new ones.

    Attributes
    ----------
    unit, up : str or None
        Unit of mesh files, and their axis that points up, where the user gave them; see
        `load_mesh`.
    """

    def __init__(
        self, workspace: Workspace, saving: Saving, standing: Standing, recent: RecentFiles
    ) -> None:
        self._workspace, self._saving = workspace, saving
        self._standing, self._recent = standing, recent
        self.unit: str | None = None
        self.up: str | None = None

    # -- asking -----------------------------------------------------------------------------

    def do_new(self) -> None:
        """Ask for an object, a material and a fineness, and begin."""
        dialog = NewDialog(self._workspace.window, self._workspace.settings)
        if not dialog.exec() or not self._saving.may_leave():
            return
        name, material, resolution = dialog.chosen()
        self._workspace.update_settings(begun_on=name)
        if not is_sheet(name):  # which each have a material and a detail that suit them
            self._workspace.update_settings(material=material, resolution_mm=resolution)
        if name:
            self.open_path(name, resolution, material, asked=True)
        else:
            self.do_open(resolution, material, asked=True)

    def do_open(
        self, resolution: float | None = None, material: str | None = None, *, asked: bool = False
    ) -> None:
        """Ask for a file, and open it; see `open_path`."""
        meshes = " ".join(f"*{suffix}" for suffix in (SESSION_SUFFIX, *MESH_SUFFIXES))
        kinds = f"{say('Objects and paintings')} ({meshes});;{say('All files')} (*)"
        path = ask_file(self._workspace.window, say("Open…").rstrip("…"), kinds)
        if path:
            self.open_path(path, resolution, material, asked=asked)

    # -- opening ----------------------------------------------------------------------------

    def open_path(
        self,
        path: str,
        resolution: float | None = None,
        material: str | None = None,
        *,
        asked: bool = False,
    ) -> bool:
        """Open a painting, a mesh or a built-in object; return whether that succeeded.

        If it is stopped or fails, the painting that is open stays as it is.

        Parameters
        ----------
        path : str
        resolution : float, optional
            mm; of a mesh. By default what was chosen last.
        material : str, optional
            Of a mesh. By default what was chosen last.
        asked : bool
            Whether the user was already asked about the open painting.
        """
        if self._workspace.is_waiting:
            return False
        if (
            not asked
            and self._workspace.stage.paint_thread is not None
            and not self._saving.may_leave()
        ):
            return False
        self._workspace.error = None
        if not is_warm() and not self._workspace.went_well(
            self._workspace.run(say_warming(), _warm_up)
        ):
            return False
        title = say("Opening {name}…", name=say_object(Path(path).name))
        if is_session_path(path):
            done: Future[Any] | None = self._open_session(path, title)
        else:
            done = self._open_mesh(path, title, resolution, material)
        if done is None or not self._workspace.went_well(done):
            return False
        if not self._workspace.show(done.result()):
            return False
        self._standing.report_assumptions()
        if not is_built_in(str(path)):
            self._recent.add(path)
        for message in open_elsewhere(self._workspace):
            self._workspace.tell(message, state="bad", stays=True)
        return True

    def _open_session(self, path: str, title: str) -> Future[Any]:
        undo_bytes = self._undo_bytes()

        def work(progress: JobProgress) -> OpenResult:
            message = part_of(progress, 0.0, 0.9)
            document = Document.open(path, undo_bytes=undo_bytes, progress=message)
            return open_with_progress(document, progress, 0.9)

        return self._workspace.run(title, work)

    def _open_mesh(
        self, path: str, title: str, resolution: float | None, material: str | None
    ) -> Future[Any] | None:
        settings = self._workspace.settings
        resolution = settings.resolution_mm if resolution is None else resolution
        if material is None:
            suited = is_sheet(path) and not Path(path).is_file()
            material = parse_sheet(path).usual.material if suited else chosen_material(settings)

        def read(progress: JobProgress) -> Reading:
            message = _before_one(progress)
            mesh = read_mesh(path, self.unit, texture=True, up=self.up, progress=message)
            _ = mesh.mesh.face_normals, mesh.mesh.bounds  # here, not in the window's thread
            if not is_built_in(path):
                _ = mesh.up_by_shape
            return mesh

        loaded = self._workspace.run(title, read)
        if not self._workspace.went_well(loaded):
            return None
        reading = loaded.result()
        choice = self._standing.choose(
            path, reading, material, resolution, ask=not self._workspace.quiet
        )
        if choice is None:
            return None
        self._workspace.remember_in_hand()
        settings = self._workspace.settings
        brush, inks = chosen_brush(settings), chosen_inks(settings)
        undo_bytes = self._undo_bytes()

        def make(progress: JobProgress) -> OpenResult:
            mesh = reading.mesh
            if not choice.coloured:  # as it was before it was refined for its picture
                message = part_of(progress, 0.0, 0.4)
                mesh = read_mesh(path, self.unit, up=self.up, progress=message).mesh
            progress(0.0 if choice.coloured else 0.4)
            document = Document.new(
                choice.apply(mesh),
                choice.resolution,
                choice.material,
                brush=brush,
                ink=inks[0],
                undo_bytes=undo_bytes,
            )
            document.inks[1] = inks[1]
            return open_with_progress(document, progress, 0.7)

        return self._workspace.run(title, make)

    def _undo_bytes(self) -> int:
        return int(self._workspace.settings.undo_megabytes * (1 << 20))


def say_warming() -> str:
    """Return the text shown while kernels are compiled."""
    if is_first_start():
        return say("First start: preparing the brush, about a minute…")
    return say("Preparing the brush…")


def _warm_up(progress: JobProgress) -> None:
    warm_up(_before_one(progress))


def _before_one(progress: JobProgress) -> Callable[[float], None]:
    return part_of(progress, 0.0, 0.98)

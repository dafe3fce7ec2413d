"""The result of a command that paints: its report, and its file, a session or another format."""

from __future__ import annotations

import argparse
import logging
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from paint3d.cli.options import (
    BUILT_IN_HELP,
    BUILT_IN_OBJECTS,
    PLACE,
    add_unit_option,
    add_up_option,
    check_input_file,
    group_of,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.report import find_versions
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, RecordingError
from paint3d.files.contents import json_text

if TYPE_CHECKING:
    from paint3d.app.model.document import Document
    from paint3d.brush.spec import BrushSpec
    from paint3d.colour.pigments import Pigment
    from paint3d.files.project.session import Session
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "PaintingResult",
    "add_layer_option",
    "add_painting_argument",
    "brush_of",
    "check_is_plane",
    "export_outlines",
    "export_recordings",
    "finish",
    "is_recording",
    "open_painting",
    "refuse_untouched",
    "result_suffixes",
    "timed",
    "write_report",
    "write_result",
    "write_results",
]

_LOG = logging.getLogger("paint3d")
_MUCH_OVER = 0.02  # of the area painted: less only touches


@dataclass(frozen=True)
class PaintingResult:
    """A painted surface, its counts and recordings, and the seconds of each step.

    With a `document` it is that one's painting, which has a history of its own.
    """

    surface: PaintedSurface
    counts: dict[str, Any]
    seconds: dict[str, float]
    recordings: tuple[Recording | LaidPad, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)
    document: Document | None = None

    def whole_recordings(self) -> tuple[Recording, ...]:
        """Return the recordings in the world; a pad's is laid down as a whole."""
        from paint3d.painter.flat_input import LaidPad

        return tuple(r.whole() if isinstance(r, LaidPad) else r for r in self.recordings)

    def describe(self) -> dict[str, Any]:
        """Return the report of ``--report``: versions, seconds by stage, counts, ink ledger."""
        return {
            "versions": find_versions(),
            **self.counts,
            "seconds_by_step": {step: round(spent, 4) for step, spent in self.seconds.items()},
        }

    def summarize(self) -> str:
        """Return one line on the painting."""
        return (
            f"{self.counts['samples']:,} samples, {self.counts['footprints']:,} footprints, "
            f"{self.counts['vertices_painted']:,} vertices painted in "
            f"{self.seconds['paint']:.1f} s"
        )


@contextmanager
def timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    """Add the seconds spent inside to ``seconds[step]``."""
    started = time.perf_counter()
    yield
    seconds[step] = seconds.get(step, 0.0) + time.perf_counter() - started


def result_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that `write_result` can write."""
    from paint3d.files.export import EXPORT_SUFFIXES

    return EXPORT_SUFFIXES


def write_result(painting: PaintingResult, file: Path, *, quiet: bool = False) -> None:
    """Write a painting in the format of the file's suffix, showing progress.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    from paint3d.files.export import export
    from paint3d.files.project.session import Session, is_session_path, save_session

    with ProgressBar("writing", enabled=not quiet) as progress:
        if painting.document is not None:
            painting.document.export(file, progress=progress)
        elif is_session_path(file):
            session = Session(painting.surface, painting.whole_recordings(), painting.settings)
            save_session(session, file, progress)
        else:
            export(painting.surface, file, progress=progress)


def write_results(painting: PaintingResult, files: Iterable[Path], *, quiet: bool = False) -> None:
    """Write a painting in several formats, prepared once.

    Raises
    ------
    ExportError
        If a file cannot be written.
    """
    from paint3d.files.export import PreparedExport, prepare_export
    from paint3d.files.export_options import ExportOptions
    from paint3d.files.progress import part_of
    from paint3d.files.project.session import is_session_path

    prepared: PreparedExport | None = None
    for file in files:
        if is_session_path(file):
            write_result(painting, file, quiet=quiet)
            continue
        with ProgressBar("writing", enabled=not quiet) as progress:
            if prepared is None:
                report = part_of(progress, 0.0, 0.6)
                prepared = prepare_export(painting.surface, file, ExportOptions(), report)
            prepared.into(file).write(part_of(progress, 0.6, 1.0))


def add_layer_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--layer``."""
    group_of(parser, PLACE).add_argument(
        "--layer", metavar="NAME", help="paint on a layer of this name (default: the one in use)"
    )


class _Film(Protocol):
    """A film that can be written, such as a `films.Watch`."""

    def write(self) -> int:
        """Write it; return its number of pictures."""
        ...


def finish(
    painting: PaintingResult, options: argparse.Namespace, film: _Film | None = None
) -> None:
    """Write the painting, its film and its report where options name files for them.

    Raises
    ------
    Paint3DError
        If one cannot be written.
    """
    say_if_over(painting.counts.get("over_paint", 0.0))
    with timed(painting.seconds, "export"):
        if options.out is not None:
            write_result(painting, options.out, quiet=options.quiet)
        if film is not None:
            film.write()
    if options.report is not None:
        write_report(options.report, painting)


def say_if_over(fraction: float, name: str = "") -> None:
    """Warn of the fraction of the painting, 0 to 1, that lies over earlier paint, if it is much."""
    if fraction > _MUCH_OVER:
        piece = f"{name}: " if name else ""
        _LOG.warning("%s%.0f %% of it lies over what was painted before", piece, 100.0 * fraction)


def write_report(file: Path, painting: PaintingResult) -> None:
    """Write the report as JSON, whole or not at all.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    text = json_text(painting.describe(), indent=2, allow_nan=False)
    with write_atomically(file) as part:
        part.write_text(text + "\n", encoding="utf-8")


# ---- Outlines ------------------------------------------------------------------------------------
# Strokes on the plane as outlines in an SVG file.


_FLAT_MM = 1e-3
_MARGIN_MM = 1.0
_BRUSH, _INK = "full", "pine soot"  # where a recording names none, as `replay` has it


def check_is_plane(mesh: TriangleMesh) -> None:
    """Refuse an object that is not the sheet z = 0, facing up.

    Raises
    ------
    ExportError
        If it is another one: outlines of strokes are flat.
    """
    low, high = mesh.bounds
    if max(abs(low[2]), abs(high[2])) > _FLAT_MM or mesh.face_normals[:, 2].min() < 0.99:
        raise ExportError(
            "{object} is not the plane z = 0; expected it for an .svg of strokes",
            object=mesh.name,
        )


def export_outlines(
    mesh: TriangleMesh, recording: Recording, brush: BrushSpec, ink: str, file: Path
) -> None:
    """Write the strokes' outlines in the colour of a full coat of an ink on paper.

    Raises
    ------
    ExportError
        If the file cannot be written.
    InputError
        If the recording leans or lets the surface turn the tuft.
    """
    from paint3d.calligraphy.stroke_sides import stroke_outlines
    from paint3d.files.formats.svg import write_svg

    outlines = stroke_outlines(recording, brush)
    low, high = mesh.bounds
    bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    write_svg(file, [(_colour_of(ink), outlines)], bounds, _title(recording))


def brush_of(recording: Recording) -> BrushSpec:
    """Return the brush that a recording names, which is no file of this machine.

    Raises
    ------
    InputError
        If it is not known.
    """
    from paint3d.brush.presets import load_brush

    return load_brush(str(recording.header.get("brush", _BRUSH)), own_files=False)


def export_recordings(strokes: Sequence[tuple[Recording, BrushSpec]], file: Path) -> None:
    """Write strokes on the plane z = 0, each with its brush and in its ink, as large as they are.

    Raises
    ------
    ExportError
        If there is none, or the file cannot be written.
    InputError
        If one leans or lets the surface turn the tuft, or its ink is not known.
    """
    import numpy as np

    from paint3d.calligraphy.stroke_sides import stroke_outlines
    from paint3d.files.formats.svg import write_svg

    groups = []
    for recording, brush in strokes:
        ink = _colour_of(str(recording.header.get("ink", _INK)), own_tables=False)
        groups.append((ink, stroke_outlines(recording, brush)))
    points = [ring for _, outlines in groups for rings in outlines for ring in rings]
    if not points:
        raise ExportError("{file}: no stroke touches the plane; expected one at least", file=file)
    low = np.min([ring.min(axis=0) for ring in points], axis=0) - _MARGIN_MM
    high = np.max([ring.max(axis=0) for ring in points], axis=0) + _MARGIN_MM
    bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    write_svg(file, groups, bounds, "".join(_title(recording) for recording, _ in strokes))


def _title(recording: Recording) -> str:
    characters = recording.header.get("characters", ())
    return "".join(str(character["text"]) for character in characters)


def _colour_of(ink: str, *, own_tables: bool = True) -> str:
    """Return the colour of a full coat on paper, as ``#rrggbb``."""
    from paint3d.colour.inks import load_ink
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.colour.materials import load_material
    from paint3d.colour.spectra import srgb_from_reflectance

    stirred: dict[str | Pigment, float] = dict(load_ink(ink, own_tables=own_tables).items())
    paper = load_material("xuan").reflectance
    film = mixture_reflectance(stirred, 1.0, paper, by_volume=True)
    red, green, blue = srgb_from_reflectance(film)
    return f"#{red:02x}{green:02x}{blue:02x}"


# ---- Paintings -----------------------------------------------------------------------------------
# The painting that a command shows: a session, or any mesh with its colours.


_RECORDINGS = (".jsonl", ".inkml", ".csv", ".json")


def add_painting_argument(parser: argparse.ArgumentParser) -> None:
    """Add PAINTING, and the options of reading a mesh."""
    parser.add_argument(
        "painting",
        metavar="PAINTING",
        help="a session (.p3d), any mesh that is read, with its colours and pictures, "
        f"{BUILT_IN_HELP}",
    )
    add_unit_option(parser)
    add_up_option(parser)


def is_recording(name: str) -> bool:
    """Return whether a file's name is that of a recording."""
    plain = name.lower().removesuffix(".gz")
    return plain.endswith(_RECORDINGS)


def open_painting(options: argparse.Namespace) -> Session | TriangleMesh:
    """Open the session or the mesh that PAINTING names.

    Raises
    ------
    SessionError, MeshError
        If it cannot be read.
    """
    check_input_file(options.painting, "a painting (.p3d), a mesh", BUILT_IN_OBJECTS)
    from paint3d.files.load import load_mesh
    from paint3d.files.project.session import is_session_path, load_session

    with ProgressBar("opening", enabled=not options.quiet) as progress:
        if is_session_path(options.painting):
            return load_session(Path(options.painting), progress)
        return load_mesh(
            options.painting, options.unit, texture=True, up=options.up, progress=progress
        )


# ---- Untouched -----------------------------------------------------------------------------------
# Errors on a recording that left nothing on an object.


_PART = 1 << 16  # samples that are laid on the object at once
_MOST = 20_000  # samples whose distances are looked at


def refuse_untouched(
    painting: PaintingResult, recording: Recording | LaidPad, mesh: TriangleMesh, name: str
) -> None:
    """Refuse a painting of one recording that left no footprint, or painted nothing with ink.

    Raises
    ------
    RecordingError
        If there is none; it says how far the brush was, or that it never pressed.
    """
    from paint3d.device.sample import ERASER
    from paint3d.painter.flat_input import LaidPad

    counts = painting.counts
    buttons = (recording.pad if isinstance(recording, LaidPad) else recording).buttons
    is_ink = counts["ink_ledger"]["loaded"] > 0.0 and not (buttons & ERASER).any()  # no water
    if counts["footprints"] and (counts["vertices_painted"] or not is_ink):
        return
    if counts["footprints"]:
        raise RecordingError(
            f"{name}: the brush touches {mesh.name} and paints no vertex of it: its way there is "
            "too short or too light; expected another unit, a harder press or a finer --resolution"
        )
    if painting.document is not None:
        brush = painting.document.painter.brush
        what, length_mm = brush.name, brush.length_mm
    else:
        words = painting.settings["brush"]
        what, length_mm = words["name"], words["length_mm"]
    made_on = recording.header.get("object")
    elsewhere = made_on not in (None, mesh.name)
    raise RecordingError(
        f"{name}: the brush never touches {mesh.name}: "
        f"{_reason(recording, mesh, what, length_mm)}"
        + (f"; it was recorded on {made_on}: --at U,V lays it on {mesh.name}" if elsewhere else "")
    )


def _reason(
    recording: Recording | LaidPad, mesh: TriangleMesh, brush: str, length_mm: float
) -> str:
    import numpy as np

    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.pose.brush_pose import brush_poses

    pressure = recording.pressure
    if pressure is not None and not pressure.any():
        return "its pressure is 0 throughout; expected strokes that press"
    n = len(recording)
    roots = []
    for first in range(0, n, _PART):
        part = recording.part(first, min(n, first + _PART))
        root = brush_poses(part).points
        if part.pressure is not None:
            root = root[part.pressure > 0.0]
        roots.append(root[:: 1 + n // _MOST])
    root = np.concatenate(roots)
    gaps = np.linalg.norm(ClosestPoints(mesh).find(root).points - root, axis=1)
    near = float(gaps.min())
    if pressure is None:
        return (
            f"the tuft's root comes as near as {near:.1f} mm, and {brush} is {length_mm:g} mm "
            "long; expected a longer brush, another object, or another unit"
        )
    return (
        f"where it presses, the tuft's root is beside the surface, {near:.1f} mm off at the least, "
        "or behind it; expected another object, another unit, or columns object_x_mm, .. that say "
        "where the object lies"
    )

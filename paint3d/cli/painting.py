"""Painting with what the options ask for: one dataclass of them, the object, brush and ink."""

from __future__ import annotations

import argparse
import io
import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from paint3d.cli.options import (
    BRUSH,
    BUILT_IN_HELP,
    BUILT_IN_OBJECTS,
    FILES,
    MATERIALS,
    OBJECTS,
    UNIT_HELP,
    UNITS,
    add_up_option,
    check_input_file,
    group_of,
    own_file,
    parse_hairs,
    parse_rate,
    parse_resolution_mm,
    parse_seconds,
    parse_share,
)
from paint3d.cli.progress import ProgressBar, say_if_compiling
from paint3d.cli.results import PaintingResult, timed
from paint3d.errors import InputError, RecordingError
from paint3d.mesh.sheets import is_sheet, parse_sheet

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from paint3d.app.model.document import Document
    from paint3d.brush.spec import BrushSpec
    from paint3d.cli.films import Watch
    from paint3d.colour.materials import Material
    from paint3d.colour.pigments import Pigment
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.painter.painter import Painter
    from paint3d.painter.pose_check import PoseWarnings
    from paint3d.painter.stroke_table import StrokeTable
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "DEFAULT_INK",
    "WRITING_INK",
    "Before",
    "PaintingOptions",
    "add_out_option",
    "check_poses",
    "fraction_over",
    "keep_bare_surfaces",
    "load_object",
    "new_document",
    "open_document",
    "paint",
    "paint_onto",
    "prepare",
    "take_layer",
]

DEFAULT_BRUSH, DEFAULT_INK = "full", "pine soot"
WRITING_INK = "pine soot:0.26,water:0.74"  # as a writer grinds it


def _option(default: Any, group: str, help: str, unsaid: str = "", **how: Any) -> Any:
    """Declare a field that is an option of its name; `unsaid` is the help's text of its default."""
    metadata = {"group": group, "help": help, "unsaid": unsaid, "how": how}
    return field(default=default, metadata=metadata)


@dataclass(frozen=True)
class PaintingOptions:
    """Options of the commands that paint.

    Each field but `quiet` is an option of the same name, in the namespace None where it was not
    given; brush and ink None stand for the recording's own.
    """

    on: str = _option(
        "bowl", OBJECTS, f"a mesh file, a painting to go on with (.p3d), {BUILT_IN_HELP}",
        metavar="MESH",
    )  # fmt: skip
    material: str = _option(
        "porcelain", OBJECTS,
        f"of the surface: {', '.join(MATERIALS)}, or a file of your own, mine.toml or mine.json",
        unsaid="what suits a sheet, else porcelain", metavar="NAME|FILE",
    )  # fmt: skip
    resolution: float = _option(
        0.4, OBJECTS, "vertex spacing wanted where paint is, mm; on sheets 0.15 to 0.6",
        metavar="MM", type=parse_resolution_mm,
    )  # fmt: skip
    unit: str | None = _option(None, OBJECTS, UNIT_HELP, choices=UNITS)
    up: str | None = _option(None, OBJECTS, "")
    from_points: bool | None = _option(
        None, OBJECTS, "build a surface through the points of a mesh file that holds no triangles, "
        "even if it is not a point cloud", action="store_true",
    )  # fmt: skip
    texture: bool = _option(
        False, OBJECTS, "show the materials and pictures of the object's file, on a mesh that is "
        "refined until they can be seen", action="store_true",
    )  # fmt: skip
    brush: str | None = _option(
        None, BRUSH, "a name of `paint3d brushes`, or a file of your own, mine.toml or mine.json",
        unsaid="the recording's", metavar="NAME|FILE",
    )  # fmt: skip
    hairs: int | None = _option(
        None, BRUSH, "paint with so many single hairs, 1 to 10000; 0: a solid tuft",
        unsaid="the brush's", metavar="N", type=parse_hairs,
    )  # fmt: skip
    ink: str | None = _option(
        None, BRUSH, "NAME, FILE.csv:NAME or several with their parts, such as "
        "'pine soot:0.2,water:0.8'; burnt, thick, heavy, light or clear, alone or before a name",
        unsaid="the recording's", metavar="INK",
    )  # fmt: skip
    tip: str | None = _option(
        None, BRUSH, "dip the tip in this ink afterwards", unsaid="all in one", metavar="INK"
    )
    reach: float = _option(
        0.35, BRUSH, "of the tuft's length that --tip dips", metavar="SHARE", type=parse_share
    )
    pickup: float = _option(
        0.0, BRUSH, "share of the wet ink below it that the brush takes up per mm of travel; .05 "
        "is a thirsty brush", unsaid="0, it stays clean", metavar="RATE", type=parse_rate,
    )  # fmt: skip
    spread: float | None = _option(
        None, BRUSH, "let the ink spread and dry while it is painted, and S seconds more",
        metavar="S", type=parse_seconds,
    )  # fmt: skip
    quiet: bool = False

    @classmethod
    def add_to(
        cls,
        parser: argparse.ArgumentParser,
        *names: str,
        unsaid: Mapping[str, str] | None = None,
    ) -> None:
        """Add options in their groups, by default all.

        Parameters
        ----------
        parser : ArgumentParser
        names : str
            Only these.
        unsaid : mapping
            The help's text of a default, where a command differs.
        """
        for one in fields(cls):
            if not one.metadata or (names and one.name not in names):
                continue
            group = group_of(parser, one.metadata["group"])
            if one.name == "up":
                add_up_option(parser)
                continue
            usual = (unsaid or {}).get(one.name) or one.metadata["unsaid"] or one.default
            how, help = dict(one.metadata["how"]), one.metadata["help"]
            if "action" not in how and usual is not None and one.name not in ("on", "unit"):
                help += (
                    f" (default: {usual:g})" if isinstance(usual, float) else f" (default: {usual})"
                )
            group.add_argument(
                f"--{one.name.replace('_', '-')}", default=None, required=one.name == "on",
                help=help, **how,
            )  # fmt: skip

    @classmethod
    def of(cls, options: argparse.Namespace, **otherwise: Any) -> PaintingOptions:
        """Return the options as given; `otherwise` are a command's own defaults."""
        given = {one.name: getattr(options, one.name, None) for one in fields(cls)}
        on = given["on"]
        if on is not None and is_sheet(on) and not os.path.isfile(on):
            sheet = parse_sheet(on)
            otherwise["material"] = sheet.usual.material
            otherwise.setdefault("resolution", sheet.detail_mm)
        return cls(**{**otherwise, **{k: value for k, value in given.items() if value is not None}})

    def check(self) -> None:
        """Look up everything that is named, before any work.

        Raises
        ------
        InputError
            If the object, the brush, the ink or the material is not known or cannot be read.
        """
        from paint3d.brush.presets import load_brush
        from paint3d.colour.inks import load_ink
        from paint3d.colour.materials import load_material

        load_material(self.material)
        if self.brush is not None:
            load_brush(self.brush)
        for ink in (self.ink, self.tip):
            if ink is not None:
                load_ink(ink)

    def check_object(self) -> None:
        """Refuse an object whose file is not there, before anything heavy is imported."""
        check_input_file(self.on, "a mesh, a painting (.p3d)", BUILT_IN_OBJECTS)

    def files(self) -> list[str | None]:
        """Return the files that are read: the object, own brushes and materials, tables of inks."""
        from paint3d.colour.ink_text import tables_in

        tables = (*tables_in(self.ink), *tables_in(self.tip))
        return [self.on, own_file(self.brush), own_file(self.material), *tables]


def add_out_option(parser: argparse.ArgumentParser, *, required: bool = True) -> None:
    """Add ``--out``."""
    group_of(parser, FILES).add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        required=required,
        help="where to write the painting, in the format of the suffix",
    )


# ---- The object ----------------------------------------------------------------------------------

_last: dict[tuple[Any, ...], TriangleMesh] = {}  # the mesh read last: rows may share it


def load_object(wanted: PaintingOptions) -> TriangleMesh:
    """Load the mesh that ``--on`` names, as the other options say.

    Raises
    ------
    MeshError
        If the file cannot be read or holds no usable surface.
    """
    path = os.path.abspath(wanted.on)  # a name means another file in another folder
    how = (wanted.unit, wanted.from_points, wanted.texture, wanted.up)
    key = (wanted.on, path, _file_version(path), *how)
    if key not in _last:
        from paint3d.files.load import load_mesh

        with ProgressBar("reading", enabled=not wanted.quiet) as progress:
            mesh = load_mesh(
                wanted.on, wanted.unit, from_points=wanted.from_points, texture=wanted.texture,
                up=wanted.up, progress=progress,
            )  # fmt: skip
        _last.clear()
        _last[key] = mesh
    return _last[key]


def _file_version(path: str) -> tuple[int, int] | None:
    """Return what distinguishes a file's versions; None for a name that is no file."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return status.st_size, status.st_mtime_ns


def prepare(
    mesh: TriangleMesh, wanted: PaintingOptions, seconds: dict[str, float]
) -> PaintedSurface:
    """Make a mesh ready for painting, adding the time that takes to `seconds`.

    Raises
    ------
    InputError
        If the material is not known, or the mesh cannot be painted on at this resolution.
    """
    from paint3d.colour.materials import load_material
    from paint3d.surface.painted_surface import PaintedSurface

    material = load_material(wanted.material)
    say_if_compiling(quiet=wanted.quiet)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        if not _keeps_bare:
            return PaintedSurface(mesh, wanted.resolution, material)
        key = (mesh, wanted.resolution, material)
        prepared = next((of for of in _bare if of[0] is mesh and of[1:3] == key[1:]), None)
        if prepared is None:
            prepared = (*key, _Packed(PaintedSurface(mesh, wanted.resolution, material)))
            _bare[:] = [prepared]
        return prepared[3].surface()


# ---- Rows on one object --------------------------------------------------------------------------
# Making a mesh ready takes seconds where it is large (17 s for the vase at .1 mm), copying what was
# made ready a fraction of one.

_keeps_bare = False
_bare: list[tuple[TriangleMesh, float, Material, _Packed]] = []  # the last one prepared


def keep_bare_surfaces() -> None:
    """Keep the last surface that was prepared, for the next row on the same object."""
    global _keeps_bare
    _keeps_bare = True


class _Packed:
    """A bare surface to copy; read-only parts are shared by the copies."""

    def __init__(self, surface: PaintedSurface) -> None:
        self._shared: list[object] = []
        packed = io.BytesIO()
        pickler = _SharingPickler(packed, pickle.HIGHEST_PROTOCOL)
        pickler.shared = self._shared
        pickler.dump(surface)
        self._packed = packed.getvalue()

    def surface(self) -> PaintedSurface:
        """Return a copy."""
        unpickler = pickle.Unpickler(io.BytesIO(self._packed))
        unpickler.persistent_load = self._shared.__getitem__  # type: ignore[method-assign]
        surface: PaintedSurface = unpickler.load()
        return surface


class _SharingPickler(pickle.Pickler):
    """Pickles all but meshes, materials and read-only arrays, which are shared."""

    shared: list[object]

    def persistent_id(self, value: Any) -> int | None:
        from paint3d.colour.materials import Material
        from paint3d.mesh.triangle_mesh import TriangleMesh

        flags = getattr(value, "flags", None)
        if not isinstance(value, TriangleMesh | Material) and getattr(flags, "writeable", True):
            return None
        self.shared.append(value)
        return len(self.shared) - 1


# ---- Painting ------------------------------------------------------------------------------------


def check_poses(
    recording: Recording, surface: PaintedSurface, wished: str | None, name: str
) -> PoseWarnings:
    """Refuse poses whose handle points into the object; return other warnings.

    Raises
    ------
    RecordingError
        If it does in most samples near the surface; it says what to do, which is another thing
        where it was recorded on another object.
    """
    from paint3d.painter.pose_check import fit_to_tuft, inspect_poses

    length_mm = _brush(recording, wished).length_mm
    warnings = inspect_poses(fit_to_tuft(recording, length_mm), surface.closest_points, length_mm)
    if warnings.handle is None:
        return warnings
    made_on, object_ = recording.header.get("object"), surface.source.name
    if not isinstance(made_on, str) or made_on == object_:
        raise RecordingError("{name}: {handle}", name=name, handle=warnings.handle)
    raise RecordingError(
        "{name}: it was recorded on {made_on}, and at the same positions the handle would point "
        "into {object}; expected --at U,V, which lays its strokes on {object}",
        name=name,
        made_on=made_on,
        object=object_,
    )


def paint(
    surface: PaintedSurface,
    recording: Recording | LaidPad,
    wanted: PaintingOptions,
    seconds: dict[str, float],
    watch: Watch | None = None,
    table: StrokeTable | None = None,
) -> PaintingResult:
    """Paint a recording on a surface of `prepare`, showing a progress bar on a terminal.

    A `watch` sees how it grows, for a film; a `table` takes a row for every stroke.

    Raises
    ------
    InputError
        If the brush, the ink or a sample cannot be used.
    """
    from paint3d.painter.painter import Painter
    from paint3d.painter.recorded_tools import recorded_amount

    brush = _brush(recording, wanted.brush)
    ink = _ink(recording, wanted.ink)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        azimuth = recording.header["azimuth"]
        painter = Painter(
            surface,
            brush,
            ink,
            azimuth,
            wanted.pickup,
            wanted.hairs,
            recorded_amount(recording.header),
        )
        tip, reach = _tip(recording, wanted)
        if tip is not None:
            painter.dip(tip, reach)
    is_shown, rest_s = not wanted.quiet, wanted.spread
    with timed(seconds, "paint"):
        with ProgressBar("painting", enabled=is_shown) as progress:
            report = progress if watch is None else watch.over(recording, rest_s, progress)
            rate = None if watch is None else 1.0 / watch.step_s
            painter.replay(recording, report, rate, rest_s is not None, table)
        if rest_s is not None:
            with ProgressBar("spreading", enabled=is_shown) as progress:
                report = progress if watch is None else watch.resting(progress)
                painter.rest(int(recording.time_ns[-1]), rest_s, report)
        counts = painter.report()
    settings = _hand_settings(painter, brush, ink, tip)
    return PaintingResult(surface, counts, seconds, (recording,), settings)


def _hand_settings(
    painter: Painter, brush: BrushSpec, ink: dict[Pigment, float], tip: dict[Pigment, float] | None
) -> dict[str, Any]:
    """Return a session's settings of the hand: its brush as it was used, and the ink in it."""
    from paint3d.brush.spec import DipAmount

    own = None if painter.hairs is None else painter.hairs.spec
    used = replace(brush, bristles=own)
    settings: dict[str, Any] = {
        "brush": asdict(used), "ink": painter.ink.name, "azimuth": painter.azimuth
    }  # fmt: skip
    last = ink if tip is None else tip
    if tip is not None or len(ink) > 1:
        settings["dipped"] = {pigment.name: parts for pigment, parts in last.items()}
    if tip is not None:  # or the next dip would be a whole one in the tip's ink
        from paint3d.app.model.stroke_log import weights_of

        settings["dips"] = [[weights_of(dipped), reach] for dipped, reach in painter.dips]
    if painter.hairs is not None:
        from paint3d.app.model.persistence.brush_words import hair_words

        settings["hairs"] = hair_words(painter)
    if painter.amount != DipAmount():
        settings["amount"] = painter.amount.words()
    return settings


def _brush(recording: Recording | LaidPad, wished: str | None) -> BrushSpec:
    """Return the brush of the options, or the recording's own, which names no file here."""
    from paint3d.brush.presets import load_brush
    from paint3d.painter.recorded_tools import recorded_brush

    if wished:
        return load_brush(wished)
    try:
        return recorded_brush(recording.header) or load_brush(DEFAULT_BRUSH)
    except RecordingError as cause:
        raise RecordingError("{cause}, or --brush", cause=cause) from None


def _ink(recording: Recording | LaidPad, wished: str | None) -> dict[Pigment, float]:
    """Return the ink of the options, or the recording's own."""
    from paint3d.colour.inks import load_ink
    from paint3d.painter.recorded_tools import recorded_ink

    if wished:
        return load_ink(wished)
    try:
        return recorded_ink(recording.header) or load_ink(DEFAULT_INK)
    except RecordingError as cause:
        raise RecordingError("{cause}, or --ink", cause=cause) from None


def _tip(
    recording: Recording | LaidPad, wanted: PaintingOptions
) -> tuple[dict[Pigment, float] | None, float]:
    """Return the tip's ink and its reach: of the options, or the recording's own."""
    from paint3d.colour.inks import load_ink
    from paint3d.painter.recorded_tools import recorded_tip

    if wanted.tip is not None:
        return load_ink(wanted.tip), wanted.reach
    try:
        own = None if wanted.ink is not None else recorded_tip(recording.header)
    except RecordingError as cause:
        raise RecordingError("{cause}, or --ink", cause=cause) from None
    return own or (None, wanted.reach)


# ---- Going on with a painting --------------------------------------------------------------------

_AT_ONCE = 2000  # samples between two calls of the progress
_LONGEST_S = 1e9  # longer than any ink stays wet


def open_document(wanted: PaintingOptions, options: argparse.Namespace) -> Document:
    """Open the painting that ``--on`` names, to go on with.

    Raises
    ------
    InputError
        If an option says how to make an object ready that is ready.
    SessionError
        If it cannot be read.
    """
    from paint3d.app.model.document import Document

    for name in ("material", "resolution", "unit", "up", "from_points", "texture"):
        if getattr(options, name, None) is not None:
            option = name.replace("_", "-")
            raise InputError(
                "--{option} is given, and {on} is a painting with its own; expected none",
                option=option,
                on=wanted.on,
            )
    say_if_compiling(quiet=wanted.quiet)
    with ProgressBar("opening", enabled=not wanted.quiet) as progress:
        return Document.open(wanted.on, progress=progress)


def new_document(wanted: PaintingOptions) -> Document:
    """Begin a painting with a history on the object that ``--on`` names.

    Raises
    ------
    Paint3DError
        If the object cannot be read or painted on.
    """
    from paint3d.app.model.document import Document

    mesh = load_object(wanted)
    say_if_compiling(quiet=wanted.quiet)
    with ProgressBar("preparing", enabled=not wanted.quiet):
        return Document.new(mesh, wanted.resolution, wanted.material)


def take_layer(painted: Document | PaintedSurface, name: str | None) -> None:
    """Make the layer of this name the active one; add it above the others if missing."""
    from paint3d.surface.painted_surface import PaintedSurface

    if name is None:
        return
    if isinstance(painted, PaintedSurface):
        painted.use_layers().set_properties(0, name=name)
        return
    names = [layer.name for layer in painted.layers]
    if name in names:
        painted.select_layer(names.index(name))
    else:
        painted.add_layer(name, len(names))


def paint_onto(
    document: Document,
    recording: Recording | LaidPad,
    wanted: PaintingOptions,
    seconds: dict[str, float],
    watch: Watch | None = None,
) -> PaintingResult:
    """Paint a recording on a painting, as a step that can be undone; see `paint`.

    Where its pen is turned over, a step ends and one that erases, or paints again, begins.

    Raises
    ------
    InputError
        If the brush, the ink or a sample cannot be used, or the layer is locked or hidden.
    """
    import numpy as np

    from paint3d.painter.flat_input import LaidPad
    from paint3d.painter.ink_time import INK_STEP_NS, INK_STEP_S
    from paint3d.painter.pose_check import fit_to_tuft
    from paint3d.painter.recorded_tools import changes_at, eraser_runs, recorded_amount

    if isinstance(recording, LaidPad):
        recording = recording.whole()
    brush, ink = _brush(recording, wanted.brush), _ink(recording, wanted.ink)
    recording = fit_to_tuft(recording, brush.length_mm)
    tip, reach = _tip(recording, wanted)
    document.set_azimuth(recording.header["azimuth"])
    document.set_brush(_with_hairs(brush, wanted.hairs))
    document.dip(ink, None, recorded_amount(recording.header).words())
    if tip is not None:
        document.dip(tip, reach)
    document.set_pickup(wanted.pickup)
    document.refresh()  # what changes from here on is what the recording paints
    before = Before.of(document)
    n, time_ns, is_wet = len(recording), recording.time_ns, wanted.spread is not None
    loads, strengths = changes_at(recording.header, time_ns)
    if is_wet or watch is not None:  # time passes between these
        step_ns = INK_STEP_NS if is_wet else round(1e9 * watch.step_s)  # type: ignore[union-attr]
        ends = np.flatnonzero(np.diff(time_ns // step_ns)) + 1
    else:
        ends = np.arange(_AT_ONCE, n, _AT_ONCE)
    with timed(seconds, "paint"), ProgressBar("painting", enabled=not wanted.quiet) as progress:
        report = progress if watch is None else watch.over(recording, wanted.spread, progress)
        begins = {begin: (end, erases) for begin, end, erases in eraser_runs(recording.buttons)}
        first = 0
        for end in sorted({*ends.tolist(), *begins, n} - {0}):
            if first in begins:
                if first:
                    document.end_stroke()
                last, erases = begins[first]
                erase: dict[str, Any] = {"erase": True} if erases else {}  # a score says no false
                document.begin_stroke(
                    loads=_within(loads, first, last),
                    strengths=_within(strengths, first, last),
                    **erase,
                )
            document.feed(list(recording.part(first, end).samples()))
            if is_wet and end < n:
                pieces = int(time_ns[end] // INK_STEP_NS - time_ns[end - 1] // INK_STEP_NS)
                _let_pass(document, pieces, lambda _: None)
            report(end / n)
            first = end
        document.end_stroke()
    with timed(seconds, "paint"):
        if wanted.spread is not None:
            with ProgressBar("spreading", enabled=not wanted.quiet) as progress:
                resting = progress if watch is None else watch.resting(progress)
                _let_pass(document, round(min(wanted.spread, _LONGEST_S) / INK_STEP_S), resting)
        over = fraction_over(document, before)  # before the report, which updates colours
        counts = document.painter.report()
    counts["over_paint"] = round(over, 4)
    return PaintingResult(document.surface, counts, seconds, document=document)


def _within(pairs: Sequence[tuple[int, float]], first: int, last: int) -> list[tuple[int, float]]:
    """Return the pairs of samples from `first` to before `last`, counted from `first`."""
    return [(k - first, value) for k, value in dict(pairs).items() if first <= k < last]


def _with_hairs(brush: BrushSpec, hairs: int | None) -> BrushSpec:
    """Return the brush with so many single hairs; 0: a solid tuft, None: as it is."""
    from paint3d.brush.spec import BristleSpec

    if hairs is None:
        return brush
    own = replace(brush.bristles or BristleSpec(), n_hairs=hairs) if hairs else None
    return replace(brush, bristles=own)


def _let_pass(document: Document, pieces: int, report: Callable[[float], None]) -> None:
    """Advance the ink by so many steps of its time, or until it is dry."""
    from paint3d.painter.ink_time import INK_STEP_S

    for k in range(pieces):
        document.follow_time(INK_STEP_S)
        report((k + 1) / pieces)
        if document.surface.flow.is_dry:
            return


class Before(NamedTuple):
    """The state of vertices (V,) before something was painted: any paint, codes, wet ink."""

    painted: NDArray[np.bool_]
    codes: NDArray[np.uint8]
    ink: NDArray[np.float32]

    @classmethod
    def of(cls, document: Document) -> Before:
        """Return the present state."""
        document.refresh()
        surface = document.surface
        ink = surface.ink.amounts[: surface.n_vertices].sum(axis=1)
        return cls(surface.painted, surface.srgb.copy(), ink)


def fraction_over(document: Document, before: Before) -> float:
    """Return the fraction, by area, of the paint since then that lies over earlier paint."""
    changed = document.refresh()
    surface, n = document.surface, len(before.painted)
    known, new = changed[changed < n], changed[changed >= n]
    # with an ink that is new to it all of a painting counts as changed
    differs = (surface.srgb[known] != before.codes[known]).any(axis=1)
    differs |= surface.ink.amounts[known].sum(axis=1) != before.ink[known]
    known = known[differs]
    areas = surface.vertex_areas
    painted = float(areas[known].sum() + areas[new].sum())
    return float(areas[known[before.painted[known]]].sum()) / painted if painted > 0.0 else 0.0

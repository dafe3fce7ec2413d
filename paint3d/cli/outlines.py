"""Strokes on the plane as outlines in an SVG file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.errors import ExportError

if TYPE_CHECKING:
    from paint3d.brush.spec import BrushSpec
    from paint3d.colour.pigments import Pigment
    from paint3d.device.recorded import Recording
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["brush_of", "check_is_plane", "export_outlines", "export_recordings"]

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
        raise ExportError(f"{mesh.name} is not the plane z = 0; expected it for an .svg of strokes")


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
    from paint3d.files.writers.write_svg import write_svg

    outlines = stroke_outlines(recording, brush)
    low, high = mesh.bounds
    bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    write_svg(file, [(_colour_of(ink), outlines)], bounds, _title(recording))


def brush_of(recording: Recording) -> BrushSpec:
    """The brush that a recording names, which is no file of this machine.

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
    from paint3d.files.writers.write_svg import write_svg

    groups = []
    for recording, brush in strokes:
        ink = _colour_of(str(recording.header.get("ink", _INK)), own_tables=False)
        groups.append((ink, stroke_outlines(recording, brush)))
    points = [ring for _, outlines in groups for rings in outlines for ring in rings]
    if not points:
        raise ExportError(f"{file}: no stroke touches the plane; expected one at least")
    low = np.min([ring.min(axis=0) for ring in points], axis=0) - _MARGIN_MM
    high = np.max([ring.max(axis=0) for ring in points], axis=0) + _MARGIN_MM
    bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    write_svg(file, groups, bounds, "".join(_title(recording) for recording, _ in strokes))


def _title(recording: Recording) -> str:
    characters = recording.header.get("characters", ())
    return "".join(str(character["text"]) for character in characters)


def _colour_of(ink: str, *, own_tables: bool = True) -> str:
    """Of a full coat on paper, as ``#rrggbb``."""
    from paint3d.colour.inks import load_ink
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.colour.materials import load_material
    from paint3d.colour.spectra import srgb_from_reflectance

    stirred: dict[str | Pigment, float] = dict(load_ink(ink, own_tables=own_tables).items())
    paper = load_material("xuan").reflectance
    red, green, blue = srgb_from_reflectance(mixture_reflectance(stirred, 1.0, paper))
    return f"#{red:02x}{green:02x}{blue:02x}"

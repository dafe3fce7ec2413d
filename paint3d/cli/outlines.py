"""Strokes on the plane as outlines in an SVG file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.errors import ExportError

if TYPE_CHECKING:
    from paint3d.colour.pigment import Pigment
    from paint3d.device.recorded import Recording
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["check_is_plane", "export_outlines"]

_FLAT_MM = 1e-3


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


def export_outlines(mesh: TriangleMesh, recording: Recording, ink: str, file: Path) -> None:
    """Write the strokes' outlines in the colour of a full coat of an ink on paper.

    Raises
    ------
    ExportError
        If the file cannot be written.
    InputError
        If the recording leans or lets the surface turn the tuft.
    """
    from paint3d.brush.presets import load_brush
    from paint3d.calligraphy.stroke_sides import stroke_outlines
    from paint3d.colour.inks import load_ink
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.colour.materials import load_material
    from paint3d.colour.spectra import srgb_from_reflectance
    from paint3d.files.writers.write_svg import write_svg

    header = recording.header
    stirred: dict[str | Pigment, float] = dict(load_ink(ink).items())
    paper = load_material("xuan").reflectance
    red, green, blue = srgb_from_reflectance(mixture_reflectance(stirred, 1.0, paper))
    outlines = stroke_outlines(recording, load_brush(str(header["brush"])))
    low, high = mesh.bounds
    title = "".join(str(character["text"]) for character in header["characters"])
    bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    write_svg(file, outlines, bounds, f"#{red:02x}{green:02x}{blue:02x}", title)

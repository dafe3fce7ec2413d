"""Plays a score: on a bare object, or on what is painted already."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.saved_settings import DEFAULT_BRUSH, DEFAULT_INKS
from paint3d.app.model.score.stepping import Step, play
from paint3d.app.model.score.words import Inks, brush_in, material_in
from paint3d.colour.materials import Material
from paint3d.errors import Paint3DError, RecordingError
from paint3d.files.load import BUILT_IN_OBJECTS, load_mesh
from paint3d.mesh.likeness import Original
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording.score import Score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Step", "begun", "painted", "play"]

_RESOLUTION_MM = 0.4


def begun(
    score: Score,
    mesh: TriangleMesh,
    resolution: float | None = None,
    material: Material | None = None,
    painted_on: TriangleMesh | None = None,
) -> Document:
    """A painting that begins as the score's did.

    Parameters
    ----------
    score : Score
    mesh : TriangleMesh
    resolution : float, optional
        mm; as the header says by default.
    material : Material, optional
        As the header says by default.
    painted_on : TriangleMesh, optional
        What it was painted on, where that is the same object meshed otherwise: strokes lie where
        they lay. By default a built-in object of the name that the header says.

    Raises
    ------
    RecordingError
        If the header names no brush, ink or material that is known.
    InputError
        If the object cannot be painted on.
    """
    header = score.header
    try:
        brush = brush_in(header, DEFAULT_BRUSH)
        ink = Inks(dict(header.get("pigments", {}))).mixture(header.get("ink", DEFAULT_INKS[0]))
        made_of = material_in(header) if material is None else material
    except Paint3DError as cause:
        raise RecordingError(f"{score.name or 'the recording'}: its header: {cause}") from None
    if resolution is None:
        resolution = header.get("resolution_mm", _RESOLUTION_MM)
    surface = PaintedSurface(mesh, resolution, made_of, _original(header, painted_on))
    azimuth, pickup = header.get("azimuth", "commanded"), header.get("pickup", 0.0)
    return Document(surface, Painter(surface, brush, ink, azimuth, pickup))


def _original(header: Mapping[str, Any], painted_on: TriangleMesh | None) -> Original | None:
    """What the score was painted on, where that may be known and another mesh."""
    said = {"resolution_mm": _RESOLUTION_MM, **header}
    said |= header.get("painted_on", {})  # it was itself played on an object that was meshed anew
    if painted_on is None and said.get("object") in BUILT_IN_OBJECTS:
        painted_on = load_mesh(said["object"])
    if painted_on is None or said["resolution_mm"] is None:
        return None
    return Original(painted_on, said["resolution_mm"])


def painted(
    score: Score,
    mesh: TriangleMesh,
    resolution: float | None = None,
    material: Material | None = None,
    progress: Callable[[float], None] | None = None,
    painted_on: TriangleMesh | None = None,
) -> Document:
    """Paint a whole score on a bare object: the same score and object give the same painting.

    Parameters
    ----------
    score, mesh, resolution, material, painted_on
        See `begun`.
    progress : callable, optional
        Called with the share done; what it raises stops it.

    Raises
    ------
    RecordingError, InputError
        See `begun` and `play`.
    """
    document = begun(score, mesh, resolution, material, painted_on)
    for step in play(document, score):
        if progress is not None:
            progress(step.share)
    if document.in_stroke:
        document.end_stroke()
    return document

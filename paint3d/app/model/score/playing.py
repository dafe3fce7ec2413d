"""Plays a score: on a bare object, or on what is painted already."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.saved_settings import DEFAULT_BRUSH, PURE_INKS
from paint3d.app.model.score.codecs import (
    InkTable,
    decode_brush,
    decode_material,
    encode_brush,
    make_header,
)
from paint3d.app.model.score.stepping import PlaybackStep, play
from paint3d.app.model.stroke_log import ERASES, Stroke, ink_of, recording_of
from paint3d.brush.spec import DipAmount
from paint3d.colour.materials import Material
from paint3d.errors import Message, Paint3DError, RecordingError
from paint3d.files.load import is_built_in, load_mesh
from paint3d.mesh.likeness import Original, digest_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["PlaybackStep", "begun", "painted", "play", "score_of_strokes"]

_RESOLUTION_MM = 0.4
_log = logging.getLogger("paint3d.score")


def begun(
    score: Score,
    mesh: TriangleMesh,
    resolution: float | None = None,
    material: Material | None = None,
    painted_on: TriangleMesh | None = None,
) -> Document:
    """Start a painting as the score's was.

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
        brush = decode_brush(header, DEFAULT_BRUSH)
        ink = InkTable.of(header).decode(header.get("ink", PURE_INKS[0]))
        made_of = decode_material(header) if material is None else material
    except Paint3DError as cause:
        raise RecordingError(
            "{score}: its header: {cause}",
            score=score.name or Message("the recording"),
            cause=cause,
        ) from None
    if resolution is None:
        resolution = header.get("resolution_mm", _RESOLUTION_MM)
    surface = PaintedSurface(mesh, resolution, made_of, _original(header, mesh, painted_on))
    azimuth, pickup = header.get("azimuth", "commanded"), header.get("pickup", 0.0)
    return Document(surface, Painter(surface, brush, ink, azimuth, pickup))


def _original(
    header: Mapping[str, Any], mesh: TriangleMesh, painted_on: TriangleMesh | None
) -> Original | None:
    """Mesh that the score was painted on, where that is known and another one.

    A file may be called like a built-in object: only what has the digest that the header says is
    that object. Scores from before headers said it are believed by the name.
    """
    described = header.get("painted_on", header)  # it was itself played on an object meshed anew
    digest, resolution = described.get("mesh"), described.get("resolution_mm", _RESOLUTION_MM)
    if resolution is None:
        return None
    if painted_on is not None:
        if digest not in (None, digest_of(painted_on)):
            _log.warning(
                "%s is not to the bit what was painted on first (its normals count, too): "
                "strokes may lie elsewhere",
                painted_on.name,
            )
        return Original(painted_on, resolution)
    if digest == digest_of(mesh):
        return Original(mesh, resolution)
    if isinstance(described.get("object"), str) and is_built_in(described["object"]):
        built_in = load_mesh(described["object"])
        if digest in (None, digest_of(built_in)):
            return Original(built_in, resolution)
    return None


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
        Called with the fraction done; what it raises stops it.

    Raises
    ------
    RecordingError, InputError
        See `begun` and `play`.
    """
    document = begun(score, mesh, resolution, material, painted_on)
    for step in play(document, score):
        if progress is not None:
            progress(step.fraction)
    if document.in_stroke:
        document.end_stroke()
    return document


# ---- Of strokes alone ----------------------------------------------------------------------------
# A score of strokes alone, where what happened between them is not known.


def score_of_strokes(strokes: Sequence[Stroke], surface: PaintedSurface) -> Score | None:
    """A score of strokes alone, with their brushes, inks and layers; None where there are none.

    What was dried, mirrored, masked, wiped, or let run between them is not in it.
    """
    if not strokes:
        return None
    inks, first = InkTable({}, own_tables=False), strokes[0]
    events: list[Recording | dict[str, Any]] = [
        {"do": "rename_layer", "place": 0, "name": first.layer}
    ]
    layers, active, brush, amount = [first.layer], first.layer, None, DipAmount()
    for stroke in strokes:
        ink = inks.encode(ink_of(stroke, surface))
        if stroke.layer not in layers:
            events.append({"do": "add_layer", "name": stroke.layer, "place": len(layers)})
            layers.append(stroke.layer)
        elif stroke.layer != active:
            events.append({"do": "select_layer", "place": layers.index(stroke.layer)})
        active = stroke.layer
        if stroke.brush != brush:
            events.append({"do": "set_brush", "brush": encode_brush(stroke.brush)})
        if stroke.brush != brush or stroke.dipped_since_stroke:
            amounts = {} if stroke.amount == amount else {"amount": stroke.amount.words()}
            events.append({"do": "dip", "ink": ink, **amounts})
            amount = stroke.amount
        brush = stroke.brush
        pairs = {"loads": stroke.loads, "strengths": stroke.strengths}
        given: dict[str, Any] = {
            name: [list(one) for one in of] for name, of in pairs.items() if of
        }
        if stroke.tags.get(ERASES):
            given["erase"] = True
        events.append({"do": "begin_stroke", "time_s": stroke.time_s, **given})
        events.append(recording_of(stroke.samples, {}))
        events.append({"do": "end_stroke"})
    header = make_header(surface, first.brush, ink_of(first, surface), inks)
    own = {"pigments": inks.table} if inks.table else {}
    return Score({**header, **own}, tuple(events))

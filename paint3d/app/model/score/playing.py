"""Plays a score: on a bare object, or on what is painted already."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.saved_settings import DEFAULT_BRUSH, DEFAULT_INKS
from paint3d.app.model.score.words import Inks, asked_by, brush_in, material_in
from paint3d.colour.materials import Material
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError, RecordingError
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Step", "begun", "painted", "play"]

_AT_ONCE = 256  # samples between two looks at whether it goes on
_RESOLUTION_MM = 0.4
_COSTS = {"follow_time": 10.0, "let_time_pass": 50.0, "undo": 50.0, "redo": 50.0}
"""Of commands, in samples painted, roughly."""


@dataclass(frozen=True, eq=False)
class Step:
    """Something to be done: samples of the stroke that goes on, or a command.

    Attributes
    ----------
    event : int
        Its place in the score.
    samples : list of DeviceSample
    command : str
        Name of a method of `Document`; empty for samples.
    options : dict
        What it is called with.
    may_fail : bool
        Whether it was refused when it was asked for first.
    share : float
        Of the score that is done after it, 0 to 1.
    """

    event: int
    samples: list[DeviceSample]
    command: str
    options: dict[str, Any]
    may_fail: bool
    share: float


def begun(
    score: Score,
    mesh: TriangleMesh,
    resolution: float | None = None,
    material: Material | None = None,
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
    surface = PaintedSurface(mesh, resolution, made_of)
    azimuth, pickup = header.get("azimuth", "commanded"), header.get("pickup", 0.0)
    return Document(surface, Painter(surface, brush, ink, azimuth, pickup))


def _steps_of(score: Score, surface: PaintedSurface) -> Iterator[Step]:
    """What is to be done, in order; each is made when the ones before it are done.

    Raises
    ------
    RecordingError
        ``file:line: what is wrong`` for a brush or an ink that is not known, and the like.
    """
    inks = Inks(dict(score.header.get("pigments", {})))
    whole = sum(map(_cost, score.events)) or 1.0
    done = 0.0
    for k, event in enumerate(score.events):
        if isinstance(event, Recording):
            samples = list(event.samples())
            for at in range(0, len(samples), _AT_ONCE):
                part = samples[at : at + _AT_ONCE]
                done += len(part)
                yield Step(k, part, "", {}, False, done / whole)
            continue
        try:
            asked = asked_by(event, surface, inks)
        except Paint3DError as cause:
            raise RecordingError(f"{score.where(k)}: {event['do']}: {cause}") from None
        if event["do"] == "begin_stroke" and not event.get("refused"):
            asked.setdefault("time_s", 0.0)
        times = event.get("times", 1)
        cost = _cost(event) / times
        for _ in range(times):
            done += cost
            yield Step(k, [], event["do"], asked, bool(event.get("refused")), done / whole)


def _cost(event: Any) -> float:
    if isinstance(event, Recording):
        return float(len(event))
    return float(_COSTS.get(event["do"], 1.0) * event.get("times", 1))


def play(document: Document, score: Score) -> Iterator[Step]:
    """Do what a score says, step by step; each is done when it comes out.

    Parameters
    ----------
    document : Document
        Nobody else touches it meanwhile.
    score : Score

    Raises
    ------
    RecordingError
        ``file:line: what is wrong`` where something cannot be done, except what was refused when it
        was asked for first.
    """
    for step in _steps_of(score, document.surface):
        try:
            if step.samples:
                document.feed(step.samples)
            else:
                getattr(document, step.command)(**step.options)
        except Paint3DError as cause:
            if not step.may_fail:
                what = step.command or "a sample"
                raise RecordingError(f"{score.where(step.event)}: {what}: {cause}") from None
        yield step


def painted(
    score: Score,
    mesh: TriangleMesh,
    resolution: float | None = None,
    material: Material | None = None,
    progress: Callable[[float], None] | None = None,
) -> Document:
    """Paint a whole score on a bare object: the same score and object give the same painting.

    Parameters
    ----------
    score, mesh, resolution, material
        See `begun`.
    progress : callable, optional
        Called with the share done; what it raises stops it.

    Raises
    ------
    RecordingError, InputError
        See `begun` and `play`.
    """
    document = begun(score, mesh, resolution, material)
    for step in play(document, score):
        if progress is not None:
            progress(step.share)
    if document.in_stroke:
        document.end_stroke()
    return document

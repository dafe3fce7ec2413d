"""The strokes of a painting, painted once more."""

from __future__ import annotations

from paint3d.app.model.document import Document
from paint3d.app.model.stroke_log import Stroke
from paint3d.colour.pigments import Pigment

__all__ = ["repeated"]


def repeated(document: Document, upto: int | None = None) -> Document:
    """The first strokes of a document (None: all) on the bare object, as another document.

    Layers are those of the strokes' names in the order in which they come; what was dried, moved,
    or let run meanwhile is not repeated.
    """
    surface = document.surface
    again = Document.new(surface.source, surface.resolution, surface.material)
    known = {pigment.name: pigment for pigment in surface.pigments}
    for stroke in document.strokes[:upto]:
        _repeat(again, stroke, known)
    return again


def _repeat(document: Document, stroke: Stroke, inks: dict[str, Pigment]) -> None:
    """Paint a stroke again, with its brush and on the layer of its name, which is made."""
    names = [layer.name for layer in document.layers]
    if not document.strokes and stroke.layer not in names:
        document.rename_layer(0, stroke.layer)
    elif stroke.layer not in names:
        document.add_layer(stroke.layer, len(names))
    else:
        document.select_layer(names.index(stroke.layer))
    if stroke.brush != document.painter.brush:
        document.set_brush(stroke.brush)
    if stroke.dipped_since_stroke:
        document.dip({inks.get(name, name): part for name, part in stroke.ink.items()})
    document.begin_stroke()
    document.feed(stroke.samples)
    document.end_stroke()

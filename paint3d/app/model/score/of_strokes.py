"""A score of strokes alone, where what happened between them is not known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from paint3d.app.model.score.words import Inks, brush_named, header_of
from paint3d.app.model.stroke_log import Stroke, recording_of
from paint3d.brush.spec import DipAmount
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["score_of_strokes"]


def score_of_strokes(strokes: Sequence[Stroke], surface: PaintedSurface) -> Score | None:
    """A score of strokes alone, with their brushes, inks and layers; None where there are none.

    What was dried, mirrored, masked, wiped, or let run between them is not in it.
    """
    if not strokes:
        return None
    inks, first = Inks({}), strokes[0]
    known = {pigment.name: pigment for pigment in surface.pigments}
    events: list[Recording | dict[str, Any]] = [
        {"do": "rename_layer", "place": 0, "name": first.layer}
    ]
    layers, active, brush, amount = [first.layer], first.layer, None, DipAmount()
    for stroke in strokes:
        ink = inks.words({known.get(name, name): part for name, part in stroke.ink.items()})
        if stroke.layer not in layers:
            events.append({"do": "add_layer", "name": stroke.layer, "place": len(layers)})
            layers.append(stroke.layer)
        elif stroke.layer != active:
            events.append({"do": "select_layer", "place": layers.index(stroke.layer)})
        active = stroke.layer
        if stroke.brush != brush:
            events.append({"do": "set_brush", "brush": brush_named(stroke.brush)})
        if stroke.brush != brush or stroke.dipped:
            amounts = {} if stroke.amount == amount else {"amount": stroke.amount.words()}
            events.append({"do": "dip", "ink": ink, **amounts})
            amount = stroke.amount
        brush = stroke.brush
        pairs = {"loads": stroke.loads, "strengths": stroke.strengths}
        told = {name: [list(one) for one in of] for name, of in pairs.items() if of}
        events.append({"do": "begin_stroke", "time_s": stroke.time_s, **told})
        events.append(recording_of(stroke.samples, {}))
        events.append({"do": "end_stroke"})
    dipped = {known.get(name, name): part for name, part in first.ink.items()}
    header = header_of(surface, first.brush, dipped, inks)
    own = {"pigments": inks.table} if inks.table else {}
    return Score({**header, **own}, tuple(events))

"""What a session's settings say of brush and inks; they may come from a stranger."""

from __future__ import annotations

from collections.abc import Mapping

from paint3d.app.model.brush_words import brush_from_words, restore_hairs
from paint3d.arrays import as_number
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.errors import SessionError
from paint3d.files.load import UNITS_MM
from paint3d.ink.pigments import WATER, Pigment, load_palette
from paint3d.stroke.engine import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["DEFAULT_BRUSH", "DEFAULT_INKS", "saved_inks", "saved_painter", "saved_unit"]

DEFAULT_BRUSH, DEFAULT_INKS = "full", ("pine soot", "cinnabar")

Mixture = dict[str | Pigment, float]


def saved_painter(surface: PaintedSurface, settings: Mapping[str, object]) -> Painter:
    """The painter with the brush in its hand, as it lay there.

    Raises
    ------
    Paint3DError
        If the settings describe no brush, ink or hairs.
    """
    ink = settings.get("ink")
    ink = ink if isinstance(ink, str) else DEFAULT_INKS[0]
    azimuth = settings.get("azimuth", "commanded")
    brush = _brush(settings.get("brush"))
    painter = Painter(surface, brush, None if surface.pigments else ink, azimuth)
    if "dipped" in settings:
        dipped = _mixture(settings["dipped"], surface)
        painter.restore({**painter.keep(), "_dipped": dipped})
    restore_hairs(painter, settings.get("hairs"))
    return painter


def saved_inks(surface: PaintedSurface, settings: Mapping[str, object]) -> list[Mixture] | None:
    """The two inks at hand; None where the settings say nothing of them.

    Raises
    ------
    SessionError
        If they are not two mixtures.
    """
    inks = settings.get("inks")
    if inks is None:
        return None
    if not isinstance(inks, list) or len(inks) != 2:
        raise SessionError(f"the inks are {inks!r:.60}; expected two")
    return [_mixture(ink, surface) for ink in inks]


def saved_unit(settings: Mapping[str, object]) -> str:
    """The unit of lengths as they are shown; millimetres where it is none that is known."""
    unit = settings.get("unit")
    return unit if isinstance(unit, str) and unit in UNITS_MM else "mm"


def _brush(saved: object) -> BrushSpec:
    if isinstance(saved, Mapping):
        return brush_from_words(saved)
    return load_brush(saved if isinstance(saved, str) else DEFAULT_BRUSH)


def _mixture(saved: object, surface: PaintedSurface) -> Mixture:
    """Weights of inks by name; those that the palette has otherwise, or not, as on the surface."""
    if not isinstance(saved, Mapping) or not saved:
        raise SessionError(f"an ink is {saved!r:.60}; expected weights by name")
    palette = {**load_palette(), WATER.name: WATER}
    own = {p.name: p for p in surface.pigments if palette.get(p.name) is not p}
    return {
        own.get(name, name): as_number(weight, f"weight of {name}", 1e-9, 1e9, SessionError)
        for name, weight in saved.items()
    }

"""What settings say of brush and inks: the user's, or a session's, which may be a stranger's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import Any, TypedDict

from paint3d.app.model.brush_in_hand import resized
from paint3d.app.model.persistence.brush_words import brush_from_words, restore_hairs
from paint3d.app.model.persistence.own_brushes import own_brushes
from paint3d.app.model.persistence.own_pigments import own_pigments
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.model.stroke_log import weights_of
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.ink_text import names_table
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, Pigment, load_palette, load_pigment
from paint3d.core.arrays import as_number
from paint3d.errors import Paint3DError, SessionError
from paint3d.files.load import UNITS_MM
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "DEFAULT_BRUSH",
    "PURE_INKS",
    "chosen_brush",
    "chosen_inks",
    "chosen_material",
    "in_hand",
    "saved_brush",
    "saved_inks",
    "saved_mixture",
    "saved_painter",
    "saved_unit",
]

DEFAULT_BRUSH = "full"
PURE_INKS = ("pine soot", "cinnabar")
"""Of files and programs that name none; the studio begins with `Settings.inks`, soot in water."""

Mixture = dict[str | Pigment, float]


def saved_painter(surface: PaintedSurface, settings: Mapping[str, Any]) -> Painter:
    """The painter with the brush in its hand, as it lay there.

    Raises
    ------
    Paint3DError
        If the settings describe no brush, ink or hairs.
    """
    ink = settings.get("ink")
    ink = ink if isinstance(ink, str) else PURE_INKS[0]
    azimuth = settings.get("azimuth", "commanded")
    brush = saved_brush(settings.get("brush"))
    pigment = None if surface.pigments else load_pigment(ink, own_tables=False)
    amount = DipAmount.of(settings.get("amount", {}))
    painter = Painter(surface, brush, pigment, azimuth, amount=amount)
    if "dipped" in settings:
        dipped = saved_mixture(settings["dipped"], surface)
        dips = _saved_dips(settings.get("dips", []), surface)
        painter.restore({**painter.keep(), "_dipped": dipped, "_dips": dips})
    restore_hairs(painter, settings.get("hairs"))
    return painter


def _saved_dips(saved: object, surface: PaintedSurface) -> tuple[tuple[Mixture, float | None], ...]:
    """The dips of belly and tip, as `Painter.dips` has them."""
    if not isinstance(saved, list) or not all(isinstance(d, list) and len(d) == 2 for d in saved):
        raise SessionError(
            "dips are {saved!r:.60}; expected pairs of an ink and a reach",
            saved=saved,
        )
    reaches = [
        None if reach is None else as_number(reach, "reach of a dip", 0.0, 1.0, SessionError)
        for _, reach in saved
    ]
    inks = [saved_mixture(ink, surface) for ink, _ in saved]
    return tuple(zip(inks, reaches, strict=True))


def saved_inks(surface: PaintedSurface, settings: Mapping[str, Any]) -> list[Mixture] | None:
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
        raise SessionError("the inks are {inks!r:.60}; expected two", inks=inks)
    return [saved_mixture(ink, surface) for ink in inks]


def saved_unit(settings: Mapping[str, Any]) -> str:
    """The unit of lengths as they are shown; millimetres where it is none that is known."""
    unit = settings.get("unit")
    return unit if isinstance(unit, str) and unit in UNITS_MM else "mm"


def chosen_brush(settings: Settings) -> BrushSpec:
    """The brush that a user had in hand last; the default where there is none such any more."""
    try:
        brush = own_brushes()[0].get(settings.brush) or load_brush(settings.brush)
        return brush if settings.brush_mm is None else resized(brush, settings.brush_mm)
    except Paint3DError:
        return load_brush(DEFAULT_BRUSH)


def chosen_material(settings: Settings) -> str:
    """The material that a user chose last; porcelain where there is none such any more.

    Returns
    -------
    str
        A name for `load_material`; it may be that of a file of the user's own.
    """
    try:
        load_material(settings.material)
    except Paint3DError:
        return "porcelain"
    return settings.material


def chosen_inks(settings: Settings) -> list[Mixture | str | Pigment]:
    """The two inks that a user had at hand last; the default in place of any other."""
    palette = {*load_palette(), WATER.name}
    own = own_pigments(settings.pigment_tables).pigments if settings.pigment_tables else {}
    inks: list[Mixture | str | Pigment] = []
    for ink, instead in zip_longest(settings.inks[:2], PURE_INKS):
        parts = dict(ink) if isinstance(ink, Mapping) else {ink: 1.0}
        whole = set(parts) <= palette | set(own) and sum(parts.values()) > 0.0
        chosen: Any = own.get(ink, ink) if isinstance(ink, str) else None
        if chosen is None:
            chosen = {own.get(name, name): part for name, part in parts.items()}
        inks.append(chosen if whole else instead)
    return inks


class InHand(TypedDict, total=False):
    """Settings of these names."""

    brush: str
    brush_mm: float | None
    inks: tuple[str | Mapping[str, float], ...]


def in_hand(brush: BrushSpec, inks: Sequence[Mixture | str | Pigment]) -> InHand:
    """The settings that `chosen_brush` and `chosen_inks` read."""
    name = brush.name.split(" @")[0]
    settings: InHand = {"inks": tuple(_chosen_ink(ink) for ink in inks)}
    made = load_brush(name) if name in brush_names() else own_brushes()[0].get(name)
    if made is not None:
        as_made = made.length_mm == brush.length_mm
        settings["brush"] = name
        settings["brush_mm"] = None if as_made else brush.length_mm
    return settings


def _chosen_ink(ink: Mixture | str | Pigment) -> dict[str, float] | str:
    parts = weights_of(ink)
    return next(iter(parts)) if len(parts) == 1 else parts


def saved_brush(saved: object) -> BrushSpec:
    """The brush that settings name or describe; the default where they do neither.

    Raises
    ------
    UnknownNameError, BrushError
        If there is no such preset, or it describes no brush.
    """
    if isinstance(saved, Mapping):
        return brush_from_words(saved)
    return load_brush(saved if isinstance(saved, str) else DEFAULT_BRUSH, own_files=False)


def saved_mixture(saved: object, surface: PaintedSurface) -> Mixture:
    """Weights of inks by name; those that the palette has otherwise, or not, as on the surface."""
    if not isinstance(saved, Mapping) or not saved:
        raise SessionError("an ink is {saved!r:.60}; expected weights by name", saved=saved)
    if any(isinstance(name, str) and names_table(name) for name in saved):
        raise SessionError(
            "an ink is of a table on this machine, in {saved}; expected names of its own or of the "
            "palette",
            saved=str(saved)[:100],
        )  # fmt: skip
    palette = {**load_palette(), WATER.name: WATER}
    own: dict[str, Pigment]
    own = {p.name: p for p in surface.pigments if palette.get(p.name) is not p}
    return {
        own.get(name) or name: as_number(weight, f"weight of {name}", 1e-9, 1e9, SessionError)
        for name, weight in saved.items()
    }

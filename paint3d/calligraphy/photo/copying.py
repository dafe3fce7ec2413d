"""From a photograph to a page of strokes: the steps in order.

The sheet is found and laid flat, its light taken out, black ink separated from red; the ink's
shape is taken apart into strokes as a font's is, and along each it is measured how dry the brush
was.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.calligraphy.footprint_table import tabulate_footprints
from paint3d.calligraphy.glyphs import EM_UNITS, LEAST_STRENGTH, Box, Glyph, GlyphStroke
from paint3d.calligraphy.page.bands import fill_in_bands, is_wide
from paint3d.calligraphy.page.page import Page, Photograph, Piece, digest_of
from paint3d.calligraphy.photo.characters import Character, characters_of
from paint3d.calligraphy.photo.dryness import dryness_along, region_of, strength_of
from paint3d.calligraphy.photo.flat_page import FlatPage, on_sheet
from paint3d.calligraphy.photo.ink_mask import (
    InkMask,
    drop_brown,
    find_carved,
    find_ink,
    invert_rubbing,
    polygons_in,
    unmix_inks,
)
from paint3d.calligraphy.photo.sheet import (
    check_corners,
    check_exposure,
    check_ground,
    find_sheets,
    remove_light,
    sheet_size,
    straighten,
    white_on_dark,
    whole_picture,
)
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.colour.spectra import srgb_from_linear
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length, signed_area
from paint3d.errors import InputError, Message

if TYPE_CHECKING:
    from shapely import MultiPolygon

__all__ = [
    "Asked",
    "CopiedSheet",
    "SheetPicture",
    "check_widths",
    "copy_sheet",
    "find_photographed_sheet",
]

_LONGEST = 1600  # pixels of the straightened sheet
_MOST_STROKES = 4000  # of a sheet: more take minutes to be found
_BESIDE = 0.02  # of its longer side, that strokes of a file may stand out of it
_BLACKEST = 0.8  # quantile of the strokes' absorption that counts as the sheet's black ink
_BLACK = 0.8  # of the light, that black ink takes at the least
_LOST = 0.02  # of a character's ink: so much may be in no stroke, such as hairlines
_NEARLY = 0.88  # of it: camera and paper make so much of a difference


@dataclass(frozen=True)
class Asked:
    """Facts that are known of a photograph.

    Attributes
    ----------
    corners : (4, 2) array, optional
        Of the sheet, pixels, in any order that goes around it.
    whole, or_whole : bool
        The picture is the sheet, as from a scanner; or it is where no sheet stands out in it.
    invert : bool
        It is a rubbing: white strokes on black.
    lines : tuple of str
        The characters, column by column from the right, or row by row; () where they are not
        known.
    columns : bool
        Whether they stand in columns.
    templates : mapping
        Glyphs of characters that are known.
    least : float
        Of the square of a character's size: smaller bits of ink are no strokes.
    darker : float, optional
        Of the light that the ink takes, 0 to 1: what takes less is no ink. Without it, blots that
        are brown or have soft edges are stains.
    """

    corners: AnyArray | None = None
    whole: bool = False
    or_whole: bool = False
    invert: bool = False
    lines: tuple[str, ...] = ()
    columns: bool = True
    templates: Mapping[str, Glyph] | None = None
    least: float = 0.0
    darker: float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class SheetPicture(FlatPage):
    """A page on the photographed sheet that its strokes were found on.

    Attributes
    ----------
    picture : (H, W, 3) uint8
        The sheet laid flat, sRGB codes.
    corners : (4, 2) float64
        Of the sheet in the photograph, pixels.
    """

    picture: NDArray[np.uint8]
    corners: NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class CopiedSheet(SheetPicture):
    """A sheet and its strokes, which know how dry they are.

    Attributes
    ----------
    ink : InkMask
        On that sheet.
    red : (H, W) float32
        Density of seals there.
    notes : tuple of Message
        What may have been meant otherwise, and which ink no stroke covers.
    """

    ink: InkMask
    red: NDArray[np.float32]
    notes: tuple[Message, ...] = ()

    def taken_from(self, file: Path, scale: float, *, invert: bool = False) -> CopiedSheet:
        """The same with a page that knows its photograph.

        Parameters
        ----------
        file : path
        scale : float
            How many of the file's pixels one of the corners' is.
        invert : bool
            Whether it is a rubbing.
        """
        corners = scale * self.corners
        lies = self.size, self.per_unit, self.origin
        there = Photograph(file, corners, *lies, invert, digest_of(file))
        return replace(self, page=replace(self.page, photograph=there))

    @property
    def wet_page(self) -> Page:
        """The page as a full brush would write it."""
        pieces = []
        for piece in self.page.pieces:
            strokes = tuple(replace(stroke, dryness=()) for stroke in piece.glyph.strokes)
            pieces.append(replace(piece, glyph=replace(piece.glyph, strokes=strokes)))
        return replace(self.page, pieces=tuple(pieces))


def copy_sheet(
    pixels: NDArray[np.uint8],
    name: str,
    asked: Asked | None = None,
    progress: Callable[[float], None] | None = None,
) -> CopiedSheet:
    """Find the strokes on a photographed sheet.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        sRGB codes.
    name : str
        Of the photograph, for reports.
    asked : Asked, optional
    progress : callable, optional
        Called with the fraction of the ink's edge that is taken apart.

    Raises
    ------
    InputError
        If there is no sheet or no ink, too little can be seen of it, or there are more strokes than
        on a sheet of writing; the message says what to do.
    """
    asked = asked or Asked()
    corners, *others = _find_sheets(pixels, asked)
    sheet = straighten(pixels, corners, sheet_size(corners, pixels.shape[:2], _LONGEST))
    reflected, paper = remove_light(sheet)
    if not asked.invert:
        check_ground(sheet)
        check_exposure(sheet, paper)
    n_brown = 0
    if not asked.invert and asked.darker is None:
        reflected, n_brown = drop_brown(reflected, sheet)
    inks = invert_rubbing(sheet) if asked.invert else unmix_inks(reflected)
    ink = (find_carved if asked.invert else find_ink)(inks.black, asked.darker)
    characters = _find_characters(ink, asked)
    per_unit = _em_of(characters) / EM_UNITS
    origin = np.array([0.0, float(sheet.shape[0])])
    pieces: list[Piece] = []
    done = np.cumsum([one.shape.length for one in characters])
    for one, so_far in zip(characters, done / done[-1], strict=True):
        pieces.append(_make_piece(one, ink, asked, per_unit, origin))
        if progress is not None:
            progress(float(so_far))
        if sum(len(piece.glyph.strokes) for piece in pieces) > _MOST_STROKES:
            raise InputError(
                "there are more than {most:,} strokes on the sheet; expected no more: crop it to "
                "fewer characters, or give the corners around them",
                most=_MOST_STROKES,
                hint="--corners",
            )
    if not asked.invert:  # the strokes of a rubbing are where no ink is
        pieces = _set_strengths(pieces, inks.black, ink.mask, per_unit, origin)
    page = Page(tuple(pieces), name, f"Photograph: {name}")
    picture, (height, width) = srgb_from_linear(sheet), sheet.shape[:2]
    copied = CopiedSheet(
        page, (height, width), per_unit, origin, picture=picture, corners=corners, ink=ink,
        red=inks.red,
    )  # fmt: skip
    stains = Message(
        "a blot that is brown or has soft edges was taken for a stain of the paper and left out",
        "{n} blots that are brown or have soft edges were taken for stains of the paper and left "
        "out",
        n=n_brown + ink.stains,
    )
    along_edge = Message(
        "a white piece along the edge of the sheet was taken for no stroke and left out: give "
        "corners farther out if it is one",
        "{n} white pieces along the edge of the sheet were taken for no strokes and left out: give "
        "corners farther out if they are",
        n=ink.along_edge,
    )
    notes = (
        _note_on_others(corners, others),
        _note_on_ground(sheet) if asked.invert else None,
        stains if n_brown + ink.stains else None,
        along_edge if ink.along_edge else None,
        _note_on_lost_ink(copied),
    )
    return replace(copied, notes=tuple(note for note in notes if note is not None))


def find_photographed_sheet(page: Page, pixels: NDArray[np.uint8], scale: float) -> SheetPicture:
    """A page of a file of strokes on the photographed sheet that they were found on.

    Parameters
    ----------
    page : Page
        With a photograph.
    pixels : (H, W, 3) uint8
        That photograph, sRGB codes.
    scale : float
        How many of the file's pixels one of these is.

    Raises
    ------
    InputError
        If it is another one, in which the sheet's corners do not lie, or the strokes not on it.
    """
    there = page.photograph
    assert there is not None, "it was looked at"
    low, high = FlatPage(page, there.size, there.per_unit, there.origin).ink_bounds
    margin = _BESIDE * max(there.size)
    if not ((low > -margin).all() and (high < np.array(there.size[::-1]) + margin).all()):
        raise InputError("the strokes lie beside the sheet; expected them on it")
    corners = check_corners(there.corners / scale, pixels.shape[:2])
    picture = srgb_from_linear(straighten(pixels, corners, there.size))
    return SheetPicture(
        page, there.size, there.per_unit, there.origin, picture=picture, corners=corners
    )


def _find_characters(ink: InkMask, asked: Asked) -> list[Character]:
    """The characters on a sheet, of bits of ink that are not smaller than is asked."""
    shapes = polygons_in(ink.body, ink.width)
    characters = characters_of(shapes, ink.width, asked.lines, columns=asked.columns)
    least = asked.least * _em_of(characters) ** 2
    large_enough = [shape for shape in shapes if shape.area >= least]
    if len(large_enough) == len(shapes):
        return characters
    if not large_enough:
        raise InputError(
            "all pieces of ink on the sheet are smaller than that; expected a smaller least size"
        )
    return characters_of(large_enough, ink.width, asked.lines, columns=asked.columns)


def _find_sheets(pixels: NDArray[np.uint8], asked: Asked) -> list[NDArray[np.float64]]:
    """The corners of the sheet as it is asked for, then those of others that stand out."""
    if asked.corners is not None:
        return [check_corners(asked.corners, pixels.shape[:2])]
    if asked.whole:
        return [whole_picture(pixels)]
    try:
        return find_sheets(pixels)
    except InputError:
        if not asked.or_whole:
            raise
        return [whole_picture(pixels)]


def _note_on_others(
    taken: NDArray[np.float64], others: Sequence[NDArray[np.float64]]
) -> Message | None:
    """Note of sheets that stand out besides the one that is copied; None where none does."""
    if not others:
        return None

    def named(corners: NDArray[np.float64]) -> str:
        return " ".join(f"{x:.0f},{y:.0f}" for x, y in corners)

    return Message(
        "{n} sheets stand out in the picture: copied the one with the corners {taken}; the others' "
        "are {others}",
        n=1 + len(others),
        taken=named(taken),
        others="; ".join(map(named, others)),
    )


def _note_on_ground(sheet: NDArray[np.float32]) -> Message | None:
    """Note of a sheet that is taken for a rubbing, and is mostly white."""
    fraction, _ = white_on_dark(sheet)
    if fraction <= 0.5:
        return None
    return Message(
        "{share:.0%} of the sheet is white, and was copied as the strokes of a rubbing",
        share=fraction,
    )


def _note_on_lost_ink(sheet: CopiedSheet) -> Message | None:
    """Note of characters with ink that no stroke covers, and how much; None where hardly any."""
    from scipy.ndimage import distance_transform_edt

    pieces, drawn = sheet.page.pieces, iter(sheet.drawn())
    owner = np.zeros(sheet.size, np.int32)  # which piece's strokes cover a pixel, from 1; 0: none's
    for k, piece in enumerate(pieces, start=1):
        for stroke in islice(drawn, len(piece.glyph.strokes)):
            box, region = region_of(stroke, sheet.size)
            owner[box][region] = k
    nearest = distance_transform_edt(owner == 0, return_distances=False, return_indices=True)
    count = partial(np.bincount, minlength=len(pieces) + 1)
    ink, bare = sheet.ink.mask, sheet.ink.mask & (owner == 0)
    near = owner[tuple(nearest)]
    fractions = count(near[bare])[1:] / np.maximum(count(near[ink])[1:], 1)
    lost = [
        f"{piece.glyph.text} ({fraction:.0%})"
        for fraction, piece in zip(fractions, pieces, strict=True)
        if fraction > _LOST
    ]
    if not lost:
        return None
    return Message(
        "some of the ink is in no stroke: character {lost}; compare the strokes with the "
        "photograph",
        lost=", ".join(lost),
    )


def _em_of(characters: Sequence[Character]) -> float:
    """Longer side of a usual character, pixels: that half of the ink is in shorter ones."""
    one_by_one = sorted(characters, key=lambda one: max(one.size))
    ink = np.cumsum([one.shape.area for one in one_by_one])
    return float(max(one_by_one[int(np.searchsorted(ink, 0.5 * ink[-1]))].size))


def _make_piece(
    one: Character, ink: InkMask, asked: Asked, per_unit: float, origin: AnyArray
) -> Piece:
    """Make a character with its strokes a piece, about the middle of its box."""
    import shapely

    shape: MultiPolygon = shapely.transform(
        one.shape, lambda points: (points - origin) / per_unit * np.array([1.0, -1.0])
    )
    left, lower, right, upper = shape.bounds
    box: Box = (left, lower, right, upper)
    template = (asked.templates or {}).get(one.text)
    strokes = []
    for stroke in decompose(shape, template=template):
        parts = fill_in_bands(stroke.polygon()) if is_wide(stroke) else [stroke]
        for part in parts:
            seen = on_sheet(part, per_unit, origin)
            dryness, _ = dryness_along(seen, ink.cover, ink.mask)
            strokes.append(replace(part, dryness=dryness))
    at = 0.5 * (left + right), 0.5 * (lower + upper)
    return Piece(Glyph(one.text, tuple(strokes), box, joined=True), at)


def _set_strengths(
    pieces: Sequence[Piece],
    density: NDArray[np.float32],
    inked: NDArray[np.bool_],
    per_unit: float,
    origin: AnyArray,
) -> list[Piece]:
    """Pieces whose strokes say how strong their ink is, against the strongest of the sheet.

    A sheet without a black stroke is compared with what black ink takes.
    """
    taken = [
        [
            strength_of(on_sheet(stroke, per_unit, origin), density, inked)
            for stroke in piece.glyph.strokes
        ]
        for piece in pieces
    ]
    black = max(float(np.quantile([t for own in taken for t in own], _BLACKEST)), _BLACK)
    strong = []
    for piece, own in zip(pieces, taken, strict=True):
        strokes = tuple(
            replace(stroke, strength=_round_strength(t / black))
            for stroke, t in zip(piece.glyph.strokes, own, strict=True)
        )
        strong.append(replace(piece, glyph=replace(piece.glyph, strokes=strokes)))
    return strong


def _round_strength(fraction: float) -> float:
    """A fraction of what black ink takes as a stroke says it; what is nearly black is."""
    return 1.0 if fraction > _NEARLY else max(round(fraction, 3), LEAST_STRENGTH)


# ---- Room for the brush --------------------------------------------------------------------------
# Whether a brush can write strokes as narrow and as wide as those of a page.


_NARROW, _WIDE = 10.0, 90.0  # per cent of the strokes' widths: what may be left to the tip
_TOO_WIDE = 1.15  # times what the brush fills at its full press
_ROUNDED = 1.05  # the size that is named, so that it does


def check_widths(page: Page, brush: BrushSpec, em_mm: float, resolution_mm: float) -> None:
    """Refuse a size at which strokes are finer or wider than the brush, or than what is seen.

    Parameters
    ----------
    page : Page
    brush : BrushSpec
    em_mm : float
        1024 glyph units, mm.
    resolution_mm : float
        Vertex spacing of the surface.

    Raises
    ------
    InputError
        The message names the size that would fit.
    """
    widths = [_mean_width(stroke) for piece in page.pieces for stroke in piece.glyph.strokes]
    narrow, wide = np.percentile(widths, (_NARROW, _WIDE)) * em_mm / EM_UNITS
    rows = tabulate_footprints(build_tuft(brush), 1e3).points
    least, most = (2.0 * float(row[:, 1].max()) for row in (rows[0], rows[-1]))
    finest = max(least, resolution_mm)
    if narrow < finest:
        larger = np.ceil(_ROUNDED * em_mm * finest / narrow)
        if least > resolution_mm:
            raise InputError(
                "strokes are {narrow:.2g} mm wide at a size of {em_mm:g} mm, the brush "
                "{finest:.2g} mm; expected a size of {larger:g} mm",
                narrow=narrow,
                em_mm=em_mm,
                finest=finest,
                larger=larger,
                hint=f"--size {larger:g}",
            )
        raise InputError(
            "strokes are {narrow:.2g} mm wide at a size of {em_mm:g} mm, the vertices lie "
            "{finest:.2g} mm apart; expected a size of {larger:g} mm, or vertices every "
            "{finer:.2g} mm",
            narrow=narrow,
            em_mm=em_mm,
            finest=finest,
            larger=larger,
            finer=0.4 * narrow,
            hint=f"--size {larger:g}, or --resolution {0.4 * narrow:.2g}",
        )
    if wide > _TOO_WIDE * most:
        smaller = np.floor(em_mm * most / wide / _ROUNDED)
        raise InputError(
            "strokes are {wide:.2g} mm wide at a size of {em_mm:g} mm, the brush {brush} at its "
            "full press {most:.2g} mm; expected a larger brush, or a size of {smaller:g} mm",
            wide=wide,
            em_mm=em_mm,
            brush=brush.name,
            most=most,
            smaller=smaller,
            hint=f"--size {smaller:g}",
        )


def _mean_width(stroke: GlyphStroke) -> float:
    """Mean width of a stroke, glyph units."""
    rings = (stroke.outline, *stroke.holes)
    areas = [abs(signed_area(ring)) for ring in rings]
    length = line_length(stroke.median)
    area = max(areas[0] - sum(areas[1:]), 0.0)
    return area / max(length + 0.25 * math.sqrt(area), 1e-9)

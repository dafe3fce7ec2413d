"""Likeness of a painted copy to its photograph, both seen on the same flat sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.flying_white import BLACKEST
from paint3d.calligraphy.glyphs import EM_UNITS
from paint3d.calligraphy.kernels.raster import fill_triangles
from paint3d.calligraphy.page.laying import PlacedPiece
from paint3d.calligraphy.page.page import Piece
from paint3d.calligraphy.photo.copying import CopiedSheet
from paint3d.calligraphy.photo.dryness import dryness_along, strength_of
from paint3d.calligraphy.photo.flat_page import FlatPage
from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import make_chart, unroll
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "PaintedSheet",
    "SheetLikeness",
    "dryness_of_both",
    "likeness_of",
    "painted_sheet",
    "strength_of_both",
]

_NODES_PER_EM = 24.0
_REACH = 0.06  # ems beyond a piece's box and strokes, that ink may stand out
_COVERED = 0.5


@dataclass(frozen=True, eq=False)
class PaintedSheet:
    """A painting, piece by piece, where its pieces lie on the sheet.

    Attributes
    ----------
    picture : (H, W, 3) uint8
        sRGB codes; what is not painted has the surface's colour.
    cover : (H, W) float32
        What fraction of each pixel is under ink.
    """

    picture: NDArray[np.uint8]
    cover: NDArray[np.float32]


@dataclass(frozen=True)
class SheetLikeness:
    """Comparison of a photograph with its painted copy.

    Attributes
    ----------
    iou : float
        Of the strokes' bodies, flying white filled: area of the intersection over the union.
    ink_iou : float
        The same of the ink itself, streak against streak.
    dryness_r, dryness_error : float
        Correlation and mean difference of the fractions left bare, station by station along all
        strokes; NaN for the correlation where all are alike.
    """

    iou: float
    ink_iou: float
    dryness_r: float
    dryness_error: float

    def summary(self) -> str:
        """Return it in one line."""
        r = "none to compare" if np.isnan(self.dryness_r) else f"correlation {self.dryness_r:.2f}"
        return (
            f"strokes alike to {self.iou:.3f} (IoU), ink to {self.ink_iou:.3f}; dryness: {r}, "
            f"off by {self.dryness_error:.2f}"
        )


def painted_sheet(
    sheet: FlatPage, placed: list[tuple[Piece, PlacedPiece]], surface: PaintedSurface
) -> PaintedSheet:
    """The painting rectified onto the sheet, each piece in a chart around its own middle.

    Parameters
    ----------
    sheet : FlatPage
    placed : list of (Piece, PlacedPiece)
        Where the pieces lie on the page, and on the object.
    surface : PaintedSurface
    """
    height, width = sheet.size
    colour = surface.mesh.colours
    assert colour is not None
    plain = np.median(colour[~surface.painted], axis=0) if (~surface.painted).any() else 255.0
    planes = [np.full((height, width), level, np.float32) for level in np.broadcast_to(plain, 3)]
    cover = np.zeros((height, width), np.float32)
    closest = surface.closest_points
    faces, covered = surface.paint_mesh.leaf_faces(), surface.coverage
    faces = faces[(covered[faces] > 0.0).any(axis=1)]
    used = np.unique(faces)
    there = surface.paint_mesh.vertices[used].astype(np.float64)
    for piece, laid in placed:
        points = np.full((len(covered), 2), np.nan)
        points[used] = _to_page(piece, laid, closest, there, sheet)
        mine = faces[np.isfinite(points[faces]).all(axis=(1, 2))]
        values = np.asarray(covered, np.float32)
        fill_triangles(points, values, mine, cover)
        for k, plane in enumerate(planes):
            fill_triangles(points, np.ascontiguousarray(colour[:, k], np.float32), mine, plane)
    picture = np.clip(np.round(np.stack(planes, axis=-1)), 0.0, 255.0).astype(np.uint8)
    return PaintedSheet(picture, cover)


def _to_page(
    piece: Piece, laid: PlacedPiece, closest: ClosestPoints, there: AnyArray, sheet: FlatPage
) -> NDArray[np.float64]:
    """Positions of surface points on the sheet, pixels; NaN beyond the piece."""
    square = laid.square
    em = square.em_mm
    box = 0.5 * np.array([square.width_mm, square.height_mm])
    ink = [np.abs(one.outline - laid.glyph.middle).max(axis=0) for one in laid.glyph.strokes]
    half = np.max([box, *(em / EM_UNITS * np.array(ink))], axis=0) + _REACH * em
    chart = make_chart(closest, square.chart.frame, half[0], half[1], em / _NODES_PER_EM)
    units = unroll(chart, there) * (EM_UNITS / em) + np.array(piece.at)
    result: NDArray[np.float64] = sheet.per_unit * units * np.array([1.0, -1.0]) + sheet.origin
    return result


def likeness_of(sheet: CopiedSheet, painted: PaintedSheet) -> SheetLikeness:
    """Compare a photographed sheet and what was painted after it."""
    ink, mask = sheet.ink, painted.cover > _COVERED
    one, other = dryness_of_both(sheet, painted)
    alike = len(one) < 3 or min(np.ptp(one), np.ptp(other)) < 0.05
    r = float("nan") if alike else float(np.corrcoef(one, other)[0, 1])
    error = float(np.abs(one - other).mean()) if len(one) else 0.0
    return SheetLikeness(_iou(_fill_body(mask, ink.body), ink.body), _iou(mask, ink.mask), r, error)


def strength_of_both(
    sheet: FlatPage, painted: PaintedSheet
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Strength of the ink of all strokes (K,): as they say, and painted."""
    table = decode_srgb(np.arange(256, dtype=np.uint8))
    light = table[painted.picture].mean(axis=2)
    mask = painted.cover > _COVERED
    bare = painted.cover <= 0.0
    plain = float(np.median(light[bare])) if bare.any() else 1.0
    density = -np.log10(np.maximum(light / plain, 1e-4)).astype(np.float32)
    asked = [stroke.strength for stroke in sheet.strokes]
    got = [min(strength_of(seen, density, mask) / BLACKEST, 1.0) for seen in sheet.drawn()]
    return np.array(asked), np.array(got)


def dryness_of_both(
    sheet: FlatPage, painted: PaintedSheet
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fractions (K,) left bare at the stations of all strokes: as they say, and painted.

    Strokes that do not say how dry they are have no stations.
    """
    mask = painted.cover > _COVERED
    asked: list[float] = []
    got: list[float] = []
    for stroke, seen in zip(sheet.strokes, sheet.drawn(), strict=True):
        n = len(stroke.dryness)
        if n:
            dryness, _ = dryness_along(seen, painted.cover, mask, n)
            asked += stroke.dryness
            got += dryness
    return np.array(asked), np.array(got)


def _fill_body(mask: AnyArray, body: AnyArray) -> NDArray[np.bool_]:
    """Painted mask, with what it leaves bare within the body but for the body's rim.

    A painted streak stands for the bare ones beside it, half a width to either side.
    """
    from scipy.ndimage import distance_transform_edt

    depth = distance_transform_edt(body)
    reach = distance_transform_edt(~mask)
    result: NDArray[np.bool_] = mask | (reach < depth)
    return result


def _iou(one: AnyArray, other: AnyArray) -> float:
    return float((one & other).sum() / max(int((one | other).sum()), 1))

"""Masks of a sheet's ink and of the strokes' bodies: as far as the brush went, flying white too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.optional_packages import import_optional
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from shapely import Polygon

__all__ = [
    "InkMask",
    "Inks",
    "bodies_in",
    "drop_brown",
    "find_carved",
    "find_ink",
    "invert_rubbing",
    "otsu",
    "polygons_in",
    "unmix_inks",
]

# ---- Bodies of strokes ---------------------------------------------------------------------------
# The strokes' bodies: as far as the brush went, with what it left bare between its hairs.
#
# Where ink lies in streaks the brush ran dry. A hair that let go and took hold again went over what
# is bare between, so gaps are closed along the streaks as well as across them; wet strokes end
# where their ink does.


_NOTCH = 0.25  # half widths: notches of a rough edge, up to twice as wide, are a wet stroke's, too
_GAP = 0.5  # the same of bare streaks, of a stroke that has streaks
_DRY_GAP = 1.0  # the same where there are many
_STREAK = 0.16  # of a width: half of a streak's
_MANY, _MANY_NEAR = 0.16, 0.45  # fraction of a pixel that streaks cover; widths around it
_SOME, _ANY, _SOME_NEAR = 0.03, 0.003, 0.8  # the same of a few, and of one
_FAINT_BODY = 0.02  # the same: there faint ink is a stroke's, too
_ALONG = 2.0  # widths: bare bits of a hair's way up to so long belong to the stroke
_BESIDE = 0.8  # widths from ink that such a way lies at the most
_GRAIN, _TURN = 0.06, 0.4  # widths over which edges are seen, and the way of the streaks
_HOLE = 0.3  # squares of a width: smaller holes belong to the stroke
_SLIT = 0.1  # widths: half of that of a filled gap that may be a counter
_THICK, _STREAKY = 0.28, 0.5  # of a width: half of ink that is no hair's; hairs' part of a rim
_ROOM, _THIN_BARS = 0.3, 0.75  # of a width: half of gaps as wide as a counter; the same of theirs
_NARROW = 0.4  # widths: half of that of a hole among streaks that does, too


def bodies_in(mask: NDArray[np.bool_], faint: NDArray[np.bool_], width: float) -> NDArray[np.bool_]:
    """Strokes with the bare streaks within them; counters stay open.

    Parameters
    ----------
    mask, faint : (H, W) bool
        Where ink is, and where at least a little is.
    width : float
        Of a usual stroke, pixels.
    """
    streaks = _find_streaks(mask, width)
    near = _streak_fraction(streaks, _SOME_NEAR * width)
    inked = mask | (faint & (near > _FAINT_BODY))
    inked |= _gaps_between_hairs(inked, near > _SOME, width)
    closed = inked | _close_gaps(inked, _NOTCH * 0.5 * width)
    closed |= _close_gaps(inked, _GAP * 0.5 * width) & (near > _ANY)
    many = _streak_fraction(streaks, _MANY_NEAR * width) > _MANY
    closed |= _close_gaps(inked, _DRY_GAP * 0.5 * width) & many
    closed |= _find_small_holes(closed, near > _ANY, width)
    closed &= ~_find_counters(closed & ~_close_gaps(mask, _NOTCH * 0.5 * width), mask, width)
    return _without_specks(closed, _BIT * width**2)


def _without_specks(mask: AnyArray, least: float) -> NDArray[np.bool_]:
    """A mask without connected bits of fewer pixels."""
    from scipy.ndimage import label

    areas, _ = label(mask, np.ones((3, 3)))
    sizes = np.bincount(areas.ravel())
    sizes[0] = 0
    result: NDArray[np.bool_] = (sizes >= least)[areas]
    return result


def _close_gaps(mask: AnyArray, reach: float) -> NDArray[np.bool_]:
    """A mask with gaps filled that are narrower than twice a reach, pixels."""
    from scipy.ndimage import distance_transform_edt

    grown = np.pad(distance_transform_edt(~mask) <= reach, 1)
    result: NDArray[np.bool_] = distance_transform_edt(grown)[1:-1, 1:-1] > reach
    return result


def _find_small_holes(closed: AnyArray, streaky: AnyArray, width: float) -> NDArray[np.bool_]:
    """Holes that are no counters: small ones, and among streaks those no wider than one."""
    from scipy.ndimage import distance_transform_edt, label, maximum, mean

    holes, n = label(~closed)
    small = np.bincount(holes.ravel(), minlength=n + 1) < _HOLE * width**2
    if n:
        depth = maximum(distance_transform_edt(~closed), holes, np.arange(n + 1))
        small |= (depth < _NARROW * width) & (mean(streaky, holes, np.arange(n + 1)) > 0.5)
    small[0] = False
    result: NDArray[np.bool_] = small[holes]
    return result


def _find_counters(filled: AnyArray, mask: AnyArray, width: float) -> NDArray[np.bool_]:
    """Filled gaps between strokes: wider than slits, with more ink of strokes around than hairs."""
    from scipy.ndimage import binary_dilation, distance_transform_edt, label, maximum, mean

    gaps, n = label(filled)
    each = np.arange(n + 1)
    thick = distance_transform_edt(distance_transform_edt(mask) <= _THICK * width) <= _THICK * width
    beside = binary_dilation(mask & ~thick, iterations=2)
    rim = np.where(filled & (distance_transform_edt(filled) <= 1.5), gaps, 0)
    streaky = mean(beside, rim, each)
    half = maximum(distance_transform_edt(filled), gaps, each) / width
    large = np.bincount(gaps.ravel()) > _HOLE * width**2
    open_ = (half > _SLIT) & large & (streaky < np.where(half > _ROOM, _THIN_BARS, _STREAKY))
    open_[0] = False
    result: NDArray[np.bool_] = open_[gaps]
    return result


def _find_streaks(mask: AnyArray, width: float) -> NDArray[np.bool_]:
    """Ink that is much narrower than a stroke."""
    from scipy.ndimage import distance_transform_edt

    thin = _STREAK * width
    core = distance_transform_edt(mask) > thin
    result: NDArray[np.bool_] = mask & (distance_transform_edt(~core) > thin + 1.5)
    return result


def _streak_fraction(streaks: AnyArray, reach: float) -> NDArray[np.float32]:
    """Fraction of streaks among the pixels around each."""
    from scipy.ndimage import gaussian_filter

    result: NDArray[np.float32] = gaussian_filter(streaks.astype(np.float32), reach)
    return result


def _gaps_between_hairs(inked: AnyArray, where: AnyArray, width: float) -> NDArray[np.bool_]:
    """Bare pixels that have ink before and behind them along the hairs."""
    from scipy.ndimage import distance_transform_edt

    gaps = np.zeros(inked.shape, bool)
    bare = ~inked & where
    bare &= distance_transform_edt(~inked) <= _BESIDE * width
    pixels = np.argwhere(bare)
    if not len(pixels):
        return gaps
    directions = _hair_directions(inked, width)
    longest = int(_ALONG * width)
    ahead = _pixels_to_ink(inked, pixels, directions, longest)
    behind = _pixels_to_ink(inked, pixels, -directions, longest)
    rows, columns = pixels[ahead + behind <= longest].T
    gaps[rows, columns] = True
    return gaps


def _hair_directions(inked: AnyArray, width: float) -> NDArray[np.float32]:
    """Direction of the streaks, or edges, around each pixel: (H, W, 2) unit vectors, either sign.

    It is across the main axis of the structure tensor (Bigun and Granlund 1987).
    """
    from scipy.ndimage import gaussian_filter

    down, right = np.gradient(gaussian_filter(inked.astype(np.float32), max(1.0, _GRAIN * width)))
    reach = _TURN * width
    dd, rr, dr = (gaussian_filter(a, reach) for a in (down * down, right * right, down * right))
    along = 0.5 * np.arctan2(2.0 * dr, rr - dd) + 0.5 * np.pi
    return np.stack([np.sin(along), np.cos(along)], axis=-1).astype(np.float32)


def _pixels_to_ink(
    inked: AnyArray, pixels: AnyArray, directions: AnyArray, longest: int
) -> NDArray[np.float64]:
    """Lengths (N,) of the rays from pixels (N, 2) to ink; infinite where there is none."""
    last = np.array(inked.shape) - 1
    far = np.full(len(pixels), np.inf)
    at, cell = pixels.astype(np.float64), pixels
    heading = directions[cell[:, 0], cell[:, 1]]
    for step in range(1, longest + 1):
        at = at + heading
        cell = np.clip(np.rint(at).astype(int), 0, last)
        reached = inked[cell[:, 0], cell[:, 1]]
        far[reached] = np.minimum(far[reached], step)
        there = directions[cell[:, 0], cell[:, 1]]
        turned = (there * heading).sum(axis=1, keepdims=True) < 0.0
        heading = np.where(turned, -there, there)
    return far


# ---- The mask ------------------------------------------------------------------------------------


_LOW, _HIGH = 0.3, 0.45  # of Otsu's threshold: ink goes on to the one where it reaches the other
_EDGE = 0.575  # of the light that ink near by takes: there an edge lies, however it is blurred
_FAINT = 0.5  # the same of ink that is a dry stroke's, though its edge may be farther in
_LENS = 1.0  # pixels: how far a photograph spreads what is narrow
_NOISES = 5.0  # standard deviations of the paper that ink stands out by at the least
_FAINTEST = 0.06  # density of the palest ink that is one
_DARK = 90.0  # per cent of what is inked take less light than unbroken ink
_LENS_EDGE = 0.7  # pixels over which the steepness of edges is measured
_SHARP, _SOFT = 25.0, 1.8  # per cent of edges are sharper than usual ink's; times as soft: stains'
_PALE = 0.68  # of the ink's darkness: what is darker is no stain
_PALE_AMONG, _AMONG = 0.75, 3.0  # the same of what lies so many widths from stains
_BROAD = 1.0  # widths: half of what is too broad for a stroke
_VERY_SOFT = 3.0  # times as soft as usual ink's: stains', however dark they are
_BLOT_PX = 2.5  # half the width of the narrowest stain: what a lens spread is a hair
_MOST_STAINED = 0.5  # of all that is dark
_SPECK = 0.01  # squares of a stroke's width: smaller bits of ink are dust
_MARGIN = 0.012  # of the sheet's shorter side: its edges are no strokes
_MOST = 0.6  # of the sheet: more than that is no writing
_LEAST = 2e-4
_DITHERED = 30.0  # pixels of ink to each piece of it and hole in it: fewer is no writing
_MOST_PIECES = 2000  # the same of strokes' bodies on a sheet
_SAME = 1e-6  # of the larger: values that differ by less are the same
_CUT_UP = 1.3  # times as wide as their ink: bodies of strokes that streaks cut up
_COARSEST = 5.0  # pixels: narrower strokes are too coarse to be taken apart


@dataclass(frozen=True, eq=False)
class InkMask:
    """Ink on a sheet.

    Attributes
    ----------
    cover : (H, W) float32
        What fraction of the paper's light the ink takes, over that of unbroken ink: how much of a
        pixel is inked, 0 to 1.
    mask : (H, W) bool
        Where ink is.
    body : (H, W) bool
        What the strokes cover, with the bare streaks in them.
    width : float
        Of a usual stroke, pixels.
    full : float
        Fraction of the light that unbroken ink takes.
    stains : int
        How many blots with soft edges were taken for stains of the paper.
    along_edge : int
        How many white pieces that lie along the edge of a rubbing were taken for no strokes.
    """

    cover: NDArray[np.float32]
    mask: NDArray[np.bool_]
    body: NDArray[np.bool_]
    width: float
    full: float
    stains: int = 0
    along_edge: int = 0


def find_ink(density: NDArray[np.float32], darker: float | None = None) -> InkMask:
    """Find the ink on a sheet by its density (H, W).

    Parameters
    ----------
    density : (H, W) float32
    darker : float, optional
        Only what takes more than this fraction, 0 to 1, of the light that the ink takes: what is
        paler, such as stains, is ground. Without it, blots with soft edges are.

    Raises
    ------
    InputError
        If there is none, or too much, if it lies in dots, in more pieces than writing has, or if
        its strokes are too few pixels wide.
    """
    from scipy.ndimage import gaussian_filter

    inner = _inner_mask(density)
    density, n_broad = _without_broad_stains(density, inner) if darker is None else (density, 0)
    smooth = np.where(inner, gaussian_filter(density, 0.5), 0.0)
    taken = 1.0 - 10.0 ** -np.where(inner, density, 0.0)  # linear in what is inked of a pixel
    near = _threshold(smooth, inner)
    if darker and near.any():
        full = float(np.percentile(gaussian_filter(taken, 0.7)[near], _DARK))
        smooth = np.where(gaussian_filter(taken, 0.7) > darker * full, smooth, 0.0)
        near = _threshold(smooth, inner)
    relative = (2.0 * taken - gaussian_filter(taken, _LENS)) / np.maximum(
        _local_absorption(taken, near), 1e-6
    )
    mask, faint = near & (relative > _EDGE), near & (relative > _FAINT)
    stained, n_stains = _find_stains(mask, taken) if darker is None else (np.zeros_like(mask), 0)
    mask, faint = mask & ~stained, faint & ~stained
    if mask.mean() < _LEAST:
        raise InputError(
            "no ink was found on the sheet; expected dark strokes on paper",
            hint="of a rubbing: --invert",
        )
    if mask.sum() > _MOST * inner.sum():
        raise InputError(
            "{share:.0%} of the sheet is dark; expected writing on paper, and the corners of the "
            "paper where the picture shows more",
            share=mask.sum() / inner.sum(),
            hint="--corners; of a rubbing --invert",
        )
    width = _stroke_width(mask)
    mask, faint = (_without_specks(one, _SPECK * width**2) for one in (mask, faint))
    pieces = _pieces_and_holes(mask)
    if mask.sum() < _DITHERED * pieces:
        raise InputError(
            "the ink lies in {pieces:,} dots and gaps of a few pixels, as greys do that are "
            "dithered to black and white; expected strokes: scan in grey",
            pieces=pieces,
        )
    body = bodies_in(mask, faint, width)
    if (whole := _stroke_width(body)) > _CUT_UP * width:
        body = bodies_in(mask, faint, whole)
    _check_pieces(body)
    mask &= body
    width = _require_width(body)
    full = max(float(np.percentile(taken[mask], 75.0)), 1e-3)
    return InkMask(
        np.clip(taken / full, 0.0, 1.0).astype(np.float32), mask, body, width, full,
        n_broad + n_stains,
    )  # fmt: skip


def _without_broad_stains(
    density: NDArray[np.float32], inner: AnyArray
) -> tuple[NDArray[np.float32], int]:
    """Density without that of blots with soft edges, broader than strokes, and how many.

    They are what an opening by more than a stroke's width leaves, so that ink on them is kept. Only
    what would be taken for ink is counted.
    """
    from scipy.ndimage import (
        binary_erosion,
        gaussian_gradient_magnitude,
        label,
        maximum,
        maximum_filter,
        median,
        minimum_filter,
    )

    density = np.where(inner, density, 0.0).astype(np.float32)
    near = _threshold(density, inner)
    edges = near & ~binary_erosion(near)
    if not edges.any():
        return density, 0
    reach = 2 * round(_BROAD * _stroke_width(near)) + 1
    opened = maximum_filter(minimum_filter(density, reach), reach)
    pieces, n = label(opened > _FAINTEST, np.ones((3, 3)))
    each = np.arange(n + 1)
    steep = gaussian_gradient_magnitude(density, _LENS_EDGE)
    usual = np.percentile(density[near], 75.0) / np.percentile(steep[edges], 100.0 - _SHARP)
    darkest = maximum(opened, pieces, each)
    half = (pieces > 0) & (opened > 0.5 * darkest[pieces])  # an edge's foot is soft in ink, too
    rim = half & ~binary_erosion(half)
    steep = gaussian_gradient_magnitude(opened, _LENS_EDGE)
    softness = darkest / np.maximum(median(steep, np.where(rim, pieces, 0), each), 1e-4)
    stained = softness > _VERY_SOFT * usual
    stained[0] = False
    taken_off = np.where(stained[pieces], opened, 0.0)
    return density - taken_off, len(np.unique(pieces[near & (taken_off > 0.0)]))


def _find_stains(mask: NDArray[np.bool_], taken: AnyArray) -> tuple[NDArray[np.bool_], int]:
    """Pieces whose edges are much softer than the ink's, a little around them; how many.

    Of dark ones they must be softer still. Smaller ones that lie among them and are nearly as pale
    are of the same stain, though a fold or the sheet's edge may end it sharply. Where they are more
    than a part of all, what is pale is the writing.
    """
    from scipy.ndimage import (
        binary_dilation,
        binary_erosion,
        distance_transform_edt,
        gaussian_gradient_magnitude,
        label,
        maximum,
        mean,
        median,
    )

    pieces, n = label(mask, np.ones((3, 3)))
    each = np.arange(n + 1)
    edges = mask & ~binary_erosion(mask)
    if not edges.any():
        return np.zeros_like(mask), 0
    steep = gaussian_gradient_magnitude(taken, _LENS_EDGE)
    dark = mean(taken, pieces, each)
    softness = dark[pieces] / np.maximum(steep, 1e-4)
    usual = float(np.percentile(softness[edges], _SHARP))
    soft = median(softness, np.where(edges, pieces, 0), each) / usual
    paleness = dark / np.percentile(taken[mask], 75.0)
    broad = maximum(distance_transform_edt(mask), pieces, each) > _BLOT_PX
    stained = (soft > np.where(paleness < _PALE, _SOFT, _VERY_SOFT)) & broad
    stained[0] = False
    sizes = np.bincount(pieces.ravel())
    if stained.any():
        near = distance_transform_edt(~stained[pieces]) < _AMONG * _stroke_width(mask)
        among = maximum(near, pieces, each).astype(bool) & (paleness < _PALE_AMONG) & broad
        stained |= among & (sizes < sizes[stained].max())
    stain_mask = stained[pieces]
    if stain_mask.sum() > _MOST_STAINED * mask.sum():
        return np.zeros_like(mask), 0
    least = _stroke_width(mask) ** 2
    n_told = max(int((sizes[stained] > least).sum()), int(stain_mask.sum() > least))
    return binary_dilation(stain_mask, iterations=2), n_told


# ---- The mask of a rubbing -----------------------------------------------------------------------
# Strokes of stone were cut, not written: they have no flying white. Dots of grain and of worn
# stone, alone and in bands, are ground; dark ones within strokes are not.


_BLUR = 0.15  # of a width: what grain is smoothed by
_ROUNDS = 4  # of looking for the width that this is a part of
_CARVED = 0.35  # of white: less is ground
_THIN = 0.15  # of a width: half of that of what is too thin for a stroke
_LARGE = 0.1  # of the largest piece: smaller ones may be grain
_CHIP = 0.6  # squares of a width: smaller pieces are grain
_WORN = 0.7  # of what strokes are as white as: darker pieces are worn stone
_FEW_WIDTHS, _WORN_BIT = 4.0, 0.8  # squares of a width, and the same of pieces that are smaller
_RIM = 1.5  # widths along the sheet's edge that a stroke across it takes at the most
_MOUNT = 0.25  # of the sheet's shorter side: what lies so long along an edge is the rubbing's mount


def find_carved(density: NDArray[np.float32], darker: float | None = None) -> InkMask:
    """Find the strokes of a rubbing by how white it is, 0 to 1 (H, W).

    Parameters
    ----------
    density : (H, W) float32
        0 on black ground, 1 on white strokes.
    darker : float, optional
        Only what is whiter than this.

    Raises
    ------
    InputError
        If there are none, if they lie in more pieces than writing has, or are too few pixels wide.
    """
    from scipy.ndimage import distance_transform_edt, gaussian_filter, label, mean

    inner = _inner_mask(density)
    width = _COARSEST
    for _ in range(_ROUNDS):
        smooth = gaussian_filter(density, _BLUR * width)
        mask = inner & (
            smooth > max(_CARVED, otsu(np.clip(smooth[inner], 0.0, 1.0)), darker or 0.0)
        )
        mask, _ = _drop_rim_pieces(mask, inner, _MOUNT * min(mask.shape))
        before, width = width, max(_stroke_width(_drop_grain(mask)), _COARSEST)
        if abs(width - before) < 0.05 * width:
            break
    thick = distance_transform_edt(mask) > _THIN * width
    core = distance_transform_edt(~thick) <= _THIN * width
    mask &= distance_transform_edt(~core) <= 2.0 * _THIN * width
    mask = _without_specks(mask, _CHIP * width**2)
    pieces, n = label(mask, np.ones((3, 3)))
    whiteness = (
        mean(smooth, pieces, np.arange(n + 1)) / np.median(smooth[mask]) if n else np.ones(1)
    )
    is_bit = np.bincount(pieces.ravel()) < _FEW_WIDTHS * width**2
    dropped = whiteness < np.where(is_bit, _WORN_BIT, _WORN)
    body, n_along = _drop_rim_pieces(mask & ~dropped[pieces], inner, _RIM * width)
    body |= ~_without_specks(~body, _HOLE * width**2)
    body = gaussian_filter(body.astype(np.float32), _BLUR * width) > 0.5
    if body.mean() < _LEAST:
        raise InputError(
            "no white strokes were found on the sheet; expected those of a rubbing on black",
            hint="of ink on paper no --invert",
        )
    _check_pieces(body)
    cover, width = body.astype(np.float32), _require_width(body)
    return InkMask(cover, body, body, width, 1.0, along_edge=n_along)


def _drop_grain(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask without the pieces that are much smaller than the largest: grain."""
    from scipy.ndimage import label

    pieces, _ = label(mask, np.ones((3, 3)))
    sizes = np.bincount(pieces[mask], minlength=1)
    result: NDArray[np.bool_] = mask & (sizes >= _LARGE * sizes.max())[pieces]
    return result


def _drop_rim_pieces(
    mask: NDArray[np.bool_], inner: NDArray[np.bool_], most: float
) -> tuple[NDArray[np.bool_], int]:
    """A mask without pieces of which more pixels lie along the rim of what is seen; how many."""
    from scipy.ndimage import binary_erosion, label

    pieces, n = label(mask, np.ones((3, 3)))
    along = np.bincount(pieces[inner & ~binary_erosion(inner)], minlength=n + 1)
    along[0] = 0
    return mask & (along <= most)[pieces], int(np.count_nonzero(along > most))


def _inner_mask(density: AnyArray) -> NDArray[np.bool_]:
    """All of a sheet but the margin along its edges, which may be the table's or a frame's."""
    margin = max(1, round(_MARGIN * min(density.shape)))
    inner = np.zeros(density.shape, bool)
    inner[margin:-margin, margin:-margin] = True
    return inner


def _check_pieces(body: NDArray[np.bool_]) -> None:
    pieces = _pieces_and_holes(body)
    if pieces > _MOST_PIECES:
        raise InputError(
            "the ink lies in {pieces:,} pieces and gaps in them; expected writing, of {most:,} at "
            "the most: crop it to fewer characters, or give the corners around them",
            hint="--corners",
            pieces=pieces,
            most=_MOST_PIECES,
        )


def _require_width(body: NDArray[np.bool_]) -> float:
    """Of a usual stroke, pixels, where it is not too narrow."""
    width = _stroke_width(body)
    if width < _COARSEST:
        raise InputError(
            "strokes are {width:.1f} pixels wide on the straightened sheet; expected {least:g} or "
            "more: photograph it from nearer, or crop it to fewer characters",
            width=width,
            least=_COARSEST,
        )
    return width


def _pieces_and_holes(mask: NDArray[np.bool_]) -> int:
    """Numbers of connected pieces of a mask, and of holes in them."""
    from scipy.ndimage import label

    _, pieces = label(mask, np.ones((3, 3)))
    _, holes = label(~mask)
    return int(pieces + holes) - 1  # around all of them is no hole


def _threshold(density: AnyArray, inner: AnyArray) -> NDArray[np.bool_]:
    """Hysteresis threshold: pixels of high density, and their neighbours of moderate density."""
    from scipy.ndimage import label

    values = density[inner]
    middle = float(np.median(values))
    noise = 1.4826 * float(np.median(np.abs(values - middle)))
    threshold = otsu(np.clip(values, 0.0, np.percentile(values, 99.8)))
    low = max(_LOW * threshold, middle + _NOISES * noise, _FAINTEST)
    high = max(_HIGH * threshold, 1.05 * low)
    areas, n = label(density > low, np.ones((3, 3)))
    reached = np.zeros(n + 1, bool)
    reached[np.unique(areas[density > high])] = True
    reached[0] = False
    result: NDArray[np.bool_] = reached[areas]
    return result


def _local_absorption(taken: AnyArray, near: AnyArray) -> NDArray[np.float64]:
    """The fraction of light that unbroken ink takes around each pixel."""
    from scipy.ndimage import gaussian_filter, maximum_filter

    reach = max(3, 2 * round(0.5 * _stroke_width(near)) + 1)
    most = maximum_filter(np.where(near, gaussian_filter(taken, 0.7), 0.0), reach)
    result: NDArray[np.float64] = gaussian_filter(most, 0.25 * reach)
    return result


def otsu(values: AnyArray) -> float:
    """The threshold that parts values into two classes of least variance (Otsu 1979).

    Of values that are all the same it is that value.
    """
    highest = float(values.max())
    if highest - float(values.min()) < _SAME * max(abs(highest), 1.0):
        return highest
    counts, edges = np.histogram(values, 256)
    middles = 0.5 * (edges[:-1] + edges[1:])
    below, sums = np.cumsum(counts), np.cumsum(counts * middles)
    above = below[-1] - below
    means = sums / np.maximum(below, 1), (sums[-1] - sums) / np.maximum(above, 1)
    between = below * above * (means[0] - means[1]) ** 2.0
    return float(middles[int(np.argmax(between))])


def _stroke_width(mask: AnyArray) -> float:
    """Of a usual stroke, pixels: twice the depth along the middle lines that half the ink has."""
    from scipy.ndimage import distance_transform_edt, maximum_filter

    depth = distance_transform_edt(mask)
    ridge = mask & (depth >= maximum_filter(depth, 3) - 1e-6) & (depth > 1.0)
    if not ridge.any():
        return 1.0
    depths = np.sort(depth[ridge])  # each stands for as much ink: streaks count for little
    cumulative = np.cumsum(depths)
    return 2.0 * float(depths[np.searchsorted(cumulative, 0.5 * cumulative[-1])])


# ---- Outlines ------------------------------------------------------------------------------------
# From a raster of strokes' bodies to polygons, with edges between the pixels.


_SMOOTH = 0.7  # pixels
_STRAY = 0.15  # pixels that an edge may be simplified by
_BIT = 0.5  # squares of a width: smaller bits that smoothing cuts off are no strokes


def polygons_in(body: NDArray[np.bool_], width: float) -> list[Polygon]:
    """The connected shapes of a raster, each with its holes; x to the right, y down.

    Edges are smoothed, so ink that hangs together by a neck of a pixel is a shape on either side.

    Parameters
    ----------
    body : (H, W) bool
    width : float
        Of a usual stroke, pixels.
    """
    import shapely
    from scipy.ndimage import find_objects, gaussian_filter, label

    measure = import_optional("skimage.measure")
    areas, _ = label(body, np.ones((3, 3)))
    polygons = []
    for k, box in enumerate(find_objects(areas)):
        part = np.pad((areas[box] == k + 1).astype(np.float32), 4)
        rings = measure.find_contours(gaussian_filter(part, _SMOOTH), 0.5)
        start = np.array([box[1].start, box[0].start]) - 4.0 + 0.5
        shapes = _nest_rings(
            [shapely.Polygon(ring[:, ::-1] + start) for ring in rings if len(ring) > 4]
        )
        largest = max((shape.area for shape in shapes), default=0.0)
        least = min(_BIT * width**2, largest)
        polygons += [shape for shape in shapes if shape.area >= least]
    return polygons


def _nest_rings(rings: Sequence[Polygon]) -> list[Polygon]:
    """The areas that an odd number of rings goes around, largest first, with their holes."""
    import shapely

    rings = sorted(rings, key=lambda ring: -ring.area)
    insides = [ring.representative_point() for ring in rings]
    around = np.array([shapely.contains(ring, insides) for ring in rings])  # [outer, inner]
    around = np.triu(around, 1)  # a ring lies in larger ones, wherever its inside is
    depth = around.sum(axis=0)
    parts: list[Polygon] = []
    for k in np.flatnonzero(depth % 2 == 0):
        holes = [rings[i].exterior for i in np.flatnonzero(around[k] & (depth == depth[k] + 1))]
        whole = shapely.Polygon(rings[k].exterior, holes).simplify(_STRAY)
        whole = whole if whole.is_valid else shapely.make_valid(whole)
        flat = shapely.get_parts(shapely.get_parts(whole))  # a collection may hold a multipolygon
        parts += [part for part in flat if part.geom_type == "Polygon"]
    return parts


# ---- Ink and seals -------------------------------------------------------------------------------
# Black ink and red seals separated: inks over each other add in density, -log10 of the light.
#
# The density of every pixel is made of black and of red, neither less than none (least squares).
# Red is the sheet's own: the mean direction of its most coloured pixels.


_BLACK = np.ones(3) / np.sqrt(3.0)
_CINNABAR = np.array([0.08, 0.85, 0.75])  # densities in red, green and blue light
_COLOURED = 0.18  # by how much the density in green and blue exceeds that in red on a seal
_MOST_RED = 0.55  # of the density in green: in red light a red seal is hardly seen
_FEW = 2e-4  # of the sheet: fewer coloured pixels are no seal, and no stain
_CHROMA = 1.0  # pixels over which the colour of stains is seen
_BROWN = 0.75  # of the ink's density in red over that in blue: less is brown
_SEAL = 0.75  # of the way from the density in red to that in blue, where that in green lies
_CODE, _WARMER = 1.0 / 2.2, 0.0  # power from light to codes; of these, red over blue on a stain
_LEAST_BROWN = 75.0  # per cent of what is dark are browner than the ink
_DARKEST, _BRIGHTEST = 4e-3, 1.25  # fractions of the paper's light


@dataclass(frozen=True, eq=False)
class Inks:
    """Ink of a sheet, and what else lies on it.

    Attributes
    ----------
    black, red : (H, W) float32
        Optical densities of the ink and of seals.
    """

    black: NDArray[np.float32]
    red: NDArray[np.float32]


def unmix_inks(reflected: NDArray[np.float32]) -> Inks:
    """Separate black ink from red.

    Parameters
    ----------
    reflected : (H, W, 3) float32
        As a fraction of the paper's light.
    """
    density = -np.log10(np.clip(reflected, _DARKEST, _BRIGHTEST))
    red_direction = _red_of(density)
    # what a point of the plane of both directions is made of; off its wedge, of the nearer side
    directions = np.stack([_BLACK, red_direction])
    inverse = np.linalg.pinv(directions).astype(np.float32)
    black, red = density @ inverse[:, 0], density @ inverse[:, 1]
    alone_black = np.maximum(density @ _BLACK.astype(np.float32), 0.0)
    alone_red = np.maximum(density @ red_direction.astype(np.float32), 0.0)
    black, red = (
        np.where(red < 0.0, alone_black, np.where(black < 0.0, 0.0, black)),
        np.where(black < 0.0, alone_red, np.where(red < 0.0, 0.0, red)),
    )
    scale = np.float32(1.0 / np.sqrt(3.0))
    return Inks((black * scale).astype(np.float32), (red * scale).astype(np.float32))


def drop_brown(
    reflected: NDArray[np.float32], sheet: NDArray[np.float32]
) -> tuple[NDArray[np.float32], int]:
    """Take foxing and tide lines off a sheet by their colour: its light without, and how many.

    They take more of blue light than of red, more than the ink does, and of green about halfway,
    where a seal takes as much of green as of blue. What is ink on them stays. Of a grey picture,
    or where the ink itself is as brown, nothing is taken off; nor is a narrow stroke that has the
    warm paper's colour, which compressed pictures smear: a stain has more of it.

    Parameters
    ----------
    reflected : (H, W, 3) float32
        As a fraction of the paper's light.
    sheet : (H, W, 3) float32
        Linear light.
    """
    from scipy.ndimage import binary_dilation, binary_opening, gaussian_filter, label

    density = -np.log10(np.clip(reflected, _DARKEST, _BRIGHTEST))
    smooth = gaussian_filter(density, (_CHROMA, _CHROMA, 0))
    red, green, blue = np.moveaxis(smooth, 2, 0)
    dark = smooth.mean(axis=2)
    seen = (dark > _FAINTEST) & (blue > _FAINTEST)
    if not seen.any():
        return reflected, 0
    darkest = seen & (dark >= np.median(dark[seen]))
    ink = float(np.percentile(red[darkest] / blue[darkest], _LEAST_BROWN))
    brown = seen & (red < _BROWN * ink * blue) & (green - red < _SEAL * (blue - red))
    codes, bare = sheet**_CODE, (sheet / reflected) ** _CODE
    warmer = gaussian_filter((codes - bare)[..., 0] - (codes - bare)[..., 2], _CHROMA)
    brown &= warmer > _WARMER
    brown = binary_opening(brown, np.ones((3, 3)))  # a lens fringes edges with colour
    if brown.mean() < _FEW:
        return reflected, 0
    hue = np.array([*np.median(smooth[brown][:, :2] / blue[brown][:, None], axis=0), 1.0])
    stain = np.clip((ink * blue - red) / (ink - hue[0]), 0.0, blue)
    stain[~binary_dilation(brown, iterations=2)] = 0.0
    clean = density - stain[..., None] * hue
    return (10.0**-clean).astype(np.float32), int(label(brown, np.ones((3, 3)))[1])


def _red_of(density: AnyArray) -> NDArray[np.float64]:
    """The direction (3,) of the sheet's red, of length 1."""
    every = density[::2, ::2].reshape(-1, 3)
    other = np.minimum(every[:, 1], every[:, 2])
    coloured = every[(other - every[:, 0] > _COLOURED) & (every[:, 0] < _MOST_RED * other)]
    if len(coloured) < max(20.0, _FEW * len(every)):
        coloured = _CINNABAR[None]
    purest = coloured[:, 0] / np.minimum(coloured[:, 1], coloured[:, 2])
    mean = np.maximum(coloured[purest <= np.median(purest)].mean(axis=0), 0.0)
    result: NDArray[np.float64] = mean / np.linalg.norm(mean)
    return result


def invert_rubbing(sheet: NDArray[np.float32]) -> Inks:
    """The white strokes of a rubbing as if they were ink: how far a pixel is from its black ground.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.
    """
    from scipy.ndimage import gaussian_filter, percentile_filter, zoom

    grey = np.sqrt(np.clip(sheet.mean(axis=2), 0.0, 1.0))
    step = max(1, round(max(grey.shape) / 150))
    small = grey[::step, ::step]
    window = max(3, round(0.15 * max(small.shape)))
    dark = (small < otsu(small)).astype(np.float64)  # a wide stroke is no ground, if all is white
    reach = 0.5 * window
    weight = gaussian_filter(dark, reach)
    least = float(np.average(small, weights=np.maximum(dark, 1e-9)))
    means = (gaussian_filter(dark * small, reach) + 1e-3 * least) / (weight + 1e-3)
    levels = []
    for level in (means, percentile_filter(small, 98.0, size=window)):
        factor = np.array(grey.shape) / level.shape
        levels.append(zoom(level, factor, order=1, grid_mode=True, mode="nearest"))
    ground, white = levels
    white = np.maximum(white, ground + 0.35 * float(np.ptp(np.percentile(small, (5.0, 99.5)))))
    whiteness = np.clip((grey - ground) / np.maximum(white - ground, 1e-3), 0.0, 1.2)
    return Inks(whiteness.astype(np.float32), np.zeros_like(whiteness, np.float32))

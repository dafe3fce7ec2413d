"""The strokes' bodies: as far as the brush went, with what it left bare between its hairs.

Where ink lies in streaks the brush ran dry. A hair that let go and took hold again went over what
is bare between, so gaps are closed along the streaks as well as across them; wet strokes end where
their ink does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["bodies_in", "without_specks"]

_NOTCH = 0.25  # half widths: notches of a rough edge, up to twice as wide, are a wet stroke's, too
_GAP = 0.5  # the same of bare streaks, of a stroke that has streaks
_DRY_GAP = 1.0  # the same where there are many
_STREAK = 0.16  # of a width: half of a streak's
_MANY, _MANY_NEAR = 0.16, 0.45  # share of a place that streaks cover; widths around it
_SOME, _ANY, _SOME_NEAR = 0.03, 0.003, 0.8  # the same of a few, and of one
_FAINT = 0.02  # the same: there faint ink is a stroke's, too
_ALONG = 2.0  # widths: bare bits of a hair's way up to so long belong to the stroke
_BESIDE = 0.8  # widths from ink that such a way lies at the most
_GRAIN, _TURN = 0.06, 0.4  # widths over which edges are seen, and the way of the streaks
_HOLE = 0.3  # squares of a width: smaller holes belong to the stroke
_NARROW = 0.4  # widths: half of that of a hole among streaks that does, too
_BIT = 0.5  # squares of a width: what is smaller is no stroke


def bodies_in(mask: NDArray[np.bool_], faint: NDArray[np.bool_], width: float) -> NDArray[np.bool_]:
    """Strokes with the bare streaks within them; counters stay open.

    Parameters
    ----------
    mask, faint : (H, W) bool
        Where ink is, and where at least a little is.
    width : float
        Of a usual stroke, pixels.
    """
    streaks = _streaks(mask, width)
    near = _spread(streaks, _SOME_NEAR * width)
    inked = mask | (faint & (near > _FAINT))
    inked |= _between(inked, near > _SOME, width)
    closed = inked | _closed(inked, _NOTCH * 0.5 * width)
    closed |= _closed(inked, _GAP * 0.5 * width) & (near > _ANY)
    many = _spread(streaks, _MANY_NEAR * width) > _MANY
    closed |= _closed(inked, _DRY_GAP * 0.5 * width) & many
    closed |= _small_holes(closed, near > _ANY, width)
    return without_specks(closed, _BIT * width**2)


def without_specks(mask: AnyArray, least: float) -> NDArray[np.bool_]:
    """A mask without connected bits of fewer pixels."""
    from scipy.ndimage import label

    areas, _ = label(mask, np.ones((3, 3)))
    sizes = np.bincount(areas.ravel())
    sizes[0] = 0
    result: NDArray[np.bool_] = (sizes >= least)[areas]
    return result


def _closed(mask: AnyArray, reach: float) -> NDArray[np.bool_]:
    """A mask with gaps filled that are narrower than twice a reach, pixels."""
    from scipy.ndimage import distance_transform_edt

    grown = np.pad(distance_transform_edt(~mask) <= reach, 1)
    result: NDArray[np.bool_] = distance_transform_edt(grown)[1:-1, 1:-1] > reach
    return result


def _small_holes(closed: AnyArray, streaky: AnyArray, width: float) -> NDArray[np.bool_]:
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


def _streaks(mask: AnyArray, width: float) -> NDArray[np.bool_]:
    """Ink that is much narrower than a stroke."""
    from scipy.ndimage import distance_transform_edt

    thin = _STREAK * width
    core = distance_transform_edt(mask) > thin
    result: NDArray[np.bool_] = mask & (distance_transform_edt(~core) > thin + 1.5)
    return result


def _spread(streaks: AnyArray, reach: float) -> NDArray[np.float32]:
    """What share of the places around each are streaks."""
    from scipy.ndimage import gaussian_filter

    result: NDArray[np.float32] = gaussian_filter(streaks.astype(np.float32), reach)
    return result


def _between(inked: AnyArray, where: AnyArray, width: float) -> NDArray[np.bool_]:
    """Bare places that have ink before and behind them on the way of the hairs."""
    from scipy.ndimage import distance_transform_edt

    found = np.zeros(inked.shape, bool)
    bare = ~inked & where
    bare &= distance_transform_edt(~inked) <= _BESIDE * width
    places = np.argwhere(bare)
    if not len(places):
        return found
    way = _ways(inked, width)
    longest = int(_ALONG * width)
    ahead = _pixels_to_ink(inked, places, way, longest)
    behind = _pixels_to_ink(inked, places, -way, longest)
    rows, columns = places[ahead + behind <= longest].T
    found[rows, columns] = True
    return found


def _ways(inked: AnyArray, width: float) -> NDArray[np.float32]:
    """The way of the streaks, or of edges, around each place: (H, W, 2) unit vectors, either way.

    It is across the main axis of the structure tensor (Bigun and Granlund 1987).
    """
    from scipy.ndimage import gaussian_filter

    down, right = np.gradient(gaussian_filter(inked.astype(np.float32), max(1.0, _GRAIN * width)))
    reach = _TURN * width
    dd, rr, dr = (gaussian_filter(a, reach) for a in (down * down, right * right, down * right))
    along = 0.5 * np.arctan2(2.0 * dr, rr - dd) + 0.5 * np.pi
    return np.stack([np.sin(along), np.cos(along)], axis=-1).astype(np.float32)


def _pixels_to_ink(
    inked: AnyArray, places: AnyArray, way: AnyArray, longest: int
) -> NDArray[np.float64]:
    """How far (N,) the ways from places (N, 2) lead before ink; infinite where there is none."""
    last = np.array(inked.shape) - 1
    far = np.full(len(places), np.inf)
    at, cell = places.astype(np.float64), places
    heading = way[cell[:, 0], cell[:, 1]]
    for step in range(1, longest + 1):
        at = at + heading
        cell = np.clip(np.rint(at).astype(int), 0, last)
        reached = inked[cell[:, 0], cell[:, 1]]
        far[reached] = np.minimum(far[reached], step)
        there = way[cell[:, 0], cell[:, 1]]
        turned = (there * heading).sum(axis=1, keepdims=True) < 0.0
        heading = np.where(turned, -there, there)
    return far

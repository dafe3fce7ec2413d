"""Colour reduction for printers with a few filaments: one of k colours for every triangle.

The colours of a painting are gathered into clusters in CIE L*a*b*, every colour weighted by the
area that shows it (k-means from the colours farthest apart, so that a little cinnabar is not lost
on much porcelain), or are given. A colour gets the one that is nearest (CIEDE2000), or the larger
part of two, as at an edge. Triangles between two filaments are as small as the painting's; where
one filament covers many, they are joined.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.difference import delta_e, lab_from_linear_rgb, lab_from_srgb
from paint3d.colour.spectra import decode_srgb, srgb_from_linear
from paint3d.core.arrays import AnyArray

__all__ = ["Filaments", "choose_filaments", "choose_for_triangles", "split_by_filament"]

ROUNDS = 50
# In L*a*b*: how much nearer a mixture of two has to be than one filament alone, and how far from it
# the nearest filament lies that is none of its kind. Of more than so many the nearest is taken.
_ALONE, _ASIDE, _MOST_MIXED = 2.0, 8.0, 16
NEGLIGIBLE = 1e-4  # fraction of the area below which a colour cannot start a cluster


class Filaments(NamedTuple):
    """Filament colours, and the index of the one for each colour."""

    palette: NDArray[np.uint8]  # (k, 3) sRGB, the one that covers most first
    chosen: NDArray[np.int32]  # (V,) index into the palette


def choose_filaments(
    srgb: NDArray[np.uint8], areas: NDArray[np.float64], wanted: int | Sequence[str]
) -> Filaments:
    """Choose filaments for a painting, and one of them for every vertex.

    Parameters
    ----------
    srgb : (V, 3) uint8
    areas : (V,)
        What each vertex stands for.
    wanted : int or sequence of str
        How many filaments (fewer come back where there are fewer colours), or their sRGB as hex.

    Returns
    -------
    Filaments
    """
    packed = srgb.astype(np.int64) @ np.array([65536, 256, 1])
    colours, index = np.unique(packed, return_inverse=True)
    codes = (colours[:, None] >> np.array([16, 8, 0]) & 255).astype(np.uint8)
    weights = np.bincount(index, weights=areas, minlength=len(codes))
    if isinstance(wanted, int):
        palette = _cluster(codes, weights, wanted)
    else:
        rgb = [bytes.fromhex(colour.lstrip("#")) for colour in wanted]
        palette = np.frombuffer(b"".join(rgb), np.uint8).reshape(-1, 3)
    nearest = _choose_shown(codes, palette)
    cover = np.bincount(nearest, weights=weights, minlength=len(palette))
    order = np.argsort(-cover, kind="stable") if isinstance(wanted, int) else np.arange(len(cover))
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return Filaments(palette[order], rank[nearest][index])


def _cluster(codes: NDArray[np.uint8], weights: AnyArray, k: int) -> NDArray[np.uint8]:
    """Return at most k different colours (k, 3) that stand for all of them."""
    lab, linear = lab_from_srgb(codes), decode_srgb(codes)
    starts = np.flatnonzero(weights >= NEGLIGIBLE * weights.sum())
    centres = lab[[int(np.argmax(weights))]]
    while len(centres) < k:
        gap = np.min([np.linalg.norm(lab[starts] - c, axis=1) for c in centres], axis=0)
        if len(starts) == 0 or gap.max() == 0.0:
            break
        centres = np.vstack([centres, lab[starts[np.argmax(gap)]]])
    belongs = np.full(len(lab), -1)
    for _ in range(ROUNDS):
        gaps = np.stack([np.linalg.norm(lab - c, axis=1) for c in centres], axis=1)
        now = gaps.argmin(axis=1)
        if (now == belongs).all():
            break
        belongs = now
        mean = _means(linear, weights, belongs, len(centres))
        centres = np.where(np.isfinite(mean), lab_from_linear_rgb(np.nan_to_num(mean)), centres)
    mean = _means(linear, weights, belongs, len(centres))
    return np.unique(srgb_from_linear(mean[np.isfinite(mean).all(axis=1)]), axis=0)


def _means(linear: AnyArray, weights: AnyArray, belongs: AnyArray, k: int) -> AnyArray:
    """Mean light (k, 3) of every cluster; nan where it is empty."""
    total = np.bincount(belongs, weights=weights, minlength=k)
    sums = [np.bincount(belongs, weights=weights * band, minlength=k) for band in linear.T]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.stack(sums, axis=1) / total[:, None]


def _nearest(codes: NDArray[np.uint8], palette: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Index into the palette (n,) of the perceptually nearest colour."""
    lab, filaments = lab_from_srgb(codes), lab_from_srgb(palette)
    gaps = [delta_e(lab, filament[None]) for filament in filaments]
    result: NDArray[np.int32] = np.argmin(gaps, axis=0).astype(np.int32)
    return result


def _choose_shown(codes: NDArray[np.uint8], palette: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Index into the palette (n,) of the filament that each colour shows, or shows most of.

    At an edge a vertex shows two of them: black over white is grey there, which looks like teal
    before it looks like either. So a colour is one filament or a mixture of two, as light, whatever
    is nearest to it; of a mixture it gets the one that it has more of. A grey that lies between
    black and white is one of its own.
    """
    nearest = _nearest(codes, palette)
    if len(palette) > _MOST_MIXED:
        return nearest
    lab, known = lab_from_srgb(codes), lab_from_srgb(palette)
    linear, filaments = decode_srgb(codes), decode_srgb(palette)
    best, gap = nearest, np.linalg.norm(lab - known[nearest], axis=1) - _ALONE
    for a, b in combinations(range(len(palette)), 2):
        fraction, apart = _nearest_mixture(linear, lab, filaments[a], filaments[b])
        aside = _nearest_mixture(filaments, known, filaments[a], filaments[b])[1] > _ASIDE
        aside[[a, b]] = True
        nearer = aside[nearest] & (apart < gap)
        gap = np.where(nearer, apart, gap)
        best = np.where(nearer, np.where(fraction > 0.5, b, a), best).astype(np.int32)
    return best


def _nearest_mixture(
    linear: AnyArray, lab: AnyArray, a: AnyArray, b: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """Fraction of b in the mixture of a and b that is nearest as light, and its distance in Lab.

    Of n colours, (n, 3); a and b are linear.
    """
    direction = b - a
    fraction = np.clip(
        (linear - a) @ direction / max(float(direction @ direction), 1e-12), 0.0, 1.0
    )
    gap: AnyArray = np.linalg.norm(
        lab - lab_from_linear_rgb(a + fraction[:, None] * direction), axis=1
    )
    return fraction, gap


def choose_for_triangles(
    faces: NDArray[np.int32], chosen: NDArray[np.int32], palette: NDArray[np.uint8]
) -> NDArray[np.int32]:
    """Return each triangle's filament (F,): what two corners have, or nearest to the mean."""
    a, b, c = chosen[faces].T
    out = np.where(b == c, b, a)
    differ = np.flatnonzero((a != b) & (b != c) & (c != a))
    if len(differ):
        light = decode_srgb(palette)[chosen[faces[differ]]].mean(axis=1)
        out[differ] = _nearest(srgb_from_linear(light), palette)
    result: NDArray[np.int32] = out.astype(np.int32)
    return result


def split_by_filament(
    faces: NDArray[np.int32], face_filaments: NDArray[np.int32], n_filaments: int
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int32]]:
    """Give every vertex a copy for each filament around it, so that a triangle has one colour.

    Returns
    -------
    vertex_ids : (K,)
        The vertex that each new one is a copy of, in their order.
    faces : (F, 3) int32
        Triangles of the new vertices.
    filaments : (K,) int32
    """
    keys = faces.astype(np.int64) * n_filaments + face_filaments[:, None]
    unique, index = np.unique(keys, return_inverse=True)
    return (
        unique // n_filaments,
        index.reshape(-1, 3).astype(np.int32),
        (unique % n_filaments).astype(np.int32),
    )

"""Wet paint over what each vertex itself has below: dried layers, or the colours of a mesh.

The formula is that of `colour.kernels.kubelka_munk`, with a backing of its own for every vertex and
band. A vertex's ground is, in this order: the spectrum of its dried layers, the spectrum of the
colour that its mesh came with (`docs/ink.md`), the material. Single precision in blocks of
vertices, elementwise, so a vertex gets the same bits whatever its place in the list.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.kernels.kubelka_munk import BLOCK, fill_layers, mix_paints, shine
from paint3d.core.kernel import kernel

__all__ = [
    "GROUNDS",
    "SPECTRUM_STEPS",
    "Glaze",
    "Ground",
    "add_between",
    "dry_vertices",
    "glazed_colours",
    "see_through",
]

SPECTRUM_STEPS = 65535
"""Steps of a reflectance from 0 to 1 as it is kept: 8e-6 is a hundredth of an sRGB code."""


class Ground(NamedTuple):
    """Ground below the wet paint (cap: capacity for vertices, D: dried vertices)."""

    slots: NDArray  # (cap,) int32, row of each vertex in `spectra`, -1 for none; or (0,)
    spectra: NDArray  # (D, 31) uint16, reflectance as measured, in steps of 1/65535
    linear_rgb: NDArray  # (cap, 3) float32, colour that the mesh came with; or (0, 3)
    primaries: NDArray  # (31, 3) float32, spectra of red, green and blue
    material: NDArray  # (31,) float32


class Glaze(NamedTuple):
    """Appearance of mixtures of P pigments over any ground, from W bands."""

    paints: NDArray[np.float32]  # (W, P, 2), K and S of each pigment per coat
    weights: NDArray[np.float32]  # (W, 3), of each band in R, G, B
    saunderson: NDArray[np.float32]  # (2,), k1 and k2 of a glossy film
    films: NDArray[np.float32]  # (P, 2), 1 where a pigment leaves a film, 1 where that is glossy


@kernel(error_model="numpy")
def _fill_ground(ids, start, size, ground, backing):
    """Reflectance as measured (W, BLOCK) of what lies below a block of vertices."""
    n_bands = backing.shape[0]
    scale = np.float32(1.0 / SPECTRUM_STEPS)
    rows = ground.slots.shape[0] > 0
    coloured = ground.linear_rgb.shape[0] > 0
    for j in range(size):
        v = ids[start + j]
        row = ground.slots[v] if rows else -1
        if row >= 0:
            for w in range(n_bands):
                backing[w, j] = scale * np.float32(ground.spectra[row, w])
        elif coloured:
            red, green, blue = ground.linear_rgb[v]
            for w in range(n_bands):
                parts = ground.primaries[w]
                backing[w, j] = red * parts[0] + green * parts[1] + blue * parts[2]
        else:
            for w in range(n_bands):
                backing[w, j] = ground.material[w]
    for w in range(n_bands):
        backing[w, size:] = np.float32(0.0)


@kernel(error_model="numpy")
def _weigh_gloss(glaze, layer, outer, inner):
    """k1 and k2 (BLOCK,) of each vertex's film: as much of them as it holds of glossy paint."""
    zero = np.float32(0.0)
    most_outer, most_inner = glaze.saunderson[0], glaze.saunderson[1]
    outer[:] = zero
    inner[:] = zero
    for i in range(layer.shape[0]):
        film, glossy = glaze.films[i, 0], glaze.films[i, 1]
        for j in range(BLOCK):
            outer[j] += film * layer[i, j]
            inner[j] += glossy * layer[i, j]
    for j in range(BLOCK):
        fraction = inner[j] / outer[j] if inner[j] > zero else zero
        outer[j] = most_outer * fraction
        inner[j] = most_inner * fraction


@kernel(error_model="numpy")
def _shine_block(wet, start, size, glaze, ground, layer, work, seen):
    """Reflectance as measured (W, BLOCK) of a block: covered and bare light mixed by area."""
    paints = glaze.paints
    one, zero = np.float32(1.0), np.float32(0.0)
    black, white, cover, outer, inner = work[0], work[1], work[2], work[3], work[4]
    _fill_ground(wet.vertex_ids, start, size, ground, seen)
    cover[:] = zero
    fill_layers(wet, start, size, layer, cover)
    _weigh_gloss(glaze, layer, outer, inner)
    for w in range(paints.shape[0]):
        mix_paints(paints[w], layer, black, white)
        for j in range(BLOCK):
            bare = seen[w, j]
            passed = (one - outer[j]) * (one - inner[j])
            below = bare - outer[j]
            below = max(below, zero) / (passed + inner[j] * below)
            top, bottom = shine(black[j], white[j], below)
            painted = outer[j] + passed * top / (bottom - inner[j] * top)
            seen[w, j] = bare + cover[j] * (painted - bare)


@kernel(error_model="numpy")
def glazed_colours(wet, glaze, ground, shown):
    """Colour of vertices with wet paint over grounds of their own.

    Cost: 120 ns a vertex at P = 3, with 31 bands.

    Parameters
    ----------
    wet : Wet
    glaze : Glaze
    ground : Ground
        What lies below (`colour.glazing`).
    shown : Shown
        Only the rows named by `wet.vertex_ids` are written.
    """
    vertex_ids, paints, weights = wet.vertex_ids, glaze.paints, glaze.weights
    codes, out_rgb, out_srgb = shown.codes, shown.linear_rgb, shown.srgb
    n_paints, n_bands = paints.shape[1], paints.shape[0]
    layer = np.zeros((n_paints, BLOCK), np.float32)
    work = np.empty((5, BLOCK), np.float32)
    seen = np.empty((n_bands, BLOCK), np.float32)
    scale = np.float32(codes.size - 1)
    half, zero, one = np.float32(0.5), np.float32(0.0), np.float32(1.0)
    for start in range(0, vertex_ids.size, BLOCK):
        size = min(BLOCK, vertex_ids.size - start)
        _shine_block(wet, start, size, glaze, ground, layer, work, seen)
        for h in range(3):
            rgb = work[h]
            rgb[:] = zero
            for w in range(n_bands):
                part = weights[w, h]
                for j in range(BLOCK):
                    rgb[j] += part * seen[w, j]
            for j in range(size):
                v = vertex_ids[start + j]
                if out_rgb.size:
                    out_rgb[v, h] = rgb[j]
                value = rgb[j] if rgb[j] > zero else zero  # what is no number, too
                value = min(value, one)
                out_srgb[v, h] = codes[np.int32(value * scale + half)]


@kernel(error_model="numpy")
def dry_vertices(wet, glaze, ground, rows):
    """Make what vertices look like now, under all bands, the ground of what comes next.

    Arguments as in `glazed_colours`; `rows` (N,) i32 are the rows of `ground.spectra` to fill,
    which may be those that the vertices' grounds are read from.
    """
    vertex_ids, paints = wet.vertex_ids, glaze.paints
    n_paints, n_bands = paints.shape[1], paints.shape[0]
    layer = np.zeros((n_paints, BLOCK), np.float32)
    work = np.empty((5, BLOCK), np.float32)
    seen = np.empty((n_bands, BLOCK), np.float32)
    steps, half = np.float32(SPECTRUM_STEPS), np.float32(0.5)
    zero, one = np.float32(0.0), np.float32(1.0)
    for start in range(0, vertex_ids.size, BLOCK):
        size = min(BLOCK, vertex_ids.size - start)
        _shine_block(wet, start, size, glaze, ground, layer, work, seen)
        for j in range(size):
            row = ground.spectra[rows[start + j]]
            for w in range(n_bands):
                row[w] = np.uint16(min(max(seen[w, j], zero), one) * steps + half)


@kernel
def add_between(parents, first, last, encoded):
    """sRGB (0 to 1, encoded) of vertices first..last-1: halfway between those of their parents."""
    half = np.float32(0.5)
    for v in range(first, last):
        for h in range(3):
            encoded[v, h] = half * (encoded[parents[v, 0], h] + encoded[parents[v, 1], h])


# ---- Over another ground -------------------------------------------------------------------------
# What a layer shows over another ground than the one it dried on.
#
# Kubelka and Munk's layer is a Moebius function of the reflectance below it, and so is any pile of
# them with the gloss between; three points of it are the whole of it. Where paint covers only a
# part of a vertex it is that with a fraction of the ground itself, which the same three points
# describe nearly (docs/studio-model.md). The points are not at 0: gloss alone reflects 3 %.


GROUNDS = (0.04, 0.52, 1.0)
"""Reflectances of the grey grounds over which a dried row says what it shows; evenly spaced."""

_LEAST, _MOST = 1e-3, 0.6  # of the rise in the first half; 1/2 for a layer without scattering


@kernel(error_model="numpy")
def see_through(places, rows, low, middle, high, spectra):
    """Lay dried rows over the spectra below them.

    Parameters
    ----------
    places : (N,) i32
        Rows of `spectra`: what is below, and then what shows.
    rows : (N,) i32
        Rows of the next three.
    low, middle, high : (D, 31) u16
        Reflectance shown over `GROUNDS`, in steps of 1/65535.
    spectra : (M, 31) u16
    """
    n_bands = spectra.shape[1]
    scale = 1.0 / SPECTRUM_STEPS
    span = 1.0 / (GROUNDS[2] - GROUNDS[0])
    for j in range(places.size):
        shown = spectra[places[j]]
        row = rows[j]
        for w in range(n_bands):
            dark = np.float64(low[row, w])
            rise = np.float64(high[row, w]) - dark
            value = dark
            if rise > 0.0:
                first = (np.float64(middle[row, w]) - dark) / rise
                first = min(max(first, _LEAST), _MOST)
                bend = (2.0 * first - 1.0) / (1.0 - first)
                t = (np.float64(shown[w]) * scale - GROUNDS[0]) * span
                value += rise * (1.0 + bend) * t / (1.0 + bend * t)
            shown[w] = np.uint16(min(max(value, 0.0), 65535.0) + 0.5)

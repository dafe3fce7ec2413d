"""Light in layers of paint (Kubelka-Munk), per wavelength and per vertex.

`layer_bands` is the formula itself in double precision. The vertex kernels work in single
precision on blocks of vertices, band by band, so that the inner loops run in SIMD lanes. They
are elementwise and always run whole blocks (the last one is padded): a vertex gets the same
bits whatever its place in the list, the order or the number of threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = [
    "BLOCK",
    "TANH_RATIO",
    "Film",
    "OneInk",
    "Shown",
    "Wet",
    "fill_layers",
    "layer_bands",
    "mix_paints",
    "mixture_colours",
    "shine",
    "single_colours",
]

BLOCK = 128
"""Vertices in one block of the mixture kernel; its work arrays fit the first cache."""

LAST_RATIO = np.float32(36.0)
"""(pX)^2 up to which tanh(pX)/(pX) is the ratio of polynomials; beyond, 1/(pX) (off by 1.2e-5)."""

THICKEST = np.float32(1e4)
"""Coats beyond which a layer counts as this thick: keeps single precision from overflowing."""

TANH_RATIO = (
    (1.0, 0.114983672, 0.00152284374),
    (1.0, 0.448282707, 0.0176645049, 5.67470234e-05),
)
"""tanh(sqrt u)/sqrt u = P(u)/Q(u) for 0 <= u <= 36: coefficients of P and Q, rising powers.

A minimax fit; the relative error stays below 8e-6 (checked in the tests)."""


class Wet(NamedTuple):
    """The wet paint of P pigments on a surface of V vertices, and the N of them to colour."""

    vertex_ids: NDArray[np.int32]  # (N,)
    amounts: NDArray[np.float32]  # (V, P), coats times covered fraction, >= 0
    coverage: NDArray[np.float32]  # (V,), covered fraction in [0, 1]; 0 is bare


class Film(NamedTuple):
    """Appearance of mixtures of P matt pigments on one backing, from W bands."""

    paints: NDArray[np.float32]  # (W, P, 2), K and S of each pigment per coat
    bands: NDArray[np.float32]  # (W, 4), reflectance below; weights in R, G, B
    bare: NDArray[np.float32]  # (1, 3), linear RGB of the bare surface


class OneInk(NamedTuple):
    """Appearance of one pigment on one backing, by y = X / (X + bend) of X coats."""

    table: NDArray[np.float32]  # (N, 3), linear RGB at y = i/(N - 1)
    shades: NDArray[np.uint8]  # (M, 3), its codes, as finely as codes can differ
    bend: np.float32  # coats
    bare: NDArray[np.float32]  # (1, 3), linear RGB of the bare surface


class Shown(NamedTuple):
    """Arrays that receive colours, and how they are encoded."""

    codes: NDArray[np.uint8]  # (T,), sRGB of linear i/(T - 1); others take the nearest end
    linear_rgb: NDArray[np.float32]  # (V, 3); length 0 to skip
    srgb: NDArray[np.uint8]  # (V, 3)


@kernel(error_model="numpy")
def layer_bands(absorption, scattering, thickness, backing, reflected, alone, through):
    """Light reflected and let through by one layer at each of W wavelengths.

    MODEL: p = sqrt(K (K + 2 S)), q = tanh(p X)/p, which is X where p vanishes;
    R = (Rg + q (S (1 - Rg) - K Rg)) / (1 + q (K + S (1 - Rg))),
    R0 = q S / (1 + q (K + S)), T = sech(p X) / (1 + q (K + S)) (docs/model.md, equations (14) and
    (15); Kubelka 1948 in a form without division by K or S). Right at every limit; 8 ns a
    wavelength.

    Parameters
    ----------
    absorption, scattering, thickness, backing : (W,) f64
        K and S per coat, X in coats, all >= 0; reflectance Rg of what lies below, in [0, 1].
    reflected, alone, through : (W,) f64
        Filled with R over the backing, R0 over black, and the transmittance T.
    """
    for w in range(absorption.size):
        k, s, x, ground = absorption[w], scattering[w], thickness[w], backing[w]
        p = math.sqrt(k) * math.sqrt(k + 2.0 * s)
        z = p * x
        decay = math.exp(-z)
        if z < 1e-4:
            q = x * (1.0 - z * z / 3.0)
        else:
            q = -math.expm1(-2.0 * z) / ((1.0 + decay * decay) * p)
        bottom = 1.0 + q * (k + s)
        rise = q * s * (1.0 - ground)
        reflected[w] = (ground - q * k * ground + rise) / (1.0 + q * k + rise)
        alone[w] = q * s / bottom
        through[w] = 2.0 * decay / ((1.0 + decay * decay) * bottom)


@kernel(error_model="numpy")
def fill_layers(wet, start, size, layer, cover):
    """Coats (P, BLOCK) of each pigment where a block is covered, and the fraction that is."""
    zero, one = np.float32(0.0), np.float32(1.0)
    for j in range(size):
        v = wet.vertex_ids[start + j]
        c = wet.coverage[v]
        cover[j] = c
        thick = one / c if c > 0 else zero
        for i in range(layer.shape[0]):
            layer[i, j] = min(wet.amounts[v, i] * thick, THICKEST)


@kernel(error_model="numpy", inline="always")
def mix_paints(paints, layer, black, white):
    """K X and S X (BLOCK,) of the pigments' coats together; `paints` (P, 2) is one band's.

    docs/model.md, equation (16).
    """
    black[:] = np.float32(0.0)
    white[:] = np.float32(0.0)
    for i in range(paints.shape[0]):
        k, s = paints[i, 0], paints[i, 1]
        for j in range(BLOCK):
            black[j] += k * layer[i, j]
            white[j] += s * layer[i, j]


@kernel(error_model="numpy", inline="always")
def shine(k, s, ground):
    """Numerator and denominator of the reflectance R of a layer with K X = k and S X = s.

    docs/model.md, equation (14), both times Q of `TANH_RATIO`, or p X beyond it.
    """
    one = np.float32(1.0)
    p1, p2 = np.float32(TANH_RATIO[0][1]), np.float32(TANH_RATIO[0][2])
    q1, q2 = np.float32(TANH_RATIO[1][1]), np.float32(TANH_RATIO[1][2])
    q3 = np.float32(TANH_RATIO[1][3])
    u = k * (k + s + s)
    deep = u > LAST_RATIO
    p = one if deep else one + u * (p1 + u * p2)
    q = np.sqrt(u) if deep else one + u * (q1 + u * (q2 + u * q3))
    scattered = p * s * (one - ground)
    return (q - p * k) * ground + scattered, q + p * k + scattered


@kernel(error_model="numpy")
def mixture_colours(wet, film, shown):
    """Colour of vertices with any mixture of P pigments, from W bands.

    With X_i = amount_i / coverage the wet paint of a vertex is one layer with K X = sum K_i X_i
    and S X = sum S_i X_i (docs/model.md, equation (16)); its linear RGB is mixed by area with the
    bare surface: (1 - c) bare + c layer (equation (17)). Cost: 1.6 ns a band and vertex at P = 3.

    Parameters
    ----------
    wet : Wet
    film : Film
    shown : Shown
        Only the rows named by `wet.vertex_ids` are written.
    """
    paints, bands = film.paints, film.bands
    n_paints, n_bands = paints.shape[1], paints.shape[0]
    layer = np.zeros((n_paints, BLOCK), np.float32)
    black, white = np.empty(BLOCK, np.float32), np.empty(BLOCK, np.float32)
    rgb = np.empty((3, BLOCK), np.float32)
    cover = np.zeros(BLOCK, np.float32)
    for start in range(0, wet.vertex_ids.size, BLOCK):
        size = min(BLOCK, wet.vertex_ids.size - start)
        fill_layers(wet, start, size, layer, cover)
        rgb[:] = np.float32(0.0)
        for w in range(n_bands):
            ground, red, green, blue = bands[w, 0], bands[w, 1], bands[w, 2], bands[w, 3]
            mix_paints(paints[w], layer, black, white)
            for j in range(BLOCK):
                top, bottom = shine(black[j], white[j], ground)
                r = top / bottom
                rgb[0, j] += red * r
                rgb[1, j] += green * r
                rgb[2, j] += blue * r
        _write_block(wet.vertex_ids[start : start + size], cover, rgb, film.bare, shown)


@kernel(error_model="numpy")
def _write_block(vertex_ids, cover, rgb, bare, shown):
    """Mix the colours of a block with the bare surface and write them where they belong."""
    codes, out_rgb, out_srgb = shown.codes, shown.linear_rgb, shown.srgb
    scale = np.float32(codes.size - 1)
    half, zero, one = np.float32(0.5), np.float32(0.0), np.float32(1.0)
    for j in range(vertex_ids.size):
        v, c = vertex_ids[j], cover[j]
        for h in range(3):
            value = (one - c) * bare[0, h] + c * rgb[h, j]
            if out_rgb.size:
                out_rgb[v, h] = value
            seen = value if value > zero else zero
            seen = seen if seen < one else one
            out_srgb[v, h] = codes[np.int32(seen * scale + half)]


@kernel(error_model="numpy")
def single_colours(wet, ink, shown):
    """Colour of vertices with one pigment, from a table over the layer's thickness.

    The table's axis is y = X / (X + bend), which maps 0 to infinity onto 0 to 1 and is fine where
    thin paint changes fast; with X = amount/coverage it needs one division. Where paint covers the
    whole vertex, which is nearly everywhere, the codes are looked up in the shades.

    Parameters
    ----------
    wet : Wet
        P = 1.
    ink : OneInk
    shown : Shown
        Only the rows named by `wet.vertex_ids` are written.
    """
    vertex_ids, amounts, coverage = wet.vertex_ids, wet.amounts, wet.coverage
    table, shades, bend, bare = ink.table, ink.shades, ink.bend, ink.bare
    codes, out_rgb, out_srgb = shown.codes, shown.linear_rgb, shown.srgb
    finest = np.float32(shades.shape[0] - 1)
    last = table.shape[0] - 2
    steps = np.float32(table.shape[0] - 1)
    scale = np.float32(codes.size - 1)
    half, zero, one = np.float32(0.5), np.float32(0.0), np.float32(1.0)
    for j in range(vertex_ids.size):
        v = vertex_ids[j]
        c, a = coverage[v], amounts[v, 0]
        whole = a + bend * c
        y = a / whole if whole > zero else zero
        y = min(max(y, zero), one)
        if c >= one and out_rgb.size == 0:
            i = np.int32(y * finest + half)
            out_srgb[v, 0] = shades[i, 0]
            out_srgb[v, 1] = shades[i, 1]
            out_srgb[v, 2] = shades[i, 2]
            continue
        y *= steps
        i = min(np.int32(y), last)
        part = y - np.float32(i)
        for h in range(3):
            paint = table[i, h] + part * (table[i + 1, h] - table[i, h])
            value = (one - c) * bare[0, h] + c * paint
            if out_rgb.size:
                out_rgb[v, h] = value
            seen = value if value > zero else zero
            seen = seen if seen < one else one
            out_srgb[v, h] = codes[np.int32(seen * scale + half)]

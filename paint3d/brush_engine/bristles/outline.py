"""The outline of hairs that lie on the surface, and where the stations of their map lie in it."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine import stamp as st
from paint3d.brush_engine.bristles.bend import BLOCK, SAMPLES
from paint3d.brush_engine.bristles.contact import BEGIN, DOT, END
from paint3d.core.kernel import kernel

__all__ = [
    "BINS",
    "CELLS",
    "OUTER",
    "PER_CELL",
    "TIP",
    "draw_outline",
    "hold_outline",
    "index_stations",
]

BINS = 48  # along the imprint, for its outline
CELLS = 64  # along the imprint, for finding the station of a place
TIP, PER_CELL = 0, 1  # places in Imprint.numbers
OUTER = 96  # hairs that tell how wide the tuft is: the last ones stand at the rim, all around
_INNER = 48  # of the others, evenly chosen: the tuft's point, which those at the rim do not reach
_ENDS = 0.25  # of what is left beside hairs: so much before and behind them
_LEAST_GAP = 0.3  # of the one before it, between a station and the next
_SHORTEST = 1e-3  # mm, from the foremost to the hindmost of them
_Y = BLOCK


@kernel(error_model="numpy")
def _place_on(points, i, at):
    """Where a hair lies at a place between its points: along the bend and to the side, mm."""
    g, j = i // BLOCK, i % BLOCK
    k = min(int(at), SAMPLES - 2)
    t = np.float64(at) - k
    x = (1.0 - t) * points[g, k, j] + t * points[g, k + 1, j]
    return x, abs((1.0 - t) * points[g, k, _Y + j] + t * points[g, k + 1, _Y + j])


@kernel(error_model="numpy")
def _find_ends(points, hair_contacts, some):
    """From where to where along the bend some hairs touch, mm: (first, end, step) of them."""
    low, high = np.inf, -np.inf
    for i in range(some[0], some[1], some[2]):
        row, j = hair_contacts[i // BLOCK], i % BLOCK
        if row[END + j] < 0.0:
            continue
        for at in (row[BEGIN + j], row[END + j]):
            x, _ = _place_on(points, i, at)
            low, high = min(low, x), max(high, x)
    return low, high


@kernel(error_model="numpy")
def _draw_piece(x0, y0, x1, y1, low, per_bin, reaches):
    """Let the outline hold a straight piece of hair."""
    if x0 > x1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    begin, end = (x0 - low) * per_bin, (x1 - low) * per_bin
    rise = (y1 - y0) / (end - begin) if end > begin else 0.0
    final = min(int(end), BINS - 1)
    for b in range(max(int(begin), 0), final + 1):
        at = min(max(b + 0.5, begin), end)
        reaches[b] = max(reaches[b], y0 + (at - begin) * rise)


@kernel(error_model="numpy")
def _draw_hairs(points, hair_contacts, some, pieces, low, per_bin, reaches):
    """Let the outline hold the first pieces that touch of some hairs, with their films."""
    for i in range(some[0], some[1], some[2]):
        row, j = hair_contacts[i // BLOCK], i % BLOCK
        begin, end, dot = row[BEGIN + j], row[END + j], np.float64(row[DOT + j])
        if end < 0.0:
            continue
        x0, y0 = _place_on(points, i, begin)
        for k in range(int(begin) + 1, int(begin) + 1 + pieces):
            x1, y1 = _place_on(points, i, min(np.float32(k), end))
            _draw_piece(x0, y0 + dot, x1, y1 + dot, low, per_bin, reaches)
            if k >= end:
                break
            x0, y0 = x1, y1


@kernel(error_model="numpy")
def hold_outline(values):
    """Let the stamp's enclosing sphere hold its outline."""
    for along in (values.tip, values.heel):
        for across in (values.widest, -values.widest):
            st.hold_point(values, along, across)


@kernel(error_model="numpy")
def draw_outline(stamp, imprint, points, hair_contacts, count, margin, reach, half_width):
    """Let the stamp's outline be that of the touching hairs: what those at the tuft's rim enclose.

    Within the outline the map says what is covered.

    Parameters
    ----------
    stamp : Stamp
    imprint : Imprint
        Its `reaches` are filled.
    points, findings : arrays of `Hairs`
    count : int
        Hairs; one of them touches at least.
    margin : float
        That is left beside the hairs, mm, and a quarter of it before and behind.
    reach, half_width : arrays as for `tuft.trace_outline`
    """
    reaches = imprint.reaches
    reaches[:] = margin
    first = max(0, count - OUTER)
    rim, inner = (first, count, 1), (0, first, max(1, first // _INNER))
    low, high = _find_ends(points, hair_contacts, rim)
    low_inside, high_inside = _find_ends(points, hair_contacts, inner)
    low, high = min(low, low_inside), max(high, high_inside)
    if not low < np.inf:  # few are long enough, and none of these
        inner = (0, first, 1)
        low, high = _find_ends(points, hair_contacts, (0, count, 1))
    high = max(high, low + _SHORTEST)
    per_bin = BINS / (high - low)
    _draw_hairs(points, hair_contacts, rim, SAMPLES, low, per_bin, reaches)
    _draw_hairs(points, hair_contacts, inner, 1, low, per_bin, reaches)
    wide = (high - low) / BINS
    ends = _ENDS * margin
    n = 0
    reach[n], half_width[n] = high + ends, 0.0
    n += 1
    for b in range(BINS - 1, -1, -1):
        beside = 0.5 * (reaches[max(b - 1, 0)] + reaches[min(b + 1, BINS - 1)])
        reach[n], half_width[n] = low + (b + 0.5) * wide, max(reaches[b], beside)
        n += 1
    reach[n], half_width[n] = low - ends, 0.0
    st.fill_profile(stamp, reach, half_width, n + 1)
    hold_outline(stamp.values[0])


@kernel(error_model="numpy")
def index_stations(imprint, last, tip, heel):
    """Tabulate which station lies where along the bend, by where the hairs' stations are.

    Parameters
    ----------
    imprint : Imprint
        With places of its stations, NaN where few hairs lie; numbers and cells are filled.
    last : int
        Station of the map.
    tip, heel : float
        Of the outline, mm.
    """
    step = max(tip - heel, 1e-6) / CELLS
    imprint.numbers[TIP] = tip
    imprint.numbers[PER_CELL] = 1.0 / step
    cells = imprint.cells
    at, x_at, gap = -1, 0.0, 0.0
    cell = 0
    for s in range(last + 1):
        x = imprint.places[s]
        if np.isnan(x) or (at >= 0 and x >= x_at - _LEAST_GAP * gap):
            continue  # stations follow one another; one beside another stands for no other place
        rise = 0.0 if at < 0 else (s - at) / (x_at - x)
        while cell < CELLS and tip - cell * step >= x:
            cells[cell, 0] = s if at < 0 else at + rise * (x_at - tip + cell * step)
            cell += 1
        gap = x_at - x if at >= 0 else 0.0
        at, x_at = s, x
    while cell < CELLS:
        cells[cell, 0] = at
        cell += 1
    for cell in range(CELLS - 1):
        cells[cell, 1] = cells[cell + 1, 0] - cells[cell, 0]
    cells[CELLS - 1, 1] = at - cells[CELLS - 1, 0]

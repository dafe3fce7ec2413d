"""The outline of hairs that lie on the surface, and where the stations of their map lie in it."""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels import stamp as st
from paint3d.kernels.bristle_contact import BEGIN, DOT, END
from paint3d.kernels.bristle_tuft import BLOCK, SAMPLES

__all__ = ["BINS", "CELLS", "PER_CELL", "TIP", "draw_outline", "hold_outline", "index_stations"]

BINS = 48  # along the imprint, for its outline
CELLS = 64  # along the imprint, for finding the station of a place
TIP, PER_CELL = 0, 1  # places in Imprint.numbers
_OUTER = 96  # hairs whose ends make the outline: the last ones stand at the rim, all around
_ENDS = 0.25  # of what is left beside hairs: so much before and behind them
_Y = BLOCK


@njit(cache=True, nogil=True, error_model="numpy")
def _note_ends(points, findings, count, low, per_bin, reaches):
    """How far to the side the rim's hairs reach where they begin and cease to touch."""
    for i in range(max(0, count - _OUTER), count):
        g, j = i // BLOCK, i % BLOCK
        row = findings[g]
        if row[END + j] < 0.0:  # one that touches but does not give tells where others do
            continue
        for at in (row[BEGIN + j], row[END + j]):
            k = min(int(at), SAMPLES - 2)
            t = at - k
            x = (1.0 - t) * points[g, k, j] + t * points[g, k + 1, j]
            y = (1.0 - t) * points[g, k, _Y + j] + t * points[g, k + 1, _Y + j]
            b = min(BINS - 1, max(0, int((x - low) * per_bin)))
            reaches[b] = max(reaches[b], abs(y) + np.float64(row[DOT + j]))


@njit(cache=True, nogil=True, error_model="numpy")
def _bridge(imprint, last, low, per_bin, least, reaches):
    """Half widths from station to station, and down to `least` before the first and after the last.

    A station's hairs do not lie abreast: its width holds from halfway to the foremost of them.
    Within the outline the map says what is covered.
    """
    b = BINS - 1
    x_from, side_from = low + BINS / per_bin, least
    for s in range(last + 3):
        x_to, side_to = low, least
        if s <= last + 1:
            x_to = imprint.fronts[s] if s <= last else imprint.places[last]
            side_to = imprint.sides[min(s, last)]
            if not (x_to < x_from) or side_to <= 0.0:
                continue
        while b >= 0:
            x = low + (b + 0.5) / per_bin
            if x < x_to:
                break
            reaches[b] = side_from + (side_to - side_from) * (x_from - x) / (x_from - x_to)
            b -= 1
        x_from, side_from = x_to, side_to


@njit(cache=True, nogil=True, error_model="numpy")
def hold_outline(values):
    """Let the stamp's enclosing sphere hold its outline."""
    for along in (values[st.TIP], values[st.HEEL]):
        for across in (values[st.WIDEST], -values[st.WIDEST]):
            st.hold_point(values, along, across)


@njit(cache=True, nogil=True, error_model="numpy")
def draw_outline(
    stamp, imprint, points, findings, count, last, low, high, margin, reach, half_width
):
    """Let the stamp's outline be that of the touching hairs.

    Parameters
    ----------
    stamp : Stamp
    imprint : Imprint
        With places and sides of its stations.
    points, findings : arrays of `Hairs`
    count : int
        Hairs.
    last : int
        Station of the map.
    low, high : float
        Where along the bend hairs touch, mm.
    margin : float
        That is left beside the hairs, mm, and a quarter of it before and behind.
    reach, half_width : arrays as for `kernels.tuft.trace_outline`
    """
    reaches = imprint.reaches
    reaches[:] = margin
    per_bin = BINS / max(high - low, 1e-6)
    _bridge(imprint, last, low, per_bin, margin, reaches)
    _note_ends(points, findings, count, low, per_bin, reaches)
    step = (high - low) / BINS
    ends = _ENDS * margin
    n = 0
    reach[n], half_width[n] = high + ends, 0.0
    n += 1
    for b in range(BINS - 1, -1, -1):
        beside = 0.5 * (reaches[max(b - 1, 0)] + reaches[min(b + 1, BINS - 1)])
        reach[n], half_width[n] = low + (b + 0.5) * step, max(reaches[b], beside)
        n += 1
    reach[n], half_width[n] = low - ends, 0.0
    st.fill_profile(stamp, reach, half_width, n + 1)
    hold_outline(stamp.values)


@njit(cache=True, nogil=True, error_model="numpy")
def index_stations(imprint, last, tip, heel):
    """Tabulate which station lies where along the bend, by where the hairs' stations are.

    Parameters
    ----------
    imprint : Imprint
        With places of its stations, NaN for those without hairs; numbers and cells are filled.
    last : int
        Station of the map.
    tip, heel : float
        Of the outline, mm.
    """
    step = max(tip - heel, 1e-6) / CELLS
    imprint.numbers[TIP] = tip
    imprint.numbers[PER_CELL] = 1.0 / step
    cells = imprint.cells
    at, x_at = -1, 0.0
    cell = 0
    for s in range(last + 1):
        x = imprint.places[s]
        if np.isnan(x) or (at >= 0 and x >= x_at):
            continue  # stations follow one another
        rise = 0.0 if at < 0 else (s - at) / (x_at - x)
        while cell < CELLS and tip - cell * step >= x:
            cells[cell, 0] = s if at < 0 else at + rise * (x_at - tip + cell * step)
            cell += 1
        at, x_at = s, x
    while cell < CELLS:
        cells[cell, 0] = at
        cell += 1
    for cell in range(CELLS - 1):
        cells[cell, 1] = cells[cell + 1, 0] - cells[cell, 0]
    cells[CELLS - 1, 1] = at - cells[CELLS - 1, 0]

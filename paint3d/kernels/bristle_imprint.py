"""What hairs leave where they lie: the imprint of a tuft, as a map that vertices are looked up in.

The map runs along the hairs (stations, `SUB` to a piece, from the tip) and across the tuft (lanes
of its width there), for hairs lie side by side and keep their places: a streak stays a streak. In
each cell stand the ink that the hairs leave, and the share that they cover. A hair covers its own
thickness and a film that grows with its ink; where hairs and films are close, they flow together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from paint3d.kernels import stamp as st
from paint3d.kernels.bristle_tuft import BLOCK, CURVED, PATCH, SAMPLES

__all__ = ["LANES", "Imprint", "draw_imprint", "find_contact_pieces", "look_up",
           "make_imprint"]  # fmt: skip

SUB = 3  # stations to a piece of hair
STATIONS = SUB * (SAMPLES - 1) + 1
LANES = 128  # across the tuft
_CELLS = 64  # along the imprint, for finding the station of a place
_OUTER = 96  # hairs that tell how wide the tuft is: the last ones stand at the rim, all around
_BINS = 48  # along the imprint, for its outline
_Y = BLOCK
_Z = 2 * BLOCK
_BARE = (0.25, 0.4)  # share of a lane's width below which films leave it bare: wet, and dry
_JOINED = (0.65, 1.0)  # share from which they join
_FULL = 0.5  # of it, from which the film is as thick as it gets
_EVEN = (0.2, 0.6)  # of it: from streaks of their own to one film of even thickness

# Places in Imprint.numbers.
TIP, PER_CELL, N_STATIONS = 0, 1, 2


class Imprint(NamedTuple):
    """The imprint of one stamp, as arrays that kernels fill in place."""

    map: NDArray  # (STATIONS, LANES, 2) float32: ink (mean 1), share covered
    mix: NDArray  # (LANES, P) float32: what the ink there is made of, shares of sum 1
    widths: NDArray  # (STATIONS,) float32: half the map's width, mm
    cells: NDArray  # (_CELLS + 1,) float32: station by the place along the bend, from the tip
    numbers: NDArray  # (4,) float64


def make_imprint(n_pigments: int) -> Imprint:
    """An empty imprint."""
    return Imprint(
        np.zeros((STATIONS, LANES, 2), np.float32),
        np.zeros((LANES, n_pigments), np.float32),
        np.ones(STATIONS, np.float32),
        np.zeros(_CELLS + 1, np.float32),
        np.zeros(4),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def find_contact_pieces(bristles, bend, slopes, points, count, contact):
    """Which piece of each hair is near enough to the surface to leave ink.

    Parameters
    ----------
    bristles : Bristles
    bend : (BEND_SIZE,) float64
    slopes : (SAMPLES,) float64
        Sine of the hairs' angle to the plane at their points.
    points : (B / BLOCK, SAMPLES, 3 BLOCK) float32
        Laid on the plane meanwhile: x and y become those of a point's foot along the normal.
    count : int
        Hairs.
    contact : (2, B) float32
        First and last place on the hair, in points from the tip; the last is below 0 for a hair
        that does not touch.

    Returns
    -------
    touching : int
    low, high : float
        Where along the bend the touching pieces reach, mm.
    """
    near = np.float32(bristles.threshold_mm)
    patch = bend[PATCH : PATCH + 6]
    curved = bend[CURVED] > 0.0
    clear = np.empty(SAMPLES, np.float32)
    touching = 0
    low, high = np.inf, -np.inf
    for i in range(count):
        g, j = i // BLOCK, i % BLOCK
        first = last = -1
        for k in range(SAMPLES):
            row = points[g, k]
            z = row[_Z + j]
            if curved:
                x, y = np.float64(row[j]), np.float64(row[_Y + j])
                ground = patch[0] + patch[1] * x + patch[2] * y + patch[3] * x * x
                ground += patch[4] * x * y + patch[5] * y * y
                row[j] = x + ground * (patch[1] + 2.0 * patch[3] * x + patch[4] * y)
                row[_Y + j] = y + ground * (patch[2] + 2.0 * patch[5] * y + patch[4] * x)
                z -= np.float32(ground)
            clear[k] = z
            if z <= near:
                if first < 0:
                    first = k
                if last == k - 1 or first == k:
                    last = k
            elif first >= 0 and k > last + 1:
                break
        contact[1, i] = -1.0
        if first < 0:
            continue
        start, end = np.float32(first), np.float32(last)
        if first > 0:
            over = clear[first - 1]
            start -= (near - clear[first]) / (over - clear[first])
        if last < SAMPLES - 1:
            # a hair leaves the surface as a parabola that has the slope of its next point
            here, over = max(clear[last], np.float32(0.0)), clear[last + 1]
            rest = bristles.rests[g, last, j]
            bow = min(1.0, 2.0 * over / (rest * max(slopes[last + 1], 1e-3)))
            flat = (1.0 - bow) * (1.0 - here / near) if near > 0.0 else 1.0 - bow
            left = np.sqrt(max(near - here, np.float32(0.0)) / (over - here))
            end += np.float32(flat + (1.0 - flat) * left)
        contact[0, i], contact[1, i] = start, end
        touching += 1
        for at in (start, end):
            k = min(int(at), SAMPLES - 2)
            t = at - k
            x = (1.0 - t) * points[g, k, j] + t * points[g, k + 1, j]
            low, high = min(low, x), max(high, x)
    return touching, low, high


@njit(cache=True, nogil=True, error_model="numpy")
def _widest(points, count, widths, margin):
    """Half the tuft's width at every station, by its outermost hairs, with a margin."""
    for k in range(SAMPLES):
        most = np.float32(0.0)
        for i in range(max(0, count - _OUTER), count):
            y = abs(points[i // BLOCK, k, _Y + i % BLOCK])
            most = y if y > most else most
        widths[k * SUB] = np.float32(1.03) * most + margin
    for k in range(SAMPLES - 1):
        a, b = widths[k * SUB], widths[(k + 1) * SUB]
        for s in range(1, SUB):
            widths[k * SUB + s] = a + (b - a) * np.float32(s / SUB)


@njit(cache=True, nogil=True, error_model="numpy")
def _spread(row, half, channel, sums):
    """Mean of a row's lanes over `half` lanes to either side (a share of the outermost)."""
    sums[0] = 0.0
    for v in range(LANES):
        sums[v + 1] = sums[v] + row[v, channel]
    whole = int(half)
    part = half - whole
    width = 2.0 * half + 1.0
    for v in range(LANES):
        a, b = v - whole, v + whole + 1
        total = sums[min(b, LANES)] - sums[max(a, 0)]
        total += part * (sums[min(b + 1, LANES)] - sums[min(b, LANES)])
        total += part * (sums[max(a, 0)] - sums[max(a - 1, 0)])
        row[v, channel] = total / width


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_outline(stamp, low, high, margin, reaches, reach, half_width):
    """Let the stamp's outline be that of the touching hairs; `reaches` (_BINS,) their half widths.

    Bins without a hair are bridged: within the outline the map says what is covered.
    """
    step = (high - low) / _BINS
    before = -1
    for b in range(_BINS):
        if reaches[b] > 0.0:
            for c in range(before + 1, b):
                share = (c - before) / (b - before)
                left = reaches[before] if before >= 0 else reaches[b]
                reaches[c] = (1.0 - share) * left + share * reaches[b]
            before = b
    for c in range(before + 1, _BINS):
        reaches[c] = reaches[max(before, 0)]
    n = 0
    reach[n], half_width[n] = high + margin, 0.0
    n += 1
    for b in range(_BINS - 1, -1, -1):
        beside = 0.5 * (reaches[max(b - 1, 0)] + reaches[min(b + 1, _BINS - 1)])
        around = max(reaches[b], beside)
        reach[n], half_width[n] = low + (b + 0.5) * step, around
        n += 1
    reach[n], half_width[n] = low - margin, 0.0
    st.fill_profile(stamp, reach, half_width, n + 1)
    values = stamp.values
    for along in (values[st.TIP], values[st.HEEL]):
        for across in (values[st.WIDEST], -values[st.WIDEST]):
            d2 = 0.0
            for axis in range(3):
                d = values[st.ORIGIN_X + axis] - values[st.SPHERE_X + axis]
                d += along * values[st.BEND_X + axis] + across * values[st.CROSS_X + axis]
                d2 += d * d
            values[st.RADIUS] = max(values[st.RADIUS], np.sqrt(d2))


@njit(cache=True, nogil=True, error_model="numpy")
def draw_imprint(
    stamp, bristles, hairs, load, given, capacity, resolution, low, high, reach, half_width
):
    """Draw the imprint of hairs that lie on the surface, and the stamp's outline.

    Parameters
    ----------
    stamp : Stamp
        Gets the outline.
    bristles : Bristles
    hairs : Hairs
        With the hairs' points and contacts; its imprint is drawn.
    load : (B, P) float64
        Ink of the hairs, coats x mm2.
    given : (B,) float64
        How much of it each hair gives.
    capacity : float
        Ink in a full hair.
    resolution : float
        Vertex spacing, mm: nothing finer than a quarter of it is drawn.
    low, high : float
        From `find_contact_pieces`.
    reach, half_width : arrays as for `kernels.tuft.trace_outline`
    """
    imprint, points, contact = hairs.imprint, hairs.points, hairs.contact
    count, n_pigments = load.shape
    cells = imprint.map
    cells[:] = 0.0
    imprint.mix[:] = 0.0
    radius, film = np.float32(bristles.hair_mm), np.float32(bristles.film_mm)
    finest = 0.25 * resolution
    margin = np.float32(radius + film + finest)
    _widest(points, count, imprint.widths, margin)
    sum_x, sum_n, reaches = hairs.sums[0], hairs.sums[1], hairs.sums[2]
    sum_x[:] = 0.0
    sum_n[:] = 0.0
    reaches[:_BINS] = 0.0
    per_bin = _BINS / max(high - low, 1e-6)
    wet_sum = dot_sum = 0.0
    touching = 0
    last_station = 0
    for i in range(count):
        end = contact[1, i]
        if end < 0.0:
            continue
        g, j = i // BLOCK, i % BLOCK
        held = 0.0
        for p in range(n_pigments):
            held += load[i, p]
        wet = np.float32(held / capacity)
        dot = radius + film * min(np.float32(1.0), wet / np.float32(_FULL))
        cover = np.float32(2.0) * dot
        touching += 1
        wet_sum += wet
        dot_sum += dot
        cover = cover if given[i] > 0.0 else np.float32(0.0)
        # stations stand for half a step to either side, the outer ones for what the hair touches
        begin = contact[0, i] * SUB
        finish = max(end * SUB, begin + np.float32(0.25))
        first, last = int(begin + 0.5), min(int(finish + 0.5), STATIONS - 1)
        ink = np.float32(given[i] / (finish - begin))
        if cover > 0.0:
            for at in (begin, finish):
                k = min(int(at / SUB), SAMPLES - 2)
                t = at / SUB - k
                x = (1.0 - t) * points[g, k, j] + t * points[g, k + 1, j]
                y = (1.0 - t) * points[g, k, _Y + j] + t * points[g, k + 1, _Y + j]
                b = min(_BINS - 1, max(0, int((x - low) * per_bin)))
                reaches[b] = max(reaches[b], abs(y) + dot)
        for s in range(first, last + 1):
            part = min(finish, np.float32(s + 0.5)) - max(begin, np.float32(s - 0.5))
            k = min(s // SUB, SAMPLES - 2)
            t = np.float32(s / SUB - k)
            near, far = points[g, k], points[g, k + 1]
            x = near[j] + t * (far[j] - near[j])
            y = near[_Y + j] + t * (far[_Y + j] - near[_Y + j])
            width = imprint.widths[s]
            lane = min(LANES - 1, max(0, int((y / width + 1.0) * (0.5 * LANES))))
            per_lane = np.float32(0.5 * LANES) / width
            cells[s, lane, 0] += part * ink * per_lane
            cells[s, lane, 1] += part * cover * per_lane
            sum_x[s] += x
            sum_n[s] += 1.0
            if cover > 0.0 and part > 0.5:
                b = min(_BINS - 1, max(0, int((x - low) * per_bin)))
                reaches[b] = max(reaches[b], abs(y) + dot)
            if n_pigments > 1 and s == first and held > 0.0:
                for p in range(n_pigments):
                    imprint.mix[lane, p] += np.float32(given[i] * load[i, p] / held)
        last_station = max(last_station, last)
    _finish_map(imprint, hairs.sums, last_station, wet_sum / touching, dot_sum / touching, finest)
    _fill_mix(imprint.mix)
    _fill_outline(stamp, low, high, dot_sum / touching, reaches, reach, half_width)
    _index_stations(imprint, sum_x, sum_n, last_station, stamp.values[st.TIP],
                    stamp.values[st.HEEL])  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _finish_map(imprint, sums, last, wet, dot, finest):
    """Give hairs their width, let what is close flow together, and bring the ink to mean 1."""
    cells = imprint.map
    even = min(1.0, max(0.0, (wet - _EVEN[0]) / (_EVEN[1] - _EVEN[0])))
    least = _BARE[0] * even + _BARE[1] * (1.0 - even)
    joined = _JOINED[0] * even + _JOINED[1] * (1.0 - even)
    total_ink = total_cover = 0.0
    for s in range(last + 1):
        half = max(dot, finest) * 0.5 * LANES / imprint.widths[s]
        _spread(cells[s], half, 0, sums[3])
        _spread(cells[s], half, 1, sums[3])
        for v in range(LANES):
            # films join where there is enough of them, and draw back from where there is not
            join = (cells[s, v, 1] - least) / (joined - least)
            cells[s, v, 1] = min(np.float32(1.0), max(np.float32(0.0), join))
            total_ink += cells[s, v, 0]
            total_cover += cells[s, v, 1]
    if total_ink <= 0.0:
        return
    scale = total_cover / total_ink
    for s in range(last + 1):
        for v in range(LANES):
            ink, cover = cells[s, v, 0] * scale, cells[s, v, 1]
            cells[s, v, 0] = (1.0 - even) * min(ink, 4.0 * cover) + even * cover
    for s in range(last + 1, cells.shape[0]):
        cells[s] = cells[last]


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_mix(mix):
    """Make shares of amounts; a lane without ink takes those of the nearest before it."""
    n_pigments = mix.shape[1]
    if n_pigments < 2:
        mix[:] = 1.0
        return
    before = -1
    for v in range(LANES):
        total = mix[v].sum()
        if total > 0.0:
            mix[v] /= total
            if before < 0:
                for w in range(v):
                    mix[w] = mix[v]
            before = v
        elif before >= 0:
            mix[v] = mix[before]


@njit(cache=True, nogil=True, error_model="numpy")
def _index_stations(imprint, sum_x, sum_n, last, tip, heel):
    """Tabulate which station lies where along the bend, by where the hairs' stations are."""
    step = max(tip - heel, 1e-6) / _CELLS
    imprint.numbers[TIP] = tip
    imprint.numbers[PER_CELL] = 1.0 / step
    imprint.numbers[N_STATIONS] = last + 1
    at, x_at = -1, 0.0
    cell = 0
    for s in range(last + 1):
        if sum_n[s] == 0.0:
            continue
        x = sum_x[s] / sum_n[s]
        if at >= 0 and x >= x_at:
            continue  # stations follow one another
        while cell <= _CELLS and tip - cell * step >= x:
            if at < 0:
                imprint.cells[cell] = s
            else:
                imprint.cells[cell] = at + (s - at) * (x_at - tip + cell * step) / (x_at - x)
            cell += 1
        at, x_at = s, x
    while cell <= _CELLS:
        imprint.cells[cell] = at
        cell += 1


@njit(cache=True, nogil=True, error_model="numpy")
def look_up(imprint, x, y):
    """Ink (mean 1), share covered, and lane at a place of the imprint's plane."""
    at = (imprint.numbers[TIP] - x) * imprint.numbers[PER_CELL]
    at = min(max(at, 0.0), _CELLS - 1e-3)
    cell = int(at)
    station = imprint.cells[cell] + (at - cell) * (imprint.cells[cell + 1] - imprint.cells[cell])
    s = min(int(station), STATIONS - 2)
    t = station - s
    width = (1.0 - t) * imprint.widths[s] + t * imprint.widths[s + 1]
    lane = (y / width + 1.0) * (0.5 * LANES) - 0.5
    if lane <= -0.5 or lane >= LANES - 0.5:
        return 0.0, 0.0, 0
    lane = min(max(lane, 0.0), LANES - 1.001)
    v = int(lane)
    u = lane - v
    a, b = imprint.map[s], imprint.map[s + 1]
    ink = (1.0 - t) * ((1.0 - u) * a[v, 0] + u * a[v + 1, 0])
    ink += t * ((1.0 - u) * b[v, 0] + u * b[v + 1, 0])
    cover = (1.0 - t) * ((1.0 - u) * a[v, 1] + u * a[v + 1, 1])
    cover += t * ((1.0 - u) * b[v, 1] + u * b[v + 1, 1])
    return ink, cover, v

"""What hairs leave where they lie: the imprint of a tuft, as a map that vertices are looked up in.

The map runs along the hairs (stations, `SUB` to a piece, from the tip) and across the tuft (lanes
of its width there), for hairs lie side by side and keep their places: a streak stays a streak. In
each cell stand the ink that the hairs leave, and the share that they cover. A hair covers its own
thickness and a film that grows with its ink; where hairs and films are close, they flow together.

Hairs are laid into the map a station and a block at a time: where they lie and what they leave
there in vector instructions, and only the adding to the lanes hair by hair.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.bristles.bend import BLOCK, SAMPLES
from paint3d.brush_engine.bristles.contact import BEGIN, END, GIVES, LAID, THICK, add_up
from paint3d.brush_engine.bristles.outline import BINS, CELLS, OUTER, draw_outline, index_stations
from paint3d.core.arrays import zeros_on_lines
from paint3d.core.kernel import kernel, uncounted

__all__ = ["LANES", "STATIONS", "SUB", "Imprint", "draw_imprint", "make_imprint"]

SUB = 3  # stations to a piece of hair
STATIONS = SUB * (SAMPLES - 1) + 1
LANES = 128  # across the tuft
_Y = BLOCK
_BARE = (0.25, 0.4)  # share of a lane's width below which films leave it bare: wet, and dry
_JOINED = (0.65, 1.0)  # share from which they join
_EVEN = (0.2, 0.6)  # of it: from streaks of their own to one film of even thickness
_MOST_INK = np.float32(4.0)  # times what the share covered would hold
_FEW = 0.1  # of the most hairs at a station: so few tell nothing of the tuft's width
_EDGE = LANES // 2  # lanes that films may spread over, at the most

# Rows that hairs are laid in: what they add to their lanes, and sums over the blocks.
_ADDS, _COVERS, _SUM_X, _SUM_N, _PARTS = (place * BLOCK for place in range(5))
_ROWS = 5
_ZERO, _QUARTER, _HALF, _ONE = np.float32([0.0, 0.25, 0.5, 1.0])
_elementwise = kernel(error_model="numpy", fastmath={"contract"})


class Imprint(NamedTuple):
    """The imprint of one stamp, as arrays that kernels fill in place."""

    map: NDArray  # (STATIONS, LANES, 2) float32: ink (mean 1), share covered
    mix: NDArray  # (LANES, P) float32: what the ink there is made of, shares of sum 1
    widths: NDArray  # (STATIONS, 2) float32: half the map's width, and how much more it is at the
    # next station, mm
    cells: NDArray  # (CELLS, 2) float32: station by the place along the bend, from the tip, and
    # how much more it is a cell on
    numbers: NDArray  # (4,) float64, see `outline`
    laid: NDArray  # (2, STATIONS, LANES) float32: ink and share covered while hairs are laid
    rows: NDArray  # (5 BLOCK,) float32, scratch
    lanes: NDArray  # (BLOCK,) int32, scratch
    places: NDArray  # (STATIONS,) float64: where a station's hairs lie along the bend, mm; NaN: few
    reaches: NDArray  # (BINS,) float64: half widths of the outline
    running: NDArray  # (2, LANES + 2 EDGE + 1) float64, scratch


def make_imprint(n_pigments: int) -> Imprint:
    """An empty imprint."""
    return Imprint(
        map=np.zeros((STATIONS, LANES, 2), np.float32),
        mix=np.zeros((LANES, n_pigments), np.float32),
        widths=np.ones((STATIONS, 2), np.float32),
        cells=np.zeros((CELLS, 2), np.float32),
        numbers=np.zeros(4),
        laid=zeros_on_lines((2, STATIONS, LANES), np.float32),
        rows=zeros_on_lines(_ROWS * BLOCK, np.float32),
        lanes=zeros_on_lines(BLOCK, np.int32),
        places=np.zeros(STATIONS),
        reaches=np.zeros(BINS),
        running=np.zeros((2, LANES + 2 * _EDGE + 1)),
    )


@kernel(error_model="numpy")
def _widest(points, count, widths, margin, last):
    """Half the tuft's width at the stations, by its outermost hairs, with a margin."""
    pieces = min(last // SUB + 2, SAMPLES - 1)
    for k in range(pieces + 1):
        most = np.float32(0.0)
        for i in range(max(0, count - OUTER), count):
            y = abs(points[i // BLOCK, k, _Y + i % BLOCK])
            most = y if y > most else most
        widths[k * SUB, 0] = np.float32(1.03) * most + margin
    for k in range(pieces):
        a, b = widths[k * SUB, 0], widths[(k + 1) * SUB, 0]
        for s in range(SUB):
            widths[k * SUB + s, 0] = a + (b - a) * np.float32(s / SUB)
            widths[k * SUB + s, 1] = (b - a) * np.float32(1.0 / SUB)
    widths[pieces * SUB, 1] = 0.0


@_elementwise
def _find_parts(station, row, rows):
    """How much of a station each hair of a block touches."""
    per_piece = np.float32(SUB)
    above, below = station + _HALF, station - _HALF
    for j in range(BLOCK):
        begin, end = row[BEGIN + j] * per_piece, row[END + j] * per_piece
        least = begin + _QUARTER
        finish = end if end > least else least
        first = begin if begin > below else below
        final = finish if finish < above else above
        part = final - first  # the station stands for half a step to either side
        part = part if part > _ZERO else _ZERO
        rows[_PARTS + j] = part if end >= _ZERO else _ZERO


@_elementwise
def _lay_parts(share, scale, near, far, row, rows, lanes):
    """What the hairs of a block leave at a station: in which lane, and how much ink."""
    middle, top = np.float32(0.5 * LANES), np.float32(LANES - 1)
    for j in range(BLOCK):
        y = near[_Y + j] + share * (far[_Y + j] - near[_Y + j])
        lane = y * scale + middle
        lane = lane if lane > _ZERO else _ZERO
        lanes[j] = np.int32(lane if lane < top else top)
        part, thick = rows[_PARTS + j], row[THICK + j]
        rows[_ADDS + j] = part * row[LAID + j] * scale
        rows[_COVERS + j] = part * thick * scale


@_elementwise
def _sum_places(share, near, far, rows):
    """Sums of where along the bend a station's hairs lie."""
    for j in range(BLOCK):
        x = near[j] + share * (far[j] - near[j])
        here = rows[_PARTS + j] > _ZERO
        rows[_SUM_X + j] += x if here else _ZERO
        rows[_SUM_N + j] += _ONE if here else _ZERO


@kernel(error_model="numpy")
def _add_to_lanes(n, lanes, rows, ink, cover):
    """Add what a block leaves to its lanes, hair after hair."""
    for j in range(n):
        lane = np.uint32(lanes[j])
        ink[lane] += rows[_ADDS + j]
        cover[lane] += rows[_COVERS + j]


@uncounted(error_model="numpy")
def _lay_hairs(hairs, count, last):
    """Lay all hairs into the map's stations."""
    imprint, points, hair_contacts, depths = (
        hairs.imprint,
        hairs.points,
        hairs.hair_contacts,
        hairs.depths,
    )
    rows, lanes, places = imprint.rows, imprint.lanes, imprint.places
    imprint.laid[:, : last + 1] = _ZERO
    most = 0.0
    for s in range(last + 1):
        k = min(s // SUB, SAMPLES - 2)
        share, scale = np.float32(s / SUB - k), np.float32(0.5 * LANES) / imprint.widths[s, 0]
        rows[_SUM_X : _SUM_X + BLOCK] = _ZERO
        rows[_SUM_N : _SUM_N + BLOCK] = _ZERO
        for g in range(points.shape[0]):
            if depths[g] * SUB + 0.25 <= s - 0.5:
                continue
            near, far, row = points[g, k], points[g, k + 1], hair_contacts[g]
            _find_parts(np.float32(s), row, rows)
            _lay_parts(share, scale, near, far, row, rows, lanes)
            _sum_places(share, near, far, rows)
            n = min(BLOCK, count - g * BLOCK)
            _add_to_lanes(n, lanes, rows, imprint.laid[0, s], imprint.laid[1, s])
        there = np.float64(add_up(rows[_SUM_N : _SUM_N + BLOCK], BLOCK))
        sum_x = np.float64(add_up(rows[_SUM_X : _SUM_X + BLOCK], BLOCK))
        most = max(most, there)
        places[s] = sum_x / there if there > _FEW * most else np.nan


@uncounted(error_model="numpy")
def draw_imprint(stamp, hairs, wet, dot, resolution, scratch):
    """Draw the imprint of hairs that lie on the surface, and the stamp's outline.

    Parameters
    ----------
    stamp : Stamp
        Gets the outline.
    hairs : Hairs
        With the hairs' points and what was found of them; its imprint is drawn.
    wet, dot : float
        Means over the hairs that touch: how full they are, and their radius with their film, mm.
    resolution : float
        Vertex spacing, mm: nothing finer than a quarter of it is drawn.
    scratch : Scratch
    """
    imprint, load, bristles = hairs.imprint, hairs.load, hairs.bristles
    count = load.shape[0]
    deepest = np.float64(hairs.depths[0])
    for g in range(1, hairs.depths.shape[0]):
        deepest = max(deepest, np.float64(hairs.depths[g]))
    last = min(int(deepest * SUB + 0.75), STATIONS - 1)
    finest = 0.25 * resolution
    margin = np.float32(bristles.hair_mm + bristles.film_mm + finest)
    _widest(hairs.points, count, imprint.widths, margin, last)
    _lay_hairs(hairs, count, last)
    if load.shape[1] > 1:
        imprint.mix[:] = _ZERO
        _lay_mix(hairs, load)
    _fill_mix(imprint.mix)
    _finish_map(imprint, last, wet, max(dot, finest))
    draw_outline(
        stamp,
        imprint,
        hairs.points,
        hairs.hair_contacts,
        count,
        dot,
        scratch.reach,
        scratch.half_width,
    )
    index_stations(imprint, last, stamp.values[0].tip, stamp.values[0].heel)


@kernel(error_model="numpy")
def _spread(running, half, row):
    """Mean of a row's lanes over `half` lanes to either side; `running` (.) are its sums."""
    half = min(half, _EDGE - 2.0)
    whole = int(half)
    part, per_width = half - whole, 1.0 / (2.0 * half + 1.0)
    first = _EDGE - whole
    before, low = running[first - 1 : first - 1 + LANES], running[first : first + LANES]
    first = _EDGE + whole + 1
    high, after = running[first : first + LANES], running[first + 1 : first + 1 + LANES]
    for v in range(LANES):
        total = high[v] - low[v] + part * ((after[v] - high[v]) + (low[v] - before[v]))
        row[v] = np.float32(total * per_width)


@kernel(error_model="numpy")
def _run_up(running, ink, cover):
    """Running sums of a station's lanes; beyond them they stay as they are."""
    a, b = 0.0, 0.0
    for v in range(LANES):
        a += ink[v]
        b += cover[v]
        running[0, _EDGE + v + 1] = a
        running[1, _EDGE + v + 1] = b
    running[0, _EDGE + LANES + 1 :] = a
    running[1, _EDGE + LANES + 1 :] = b


@_elementwise
def _join(least, per_join, ink, cover, sums):
    """Films join where there is enough of them, and draw back from where there is not."""
    for v in range(LANES):
        join = (cover[v] - least) * per_join
        join = join if join > _ZERO else _ZERO
        join = join if join < _ONE else _ONE
        cover[v] = join
        sums[v] += ink[v]
        sums[LANES + v] += join


@_elementwise
def _level(even, scale, ink, cover, out):
    """Ink of mean 1, from streaks of their own to one film, beside the share covered."""
    for v in range(LANES):
        covered = cover[v]
        here, most = ink[v] * scale, _MOST_INK * covered
        out[v, 0] = (_ONE - even) * (here if here < most else most) + even * covered
        out[v, 1] = covered


@kernel(error_model="numpy")
def _finish_map(imprint, last, wet, dot):
    """Give hairs their width, let what is close flow together, and bring the ink to mean 1."""
    ink, cover, sums = imprint.laid[0], imprint.laid[1], imprint.rows[: 2 * LANES]
    even = min(1.0, max(0.0, (wet - _EVEN[0]) / (_EVEN[1] - _EVEN[0])))
    least = _BARE[0] * even + _BARE[1] * (1.0 - even)
    joined = _JOINED[0] * even + _JOINED[1] * (1.0 - even)
    sums[:] = _ZERO
    for s in range(last + 1):
        half = dot * 0.5 * LANES / np.float64(imprint.widths[s, 0])
        _run_up(imprint.running, ink[s], cover[s])
        _spread(imprint.running[0], half, ink[s])
        _spread(imprint.running[1], half, cover[s])
        _join(np.float32(least), np.float32(1.0 / (joined - least)), ink[s], cover[s], sums)
    total_ink, total_cover = add_up(sums[:LANES], LANES), add_up(sums[LANES:], LANES)
    scale = total_cover / total_ink if total_ink > _ZERO else _ZERO
    for s in range(last + 1):
        _level(np.float32(even), scale, ink[s], cover[s], imprint.map[s])
    if last + 1 < STATIONS:
        imprint.map[last + 1] = imprint.map[last]


@uncounted(error_model="numpy")
def _lay_mix(hairs, load):
    """What hairs of more than one pigment leave in their first lane, pigment by pigment."""
    imprint, points = hairs.imprint, hairs.points
    for i in range(load.shape[0]):
        g, j = i // BLOCK, i % BLOCK
        wish = hairs.hair_contacts[g, GIVES + j]
        if wish <= _ZERO:
            continue
        s = min(int(hairs.hair_contacts[g, BEGIN + j] * SUB + _HALF), STATIONS - 1)
        k = min(s // SUB, SAMPLES - 2)
        near, far = points[g, k, _Y + j], points[g, k + 1, _Y + j]
        y = near + np.float32(s / SUB - k) * (far - near)
        lane = int((y / imprint.widths[s, 0] + _ONE) * np.float32(0.5 * LANES))
        lane = min(LANES - 1, max(0, lane))
        for p in range(load.shape[1]):
            imprint.mix[lane, p] += np.float32(wish * load[i, p])


@kernel(error_model="numpy")
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

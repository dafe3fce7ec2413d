"""What hairs leave where they lie: the imprint of a tuft, as a map that vertices are looked up in.

The map runs along the hairs (stations, `SUB` to a piece, from the tip) and across the tuft (lanes
of its width there), for hairs lie side by side and keep their places: a streak stays a streak. In
each cell stand the ink that the hairs leave, and the fraction that they cover. A hair covers its
own thickness and a film that grows with its ink; where hairs and films are close, they flow
together.

Hairs are laid into the map a station and a block at a time: where they lie and what they leave
there in vector instructions, and only the adding to the lanes hair by hair.

A wet tuft is one film from rim to rim: its outline is the tuft's (Guo 2017, Eq. 8), and nothing
within it is bare. The drier it is, or the farther its clumps have parted, the more the outline is
that of the hairs that touch, and the more the film is theirs. The stations' places in the outline
are tabulated.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.bristles.bend import BLOCK, SAMPLES
from paint3d.brush_engine.bristles.contact import BEGIN, DOT, END, GIVES, LAID, LIES, THICK, add_up
from paint3d.brush_engine.footprint import (
    PROFILE_CELLS,
    fill_profile,
    hold_point,
    keep_profile,
)
from paint3d.brush_engine.outline import gather_outline
from paint3d.core.arrays import zeros_on_lines
from paint3d.core.kernel import kernel, uncounted

__all__ = [
    "CELLS",
    "LANES",
    "PER_CELL",
    "STATIONS",
    "SUB",
    "TIP",
    "Imprint",
    "draw_imprint",
    "hold_outline",
    "make_imprint",
]

SUB = 3  # stations to a piece of hair
STATIONS = SUB * (SAMPLES - 1) + 1
LANES = 128  # across the tuft
_Y = BLOCK
_BARE = (0.25, 0.4)  # fraction of a lane's width below which films leave it bare: wet, and dry
_JOINED = (0.65, 1.0)  # fraction from which they join
_EVEN = (0.2, 0.6)  # how full hairs are: from streaks of their own to one film of even thickness
_OWN_INK = 0.3  # how far what a dry hair leaves varies: where it touches, it leaves its film
_FILM = (0.45, 0.75)  # the same: from films of their own to one
_LAYERS = (1.0, 3.0)  # of films that lie over one another, for that
_LIGHT = (3.0, 8.0)  # half widths of the tuft, in radii of a hair with its film: up to the first a
# touch is one film, from the second on one of hairs
_SPLITS = 0.5  # how far clumps part until the film between them is broken
_ANY = np.float32(1e6)  # half the width of a map that is the same all over, mm
_MOST_INK = np.float32(4.0)  # times what the fraction covered would hold
_FEW = 0.1  # of the most hairs at a station: so few tell nothing of the tuft's width
_EDGE = LANES // 2  # lanes that films may spread over, at the most

# Rows that hairs are laid in: what they add to their lanes, and sums over the blocks.
_ADDS, _COVERS, _SUM_X, _SUM_N, _PARTS = (place * BLOCK for place in range(5))
_ROWS = 5
_ZERO, _QUARTER, _HALF, _ONE = np.float32([0.0, 0.25, 0.5, 1.0])
_elementwise = kernel(error_model="numpy", fastmath={"contract"})
_BINS = 48  # along the imprint, for its outline; with both ends fewer than `OUTLINE_CAPACITY`
CELLS = 64  # along the imprint, for finding the station of a place
TIP, PER_CELL = 0, 1  # places in Imprint.numbers
_OUTER = 96  # hairs that tell how wide the tuft is: the last ones stand at the rim, all around
_INNER = 48  # of the others, evenly chosen: the tuft's point, which those at the rim do not reach
_ENDS = 0.25  # of what is left beside hairs: so much before and behind them
_ASKED = 256  # hairs, at the most, that tell from where to where they lie
_FRACTIONS = 64  # places along the bend that these are counted in
_FEWEST = 0.03  # of the hairs that lie: the outline ends where no more are left
_MORE = 4.0  # times as many, for how they thin out from there
_ROUND = 0.66  # of the way to there: what a round end goes on beyond
_BLUNTEST = (7.0, 4.0)  # slope of its flanks at the heel, as a solid tuft's, and at the tip:
# beside steeper ones a soft edge spreads far
_CLOSE = 0.05  # of them within a film of a place: enough to close it
_LEAST_GAP = 0.3  # of the one before it, between a station and the next
_SHORTEST = 1e-3  # mm, from the foremost to the hindmost of them


class Imprint(NamedTuple):
    """The imprint of one stamp, as arrays that kernels fill in place."""

    map: NDArray  # (STATIONS, LANES, 2) float32: ink (mean 1), fraction covered
    mix: NDArray  # (LANES, P) float32: what the ink there is made of, in proportion
    widths: NDArray  # (STATIONS, 2) float32: half the map's width, and how much more it is at the
    # next station, mm
    cells: NDArray  # (CELLS, 2) float32: station by the place along the bend, from the tip, and
    # how much more it is a cell on
    numbers: NDArray  # (4,) float64: at TIP and PER_CELL
    laid: NDArray  # (2, STATIONS, LANES) float32: ink and fraction covered while hairs are laid
    rows: NDArray  # (5 BLOCK,) float32, scratch
    lanes: NDArray  # (BLOCK,) int32, scratch
    places: NDArray  # (STATIONS,) float64: where a station's hairs lie along the bend, mm; NaN: few
    reaches: NDArray  # (BINS,) float64: half widths of the outline
    ends: NDArray  # (3, _ASKED) float64: where some hairs' contacts begin and end along the bend
    # (the lesser place first), mm, and how far these lie on the surface
    fractions: NDArray  # (2, _FRACTIONS + 2) float64: of hairs that begin, and that end, before a
    # position
    running: NDArray  # (2, LANES + 2 EDGE + 1) float64, scratch
    tuft_widths: NDArray  # (PROFILE_CELLS + 2,) float64: of the tuft's own outline


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
        reaches=np.zeros(_BINS),
        ends=np.zeros((3, _ASKED)),
        fractions=np.zeros((2, _FRACTIONS + 2)),
        running=np.zeros((2, LANES + 2 * _EDGE + 1)),
        tuft_widths=np.zeros(PROFILE_CELLS + 2),
    )


@kernel(error_model="numpy")
def _widest(points, count, widths, bristles, film, finest, last):
    """Half the tuft's width at the stations, by its outermost hairs, with their films."""
    pieces = min(last // SUB + 2, SAMPLES - 1)
    for k in range(pieces + 1):
        most = np.float32(0.0)
        for i in range(max(0, count - _OUTER), count):
            y = abs(points[i // BLOCK, k, _Y + i % BLOCK])
            most = y if y > most else most
        margin = bristles.hair_mm + bristles.film_mm * film[k] + finest
        widths[k * SUB, 0] = np.float32(1.03) * most + np.float32(margin)
    for k in range(pieces):
        a, b = widths[k * SUB, 0], widths[(k + 1) * SUB, 0]
        for s in range(SUB):
            widths[k * SUB + s, 0] = a + (b - a) * np.float32(s / SUB)
            widths[k * SUB + s, 1] = (b - a) * np.float32(1.0 / SUB)
    widths[pieces * SUB, 1] = 0.0


@_elementwise
def _find_parts(station, row, rows):
    """Fill the part of a station that each hair of a block touches."""
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
def _lay_parts(fraction, scale, near, far, row, rows, lanes):
    """Add what the hairs of a block leave at a station: in which lane, and how much ink."""
    middle, top = np.float32(0.5 * LANES), np.float32(LANES - 1)
    for j in range(BLOCK):
        y = near[_Y + j] + fraction * (far[_Y + j] - near[_Y + j])
        lane = y * scale + middle
        lane = lane if lane > _ZERO else _ZERO
        lanes[j] = np.int32(lane if lane < top else top)
        part, thick = rows[_PARTS + j], row[THICK + j]
        rows[_ADDS + j] = part * row[LAID + j] * scale
        rows[_COVERS + j] = part * thick * scale


@_elementwise
def _sum_places(fraction, near, far, rows):
    """Sums of where along the bend a station's hairs lie."""
    for j in range(BLOCK):
        x = near[j] + fraction * (far[j] - near[j])
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
        fraction, scale = np.float32(s / SUB - k), np.float32(0.5 * LANES) / imprint.widths[s, 0]
        rows[_SUM_X : _SUM_X + BLOCK] = _ZERO
        rows[_SUM_N : _SUM_N + BLOCK] = _ZERO
        for g in range(points.shape[0]):
            if depths[g] * SUB + 0.25 <= s - 0.5:
                continue
            near, far, row = points[g, k], points[g, k + 1], hair_contacts[g]
            _find_parts(np.float32(s), row, rows)
            _lay_parts(fraction, scale, near, far, row, rows, lanes)
            _sum_places(fraction, near, far, rows)
            n = min(BLOCK, count - g * BLOCK)
            _add_to_lanes(n, lanes, rows, imprint.laid[0, s], imprint.laid[1, s])
        there = np.float64(add_up(rows[_SUM_N : _SUM_N + BLOCK], BLOCK))
        sum_x = np.float64(add_up(rows[_SUM_X : _SUM_X + BLOCK], BLOCK))
        most = max(most, there)
        places[s] = sum_x / there if there > _FEW * most else np.nan


@uncounted(error_model="numpy")
def _holds_several(load):
    """Whether hairs (B, P) hold more than one pigment, however many are known."""
    kinds = 0
    for p in range(load.shape[1]):
        for i in range(load.shape[0]):
            if load[i, p] > 0.0:
                kinds += 1
                break
    return kinds > 1


@uncounted(error_model="numpy")
def draw_imprint(stamp, tuft, hairs, sums, finest, scratch):
    """Draw the imprint of hairs that lie on the surface, and the stamp's outline.

    Parameters
    ----------
    stamp : Stamp
        With the tuft's own outline; gets that of the hairs.
    tuft : Tuft
    hairs : Hairs
        With the hairs' points and what was found of them; its imprint is drawn.
    sums : (float, float, float)
        How many hairs touch, and over these the sums of how full they are, and of their radius with
        their film, mm.
    finest : float
        Nothing finer is drawn, mm.
    scratch : Scratch
    """
    imprint, load, bend = hairs.imprint, hairs.load, hairs.bend[0]
    wet, dot = sums[1] / sums[0], sums[2] / sums[0]
    joined, light = _joined(stamp, wet, dot, sums[2], hairs)
    values = stamp.values[0]
    values.tip += bend.shift_x[0]  # as far as it has set
    values.heel += bend.shift_x[0]
    values.widest_at += bend.shift_x[0]
    film = joined >= 1.0 and not _holds_several(load)  # the same all over: nothing to map
    if film:
        _fill_evenly(imprint)
        if bend.own <= 0.0:
            hold_outline(values)
            return
    tip, heel, widest = values.tip, values.heel, values.widest
    for i in range(PROFILE_CELLS + 1):
        imprint.tuft_widths[i] = stamp.half_widths[i]
    rim = max(dot, finest)
    n, foremost, hindmost = _draw_outline(hairs, tuft.point, rim, scratch.reach, scratch.half_width)
    straight = tuft.length * np.cos(values.tilt)
    gather_outline(values.bent, straight, scratch.reach, scratch.half_width, n)
    fill_profile(stamp, scratch.reach, scratch.half_width, n)
    own = 1.0 - light if bend.own > 0.0 else 0.0
    _blend_outlines(stamp, imprint.tuft_widths, joined, own, tip, heel, widest)
    hold_outline(values)
    if not film:
        _draw_map(stamp, hairs, joined, wet, rim, finest, (foremost, hindmost))


@kernel(error_model="numpy")
def _ramp(x, limits):
    """From 0 at the first limit to 1 at the second."""
    return min(1.0, max(0.0, (x - limits[0]) / (limits[1] - limits[0])))


@kernel(error_model="numpy")
def _joined(stamp, wet, dot, films, hairs):
    """Degree to which the tuft is one film, 0 for separate hairs to 1; and that by a light touch.

    So many films (mm, their radii's sum) must lie over one another on its width. Where this is no
    more than that of a few hairs (`dot`: their radius with their film, mm), they flow together
    though the tuft is dry and has parted.
    """
    widest = max(stamp.values[0].widest, 1e-9)
    layers = _ramp(films / widest, _LAYERS)
    memory = hairs.memory[0]
    wet = _ramp(wet, _FILM) * max(0.0, 1.0 - (memory.parted + memory.split) / _SPLITS)
    light = 1.0 - _ramp(widest / dot, _LIGHT)
    return layers * (wet + (1.0 - wet) * light), layers * light


@kernel(error_model="numpy")
def _fill_evenly(imprint):
    """Fill the map as one film."""
    imprint.map[:2] = _ONE
    imprint.mix[:] = _ONE
    imprint.cells[:] = _ZERO
    imprint.widths[0, 0], imprint.widths[0, 1] = _ANY, _ZERO
    imprint.numbers[TIP], imprint.numbers[PER_CELL] = 0.0, 0.0


@kernel(error_model="numpy")
def _blend_outlines(stamp, tuft_widths, joined, own, tip, heel, widest):
    """From the outline of hairs, which the stamp has, to the tuft's own, which is given.

    So far as hairs lie otherwise than the tuft's outline has them (`own`), theirs tells how long
    and how wide it is, and the tuft's its shape.
    """
    values, widths = stamp.values[0], stamp.half_widths
    scale = 1.0 - own + own * values.widest / max(widest, 1e-9)
    for i in range(PROFILE_CELLS + 1):
        widths[i] = joined * scale * tuft_widths[i] + (1.0 - joined) * widths[i]
    tip, heel = own * values.tip + (1.0 - own) * tip, own * values.heel + (1.0 - own) * heel
    tip = joined * tip + (1.0 - joined) * values.tip
    heel = joined * heel + (1.0 - joined) * values.heel
    keep_profile(stamp, heel, tip)


@uncounted(error_model="numpy")
def _draw_map(stamp, hairs, joined, wet, dot, finest, lie):
    """Lay the hairs into the map. `lie`: from where to where along the bend they do, mm."""
    imprint, load, bend = hairs.imprint, hairs.load, hairs.bend[0]
    count = load.shape[0]
    deepest = np.float64(hairs.depths[0])
    for g in range(1, hairs.depths.shape[0]):
        deepest = max(deepest, np.float64(hairs.depths[g]))
    last = min(int(deepest * SUB + 0.75), STATIONS - 1)
    _widest(hairs.points, count, imprint.widths, hairs.bristles, bend.film, finest, last)
    _lay_hairs(hairs, count, last)
    if load.shape[1] > 1:
        imprint.mix[:] = _ZERO
        _lay_mix(hairs, load)
    _fill_mix(imprint.mix)
    _finish_map(imprint, bend.film, last, joined, wet, max(dot, finest))
    _move_stations(stamp, imprint, last, joined, finest, lie)
    _index_stations(imprint, last, stamp.values[0].tip, stamp.values[0].heel)


@kernel(error_model="numpy")
def _move_stations(stamp, imprint, last, joined, finest, lie):
    """Bring the stations from where the hairs lie to where the outline that was made of them has
    them: as far towards its tip, and as wide as it is there."""
    foremost, hindmost = lie
    values, places, widths = stamp.values[0], imprint.places, imprint.widths
    half, own = 0.5 * (foremost - hindmost), (1.0 - joined) * values.bent
    middle, final = 0.5 * (foremost + hindmost), 0.5 * (values.tip - values.heel)
    at = 0.0
    for s in range(last + 1):
        if not np.isnan(places[s]):
            at = min(1.0, max(-1.0, (places[s] - middle) / half))
            places[s] = 0.5 * (values.tip + values.heel) + final * at
        cell = 0.5 * (at + 1.0) * PROFILE_CELLS
        i = min(int(cell), PROFILE_CELLS - 1)
        here = stamp.half_widths[i]
        here += (cell - i) * (stamp.half_widths[i + 1] - here)
        widths[s, 0] = own * widths[s, 0] + (1.0 - own) * np.float32(1.03 * here + finest)
    for s in range(last):
        widths[s, 1] = widths[s + 1, 0] - widths[s, 0]


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
def _level(even, joined, scale, ink, cover, out):
    """Ink of mean 1, from streaks of their own to one film, beside the fraction covered."""
    for v in range(LANES):
        covered = cover[v] + joined * (_ONE - cover[v])
        here, most = ink[v] * scale, _MOST_INK * covered
        out[v, 0] = (_ONE - even) * (here if here < most else most) + even * covered
        out[v, 1] = covered


@kernel(error_model="numpy")
def _finish_map(imprint, films, last, joined, wet, dot):
    """Give hairs their width, let what is close flow together, and bring the ink to mean 1.

    `films` is how thick films are at the hairs' points, `dot` their radius with it, mm.
    """
    ink, cover, sums = imprint.laid[0], imprint.laid[1], imprint.rows[: 2 * LANES]
    even = _ramp(wet, _EVEN)
    least = _BARE[0] * even + _BARE[1] * (1.0 - even)
    whole = _JOINED[0] * even + _JOINED[1] * (1.0 - even)
    sums[:] = _ZERO
    for s in range(last + 1):
        k = min(s // SUB, SAMPLES - 2)
        thick = films[k] + (s / SUB - k) * (films[k + 1] - films[k])
        half = dot * thick * 0.5 * LANES / np.float64(imprint.widths[s, 0])
        _run_up(imprint.running, ink[s], cover[s])
        _spread(imprint.running[0], half, ink[s])
        _spread(imprint.running[1], half, cover[s])
        _join(np.float32(least), np.float32(1.0 / (whole - least)), ink[s], cover[s], sums)
    total_ink, total_cover = add_up(sums[:LANES], LANES), add_up(sums[LANES:], LANES)
    scale = total_cover / total_ink if total_ink > _ZERO else _ZERO
    smooth, film = np.float32(1.0 - _OWN_INK * (1.0 - even)), np.float32(joined)
    for s in range(last + 1):
        _level(smooth, film, scale, ink[s], cover[s], imprint.map[s])
    if last + 1 < STATIONS:
        imprint.map[last + 1] = imprint.map[last]


@uncounted(error_model="numpy")
def _lay_mix(hairs, load):
    """Add what hairs of more than one pigment leave in their first lane, pigment by pigment."""
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
    """Make fractions of amounts; a lane without ink takes those of the nearest before it."""
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


@kernel(error_model="numpy")
def _place_on(points, i, at):
    """Position of a hair between two of its points: along the bend and to the side, mm."""
    g, j = i // BLOCK, i % BLOCK
    k = min(int(at), SAMPLES - 2)
    t = np.float64(at) - k
    x = (1.0 - t) * points[g, k, j] + t * points[g, k + 1, j]
    return x, abs((1.0 - t) * points[g, k, _Y + j] + t * points[g, k + 1, _Y + j])


@kernel(error_model="numpy")
def _note_ends(points, hair_contacts, count, ends):
    """From where to where along the bend some hairs touch, mm, and how far they lie; how many."""
    n = 0
    for i in range(0, count, (count + _ASKED - 1) // _ASKED):
        row, j = hair_contacts[i // BLOCK], i % BLOCK
        if row[END + j] < 0.0:
            continue
        ahead, _ = _place_on(points, i, row[BEGIN + j])
        behind, _ = _place_on(points, i, row[END + j])
        ends[0, n], ends[1, n] = min(ahead, behind), max(ahead, behind)
        ends[2, n] = row[LIES + j]
        n += 1
    return n


@kernel(error_model="numpy")
def _add_fractions(ends, n, low, per_cell, fractions):
    """Fraction of hairs whose contact begins (row 0), and ends (row 1), before half a cell behind
    each of the places that are counted from `low`."""
    fractions[:] = 0.0
    total = 0.0
    for i in range(n):
        total += ends[2, i]
        for side in range(2):
            at = (ends[side, i] - low) * per_cell
            k = max(0, min(int(at), _FRACTIONS - 1))
            beyond = (at - k) * ends[2, i]
            fractions[side, k + 1] += ends[2, i] - beyond
            fractions[side, k + 2] += beyond
    for side in range(2):
        for k in range(1, _FRACTIONS + 2):
            fractions[side, k] = fractions[side, k - 1] + fractions[side, k] / total


@kernel(error_model="numpy")
def _fraction_before(row, cell):
    """Fraction of hairs before a place, in cells."""
    at = min(_FRACTIONS + 1.0, max(0.0, cell + 0.5))
    k = min(int(at), _FRACTIONS)
    return row[k] + (at - k) * (row[k + 1] - row[k])


@kernel(error_model="numpy")
def _place_of(row, fraction):
    """The place, in cells, before which a fraction of the hairs lies."""
    k = 0
    while k < _FRACTIONS and row[k + 1] < fraction:
        k += 1
    rise = row[k + 1] - row[k]
    return k - 0.5 + ((fraction - row[k]) / rise if rise > 0.0 else 0.0)


@kernel(error_model="numpy")
def _find_ends(points, hair_contacts, count, imprint):
    """From where to where along the bend the hairs touch that make an outline, mm.

    The few that come down far from the others, or hardly lie, do not: an end is where a fraction of
    the hairs is left, and beyond it as far as a round end goes on that thins out as they do there.
    It changes as the places of all hairs do, and jumps with none. The imprint's
    fractions are filled.

    Returns
    -------
    low, high : float
    first, per_cell : float
        From where the places of the fractions are counted, mm, and how many there are to the mm.
    """
    ends, fractions = imprint.ends, imprint.fractions
    n = _note_ends(points, hair_contacts, count, ends)
    first, last, lying = np.inf, -np.inf, 0.0
    for i in range(n):
        first, last, lying = min(first, ends[0, i]), max(last, ends[1, i]), lying + ends[2, i]
    if not lying > 0.0:  # none of these, or all just about to leave
        first, last = _find_extremes(points, hair_contacts, count)
        ends[0, 0], ends[1, 0], ends[2, 0] = first, last, 1.0
        n = 1
    last = max(last, first + _SHORTEST)
    per_cell = _FRACTIONS / (last - first)
    _add_fractions(ends, n, first, per_cell, fractions)
    low, more = _place_of(fractions[0], _FEWEST), _place_of(fractions[0], _MORE * _FEWEST)
    low = max(0.0, low - _ROUND * (more - low))
    high = _place_of(fractions[1], 1.0 - _FEWEST)
    more = _place_of(fractions[1], 1.0 - _MORE * _FEWEST)
    high = min(np.float64(_FRACTIONS), high + _ROUND * (high - more))
    low, high = first + low / per_cell, first + high / per_cell
    return low, max(high, low + _SHORTEST), first, per_cell


@kernel(error_model="numpy")
def _find_extremes(points, hair_contacts, count):
    """From where to where along the bend any hair touches, mm."""
    low, high = np.inf, -np.inf
    for i in range(count):
        row, j = hair_contacts[i // BLOCK], i % BLOCK
        if row[END + j] >= 0.0:
            ahead, _ = _place_on(points, i, row[BEGIN + j])
            behind, _ = _place_on(points, i, row[END + j])
            low, high = min(low, min(ahead, behind)), max(high, max(ahead, behind))
    return low, high


@kernel(error_model="numpy")
def _draw_piece(x0, y0, x1, y1, lies, low, per_bin, reaches):
    """Extend the outline by a straight piece of hair, so far as this lies on the surface."""
    if x0 > x1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    begin, end = (x0 - low) * per_bin, (x1 - low) * per_bin
    rise = (y1 - y0) / (end - begin) if end > begin else 0.0
    first, final = max(int(begin), 0), min(int(end), _BINS - 1)
    here = reaches[first : final + 1]  # no index that might be negative: vector instructions
    for b in range(here.shape[0]):
        at = min(max(first + b + 0.5, begin), end)
        here[b] = max(here[b], lies * (y0 + (at - begin) * rise))


@kernel(error_model="numpy")
def _draw_dot(x, y, radius, lies, low, per_bin, reaches):
    """Extend the outline by a round film, so far as its hair lies on the surface."""
    if radius * per_bin < 1.0:
        return
    begin, end = max(int((x - radius - low) * per_bin), 0), int((x + radius - low) * per_bin)
    for b in range(begin, min(end, _BINS - 1) + 1):
        away = low + (b + 0.5) / per_bin - x
        beside = radius * radius - away * away
        if beside > 0.0:
            reaches[b] = max(reaches[b], lies * (y + np.sqrt(beside)))


@kernel(error_model="numpy")
def _film_at(film, at):
    """Thickness of films at a position between a hair's points."""
    k = min(int(at), SAMPLES - 2)
    return film[k] + (np.float64(at) - k) * (film[k + 1] - film[k])


@kernel(error_model="numpy")
def _draw_hairs(points, hair_contacts, film, some, pieces, low, per_bin, reaches):
    """Extend the outline by the first pieces that touch of some hairs, with their films.

    `film` is how thick these are at the hairs' points. Returns how many hairs these were.
    """
    drawn = 0
    for i in range(some[0], some[1], some[2]):
        row, j = hair_contacts[i // BLOCK], i % BLOCK
        begin, end, dot = row[BEGIN + j], row[END + j], np.float64(row[DOT + j])
        if end < 0.0:
            continue
        drawn += 1
        lies = np.float64(row[LIES + j])
        x0, y0 = _place_on(points, i, begin)
        radius = dot * _film_at(film, begin)
        _draw_dot(x0, y0, radius, lies, low, per_bin, reaches)
        y0 += radius
        for k in range(int(begin) + 1, int(begin) + 1 + pieces):
            at = min(np.float32(k), end)
            x1, y1 = _place_on(points, i, at)
            y1 += dot * _film_at(film, at)
            _draw_piece(x0, y0, x1, y1, lies, low, per_bin, reaches)
            if k >= end:
                break
            x0, y0 = x1, y1
    return drawn


@kernel(error_model="numpy")
def hold_outline(values):
    """Enlarge the stamp's enclosing sphere so that it holds its outline."""
    for along in (values.tip, values.heel):
        for across in (values.widest, -values.widest):
            hold_point(values, along, across)


@kernel(error_model="numpy")
def _draw_outline(hairs, point, margin, reach, half_width):
    """The outline of the touching hairs: what those at the tuft's rim enclose.

    Within the outline the map says what is covered.

    Parameters
    ----------
    hairs : Hairs
        One of them touches at least.
    point : float
        How long the tuft's point is, mm.
    margin : float
        That is left beside the hairs, mm, where there are enough, and a quarter of it before and
        behind.
    reach, half_width : arrays as for `tuft.trace_outline`

    Returns
    -------
    n : int
        Points of the outline.
    foremost, hindmost : float
        Between which places along the bend it lies, mm.
    """
    points, hair_contacts, count = hairs.points, hairs.hair_contacts, hairs.load.shape[0]
    reaches, fractions = hairs.imprint.reaches, hairs.imprint.fractions
    low, high, zero, per_cell = _find_ends(points, hair_contacts, count, hairs.imprint)
    per_bin, wide, film = _BINS / (high - low), (high - low) / _BINS, hairs.bend[0].film
    for b in range(_BINS):
        behind = (_BINS - 0.5 - b) * wide
        film_here = margin * (min(1.0, behind / point) if point > 0.0 else 1.0)
        at = (low + (b + 0.5) * wide - zero) * per_cell
        near = _fraction_before(fractions[0], at + margin * per_cell)
        near -= _fraction_before(fractions[1], at - margin * per_cell)
        reaches[b] = film_here * min(1.0, max(0.0, near) / _CLOSE)
    first = max(0, count - _OUTER)
    inner = (0, first, max(1, first // _INNER))
    drawn = _draw_hairs(
        points, hair_contacts, film, (first, count, 1), SAMPLES, low, per_bin, reaches
    )
    drawn += _draw_hairs(points, hair_contacts, film, inner, 1, low, per_bin, reaches)
    if drawn == 0:  # few are long enough, and none of these
        _draw_hairs(points, hair_contacts, film, (0, first, 1), 1, low, per_bin, reaches)
    foremost = high + _ENDS * margin * film[0]
    hindmost = low - _ENDS * margin
    n = 0
    reach[n], half_width[n] = foremost, 0.0
    n += 1
    for b in range(_BINS - 1, -1, -1):
        beside = 0.5 * (reaches[max(b - 1, 0)] + reaches[min(b + 1, _BINS - 1)])
        at = low + (b + 0.5) * wide
        blunt = min(_BLUNTEST[0] * (at - hindmost), _BLUNTEST[1] * (foremost - at))
        reach[n], half_width[n] = at, min(max(reaches[b], beside), blunt)
        n += 1
    reach[n], half_width[n] = hindmost, 0.0
    return n + 1, foremost, hindmost


@kernel(error_model="numpy")
def _index_stations(imprint, last, tip, heel):
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

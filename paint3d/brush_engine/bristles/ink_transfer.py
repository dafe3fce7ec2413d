"""What passes between single hairs and the vertices under them.

Guo 2017, Eqs. 12, 13 in their continuous form (docs/model.md, equation (10)) hold for the tuft: of
the ink R in it, the way ds at the pressure pe takes R (1 - exp(-eta' pe ds)). Here each hair gives
by that law, those that lie on the surface for all, some more readily than others; neighbours that
are wet level out. A tuft that is equally wet everywhere thus gives what a solid one gives, and one
that runs dry does so hair by hair.

A tuft that is loaded differently along its length has hairs that are so: how much each holds is its
own, and of which inks that is lies in reservoirs from the tip to the root, as in a solid one.

One sweep: vertices ask the map of hairs what lies over them, block by block in vector instructions,
and get what the hairs there leave.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.bend import BLOCK
from paint3d.brush_engine.bristles.contact import (
    BEGIN,
    DOT,
    END,
    GIVES,
    HELD,
    LAID,
    READY,
    THICK,
    add_up,
)
from paint3d.brush_engine.bristles.imprint import CELLS, LANES, PER_CELL, STATIONS, TIP
from paint3d.brush_engine.coverage import hold_within, weighed_area
from paint3d.brush_engine.dry_contact import dry_contact, note_way, thin_contact
from paint3d.brush_engine.footprint import find_way, outline_motion
from paint3d.brush_engine.ink_transfer import (
    PAINTED,
    Deposit,
    absorbency,
    add_ink,
    fetch_found,
    fetch_positions,
    first_film,
    given_on_way,
    landing_fraction,
    leave_from_reservoirs,
    level_film,
    note_covered,
    take_in,
    take_up_ink,
    wetness,
)
from paint3d.brush_engine.vertex_query import find_vertices
from paint3d.core.kernel import kernel, uncounted

__all__ = [
    "LEVEL_BINS",
    "ask_hairs",
    "know_hairs",
    "settle_deposits",
    "sum_hairs",
    "sweep_hairs",
]

_BUNDLES = 0.85  # how far bundles differ, besides hairs
_DIFFER = 0.45  # and how far what these cover does
_DRIES = 0.2  # how far the contact level falls until tooth and hairs together say what is touched
_WHOLE = 0.07  # fraction that dry hairs cover, from which on all of it may be touched
_BRIDGED = 0.6  # and wet ones: ink stands between hairs that lie so close
_OWN_GAPS = 1.03  # times as deep into the tooth: hairs leave gaps of their own besides
LEVEL_BINS = 64  # across the tuft, within which hairs share
_MOST_PER_HAIR = 8.0  # times its own share that a hair gives for those that do not touch
_RETENTION = np.float32(0.4)  # of a hair's room: what those keep that hold back most
_PER_SOFT = np.float32(1.0 / 0.06)  # of it, over which they do so
_ALL_KEEP = 0.4  # fullness of the tuft below which pores draw on what hairs keep
_LEAST_KEPT = 1e-3  # of what they keep of a fuller one
_PASSING = np.float32(0.45)  # fraction of the retention that changes along the way
_STAGE = 5.0  # mm of way, over which it becomes another
_STEP = 6  # places that change alike
_FLOWS = (0.08, 0.35)  # of a hair's room for ink: where ink begins to move, and moves freely
_SIDE = BLOCK  # place of b in the rows of `turned`
_PER_FULL = np.float32(1.0 / 0.5)  # of a hair's room, from which its film is as thick as it gets
_LEAST_WISH = np.float32(0.5)  # of a hair that touches in one point only
_SHORTEST = np.float32(0.25)  # stations that any contact covers at the least
_ZERO, _HALF, _ONE, _TWO = np.float32([0.0, 0.5, 1.0, 2.0])
_APPETITE, _OWN, _NOW, _SOON = (READY + place * BLOCK for place in range(4))
_elementwise = kernel(error_model="numpy", fastmath={"contract"})
_LANE = np.int32(LANES - 1)  # of a place: LANES is a power of 2
_FAINTEST = np.float32(2e-3)  # fraction covered below which a vertex is left alone
_LAST_CELL = np.float32(CELLS - 1e-3)
_LAST_LANE = np.float32(LANES - 1.001)
_LEVELS_EVERY = 2.0  # mm of way


@kernel(error_model="numpy")
def know_hairs(bristles, turned, roll, way_done, known, hair_contacts):
    """Update how readily hairs at their places give, where the bend or the stage is another.

    Parameters
    ----------
    bristles : Bristles
    turned, roll : arrays of `Hairs`
    way_done : float
        Of the tuft since it was dipped, mm: streaks come and go along it.
    known : (3,) float64
        What `hair_contacts` is for: the roll, and the stage of the way.
    hair_contacts : (B / BLOCK, FINDINGS BLOCK) float32
        The rows from READY on are filled.
    """
    stage = int(way_done / _STAGE)
    if known[0] == roll[0] and known[1] == roll[1] and known[2] == stage:
        return
    known[0], known[1], known[2] = roll[0], roll[1], stage
    cells = bristles.appetite.shape[0]
    for g in range(turned.shape[0]):
        row, sides = hair_contacts[g], turned[g]
        for j in range(BLOCK):
            side = (sides[_SIDE + j] + _ONE) * np.float32(0.5 * cells)
            cell = min(cells - 1, max(0, int(side)))
            place = _STEP * (cell // _STEP) + 1
            row[_APPETITE + j] = bristles.appetite[cell]
            row[_OWN + j] = bristles.retention[cell]
            row[_NOW + j] = bristles.retention[(place * (stage + 7) * 31) % cells]
            row[_SOON + j] = bristles.retention[(place * (stage + 8) * 31) % cells]


@kernel(error_model="numpy")
def _hold(load, first, n, row):
    """Ink in each hair of a block, of all pigments."""
    if load.shape[1] == 1:
        flat = load.reshape(load.shape[0])[first : first + n]
        for j in range(n):
            row[HELD + j] = np.float32(flat[j])
        return
    for j in range(n):
        held = 0.0
        for p in range(load.shape[1]):
            held += load[first + j, p]
        row[HELD + j] = np.float32(held)


@_elementwise
def _wish(per_room, keeps, fraction, hair_mm, film_mm, per_piece, row, sums):
    """Fill what each hair of a block would give, its thickness, and what it would lay down."""
    own, passing = _ONE - _PASSING, _PASSING
    kept, per_soft = keeps * _RETENTION, _PER_SOFT / keeps
    for j in range(BLOCK):
        begin, end, held = row[BEGIN + j], row[END + j], row[HELD + j]
        here = _ONE if end >= _ZERO else _ZERO
        wet = held * per_room
        now, soon = row[_NOW + j], row[_SOON + j]
        retention = own * row[_OWN + j] + passing * (now + fraction * (soon - now))
        flow = (wet - kept * retention) * per_soft
        flow = flow if flow > _ZERO else _ZERO
        reach = _LEAST_WISH + (end - begin)
        reach = reach if reach < _ONE else _ONE
        wish = here * reach * row[_APPETITE + j] * (flow if flow < _ONE else _ONE)
        full = wet * _PER_FULL
        dot = hair_mm + film_mm * (full if full < _ONE else _ONE)
        span = (end - begin) * per_piece
        row[GIVES + j] = wish
        row[DOT + j] = dot
        row[LAID + j] = wish * held / (span if span > _SHORTEST else _SHORTEST)
        row[THICK + j] = _TWO * dot if wish > _ZERO else _ZERO
        sums[j] += wish
        sums[BLOCK + j] += here * wet
        sums[2 * BLOCK + j] += here * dot


@kernel(error_model="numpy")
def ask_hairs(bristles, load, capacity, draws, way_done, per_piece, hair_contacts, sums):
    """Fill what the hairs are ready to give, relative to one another.

    Each keeps some of its ink back; from a tuft that is nearly dry pores draw it all the same, so
    that a mark on paper breaks up and does not end.

    Parameters
    ----------
    bristles : Bristles
    load : (B, P) float64
        Ink in each hair, coats x mm2.
    capacity : float
        Ink in a full hair.
    draws : float
        How far pores draw ink, 0 to 1.
    way_done : float
        As for `know_hairs`.
    per_piece : int
        Stations of the map to a piece of hair.
    hair_contacts : (B / BLOCK, FINDINGS BLOCK) float32
        With the hairs' contacts, and READY; the other rows are filled.
    sums : (3 BLOCK,) float32
        Scratch.

    Returns
    -------
    wanted, wet, dot : float
        Sums of the hairs' wishes, and over those that touch, of how full they are, and of their
        radius with their film, mm.
    """
    count = load.shape[0]
    sums[:] = _ZERO
    held = load.sum() / (count * capacity) if capacity > 0.0 else 1.0
    keeps = np.float32(max(_LEAST_KEPT, 1.0 - draws * (1.0 - min(1.0, held / _ALL_KEEP))))
    fraction = np.float32(way_done / _STAGE - int(way_done / _STAGE))
    for g in range(hair_contacts.shape[0]):
        row = hair_contacts[g]
        _hold(load, g * BLOCK, min(BLOCK, count - g * BLOCK), row)
        _wish(
            np.float32(1.0 / capacity) if capacity > 0.0 else _ZERO, keeps, fraction,
            np.float32(bristles.hair_mm), np.float32(bristles.film_mm), np.float32(per_piece),
            row, sums,
        )  # fmt: skip
    wanted, wet = add_up(sums[:BLOCK], BLOCK), add_up(sums[BLOCK : 2 * BLOCK], BLOCK)
    return np.float64(wanted), np.float64(wet), np.float64(add_up(sums[2 * BLOCK :], BLOCK))


@_elementwise
def _give_by_law(rate, doublings, row):
    """1 - exp(-rate x wish) for every hair: rational for a small part of it, then doubled.

    With h a quarter of the part at the most, tanh h = h (15 + h^2) / (15 + 6 h^2) to 3e-7 of it,
    1 - exp(-2 h) = 2 tanh h / (1 + tanh h), and u for a part is u (2 - u) for twice the part.
    """
    half = _HALF * rate
    for j in range(BLOCK):
        h = half * row[GIVES + j]
        h2 = h * h
        t = h * (np.float32(15.0) + h2) / (np.float32(15.0) + np.float32(6.0) * h2)
        row[GIVES + j] = _TWO * t / (_ONE + t)
    for _ in range(doublings):
        for j in range(BLOCK):
            u = row[GIVES + j]
            row[GIVES + j] = u * (_TWO - u)


@kernel(error_model="numpy")
def settle_deposits(count, wanted, rate, hair_contacts, sums):
    """Turn wishes into the fraction of its ink that each hair gives over a way; returns the sum.

    Parameters
    ----------
    count : int
        Hairs.
    wanted : float
        Sum of the wishes, from `ask_hairs`.
    rate : float
        eta' pe ds.
    hair_contacts : (B / BLOCK, FINDINGS BLOCK) float32
        From `ask_hairs`; GIVES is overwritten.
    sums : (BLOCK,) float64
        Scratch.
    """
    each = min(count / wanted, _MOST_PER_HAIR) * rate
    doublings = 0
    while each > 0.25 and doublings < 60:  # the readiest hairs wish for less than twice as much
        each *= 0.5
        doublings += 1
    sums[:BLOCK] = 0.0
    for g in range(hair_contacts.shape[0]):
        row = hair_contacts[g]
        _give_by_law(np.float32(each), doublings, row)
        for j in range(BLOCK):
            sums[j] += np.float64(row[GIVES + j]) * np.float64(row[HELD + j])
    return add_up(sums, BLOCK)


@kernel(error_model="numpy")
def sum_hairs(load, out):
    """Ink in all hairs: `out` (P,) of `load` (B, P); in one order of adding, halves to halves."""
    count, n_pigments = load.shape
    sums = np.empty(BLOCK)
    flat = load.reshape(load.size)
    for p in range(n_pigments):
        sums[:] = 0.0
        for first in range(0, count, BLOCK):
            n = min(BLOCK, count - first)
            if n_pigments == 1:
                part = flat[first : first + n]
                for j in range(n):
                    sums[j] += part[j]
            else:
                for j in range(n):
                    sums[j] += load[first + j, p]
        out[p] = add_up(sums, BLOCK)


@kernel(error_model="numpy")
def _take_from_hairs(load, hair_contacts, scale, sums, released):
    """Take `scale` of what each hair is ready to give; `released` (P,) gets the sums.

    Parameters
    ----------
    load : (B, P) float64
    hair_contacts : (B / BLOCK, FINDINGS BLOCK) float32
        From `settle_deposits`.
    scale : float
    sums : (BLOCK,) float64
        Scratch.
    """
    count, n_pigments = load.shape
    flat = load.reshape(load.size)
    for p in range(n_pigments):
        sums[:BLOCK] = 0.0
        for g in range(hair_contacts.shape[0]):
            row, first = hair_contacts[g][GIVES : GIVES + BLOCK], g * BLOCK
            n = min(BLOCK, count - first)
            if n_pigments == 1:
                here = flat[first : first + n]
                for j in range(n):
                    part = min(1.0, scale * np.float64(row[j])) * here[j]
                    here[j] -= part
                    sums[j] += part
            else:
                for j in range(n):
                    part = min(1.0, scale * np.float64(row[j])) * load[first + j, p]
                    load[first + j, p] -= part
                    sums[j] += part
        released[p] = add_up(sums, BLOCK)


@kernel(error_model="numpy")
def _give_to_hairs(load, hair_contacts, taken):
    """Share `taken` (P,) evenly among the hairs that touch."""
    count = load.shape[0]
    touching = 0
    for i in range(count):
        touching += hair_contacts[i // BLOCK, END + i % BLOCK] >= _ZERO
    for i in range(count):
        if hair_contacts[i // BLOCK, END + i % BLOCK] >= _ZERO:
            for p in range(load.shape[1]):
                load[i, p] += taken[p] / touching


@kernel(error_model="numpy")
def _level_hairs(bristles, turned, load, capacity, way, bins):
    """Exchange ink between neighbouring hairs, the more freely the wetter they are.

    Parameters
    ----------
    bristles, turned, load : as for `know_hairs` and `ask_hairs`
    capacity : float
        Ink in a full hair.
    way : float
        Of the tuft, mm.
    bins : (LEVEL_BINS, P + 1) float64
        Scratch.
    """
    count, n_pigments = load.shape
    bins[:] = 0.0
    for i in range(count):
        b = turned[i // BLOCK, _SIDE + i % BLOCK]
        at = min(LEVEL_BINS - 1, max(0, int((b + 1.0) * 0.5 * LEVEL_BINS)))
        for p in range(n_pigments):
            bins[at, p] += load[i, p]
        bins[at, n_pigments] += 1.0
    reach = 1.0 - np.exp(-way / bristles.levelling_mm)
    for i in range(count):
        b = turned[i // BLOCK, _SIDE + i % BLOCK]
        at = min(LEVEL_BINS - 1, max(0, int((b + 1.0) * 0.5 * LEVEL_BINS)))
        n = bins[at, n_pigments]
        mean = 0.0
        for p in range(n_pigments):
            mean += bins[at, p]
        flow = (mean / (n * capacity) - _FLOWS[0]) / (_FLOWS[1] - _FLOWS[0])
        fraction = reach * min(1.0, max(0.0, flow))
        for p in range(n_pigments):
            load[i, p] += fraction * (bins[at, p] / n - load[i, p])


@_elementwise
def _find_stations(n, tip, per_cell, cells, widths, xs, places, parts):
    """Which station vertices lie behind, how far towards the next, and half the map's width."""
    for k in range(n):
        at = (tip - xs[k]) * per_cell
        at = at if at > _ZERO else _ZERO
        at = at if at < _LAST_CELL else _LAST_CELL
        cell = np.int32(at)
        station = cells[cell, 0] + (at - np.float32(cell)) * cells[cell, 1]
        s = np.int32(station)
        s = s if s < STATIONS - 2 else np.int32(STATIONS - 2)
        t = station - np.float32(s)
        places[k] = s * np.int32(LANES)
        parts[0, k] = t
        parts[2, k] = widths[s, 0] + t * widths[s, 1]


@_elementwise
def _find_lanes(n, ys, places, parts):
    """The lane that vertices lie beside, how far towards the next, and whether within the map."""
    middle = np.float32(0.5 * LANES)
    for k in range(n):
        beside = ys[k] * middle / parts[2, k]
        lane = beside + (middle - _HALF)
        lane = lane if lane > _ZERO else _ZERO
        lane = lane if lane < _LAST_LANE else _LAST_LANE
        v = np.int32(lane)
        places[k] += v
        parts[1, k] = lane - np.float32(v)
        parts[2, k] = _ONE if abs(beside) < middle else _ZERO


@_elementwise
def _read_map(n, map_, places, parts, inks, covers):
    """Ink and fraction covered between the four cells around each vertex."""
    for k in range(n):
        i = places[k]
        t, u = parts[0, k], parts[1, k]
        a, b = map_[2 * i], map_[2 * i + 2]
        c, d = map_[2 * (i + LANES)], map_[2 * (i + LANES) + 2]
        one, other = a + u * (b - a), c + u * (d - c)
        inks[k] = one + t * (other - one)
        a, b = map_[2 * i + 1], map_[2 * i + 3]
        c, d = map_[2 * (i + LANES) + 1], map_[2 * (i + LANES) + 3]
        one, other = a + u * (b - a), c + u * (d - c)
        covers[k] = parts[2, k] * (one + t * (other - one))


@uncounted(error_model="numpy", apart=True)
def _turn_to_stamp(n, turn, ahead, aside, xs, ys):
    """Turn positions along and across the way into a stamp's own coordinates, mm."""
    turn_x, turn_y, cosine, sine = turn
    ox, oy, c, s = np.float32(turn_x), np.float32(turn_y), np.float32(cosine), np.float32(sine)
    for k in range(n):
        dx, dy = ahead[k] - ox, aside[k] - oy
        xs[k], ys[k] = c * dx + s * dy, c * dy - s * dx


@uncounted(error_model="numpy", apart=True)
def _weigh_by_map(n, places, inks, covers, whole_from, fraction, cover, under, lanes):
    """Weigh vertices by what they found in the map; what found nothing gets nothing."""
    for k in range(n):
        covered = covers[k]
        most = covered if covered > whole_from else whole_from
        here = _ONE / most if covered > _FAINTEST else _ZERO
        fraction[k] *= inks[k] * here
        cover[k] *= covered * here
        under[k] = covered
        lanes[k] = places[k] & _LANE


@uncounted(error_model="numpy")
def _look_up_hairs(imprint, whole_from, n, scratch):
    """Weigh the vertices that an outline covers by the hairs that pass over them.

    The way from the stamp before is no longer than the vertices lie apart, so that the imprint at
    its end is that of all of it. Vertices are looked up where it ends, or where they lay under it
    last.

    Parameters
    ----------
    imprint : Imprint
    whole_from : float
        fraction that hairs cover from which on all is.
    n : int
        Vertices in `scratch.found`, which get the lane of the map that each lies in, and what hairs
        cover there.
    scratch : Scratch
    """
    sweep, chords, found, block = scratch.sweep[0], scratch.chords, scratch.found, scratch.block
    map_ = imprint.map.reshape(imprint.map.size)
    tip, per_cell = np.float32(imprint.numbers[TIP]), np.float32(imprint.numbers[PER_CELL])
    turn = sweep.to_after
    rows, places, parts, size = block.rows, block.near[1], block.work[:3], block.stretch.shape[0]
    for first in range(0, n, size):
        m = min(size, n - first)
        last = first + m
        ahead, aside, xs, ys = rows[0], rows[1], rows[2], rows[3]
        own_ahead, own_aside = found.ahead[first:last], found.aside[first:last]
        for k in range(m):
            ahead[k], aside[k] = own_ahead[k], own_aside[k]
        hold_within(
            m, sweep.scale, chords.flanks[1], chords.grids[1], chords.lines[1], ahead, aside
        )
        _turn_to_stamp(m, (turn[0], turn[1], turn[2], turn[3]), ahead, aside, xs, ys)
        _find_stations(m, tip, per_cell, imprint.cells, imprint.widths, xs, places, parts)
        _find_lanes(m, ys, places, parts)
        _read_map(m, map_, places, parts, rows[4], rows[5])
        _weigh_by_map(
            m, places, rows[4], rows[5], whole_from, found.fraction[first:last],
            found.cover[first:last], found.under[first:last], found.lanes[first:last],
        )  # fmt: skip


@uncounted(error_model="numpy", apart=True)
def _weigh_by_lane(n, fraction, lanes, inks, out):
    """Fill the fractions of vertices times how much of an ink is in their lanes (of `inks`)."""
    for k in range(n):
        out[k] = fraction[k] * inks[np.uint32(lanes[k])]


@uncounted(error_model="numpy")
def _leave(mix, landing, found, n, field, ink):
    """Leave `landing` (P,) on the vertices, by their fractions and by what is in their lanes."""
    for p in range(landing.shape[0]):
        if landing[p] > 0.0:
            _weigh_by_lane(n, found.fraction, found.lanes, mix[:, p], found.coats)
            weighed = weighed_area(n, found.area, found.coats, field.area_step)
            if weighed > 0.0:
                coats = np.float32(landing[p] / weighed)
                add_ink(found, n, found.coats, coats, ink.amounts, p)
                landing[p] = 0.0


@uncounted(error_model="numpy")
def _leave_along(before, after, lands, n, hairs, field, ink, scratch):
    """Leave what the hairs released on the vertices found, each of the inks that lie so far up the
    tuft; `lands` of it does. What stays is shared out among the hairs as they hold it.

    Conserves as `leave_from_reservoirs` does.
    """
    found, released = scratch.found, 0.0
    for p in range(hairs.released.shape[0]):
        released += hairs.released[p]
    weighed = weighed_area(n, found.area, found.fraction, field.area_step)
    landing = released * lands if weighed > 0.0 else 0.0
    if released > 0.0 or ink.transfer[0].pickup > 0.0:
        deposit = Deposit(released, landing, weighed)
        leave_from_reservoirs(before, after, deposit, found, n, field, ink, scratch.taken)
    _mix_hairs(hairs.load, ink.load)


@kernel(error_model="numpy")
def _mix_hairs(load, mixture):
    """Give hairs (B, P) `mixture` (P,) in all, each as much as before, and all of one kind."""
    count, n_pigments = load.shape
    total = 0.0
    for i in range(count):
        for p in range(n_pigments):
            total += load[i, p]
    for i in range(count):
        own = 0.0
        for p in range(n_pigments):
            own += load[i, p]
        fraction = own / total if total > 0.0 else 1.0 / count
        for p in range(n_pigments):
            load[i, p] = fraction * mixture[p]


@uncounted(error_model="numpy")
def sweep_hairs(before, after, ready, transfer_per_mm, hairs, field, ink, scratch):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Parameters
    ----------
    before, after : Stamp
        `after` touches.
    ready : float
        What the hairs are ready to give on the way, coats x mm2: what `settle_deposits` found.
    transfer_per_mm : float
        Of the tuft.
    hairs, field, ink, scratch : as for `brush_engine.bristles.stroke_loop`

    Conserves: what leaves the hairs is on vertices or counted in `ink.off_surface`
    (docs/model.md, equation (11)).
    """
    width, found = field.soft_edge, scratch.found
    note_way(before, after)
    wet = wetness(before, after, ink)
    level = min(1.0, wet)
    scratch.sweep[0].wet = wet
    dry = min(1.0, (1.0 - level) / _DRIES)
    whole_from = np.float32(_BRIDGED + dry * (_WHOLE - _BRIDGED))
    n = find_vertices(before, after, field, scratch)
    if n < 0:
        return False
    fetch_found(found, n, field.area, found.area)
    within = weighed_area(n, found.area, found.fraction, field.area_step)
    _look_up_hairs(hairs.imprint, whole_from, n, scratch)
    weighed = weighed_area(n, found.area, found.fraction, field.area_step)
    come_from = before.values[0]
    area = after.values[0].area
    if come_from.touches > 0.0:
        area = 0.5 * (come_from.area + area)
    bare = weighed <= 0.0 < within  # no hair lies over the vertices that the outline covers
    scale = 0.0 if bare or (area < width * width and within <= 0.0) else given_on_way(level)
    lands = landing_fraction(area, width, within)
    bristles = hairs.bristles
    bundles = (bristles.root_mm, bristles.bundle_mm, _BUNDLES, dry * _DIFFER)
    reached = min(1.0, _OWN_GAPS * level)
    contact = dry_contact(reached, find_way(before, after)[0], after, bundles, field, ink)
    if level < 1.0 or absorbency(ink) > 0.0:
        fetch_positions(found, n, field)
    if level < 1.0 and weighed > 0.0:  # hairs that run dry give less, and only to the heights
        thin_contact(contact, after, found, n, ink, scratch.block)
        rest = weighed_area(n, found.area, found.fraction, field.area_step)
        scale *= rest / weighed
    scratch.taken[:] = 0.0
    if ink.transfer[0].pickup > 0.0:
        take_up_ink(before, after, ready * scale, found, n, field, ink, scratch.taken)
    level_film(before, after, wet, contact, field, ink, n, scratch)
    landing = ready * scale * lands
    weighed = weighed_area(n, found.area, found.fraction, field.area_step)
    if landing > 0.0 and weighed > 0.0:
        coats = first_film(level, transfer_per_mm, bristles.root_mm, ink)
        rest, first, _ = take_in(coats, before, after, landing, weighed, n, field, ink, scratch)
        given = scale * rest + first / ready  # all of the film lands
        lands = (scale * rest * lands + first / ready) / given if given > 0.0 else lands
        scale = given
    _take_from_hairs(hairs.load, hairs.hair_contacts, scale, hairs.whole_sums, hairs.released)
    if ink.reservoirs.shape[0] > 1:
        _leave_along(before, after, lands, n, hairs, field, ink, scratch)
    else:
        for p in range(hairs.left.shape[0]):
            hairs.left[p] = hairs.released[p] * lands
            ink.off_surface[p] += hairs.released[p] - hairs.left[p]
        _leave(hairs.imprint.mix, hairs.left, found, n, field, ink)
        for p in range(hairs.left.shape[0]):  # what found no vertex
            ink.off_surface[p] += hairs.left[p]
        if ink.transfer[0].pickup > 0.0:
            _give_to_hairs(hairs.load, hairs.hair_contacts, scratch.taken)
    _level(hairs, ink.transfer[0].capacity, outline_motion(before, after))
    sum_hairs(hairs.load, ink.load)
    scratch.counters[PAINTED] += note_covered(found, n, ink)
    return True


@uncounted(error_model="numpy")
def _level(hairs, capacity, way):
    """Level the ink of the hairs, where the tuft has gone so far (mm) that it is time."""
    memory = hairs.memory[0]
    memory.unlevelled += way
    if memory.unlevelled >= _LEVELS_EVERY:
        each = capacity / hairs.load.shape[0]
        _level_hairs(hairs.bristles, hairs.turned, hairs.load, each, memory.unlevelled, hairs.bins)
        memory.unlevelled = 0.0

"""What passes between the brush and the vertices that a footprint swept (Guo 2017, Eqs. 12-13).

One sweep gathers the vertices that it covers, and leaves ink on them: on all alike, in streaks
where the brush runs dry, and from where on the tuft they are touched if it is loaded differently
along its length.

The classic loading, tip dark and belly light: the load lies in reservoirs from the tip to the root,
all filled alike: when the part that touches gives ink, the rest flows down to it, as in a wet tuft
the capillaries see to. The tuft lies along its footprint, so a vertex at a distance s behind the
tip is painted by what is s up the tuft.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.coverage import cut_outline, fetch, find_begun, weighed_area
from paint3d.brush_engine.dry_contact import (
    BUNDLE_MM,
    dry_contact,
    note_way,
    thin_contact,
    weigh_streaks,
)
from paint3d.brush_engine.footprint import (
    LAST_PLACE,
    PROFILE_CELLS,
    find_way,
    ink_way,
    outline_motion,
    profile_cell,
)
from paint3d.brush_engine.vertex_query import find_vertices
from paint3d.core.kernel import kernel, uncounted
from paint3d.mesh.kernels.mesh_arrays import as_index

__all__ = [
    "FADING",
    "FILM",
    "FILM_FRACTION",
    "LINES",
    "PAINTED",
    "TRANSFER",
    "Deposit",
    "InkField",
    "absorbency",
    "add_ink",
    "drawn_rate",
    "fetch_found",
    "fetch_positions",
    "first_film",
    "forget_dirty",
    "given_on_way",
    "held_ink",
    "landing_fraction",
    "leave_from_reservoirs",
    "level_film",
    "level_reservoirs",
    "mean_pressure",
    "note_covered",
    "sweep_deposit",
    "take_in",
    "take_up_ink",
    "wetness",
]

# ---- The even film -------------------------------------------------------------------------------
# Wet ink lies under a brush as an even film (docs/model.md, equation (12)).
#
# Guo 2017, Eq. 13 gives every vertex under the footprint the same, moment by moment. What is under
# the middle of the tuft for long then gets much, and what only its flank passes gets little: a
# ridge with pale rims. A wet tuft and the ink under it are one body of liquid, though, that levels
# across the way as it goes. So each line of the footprint along the way gets as much to the mm2,
# however long or short it is; on a glaze the flanks rather more, where the film is drawn to as it
# dries, and rather less on paper that drinks it meanwhile.


LINES = 64  # along the way, side by side, that a footprint is cut into
_RUNS_DRY = (0.15, 0.3)  # contact level below which a tuft has no film, and from which it has one
_MOST = 6.0  # times a fraction that a line gets
_ON_GLAZE, _ON_GRAIN = 1.15, 0.55  # power of a line's length that what it gets falls with
# Strength of what bundles of hairs bring on paper: of a tuft about to skip, and of one so many
# times as full, in which ink runs together
_STREAKS, _STREAKS_FULL, _FULL = 0.16, 0.05, 2.2


@uncounted(error_model="numpy")
def _fill_gains(enters, leaves, strength, power, numbers, gains):
    """Fill the gains of a footprint's lines: linear from the middle of one to that of the next.

    Where a footprint's lines are entered and left is given; `numbers` is worked in.
    """
    mean, count = 0.0, 0
    for line in range(LINES):
        length = max(0.0, leaves[line] - enters[line])
        mean += length
        count += length > 0.0
    mean /= max(1, count)
    for line in range(LINES):
        length, gain = leaves[line] - enters[line], _MOST
        if length > 0.0:
            gain = min(_MOST, (mean / length) ** power)
        numbers[line] = 1.0 + strength * (gain - 1.0)
    for line in range(LINES - 1):
        rise = numbers[line + 1] - numbers[line]
        gains[0, line] = numbers[line] - line * rise
        gains[1, line] = rise


@uncounted(error_model="numpy", apart=True)
def _give_by_line(n, aside, first, per_mm, reach, gains, fraction):
    """Multiply the fractions of vertices by what the lines on which they lie get.

    The middle of the first line lies at `first` mm across the way, and vertices stand for `reach`
    mm to either side: of one at a flank, the line in the middle of what is covered counts. Between
    the middles of a line and the next, a gain is that of the first of a pair of `gains`, and so
    many times as the place says that of the second.
    """
    middle, scale, half = np.float32(first), np.float32(per_mm), np.float32(reach * per_mm)
    starts, rises, last = gains[0], gains[1], np.float32(LINES - 1.001)
    left, right = np.float32(-0.5), np.float32(LINES - 0.5)  # flanks
    for k in range(n):
        at = (aside[k] - middle) * scale
        at = np.float32(0.5) * (max(at - half, left) + min(at + half, right))
        at = min(max(at, np.float32(0.0)), last)
        line = np.uint32(np.int32(at)) & np.uint32(LINES - 1)
        fraction[k] *= starts[line] + at * rises[line]


@uncounted(error_model="numpy")
def level_film(before, after, wet, contact, field, ink, n, scratch):
    """Level what a sweep leaves to an even film across the way, as far as the tuft is wet.

    On paper bundles of hairs show in it.

    Parameters
    ----------
    before, after : Stamp
    wet : float
        See `wetness`.
    contact : DryContact
        Where bundles are.
    field, ink : SurfaceField, InkField
    n : int
        Vertices in `scratch.found`; their fractions are changed.
    scratch : Scratch

    Returns
    -------
    bool
        Whether they were.
    """
    values, found, drinks = after.values[0], scratch.found, absorbency(ink)
    if drinks > 0.0:  # on a glaze nobody reads it
        found.brings[:n] = 1.0
    if before.values[0].touches <= 0.0 or values.touches <= 0.0 or values.tip <= values.heel:
        return False
    evens = min(1.0, (wet - _RUNS_DRY[0]) / (_RUNS_DRY[1] - _RUNS_DRY[0]))
    carried = find_way(before, after)[0]
    if evens <= 0.0 or carried <= 0.0:
        return False
    evens *= carried
    chords, gains = scratch.chords, scratch.gains
    flanks, cuts = chords.flanks[1], chords.cuts
    at, enters, leaves, numbers = cuts[0], cuts[1], cuts[2], cuts[3]
    apart = (flanks[2] - flanks[0]) / LINES
    for line in range(LINES):
        at[line] = flanks[0] + (line + 0.5) * apart
    cut_outline(chords.points[1], at, LINES, 1.0 / apart, enters, leaves)
    power = _ON_GLAZE + ink.transfer[0].grain * (_ON_GRAIN - _ON_GLAZE)
    _fill_gains(enters, leaves, evens, power, numbers, gains)
    reach = 0.5 * field.soft_edge
    _give_by_line(n, found.aside, at[0], 1.0 / apart, reach, gains, found.fraction)
    if drinks > 0.0:
        full = min(1.0, max(0.0, (wet - 1.0) / (_FULL - 1.0)))
        strength = evens * drinks * (_STREAKS + full * (_STREAKS_FULL - _STREAKS))
        weigh_streaks(strength, contact, after, found, n, ink, scratch.block)
    return True


# --------------------------------------------------------------------------------------------------


# ---- Ink as kernels see it -----------------------------------------------------------------------
# The ink on vertices and in the brush as kernels see it.


TRANSFER = np.dtype(
    [
        ("pickup", "f8"),  # fraction of the wet ink under it that a brush takes per mm, at pe = 1
        ("grain", "f8"),  # of the surface's material, 0 to 1
        ("capacity", "f8"),  # ink in a full brush, coats x mm2
        ("tooth_mm", "f8"),  # length of that surface's bumps, 0 for none
        ("reservoir_mm", "f8"),  # length of the tuft that one reservoir of its load stands for
        ("water", "f8"),  # column of water among the pigments, -1 for none
    ],
    align=True,
)
"""What decides how ink passes between the brush and the surface."""


class InkField(NamedTuple):
    """Arrays by which kernels leave ink on vertices (cap: capacity for vertices, P: pigments)."""

    amounts: NDArray  # (cap, P) float32, full coats x fraction of the vertex's area that is covered
    coverage: NDArray  # (cap,) float32, fraction of the vertex's area under paint, 0 to 1
    dirty: NDArray  # (cap,) uint8, 1 where the colour is out of date
    dirty_ids: NDArray  # (cap + 1,) int32, those vertices; one more is written before it counts
    n_dirty: NDArray  # (1,) int64, how many
    load: NDArray  # (P,) float64, ink in the brush, coats x mm2
    off_surface: NDArray  # (P,) float64, ink that ran off the surface, coats x mm2
    reservoirs: NDArray  # (N, P) float64, the load along the tuft, tip first; N = 1: alike all over
    transfer: NDArray  # (1,) of TRANSFER
    noise: NDArray  # (64^3,) int8, of the tooth: see `dry_contact.fill_noise`
    bundles: NDArray  # (2, 64^2) int32, and of bundles: see `dry_contact.bundle_noise`


# --------------------------------------------------------------------------------------------------


_DRY_AT = 0.8  # fraction of a full load below which a light brush on grain 1 begins to skip
_DRY_PRESSED = 0.4  # less of it at full pressure
FADING = 0.1  # k of equation (10a): the larger, the paler a brush writes on paper as it empties
FILM = 0.35  # of equation (12a): pressure under which a way as long as the root is wide gives it
FILM_FRACTION = 0.6  # of equation (12a): how much less a wet tuft gives on the way for its film
_DRY_FILM = 0.5  # of that film, what a tuft leaves that hardly reaches the grain
_FILM_MOST = 0.1  # fraction of what the tuft holds that goes into films in one sweep at most
_TRACE = 0.025  # fraction of pigment in a liquid at which a count by it is halved
_FED_MM = 1.0  # way on which it puts back all but 1 / e of what has run from under it
_SATURATED = 0.9  # coats, h of equation (12b), at which paper takes half of what comes on the way
_POOLED = 0.25  # how much more the middle of a tuft's liquid gives than its rim
# speed of a hand at which h is that, the power it falls with, and the least speed that counts
_EVEN_MM_S, _LINGERS, _SLOWEST_MM_S = 60.0, 0.25, 4.0
_LEAST_COVERED = 1.0 / 16.0  # of a vertex's area: what ink lies on counts as no less
_LEAST_WIDTH = 1e-6  # mm, of a tuft whose liquid is looked for
_NOTHING = 1e-6  # fraction of a film
_MOST_PASSES = 1000
_FRACTION = 0.45  # of a reservoir, the most that flows out of it on one side in one pass
PAINTED = 3  # counter: vertices that ink was left on
_NOTED = 256  # vertices that are looked through together for such as have not been noted yet


@uncounted(error_model="numpy")
def mean_pressure(before, after):
    """Mean pressure on the way between two stamps, 0 to 1."""
    pressure = 0.0
    for values in (before.values[0], after.values[0]):
        if values.touches > 0.0:
            pressure += 0.5 * values.pressure
    return pressure


@uncounted(error_model="numpy")
def held_ink(ink):
    """Ink in the brush, coats x mm2."""
    total = 0.0
    for p in range(ink.load.shape[0]):
        total += ink.load[p]
    return total


@uncounted(error_model="numpy")
def wetness(before, after, ink):
    """Load of the brush over that below which it begins to skip; 2 where it never does.

    A full brush floods the grain; one that runs dry touches only what stands out (feibai), and so
    does a fuller one that goes faster than ink can follow from the belly; what is nearly dry has
    less to lose by it. Up to 1 it is how deep into the grain the tuft reaches, the contact level.
    """
    transfer = ink.transfer[0]
    if transfer.grain <= 0.0 or transfer.capacity <= 0.0:
        return 2.0
    begins = transfer.grain * (_DRY_AT - _DRY_PRESSED * mean_pressure(before, after))
    level = held_ink(ink) / (transfer.capacity * begins)
    haste = after.values[0].haste
    return level / (1.0 + haste * haste * min(1.0, level))


@uncounted(error_model="numpy")
def absorbency(ink):
    """Degree to which the material's pores draw ink: 0 on a glaze, 1 from a grain of .5 on."""
    return min(1.0, 2.0 * ink.transfer[0].grain)


@uncounted(error_model="numpy")
def drawn_rate(rate, ink):
    """The y of docs/model.md, equation (10a): a tuft leaves 1 - exp(-y) of its ink.

    Found by Newton's steps, which come from below; on a glaze it is `rate`, eta' pe ds.
    """
    capacity, draws = ink.transfer[0].capacity, absorbency(ink)
    if draws <= 0.0 or capacity <= 0.0:
        return rate
    k = FADING / draws
    f = min(1.0, held_ink(ink) / capacity)
    wanted = (1.0 + k) * rate
    y = wanted / (k + f)
    for _ in range(8):
        missing = wanted - k * y + f * np.expm1(-y)
        y += missing / (k + f * np.exp(-y))
        if missing <= 1e-12 * wanted:
            break
    return y


@uncounted(error_model="numpy")
def first_film(level, transfer_per_mm, root_mm, ink):
    """Coats that a tuft leaves at once where it comes first: docs/model.md, equation (12a)."""
    film = FILM * _film_kept(level)
    return film * drawn_rate(transfer_per_mm / root_mm, ink) * held_ink(ink)


@uncounted(error_model="numpy")
def given_on_way(level):
    """Fraction of what equation (10) gives that is left for the way, beside the first film."""
    return 1.0 - FILM_FRACTION * _film_kept(level)


@uncounted(error_model="numpy")
def _film_kept(level):
    """Fraction of a wet tuft's film that one that runs dry leaves where it touches."""
    return _DRY_FILM + (1.0 - _DRY_FILM) * level


@uncounted(error_model="numpy")
def fetch_found(found, n, values, out):
    """Fill the values that vertices found have; `values` holds those of all."""
    fetch(found.runs, found.count[0], found.ids, n, values, out)


@uncounted(error_model="numpy")
def fetch_positions(found, n, field):
    """Fill where the vertices found are, mm."""
    fetch_found(found, n, field.px, found.px)
    fetch_found(found, n, field.py, found.py)
    fetch_found(found, n, field.pz, found.pz)


@uncounted(error_model="numpy", apart=True)
def _fetch_coats(runs, n_runs, ids, n, amounts, coats):
    """Fill how much wet ink lies on vertices, of all pigments, coats times the covered fraction."""
    if amounts.shape[1] == 1:
        fetch(runs, n_runs, ids, n, amounts.reshape(amounts.size), coats)
        return
    for k in range(n):
        coats[k] = np.float32(0.0)
    for p in range(amounts.shape[1]):
        for k in range(n):
            coats[k] += amounts[as_index(ids[k]), p]


@uncounted(error_model="numpy")
def _count_drained(before, after, found, n, field, ink):
    """Count the liquid with which the ink on vertices came: its water, once in the paper, is gone.

    What lies on a vertex counts as so much of the liquid that the tuft holds where it touches it
    (of single hairs their mean) as brings those pigments, by least squares; a tuft of water with a
    trace of pigment tells nothing. `found.coats` only grows.
    """
    ids, coats, reservoirs = found.ids, found.coats, ink.reservoirs
    count, n_pigments = reservoirs.shape
    last, reach, water = count - 1, ink.transfer[0].reservoir_mm, ink.transfer[0].water
    i, t = 0, 0.0
    for k in range(n):
        v = as_index(ids[k])
        if count > 1:
            at = _reservoir(before, after, field, v, reach, last)
            i = min(np.int64(at), last - 1)
            t = at - i
        total, along, squared = 0.0, 0.0, 0.0
        for p in range(n_pigments):
            held = ink.load[p]
            if count > 1:
                held = (1.0 - t) * reservoirs[i, p] + t * reservoirs[i + 1, p]
            total += held
            if p != water:
                along += held * ink.amounts[v, p]
                squared += held * held
        if squared > 0.0:
            fourth = squared * squared
            weight = fourth / (fourth + (_TRACE * total) ** 4)
            coats[k] = max(coats[k], np.float32(weight * along / squared * total))


@uncounted(error_model="numpy", apart=True)
def _find_liquid(n, ahead, aside, turn, values, lines, heights):
    """Fill how high a tuft's liquid stands over vertices: 1 in an outline's middle, 0 outside.

    Where they lie along the way and across is given, and the turn from there to a stamp, which
    touches; `values` and `lines` are the stamp's.
    """
    turn_x, turn_y, cosine, sine = turn
    ox, oy, c, s = np.float32(turn_x), np.float32(turn_y), np.float32(cosine), np.float32(sine)
    heel, per_length = np.float32(values.heel), np.float32(1.0 / (values.tip - values.heel))
    cells, last = np.float32(PROFILE_CELLS), np.float32(LAST_PLACE)
    zero, one, four = np.float32(0.0), np.float32(1.0), np.float32(4.0)
    least, starts, rises = np.float32(_LEAST_WIDTH), lines[0], lines[1]
    for k in range(n):
        dx, dy = ahead[k] - ox, aside[k] - oy
        part = (c * dx + s * dy - heel) * per_length
        at = min(max(part * cells, zero), last)
        i = profile_cell(at)
        width = max(starts[i] + at * rises[i], least)
        side = (c * dy - s * dx) / width
        height = four * part * (one - part) * (one - side * side)
        over = (part > zero) & (part < one) & (side * side < one)
        heights[k] = height if over else zero


@uncounted(error_model="numpy")
def _find_heights(turn, stamp, found, n):
    """Fill how high the liquid of a stamp's tuft stands over vertices; 0 if it does not touch."""
    if stamp.values[0].touches > 0.0:
        _find_liquid(
            n, found.ahead, found.aside, (turn[0], turn[1], turn[2], turn[3]), stamp.values[0],
            stamp.lines, found.heights,
        )  # fmt: skip
    else:
        found.heights[:n] = 0.0


@uncounted(error_model="numpy", apart=True)
def _take_less(n, take, coats, covered, heights, brings, draws, per_coat, fraction):
    """Reduce what wet paper takes: docs/model.md, equation (12b)."""
    one, half, pooled = np.float32(1.0), np.float32(0.5), np.float32(_POOLED)
    least = np.float32(_LEAST_COVERED)
    for k in range(n):
        stands = (one + pooled * (heights[k] - half)) * brings[k]
        takes = take[k]
        wet = coats[k] * per_coat / (takes * takes * stands * max(covered[k], least))
        wet2 = wet * wet
        wet4 = wet2 * wet2
        wet8 = wet4 * wet4
        fraction[k] *= one - draws * wet8 / (one + wet8)


@uncounted(error_model="numpy")
def _saturate(after, sweep, found, n, ink):
    """Reduce what wet paper takes of what comes on the way: docs/model.md, equation (12b).

    So a stroke that crosses a wet one runs into it and does not lie on it like a film, and where
    the brush dwells no more comes than the sheet holds. Nothing changes on a glaze: False.
    """
    draws = np.float32(absorbency(ink))
    if draws <= 0.0:
        return False
    speed = max(after.values[0].speed, _SLOWEST_MM_S)
    per_coat = np.float32((speed / _EVEN_MM_S) ** _LINGERS / _SATURATED)
    _find_heights(sweep.to_after, after, found, n)
    _take_less(
        n, found.take, found.coats, found.covered, found.heights, found.brings, draws, per_coat,
        found.fraction,
    )  # fmt: skip
    return True


@uncounted(error_model="numpy", apart=True)
def _find_lacking(n, film, cover, take, covered, coats, lacks):
    """Fill coats of a first film that vertices lack, times the newly covered fraction of area.

    `coats`, what lies on each, becomes what it falls short of the film where it was covered
    already. Returns whether any does.
    """
    zero, short = np.float32(0.0), np.int32(0)
    for k in range(n):
        whole = film * take[k]
        lacks[k] = whole * max(zero, cover[k] - covered[k])
        coats[k] = whole * min(cover[k], covered[k]) - coats[k]
        short = max(short, np.int32(coats[k] > zero))
    return short > 0


@uncounted(error_model="numpy", apart=True)
def _add_short(n, film, fed, cover, take, covered, coats, begun, lacks):
    """Add what vertices fall short of a film, though they were covered already.

    Where the tuft comes it leaves its film, and of what has run from under it since it puts back
    the fraction `fed`; `begun` is what it covered of each when the sweep began.
    """
    zero, part = np.float32(0.0), np.float32(fed)
    for k in range(n):
        comes = film * take[k] * (min(cover[k], covered[k]) - begun[k])
        lacks[k] += max(zero, min(coats[k], max(comes, part * coats[k])))


@uncounted(error_model="numpy")
def _lay_first_film(coats, unit, before, after, found, n, field, ink, scratch):
    """Lay a film at once where the tuft comes to, however lightly and briefly it is touched.

    What is newly covered lacks all of it; where ink ran ahead of the tuft, or has dried, what comes
    under the tuft lacks what that falls short of it.

    Parameters
    ----------
    coats : float
        Of the film.
    unit : float
        Coats that a fraction of 1 gets of what is given on the way; 0 where nothing is.
    before, after : Stamp
        What lies under the first has got its film.
    found : Found
        The first `n` of it; their fractions grow.
    n, field, ink, scratch : as for `level_film`

    Returns
    -------
    float
        What it takes, coats x mm2; a small part of what the tuft holds at most.
    """
    fraction, lacks = found.fraction, found.lacks
    film = np.float32(coats)
    if _find_lacking(n, film, found.cover, found.take, found.covered, found.coats, lacks):
        begun = found.heights
        if before.values[0].touches > 0.0:
            sweep, chords = scratch.sweep[0], scratch.chords
            find_begun(
                n, sweep.scale, chords.flanks[0], chords.grids[0], chords.lines[0], found.ahead,
                found.aside, begun,
            )  # fmt: skip
        else:
            begun[:n] = 0.0
        alike = ink.transfer[0].pickup <= 0.0 and ink.reservoirs.shape[0] == 1
        fed = -np.expm1(-ink_way(before, after) / _FED_MM) if alike else 0.0
        _add_short(
            n, film, fed, found.cover, found.take, found.covered, found.coats, begun, lacks
        )  # fmt: skip
    lacking = weighed_area(n, found.area, lacks, field.area_step)
    if lacking <= 0.0:
        return 0.0
    most = _FILM_MOST * held_ink(ink)
    # where next to nothing is given on the way, that is shared out as the film is
    goes_on = unit > _NOTHING * coats
    kept = np.float32(1.0 if goes_on else 0.0)
    per_coat = np.float32(min(1.0, most / lacking) / (unit if goes_on else 1.0))
    for k in range(n):
        fraction[k] = kept * fraction[k] + per_coat * lacks[k]
    return min(lacking, most)


@uncounted(error_model="numpy")
def take_in(coats, before, after, landing, weighed, n, field, ink, scratch):
    """Take in what lands on the way and the first film; the weights of vertices are changed.

    Parameters
    ----------
    coats : float
        Of the first film.
    before, after : Stamp
        Where the sweep begins and ends.
    landing, weighed : float
        Of what is given on the way, coats x mm2, and the area that it is shared by, mm2.
    n, field, ink, scratch : as for `level_film`

    Returns
    -------
    rest, first : float
        How much of what lands on the way is taken in, 0 to 1, and of the film, coats x mm2.
    weighed : float
        The area that is shared by now.
    """
    rest, whole, found = 1.0, weighed, scratch.found
    fetch_found(found, n, field.take, found.take)
    fetch_found(found, n, ink.coverage, found.covered)
    _fetch_coats(found.runs, found.count[0], found.ids, n, ink.amounts, found.coats)
    if ink.transfer[0].water >= 0:
        _count_drained(before, after, found, n, field, ink)
    if landing > 0.0 and _saturate(after, scratch.sweep[0], found, n, ink):
        weighed = weighed_area(n, found.area, found.fraction, field.area_step)
        rest = weighed / whole
    first = _lay_first_film(coats, landing / whole, before, after, found, n, field, ink, scratch)
    if first > 0.0:
        weighed = weighed_area(n, found.area, found.fraction, field.area_step)
    return rest, first, weighed


@uncounted(error_model="numpy")
def take_up_ink(before, after, released, found, n, field, ink, taken):
    """Take wet ink from the vertices that a brush passes; fill `taken` (P,), coats x mm2.

    A fraction 1 - exp(-rate pe ds) of what is there, ds the way over the vertex (mm): any cutting
    of the way takes the same. Never more than there is, nor than the brush has capacity for after
    it has given `released`.
    """
    ids, fraction, areas, unit = found.ids, found.fraction, field.area_units, field.area_unit
    rate = ink.transfer[0].pickup * mean_pressure(before, after) * outline_motion(before, after)
    n_pigments = ink.load.shape[0]
    held = held_ink(ink)
    for p in range(n_pigments):
        taken[p] = 0.0
    within = 0.0
    for k in range(n):
        v = ids[k]
        part = 1.0 - np.exp(-rate * min(1.0, np.float64(fraction[k])))
        here = 0.0
        for p in range(n_pigments):
            here += ink.amounts[v, p]
        within += part * here * areas[v] * unit
    if within <= 0.0:
        return
    capacity_left = max(0.0, ink.transfer[0].capacity - held + released)
    scale = min(1.0, capacity_left / within)
    for k in range(n):
        v = ids[k]
        part = scale * (1.0 - np.exp(-rate * min(1.0, np.float64(fraction[k]))))
        for p in range(n_pigments):
            old = ink.amounts[v, p]
            new = np.float32(old * (1.0 - part))
            ink.amounts[v, p] = new
            taken[p] += (np.float64(old) - np.float64(new)) * areas[v] * unit


@uncounted(error_model="numpy")
def _ink_released(before, after, tuft, ink):
    """Ink that leaves the brush on the way between two stamps: R (1 - exp(-eta' pe ds)).

    docs/model.md, equation (10), the continuous form of Guo 2017, Eqs. 12-13, which one step of
    unit length gives back; `ds` is the way that ink is given for (`ink_way`, mm).
    """
    drawn = tuft.transfer_per_mm * mean_pressure(before, after) * ink_way(before, after)
    total = held_ink(ink)
    return total, -total * np.expm1(-drawn_rate(drawn, ink))


@uncounted(error_model="numpy")
def landing_fraction(area, width, weighed_area):
    """Fraction of the released ink that meets surface; the rest runs off its edge.

    The vertices stand for the area only to within a seam of half their spacing; a shortfall no
    larger than that is not a gap.
    """
    if weighed_area <= 0.0:
        return 0.0
    slack = 0.1 + width / np.sqrt(area)
    if slack >= 0.9:
        return 1.0
    return min(1.0, weighed_area / area / (1.0 - slack))


@uncounted(error_model="numpy")
def add_ink(found, n, fraction, coats, amounts, p):
    """Add so many coats, times its fraction, to what every vertex found has of pigment p."""
    _add_coats(
        found.runs, found.count[0], found.ids, n, fraction, coats, amounts.reshape(amounts.size),
        amounts.shape[1], p,
    )  # fmt: skip


@uncounted(error_model="numpy", apart=True)
def _add_coats(runs, n_runs, ids, n, fraction, coats, amounts, stride, p):
    """`add_ink` for arrays; the amounts of a pigment are `stride` apart."""
    at = 0
    for r in range(n_runs):
        first, many = runs[r, 0], runs[r, 1]
        own, target = fraction[at : at + many], amounts[first * stride : (first + many) * stride]
        if stride == 1:
            for k in range(many):
                target[k] += coats * own[k]
        else:
            for k in range(many):
                target[k * stride + p] += coats * own[k]
        at += many
    for k in range(at, n):
        amounts[np.int64(ids[k]) * stride + p] += coats * fraction[k]


@uncounted(error_model="numpy")
def _leave_ink(found, n, part, ink):
    """Add every vertex's fraction of each pigment, `part` (P,) of it, and note what is covered."""
    for p in range(part.shape[0]):
        coats = np.float32(part[p])
        if coats != 0.0:
            add_ink(found, n, found.fraction, coats, ink.amounts, p)
    return note_covered(found, n, ink)


@uncounted(error_model="numpy")
def note_covered(found, n, ink):
    """Note how much of each vertex's area is covered, and whose colour is out of date.

    Returns how many vertices got paint.
    """
    painted, ink.n_dirty[0] = _note(
        found.runs, found.count[0], found.ids, n, found.cover, ink.coverage, ink.dirty,
        ink.dirty_ids, ink.n_dirty[0],
    )  # fmt: skip
    return painted


@uncounted(error_model="numpy", apart=True)
def _note(runs, n_runs, ids, n, cover, coverage, dirty, dirty_ids, count):
    """`note_covered` for arrays; also returns how many colours are out of date then."""
    zero, at, painted = np.float32(0.0), 0, 0
    for r in range(n_runs):
        for begin in range(0, runs[r, 1], _NOTED):
            first, many = runs[r, 0] + begin, min(_NOTED, runs[r, 1] - begin)
            last = first + many
            own, covered, marks = cover[at : at + many], coverage[first:last], dirty[first:last]
            touched, fresh = np.int32(0), np.int32(0)
            for k in range(many):
                # one maximum more, or it is stored only where it is larger, which is slow
                covered[k] = max(max(covered[k], own[k]), zero)
            for k in range(many):
                here = own[k] > zero
                touched = np.int32(touched + np.int32(here))
                fresh = np.int32(fresh | np.int32(here & (marks[k] == 0)))
            painted += touched
            if fresh > 0:
                for k in range(many):  # without a branch, which would be taken now and then
                    is_fresh = (own[k] > zero) & (marks[k] == 0)
                    marks[k] |= np.uint8(is_fresh)
                    dirty_ids[count] = first + k
                    count += np.int64(is_fresh)
            at += many
    for k in range(at, n):
        if cover[k] > zero:
            v = ids[k]
            coverage[v] = max(coverage[v], cover[k])
            painted += 1
            if dirty[v] == 0:
                dirty[v] = 1
                dirty_ids[count] = v
                count += 1
    return painted, count


@uncounted(error_model="numpy")
def forget_dirty(ids, dirty):
    """Unmark vertices (N,) int32 whose colours have been brought up to date."""
    for k in range(ids.size):
        dirty[as_index(ids[k])] = 0


@uncounted(error_model="numpy")
def _behind_tip(values, field, v):
    """Distance (mm) of a vertex behind the tip of a stamp, along the bend."""
    dx = field.px[v] - values.origin[0]
    dy = field.py[v] - values.origin[1]
    dz = field.pz[v] - values.origin[2]
    reach = dx * values.bend[0] + dy * values.bend[1] + dz * values.bend[2]
    return values.tip - reach


@uncounted(error_model="numpy")
def _reservoir(before, after, field, v, reach, last):
    """Place of a vertex on the tuft, in reservoirs from the tip: middle of the first is 0."""
    a, b = before.values[0], after.values[0]
    if a.touches > 0.0 and b.touches > 0.0:
        behind = 0.5 * (_behind_tip(a, field, v) + _behind_tip(b, field, v))
    elif b.touches > 0.0:
        behind = _behind_tip(b, field, v)
    else:
        behind = _behind_tip(a, field, v)
    return min(max(behind / reach - 0.5, 0.0), np.float64(last))


class Deposit(NamedTuple):
    """Ink that a brush gives on its way from one stamp to the next, coats x mm2."""

    released: float  # what leaves it
    landing: float  # what of that lands on vertices; the rest runs off the surface's edge
    weighed: float  # mm2, the area that those stand for


@kernel(error_model="numpy")
def leave_from_reservoirs(before, after, deposit, found, n, field, ink, taken):
    """Leave what lands of a deposit on the vertices found, each from the reservoirs that touch it.

    The rest of it runs off; `taken` (P,) that the brush took up meanwhile goes to where it touches.
    Conserves: the reservoirs, what was left and what ran off add up.
    """
    reservoirs = ink.reservoirs
    count, n_pigments = reservoirs.shape
    last = count - 1
    reach = ink.transfer[0].reservoir_mm
    ids, fraction, areas, unit = found.ids, found.fraction, field.area_units, field.area_unit
    amounts = ink.amounts
    demand = np.zeros(count)
    for k in range(n):
        v = ids[k]
        at = _reservoir(before, after, field, v, reach, last)
        i = min(np.int64(at), last - 1)
        part = fraction[k] * areas[v] * unit
        demand[i] += part * (1.0 - (at - i))
        demand[i + 1] += part * (at - i)
    total = demand.sum()
    if total <= 0.0:
        demand[0] = 1.0
        total = 1.0
    density = np.zeros((count, n_pigments))  # left per weighed mm2, by reservoir
    for i in range(count):
        wanted = deposit.released * demand[i] / total
        held = reservoirs[i].sum()
        given = min(wanted, held)
        if given <= 0.0:
            continue
        landed = given * (deposit.landing / deposit.released)
        for p in range(n_pigments):
            part = reservoirs[i, p] / held
            ink.off_surface[p] += part * (given - landed)
            density[i, p] = part * landed / demand[i] if deposit.weighed > 0.0 else 0.0
            reservoirs[i, p] -= part * given
    for k in range(n):
        v = ids[k]
        at = _reservoir(before, after, field, v, reach, last)
        i = min(np.int64(at), last - 1)
        t = at - i
        for p in range(n_pigments):
            amounts[v, p] += np.float32(
                fraction[k] * ((1.0 - t) * density[i, p] + t * density[i + 1, p])
            )
    for i in range(count):
        for p in range(n_pigments):
            reservoirs[i, p] += taken[p] * demand[i] / total
    level_reservoirs(reservoirs)
    for p in range(n_pigments):
        ink.load[p] = reservoirs[:, p].sum()


@kernel(error_model="numpy")
def level_reservoirs(reservoirs):
    """Level the liquid along the tuft until all reservoirs (N, P) are filled alike."""
    count, n_pigments = reservoirs.shape
    held = np.empty(count)
    passing = np.empty(count - 1)  # from reservoir i + 1 to reservoir i
    for _ in range(_MOST_PASSES):
        for i in range(count):
            held[i] = reservoirs[i].sum()
        mean = held.sum() / count
        towards_tip = 0.0
        held_back = False
        for i in range(count - 1):
            towards_tip += mean - held[i]
            source = i + 1 if towards_tip > 0.0 else i
            most = _FRACTION * held[source]
            passing[i] = min(max(towards_tip, -most), most)
            held_back = held_back or abs(towards_tip) > most
        old = reservoirs.copy()
        for i in range(count - 1):
            source = i + 1 if passing[i] > 0.0 else i
            if held[source] <= 0.0:
                continue
            for p in range(n_pigments):
                moved = passing[i] * old[source, p] / held[source]
                reservoirs[i, p] += moved
                reservoirs[i + 1, p] -= moved
        if not held_back:
            break


@uncounted(error_model="numpy")
def sweep_deposit(before, after, tuft, field, ink, scratch):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Conserves: what leaves `ink.load` is on vertices or counted in `ink.off_surface`
    (docs/model.md, equation (11)).
    """
    width, found = field.soft_edge, scratch.found
    note_way(before, after)
    wet = wetness(before, after, ink)
    level = min(1.0, wet)
    scratch.sweep[0].wet = wet
    n = find_vertices(before, after, field, scratch)
    if n < 0:
        return False
    fetch_found(found, n, field.area, found.area)
    weighed = weighed_area(n, found.area, found.fraction, field.area_step)
    a = before.values[0]
    b = after.values[0]
    area = 0.5 * (a.area + b.area)
    if a.touches <= 0.0 or b.touches <= 0.0:
        area = max(a.area * a.touches, b.area * b.touches)
    total, released = _ink_released(before, after, tuft, ink)
    if area < width * width and weighed <= 0.0:
        released = 0.0  # a touch finer than the vertices leaves nothing yet
    released *= given_on_way(level)
    landing = released * landing_fraction(area, width, weighed)
    bundles = (tuft.diameters[-1], BUNDLE_MM, 1.0, 0.0)
    contact = dry_contact(level, find_way(before, after)[0], after, bundles, field, ink)
    if level < 1.0 or absorbency(ink) > 0.0:
        fetch_positions(found, n, field)
    scratch.taken[:] = 0.0
    if ink.transfer[0].pickup > 0.0:  # the thirstier it is; wet ink stands over the depths, too
        take_up_ink(before, after, released, found, n, field, ink, scratch.taken)
    if level < 1.0 and weighed > 0.0:  # a brush that runs dry gives less, and only to the heights
        thin_contact(contact, after, found, n, ink, scratch.block)
        whole = weighed
        weighed = weighed_area(n, found.area, found.fraction, field.area_step)
        released *= weighed / whole
        landing *= weighed / whole
    if weighed <= 0.0:
        landing = 0.0
    scratch.part[:] = 0.0
    if level_film(before, after, wet, contact, field, ink, n, scratch):
        weighed = weighed_area(n, found.area, found.fraction, field.area_step)
    if weighed > 0.0:
        coats = first_film(level, tuft.transfer_per_mm, tuft.diameters[-1], ink)
        rest, first, weighed = take_in(
            coats, before, after, landing, weighed, n, field, ink, scratch
        )
        released, landing = rest * released + first, rest * landing + first
    if ink.reservoirs.shape[0] > 1:
        deposit = Deposit(released, landing, weighed)
        leave_from_reservoirs(before, after, deposit, found, n, field, ink, scratch.taken)
    elif total > 0.0:
        for p in range(ink.load.shape[0]):
            part = ink.load[p] / total
            ink.off_surface[p] += part * (released - landing)
            scratch.part[p] = part * landing / weighed if weighed > 0.0 else 0.0
            ink.load[p] -= part * released
    if ink.transfer[0].pickup > 0.0 and ink.reservoirs.shape[0] <= 1:
        for p in range(ink.load.shape[0]):
            ink.load[p] += scratch.taken[p]
    scratch.counters[PAINTED] += _leave_ink(found, n, scratch.part, ink)
    return True

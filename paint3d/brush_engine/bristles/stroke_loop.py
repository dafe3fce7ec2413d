"""A stroke with a tuft of hairs: place, bend, draw the imprint, sweep, deposit.

As `brush_engine.stroke_loop`, but the way between two samples is cut by the fastest hair: no two
imprints lie further apart than the surface's vertices, wherever in the tuft that is measured, and
also while the brush turns on the spot or is pressed. The steps follow one another: one that went
too far is halved and taken again.

All hairs follow from what `fill_bend` is given. While those numbers have hardly changed, and the
tuft has gone less than half a millimetre or so, the hairs are not bent and drawn anew: the imprint
is the last one, carried along.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.bend import (
    ARCS,
    BLOCK,
    SAMPLES,
    Cause,
    bend_hairs,
    fill_bend,
    find_clumps,
    turn_hairs,
)
from paint3d.brush_engine.bristles.contact import find_contacts, find_landings
from paint3d.brush_engine.bristles.ground_fit import fit_patch
from paint3d.brush_engine.bristles.imprint import SUB, draw_imprint, hold_outline
from paint3d.brush_engine.bristles.ink_transfer import (
    ask_hairs,
    know_hairs,
    settle_deposits,
    sweep_hairs,
)
from paint3d.brush_engine.bristles.state import CAUSES, TRACKED, TRACKED_POINTS
from paint3d.brush_engine.footprint import ink_way, outline_motion
from paint3d.brush_engine.ink_transfer import absorbency, drawn_rate, held_ink, mean_pressure
from paint3d.brush_engine.stroke_loop import (
    FINISHED,
    FOOTPRINTS,
    NEEDS_ROOM,
    copy_stamp,
    end_interval,
    foot_motion,
    next_interval,
    place_at,
)
from paint3d.core.kernel import kernel, uncounted
from paint3d.core.quaternion import compiled_x_axis

__all__ = ["paint_with_hairs"]

_SPACING = 0.95  # of the vertex spacing: the most that a hair moves from imprint to imprint
_NEAR = 0.5  # mm over the surface: nearer points of hairs count
_SHORTEST = 1.0 / 128.0  # of the way between two samples
_EASE = 1.6  # how much a step may grow on the last
_PARTS_OVER = 6.0  # mm of way over which clumps part
_SPLITS_OVER = 4.0  # mm against the hairs over which it splits
_JOINS_OVER = 25.0  # mm over which wet ones join
_SETS_OVER = 12.0  # mm of way over which a tuft takes on the bend that it has
_SET_FRACTION = 0.3  # of the tip's reach that a tuft keeps at full plasticity
_FINEST = 0.25  # of the vertex spacing: nothing finer is drawn
_LEAST_TURN = 4e-3  # cosine and sine: less than that the tuft does not turn in the handle
_DRY = (0.12, 0.45)  # of the load: dry, and wet
_SAME_CLUMPS = 1e-4  # that the sum of their middles differs at the most: rounding
_MOST_WAY = 0.6  # mm: what hairs hold, and how ready they are to give it, changes slowly
_MOST_BEND = 1.0 / 8.0  # of the vertex spacing


@uncounted(error_model="numpy")
def _wetness(ink):
    """Wetness of the tuft, from 0, dry, to 1."""
    capacity = ink.transfer[0].capacity
    wetness = held_ink(ink) / capacity if capacity > 0.0 else 0.0
    return min(1.0, max(0.0, (wetness - _DRY[0]) / (_DRY[1] - _DRY[0])))


@uncounted(error_model="numpy")
def _find_roll(pose, values):
    """Direction of the bend in the handle's axes, laid into the plane."""
    ax, ay, az = compiled_x_axis((pose[3], pose[4], pose[5], pose[6]))
    c = ax * values.bend[0] + ay * values.bend[1] + az * values.bend[2]
    s = 0.0
    for axis, part in enumerate((ax, ay, az)):
        s += part * values.cross[axis]
    norm = np.hypot(c, s)
    if norm < 1e-9:
        c, s, norm = 1.0, 0.0, 1.0
    return c / norm, -s / norm


@kernel(error_model="numpy")
def _find_slopes(tuft, points, slopes):
    """Slope of the tuft at its points, from its first hair: half of the pieces above and below."""
    for k in range(SAMPLES):
        low, high = max(k - 1, 0), min(k + 1, SAMPLES - 1)
        rise = points[0, high, 2 * points.shape[2] // 3] - points[0, low, 2 * points.shape[2] // 3]
        slopes[k] = rise / (tuft.length * (ARCS[high] - ARCS[low]))


@uncounted(error_model="numpy")
def _meet(stamp, tuft, hairs):
    """Find where the hairs touch; a stamp where none does no longer touches."""
    _find_slopes(tuft, hairs.points, hairs.slopes)
    find_landings(tuft, hairs.bend[0], hairs.landing)
    touching = find_contacts(hairs)
    if touching == 0:
        stamp.values[0].touches = 0.0
    return touching


@uncounted(error_model="numpy")
def _find_cause(values, tuft, cosine, sine, hairs, ink):
    """Cause of the bend of the hairs under a stamp, with the bend at this angle in the handle."""
    # how deep the tuft is pressed counts from where its straight tip touches, as in `_settle`
    patch, reach = hairs.patch, tuft.length * np.cos(values.tilt)
    patch[0] = -reach * (patch[1] + reach * patch[3])
    memory = hairs.memory[0]
    set_x = cosine * memory.set_x + sine * memory.set_y
    set_y = cosine * memory.set_y - sine * memory.set_x
    return Cause(
        values.descent, values.tilt, values.pressure, patch, 1.0 - _wetness(ink), memory.parted,
        memory.split, set_x, set_y,
    )  # fmt: skip


@kernel(error_model="numpy")
def _note_cache_key(cause, values, tuft, kept):
    """Note what the hairs under a stamp would be bent by, in mm at the border of the tuft."""
    patch, radius, now = cause.patch, values.radius, kept.now
    now[0] = cause.descent
    now[1] = cause.tilt * tuft.length
    now[2] = cause.pressure * radius
    now[3] = tuft.spread * radius
    now[4] = patch[0]
    now[5], now[6] = patch[1] * radius, patch[2] * radius
    for k in range(3, 6):
        now[4 + k] = patch[k] * radius * radius
    now[10], now[11] = cause.dryness * radius, cause.parted * radius
    now[12], now[13] = cause.set_x, cause.set_y
    now[14], now[15] = values.bent * radius, cause.split * radius


@kernel(error_model="numpy")
def _may_keep(before, values, way_done, resolution, kept):
    """Whether the hairs may stay as they were bent last.

    Parameters
    ----------
    before : Stamp
    values : record of GEOMETRY
        Of the stamp in hand.
    way_done : float
        Of the tuft up to `before`, mm.
    resolution : float
        Vertex spacing, mm.
    kept : record of KEPT
        With the stamp's cause.
    """
    if kept.touching <= 0.0:
        return False
    way = way_done - kept.way + foot_motion(before.values[0], values)
    if way < 0.0 or way > _MOST_WAY:
        return False
    change = 0.0
    for k in range(CAUSES):
        change += abs(kept.now[k] - kept.cause[k])
    return change <= _MOST_BEND * resolution


@kernel(error_model="numpy")
def _keep_bend(before, values, way_done, touching, kept):
    """Note that the hairs were bent by the stamp's cause, and how many touch."""
    kept.touching = touching
    kept.drawn = 0.0
    kept.way = way_done + foot_motion(before.values[0], values)
    kept.cause[:] = kept.now


@kernel(error_model="numpy")
def _keep_outline(stamp, kept, lines):
    """Note the outline that was drawn."""
    values = stamp.values[0]
    kept.heel, kept.tip, kept.widest = values.heel, values.tip, values.widest
    kept.widest_at, kept.area = values.widest_at, values.area
    kept.half_widths[:] = stamp.half_widths
    lines[:] = stamp.lines
    kept.drawn = 1.0


@kernel(error_model="numpy")
def _carry_outline(stamp, kept, lines):
    """Give a stamp the outline that was drawn last."""
    values = stamp.values[0]
    values.heel, values.tip, values.widest = kept.heel, kept.tip, kept.widest
    values.widest_at, values.area = kept.widest_at, kept.area
    stamp.half_widths[:] = kept.half_widths
    stamp.lines[:] = lines
    hold_outline(values)


@kernel(error_model="numpy")
def _centre_hairs(hairs):
    """Count the hairs' places across the tuft from where it has set to."""
    points, aside = hairs.points, np.float32(hairs.bend[0].shift_y[0])
    if aside == 0.0:
        return
    for g in range(points.shape[0]):
        for k in range(SAMPLES):
            across = points[g, k, BLOCK : 2 * BLOCK]
            for j in range(BLOCK):
                across[j] -= aside


@uncounted(error_model="numpy")
def _move_aside(values, aside):
    """Move a stamp so far to the side (mm) of its bend."""
    for axis in range(3):
        values.origin[axis] += aside * values.cross[axis]


@uncounted(error_model="numpy")
def _place_hairs(pose, before, stamp, tuft, hairs, canvas, scratch):
    """Bend the hairs under a stamp that touches and find where they do; return how many.

    Where they would hardly lie otherwise, they stay as they are.
    """
    values, kept, bristles = stamp.values[0], hairs.kept[0], hairs.bristles
    way, field = hairs.memory[0].way, canvas.field
    cosine, sine = _find_roll(pose, values)
    turned = abs(cosine - hairs.roll[0]) + abs(sine - hairs.roll[1])
    same = turned < (_LEAST_TURN if kept.touching > 0.0 else 1e-6)
    if same:
        cosine, sine = hairs.roll[0], hairs.roll[1]
    fit_patch(values, field, scratch, hairs.patch_work, hairs.patch)
    cause = _find_cause(values, tuft, cosine, sine, hairs, canvas.ink)
    _note_cache_key(cause, values, tuft, kept)
    if same and _may_keep(before, values, way, field.resolution, kept):
        _move_aside(values, hairs.bend[0].shift_y[0])
        return int(kept.touching)
    if not same:
        hairs.roll[0], hairs.roll[1] = cosine, sine
        turn_hairs(bristles, cosine, sine, hairs.turned)
    fill_bend(bristles, tuft, cause, hairs.bend[0])
    bend_hairs(bristles.rests, hairs.turned, hairs.bend[0], hairs.block, hairs.points)
    touching = _meet(stamp, tuft, hairs)
    _centre_hairs(hairs)
    _move_aside(values, hairs.bend[0].shift_y[0])
    _keep_bend(before, values, way, touching, kept)
    return touching


@uncounted(error_model="numpy")
def _draw(stamp, touching, tuft, hairs, canvas, scratch):
    """Find what the hairs would give, and the imprint; return how much they wish to give."""
    count, bristles, kept = hairs.load.shape[0], hairs.bristles, hairs.kept[0]
    way, ink = hairs.memory[0].way, canvas.ink
    know_hairs(bristles, hairs.turned, hairs.roll, way, hairs.known, hairs.hair_contacts)
    full = ink.transfer[0].capacity / count  # of a hair
    draws = min(1.0, 2.0 * absorbency(ink))
    wanted, wet, dot = ask_hairs(
        bristles, hairs.load, full, draws, way, SUB, hairs.hair_contacts, hairs.sums
    )
    if kept.drawn > 0.0:
        _carry_outline(stamp, kept, hairs.kept_lines)
    else:
        finest = _FINEST * canvas.field.resolution
        draw_imprint(stamp, tuft, hairs, (touching, wet, dot), finest, scratch)
        _keep_outline(stamp, kept, hairs.kept_lines)
    return wanted


@uncounted(error_model="numpy")
def _against_hairs(last, values):
    """Distance (mm) that a tuft was pushed back towards its tip, or its tip twisted aside."""
    if last.touches <= 0.0:
        return 0.0
    pushed = 0.0
    for axis in range(3):
        pushed += (values.foot[axis] - last.foot[axis]) * values.bend[axis]
    twisted = max(0.0, abs(values.twist) - abs(last.twist))
    return max(0.0, pushed) + twisted * max(0.0, values.tip - values.heel)


@uncounted(error_model="numpy")
def _remember(before, after, tuft, hairs, ink):
    """Update the tuft by the way between two stamps: clumps part or join, it splits into
    points where it goes against its hairs, the bend sets."""
    values, memory = after.values[0], hairs.memory[0]
    way = outline_motion(before, after)
    wet = _wetness(ink)
    pe = values.pressure
    wanted = hairs.bristles.parting * min(
        1.0, (1.0 - wet) * (0.5 + 0.5 * pe) + 0.5 * max(0.0, pe - 0.7) / 0.3
    )
    memory.way += way
    over = _PARTS_OVER if wanted > memory.parted else _JOINS_OVER / max(wet, 0.02)
    memory.parted += (wanted - memory.parted) * (1.0 - np.exp(-way / over))
    against = _against_hairs(before.values[0], values)
    memory.split *= np.exp(-way * wet / _JOINS_OVER)
    splits = 1.0 - np.exp(-against / _SPLITS_OVER)
    memory.split += max(0.0, wanted - memory.split) * splits
    reach = values.tip - tuft.length * np.cos(values.tilt)
    stays = _SET_FRACTION * tuft.plasticity * max(0.0, reach)
    fraction = 1.0 - np.exp(-way / _SETS_OVER)
    memory.set_x += fraction * (hairs.roll[0] * stays - memory.set_x)
    memory.set_y += fraction * (hairs.roll[1] * stays - memory.set_y)


@uncounted(error_model="numpy")
def _track(stamp, hairs, rows):
    """Fill the positions in space of the outer hairs' points; of those on the surface or near it
    the hair's clumps too, by the sum of their middles."""
    values, points = stamp.values[0], hairs.points
    count = hairs.load.shape[0]
    for n in range(TRACKED):
        i = max(0, count - 1 - n)
        g, j = i // BLOCK, i % BLOCK
        clumps = find_clumps(hairs.turned[g], j)
        for k in range(TRACKED_POINTS):
            x, y = np.float64(points[g, k, j]), np.float64(points[g, k, BLOCK + j])
            z = np.float64(points[g, k, 2 * BLOCK + j])
            for axis in range(3):
                rows[n, k, axis] = (
                    values.origin[axis] + x * values.bend[axis]
                    + y * values.cross[axis] + z * values.normal[axis]
                )  # fmt: skip
            rows[n, k, 3] = clumps if z < _NEAR else np.nan


@kernel(error_model="numpy")  # slices are counted, which `paint_with_hairs` must not do
def _keep_track(track):
    """Record the present positions of the outer hairs."""
    track[0] = track[1]


@uncounted(error_model="numpy")
def _fastest(before, after, track):
    """Distance that the fastest hair moved on the surface between two stamps, mm.

    One that went over to other clumps does not count: while the tuft turns, hairs of parted clumps
    jump, and no step is so short that they do not.
    """
    if before.values[0].touches <= 0.0 or after.values[0].touches <= 0.0:
        return outline_motion(before, after)
    most = 0.0
    for n in range(TRACKED):
        for k in range(TRACKED_POINTS):
            if abs(track[1, n, k, 3] - track[0, n, k, 3]) < _SAME_CLUMPS:
                d2 = 0.0
                for axis in range(3):
                    d2 += (track[1, n, k, axis] - track[0, n, k, axis]) ** 2
                most = max(most, d2)
    return np.sqrt(most)


@uncounted
def _begin(samples, i, brush, canvas, progress, scratch, hairs):
    """Begin an interval: where the brush does not touch yet, with the imprint of its first pose."""
    before, pose = progress.before, scratch.pose
    hairs.pace[0], hairs.pace[1] = 0.0, 1.0
    progress.at[2] = 1
    if before.values[0].touches > 0.0:
        return
    tuft = place_at(samples, i, 0.0, brush, canvas, before, before, scratch)
    hairs.kept[0].touching = 0.0
    if before.values[0].touches > 0.0:
        touching = _place_hairs(pose, before, before, tuft, hairs, canvas, scratch)
        if touching > 0:
            _draw(before, touching, tuft, hairs, canvas, scratch)
        _track(before, hairs, hairs.track[0])
    if samples.joined[i]:
        before.values[0].touches = 0.0


@uncounted
def _find_step(samples, i, brush, canvas, progress, scratch, hairs):
    """Place the next imprint of an interval, as far from the last as no hair moves too far.

    Returns
    -------
    tuft : Tuft
        As it is driven there.
    touching : int
        Hairs that touch.
    moved : float
        How far the fastest moved, mm.
    step : float
        How far in the interval it lies from the last, as a fraction of it.
    """
    before, after, pose, pace = progress.before, progress.after, scratch.pose, hairs.pace
    most = _SPACING * canvas.field.resolution
    step = min(pace[1], 1.0 - pace[0])
    while True:
        tuft = place_at(samples, i, pace[0] + step, brush, canvas, before, after, scratch)
        touching = 0
        if after.values[0].touches > 0.0:
            touching = _place_hairs(pose, before, after, tuft, hairs, canvas, scratch)
            _track(after, hairs, hairs.track[1])
        touches = after.values[0].touches > 0.0 or before.values[0].touches > 0.0
        moved = _fastest(before, after, hairs.track) if touches else 0.0
        if moved <= most or step <= _SHORTEST:
            return tuft, touching, moved, step
        step = max(_SHORTEST, step * max(0.2, min(0.7, 0.9 * most / moved)))


@uncounted
def _deposit(before, after, tuft, touching, hairs, canvas, scratch):
    """Leave what the hairs of an imprint wish to give; False where the mesh has no room."""
    field, ink = canvas.field, canvas.ink
    wanted = _draw(after, touching, tuft, hairs, canvas, scratch)
    if wanted <= 0.0:
        return True
    rate = tuft.transfer_per_mm * mean_pressure(before, after)
    rate = drawn_rate(rate * ink_way(before, after), ink)
    if rate <= 0.0:  # what lies still gives nothing, nor covers what it has not inked
        return True
    count = hairs.load.shape[0]
    ready = settle_deposits(count, wanted, rate, hairs.hair_contacts, hairs.whole_sums)
    if not sweep_hairs(before, after, ready, tuft.transfer_per_mm, hairs, field, ink, scratch):
        return False
    scratch.counters[FOOTPRINTS] += 1
    _remember(before, after, tuft, hairs, ink)
    return True


@uncounted
def paint_with_hairs(samples, last, brush, canvas, progress, scratch, hairs):
    """Paint from where `progress` stands up to sample `last`; see `paint_samples`.

    Parameters
    ----------
    hairs : Hairs
    others : as for `paint_samples`

    Returns
    -------
    int
        FINISHED, or NEEDS_ROOM: call again after the mesh's arrays have grown.
    """
    before, after, pace = progress.before, progress.after, hairs.pace
    resolution = canvas.field.resolution
    most = _SPACING * resolution
    while True:
        i = next_interval(samples, last, brush.tuft, resolution, progress, scratch.counters)
        if i < 0:
            return FINISHED
        if progress.at[2] == 0:
            _begin(samples, i, brush, canvas, progress, scratch, hairs)
        while pace[0] < 1.0:
            tuft, touching, moved, step = _find_step(
                samples, i, brush, canvas, progress, scratch, hairs
            )
            if touching > 0 and not _deposit(before, after, tuft, touching, hairs, canvas, scratch):
                pace[1] = step
                return NEEDS_ROOM
            copy_stamp(after, before)
            _keep_track(hairs.track)
            pace[0] = 1.0 if pace[0] + step >= 1.0 - 1e-12 else pace[0] + step
            grown = _EASE if moved <= 0.0 else min(_EASE, 0.9 * most / moved)
            pace[1] = max(_SHORTEST, step * grown)
        end_interval(samples, progress)

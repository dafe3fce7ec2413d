"""A step of the water in an absorbent surface, and of the pigment that rides on it.

The equation is that of `surface.kernels.diffusion`. The time of a step is cut into stages, each
explicit, whose lengths make it stable over s (s + 1) / 2 times what one explicit step could
(Legendre polynomials: Meyer, Balsara, Aslam, *J. Comput. Phys.* 257, 2014). So work grows with the
root of the time, nothing has to converge, and no stage needs to know in what order nodes are taken:
the outcome is the same for any order.

Every node's potential, averaged over the step by the weights of the stages, is carried along: what
runs through an edge is the weight times the fall of that average. Where an entry potential may
stop it, the flow through the edge is averaged itself. Whatever the stages have found, water and
pigment are then moved along the edges, from where nothing flows in any more, never more than there
is, and mixed where they arrive: this conserves both to rounding, keeps both from going negative
and concentrations within their range, at any step.

All of it is done on rows: a copy of the nodes that take part, with their neighbours side by side.
They start as those with water that can move, and grow by a ring whenever it comes to their edge.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = ["WetFields", "move_water"]

_MOST = 0.5  # of the pores' depth: a longer step in which more moves is cut in parts
_FLOATS = 0.005  # mm: a film as deep carries pigment as fast as itself
_GONE = -(1 << 30)  # of what a node waits for, once it is taken out of its turn


class WetFields(NamedTuple):
    """What a step knows of all nodes (N), links (L) and blocks (B); P pigments."""

    first: NDArray  # (N,) int64, the run of each node's links
    last: NDArray  # (N,) int64
    links: NDArray  # (L,) int32, the nodes they lead to
    weights: NDArray  # (L,) float64, of the edges, all >= 0
    area: NDArray  # (N,) float64, mm2
    block: NDArray  # (N,) int32
    closed: NDArray  # (N,) uint8, 1 where neighbours are not known; 2: water would go there
    place: NDArray  # (N,) int32, work, 0 before and after
    residual: NDArray  # (N,) float64, these carry the grain: see `surface.kernels.diffusion`
    strength: NDArray  # (N,) float64, c D (1 - r) / 3
    sieve: NDArray  # (N,) float64, potential from which on pores let all pigment pass
    held: NDArray  # (N,) float64, depth to which a dry node fills before water goes on, mm
    entry: NDArray  # (N,) float64, potential that it takes to get in: 0 where it is wet already
    water: NDArray  # (N,) float64, depth, mm
    pigment: NDArray  # (N, P) float64, coats
    fine: NDArray  # (N, P) float64, of these, what goes wherever the water goes
    soaked: NDArray  # (N,) float32, greatest share that was under water since it was dry
    changed: NDArray  # (N,) bool, set where anything moved
    owed: NDArray  # (B,) float32, time since each block's last step, s
    due: NDArray  # (B,) bool, those that take theirs now
    mobile: NDArray  # (B,) bool, set where there is water that can move
    moved: NDArray  # (B, 3) float64: raised to the greatest change of depth, mm; added to: volume
    # that changed, and wet area that could, mm3 and mm2


class _Rows(NamedTuple):
    """The nodes that take part, in the order in which they came; R of them have their links."""

    ids: NDArray  # (R + ring,) int32
    starts: NDArray  # (R + 1,) uint32: an index without a sign need not be looked at for one
    cols: NDArray  # (K,) uint32, places in ids
    x: NDArray  # (K,) float64, weight times the time for which water runs there
    ran: NDArray  # (2, K) float64, what came in by edges with an entry
    totals: NDArray  # (R,) float64, sum of x
    share: NDArray  # (R,) float64, 1 / area
    low: NDArray  # (R,) float64, depth below which nothing moves
    inverse: NDArray  # (R,) float64, 1 / (capacity - low)
    strength: NDArray  # (R,) float64
    sieve: NDArray  # (R,) float64
    entry: NDArray  # (R + ring,) float64
    before: NDArray  # (R,) float64, depth
    free: NDArray  # (R,) bool: no entry stops anything here
    psi: NDArray  # (R + ring,) float64, now
    mean: NDArray  # (2, R + ring) float64, averaged over the time up to this stage and the last


@kernel(error_model="numpy", inline="always")
def _psi(depth, low, inverse, strength, film, capacity):
    """psi (mm2/s) of a depth (mm); below `low` nothing moves, `inverse` is 1 / (capacity - low)."""
    s = (depth - low) * inverse
    within = min(max(s, 0.0), 1.0)
    above = film * (depth - capacity) if s >= 1.0 else 0.0
    return strength * within * within * within + above


@kernel(error_model="numpy")
def _make_rows(size, n_links):
    return _Rows(
        np.empty(size, np.int32), np.zeros(size + 1, np.uint32), np.empty(n_links, np.uint32),
        np.empty(n_links), np.empty((2, n_links)), np.empty(size), np.empty(size), np.empty(size),
        np.empty(size), np.empty(size), np.empty(size), np.empty(size), np.empty(size),
        np.empty(size, np.bool_), np.zeros(size), np.zeros((2, size)),
    )  # fmt: skip


@kernel(error_model="numpy")
def _grow(f, rows, n_rows, n_ids, rest, capacity, film):
    """Give all that have none yet their row; return how many nodes are known now."""
    end = np.int64(rows.starts[n_rows])
    known = n_ids
    for r in range(n_rows, n_ids):
        i = rows.ids[r]
        b = f.block[i]
        is_due = f.due[b]
        total = 0.0
        barrier = f.entry[i]
        begin = end
        for e in range(f.first[i], f.last[i]):
            j = f.links[e]
            c = f.block[j]
            if not is_due and not f.due[c]:
                continue
            x = f.weights[e] * (min(f.owed[b], f.owed[c]) - rest)
            if x <= 0.0:
                continue
            k = f.place[j] - 1
            if k < 0:
                k = known
                rows.ids[k] = j
                rows.entry[k] = f.entry[j]
                f.place[j] = k + 1
                known += 1
            barrier = max(barrier, f.entry[j])
            rows.cols[end] = k
            rows.x[end] = x
            total += x
            end += 1
        if barrier > 0.0:
            for e in range(begin, end):
                rows.ran[0, e] = rows.ran[1, e] = 0.0
        low = capacity * f.residual[i]
        rows.starts[r + 1] = end
        rows.totals[r] = total
        rows.share[r] = 1.0 / f.area[i]
        rows.low[r] = low
        rows.inverse[r] = 1.0 / (capacity - low)
        rows.strength[r] = f.strength[i]
        rows.sieve[r] = f.sieve[i]
        rows.before[r] = f.water[i]
        rows.free[r] = barrier == 0.0
        rows.psi[r] = _psi(f.water[i], low, rows.inverse[r], f.strength[i], film, capacity)
    return known


@kernel(error_model="numpy")
def _is_shut(f, rows, r):
    """Whether the neighbours of a row are not all known; those are marked."""
    found = False
    for e in range(rows.starts[r], rows.starts[r + 1]):
        i = rows.ids[rows.cols[e]]
        if f.closed[i] != 0:
            f.closed[i] = 2
            found = True
    return found


@kernel(error_model="numpy")
def _count_stages(rows, n_rows, film):
    """How many stages are stable, by the steepest slope of psi that each node can come to."""
    stiffest = 0.0
    for r in range(n_rows):
        top = rows.psi[r]
        for e in range(rows.starts[r], rows.starts[r + 1]):
            top = max(top, rows.psi[rows.cols[e]])
        if top <= 0.0:
            continue
        strength = rows.strength[r]
        slope = 3.0 * strength * rows.inverse[r]
        if top < strength:
            slope *= (top / strength) ** (2.0 / 3.0)
        else:
            slope = max(slope, film)
        stiffest = max(stiffest, slope * rows.totals[r] * rows.share[r])
    return max(1, int(np.ceil(0.5 * (np.sqrt(1.0 + 8.0 * stiffest) - 1.0))))


@kernel(error_model="numpy", inline="always")
def _fall(own, other, own_entry, other_entry):
    """The difference of potentials that drives water in, below 0 out."""
    return max(other - max(own, own_entry), 0.0) - max(own - max(other, other_entry), 0.0)


@kernel(error_model="numpy")
def _run_stage(rows, n_rows, stage, n_stages, film, capacity, come):
    """Bring all potentials to the end of a stage; see the module. `come` (R,) is for work."""
    now = rows.mean[stage % 2]
    last = rows.mean[1 - stage % 2]
    ran, ran_last = rows.ran[stage % 2], rows.ran[1 - stage % 2]
    a = (2.0 * stage - 1.0) / stage
    b = (1.0 - stage) / stage
    c = a * 2.0 / (n_stages * (n_stages + 1.0))
    for r in range(n_rows):
        now[r] = a * last[r] + b * now[r] + c * rows.psi[r]
    for r in range(n_rows):
        inflow = 0.0
        if rows.free[r]:
            for e in range(rows.starts[r], rows.starts[r + 1]):
                inflow += rows.x[e] * now[rows.cols[e]]
            inflow -= rows.totals[r] * now[r]
        else:
            entry = rows.entry[r]
            for e in range(rows.starts[r], rows.starts[r + 1]):
                k = rows.cols[e]  # without branches, which nobody could foretell at a front
                fall = _fall(rows.psi[r], rows.psi[k], entry, rows.entry[k])
                ran[e] = a * ran_last[e] + b * ran[e] + c * rows.x[e] * fall
                flows = rows.x[e] * (now[k] - now[r])
                inflow += flows if entry == 0.0 and rows.entry[k] == 0.0 else ran[e]
        come[r] = inflow
    for r in range(n_rows):  # apart, several at once
        depth = rows.before[r] + rows.share[r] * come[r]
        rows.psi[r] = _psi(depth, rows.low[r], rows.inverse[r], rows.strength[r], film, capacity)


@kernel(error_model="numpy")
def _find_flows(rows, n_rows, n_stages, passing, film):
    """Turn `x` into what runs out by each link, below 0 in, mm3; `ran` into what carries soot.

    Pores that are barely wet let none of the coarse pigment pass, those above `sieve` all of it; in
    a film on them nothing holds it.
    """
    mean, ran = rows.mean[n_stages % 2], rows.ran[n_stages % 2]
    carries = rows.ran[0]
    for r in range(n_rows):
        sieve = rows.sieve[r]
        full, floats = rows.strength[r], 1.0 / (film * _FLOATS)
        always, opens = (0.0, passing / sieve) if sieve > 0.0 else (passing, 0.0)
        for e in range(rows.starts[r], rows.starts[r + 1]):
            k = rows.cols[e]
            if rows.free[r] or (rows.entry[r] == 0.0 and rows.entry[k] == 0.0):
                rows.x[e] *= mean[r] - mean[k]
            else:
                rows.x[e] = -ran[e]
            carries[e] = 0.0
            if rows.x[e] > 0.0:
                level = min(mean[r], mean[k])
                share = min(always + opens * level, passing)
                carries[e] = rows.x[e] * max(share, min(floats * (level - full), 1.0))


@kernel(error_model="numpy")
def _carry(f, rows, n_rows, n_ids):
    """Move water and pigment, each node when all that flows into it has come."""
    n_pigments = f.pigment.shape[1]
    waits, turns = np.zeros(n_ids, np.int32), np.empty(n_ids, np.int32)
    n_turns = _line_up(rows, n_rows, waits, turns)
    gained = np.zeros(n_ids)
    brought = np.zeros((2, n_ids, n_pigments))  # coarse and fine
    turn = 0
    looked = 0
    while True:
        if turn == n_turns:  # done, or they run in a circle round an entry: one has to be first
            while looked < n_rows and waits[looked] <= 0:
                looked += 1
            if looked == n_rows:
                break
            waits[looked] = _GONE
            turns[n_turns] = looked
            n_turns += 1
        r = turns[turn]
        turn += 1
        i = rows.ids[r]
        out, carrying = 0.0, 0.0
        for e in range(rows.starts[r], rows.starts[r + 1]):
            out += max(0.0, rows.x[e])
            carrying += rows.ran[0, e]
        if out == 0.0 and gained[r] == 0.0:
            continue
        f.changed[i] = True
        volume = f.water[i] * f.area[i] + gained[r]
        gained[r] = 0.0
        gone = min(out, volume)
        scale = gone / out if out > 0.0 else 0.0
        _mix(f, rows, r, volume, gone, scale * carrying, brought)
        if out > 0.0:
            for e in range(rows.starts[r], rows.starts[r + 1]):
                if rows.x[e] > 0.0:
                    k = rows.cols[e]
                    flux = rows.x[e] * scale
                    carried = rows.ran[0, e] * scale
                    gained[k] += flux
                    for p in range(n_pigments):
                        brought[0, k, p] += carried * brought[0, r, p]
                        brought[1, k, p] += flux * brought[1, r, p]
                    waits[k] -= 1
                    if waits[k] == 0:
                        turns[n_turns] = k
                        n_turns += 1
        for p in range(n_pigments):
            brought[0, r, p] = brought[1, r, p] = 0.0
    _take_rest(f, rows, n_rows, gained, brought)


@kernel(error_model="numpy", inline="always")
def _mix(f, rows, r, volume, gone, drawn, brought):
    """Mix what came to a row with what is there; turn `brought` (2, R, P) into what goes on.

    Of a volume so much is gone: fines go with it, coarse pigment with what is drawn, and the rest
    stays behind. What goes on is given per volume of these.
    """
    i = rows.ids[r]
    area, share = f.area[i], rows.share[r]
    part = drawn / (volume - gone + drawn) if drawn > 0.0 else 0.0
    fine_part = gone / volume if gone > 0.0 else 0.0
    f.water[i] = (volume - gone) * share
    for p in range(f.pigment.shape[1]):
        fine = f.fine[i, p] * area + brought[1, r, p]
        coarse = max(0.0, f.pigment[i, p] - f.fine[i, p]) * area + brought[0, r, p]
        brought[1, r, p] = fine_part * fine / gone if gone > 0.0 else 0.0
        brought[0, r, p] = part * coarse / drawn if drawn > 0.0 else 0.0
        f.fine[i, p] = (1.0 - fine_part) * fine * share
        f.pigment[i, p] = (1.0 - part) * coarse * share + f.fine[i, p]


@kernel(error_model="numpy")
def _line_up(rows, n_rows, waits, turns):
    """Count the nodes that each waits for, and list those that wait for none; how many these are.

    `waits` is 0 before, `turns` is filled.
    """
    for r in range(n_rows):
        for e in range(rows.starts[r], rows.starts[r + 1]):
            if rows.x[e] > 0.0:
                waits[rows.cols[e]] += 1
    n_turns = 0
    for r in range(n_rows):
        if waits[r] == 0:
            turns[n_turns] = r
            n_turns += 1
    return n_turns


@kernel(error_model="numpy")
def _take_rest(f, rows, n_rows, gained, brought):
    """Give nodes what came to them after they had passed on theirs: water, pigments (2, R, P)."""
    for r in range(n_rows):
        if gained[r] > 0.0:
            i = rows.ids[r]
            f.changed[i] = True
            f.water[i] += gained[r] * rows.share[r]
            for p in range(brought.shape[2]):
                f.pigment[i, p] += (brought[0, r, p] + brought[1, r, p]) * rows.share[r]
                f.fine[i, p] += brought[1, r, p] * rows.share[r]


@kernel(error_model="numpy")
def _greatest_change(f, rows, n_rows, shortest):
    """Of depth, mm, that the flows will make in blocks that are owed more than `shortest`."""
    most = 0.0
    for r in range(n_rows):
        if f.owed[f.block[rows.ids[r]]] < shortest:
            continue
        gone = 0.0
        for e in range(rows.starts[r], rows.starts[r + 1]):
            gone += rows.x[e]
        most = max(most, abs(gone) * rows.share[r])
    return most


@kernel(error_model="numpy")
def _note(f, rows, n_rows, rest):
    """Note what the step did to the nodes that it changed; blocks that get water are owed rest."""
    for r in range(n_rows):
        i = rows.ids[r]
        b = f.block[i]
        water = f.water[i]
        f.moved[b, 2] += f.area[i]
        change = abs(water - rows.before[r])
        if change == 0.0:
            continue
        f.moved[b, 0] = max(f.moved[b, 0], change)
        f.moved[b, 1] += change * f.area[i]
        if np.isinf(f.owed[b]):
            f.owed[b] = rest
        share = water / f.held[i] if water < f.held[i] else 1.0
        f.soaked[i] = max(f.soaked[i], share)
        if f.soaked[i] >= 1.0:
            f.entry[i] = 0.0


@kernel(error_model="numpy")
def _seed(f, rows, nodes, around, capacity):
    """Take in the nodes with water that can move; return how many."""
    known = 0
    for own in range(2):
        some = nodes if own == 0 else around
        for n in range(some.shape[0]):
            i = some[n]
            if f.water[i] > capacity * f.residual[i] and f.place[i] == 0:
                rows.ids[known] = i
                rows.entry[known] = f.entry[i]
                known += 1
                f.place[i] = known
                f.mobile[f.block[i]] = True
    return known


@kernel(error_model="numpy")
def _find(f, rows, known, rest, capacity, film, passing, come):
    """Find what flows; return rows and nodes known, stages, and whether more has to be known."""
    inner, n_rows = 0, known  # those within have all neighbours among the rows
    known = _grow(f, rows, 0, known, rest, capacity, film)
    n_stages = 0
    stage = 0
    rows.mean[:, :known] = 0.0
    while n_stages == 0 or stage < n_stages:
        reaches = False
        is_shut = False
        for r in range(inner, n_rows):
            if rows.psi[r] > 0.0:
                reaches = True
                is_shut = _is_shut(f, rows, r) or is_shut
        if is_shut:
            return n_rows, known, -1
        if reaches:
            inner, n_rows, was = n_rows, known, known
            known = _grow(f, rows, inner, known, rest, capacity, film)
            rows.mean[:, was:known] = 0.0
            rows.psi[was:known] = 0.0
        if n_stages == 0:
            n_stages = _count_stages(rows, n_rows, film)
        stage += 1
        _run_stage(rows, n_rows, stage, n_stages, film, capacity, come)
    _find_flows(rows, n_rows, n_stages, passing, film)
    return n_rows, known, n_stages


@kernel(error_model="numpy")
def move_water(f, nodes, around, capacity, film, passing, shortest, rest):
    """Let the water of some blocks run for the time that they are owed, or a part of it.

    Parameters
    ----------
    f : WetFields
        water, pigment, soaked, entry, changed, mobile, moved and owed are changed.
    nodes : (K,) i32
        All nodes of these blocks.
    around : (R,) i32
        All nodes next to them, and perhaps some more than once, or of the blocks themselves.
    capacity, film : f64
        Depth that the pores hold, mm; diffusivity of a film on them, mm2/s.
    passing : f64
        Speed of coarse pigment over that of the water in pores that let it pass, 0 to 1.
    shortest : f64
        A longer step, s, in which much would move is not taken whole.
    rest : (1,) f64
        Filled with what all these blocks are still owed then, if they are not owed less.

    Returns
    -------
    int
        Stages taken; -1 where more of the surface has to be known: then nothing was done.
    """
    n_links = 0
    size = nodes.shape[0]
    longest = 0.0
    for n in range(nodes.shape[0]):
        n_links += f.last[nodes[n]] - f.first[nodes[n]]
        longest = max(longest, f.owed[f.block[nodes[n]]])
    for n in range(around.shape[0]):
        i = around[n]
        if not f.due[f.block[i]]:
            size += 1
            n_links += f.last[i] - f.first[i]
            if f.closed[i] != 0 and f.water[i] > 0.0:
                return -1
    rows = _make_rows(size, n_links)
    come = np.empty(size)
    length = longest
    while True:
        rest[0] = longest - length
        seeds = _seed(f, rows, nodes, around, capacity)
        n_rows, known, n_stages = seeds, seeds, 0
        if seeds > 0:
            n_rows, known, n_stages = _find(f, rows, seeds, rest[0], capacity, film, passing, come)
        is_long = (
            n_stages > 0
            and length > 2.0 * shortest
            and _greatest_change(f, rows, n_rows, rest[0] + 2.0 * shortest) > _MOST * capacity
        )
        if n_stages > 0 and not is_long:
            _carry(f, rows, n_rows, known)
            _note(f, rows, n_rows, rest[0])
        for k in range(known):
            f.place[rows.ids[k]] = 0
        if not is_long:
            return n_stages
        length = max(shortest, 0.25 * length)

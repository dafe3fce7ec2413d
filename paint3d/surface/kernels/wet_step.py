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

How water enters what is dry; the same words stand in `surface.pores`, `surface.wet_patch` and
`surface.flow_graph` (c: the capacity, mm; r: the residual saturation; psi: the potential):

=============  =======  ============================================================================
word           unit     meaning
=============  =======  ============================================================================
entry          mm3/s    potential of a neighbour above which its water enters a dry node; 0 once the
                        node is soaked. Glue raises it, wet neighbours lower it (`ease_entries`)
entry depth    mm       depth at which a dry node is soaked: a c with a > r (`Material.advance`)
entry ratio    0 to 1   entry of a node's widest pores, which fill first, over that of its narrowest
barrier        mm3/s    highest entry of a node and its neighbours; 0: no edge there can be stopped
soaked         0 to 1   greatest water over entry depth since the node was last dry; from 1 on water
                        enters and leaves freely
clogged        0 to 1   fraction of what dried glue can clog that it has clogged: it raises the
                        entry depth and lowers the conductance of links
closed         0, 1, 2  whether the links of a node are not known yet (1), and water would go there
                        (2), so that its block has to be opened first
sieve          mm3/s    potential from which on pores pass coarse pigment at `passing` times the
                        speed of the water; below it in proportion
=============  =======  ============================================================================
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = ["WORKSPACE_TOO_SMALL", "Absorption", "WetFields", "Workspace", "move_water"]

WORKSPACE_TOO_SMALL = -2

_MOST = 0.5  # of the pores' depth: a longer step in which more moves is cut in parts
_LOOSE_CAPTURE = 0.2  # capture rate of loose flocs over that of fine pigment
_DISPERSES = 0.1, 0.4  # mm: in pores and as a film; water that runs so far mixes over as far
_MIXES = 0.06  # most of a node's water exchanged by a link in a step; of n > 8 links 8 / n of it
_CROWDED = 4.0  # coats to the mm of water: of more flocs some come to rest
_LEAST_ENTRY = 0.05  # of the pores' depth: entry depths count as no less in a division
_GONE = -(1 << 30)  # of what a node waits for, once it is taken out of its turn


class WetFields(NamedTuple):
    """State of all nodes (N), links (L) and blocks (B) for a step; P pigments."""

    first: NDArray  # (N,) int64, the run of each node's links
    last: NDArray  # (N,) int64
    links: NDArray  # (L,) int32, the nodes they lead to
    weights: NDArray  # (L,) float64, of the edges, all >= 0
    area: NDArray  # (N,) float64, mm2
    block: NDArray  # (N,) int32
    closed: NDArray  # (N,) uint8, see the table: 0, 1 or 2
    place: NDArray  # (N,) int32, work, 0 before and after
    residual: NDArray  # (N,) float64, these carry the grain: see `surface.kernels.diffusion`
    strength: NDArray  # (N,) float64, psi of full pores, c D (1 - r) / 3, mm3/s
    sieve: NDArray  # (N,) float64, mm3/s
    catch: NDArray  # (N,) float64, fraction of fine pigment coming through its pores that it keeps
    entry_depth: NDArray  # (N,) float64, mm
    entry: NDArray  # (N,) float64, mm3/s
    water: NDArray  # (N,) float64, depth, mm
    pigment: NDArray  # (N, P) float64, coats
    fine: NDArray  # (N, P) float64, of these, what goes with the water until a pore catches it
    loose: NDArray  # (N, P) float64, and the flocs that much water parts, which pores hardly catch
    mobility: NDArray  # (P,) float64, what pores let pass of the others, over that of soot
    sticks: NDArray  # (P,) float64, to pores, 0 to 1: soot does, a dye does not
    soaked: NDArray  # (N,) float32, 0 to 1
    changed: NDArray  # (N,) bool, set where anything moved
    owed: NDArray  # (B,) float32, time since each block's last step, s
    due: NDArray  # (B,) bool, those that take theirs now
    mobile: NDArray  # (B,) bool, set where there is water that can move
    moved: NDArray  # (B, 3) float64: raised to the greatest change of depth, mm; added to: volume
    # that changed, and wet area that could, mm3 and mm2


class Absorption(NamedTuple):
    """Properties of the pores that are the same everywhere."""

    capacity: float  # depth that the pores hold, mm
    film: float  # diffusivity of a film on them, mm2/s
    passing: float  # speed of coarse soot over that of the water where pores let it pass, 0 to 1
    pores: float  # depth of the pores, mm: a film as deep on them floats half of their pigment
    entry_ratio: float  # 0 to 1


class Workspace(NamedTuple):
    """Memory to work in; what is there counts for nothing."""

    floats: NDArray  # (F,) float64
    ints: NDArray  # (I,) int32


class _Rows(NamedTuple):
    """The nodes that take part, in the order in which they came; R of them have their links."""

    ids: NDArray  # (R + ring,) int32
    waits: NDArray  # (R + ring,) int32, how many have to give before a node gives
    turns: NDArray  # (R + ring,) uint32: an index without a sign need not be looked at for one
    starts: NDArray  # (R + 1,) uint32
    cols: NDArray  # (K,) uint32, places in ids
    x: NDArray  # (K,) float64, weight times the time for which water runs there
    edge_flow: NDArray  # (2, K) float64, what came in by edges with an entry; in the end what
    # runs out and carries soot, and what of it runs as a film, which carries all pigment
    totals: NDArray  # (R,) float64, sum of x
    per_area: NDArray  # (R,) float64, 1 / area, 1/mm2
    residual_depth: NDArray  # (R,) float64, depth below which nothing moves
    inverse: NDArray  # (R,) float64, 1 / (capacity - residual_depth)
    strength: NDArray  # (R,) float64
    sieve: NDArray  # (R,) float64
    entry: NDArray  # (R + ring,) float64, at the present filling
    full_entry: NDArray  # (R + ring,) float64, that of the narrowest pores
    per_entry_depth: NDArray  # (R + ring,) float64, 1 / the depth at which these are full
    before: NDArray  # (R,) float64, depth
    barrier: NDArray  # (R,) float64
    psi: NDArray  # (R + ring,) float64, now
    mean: NDArray  # (2, R + ring) float64, averaged over the time up to this stage and the last


@kernel(error_model="numpy", inline="always")
def _psi(depth, residual_depth, inverse, strength, film, capacity):
    """Potential psi (mm3/s) of a depth (mm); `inverse` is 1 / (capacity - residual_depth)."""
    s = (depth - residual_depth) * inverse
    within = min(max(s, 0.0), 1.0)
    above = film * (depth - capacity) if s >= 1.0 else 0.0
    return strength * within * within * within + above


@kernel(error_model="numpy", inline="always")
def _make_rows(floats, ints, size, n_links):
    """Rows in memory that is there."""
    of_nodes = floats[: 12 * size].reshape(12, size)
    mean = floats[12 * size : 14 * size].reshape(2, size)
    first = 14 * size
    edge_flow = floats[first : first + 2 * n_links].reshape(2, n_links)
    x = floats[first + 2 * n_links : first + 3 * n_links]
    numbers = ints.view(np.uint32)
    return _Rows(
        ints[:size], ints[size : 2 * size], numbers[2 * size : 3 * size],
        numbers[3 * size : 4 * size + 1], numbers[4 * size + 1 : 4 * size + 1 + n_links], x,
        edge_flow, of_nodes[0], of_nodes[1], of_nodes[2], of_nodes[3], of_nodes[4], of_nodes[5],
        of_nodes[6], of_nodes[7], of_nodes[8], of_nodes[9], of_nodes[10], of_nodes[11], mean,
    )  # fmt: skip


@kernel(error_model="numpy", inline="always")
def _entry_of(full_entry, filled, ratio):
    """Entry potential of a cell that is filled in part, 0 to 1: its wide pores fill first.

    So a front rests between two nodes, where pressure and pores say, and not on the mesh.
    """
    return full_entry * (ratio + (1.0 - ratio) * min(filled, 1.0))


@kernel(error_model="numpy", inline="always")
def _init_entry(f, rows, k, i, absorption):
    """Fill in the entry potentials of node i, the k-th that takes part."""
    per_depth = 1.0 / max(f.entry_depth[i], _LEAST_ENTRY * absorption.capacity)
    rows.full_entry[k], rows.per_entry_depth[k] = f.entry[i], per_depth
    rows.entry[k] = _entry_of(f.entry[i], f.water[i] * per_depth, absorption.entry_ratio)


@kernel(error_model="numpy")
def _grow(f, rows, n_rows, n_ids, rest, absorption):
    """Give all that have none yet their row; return how many nodes are known now."""
    capacity, film = absorption.capacity, absorption.film
    end = rows.starts[n_rows]
    known = n_ids
    cols, weight, entry = rows.cols, rows.x, rows.entry
    for r in range(n_rows, n_ids):
        i = rows.ids[r]
        b = f.block[i]
        is_due, owed = f.due[b], f.owed[b] - rest
        total = 0.0
        barrier = entry[r]
        begin = end
        for e in range(np.uint64(f.first[i]), np.uint64(f.last[i])):
            j = np.uint32(f.links[e])
            c = f.block[j]
            time = owed
            if c == b:
                if not is_due:
                    continue
            else:
                time = min(owed, f.owed[c] - rest)
                if not (is_due or f.due[c]):
                    continue
            x = f.weights[e] * time
            if x <= 0.0:
                continue
            k = f.place[j] - 1
            if k < 0:
                k = known
                rows.ids[k] = j
                _init_entry(f, rows, k, j, absorption)
                f.place[j] = k + 1
                known += 1
            barrier = max(barrier, entry[np.uint32(k)])
            cols[end] = k
            weight[end] = x
            total += x
            end += np.uint32(1)
        if barrier > 0.0:
            for e in range(begin, end):
                rows.edge_flow[0, e] = rows.edge_flow[1, e] = 0.0
        residual_depth = capacity * f.residual[i]
        rows.starts[r + 1] = end
        rows.totals[r] = total
        rows.per_area[r] = 1.0 / f.area[i]
        rows.residual_depth[r] = residual_depth
        rows.inverse[r] = 1.0 / (capacity - residual_depth)
        rows.strength[r] = f.strength[i]
        rows.sieve[r] = f.sieve[i]
        rows.before[r] = f.water[i]
        rows.barrier[r] = barrier
        rows.psi[r] = _psi(
            f.water[i], residual_depth, rows.inverse[r], f.strength[i], film, capacity
        )
    return known


@kernel(error_model="numpy")
def _reaches_closed(f, rows, r):
    """Whether a neighbour of a row is closed; those that are get marked (2)."""
    found = False
    for e in range(rows.starts[r], rows.starts[r + 1]):
        i = rows.ids[rows.cols[e]]
        if f.closed[i] != 0:
            f.closed[i] = 2
            found = True
    return found


@kernel(error_model="numpy")
def _count_stages(rows, n_rows, absorption):
    """Count the stages that are stable, by the steepest slope of psi each node can come to."""
    film, rises = absorption.film, 1.0 - absorption.entry_ratio
    stiffest = 0.0  # its third power: that of a slope that grows with psi to 2/3 needs no root
    for r in range(n_rows):
        top = rows.psi[r]
        for e in range(rows.starts[r], rows.starts[r + 1]):
            top = max(top, rows.psi[rows.cols[e]])
        strength = rows.strength[r]
        slope = 3.0 * strength * rows.inverse[r]
        slope = max(slope, rises * rows.full_entry[r] * rows.per_entry_depth[r])
        part = top / strength
        if top >= strength:
            slope, part = max(slope, film), 1.0
        if top > 0.0:
            stiff = slope * rows.totals[r] * rows.per_area[r]
            stiffest = max(stiffest, stiff * stiff * stiff * part * part)
    return max(1, int(np.ceil(0.5 * (np.sqrt(1.0 + 8.0 * np.cbrt(stiffest)) - 1.0))))


@kernel(error_model="numpy", inline="always")
def _fall(own, other, own_entry, other_entry):
    """The difference of potentials that drives water in, below 0 out."""
    return max(other - max(own, own_entry), 0.0) - max(own - max(other, other_entry), 0.0)


@kernel(error_model="numpy")
def _run_stage(rows, n_rows, stage, n_stages, absorption, inflows):
    """Bring all potentials to the end of a stage; see the module. `inflows` (R,) is scratch."""
    capacity, film = absorption.capacity, absorption.film
    now = rows.mean[stage % 2]
    last = rows.mean[1 - stage % 2]
    edge_flow, edge_flow_last = rows.edge_flow[stage % 2], rows.edge_flow[1 - stage % 2]
    a = (2.0 * stage - 1.0) / stage
    b = (1.0 - stage) / stage
    c = a * 2.0 / (n_stages * (n_stages + 1.0))
    for r in range(n_rows):
        now[r] = a * last[r] + b * now[r] + c * rows.psi[r]
    for r in range(n_rows):
        inflow = 0.0
        if rows.barrier[r] == 0.0:
            for e in range(rows.starts[r], rows.starts[r + 1]):
                inflow += rows.x[e] * now[rows.cols[e]]
            inflow -= rows.totals[r] * now[r]
        else:
            entry = rows.entry[r]
            for e in range(rows.starts[r], rows.starts[r + 1]):
                k = rows.cols[e]  # without branches, which nobody could foretell at a front
                fall = _fall(rows.psi[r], rows.psi[k], entry, rows.entry[k])
                edge_flow[e] = a * edge_flow_last[e] + b * edge_flow[e] + c * rows.x[e] * fall
                flows = rows.x[e] * (now[k] - now[r])
                inflow += flows if entry == 0.0 and rows.entry[k] == 0.0 else edge_flow[e]
        inflows[r] = inflow
    for r in range(n_rows):  # apart, several at once
        depth = rows.before[r] + rows.per_area[r] * inflows[r]
        filled = max(depth, 0.0) * rows.per_entry_depth[r]
        rows.entry[r] = _entry_of(rows.full_entry[r], filled, absorption.entry_ratio)
        rows.psi[r] = _psi(
            depth, rows.residual_depth[r], rows.inverse[r], rows.strength[r], film, capacity
        )


@kernel(error_model="numpy")
def _find_flows(rows, n_rows, n_ids, n_stages, absorption):
    """Find what runs out by each link, and what of it carries coarse pigment, mm3.

    `starts`, `cols`, `x` and `edge_flow` hold it for the links by which anything runs out, and for
    them alone; `totals` is what leaves in all, below 0 what comes; `waits` how many give to each
    node. Pores that are barely wet let no soot pass, those above `sieve` all of it; in a film on
    them nothing holds it.
    """
    passing, held = absorption.passing, absorption.film * absorption.pores
    mean, edge_flow = rows.mean[n_stages % 2], rows.edge_flow[n_stages % 2]
    x, cols, waits, carries, floating = (
        rows.x,
        rows.cols,
        rows.waits,
        rows.edge_flow[0],
        rows.edge_flow[1],
    )
    waits[:n_ids] = 0
    end, n = np.uint32(0), np.uint32(0)  # flows that were found lie before links not yet read
    for r in range(n_rows):
        begin, end = end, rows.starts[r + 1]
        rows.starts[r] = n
        own, full, sieve = mean[r], rows.strength[r], rows.sieve[r]
        free = rows.barrier[r] == 0.0
        free_here = free or rows.entry[r] == 0.0
        always, opens = (0.0, passing / sieve) if sieve > 0.0 else (passing, 0.0)
        total = 0.0
        for e in range(begin, end):
            k = cols[e]
            other = mean[k]
            flow = x[e] * (own - other)
            if not free and not (free_here and rows.entry[k] == 0.0):
                flow = -edge_flow[e]
            total += flow
            level = min(own, other)
            on_top = max(level - full, 0.0)
            film_fraction = on_top / (on_top + held) if on_top > 0.0 else 0.0
            between = 0.5 * (own + other)
            carried = max(min(always + opens * between, passing), film_fraction)
            cols[n], x[n], carries[n], floating[n] = k, flow, flow * carried, flow * film_fraction
            goes = np.uint32(flow > 0.0)
            waits[k] += np.int32(goes)
            n += goes
        rows.totals[r] = total
    rows.starts[n_rows] = n


@kernel(error_model="numpy")
def _carry(f, rows, n_rows, n_ids, work):
    """Move water and pigment, each node when all that flows into it has come.

    `work` holds what comes to each: water, and of each pigment the coarse, the fine, the loose.
    Water takes ways of many lengths through fibres, so a front of clean water widens as it goes:
    both ends of a link exchange what is afloat in `_DISPERSES` / distance times what runs
    (mechanical dispersion: Bear, *Dynamics of Fluids in Porous Media*, 1972).
    """
    n_pigments = f.pigment.shape[1]
    waits, turns = rows.waits, rows.turns
    coming = work[: n_ids * (1 + 3 * n_pigments)].reshape(n_ids, 1 + 3 * n_pigments)
    coming[:] = 0.0
    n_turns = 0
    for r in range(n_rows):
        turns[n_turns] = r
        n_turns += np.int64(waits[r] == 0)
    turn, looked, n_forced = 0, 0, 0
    while True:
        if turn == n_turns:  # done, or they run in a circle round an entry: one has to be first
            while looked < n_rows and waits[looked] <= 0:
                looked += 1
            if looked == n_rows:
                break
            waits[looked] = _GONE
            n_forced += 1
            turns[n_turns] = looked
            n_turns += 1
        r = turns[turn]
        turn += 1
        begin, end = rows.starts[r], rows.starts[r + 1]
        if begin == end and coming[r, 0] == 0.0:
            continue
        i = rows.ids[r]
        out, carrying, floating = 0.0, 0.0, 0.0
        for e in range(begin, end):
            out += rows.x[e]
            carrying += rows.edge_flow[0, e]
            floating += rows.edge_flow[1, e]
        volume = f.water[i] * f.area[i] + coming[r, 0]
        gone = min(out, volume)
        scale = gone / out if out > 0.0 else 0.0
        f.changed[i] = True
        _mix(f, rows, r, volume, gone, (scale * carrying, scale * floating), coming)
        per_area, left = rows.per_area[r], volume - gone
        spacing, links = np.sqrt(f.area[i]), np.float64(f.last[i] - f.first[i])
        for e in range(begin, end):
            k = rows.cols[e]
            flux = rows.x[e] * scale
            carried, afloat = rows.edge_flow[0, e] * scale, rows.edge_flow[1, e] * scale
            coming[k, 0] += flux
            within = 1.0 - rows.edge_flow[1, e] / rows.x[e]  # of the flow, through pores
            j = rows.ids[k]  # where a mesh has wide cells beside narrow ones, by their areas
            within *= np.sqrt(2.0 * f.area[j] / (f.area[i] + f.area[j]))
            there = f.water[j] * f.area[j]
            stirred = (_DISPERSES[0] * (flux - afloat) + _DISPERSES[1] * afloat) / spacing
            beside = np.float64(f.last[j] - f.first[j])
            link_limit = min(1.0, 8.0 / max(links, beside, 1.0))
            stirred = min(stirred, link_limit * _MIXES * min(left, there))
            back = stirred / there if stirred > 0.0 else 0.0
            for p in range(n_pigments):
                drawn = _drawn(f.mobility[p], carried, afloat)
                if stirred > 0.0:
                    fine = stirred * coming[r, 2 + 3 * p] - back * f.fine[j, p] * f.area[j]
                    loose = stirred * coming[r, 3 + 3 * p] - back * f.loose[j, p] * f.area[j]
                    coarse = f.pigment[j, p] - f.fine[j, p] - f.loose[j, p]
                    coarse = stirred * coming[r, 1 + 3 * p] - back * max(coarse, 0.0) * f.area[j]
                    coarse *= drawn / flux
                    coming[k, 1 + 3 * p] += coarse
                    coming[k, 2 + 3 * p] += fine
                    coming[k, 3 + 3 * p] += loose
                    f.fine[i, p] -= per_area * fine
                    f.loose[i, p] -= per_area * loose
                    f.pigment[i, p] -= per_area * (coarse + fine + loose)
                fine, loose = flux * coming[r, 2 + 3 * p], flux * coming[r, 3 + 3 * p]
                held = min(1.0, f.sticks[p] * f.catch[j])
                catches = min(1.0, held * within)
                coming[k, 2 + 3 * p] += (1.0 - catches) * fine
                # -ln(1 - x) is x (6 - x) / (6 - 4 x) by Pade; with x = held alone, or catches, a
                # lattice of wide and narrow cells would show in washes.
                mean = 0.5 * (held + catches)
                rate = _LOOSE_CAPTURE * within * held * (6.0 - mean) / (6.0 - 4.0 * mean)
                captured = rate / (1.0 + 0.5 * rate)  # 1 - exp(-rate)
                coming[k, 3 + 3 * p] += (1.0 - captured) * loose
                caught = catches * fine + captured * loose
                coming[k, 1 + 3 * p] += drawn * coming[r, 1 + 3 * p] + caught
            waits[k] -= 1
            if waits[k] == 0:
                turns[n_turns] = k
                n_turns += 1
        for q in range(coming.shape[1]):
            coming[r, q] = 0.0
    if n_forced > 0:
        _take_rest(f, rows, n_rows, coming)


@kernel(error_model="numpy", inline="always")
def _drawn(mobility, carried, afloat):
    """Water that carries coarse pigment, of that which carries soot and what of it is a film."""
    return mobility * carried + (1.0 - mobility) * afloat


@kernel(error_model="numpy", inline="always")
def _mix(f, rows, r, volume, gone, carrying, coming):
    """Mix what came to a row with what is there; turn `coming` into what goes on.

    Of a volume so much is gone; `carrying` is what of this carries soot, and what is a film. What
    is fine or loose goes with all of it, coarse pigment with these by its mobility, and the rest
    stays behind. What goes on is given per volume of these.
    """
    i = rows.ids[r]
    area, per_area = f.area[i], rows.per_area[r]
    fine_part = 1.0 / volume if gone > 0.0 else 0.0
    f.water[i] = (volume - gone) * per_area
    for p in range(f.pigment.shape[1]):
        drawn = _drawn(f.mobility[p], carrying[0], carrying[1])
        part = 1.0 / (volume - gone + drawn) if drawn > 0.0 else 0.0  # of it, per volume drawn
        fine = f.fine[i, p] * area + coming[r, 2 + 3 * p]
        loose = f.loose[i, p] * area + coming[r, 3 + 3 * p]
        coarse = max(0.0, f.pigment[i, p] - f.fine[i, p] - f.loose[i, p]) * area
        coarse += coming[r, 1 + 3 * p]
        coming[r, 2 + 3 * p] = fine_part * fine
        coming[r, 3 + 3 * p] = fine_part * loose
        coming[r, 1 + 3 * p] = part * coarse
        f.fine[i, p] = (1.0 - fine_part * gone) * fine * per_area
        f.loose[i, p] = (1.0 - fine_part * gone) * loose * per_area
        f.pigment[i, p] = (1.0 - part * drawn) * coarse * per_area + f.fine[i, p] + f.loose[i, p]


@kernel(error_model="numpy")
def _take_rest(f, rows, n_rows, coming):
    """Give nodes what came to them after they had passed on theirs."""
    for r in range(n_rows):
        if coming[r, 0] > 0.0:
            i = rows.ids[r]
            f.changed[i] = True
            f.water[i] += coming[r, 0] * rows.per_area[r]
            for p in range(f.pigment.shape[1]):
                fine, loose = (
                    coming[r, 2 + 3 * p] * rows.per_area[r],
                    coming[r, 3 + 3 * p] * rows.per_area[r],
                )
                f.pigment[i, p] += coming[r, 1 + 3 * p] * rows.per_area[r] + fine + loose
                f.fine[i, p] += fine
                f.loose[i, p] += loose


@kernel(error_model="numpy")
def _greatest_change(f, rows, n_rows, shortest):
    """Of depth, mm, that the flows will make in blocks that are owed more than `shortest`."""
    most = 0.0
    for r in range(n_rows):
        if f.owed[f.block[rows.ids[r]]] < shortest:
            continue
        most = max(most, abs(rows.totals[r]) * rows.per_area[r])
    return most


@kernel(error_model="numpy", inline="always")
def _settle(f, i, water):
    """Bring flocs to rest on fibres where the water between them gets little."""
    afloat = 0.0
    for p in range(f.pigment.shape[1]):
        afloat += f.loose[i, p]
    most = _CROWDED * water
    if afloat > most:
        for p in range(f.pigment.shape[1]):
            f.loose[i, p] *= most / afloat


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
        _settle(f, i, water)
        filled = water / f.entry_depth[i] if water < f.entry_depth[i] else 1.0
        f.soaked[i] = max(f.soaked[i], filled)
        if f.soaked[i] >= 1.0:
            f.entry[i] = 0.0


@kernel(error_model="numpy")
def _seed(f, rows, nodes, around, absorption):
    """Take in the nodes with water that can move; return how many."""
    known = 0
    for own in range(2):
        some = nodes if own == 0 else around
        for n in range(some.shape[0]):
            i = some[n]
            if f.water[i] > absorption.capacity * f.residual[i] and f.place[i] == 0:
                rows.ids[known] = i
                _init_entry(f, rows, known, i, absorption)
                known += 1
                f.place[i] = known
                f.mobile[f.block[i]] = True
    return known


@kernel(error_model="numpy")
def _find(f, rows, known, rest, absorption, inflows):
    """Find what flows; return rows and nodes known, stages, and whether more has to be known."""
    inner, n_rows = 0, known  # those within have all neighbours among the rows
    rows.starts[0] = 0
    known = _grow(f, rows, 0, known, rest, absorption)
    n_stages = 0
    stage = 0
    rows.mean[:, :known] = 0.0
    rows.psi[n_rows:known] = 0.0
    while n_stages == 0 or stage < n_stages:
        reaches = False
        reaches_closed = False
        for r in range(inner, n_rows):
            if rows.psi[r] > 0.0:
                reaches = True
                reaches_closed = _reaches_closed(f, rows, r) or reaches_closed
        if reaches_closed:
            return n_rows, known, -1
        if reaches:
            inner, n_rows, was = n_rows, known, known
            known = _grow(f, rows, inner, known, rest, absorption)
            rows.mean[:, was:known] = 0.0
            rows.psi[was:known] = 0.0
        if n_stages == 0:
            n_stages = _count_stages(rows, n_rows, absorption)
        stage += 1
        _run_stage(rows, n_rows, stage, n_stages, absorption, inflows)
    _find_flows(rows, n_rows, known, n_stages, absorption)
    return n_rows, known, n_stages


@kernel(error_model="numpy")
def _measure(f, nodes, around):
    """Count nodes and links, and find the longest time that is owed.

    -1 nodes where there is water around of which it is not known where it goes.
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
                return -1, n_links, longest
    return size, n_links, longest


@kernel(error_model="numpy")
def move_water(f, nodes, around, absorption, shortest, rest, workspace):
    """Move the water of some blocks for the time that they are owed, or a part of it.

    Parameters
    ----------
    f : WetFields
        water, pigment, soaked, entry, changed, mobile, moved and owed are changed.
    nodes : (K,) i32
        All nodes of these blocks.
    around : (R,) i32
        All nodes next to them, and perhaps some more than once, or of the blocks themselves.
    absorption : Absorption
    shortest : f64
        A longer step, s, in which much would move is not taken whole.
    rest : (1,) f64
        Filled with what all these blocks are still owed then, if they are not owed less.
    workspace : Workspace
        For M nodes, these and around, and their K links at least (15 + 3 P) M + 3 K floats and
        4 M + 1 + K ints.

    Returns
    -------
    int
        Stages taken; below 0 nothing was done: -1 where more of the surface has to be known, or
        WORKSPACE_TOO_SMALL.
    """
    size, n_links, longest = _measure(f, nodes, around)
    if size < 0:
        return -1
    n_work = size * (1 + 3 * f.pigment.shape[1])
    n_floats = n_work + 14 * size + 3 * n_links
    if workspace.floats.shape[0] < n_floats or workspace.ints.shape[0] < 4 * size + 1 + n_links:
        return WORKSPACE_TOO_SMALL
    rows = _make_rows(workspace.floats[n_work:], workspace.ints, size, n_links)
    work = workspace.floats[:n_work]
    length = longest
    while True:
        rest[0] = longest - length
        seeds = _seed(f, rows, nodes, around, absorption)
        n_rows, known, n_stages = seeds, seeds, 0
        if seeds > 0:
            n_rows, known, n_stages = _find(f, rows, seeds, rest[0], absorption, work)
        is_long = (
            n_stages > 0
            and length > 2.0 * shortest
            and _greatest_change(f, rows, n_rows, rest[0] + 2.0 * shortest)
            > _MOST * absorption.capacity
        )
        if n_stages > 0 and not is_long:
            _carry(f, rows, n_rows, known, work)
            _note(f, rows, n_rows, rest[0])
        for k in range(known):
            f.place[rows.ids[k]] = 0
        if not is_long:
            return n_stages
        length = max(shortest, 0.25 * length)

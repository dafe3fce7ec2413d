"""Ink in an absorbent surface: water flows, pigment rides on it, the rest dries.

One unknown tells where the water is: its depth T, mm, which is also its volume in ul per mm2. The
pores hold up to the capacity c; below the residual saturation r nothing moves; between them the
potential is that of a porous medium, and what is over c lies on top as a film:

    psi(T) = c D / 3 (1 - r) s^3,  s = (min(T, c) - r c) / (c - r c),   + D (T - c) where T > c,
    dT/dt = div grad psi(T) - evaporation.

psi is flat below r c, so the front is sharp (the porous medium equation: Vazquez, *The Porous
Medium Equation*, 2007; saturation cubed for the conductivity of a porous sheet: Brooks, Corey
1964). What is dry takes water only where psi is above an entry potential, that of a depth a c,
a > r: the front stops there and is pinned while the water behind it can still move, and is drawn
to the border, where it dries fastest: rims get darker (Deegan et al., Nature 389, 1997; wetting
and draining of a porous body differ: Haines 1930). Weights are those of the intrinsic Delaunay
triangulation (`kernels.intrinsic`), which cannot create new extremes.

A step is implicit. Whatever the solver has reached, water and pigment are then moved along the
edges in falling order of the potential, never more than there is, and mixed where they arrive:
this conserves both to rounding, keeps both from going negative and concentrations within their
range, at any step.

Time goes on block by block (`mesh.flow_graph`): where much moves in short steps, where little does
in long ones. The water of an edge between two blocks runs whenever either takes its step, for the
time since one of them last did: no time is lost or counted twice, and what leaves one is what
enters the other (local time stepping: Osher, Sanders 1983). `weigh_links` turns the weights into
weights times those times, and the steps know nothing of it.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels.refine import activate_cell

__all__ = [
    "activate_cells",
    "evaporate",
    "flow_pigment",
    "note_motion",
    "potential",
    "potentials",
    "solve_edges",
    "solve_water",
    "weigh_links",
]

_NEWTON = 40
_NEAR = 2e-3  # of the saturation; convergence is quadratic: the next step would be below 1e-5
_MOST_OVER = 1.8  # over-relaxation, which is chosen node by node (Ehrlich 1981)
_LOOK_AGAIN = 6  # sweeps after which it is chosen anew
_LOW, _INVERSE, _SHARE, _STIFF, _OVER = range(5)  # places in what is known of an active node
_QUIET = 0.1  # of the tolerance: who changes less lets the neighbours rest


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def potential(depth, capacity, residual, strength, film):
    """psi (mm2/s) of a water depth (mm); `strength` is c D (1 - r) / 3, `film` is D."""
    low = capacity * residual
    if depth <= low:
        return 0.0
    if depth >= capacity:
        return strength + film * (depth - capacity)
    s = (depth - low) / (capacity - low)
    return strength * s * s * s


@njit(cache=True, nogil=True, error_model="numpy")
def potentials(nodes, depth, capacity, residual, strength, film, psi):
    """Fill psi of some nodes."""
    for n in range(nodes.shape[0]):
        i = nodes[n]
        psi[i] = potential(depth[i], capacity, residual[i], strength[i], film)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _depth_at(right, factor, guess, capacity, low, inverse, strength, film, entry):
    """The depth T with T + factor max(psi(T), entry) = right, by Newton; and psi there.

    `low` is the depth below which nothing moves, `inverse` 1 / (capacity - low).
    """
    if entry > 0.0:
        depth = right - factor * entry
        if depth <= low:
            return depth, 0.0
        s = min(1.0, (depth - low) * inverse)
        psi = strength * s * s * s + film * max(0.0, depth - capacity)
        if psi <= entry:
            return depth, psi
    if right <= low:
        return right, 0.0
    at_capacity = capacity + factor * strength
    if right >= at_capacity:
        over = (right - at_capacity) / (1.0 + factor * film)
        return capacity + over, strength + film * over
    # s + cube s^3 = wanted is convex: after its first step Newton comes down on the root
    cube = factor * strength * inverse
    wanted = (right - low) * inverse
    s = (guess - low) * inverse if low < guess < capacity else min(wanted, 1.0)
    for _ in range(_NEWTON):
        square = cube * s * s
        step = (s + square * s - wanted) / (1.0 + 3.0 * square)
        s -= step
        if abs(step) < _NEAR:
            break
    s = min(1.0, s)
    return low + s * (capacity - low), strength * s * s * s


@njit(cache=True, nogil=True)
def weigh_links(
    nodes, first, last, links, weights, block, owed, due, marks, exchange, totals, ring
):
    """Multiply weights by the times for which water runs on each link; return the ring's size.

    Parameters
    ----------
    nodes : (K,) i32
        Those of the blocks that are due.
    first, last, links, weights : (N,) i64, (N,) i64, (L,) i32, (L,) f64
        The run of each node's links, the nodes they lead to, and the edges' weights, >= 0.
    block : (N,) i32
    owed : (B,) f64
        Time since each block's last step, s.
    due : (B,) bool
    marks : (N,) u8
        0; becomes 4 on the ring.
    exchange : (L,) f64, totals : (N,) f64
        Filled for these nodes and the ring: weight times time, and its sum.
    ring : (N,) i32
        Filled with the neighbours in blocks that are not due.
    """
    n_ring = 0
    for n in range(nodes.shape[0]):
        i = nodes[n]
        b = block[i]
        total = 0.0
        for e in range(first[i], last[i]):
            j = links[e]
            c = block[j]
            x = weights[e] * owed[b] if c == b else weights[e] * min(owed[b], owed[c])
            if not due[c] and marks[j] == 0:
                marks[j] = 4
                ring[n_ring] = j
                n_ring += 1
            exchange[e] = x
            total += x
        totals[i] = total
    for n in range(n_ring):
        i = ring[n]
        b = block[i]
        total = 0.0
        for e in range(first[i], last[i]):
            c = block[links[e]]
            x = weights[e] * min(owed[b], owed[c]) if due[c] else 0.0
            exchange[e] = x
            total += x
        totals[i] = total
        marks[i] = 0
    return n_ring


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _stiffness(depth, total, known, capacity, strength, film):
    """How much more a node's balance changes than its depth, less 1; and its over-relaxation."""
    if depth <= known[_LOW]:
        return 0.0, 1.0
    s = (depth - known[_LOW]) * known[_INVERSE]
    slope = film if depth >= capacity else 3.0 * strength * s * s * known[_INVERSE]
    stiff = known[_SHARE] * total * slope
    rho = stiff / (1.0 + stiff)
    return stiff, min(_MOST_OVER, 2.0 / (1.0 + np.sqrt(1.0 - rho * rho)))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _inflow(i, free, psi, entry, first, last, links, exchange, totals):
    """Sum of exchanges times potentials of what node i shares water with, and of the exchanges."""
    inflow = 0.0
    if free:
        for e in range(first[i], last[i]):
            inflow += exchange[e] * psi[links[e]]
        return inflow, totals[i]
    total = 0.0
    own = psi[i]
    own_entry = max(own, entry[i])
    for e in range(first[i], last[i]):
        other = psi[links[e]]
        other_entry = max(other, entry[links[e]])
        if other > own_entry:
            inflow += exchange[e] * other
            total += exchange[e]
        elif own >= other_entry:
            inflow += exchange[e] * other_entry
            total += exchange[e]
    return inflow, total


@njit(cache=True, nogil=True, error_model="numpy")
def solve_water(
    active, n_active, is_active, closed, before, area, first, last, links, exchange, totals,
    capacity, residual, strength, film, entry, tolerance, most_sweeps, depth, psi, stats,
):  # fmt: skip
    """Solve the implicit step by over-relaxed Gauss-Seidel sweeps over what still changes.

    Nodes are activated as water reaches them. Cost: about 30 ns a node and sweep.

    Parameters
    ----------
    active : (N,) i32
        The first `n_active` are those with water that can move; extended in place.
    is_active : (N,) u8
        1 for those, 0 for others; changed.
    closed : (N,) u8
        1 for nodes whose neighbours are not known; 2 is set where water would go there.
    before : (N,) f64
        Depth at the step's start, mm.
    area : (N,) f64
        mm2.
    first, last, links, exchange : (N,) i64, (N,) i64, (L,) i32, (L,) f64
        Neighbours of every node, and the weights, all >= 0, of the edges to them times the
        time for which water runs there, s.
    totals : (N,) f64
        Sum of a node's exchanges.
    capacity, film : f64
    residual, strength : (N,) f64
        See `potential`; they carry the grain.
    entry : (N,) f64
        Potential that it takes to get into a node: 0 where it is wet already.
    tolerance : f64
        mm of depth that may be missing in the balance of a node, in the mean.
    depth, psi : (N,) f64
        Start (the nearer the better) and solution.
    stats : (3,) f64
        Filled with sweeps, the mean residual left, and 1 if a closed node was asked to take
        water: then nothing is solved.

    Returns
    -------
    int
        Active nodes now.
    """
    stats[2] = 0.0
    free = np.zeros(active.shape[0], np.bool_)
    moving = np.ones(entry.shape[0], np.bool_)
    known = np.empty((active.shape[0], 5))  # of each active node, in their order
    for n in range(n_active):
        i = active[n]
        known[n, _LOW] = capacity * residual[i]
        known[n, _INVERSE] = 1.0 / (capacity - known[n, _LOW])
        known[n, _SHARE] = 1.0 / area[i]
        known[n, _STIFF], known[n, _OVER] = _stiffness(
            depth[i], totals[i], known[n], capacity, strength[i], film
        )
        barrier = entry[i]
        for e in range(first[i], last[i]):
            barrier = max(barrier, entry[links[e]])
        free[n] = barrier == 0.0  # wet as all its neighbours: no entry stops anything
    quiet = _QUIET * tolerance
    sweep = 0
    left = 0.0
    while sweep < most_sweeps:
        count = n_active
        left = 0.0
        for n in range(count):
            i = active[n]
            if not moving[i]:
                continue
            moving[i] = False
            inflow, total = _inflow(i, free[n], psi, entry, first, last, links, exchange, totals)
            low, share = known[n, _LOW], known[n, _SHARE]
            was = depth[i]
            d, p = _depth_at(
                before[i] + share * inflow, share * total, was, capacity, low,
                known[n, _INVERSE], strength[i], film, entry[i],
            )  # fmt: skip
            change = d - was
            left += abs(change) * (1.0 + known[n, _STIFF])
            if free[n] and d > low and was > low:
                d = max(low, was + known[n, _OVER] * change)
                s = min(1.0, (d - low) * known[n, _INVERSE])
                p = strength[i] * s * s * s + film * max(0.0, d - capacity)
            if abs(d - was) > quiet or (p > 0.0) != (psi[i] > 0.0):
                moving[i] = True
                for e in range(first[i], last[i]):
                    moving[links[e]] = True
            depth[i] = d
            psi[i] = p
            if p > 0.0 and is_active[i] == 1:
                is_active[i] = 2  # its neighbours are active too
                for e in range(first[i], last[i]):
                    j = links[e]
                    if exchange[e] == 0.0:
                        continue
                    if closed[j] != 0:
                        closed[j] = 2
                        stats[2] = 1.0
                    elif is_active[j] == 0:
                        is_active[j] = 1
                        active[n_active] = j
                        known[n_active, _LOW] = capacity * residual[j]
                        known[n_active, _INVERSE] = 1.0 / (capacity - known[n_active, _LOW])
                        known[n_active, _SHARE] = 1.0 / area[j]
                        known[n_active, _STIFF], known[n_active, _OVER] = 0.0, 1.0
                        free[n_active] = False
                        n_active += 1
                        psi[j] = 0.0
                        depth[j] = before[j]
        sweep += 1
        if stats[2] > 0.0:
            break
        left /= max(n_active, 1)
        if n_active == count and left < tolerance:
            break
        if sweep % _LOOK_AGAIN == 0:
            for n in range(count):
                i = active[n]
                known[n, _STIFF], known[n, _OVER] = _stiffness(
                    depth[i], totals[i], known[n], capacity, strength[i], film
                )
    stats[0] = sweep
    stats[1] = left
    return n_active


@njit(cache=True, nogil=True, error_model="numpy")
def flow_pigment(
    order, active, n_active, psi, entry, area, first, last, links, exchange, passing,
    water, pigment, gained, brought,
):  # fmt: skip
    """Move water and pigment along the edges, downhill, in one pass.

    Parameters
    ----------
    order : (A,) i32
        Active nodes with psi > 0 in falling order of psi, so that what flows in is known before
        anything flows out.
    active, n_active, area, first, last, links, exchange
        As in `solve_water`.
    psi, entry : (N,) f64
        The potentials at the step's end; see `solve_water`.
    passing : f64
        Speed of the pigment over that of the water, 0 to 1: below 1 it lags behind.
    water : (N,) f64
        Depth, mm, before and after.
    pigment : (N, P) f64
        Coats, before and after.
    gained : (N,) f64, brought : (N, P) f64
        Work, zero before and after.
    """
    n_pigments = pigment.shape[1]
    for n in range(order.shape[0]):
        i = order[n]
        out = 0.0
        for e in range(first[i], last[i]):
            fall = psi[i] - max(psi[links[e]], entry[links[e]])
            if fall > 0.0:
                out += exchange[e] * fall
        volume = water[i] * area[i] + gained[i]
        gained[i] = 0.0
        gone = min(out, volume)
        scale = gone / out if out > 0.0 else 0.0
        # pigment at `passing` times the water's speed, mixed with what stays behind
        drawn = passing * gone
        share = drawn / (volume - gone + drawn) if drawn > 0.0 else 0.0
        water[i] = (volume - gone) / area[i]
        for p in range(n_pigments):
            amount = pigment[i, p] * area[i] + brought[i, p]
            brought[i, p] = share * amount / gone if gone > 0.0 else 0.0  # per volume going out
            pigment[i, p] = (1.0 - share) * amount / area[i]
        if gone > 0.0:
            for e in range(first[i], last[i]):
                j = links[e]
                fall = psi[i] - max(psi[j], entry[j])
                if fall > 0.0 and exchange[e] > 0.0:
                    flux = exchange[e] * fall * scale
                    gained[j] += flux
                    for p in range(n_pigments):
                        brought[j, p] += flux * brought[i, p]
        for p in range(n_pigments):
            brought[i, p] = 0.0
    for n in range(n_active):
        i = active[n]
        if gained[i] > 0.0:
            water[i] += gained[i] / area[i]
            gained[i] = 0.0
            for p in range(n_pigments):
                pigment[i, p] += brought[i, p] / area[i]
                brought[i, p] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def solve_edges(wet, area, first, last, links, weights, totals, reach, sweeps, inside):
    """How deep inside the wet region nodes lie: 0 beyond its border, 1 well within.

    (1 - reach^2 Laplacian) inside = 1 on the wet nodes (W,), 0 elsewhere: at a distance x from a
    straight border 1 - exp(-x / reach). Gauss-Seidel from what `inside` (N,) f64 holds, which
    is 0 beyond the wet nodes.
    """
    square = reach * reach
    for sweep in range(sweeps):
        for n in range(wet.shape[0]):
            i = wet[n] if sweep % 2 == 0 else wet[wet.shape[0] - 1 - n]
            inflow = 0.0
            for e in range(first[i], last[i]):
                inflow += weights[e] * inside[links[e]]
            inside[i] = (area[i] + square * inflow) / (area[i] + square * totals[i])


@njit(cache=True, nogil=True, error_model="numpy")
def note_motion(
    reached, count, before, water, block, owed, due, held, speed, changed, soaked, entry, moved
):
    """Note what a step did to the nodes that it reached.

    Parameters
    ----------
    reached : (N,) i32
        The first `count` are meant.
    before : (count,) f64, water : (N,) f64
        Depth before, of those, and after, mm.
    block, owed, due
        As in `weigh_links`.
    held : (N,) f64
        Depth to which a dry node fills before water goes on.
    speed, changed, soaked, entry
        Of `surface.wet_patch.WetPatch`; changed.
    moved : (B,) f64
        The greatest change of depth in each block; changed.
    """
    for n in range(count):
        i = reached[n]
        b = block[i]
        change = water[i] - before[n]
        if due[b]:
            speed[i] = change / owed[b]
        moved[b] = max(moved[b], abs(change))
        changed[i] = True
        share = water[i] / held[i] if water[i] < held[i] else 1.0
        soaked[i] = max(soaked[i], share)
        if soaked[i] >= 1.0:
            entry[i] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def evaporate(wet, block, owed, rate, gain, inside, dry, water, dried, still_wet):
    """Let water go from wet nodes (W,), for the time that each one's block is owed.

    `rate` mm/s well inside, 1 + `gain` times that at the border (`inside`, see `solve_edges`).
    At `dry` mm or less a node is dry: `dried` (W,) is filled, `still_wet` (B,) set for the
    blocks of others. Returns how many are dry.
    """
    n_dried = 0
    for n in range(wet.shape[0]):
        i = wet[n]
        b = block[i]
        water[i] -= owed[b] * rate * (1.0 + gain * (1.0 - inside[i]))
        if water[i] <= dry:
            water[i] = 0.0
            dried[n_dried] = i
            n_dried += 1
        else:
            still_wet[b] = True
    return n_dried


@njit(cache=True, nogil=True)
def activate_cells(field, cells, first):
    """Refine cells (C,) from the first-th on; return how many are done: fewer for want of room."""
    for n in range(first, cells.shape[0]):
        if field.done[cells[n]] == 0 and activate_cell(field, cells[n]) < 0:
            return n
    return cells.shape[0]

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
"""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels.refine import activate_cell

__all__ = [
    "activate_cells",
    "flow_pigment",
    "potential",
    "potentials",
    "solve_edges",
    "solve_water",
]

_NEWTON = 40
_NEAR = 1e-4  # of the saturation; convergence is quadratic: the next step would be below 1e-7
_OVER = 1.5  # over-relaxation of the sweeps, which all go one way: to and fro it would not help
_CHECK = 2  # sweeps between two looks at the residual


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
def _depth_at(right, factor, guess, capacity, residual, strength, film, entry):
    """The depth T with T + factor max(psi(T), entry) = right: by Newton."""
    low = capacity * residual
    if entry > 0.0:
        depth = right - factor * entry
        if potential(depth, capacity, residual, strength, film) <= entry:
            return depth
    if right <= low:
        return right
    at_capacity = capacity + factor * strength
    if right >= at_capacity:
        return capacity + (right - at_capacity) / (1.0 + factor * film)
    # s + cube s^3 = wanted is convex: after its first step Newton comes down on the root
    inverse = 1.0 / (capacity - low)
    cube = factor * strength * inverse
    wanted = (right - low) * inverse
    s = (guess - low) * inverse if low < guess < capacity else min(wanted, 1.0)
    for _ in range(_NEWTON):
        square = cube * s * s
        step = (s + square * s - wanted) / (1.0 + 3.0 * square)
        s -= step
        if abs(step) < _NEAR:
            break
    return low + s * (capacity - low)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _drop(psi_i, entry_i, psi_j, entry_j):
    """Difference of potential that drives water from i to j; below 0 from j to i."""
    if psi_i > max(psi_j, entry_j):
        return psi_i - max(psi_j, entry_j)
    if psi_j > max(psi_i, entry_i):
        return max(psi_i, entry_i) - psi_j
    return 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _all_wet(active, n_active, runs, links, entry):
    """(N,) u8: 1 for active nodes that are wet as all their neighbours: no entry stops anything."""
    free = np.zeros(entry.shape[0], np.uint8)
    for n in range(n_active):
        i = active[n]
        barrier = entry[i]
        for e in range(runs[i], runs[i + 1]):
            barrier = max(barrier, entry[links[e]])
        free[i] = barrier == 0.0
    return free


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _inflow(i, free, psi, entry, runs, links, weights, totals):
    """Sum of weights times potentials of what node i exchanges water with, and of the weights."""
    inflow = 0.0
    if free[i]:
        for e in range(runs[i], runs[i + 1]):
            inflow += weights[e] * psi[links[e]]
        return inflow, totals[i]
    total = 0.0
    own = psi[i]
    own_entry = max(own, entry[i])
    for e in range(runs[i], runs[i + 1]):
        other = psi[links[e]]
        other_entry = max(other, entry[links[e]])
        if other > own_entry:
            inflow += weights[e] * other
            total += weights[e]
        elif own >= other_entry:
            inflow += weights[e] * other_entry
            total += weights[e]
    return inflow, total


@njit(cache=True, nogil=True, error_model="numpy")
def solve_water(
    active, n_active, is_active, rim, before, area, runs, links, weights, totals, step, capacity,
    residual, strength, film, entry, tolerance, most_sweeps, depth, psi, stats,
):  # fmt: skip
    """Solve the implicit step by over-relaxed Gauss-Seidel sweeps.

    Nodes are activated as water reaches them. Cost: about 30 ns a node and sweep.

    Parameters
    ----------
    active : (N,) i32
        The first `n_active` are those with water that can move; extended in place.
    is_active : (N,) u8
        1 for those, 0 for others; changed.
    rim : (N,) u8
        1 for nodes whose neighbourhood is not whole.
    before : (N,) f64
        Depth at the step's start, mm.
    area : (N,) f64
        mm2.
    runs, links, weights : (N + 1,) i64, (L,) i32, (L,) f64
        Neighbours of every node and the weights of the edges to them, all >= 0; 0 to the rim.
    totals : (N,) f64
        Sum of the weights of every node.
    step : f64
        s.
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
        Filled with sweeps, the mean residual left, and 1 if a rim node was asked to take water.

    Returns
    -------
    int
        Active nodes now.
    """
    stats[2] = 0.0
    free = _all_wet(active, n_active, runs, links, entry)
    sweep = 0
    left = 0.0
    while sweep < most_sweeps:
        count = n_active
        for n in range(count):
            i = active[n]
            inflow, total = _inflow(i, free, psi, entry, runs, links, weights, totals)
            share = step / area[i]
            d = _depth_at(
                before[i] + share * inflow, share * total, depth[i], capacity,
                residual[i], strength[i], film, entry[i],
            )  # fmt: skip
            low = capacity * residual[i]
            if d > low and depth[i] > low and free[i]:
                d = max(low, depth[i] + _OVER * (d - depth[i]))
            p = potential(d, capacity, residual[i], strength[i], film)
            depth[i] = d
            psi[i] = p
            if p > 0.0 and is_active[i] == 1:
                is_active[i] = 2  # its neighbours are active too
                for e in range(runs[i], runs[i + 1]):
                    j = links[e]
                    if rim[j] == 1:
                        stats[2] = 1.0
                    elif is_active[j] == 0:
                        is_active[j] = 1
                        active[n_active] = j
                        n_active += 1
                        psi[j] = 0.0
                        depth[j] = before[j]
        sweep += 1
        if n_active == count and sweep % _CHECK == 0:
            left = 0.0
            for n in range(n_active):
                i = active[n]
                balance = 0.0
                for e in range(runs[i], runs[i + 1]):
                    j = links[e]
                    balance -= weights[e] * _drop(psi[i], entry[i], psi[j], entry[j])
                left += abs(before[i] - depth[i] + step / area[i] * balance)
            left /= max(n_active, 1)
            if left < tolerance:
                break
    stats[0] = sweep
    stats[1] = left
    return n_active


@njit(cache=True, nogil=True, error_model="numpy")
def flow_pigment(
    order, active, n_active, psi, entry, area, runs, links, weights, step, passing,
    water, pigment, gained, brought,
):  # fmt: skip
    """Move water and pigment along the edges, downhill, in one pass.

    Parameters
    ----------
    order : (A,) i32
        Active nodes with psi > 0 in falling order of psi, so that what flows in is known before
        anything flows out.
    active, n_active, area, runs, links, weights, step
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
        for e in range(runs[i], runs[i + 1]):
            fall = psi[i] - max(psi[links[e]], entry[links[e]])
            if fall > 0.0:
                out += weights[e] * fall
        out *= step
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
            for e in range(runs[i], runs[i + 1]):
                j = links[e]
                fall = psi[i] - max(psi[j], entry[j])
                if fall > 0.0:
                    flux = step * weights[e] * fall * scale
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
def solve_edges(wet, area, runs, links, weights, totals, reach, sweeps, inside):
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
            for e in range(runs[i], runs[i + 1]):
                inflow += weights[e] * inside[links[e]]
            inside[i] = (area[i] + square * inflow) / (area[i] + square * totals[i])


@njit(cache=True, nogil=True)
def activate_cells(field, cells, first):
    """Refine cells (C,) from the first-th on; return how many are done: fewer for want of room."""
    for n in range(first, cells.shape[0]):
        if field.done[cells[n]] == 0 and activate_cell(field, cells[n]) < 0:
            return n
    return cells.shape[0]

"""Ink in an absorbent surface: water flows, pigment rides on it, the rest dries.

One unknown tells where the water is: its depth T, mm, which is also its volume in ul per mm2. The
pores hold up to the capacity c; below the residual saturation r nothing moves; between them the
potential is that of a porous medium, and what is over c lies on top as a film:

    psi(T) = c D / 3 (1 - r) s^3,  s = (min(T, c) - r c) / (c - r c),   + D (T - c) where T > c,
    dT/dt = div grad psi(T) - evaporation.

psi is flat below r c, so the front is sharp (the porous medium equation: Vazquez, *The Porous
Medium Equation*, 2007; saturation cubed for the conductivity of a porous sheet: Brooks, Corey
1964). Water enters what is dry only where psi is above an entry potential, that of a depth a c,
a > r: the front stops there and is pinned while the water behind it can still move, and is drawn
to the border, where it dries fastest: rims get darker (Deegan et al., Nature 389, 1997; wetting
and draining of a porous body differ: Haines 1930). Weights are those of the intrinsic Delaunay
triangulation (`surface.kernels.intrinsic_delaunay`), which cannot create new extremes.

`surface.kernels.wet_step` is a step of it, with a table of these words; here is what else happens
to the water.

Time goes on block by block (`surface.flow_graph`): where much moves in short steps, where little
does in long ones. The water of an edge between two blocks runs whenever either takes its step, for
the time since one of them last did: no time is lost or counted twice, and what leaves one is what
enters the other (local time stepping: Osher, Sanders 1983). Neighbours' steps are much alike, for
what comes into a block that is not moved stays at its border until it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.refine import activate_cell

__all__ = [
    "Drying",
    "activate_cells",
    "ease_entries",
    "evaporate",
    "give_back",
    "mark_news",
    "solve_edges",
]

_NOTCH, _FILLS = 0.5, 0.75  # filled fraction of the neighbours: entry falls from it, is 0 at it


class Drying(NamedTuple):
    """Rates at which water evaporates."""

    rate: float  # mm/s, well inside the wet region
    gain: float  # what it is faster at the border, times as fast
    dry: float  # mm: a node with no more is dry
    capacity: float  # depth that the pores hold, mm


@kernel(error_model="numpy")
def solve_edges(wet, f, totals, reach, sweeps, inside):
    """Solve for how deep inside the wet region nodes lie: 0 beyond its border, 1 well within.

    (1 - reach^2 Laplacian) inside = 1 on the wet nodes (W,), 0 elsewhere: at a distance x from a
    straight border 1 - exp(-x / reach). Gauss-Seidel from what `inside` (N,) f32 holds, which
    is 0 beyond the wet nodes. `f` is a `WetFields`, `totals` (N,) are the sums of its weights.
    """
    area, first, last, links, weights = f.area, f.first, f.last, f.links, f.weights
    square = reach * reach
    for sweep in range(sweeps):
        for n in range(wet.shape[0]):
            i = wet[n] if sweep % 2 == 0 else wet[wet.shape[0] - 1 - n]
            own = 1.0 / (area[i] + square * totals[i])  # while what follows is on its way
            inflow = 0.0
            for e in range(first[i], last[i]):
                inflow += weights[e] * inside[links[e]]
            inside[i] = (area[i] + square * inflow) * own


@kernel(error_model="numpy")
def evaporate(wet, f, rest, drying, inside, dried, still_wet):
    """Evaporate water of wet nodes (W,), for the time that each one's block is owed over `rest`.

    What is left below the residual saturation hangs together no longer: what comes later has to
    fill these pores anew, and stops where it stopped in dry ones.

    Parameters
    ----------
    wet : (W,) i32
    f : WetFields
        Its water is changed, and `soaked` where that moves no longer.
    rest : f64
        s.
    drying : Drying
    inside : (N,) f32
        See `solve_edges`.
    dried : (W,) i32
        Filled with the nodes that are dry then.
    still_wet : (B,) bool
        Set for the blocks of others.

    Returns
    -------
    int
        How many are dry.
    """
    block, owed, water = f.block, f.owed, f.water
    rate, gain, dry, capacity = drying
    n_dried = 0
    for n in range(wet.shape[0]):
        i = wet[n]
        b = block[i]
        water[i] -= max(0.0, owed[b] - rest) * rate * (1.0 + gain * (1.0 - inside[i]))
        if water[i] <= dry:
            water[i] = 0.0
            dried[n_dried] = i
            n_dried += 1
            continue
        still_wet[b] = True
        if water[i] < capacity * f.residual[i]:
            f.soaked[i] = min(f.soaked[i], np.float32(water[i] / f.entry_depth[i]))
    return n_dried


@kernel(error_model="numpy")
def ease_entries(nodes, f, dry_entry):
    """Lower the entry potentials of what is dry, the more the fuller its neighbours are.

    Menisci that come from several sides meet in a pore, and fill it at less than each would need
    (cooperative filling: Cieplak, Robbins, *Phys. Rev. Lett.* 60, 2042, 1988). So no single place
    stays bare in a wash, nor in a notch of its border; along a straight one nothing changes.

    Parameters
    ----------
    nodes : (K,) i32
    f : WetFields
        `entry` is changed where it is dry.
    dry_entry : (N,) f64
        That of a dry node with nothing wet around it.
    """
    entry, first, last, links, weights = f.entry, f.first, f.last, f.links, f.weights
    for n in range(nodes.shape[0]):
        i = nodes[n]
        if f.soaked[i] >= 1.0 or first[i] == last[i]:
            continue
        filled, total = 0.0, 0.0
        for e in range(first[i], last[i]):
            total += weights[e]
            fuller = max(f.soaked[links[e]] - f.soaked[i], 0.0)
            filled += weights[e] * fuller / (1.0 - f.soaked[i])
        if total > 0.0:
            entry[i] = dry_entry[i] * min(
                max((_FILLS - filled / total) / (_FILLS - _NOTCH), 0.0), 1.0
            )


@kernel
def activate_cells(field, cells, first):
    """Refine cells (C,) from the first-th on; return how many are done: fewer for want of room."""
    for n in range(first, cells.shape[0]):
        if field.done[cells[n]] == 0 and activate_cell(field, cells[n]) < 0:
            return n
    return cells.shape[0]


# ---- Pigment -------------------------------------------------------------------------------------
# The pigment on a surface's vertices and that on the nodes of its wet part, each after the other.
#
# N vertices, C places (vertices of the wet part), K nodes, B blocks and P pigments: see
# `surface.wet_patch`.


@kernel
def give_back(vertices, node_of, changed, pigment, soaked, written, ink, out):
    """Put pigment back on the vertices of nodes where it moved; ink that came since stays there.

    Parameters
    ----------
    vertices, node_of : (C,) i32
        Of each place.
    changed : (K,) bool
        Nodes where it moved; none afterwards.
    pigment, soaked : (K, P) f64, (K,) f32
        Coats times the covered fraction, and that fraction.
    written : (C, P) f32
        What was put there before, and is now.
    ink : InkField
        Of all vertices; changed.
    out : (C,) i32
        Filled with these vertices.

    Returns
    -------
    int
        How many they are.
    """
    amounts, coverage = ink.amounts, ink.coverage
    count = 0
    for place in range(vertices.shape[0]):
        node = node_of[place]
        if not changed[node]:
            continue
        vertex = vertices[place]
        inked = False
        for p in range(written.shape[1]):
            amount = np.float32(pigment[node, p])
            now, before = amounts[vertex, p], written[place, p]
            if now == before:
                amounts[vertex, p] = amount
            else:
                amounts[vertex, p] = max(now + (amount - before), np.float32(0.0))
            written[place, p] = amount
            inked = inked or amount != 0.0
        if inked:
            coverage[vertex] = max(coverage[vertex], soaked[node])
        out[count] = place
        count += 1
    for n in range(count):  # several vertices may share a node
        place = out[n]
        changed[node_of[place]] = False
        out[n] = vertices[place]
    return count


@kernel
def mark_news(ids, place, node_of, block, block_open, written, amounts, out):
    """Mark vertices (N,) whose ink is not what was put there, or lies where no links are known.

    `place` (N,) i32 is theirs or -1, `block` (K,) i32, `block_open` (B,) bool; `out` (N,) bool is
    filled, the others are as in `give_back`.
    """
    for n in range(ids.shape[0]):
        vertex, at = ids[n], place[n]
        wet = differs = False
        for p in range(written.shape[1]):
            amount = amounts[vertex, p]
            wet = wet or amount != 0.0
            differs = differs or amount != (written[at, p] if at >= 0 else np.float32(0.0))
        out[n] = differs or (wet and not block_open[block[node_of[at]]])

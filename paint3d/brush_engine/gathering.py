"""Gather the vertices that a sweep covers, and weigh them."""

from __future__ import annotations

from paint3d.brush_engine.coverage import weigh_block
from paint3d.brush_engine.distance import INSIDE
from paint3d.brush_engine.projecting import take_run, vertices_of
from paint3d.brush_engine.sweep import Sweep
from paint3d.brush_engine.vertex_query import VISITED, find_candidates, next_block
from paint3d.core.kernel import uncounted

__all__ = ["gather"]


@uncounted(error_model="numpy", forceinline=True)
def gather(before, after, field, scratch):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    sweep = Sweep(scratch.sweep, scratch.between, before, after)
    n_runs, n_cells = find_candidates(sweep, False, field, scratch)
    if n_cells < 0:
        return -1
    found = 0
    runs, values, counters = scratch.query.runs, scratch.sweep[0], scratch.counters
    for r in range(n_runs):
        first, last = runs[r, 0], runs[r, 1]
        if runs[r, 2] == INSIDE:
            counters[VISITED] += last - first
            found = take_run(vertices_of(field), first, last, values, scratch.found, found)
    while True:
        n = next_block(n_runs, n_cells, True, values, field, scratch)
        if n == 0:
            return found
        counters[VISITED] += n
        found = weigh_block(n, sweep, scratch.block, scratch.found, found)

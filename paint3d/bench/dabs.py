"""A dab of a brush on a mesh that is as fine as the colours want it, and on larger and larger ones.

A dab is everything: contact, plane, outline, projection, ink, and the colours brought up to date
30 times a second of the stroke's own time. What pen-down costs is the time of a stroke of two dabs
less its dabs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from paint3d.bench.result import Check, Result
from paint3d.bench.strokes import (
    Dab,
    LiveTimes,
    figure_for,
    frames_of,
    make_dab,
    make_grid,
    play,
    play_live,
    record_dabs,
)
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["measure", "measure_scaling", "time_dabs"]

_DABS = 1020  # at a million vertices
_SHORT = 2  # dabs of the stroke from which the cost of pen-down is computed
_ROUNDS = 5
_COVERS = (2_000, 20_000)
_MOST_PEN_DOWN_MS = 1.0


@dataclass(frozen=True)
class DabTimes:
    """Cost of dabs on one surface.

    Attributes
    ----------
    wall_ms, cpu_ms : float
        A dab.
    colour_ms : float
        Of it, the colours (wall).
    live_cpu_ms : float
        A dab of the same stroke painted as it comes in.
    pen_down_ms : float
        A stroke without its dabs (wall).
    visited, painted : float
        Vertices a dab.
    changed : int
        Vertices that carry paint at the end.
    """

    wall_ms: float
    cpu_ms: float
    colour_ms: float
    live_cpu_ms: float
    pen_down_ms: float
    visited: float
    painted: float
    changed: int


def time_dabs(surface: PaintedSurface, dab: Dab, recording: Recording, rounds: int) -> DabTimes:
    """Paint a stroke of one dab a sample repeatedly; measure a dab and pen-down."""
    painter = Painter(surface, brush=dab.brush)
    n = len(recording)
    short = _SHORT
    strokes = {n: recording, short: recording.part(0, short)}
    for stroke in strokes.values():
        play(painter, stroke)  # compiles, and brings the first pages in
    before = painter.report()
    best: dict[int, LiveTimes] = {}
    for _ in range(rounds):
        for size, stroke in strokes.items():
            times = play(painter, stroke)
            best[size] = best[size].best(times) if size in best else times
    after = painter.report()
    steps = rounds * (n + short)

    frames = frames_of(recording)
    live = min(play_live(painter, frames).whole.cpu_s for _ in range(rounds))
    long_, short_ = best[n], best[short]
    per_dab = 1e3 / (n - short)
    wall = per_dab * (long_.whole.wall_s - short_.whole.wall_s)
    return DabTimes(
        wall_ms=wall,
        cpu_ms=per_dab * (long_.whole.cpu_s - short_.whole.cpu_s),
        colour_ms=per_dab * (long_.colour_s - short_.colour_s),
        live_cpu_ms=1e3 * live / n,
        pen_down_ms=1e3 * short_.whole.wall_s - short * wall,
        visited=(after["vertices_visited"] - before["vertices_visited"]) / steps,
        painted=(after["deposits"] - before["deposits"]) / steps,
        changed=int(np.count_nonzero(surface.coverage)),
    )


def measure(scale: float = 1.0) -> Result:
    """Measure dabs over 2,000 and 20,000 vertices, and pen-down at one and four million."""
    dab = make_dab()
    rows, checks = [], []
    for n_vertices, covers in ((1_000_000, _COVERS), (4_000_000, _COVERS[:1])):
        for cover in covers:
            n, under = max(400, int(n_vertices * scale)), max(12, int(cover * scale))
            mesh = make_grid(n, (dab.footprint.area / under) ** 0.5)
            centres = figure_for(mesh, dab.radius, max(40, int(_DABS * scale)))
            surface = PaintedSurface(mesh, resolution=None)
            times = time_dabs(surface, dab, record_dabs(dab, centres), _ROUNDS)
            rows.append(
                [surface.n_vertices, under, times.wall_ms, times.cpu_ms, times.colour_ms,
                 times.live_cpu_ms, 1e6 * times.cpu_ms / max(1.0, times.visited), times.visited,
                 times.painted, times.pen_down_ms]
            )  # fmt: skip
            checks.append(
                Check(
                    f"pen-down at {surface.n_vertices:,} vertices, {under:,} under the brush",
                    times.pen_down_ms,
                    _MOST_PEN_DOWN_MS,
                    unit="ms",
                )
            )
    return Result(
        "A whole dab on one core, colours included",
        ["vertices", "under brush", "ms/dab", "CPU ms/dab", "colours ms", "CPU ms as it comes in",
         "CPU ns/visited", "visited/dab", "painted/dab", "pen-down ms"],
        rows,
        checks,
        ["tests/benchmarks/peer_dabs.py runs the same dabs beside another program."],
    )  # fmt: skip


# ---- On larger and larger objects ----------------------------------------------------------------

_SIZES = (100_000, 1_000_000, 4_000_000)
_COVER = 2_000
_SIZE_ROUNDS = 7
_MOST_RATIO = 1.3


def measure_scaling(scale: float = 1.0) -> Result:
    """Measure a footprint on grids of 100 thousand, 1 million and 4 million vertices, by turns.

    It covers the same number of vertices along the same figure at the same steps: only the object
    grows.
    """
    dab = make_dab()
    under = max(12, int(_COVER * scale))
    spacing = (dab.footprint.area / under) ** 0.5
    painters, strokes = [], []
    for size in _SIZES:
        mesh = make_grid(max(400, int(size * scale)), spacing)
        n_dabs = max(20, int(_DABS * (size * scale / 1e6) ** 0.5))
        painters.append(Painter(PaintedSurface(mesh, resolution=None), brush=dab.brush))
        strokes.append(record_dabs(dab, figure_for(mesh, dab.radius, n_dabs)))
    best: dict[int, LiveTimes] = {}
    for _ in range(_SIZE_ROUNDS + 1):
        for i, (painter, stroke) in enumerate(zip(painters, strokes, strict=True)):
            times = play(painter, stroke)
            best[i] = times.best(best[i]) if i in best else times
    rows = []
    for painter, times in zip(painters, best.values(), strict=True):
        counts = painter.report()
        each = counts["footprints"] / (_SIZE_ROUNDS + 1)
        rows.append(
            [painter.surface.n_vertices, each, counts["vertices_visited"] / counts["footprints"],
             1e6 * times.whole.wall_s / each, 1e6 * times.whole.cpu_s / each]
        )  # fmt: skip
    for row in rows:
        row.append(row[4] / rows[0][4])
    names = [f"{row[0]:,}" for row in rows]
    return Result(
        "Cost of a footprint as the object grows",
        ["vertices", "footprints", "visited/footprint", "us", "CPU us", "CPU ratio"],
        rows,
        [
            Check(f"cost at {names[i]} over {names[0]} vertices", rows[i][5], _MOST_RATIO)
            for i in range(1, len(rows))
        ],
    )

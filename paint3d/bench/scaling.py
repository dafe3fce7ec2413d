"""Cost of a footprint on larger and larger objects.

The same footprint over the same number of vertices, along the same figure at the same steps, on
grids of 100 thousand, 1 million and 4 million vertices. Only the object grows.
"""

from __future__ import annotations

from paint3d.bench.live import LiveTimes, play
from paint3d.bench.result import Check, Result
from paint3d.bench.strokes import figure_for, make_dab, make_grid, record_dabs
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["measure"]

_SIZES = (100_000, 1_000_000, 4_000_000)
_COVER = 2_000
_DABS = 1020  # at a million vertices
_ROUNDS = 7
_MOST = 1.3


def measure(share: float = 1.0) -> Result:
    """Cost a footprint on the three grids; they take turns."""
    dab = make_dab()
    under = max(12, int(_COVER * share))
    spacing = (dab.footprint.area / under) ** 0.5
    painters, strokes = [], []
    for size in _SIZES:
        mesh = make_grid(max(400, int(size * share)), spacing)
        n_dabs = max(20, int(_DABS * (size * share / 1e6) ** 0.5))
        painters.append(Painter(PaintedSurface(mesh, resolution=None), brush=dab.brush))
        strokes.append(record_dabs(dab, figure_for(mesh, dab.radius, n_dabs)))
    best: dict[int, LiveTimes] = {}
    for _ in range(_ROUNDS + 1):
        for i, (painter, stroke) in enumerate(zip(painters, strokes, strict=True)):
            found = play(painter, stroke)
            best[i] = found.best(best[i]) if i in best else found
    rows = []
    for painter, found in zip(painters, best.values(), strict=True):
        counts = painter.report()
        each = counts["footprints"] / (_ROUNDS + 1)
        rows.append(
            [painter.surface.n_vertices, each, counts["vertices_visited"] / counts["footprints"],
             1e6 * found.whole.wall_s / each, 1e6 * found.whole.cpu_s / each]
        )  # fmt: skip
    for row in rows:
        row.append(row[4] / rows[0][4])
    names = [f"{row[0]:,}" for row in rows]
    return Result(
        "Cost of a footprint as the object grows",
        ["vertices", "footprints", "visited/footprint", "us", "CPU us", "CPU ratio"],
        rows,
        [
            Check(f"cost at {names[i]} over {names[0]} vertices", rows[i][5], _MOST)
            for i in range(1, len(rows))
        ],
    )

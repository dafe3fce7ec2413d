"""Benchmarks in processes of their own: memory of a painting, and time to start."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from paint3d.bench.result import Check, Result
from paint3d.bench.start import Waited, wait_for

__all__ = ["measure_import", "measure_memory"]

_VERTICES = 4_000_000
_MOST_GB = 2.0
_MOST_IMPORT_S = 0.5
_ROUNDS = 5

_PAINT = """
import json, sys, time
from paint3d.bench.strokes import figure_for, make_dab, make_grid, record_dabs
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

def peak_kb():
    for line in open("/proc/self/status"):
        if line.startswith("VmHWM"):
            return int(line.split()[1])

n, n_dabs = int(sys.argv[1]), int(sys.argv[2])
dab = make_dab()
mesh = make_grid(n, (dab.footprint.area / max(12, n // 500)) ** 0.5)
mesh_kb, started = peak_kb(), time.perf_counter()
surface = PaintedSurface(mesh, resolution=None)
built = time.perf_counter() - started
built_kb = peak_kb()
painter = Painter(surface, brush=dab.brush)
painter.replay(record_dabs(dab, figure_for(mesh, dab.radius, n_dabs)))
surface.refresh()
print(json.dumps({"vertices": surface.n_vertices, "build_s": built, "mesh_kb": mesh_kb,
                  "built_kb": built_kb, "peak_kb": peak_kb()}))
"""

_FIRST_DAB = """
from paint3d.bench.strokes import figure_for, make_dab, make_grid, record_dabs
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
dab = make_dab()
mesh = make_grid(400, dab.radius / 5)
surface = PaintedSurface(mesh, resolution=None)
Painter(surface, brush=dab.brush).replay(record_dabs(dab, figure_for(mesh, dab.radius, 4)))
surface.refresh()
"""

_STARTS = {
    "python alone": "pass",
    "import paint3d": "import paint3d",
    "paint3d --help": "from paint3d.cli.main import main; import sys; sys.argv = ['paint3d']; "
    "sys.stdout = open('/dev/null', 'w'); main(['--help'])",
    "first dab, loops compiled before": _FIRST_DAB,
}


def _run(code: str, *arguments: str) -> Waited:
    return wait_for((sys.executable, "-c", code, *arguments), Path.cwd())


def measure_memory(scale: float = 1.0) -> Result:
    """Measure the peak resident memory of a process that paints on 4 million vertices.

    Raises
    ------
    Paint3DError
        If that process fails.
    """
    n = max(400, int(_VERTICES * scale))
    figures = json.loads(_run(_PAINT, str(n), str(max(4, int(1000 * scale)))).lines[-1][1])
    gigabytes = {name: figures[f"{name}_kb"] * 1024 / 1e9 for name in ("mesh", "built", "peak")}
    return Result(
        f"Memory of a process that paints on {figures['vertices']:,} vertices",
        ["vertices", "build s", "peak GB, mesh made", "peak GB, surface built", "peak GB, painted"],
        [[figures["vertices"], figures["build_s"], *gigabytes.values()]],
        [Check("peak resident memory", gigabytes["peak"], _MOST_GB, unit="GB")],
    )


def measure_import(scale: float = 1.0) -> Result:
    """Measure the time from starting Python to having paint3d, and to the first dab.

    Raises
    ------
    Paint3DError
        If a process fails.
    """
    _run(_FIRST_DAB)  # compiles what was never compiled
    best = dict.fromkeys(_STARTS, float("inf"))
    for _ in range(max(1, round(_ROUNDS * scale))):
        for name, code in _STARTS.items():
            best[name] = min(best[name], _run(code).wall_s)
    alone = best["python alone"]
    return Result(
        "Starting, in a new process",
        ["what", "s", "s more than Python"],
        [[name, seconds, seconds - alone] for name, seconds in best.items()],
        [Check("import paint3d", best["import paint3d"], _MOST_IMPORT_S, unit="s")],
    )

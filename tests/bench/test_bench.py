"""The benchmarks run, and what they time is what they say; no test here looks at a clock."""

from __future__ import annotations

import json
import math
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from paint3d.bench.dabs import time_dabs
from paint3d.bench.gathering import PlainSurface
from paint3d.bench.registry import BENCHMARKS, run_benchmark
from paint3d.bench.result import Result
from paint3d.bench.start import wait_for
from paint3d.bench.stopwatch import Times, best_of, watch_steal
from paint3d.bench.strokes import (
    FRAME_HZ,
    figure_for,
    frames_of,
    make_dab,
    make_grid,
    play,
    play_live,
    record_dabs,
    refined_surface,
)
from paint3d.errors import InputError, Paint3DError, UnknownNameError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

TINY = 0.002
LONG = ("bristles", "haptics", "kernel", "memory", "start", "studio")
PEER = Path(__file__).parents[1] / "benchmarks" / "peer_dabs.py"


def numbers(result: Result) -> list[float]:
    return [cell for row in result.rows for cell in row if isinstance(cell, int | float)]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long if name in LONG else ())
        for name in sorted(BENCHMARKS)
    ],
)
def test_every_benchmark_runs(name: str) -> None:
    result = run_benchmark(name, TINY)
    assert result.rows
    assert np.isfinite(numbers(result)).all()
    assert all(math.isfinite(check.value) for check in result.checks)
    json.dumps(result.as_dict(), allow_nan=False)
    assert result.notes[-1].startswith("Load average")


def test_the_time_that_the_host_gave_to_others_is_measured(tmp_path) -> None:
    """Ticks of /proc/stat: user nice system idle iowait irq softirq steal guest guest_nice."""
    file = tmp_path / "stat"
    file.write_text("cpu  100 0 50 800 0 0 0 10 70 0\ncpu0 1 2 3\n")
    fraction = watch_steal(file)
    assert fraction() is None  # no time has passed
    file.write_text("cpu  150 0 60 820 0 0 0 30 90 0\ncpu0 1 2 3\n")
    assert fraction() == pytest.approx(20 / 100)
    file.write_text("cpu  150 0 60\n")
    assert fraction() is None
    file.unlink()
    assert fraction() is None
    assert watch_steal(file)() is None


def test_unknown_benchmark() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'replay'"):
        run_benchmark("replya")


@pytest.mark.parametrize("share", [0.0, -1.0, 1.5, math.nan])
def test_share_out_of_range(share: float) -> None:
    with pytest.raises(InputError, match="expected above 0"):
        run_benchmark("colours", share)


def test_rows_are_as_long_as_the_columns() -> None:
    with pytest.raises(InputError, match="a row has 1 cells; expected 2"):
        Result("T", ["a", "b"], [["r"]])


def test_best_of_takes_the_smallest_of_each() -> None:
    assert Times(1.0, 4.0).best(Times(2.0, 3.0)) == Times(1.0, 3.0)
    calls: list[str] = []
    best_of(2, lambda: calls.append("timed"), before=lambda: calls.append("before"))
    assert calls == ["before", "timed"] * 2


def test_grid_is_square_and_faces_up() -> None:
    mesh = make_grid(30, 0.5)
    assert mesh.n_vertices == 36
    assert mesh.area == pytest.approx(2.5**2)
    np.testing.assert_allclose(mesh.face_normals, np.tile([0, 0, 1], (mesh.n_faces, 1)))


def test_frames_hold_every_sample_once_in_its_own_frame() -> None:
    dab = make_dab()
    recording = record_dabs(dab, np.zeros((50, 3)))
    frames = frames_of(recording)
    times = [sample.time_ns for frame in frames for sample in frame]
    assert times == list(recording.time_ns)
    for k, frame in enumerate(frames):
        assert all(k <= s.time_ns * 1e-9 * FRAME_HZ < k + 1 for s in frame)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, -1.0, 0.0)])
def test_a_dab_covers_the_area_it_says_where_it_says(normal: tuple[float, float, float]) -> None:
    dab = make_dab()
    flat = make_grid(90_000, dab.radius / 40)
    stroke = record_dabs(dab, np.zeros((2, 3)), normal)
    turn = _frame(normal)
    mesh = type(flat)(flat.vertices @ turn.T, flat.faces)
    surface = PaintedSurface(mesh, resolution=None)
    play(Painter(surface, brush=dab.brush), stroke)
    weight = surface.vertex_areas * surface.coverage
    assert weight.sum() == pytest.approx(math.pi * dab.radius**2, rel=0.01)
    middle = 0.5 * sum(
        f(surface.paint_mesh.vertices[surface.coverage > 0.5], axis=0) for f in (np.min, np.max)
    )
    assert np.linalg.norm(middle) < 0.1 * dab.radius


def _frame(normal: tuple[float, float, float]) -> np.ndarray:
    up = np.asarray(normal)
    along = np.cross([0.28, 0.96, 0.1], up)
    along /= np.linalg.norm(along)
    return np.stack([along, np.cross(up, along), up], axis=1)


def test_both_ways_of_playing_paint_the_same() -> None:
    dab = make_dab()
    mesh = make_grid(10_000, dab.radius / 10)
    recording = record_dabs(dab, figure_for(mesh, dab.radius, 30))
    painters = [Painter(PaintedSurface(mesh, resolution=None), brush=dab.brush) for _ in range(2)]
    play(painters[0], recording)
    play_live(painters[1], frames_of(recording))
    np.testing.assert_array_equal(painters[0].surface.srgb, painters[1].surface.srgb)
    np.testing.assert_array_equal(painters[0].surface.amounts, painters[1].surface.amounts)


def test_the_competitor_paints_the_same_vertices() -> None:
    dab = make_dab()
    surface = PaintedSurface(make_grid(40_000, dab.radius / 25), resolution=None)
    plain = PlainSurface(surface)
    play(Painter(surface, brush=dab.brush), record_dabs(dab, np.zeros((2, 3))))
    along = np.array([1.0, 0.0, 0.0])
    seen = plain.stamp(-dab.middle * along, along, dab.footprint, (np.zeros(3), 30.0), 5.0)
    ours, theirs = surface.coverage > 0.5, plain.coverage > 0.5
    assert (ours & theirs).sum() / (ours | theirs).sum() > 0.97
    assert seen > theirs.sum()
    assert plain.amounts @ plain.areas == pytest.approx(5.0, rel=1e-4)
    assert (plain.dirty == (plain.coverage > 0)).all()


def test_a_refined_surface_has_the_vertices_asked_for_and_every_edge_fine() -> None:
    surface = refined_surface(load_mesh("sphere"), 30_000)
    assert 30_000 <= surface.n_vertices < 4 * 30_000
    corners = surface.paint_mesh.vertices[surface.paint_mesh.leaf_faces()].astype(float)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges.max() <= surface.resolution * 1.0001


def test_dabs_are_counted_per_dab() -> None:
    dab = make_dab()
    mesh = make_grid(10_000, dab.radius / 10)
    recording = record_dabs(dab, figure_for(mesh, dab.radius, 60))
    surface = PaintedSurface(mesh, resolution=None)
    found = time_dabs(surface, dab, recording, rounds=1)
    assert found.changed == np.count_nonzero(surface.coverage)
    assert found.painted >= 250  # 314 vertices under the brush
    assert found.visited >= found.painted


def test_the_peer_script_keeps_its_contract(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    side, spacing = 60, 0.01
    grid = make_grid(side * side, spacing)
    lines = [f"{x:.6g} {y:.6g} {z:.6g}" for x, y, z in grid.vertices.astype(float)]
    lines += [f"3 {a} {b} {c}" for a, b, c in grid.faces]
    (tmp_path / "mesh.ply").write_text(
        f"ply\nformat ascii 1.0\nelement vertex {len(grid.vertices)}\nproperty float x\n"
        f"property float y\nproperty float z\nelement face {len(grid.faces)}\n"
        "property list uchar int vertex_indices\nend_header\n" + "\n".join(lines) + "\n"
    )
    dabs = {
        "radius_world": 0.05,
        "dabs_world": figure_for(grid, 0.05, 40).tolist(),
        "normal": [0.0, 0.0, 1.0],
    }
    (tmp_path / "dabs.json").write_text(json.dumps(dabs))
    monkeypatch.setattr(
        sys, "argv", [str(PEER), str(tmp_path / "mesh.ply"), str(tmp_path / "dabs.json")]
    )
    runpy.run_path(str(PEER), run_name="__main__")
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    keys = {"ms_per_dab", "cpu_ms_per_dab", "ms_per_stroke_fixed", "changed_total"}
    assert keys <= set(found)
    assert found["verts"] == side * side
    assert 0 < found["changed_total"] <= side * side


def test_waiting_is_for_a_process_with_its_children_in_its_own_home(tmp_path: Path) -> None:
    """Time to each line, the children's time and memory, too; what lies at home is not seen."""
    home = tmp_path / "home"
    home.mkdir()
    child = "x = bytearray(b'a' * 60_000_000); k = sum(range(12_000_000))"
    code = (
        "import os, subprocess, sys; print(os.path.expanduser('~'), flush=True); "
        f"subprocess.run([sys.executable, '-c', {child!r}]); print('done')"
    )
    found = wait_for((sys.executable, "-c", code), tmp_path, home=home, measure_memory=True)
    assert [line for _, line in found.lines] == [str(home), "done"]
    assert 0.0 < found.until(str(home)) < found.until("done") <= found.wall_s
    assert found.cpu_s > 0.0
    assert found.peak_mb is None or found.peak_mb > 60.0
    assert found.peak_mb is not None or not Path("/proc/self/statm").exists()
    with pytest.raises(Paint3DError, match="did not write 'more'"):
        found.until("more")


def test_waiting_for_what_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(Paint3DError, match=r"failed: paint3d: error: .*no-such-ink"):
        wait_for(
            (sys.executable, "-m", "paint3d", "write", "一", "--ink", "no-such-ink",
             "--on", "bowl", "--out", "x.glb"),
            tmp_path,
        )  # fmt: skip

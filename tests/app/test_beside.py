"""What takes long is not done in the thread that the window lives in."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.app.window.files.open_result import some_points
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import guess_up
from paint3d.view.camera import View, fit_camera
from paint3d.view.live_light import LiveLight
from paint3d.view.live_patches import LivePatches
from tests.support.app.windows import opened

LONG = (ClosestPoints, LiveLight, LivePatches)  # to be made: seconds a million triangles

# A process of its own: the kernels of this one are ready. What one thread makes ready makes all
# others wait that need any kernel, and brushes of many hairs take minutes.
FIRST = """
import sys, threading
from numba.core.dispatcher import Dispatcher
from paint3d.app.window.start import make_program
from tests.support.app.gestures import BUTTON, drag, pen_stroke
from tests.support.app.windows import light_by_few, opened, settled

light_by_few()
make_ready, found = Dispatcher.compile, []

def tell(kernel, signature):
    if threading.current_thread() is threading.main_thread():
        found.append(kernel.py_func.__name__)
    return make_ready(kernel, signature)

Dispatcher.compile = tell
with opened(make_program(), sys.argv[1]) as window:
    canvas = window.canvas
    pen_stroke(canvas, (0.45, 0.5), (0.55, 0.55), [0.3] * 12)
    drag(canvas, (0.4, 0.4), (0.6, 0.5), BUTTON.RightButton)
    drag(canvas, (0.45, 0.55), (0.55, 0.5))
    settled(window)
    assert window.stage.draw() is not None or window.stage.frame is not None
    assert window.document.strokes
    print("in the window's thread:", *found)
"""


@pytest.mark.parametrize("name", [pytest.param("plane", marks=pytest.mark.long), "sphere"])
def test_no_kernel_is_made_ready_in_the_windows_thread(name: str, screen: str, places) -> None:
    assert screen
    assert places
    command = [sys.executable, "-c", FIRST, name]
    root = Path(__file__).parents[2]
    done = subprocess.run(command, capture_output=True, text=True, cwd=root, check=False)
    assert done.stdout.splitlines()[-1:] == ["in the window's thread:"], done.stderr[-2000:]


def test_an_object_is_examined_beside_the_window(
    program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, found = threading.main_thread(), []

    def watched(before: Callable[..., object], what: str) -> Callable[..., object]:
        def told(*args: object, **options: object) -> object:
            found.append((what, threading.current_thread() is here))
            return before(*args, **options)

        return told

    for kind in LONG:
        monkeypatch.setattr(kind, "__init__", watched(kind.__init__, kind.__name__))
    reading = sys.modules["paint3d.files.reading"]
    monkeypatch.setattr(reading, "guess_up", watched(guess_up, guess_up.__name__))
    is_solid = watched(TriangleMesh.is_solid.func, "is_solid")
    monkeypatch.setattr(TriangleMesh, "is_solid", property(is_solid))
    path = tmp_path / "ball.ply"
    paint3d.export(load_mesh("sphere"), path)
    with opened(program, str(path)):
        pass
    wanted = {kind.__name__ for kind in LONG} | {guess_up.__name__, "is_solid"}
    assert {what for what, _ in found} == wanted
    assert not any(in_window for _, in_window in found)


def test_a_camera_is_placed_as_well_by_some_of_the_points() -> None:
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(200_000, 3))
    points = 80.0 * ways / np.linalg.norm(ways, axis=1, keepdims=True) * [1.0, 0.4, 0.7]
    points = np.concatenate([points, [[0.0, 0.0, 120.0]]]).astype(np.float32)
    some = some_points(points)
    assert len(some) < 70_000
    assert np.array_equal(some.max(axis=0), points.max(axis=0))
    assert np.array_equal(some.min(axis=0), points.min(axis=0))
    for direction in rng.normal(size=(8, 3)):
        view = View(direction)
        all_of_it, by_some = (fit_camera(where, view, 1.4) for where in (points, some))
        away = np.linalg.norm(all_of_it.position - all_of_it.focus)
        assert np.linalg.norm(all_of_it.position - by_some.position) < 0.005 * away
    assert np.array_equal(some_points(points[:1000]), points[:1000])

"""A pen's marks on objects with sharp edges, grooves and steps: under the pen, and nowhere else."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

import paint3d
from paint3d.app.window.studio import StudioWindow
from paint3d.brush.bending import build_tuft
from paint3d.brush_engine.tuft import (
    OUTLINE_CAPACITY,
    SCRATCH_SIZE,
    greatest_descent,
    trace_outline,
)
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.app.event_player import DeviceEvent, EventRecording, open_for, pixel_of
from tests.support.app.marks import off_the_way, stations, stray
from tests.support.app.trials import blind_window, faults, try_strokes
from tests.support.examples import ALL

LENGTH_MM = 140.0
# beside an outline, at 1 mm: half its soft edge, from a vertex with paint towards a bare one as far
# as `INKED`, and half of the longest sweep
BESIDE_MM = 0.3 + 0.75 + 0.6
STEPS = [(-60, 0), (-60, 12), (-36, 12), (-36, 24), (-12, 24), (-12, 36), (60, 36), (60, 0)]
DOWN_THE_STEPS = [(-18, -12, 24), (-36, -4, 24), (-36, 2, 12), (-54, 10, 12)]
UP_THE_STEPS = [(-50, -6, 12), (-36, 0, 12), (-36, 3, 24), (-16, 14, 24)]
STEP_MS, SPEED_MM_S = 10, 80.0


@pytest.fixture(scope="module")
def window(program):
    """A window that draws no pictures."""
    with blind_window(program) as window:
        yield window


def drawn_out(outline: Sequence[tuple[float, float]], length_mm: float = LENGTH_MM) -> TriangleMesh:
    """A bar of that cross section, (x, z) clockwise; its ends are open, its edges sharp."""
    at = np.array(outline, float)
    vertices: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int]] = []
    for a, b in zip(at, np.roll(at, -1, axis=0), strict=True):
        for x, z in (a, b):
            vertices += [(x, -0.5 * length_mm, z), (x, 0.5 * length_mm, z)]
        k = len(vertices) - 4
        faces += [(k, k + 3, k + 1), (k, k + 2, k + 3)]
    return TriangleMesh(np.array(vertices), np.array(faces))


def over(window: StudioWindow, corners, tilt: tuple[float, float]) -> EventRecording:
    """One stroke along a line through these places on the object, mm, in the view of now."""
    line = np.array(corners, float)
    behind = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, behind[-1], round(behind[-1] / SPEED_MM_S * 1000.0 / STEP_MS))
    size = window.canvas.width(), window.canvas.height()
    events = []
    for k, d in enumerate((*at, at[-1])):
        place = [np.interp(d, behind, column) for column in line.T]
        pixel = np.array(pixel_of(window, place, None)) / size
        kind = "press" if k == 0 else "release" if k == len(at) else "move"
        down = kind != "release"
        events.append(
            DeviceEvent("pen", kind, tuple(pixel), 0.25 * down, tilt, 0.0, ("left",) * down,
                        time_ms=STEP_MS * k, handled_ms=STEP_MS * k + 3)
        )  # fmt: skip
    return EventRecording({"places": "canvas", "aspect": size[0] / size[1]}, tuple(events))


def footprint_reach(window: StudioWindow, tilt: tuple[float, float], pressure=0.25) -> float:
    """How far a footprint's ends lie from its middle if the pen leans along its bend, mm."""
    tuft = build_tuft(window.document.painter.brush)
    lean = math.atan(math.hypot(*(math.tan(math.radians(angle)) for angle in tilt)))
    angle = max(0.5 * math.pi - lean, tuft.lowest_tilt)
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    descent = min(pressure * tuft.full_press, greatest_descent(tuft, angle))
    n = trace_outline(tuft, descent, angle, pressure, np.empty(SCRATCH_SIZE), reach, half)
    return 0.5 * float(reach[0] - reach[n - 1])


@pytest.mark.parametrize(
    "way",
    [
        pytest.param(DOWN_THE_STEPS, id="down"),
        pytest.param(UP_THE_STEPS, id="up", marks=pytest.mark.long),
    ],
)
def test_over_steps_a_pen_paints_under_its_point_and_nowhere_else(window, tmp_path, way) -> None:
    path = tmp_path / "steps.ply"
    paint3d.export(drawn_out(STEPS), path)
    open_for(window, {"object": str(path), "material": "porcelain"}, 1.0)
    source = window.document.surface.source
    np.testing.assert_allclose(np.ptp(source.vertices, axis=0)[2], 36.0)
    lowest = source.vertices[source.faces][:, :, 2].min(axis=1)
    assert source.face_normals[np.argmax(lowest), 2] > 0.9  # it is seen from outside
    camera = window.hand.camera
    away = np.array([-1.0, -0.3, 1.0])
    middle = np.array([-36.0, 0.0, 18.0])
    seen_from = middle + 200.0 * away / np.linalg.norm(away)
    window.hand.look(replace(camera, position=seen_from, focus=middle, up=np.array([0, 0, 1.0])))
    told = []
    tilts = ((40.0, 0.0), (-40.0, 20.0), (0.0, 45.0), (20.0, -40.0), (0.0, 0.0))
    for tilt in tilts if ALL else tilts[:3]:
        for trial in try_strokes(window, over(window, way, tilt)):
            told += [f"tilt {tilt}: {fault}" for fault in faults(trial)]
            off = off_the_way(stations(trial.mark, trial.way), ends_mm=1.0)
            if off > 1.0:
                told.append(f"tilt {tilt}: in one place {off:.2f} mm off")
            far = stray(trial.mark, trial.way, 0.0)
            if far > (most := footprint_reach(window, tilt) + BESIDE_MM):
                told.append(f"tilt {tilt}: paint {far:.2f} mm from the way, at most {most:.2f}")
    assert told == []

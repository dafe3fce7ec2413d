"""A pen's marks on objects with sharp edges, grooves and steps: under the pen, and nowhere else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

import paint3d
from paint3d.app.window.studio import StudioWindow
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.app.event_player import DeviceEvent, EventRecording, open_for, pixel_of
from tests.app.marks import stray
from tests.app.trials import HALF_FOOTPRINT, blind_window, faults, try_strokes

LENGTH_MM = 140.0
FARTHEST_MM = 3.0  # beyond half a footprint: what else is painted lies on another face
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
        faces += [(k, k + 1, k + 3), (k, k + 3, k + 2)]
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


@pytest.mark.parametrize("way", [DOWN_THE_STEPS, UP_THE_STEPS], ids=["down", "up"])
def test_over_steps_a_pen_paints_under_its_point_and_nowhere_else(window, tmp_path, way) -> None:
    path = tmp_path / "steps.ply"
    paint3d.export(drawn_out(STEPS), path)
    open_for(window, {"object": str(path), "material": "porcelain"}, 1.0)
    np.testing.assert_allclose(np.ptp(window.document.surface.source.vertices, axis=0)[2], 36.0)
    camera = window.hand.camera
    away = np.array([-1.0, -0.3, 1.0])
    middle = np.array([-36.0, 0.0, 18.0])
    seen_from = middle + 200.0 * away / np.linalg.norm(away)
    window.hand.look(replace(camera, position=seen_from, focus=middle, up=np.array([0, 0, 1.0])))
    told = []
    for tilt in ((0.0, 0.0), (40.0, 0.0), (-40.0, 20.0), (0.0, 45.0), (20.0, -40.0)):
        for trial in try_strokes(window, over(window, way, tilt)):
            told += [f"tilt {tilt}: {fault}" for fault in faults(trial)]
            far = stray(trial.mark, trial.way, HALF_FOOTPRINT)
            if far > FARTHEST_MM:
                told.append(f"tilt {tilt}: {far:.2f} mm astray")
    assert told == []

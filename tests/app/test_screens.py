"""On small screens and fine ones nothing is lost, and the mark lies under the pen."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui

from paint3d.app.window.hand.canvas import CanvasWidget
from tests.support.app.screens import start_screen
from tests.support.cases import long_but


@pytest.mark.parametrize(
    ("size", "ratio"),
    [
        pytest.param("1280x720", 1.0, marks=pytest.mark.long),
        ("1920x1080", 1.5),  # as small as the first for a window, and finer by no whole number
        pytest.param("1920x1200", 1.5, marks=pytest.mark.long),
        pytest.param("2240x1400", 1.75, marks=pytest.mark.long),
        pytest.param("2560x1440", 2.0, marks=pytest.mark.long),
        pytest.param("1366x768", 1.25, marks=pytest.mark.long),
        pytest.param("3840x2160", 1.5, marks=pytest.mark.long),
    ],
)
def test_everything_is_on_the_screen_and_the_mark_under_the_pen(
    size: str, ratio: float, places: Path
) -> None:
    assert places
    display, server = start_screen(size)
    try:
        told = told_by_a_studio({"DISPLAY": display, "QT_SCALE_FACTOR": str(ratio)})
    finally:
        server.terminate()
        server.wait()
    check(told, ratio)


@pytest.mark.long
def test_under_wayland_the_same(places: Path, tmp_path: Path) -> None:
    """Its compositor draws no screen, so that none is needed."""
    assert places
    weston = shutil.which("weston")
    if weston is None:
        pytest.skip("no Wayland compositor: apt-get install weston")
    tmp_path.chmod(0o700)  # as the sockets' folder must be
    own = {"XDG_RUNTIME_DIR": str(tmp_path), "WAYLAND_DISPLAY": "paint3d"}
    server = subprocess.Popen(
        [weston, "--backend=headless-backend.so", "--width=1920", "--height=1200",
         "--socket=paint3d", "--idle-time=0"],
        env={**os.environ, **own}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        until = time.monotonic() + 300.0
        while not (tmp_path / "paint3d").exists():
            assert server.poll() is None, "the compositor did not start"
            assert time.monotonic() < until
            time.sleep(0.05)
        ways = {"QT_QPA_PLATFORM": "wayland", "QT_SCALE_FACTOR": "1.5"}
        told = told_by_a_studio({**own, **ways})
    finally:
        server.terminate()
        server.wait()
    check(told, 1.5)


def told_by_a_studio(environment: dict[str, str]) -> dict:
    """What a studio on that screen says of itself."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.app.on_a_screen"],
        capture_output=True, text=True, cwd=Path(__file__).parents[2], timeout=600, check=False,
        env={**os.environ, **environment},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    told: dict = json.loads(done.stdout.splitlines()[-1])
    return told


def check(told: dict, ratio: float) -> None:
    """Everything is on the screen, as fine as it is, and the mark under the pen."""
    assert told["ratio"] == ratio
    left, top, right, bottom = told["screen"]
    for box in (told["window"], *told["panels"]):
        assert left <= box[0] < box[2] <= right
        assert top <= box[1] < box[3] <= bottom
    wide, high = told["canvas"]
    for box in told["grips"]:
        assert 0 <= box[0] < box[2] <= wide
        assert 0 <= box[1] < box[3] <= high
    for pixels in (told["picture"], told["shown"]):  # drawn as finely as the screen is
        assert np.abs(np.array(pixels) - ratio * np.array([wide, high])).max() <= 1.0
    assert told["off_mm"] < 1.0
    assert told["stale"] == 0
    assert np.abs(np.array(told["dark"]) - [0.5, 0.6]).max() < 0.015


# -- ratios that are no whole number -----------------------------------------------------------


NOTHING = (1, 2, 3)  # codes that no picture has here
PLACE = QtCore.QPoint(35, 30)


def drawn(canvas: CanvasWidget, part: QtCore.QRect, ratio: float) -> np.ndarray:
    """(H, W, 3) codes of a screen on which a part of a widget within a window is drawn."""
    image = QtGui.QImage(760, 580, QtGui.QImage.Format.Format_RGBX8888)
    image.setDevicePixelRatio(ratio)
    image.fill(QtGui.QColor(*NOTHING))
    canvas.render(image, PLACE + part.topLeft(), QtGui.QRegion(part))
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(580, 760, 4)
    return rows[:, :, :3].copy()


def noisy(size, ratio, monkeypatch) -> tuple[CanvasWidget, np.ndarray, np.random.Generator]:
    """A canvas on a screen of this ratio that shows noise, its pixels, and where they are from."""
    canvas, chance = CanvasWidget(), np.random.default_rng(5)
    canvas.resize(*size)
    monkeypatch.setattr(canvas, "devicePixelRatioF", lambda: ratio)
    width, height = canvas.pixel_size
    pixels = chance.integers(8, 255, (height, width, 4)).astype(np.uint8)
    canvas.show_pixels(pixels)
    return canvas, pixels, chance


@pytest.mark.parametrize(
    ("ratio", "size"),
    long_but(
        [(1.25, (323, 241)), (1.5, (320, 240)), (1.75, (323, 241)), (2.0, (320, 240))],
        product((1.0, 1.25, 1.5, 1.75, 2.0), ((323, 241), (320, 240))),
    ),
)
def test_parts_are_shown_as_the_whole_is(program, ratio, size, monkeypatch) -> None:
    canvas, pixels, chance = noisy(size, ratio, monkeypatch)
    whole = drawn(canvas, canvas.rect(), ratio)
    shown = (whole != NOTHING).any(axis=2)
    rows, columns = np.flatnonzero(shown.any(axis=1)), np.flatnonzero(shown.any(axis=0))
    top, left = rows[0], columns[0]
    assert abs(left - ratio * PLACE.x()) <= 0.5
    assert abs(top - ratio * PLACE.y()) <= 0.5
    for found, wanted in zip((columns.size, rows.size), size, strict=True):
        assert abs(found - ratio * wanted) <= 1.0
    box = np.s_[top : top + rows.size, left : left + columns.size]
    assert shown[box].all()  # no row or column of it is left out
    assert (whole[box] == pixels[::-1][: rows.size, : columns.size, :3]).all()
    for _ in range(12):
        (x0, x1), (y0, y1) = (sorted(chance.choice(side, 2, replace=False)) for side in size)
        part = drawn(canvas, QtCore.QRect(x0, y0, x1 - x0, y1 - y0), ratio)
        changed = (part != NOTHING).any(axis=2)
        assert changed.sum() > 0
        assert (part[changed] == whole[changed]).all()


@pytest.mark.parametrize("ratio", [1.0, 1.25, 1.5, 1.75])
def test_what_has_changed_is_asked_to_be_drawn_whole(program, ratio, monkeypatch) -> None:
    canvas, pixels, chance = noisy((323, 241), ratio, monkeypatch)
    asked = list[QtCore.QRect]()
    height, width = pixels.shape[:2]
    before = drawn(canvas, canvas.rect(), ratio)
    monkeypatch.setattr(canvas, "update", lambda *rects: asked.extend(rects))
    for _ in range(12):
        (x0, x1), (y0, y1) = (
            sorted(int(edge) for edge in chance.choice(side - 1, 2, replace=False))
            for side in (width, height)
        )
        pixels[y0:y1, x0:x1] ^= 255
        canvas.show_pixels(pixels, (x0, y0, x1, y1))
        after = drawn(canvas, canvas.rect(), ratio)
        part = drawn(canvas, asked.pop(), ratio)
        changed = (after != before).any(axis=2)
        assert changed.any()
        assert (part[changed] == after[changed]).all()
        before = after

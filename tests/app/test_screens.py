"""On small screens and fine ones nothing is lost, and the mark lies under the pen."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from tests.support.app.screens import start_screen


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
        until = time.monotonic() + 60.0
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

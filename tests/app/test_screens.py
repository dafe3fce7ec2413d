"""On small screens and fine ones nothing is lost, and the mark lies under the pen."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from tests.support.app.screens import start_screen


@pytest.mark.parametrize(
    ("size", "ratio"),
    [
        pytest.param("1280x720", 1.0, marks=pytest.mark.long),
        ("2560x1440", 2.0),  # as small as the first for a window, and as fine as they are
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
        done = subprocess.run(
            [sys.executable, "-m", "tests.support.app.on_a_screen"],
            capture_output=True, text=True, cwd=Path(__file__).parents[2], timeout=600, check=False,
            env={**os.environ, "DISPLAY": display, "QT_SCALE_FACTOR": str(ratio)},
        )  # fmt: skip
    finally:
        server.terminate()
        server.wait()
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout.splitlines()[-1])
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
    assert np.abs(np.array(told["dark"]) - [0.5, 0.6]).max() < 0.015

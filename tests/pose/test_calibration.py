"""The calibrated brush against presses of a real one."""

from __future__ import annotations

from pathlib import Path

import pytest

from paint3d.brush.fitting import press_errors, read_presses
from paint3d.brush.presets import load_brush

TABLE = Path(__file__).parents[2] / ".." / "shared" / "calibration" / "real_brush.csv"


@pytest.mark.skipif(not TABLE.exists(), reason="the measured presses are not here")
def test_calibrated_brush_is_as_near_as_the_model_says():
    width, heel, length = press_errors(load_brush("calibrated"), read_presses(TABLE))
    assert width < 0.72  # readings of one depth scatter by 1.06
    assert heel < 0.86
    assert length < 2.5

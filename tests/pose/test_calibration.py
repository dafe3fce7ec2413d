"""The calibrated brush against presses of a real one."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from paint3d.errors import InputError

ROOT = Path(__file__).parents[2]
TABLE = ROOT / ".." / "shared" / "calibration" / "real_brush.csv"


@pytest.fixture(scope="module")
def calibration():
    spec = importlib.util.spec_from_file_location(
        "calibrate_brush", ROOT / "scripts" / "calibrate_brush.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif(not TABLE.exists(), reason="the measured presses are not here")
def test_calibrated_brush_is_as_near_as_the_model_says(calibration):
    width, heel, length = calibration.rms_errors("calibrated", TABLE)
    assert width < 0.72  # readings of one depth scatter by 1.06
    assert heel < 0.86
    assert length < 2.5


def test_readings_of_one_depth_are_averaged(calibration, tmp_path):
    table = tmp_path / "presses.csv"
    table.write_text("depth_mm,width_mm,drag_mm,offset_mm\n2,3,4,1\n1,1,1,1\n2,5,2,2\n")
    presses = calibration.read_presses(table)
    assert presses.tolist() == [[1.0, 1.0, 1.0, 1.0], [2.0, 4.0, 1.5, 3.0]]


def test_a_table_without_the_columns_is_refused(calibration, tmp_path):
    table = tmp_path / "presses.csv"
    table.write_text("depth,width\n1,2\n")
    with pytest.raises(InputError, match="depth_mm"):
        calibration.read_presses(table)

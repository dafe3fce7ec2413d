"""Brushes made of what was measured: presses, and bent hairs."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from paint3d.brush.bristles import MEASURED, build_bristles, measured_shapes
from paint3d.brush.fitting import (
    PRESS_COLUMNS,
    fit_presses,
    is_table_of_shapes,
    predict_presses,
    press_errors,
    read_presses,
    read_shapes,
)
from paint3d.brush.presets import brush_text, load_brush, load_presets, write_brush
from paint3d.brush.spec import BristleSpec, shape_rows
from paint3d.errors import BrushError, InputError

CURVES = "angle,x0,z0,x1,z1,x2,z2,x3,z3,spread\n"


def table(folder: Path, text: str, name: str = "t.csv") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_the_brush_that_was_measured_is_found_again() -> None:
    base = load_brush("full")
    real = dataclasses.replace(
        base, name="x", root_diameter_mm=10.0, taper=0.8, stiffness_exponent=4.0, full_press_mm=15.0
    )
    depths = np.linspace(1.0, 18.0, 9)
    presses = np.column_stack([depths, predict_presses(real, depths)])
    shares: list[float] = []
    found = fit_presses(presses, base, "mine", shares.append, exponents=(4.0,))
    assert max(press_errors(base, presses)) > 1.0
    assert max(press_errors(found, presses)) < 0.05
    for parameter in ("root_diameter_mm", "taper", "stiffness_exponent", "full_press_mm"):
        assert getattr(found, parameter) == pytest.approx(getattr(real, parameter), rel=0.02)
    assert shares == [0.5, 1.0]
    assert found.name == "mine"


def test_readings_of_one_depth_are_averaged(tmp_path: Path) -> None:
    text = "depth_mm,width_mm,drag_mm,offset_mm\n2,3,4,1\n1,1,1,1\n2,5,2,2\n"
    assert read_presses(table(tmp_path, text)).tolist() == [[1, 1, 1, 1], [2, 4, 1.5, 3]]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("depth,width\n1,2\n", "has the columns depth, width; expected depth_mm"),
        (",".join(PRESS_COLUMNS) + "\n1,2,x,3\n", "t.csv:2: offset_mm is 'x'; expected a number"),
        (
            "# by hand\n\n" + ",".join(PRESS_COLUMNS) + "\n# one\n1,2,3\n",
            "t.csv:5: drag_mm is None",
        ),
        (",".join(PRESS_COLUMNS) + "\n" + "1" * 200_000 + ",2,3,4\n", "cannot be read as a table"),
        (",".join(PRESS_COLUMNS) + "\n1,-2,3,4\n", "t.csv:2: width_mm is -2; expected 0 to 1000"),
        (",".join(PRESS_COLUMNS) + "\n1,2,3,1e300\n", "drag_mm is 1e\\+300; expected 0 to 1000"),
        ("", "has the columns none"),
        (",".join(PRESS_COLUMNS) + "\n", "has no rows"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=told) as caught:
        read_presses(table(tmp_path, text))
    assert "t.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_too_few_and_too_deep_presses_are_refused() -> None:
    brush = load_brush("full")
    with pytest.raises(InputError, match="presses of 2 depths; expected 3"):
        fit_presses(np.ones((2, 4)), brush, "mine")
    with pytest.raises(InputError, match=r"depths are 1 to 30 mm; expected 0 to 21\.7"):
        fit_presses(np.array([[1.0, 1, 1, 1], [2, 1, 1, 1], [30, 1, 1, 1]]), brush, "mine")


def test_a_table_of_fastbrushs_shapes_gives_fastbrushs_brush(tmp_path: Path) -> None:
    head = "angle,height,offset,imprint,upper,lower,spread\n"
    text = head + "".join(",".join(map(str, row)) + "\n" for row in MEASURED if row[1] < 1.0)
    path = table(tmp_path, text)
    assert is_table_of_shapes(path)
    assert is_table_of_shapes(table(tmp_path, "# seen from the side\n\n" + text, "b.csv"))
    assert is_table_of_shapes(table(tmp_path, text.replace("angle", '"angle"', 1), "c.csv"))
    rows = read_shapes(path, 35.0)
    assert rows == shape_rows(MEASURED)
    own = BristleSpec(n_hairs=60, table=rows)
    brush, known = load_brush("full"), BristleSpec(n_hairs=60, table="measured")
    mine, theirs = build_bristles(brush, own), build_bristles(brush, known)
    assert np.array_equal(mine.shapes, theirs.shapes)
    assert np.array_equal(mine.fans, theirs.fans)


def test_points_of_curves_are_turned_into_lengths(tmp_path: Path) -> None:
    """A hair of 40 mm, its root 30 mm over the paper; from the left and from the right alike."""
    points = [(0, 30), (0, 18), (8, 0), (20, 0)]
    right = ",".join(f"{x},{z}" for x, z in points)
    left = ",".join(f"{100 - x},{z + 5}" for x, z in points)
    (_, bent) = read_shapes(table(tmp_path, f"{CURVES}0,{right},12\n"), 40.0)
    assert bent == pytest.approx((0.0, 0.75, 0.5, 0.0, 0.3, 0.3, 12.0))
    (_, other) = read_shapes(table(tmp_path, f"{CURVES}0,{left},12\n"), 40.0)
    assert other == pytest.approx(bent)
    tilts, fractions = np.array([math.pi / 2]), np.array([0.0, 0.25])
    shapes, fans = measured_shapes(tilts, fractions, (_, bent))
    x, z = shapes[0, 1].reshape(3, -1)[:2]
    assert pytest.approx(np.hypot(np.diff(x), np.diff(z)).sum(), abs=0.05) == 1.0
    assert z.max() == pytest.approx(0.75, abs=1e-3)
    assert fans[0, 1, 0] == pytest.approx(math.radians(6.0))


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ("70,0,30,0,18,8,0,20,0,0", "t.csv:2: angle is 70; expected 0 to 60"),
        ("0,0,50,0,18,8,0,20,0,0", "the root is 50 mm over the tip; expected above 0, to 40"),
        ("0,0,30,0,18,8,0,20,0,0\n0,0,30,0,17,8,0,20,0,0", "two rows of angle 0 and height 0.75"),
        ("0,0,30,0,18,8,0,200,0,0", "row 1: offset is 5; expected -1 to 1.5"),
        ("0,0,40,0,18,8,0,0,0,0", "no bent hair of angle 0"),
    ],
)
def test_a_curve_that_is_no_bent_hair_is_refused(rows: str, told: str, tmp_path: Path) -> None:
    with pytest.raises((InputError, BrushError), match=told) as caught:
        read_shapes(table(tmp_path, f"{CURVES}{rows}\n"), 40.0)
    assert "t.csv" in str(caught.value)


def test_a_brush_carries_its_own_table_in_its_file(tmp_path: Path) -> None:
    rows = shape_rows([(0.0, 0.5, 0.6, 0.1, 0.4, 0.6, 10.0), (30.0, 0.4, 0.5, 0.0, 0.5, 0.2, 5.0)])
    brush = dataclasses.replace(load_brush("full"), name="mine", bristles=BristleSpec(20, rows))
    (tmp_path / "mine.toml").write_text(brush_text(brush), encoding="utf-8")
    assert load_brush(str(tmp_path / "mine.toml")) == brush
    (tmp_path / "bad.toml").write_text(
        'base = "full"\n[bristles]\ntable = [[0, 0.5, 0.1]]\n', encoding="utf-8"
    )
    with pytest.raises(BrushError, match=r"bristles: table: row 1 is .* expected 7 numbers"):
        load_brush(str(tmp_path / "bad.toml"))


def test_a_note_of_any_characters_is_kept_in_a_file(tmp_path: Path) -> None:
    """A table's name may be no text at all, and control characters are none of TOML."""
    brush = dataclasses.replace(load_brush("full"), name="mine")
    path = tmp_path / "mine.toml"
    write_brush(path, brush, load_presets(), "of \udcff\x7f\n.csv")
    assert load_brush(str(path)) == brush


def test_shapes_that_are_no_rows_are_refused() -> None:
    with pytest.raises(BrushError, match="table is 7; expected rows of numbers"):
        shape_rows(7)

"""Brush parameters, presets and the bent shapes behind them."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from paint3d.brush.bending import BendingTable, bending_table, build_tuft, joint_stiffness
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import brush_names, brush_note, brush_text, choose_brush, load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.brush_engine.tuft import STATIONS, greatest_descent, trace_spine
from paint3d.calligraphy.footprint_table import tabulate_footprints
from paint3d.core.parameter_file import is_parameter_file
from paint3d.errors import BrushError, InputError, UnknownNameError
from tests.support.examples import examples
from tests.support.outlines import sizes_of


def test_segments_are_an_arithmetic_progression_that_fills_the_tuft():
    spec = load_brush("full")
    lengths = spec.segment_lengths
    assert lengths[0] == pytest.approx(1.0)
    assert np.allclose(np.diff(lengths), 2 * (35 - 9) / (9 * 8))
    assert lengths.sum() == pytest.approx(35.0)


def test_force_reaches_its_maximum_at_full_press():
    spec = load_brush("full")
    assert spec.force_coefficient == pytest.approx(0.645, abs=5e-4)
    assert build_tuft(spec).spring * 17.5 == pytest.approx(7.9)


@pytest.mark.parametrize(
    ("parameter", "value", "expected"),
    [
        ("hardness", 0.9, "0.3 to 0.7"),
        ("n_segments", 7, "8 to 13"),
        ("n_segments", 9.5, "a whole number"),
        ("tip_segment_mm", 2.0, "0.8 to 1.4"),
        ("friction", 0.1, "0.2 to 0.3"),
        ("spread_by_pressure", 2.0, "1.3 to 1.8"),
        ("spread_by_friction", 0.5, "0.6 to 0.8"),
        ("length_mm", math.nan, "finite"),
        ("load", -1.0, "1 to"),
        ("full_press_mm", 25.0, "7 to 21.7"),
        ("hair", "nylon", "goat, weasel, mixed"),
    ],
)
def test_a_parameter_out_of_range_is_named(parameter, value, expected):
    with pytest.raises(BrushError, match=expected) as caught:
        dataclasses.replace(load_brush("full"), **{parameter: value})
    assert parameter in str(caught.value)
    assert (value if parameter == "hair" else f"is {value:g}") in str(caught.value)


def test_the_tip_segment_may_scale_with_the_tuft():
    spec = load_brush("full")
    scaled = {"root_diameter_mm": 28.0, "full_press_mm": 35.0, "length_mm": 70.0}
    dataclasses.replace(spec, tip_segment_mm=2.8, **scaled)
    with pytest.raises(BrushError, match=r"1\.6 to 2\.8"):
        dataclasses.replace(spec, tip_segment_mm=1.0, **scaled)


def test_presets_cover_hairs_and_sizes():
    specs = [load_brush(name) for name in brush_names()]
    assert {"full", "slender", "calibrated", "xiaokai"} <= set(brush_names())
    assert {spec.hair for spec in specs} == {"goat", "weasel", "mixed"}
    assert min(spec.length_mm for spec in specs) <= 22.0
    assert max(spec.length_mm for spec in specs) >= 60.0


def test_an_unknown_brush_is_answered_with_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'slender'"):
        load_brush("slendr")


EXPONENTS = (2.5, 3.3, 3.5, 4.0, 5.0)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_bent_shapes_keep_the_height_of_the_root(exponent):
    table = bending_table(exponent)
    height = (np.diff(table.arcs) * np.sin(table.angles)).sum(axis=-1)
    wanted = np.sin(table.tilts)[:, None] * (1 - table.fractions)
    assert np.allclose(height, wanted, atol=1e-9)
    assert table.angles.min() >= 0.0
    assert (np.diff(table.angles, axis=-1) >= -1e-12).all()  # bends one way only
    assert (table.angles <= table.tilts[:, None, None] + 1e-12).all()


@pytest.mark.parametrize(("row", "column"), [(0, 60), (0, 128), (12, 90), (24, 40), (24, 120)])
def test_bent_shapes_have_the_least_energy(row, column):
    table = BendingTable(4.0, n_arcs=16)
    lengths, stiffness = np.diff(table.arcs), joint_stiffness(table.arcs, 4.0)
    tilt = table.tilts[row]
    height = math.sin(tilt) * (1 - table.fractions[column])

    def energy(angles):
        return 500.0 * np.sum(stiffness * np.diff(np.append(angles, tilt)) ** 2)

    start = np.linspace(0.1 * tilt, tilt, len(lengths))
    bound = {"type": "eq", "fun": lambda angles: lengths @ np.sin(angles) - height}
    found = minimize(
        energy,
        start,
        method="SLSQP",
        constraints=[bound],
        bounds=[(0.0, math.pi)] * len(lengths),
        options={"maxiter": 2000, "ftol": 1e-13},
    )
    ours = table.angles[row, column]
    assert energy(ours) <= found.fun * (1 + 1e-5)
    heavy = lengths > 0.02  # the energy hardly feels how the shortest arcs at the tip lie
    assert np.allclose(ours[heavy], found.x[heavy], atol=0.01)


def spine_of(tuft, descent, tilt):
    out = np.empty((3, STATIONS))
    trace_spine(tuft, descent, tilt, out)
    return out


def test_lookup_meets_the_table_and_stays_near_the_height_between():
    spec = load_brush("full")
    tuft, table = build_tuft(spec), bending_table(3.5)
    straight = spec.length_mm * math.sin(table.tilts[7])
    along, up, angle = spine_of(tuft, straight * table.fractions[50], table.tilts[7])
    for ours, theirs in zip((along / 35, up / 35, angle), table.spine, strict=True):
        assert np.allclose(ours, theirs[7, 50, ::2], atol=1e-6)
    for tilt in np.radians([33.3, 58.1, 77.7, 89.2]):
        for descent in np.linspace(0.3, 10.0, 23):
            height = spine_of(tuft, descent, tilt)[1, -1]
            assert height == pytest.approx(35 * math.sin(tilt) - descent, abs=0.01)


def test_an_unpressed_tuft_is_straight():
    assert np.allclose(spine_of(build_tuft(load_brush("full")), 0.0, 1.1)[2], 1.1, atol=1e-6)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_the_ends_of_the_ranges_can_be_bent(exponent):
    spec = dataclasses.replace(
        load_brush("full"), stiffness_exponent=exponent, root_diameter_mm=0.42 * 35, taper=0.4
    )
    tuft = build_tuft(spec)
    # At the end of the table the ferrule is still clear of the plane, at every tilt.
    for tilt in np.linspace(tuft.lowest_tilt, math.pi / 2, 13):
        _, up, angle = spine_of(tuft, greatest_descent(tuft, tilt), tilt)
        assert 2.0 * up[-1] / max(math.cos(angle[-1]), 1e-9) > spec.root_diameter_mm


def test_twice_as_many_arcs_change_next_to_nothing():
    """Law 5: width and area within .3 %."""
    coarse, fine = (
        dict(zip(("along", "up", "angle"), BendingTable(3.5, n).spine, strict=True))
        for n in (112, 224)
    )
    for part, tolerance in (("along", 3e-4), ("up", 3e-4)):
        moved = np.abs(coarse[part][:, 20:] - fine[part][:, 20:, ::2])
        assert moved.max() < tolerance


@pytest.mark.parametrize("share", [-0.01, 0.16])
def test_a_points_length_is_checked(share):
    with pytest.raises(BrushError, match="point_mm"):
        dataclasses.replace(load_brush("full"), point_mm=share * 35)


def test_a_pointed_tuft_is_a_cone_at_its_tip_and_the_papers_law_above():
    spec = dataclasses.replace(load_brush("full"), point_mm=2.0)
    blunt = dataclasses.replace(spec, point_mm=0.0)
    near = np.array([1e-4, 2e-4])
    assert spec.diameters(near)[1] == pytest.approx(2.0 * spec.diameters(near)[0], rel=1e-3)
    assert spec.diameters([15.0, 35.0]) == pytest.approx(blunt.diameters([15.0, 35.0]), rel=1e-3)
    assert load_brush("full").point_mm == pytest.approx(2.0 * load_brush("full").tip_segment_mm)
    assert dataclasses.replace(spec, taper=1.0).diameters(near) == pytest.approx(14.0 * near / 35.0)


def pressed(brush, descent):
    return make_footprint(build_tuft(brush), descent, 0.5 * math.pi)


def test_the_force_follows_the_hardness():
    """Eq. 4: F = lambda H X, with lambda as it was rated."""
    full = load_brush("full")
    soft = dataclasses.replace(full, hardness=0.6)
    assert soft.force_coefficient == full.force_coefficient
    assert soft.spring == pytest.approx(full.spring * 0.6 / 0.7)
    tuft = build_tuft(soft)
    assert tuft.full_press == pytest.approx(17.5 * 0.7 / 0.6)
    assert tuft.spring * tuft.full_press == pytest.approx(7.9)
    limp = build_tuft(dataclasses.replace(full, hardness=0.3))
    assert limp.full_press == 0.62 * 35.0
    assert limp.max_force == pytest.approx(limp.spring * limp.full_press)
    widths = [
        make_footprint(build_tuft(b), 3.0 / b.spring, 0.5 * math.pi).width for b in (full, soft)
    ]
    assert widths[0] < widths[1]


@pytest.mark.parametrize("name", brush_names())
def test_presets_are_rated_as_they_are(name):
    brush = load_brush(name)
    assert brush.segmentation is None
    tuft = build_tuft(brush)
    assert tuft.full_press == brush.full_press_mm
    assert tuft.max_force == brush.max_force


@pytest.mark.parametrize("change", [{"tip_segment_mm": 0.8}, {"n_segments": 8}])
def test_a_shorter_tip_segment_softens_the_tip(change):
    full = load_brush("full")
    soft = dataclasses.replace(full, **change)
    for descent in (0.2, 1.0, 5.0):
        tips = [
            make_footprint(build_tuft(b), descent, 0.5 * math.pi).reach[0] for b in (full, soft)
        ]
        assert tips[1] < tips[0] - 1e-3 * descent, "it gives way nearer to the tip"


@settings(max_examples=examples(30), deadline=None)
@given(
    st.floats(2.5, 5.0),
    st.integers(8, 13),
    st.floats(0.8, 1.4),
    st.integers(8, 13),
    st.floats(0.8, 1.4),
)
def test_any_tip_within_the_ranges_bends(exponent, n, tip, rated_n, rated_tip):
    table = BendingTable(exponent, segmentation=(n, tip / 35.0, rated_n, rated_tip / 35.0))
    _, up, _ = table.spine
    height = np.sin(table.tilts)[:, None] * (1.0 - table.fractions)
    assert np.allclose(up[..., -1], height, atol=1e-9)


# -- presets -----------------------------------------------------------------------------------


SIZES = np.geomspace(8.0, 350.0, 40)


def test_every_size_has_a_brush_and_larger_ones_no_smaller_brush():
    chosen = [choose_brush(em) for em in SIZES]
    assert set(chosen) <= set(brush_names())
    lengths = [load_brush(name).length_mm for name in chosen]
    assert (np.diff(lengths) >= 0.0).all()
    assert len(set(chosen)) > 1


def test_new_brushes_come_after_the_others():
    """The studio's keys go by the order."""
    assert brush_names() == (
        "full", "slender", "calibrated", "xiaokai", "zhongkai", "dakai", "gongbi", "baiyun",
        "xiaobaiyun", "zhongbaiyun", "dabaiyun", "feibai", "langhao", "yanghao", "jianhao",
        "tidou",
    )  # fmt: skip


def test_weasel_is_thin_and_springs_back_goat_is_broad_and_stays_bent():
    brushes = [load_brush(name) for name in ("langhao", "jianhao", "yanghao")]
    assert [brush.hair for brush in brushes] == ["weasel", "mixed", "goat"]
    for low, high in itertools.pairwise(brushes):
        assert low.plasticity < high.plasticity
        assert low.load < high.load
        assert low.spring > high.spring
    shares = np.linspace(0.01, 1.0, 100)
    widths = [sizes_of(build_tuft(b), shares * b.full_press_mm)[:, 1] for b in brushes]
    assert (np.diff(widths, axis=1) > 0.0).all()
    assert (np.diff(widths, axis=0) > 0.0).all()


@pytest.mark.parametrize("em", [8.0, 21.9, 22.1, 60.0, 60.1, 200.0, 200.1, 350.0])
def test_brush_makes_the_strokes_of_its_size(em):
    """Kaishu's strokes are 1 to 14 % of the em wide; the footprint must be about as long."""
    footprints = tabulate_footprints(build_tuft(load_brush(choose_brush(em))), 0.2 * em)
    length, width = np.ptp(footprints.points, axis=1).T
    assert width[0] < 0.02 * em
    assert width[-1] > 0.14 * em
    body = (width > 0.04 * em) & (width < 0.1 * em)
    assert (length / width)[body].min() > 0.6
    assert (length / width)[body].max() < 1.4
    assert load_brush(choose_brush(em)).length_mm < 2.6 * em


@pytest.mark.parametrize("em", [7.9, 350.1, float("nan"), -3.0, "large"])
def test_other_sizes_are_refused(em):
    with pytest.raises(InputError, match="size of the characters"):
        choose_brush(em)


# -- files -------------------------------------------------------------------------------------


def written(folder: Path, text: str, name: str = "mine.toml") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


@pytest.mark.parametrize("name", brush_names())
def test_what_is_shown_is_read_back(name: str, tmp_path: Path) -> None:
    brush = load_brush(name)
    read = load_brush(written(tmp_path, brush_text(brush, brush_note(name))))
    assert read.name == "mine"
    assert dataclasses.replace(read, name=name) == brush


def test_a_file_may_start_from_a_preset(tmp_path: Path) -> None:
    toml = written(tmp_path, 'base = "feibai"\nhardness = 0.4\n[bristles]\nn_hairs = 50\n')
    same = {"base": "feibai", "name": "mine", "hardness": 0.4, "bristles": {"n_hairs": 50}}
    json_file = written(tmp_path, json.dumps(same), "other.JSON")
    read = load_brush(toml)
    assert read == load_brush(json_file)
    assert (read.hardness, read.bristles) == (0.4, BristleSpec(n_hairs=50))
    assert read.inputs == load_brush("feibai").inputs
    assert load_brush(written(tmp_path, 'base = "feibai"\nbristles = false\n')).bristles is None


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("hardness = 0.4", "hair, n_segments"),
        ('base = "ful"', "base is 'ful'; expected one of full"),
        ('base = "full"\nhardnes = 0.4', "there is no 'hardnes': did you mean 'hardness'"),
        ('base = "full"\nhardness = 0.9', "hardness is 0.9; expected 0.3 to 0.7"),
        ('base = "full"\nhardness = "hard"', "hardness is 'hard'; expected a number"),
        ('base = "full"\nhair = []', "hair is []; expected one of goat"),
        ('base = "full"\nname = "dakai"', "a brush that comes with the program"),
        ('base = "full"\nname = "a @3"', "without ' @'"),
        ('base = "full"\nname = "a.toml"', "not ending in .toml or .json"),
        ('base = "full"\nbristles = 300', "bristles is 300; expected parameters"),
        ('base = "full"\n[bristles]\nhair = 1', "bristles: there is no 'hair'"),
        ('base = "full"\n[bristles]\nn_hairs = 0', "bristles: n_hairs is 0; expected 1 to 10000"),
        ('base = "full"\n[inputs.wetness]\nspeed = 3', "wetness by speed is 3; expected points"),
        ("base = \n\nx = 1", "cannot be read as TOML: Invalid value (at line 1, column 8)"),
        ("#" * (1 << 20) + "\n", "is over 1 MiB"),
    ],
)
def test_a_bad_file_says_where_and_what(text: str, told: str, tmp_path: Path) -> None:
    file = written(tmp_path, text)
    with pytest.raises(BrushError) as refused:
        load_brush(file)
    assert str(refused.value).startswith(f"{file}: ")
    assert told in str(refused.value)


def test_other_things_than_tables_are_refused(tmp_path: Path) -> None:
    for text in ("[1]", "3", "[" * 100_000):
        with pytest.raises(BrushError, match=r"mine\.json: "):
            load_brush(written(tmp_path, text, "mine.json"))
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    for name, told in (("bytes.toml", "TOML"), ("none.toml", "no such file"), (".", "brush")):
        with pytest.raises((BrushError, ValueError), match=told):
            load_brush(str(tmp_path / name))


def test_names_out_of_files_open_no_files(tmp_path: Path) -> None:
    file = written(tmp_path, 'base = "full"')
    assert is_parameter_file(file)
    with pytest.raises(BrushError, match="which a file may not name"):
        load_brush(file, own_files=False)
    assert load_brush("full", own_files=False) is load_brush("full")

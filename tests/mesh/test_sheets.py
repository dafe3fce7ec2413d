"""Sheets: their names, their shape, what is around them, and text that keeps to their paper."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import paint3d
from paint3d.calligraphy.layout import Layout, layout_text
from paint3d.colour.materials import load_material
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import InputError, MeshError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.sheet_mesh import sheet_of, writing_areas
from paint3d.mesh.sheets import FORMS, parse_sheet

NAMES = [form if form != "sheet" else "sheet:210x150" for form in FORMS]


@pytest.mark.parametrize("name", [*NAMES, *(f"{name}:mounted" for name in NAMES)])
def test_a_name_makes_a_sheet_that_faces_up_and_says_the_same_name(name: str) -> None:
    sheet, mesh = parse_sheet(name), load_mesh(name)
    assert sheet.name == name == mesh.name
    assert sheet_of(mesh) == sheet
    paper = np.abs(mesh.vertices[:, 2][mesh.faces]).max(axis=1) < 0.1
    assert (mesh.face_normals[paper, 2] > 0.99).all()
    other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert other.is_winding_consistent
    assert (mesh.double_areas > 1e-6).all()
    wide = sheet.usual.panels * sheet.width_mm
    assert sheet.mounted or wide <= np.ptp(mesh.bounds, axis=0)[0] <= wide + 121.0
    assert mesh.n_faces < 20_000  # paint refines it


@pytest.mark.parametrize(("name", "area"), [("scroll", 340 * 1380), ("round-fan", np.pi * 125**2),
    ("fan", np.deg2rad(70) * (271.36**2 - 101.36**2))])  # fmt: skip
def test_a_sheet_has_the_area_of_its_size(name: str, area: float) -> None:
    assert load_mesh(name).area == pytest.approx(area, rel=2e-3)


@pytest.mark.parametrize("name", ["sheet", "scroll:wide", "scroll:5x5", "square:100:margin=60",
    "fan:200x190", "scroll:1e9", "sheet:100x9000", "round-fan:100x90"])  # fmt: skip
def test_what_is_no_sheet_is_said_in_one_line(name: str) -> None:
    with pytest.raises((InputError, MeshError), match="expected") as caught:
        load_mesh(name)
    assert "\n" not in str(caught.value)


def test_another_mesh_of_such_a_name_is_no_sheet() -> None:
    bowl = load_mesh("bowl")
    other = paint3d.TriangleMesh(bowl.vertices, bowl.faces, name="scroll")
    assert sheet_of(other) is None
    assert writing_areas(other)[0].mesh is other


def test_a_sheet_is_of_what_suits_it_and_its_mount_keeps_its_silk() -> None:
    assert paint3d.PaintedSurface(load_mesh("round-fan")).material.name == "silk"
    for material in ("xuan", "tinted xuan"):
        surface = paint3d.PaintedSurface(load_mesh("square:mounted"), material=material)
        mesh = surface.mesh
        within = (np.abs(mesh.vertices[:, :2]) < 169.0).all(axis=1)
        paper = srgb_from_reflectance(load_material(material).reflectance)
        assert (surface.srgb[within] == paper).all()
        outside = (np.abs(mesh.vertices[:, :2]) > 171.0).any(axis=1)
        assert (surface.srgb[outside] == (203, 194, 170)).all()


def test_small_sheets_have_finer_paint_for_their_characters_are_small() -> None:
    names = ("sheet:60x60", "sheet:160x50", "a4", "square", "scroll")
    assert [parse_sheet(name).detail_mm for name in names] == [0.15, 0.27, 0.4, 0.4, 0.6]


def test_text_keeps_to_the_margin_of_a_mounted_sheet() -> None:
    surface = ClosestPoints(load_mesh("scroll:340x690:margin=40:mounted"))
    placed = layout_text(surface, "牀前明月光\n疑是地上霜", 120.0)
    points = np.concatenate([one.square.points.reshape(-1, 3) for one in placed])
    assert (np.abs(points[:, :2]) <= [130.0 + 1e-3, 305.0 + 1e-3]).all()
    with pytest.raises(InputError, match="does not fit"):
        layout_text(surface, "牀前明月光", 124.0)
    placed = layout_text(surface, "牀前明月光", 124.0, Layout(point=(0.0, 0.0, 0.0)))
    assert len(placed) == 5  # where it is said where it goes, the margin is the writer's affair


def test_a_couplet_is_written_from_the_right_one_line_a_panel() -> None:
    surface = ClosestPoints(load_mesh("couplet"))
    for text in ("白日依山盡\n黃河入海流", "白日依山盡黃河入海流"):
        placed = layout_text(surface, text, 100.0)
        x = [float(one.square.chart.frame.origin[0]) for one in placed]
        assert min(x[:5]) > 0.0 > max(x[5:])
    (one,) = layout_text(surface, "福", 100.0, Layout(at=(0.2, 0.9)))
    assert one.square.chart.frame.origin[:2] == pytest.approx([-240.0, 552.0], abs=0.1)


def test_columns_of_a_folding_fan_run_to_where_its_ribs_meet() -> None:
    surface = ClosestPoints(load_mesh("fan"))
    placed = layout_text(surface, "白日依山盡黃河入海流欲窮千里目更上一層樓", 24.0)
    apex = np.array([0.0, writing_areas(surface.mesh)[0].apex[1]])
    for one in placed:
        frame = one.square.chart.frame
        away = frame.origin[:2] - apex
        assert away @ frame.y_axis[:2] == pytest.approx(np.linalg.norm(away))


@pytest.mark.parametrize("name", ["plane", "bowl"])
def test_text_is_turned_and_spaced_around_its_point(name: str) -> None:
    surface = ClosestPoints(load_mesh(name))
    point = (10.0, 5.0, 0.0) if name == "plane" else (0.0, -68.0, 40.0)
    plain, turned = (
        layout_text(
            surface, "永和\n九年", 14.0, Layout(point=point, turn=turn, between=0.3, gap=0.2)
        )
        for turn in (0.0, 15.0)
    )
    for one, other in zip(plain, turned, strict=True):
        up, leaning = one.square.chart.frame.y_axis, other.square.chart.frame.y_axis
        assert np.degrees(np.arccos(up @ leaning)) == pytest.approx(15.0, abs=4.0)
    middles = np.array([one.square.chart.frame.origin for one in turned])
    np.testing.assert_allclose(
        middles.mean(axis=0), surface.find(np.array([point])).points[0], atol=1.5
    )
    assert np.linalg.norm(middles[1] - middles[0]) == pytest.approx(14.0 * 1.3, rel=0.03)


def test_ink_refines_a_sheet_only_where_it_falls() -> None:
    surface = paint3d.PaintedSurface(load_mesh("scroll:mounted"))
    before = surface.n_vertices
    painter = paint3d.Painter(surface, brush="zhongkai")
    painter.write("永", size=40.0)
    fine = surface.mesh.vertices[before:]
    assert 500 < len(fine) < 60_000
    assert (np.abs(fine[:, :2]) < 60.0).all()


def test_a_seal_is_placed_by_shares_of_the_paper_of_a_mounted_sheet() -> None:
    surface = paint3d.PaintedSurface(load_mesh("scroll:100x140:mounted"), 1.0)
    touched = paint3d.Painter(surface, ink="cinnabar").seal("永", at=(0.2, 0.25), size=12.0)
    where = surface.mesh.vertices[surface.painted_coverage() > 0.5]
    middle = 0.5 * (where.min(axis=0) + where.max(axis=0))
    np.testing.assert_allclose(middle[:2], [-30.0, -35.0], atol=0.5)
    assert touched > 0.8

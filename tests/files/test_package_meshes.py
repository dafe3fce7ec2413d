"""Paintings as objects of trimesh, Open3D and PyVista, and their meshes as objects to paint."""

from __future__ import annotations

import logging
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from paint3d.errors import InputError, MeshError
from paint3d.files.load import load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, on_sphere, poses, sheet

KINDS = ("trimesh", "open3d", "open3d legacy", "pyvista")


def given_to(kind: str, surface: PaintedSurface):
    package = kind.split()[0]
    pytest.importorskip(package, reason=f"{package} is not installed")
    if package == "open3d":
        return surface.to_open3d(legacy=kind.endswith("legacy"))
    return getattr(surface, f"to_{package}")()


def painted(mesh: TriangleMesh | None = None) -> PaintedSurface:
    """A sheet with a stroke of two inks, on two layers."""
    surface = PaintedSurface(mesh or sheet(on_sphere(60.0), (20.0, 20.0), 2.0), resolution=0.5)
    painter = Painter(surface, "slender", {"pine soot": 0.5, "cinnabar": 0.5})
    painter.replay(stroke(-12.0))
    surface.use_layers().add("red", 1)
    Painter(surface, "slender", "cinnabar").replay(stroke(-4.0))
    return surface


def stroke(y: float):
    points = np.stack([np.linspace(-5.0, 5.0, 30), np.full(30, y), np.zeros(30)], axis=1)
    return poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.full(30, 0.5))


@pytest.fixture(scope="module")
def painting() -> PaintedSurface:
    return painted()


def same(one: TriangleMesh, two: TriangleMesh) -> None:
    """The same to the bit, but for rounding of normals."""
    np.testing.assert_array_equal(one.vertices, two.vertices)
    np.testing.assert_array_equal(one.faces, two.faces)
    np.testing.assert_array_equal(one.colours, two.colours)
    normals = one.normals
    if normals is None:  # they are those that follow from the faces
        normals = PaintedSurface(one, resolution=None).mesh.normals
    np.testing.assert_allclose(normals, two.normals, atol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_a_painting_comes_back_from_each_package(kind: str, painting: PaintedSurface) -> None:
    found = given_to(kind, painting)
    back = load_mesh(found)
    same(back, painting.mesh)
    assert len(np.unique(back.colours, axis=0)) > 20
    again = PaintedSurface(back, resolution=None)  # what was painted is the ground to paint on
    np.testing.assert_array_equal(again.export_arrays(None)[3], painting.mesh.colours)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "open3d legacy"])
def test_what_each_layer_holds_goes_along(kind: str, painting: PaintedSurface) -> None:
    found = given_to(kind, painting)
    held = painting.layer_arrays()
    assert set(held) == {"1: share", "1: pine soot", "1: cinnabar", "red: share", "red: cinnabar"}
    inked = painting.vertex_areas @ (held["1: pine soot"] + held["1: cinnabar"])
    inked += painting.vertex_areas @ held["red: cinnabar"]
    assert inked == pytest.approx(painting.wet_ink() + painting.dry_ink(), rel=1e-6)
    for name, array in held.items():
        if kind == "trimesh":
            there = found.vertex_attributes[name]
        elif kind == "open3d":
            there = found.vertex[name].numpy()
        else:
            there = found.point_data[name]
        np.testing.assert_array_equal(there, array)
    assert (held["red: share"] > 0.9).any()
    across = painting.mesh.vertices[:, 1]
    lower, upper = (across[held[f"{name}: share"] > 0.9].mean() for name in ("1", "red"))
    assert upper > lower + 3.0


def test_dried_paint_and_layers_of_one_name_are_told_apart() -> None:
    surface = painted()
    surface.dry()
    surface.layers.add("red", 2)
    wet = painted().layer_arrays()
    held = surface.layer_arrays()
    assert set(held) == {*wet, "red (2): share"}
    for name, array in wet.items():
        np.testing.assert_array_equal(held[name], array)
    assert not held["red (2): share"].any()


def test_a_surface_without_layers_has_one() -> None:
    surface = PaintedSurface(sheet(flat, (20.0, 20.0), 2.0), resolution=0.5)
    Painter(surface, "slender", {"cinnabar": 0.4, "water": 0.6}).replay(stroke(0.0))
    held = surface.layer_arrays()
    assert set(held) == {"1: share", "1: cinnabar"}  # water is no pigment
    surface.dry()
    dried = surface.layer_arrays()
    np.testing.assert_allclose(dried["1: cinnabar"], held["1: cinnabar"])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS))
def test_any_mesh_goes_through_any_package(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 40))
    vertices = rng.uniform(-100.0, 100.0, (n, 3)).astype(np.float32)
    ends = rng.permuted(np.tile(np.arange(n), (int(rng.integers(1, 60)), 1)), axis=1)[:, :3]
    mesh = TriangleMesh(vertices, ends, rng.integers(0, 256, (n, 3), dtype=np.uint8))
    surface = PaintedSurface(mesh, resolution=None)
    same(load_mesh(given_to(kind, surface)), surface.mesh)


def test_units_and_the_way_up_are_as_for_files(caplog: pytest.LogCaptureFixture) -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    np.testing.assert_allclose(np.ptp(load_mesh(box).vertices, axis=0), (1, 2, 3))
    np.testing.assert_allclose(np.ptp(load_mesh(box, "cm", up="y").vertices, axis=0), (10, 30, 20))
    box.units = "inches"
    np.testing.assert_allclose(
        np.ptp(load_mesh(box).vertices, axis=0), np.multiply(25.4, (1, 2, 3))
    )
    box.units = "ells"
    with caplog.at_level(logging.WARNING, "paint3d"):
        np.testing.assert_allclose(np.ptp(load_mesh(box).vertices, axis=0), (1, 2, 3))
    assert "trimesh.Trimesh: its unit 'ells' is not known: mm are taken" in caplog.text


def test_normals_that_trimesh_works_out_itself_are_not_taken_for_given() -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    box = trimesh.creation.box()
    assert box.vertex_normals.shape == (8, 3)  # looked at, and so kept by it
    assert load_mesh(box).normals is None
    up = np.tile([0.0, 0.0, 1.0], (8, 1))
    told = trimesh.Trimesh(box.vertices, box.faces, vertex_normals=up, process=False)
    np.testing.assert_array_equal(load_mesh(told).normals, up)


def test_a_scene_is_one_mesh_with_everything_in_its_place() -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    box = trimesh.creation.box((2.0, 2.0, 2.0))
    box.visual.vertex_colors = np.tile(np.uint8([200, 30, 20, 255]), (8, 1))
    scene = trimesh.Scene([box])
    aside = trimesh.transformations.translation_matrix((10.0, 0.0, 0.0))
    scene.add_geometry(trimesh.creation.box((2.0, 2.0, 2.0)), transform=aside)
    mesh = load_mesh(scene)
    assert (mesh.n_vertices, mesh.n_faces) == (16, 24)
    np.testing.assert_allclose(mesh.bounds, [(-1, -1, -1), (11, 1, 1)])
    red = (mesh.colours == (200, 30, 20)).all(axis=1)
    np.testing.assert_array_equal(red, mesh.vertices[:, 0] < 5.0)
    with pytest.raises(MeshError, match=r"trimesh.Scene: it has no vertices and no triangles"):
        load_mesh(trimesh.Scene())


def test_pictures_of_trimesh_are_shown_where_they_are_wanted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    halves = np.zeros((8, 8, 3), np.uint8)
    halves[:4], halves[4:] = (200, 0, 0), (0, 0, 200)  # red above
    square = trimesh.Trimesh([(0, 0, 0), (8, 0, 0), (8, 8, 0), (0, 8, 0)], [(0, 1, 2), (0, 2, 3)],
                             process=False)  # fmt: skip
    uv = [(0, 0), (1, 0), (1, 1), (0, 1)]
    square.visual = trimesh.visual.TextureVisuals(uv, image=Image.fromarray(halves))
    mesh = load_mesh(square, texture=True)
    y = mesh.vertices[:, 1]  # the picture repeats, so its border is of both colours
    top, bottom = (y > 5.0) & (y < 7.0), (y > 1.0) & (y < 3.0)
    assert top.any()
    assert bottom.any()
    assert (mesh.colours[top] == (200, 0, 0)).all()
    assert (mesh.colours[bottom] == (0, 0, 200)).all()
    with caplog.at_level(logging.WARNING, "paint3d"):
        assert load_mesh(square).colours is None
    assert "trimesh.Trimesh: left out: its colours and pictures" in caplog.text


@pytest.mark.parametrize("kind", ["trimesh", "pyvista"])
def test_colours_of_faces_are_shown_where_they_are_wanted(kind: str) -> None:
    package = pytest.importorskip(kind, reason=f"{kind} is not installed")
    codes = np.uint8([(255, 0, 0), (0, 0, 255)])
    points = np.array([(0.0, 0, 0), (8, 0, 0), (8, 8, 0), (0, 8, 0)])
    if kind == "trimesh":
        square = package.Trimesh(points, [(0, 1, 2), (0, 2, 3)], face_colors=codes, process=False)
    else:
        square = package.PolyData(points, [3, 0, 1, 2, 3, 0, 2, 3])
        square.cell_data["rgb"] = codes
    mesh = load_mesh(square, texture=True)
    for face, code in zip(mesh.faces, codes, strict=True):
        assert (mesh.colours[face] == code).all()
    assert load_mesh(square).colours is None


def test_polygons_strips_and_lines_of_pyvista(caplog: pytest.LogCaptureFixture) -> None:
    pv = pytest.importorskip("pyvista", reason="pyvista is not installed")
    points = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 2, 0)])
    mixed = pv.PolyData(points, [4, 0, 1, 2, 3, 3, 0, 3, 4], lines=[2, 0, 4])
    with caplog.at_level(logging.WARNING, "paint3d"):
        mesh = load_mesh(mixed)
    assert (mesh.n_faces, mesh.area) == (3, pytest.approx(1.5))
    assert "pyvista.PolyData: left out: lines" in caplog.text
    strip = load_mesh(pv.PolyData(points[[0, 1, 3, 2]], strips=[4, 0, 1, 2, 3]))
    assert (strip.n_faces, strip.area) == (2, pytest.approx(1.0))
    with pytest.raises(MeshError, match="points but no triangles, though it says it has lines"):
        load_mesh(pv.PolyData(points, lines=[2, 0, 4]))
    ball = load_mesh(pv.Sphere(radius=20.0))
    assert ball.normals is not None
    assert load_mesh(pv.PolyData(pv.Sphere(radius=20.0).points)).n_faces > 1000  # a point cloud


def test_open3d_tensors_of_other_types() -> None:
    o3d = pytest.importorskip("open3d", reason="open3d is not installed")
    box = o3d.t.geometry.TriangleMesh.create_box()
    shown = np.linspace(0.0, 1.0, 24).reshape(8, 3)
    box.vertex.colors = o3d.core.Tensor(shown.astype(np.float32))
    mesh = load_mesh(box)
    np.testing.assert_array_equal(mesh.colours, np.floor(shown * 255.0 + 0.5).astype(np.uint8))
    assert mesh.n_faces == 12
    with pytest.raises(MeshError, match="it has no vertices"):
        load_mesh(o3d.t.geometry.TriangleMesh())


def test_what_is_no_mesh_is_named() -> None:
    with pytest.raises(MeshError, match=r"a mesh is a builtins.int; expected a file, the name"):
        load_mesh(3)
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    bad = trimesh.Trimesh([(0, 0, np.nan), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], process=False)
    with pytest.raises(MeshError, match=r"trimesh.Trimesh: vertex 0 is \(0, 0, nan\); expected"):
        load_mesh(bad)
    wide = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 7)], process=False)
    with pytest.raises(MeshError, match="face 0 refers to vertex 7; expected 0 to 2"):
        load_mesh(wide)
    with pytest.raises(InputError, match="unknown unit 'ell'"):
        load_mesh(bad, "ell")


def test_taking_a_mesh_imports_no_package() -> None:
    code = (
        "import sys, paint3d\n"
        "try:\n"
        "    paint3d.load_mesh(object())\n"
        "except paint3d.errors.MeshError:\n"
        "    pass\n"
        "print(*{'trimesh', 'open3d', 'pyvista', 'colour'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_plotting_shows_the_colours_that_were_painted(tmp_path, painting: PaintedSurface) -> None:
    pytest.importorskip("pyvista", reason="pyvista is not installed")
    picture = tmp_path / "seen.png"
    painting.plot(lit=False, off_screen=True, screenshot=picture, window_size=(300, 300))
    seen = np.asarray(Image.open(picture).convert("RGB")).reshape(-1, 3).astype(int)
    for code in np.unique(painting.srgb, axis=0)[::40].astype(int):
        if (np.abs(painting.srgb.astype(int) - code).max(axis=1) < 4).sum() > 40:
            assert (np.abs(seen - code).max(axis=1) < 8).any(), code

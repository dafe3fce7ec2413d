"""Few colours for printers: chosen well, one for every triangle, in the file that slicers read."""

import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.files.filaments import (
    choose_filaments,
    choose_for_triangles,
    split_by_filament,
)
from paint3d.files.load import load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh

CORE = {"c": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
WHITE, BLACK, RED = (250, 248, 240), (20, 20, 22), (200, 40, 30)


def three_groups():
    rng = np.random.default_rng(1)
    centres = np.repeat([WHITE, BLACK, RED], (9000, 900, 100), axis=0)
    noise = rng.integers(-4, 5, centres.shape)
    return np.clip(centres + noise, 0, 255).astype(np.uint8), centres


def test_clusters_are_found_and_the_one_that_covers_most_comes_first():
    codes, centres = three_groups()
    palette, chosen = choose_filaments(codes, np.ones(len(codes)), 3)
    np.testing.assert_allclose(palette, [WHITE, BLACK, RED], atol=3)
    np.testing.assert_array_equal(palette[chosen][:, 0] > 225, centres[:, 0] == 250)
    assert np.bincount(chosen).tolist() == [9000, 900, 100]


def test_areas_count_and_not_vertices():
    codes = np.uint8([WHITE, BLACK, BLACK])
    palette, _ = choose_filaments(codes, np.array([5.0, 1.0, 1.0]), 2)
    np.testing.assert_array_equal(palette, [WHITE, BLACK])
    palette, _ = choose_filaments(codes, np.array([1.0, 1.0, 1.0]), 2)
    np.testing.assert_array_equal(palette, [BLACK, WHITE])


@pytest.mark.parametrize("k", [1, 2, 3, 8])
def test_more_filaments_never_make_it_worse(k):
    rng = np.random.default_rng(4)
    codes = rng.integers(0, 256, (400, 3)).astype(np.uint8)
    lab = lab_from_srgb(codes)
    missed = []
    for count in (k, 4 * k):
        palette, chosen = choose_filaments(codes, np.ones(len(codes)), count)
        assert len(palette) == count
        missed.append(delta_e(lab, lab_from_srgb(palette[chosen])).mean())
    assert missed[1] < missed[0]


def test_fewer_colours_than_filaments():
    palette, chosen = choose_filaments(np.uint8([WHITE, WHITE]), np.ones(2), 5)
    np.testing.assert_array_equal(palette, [WHITE])
    assert chosen.tolist() == [0, 0]


def test_given_filaments_stay_in_their_order_and_the_nearest_is_taken():
    codes, _ = three_groups()
    given = ["#C82020", "101010", "#FFFFFF", "#00FF00"]
    palette, chosen = choose_filaments(codes, np.ones(len(codes)), given)
    assert palette.tolist() == [[200, 32, 32], [16, 16, 16], [255, 255, 255], [0, 255, 0]]
    assert np.bincount(chosen, minlength=4).tolist() == [100, 900, 9000, 0]


def test_a_triangle_takes_what_two_of_its_corners_have_or_the_mean():
    palette = np.uint8([(0, 0, 0), (255, 255, 255), (170, 170, 170)])
    faces = np.int32([[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 0, 0], [0, 2, 3]])
    chosen = np.int32([0, 0, 1, 2])
    assert choose_for_triangles(faces, chosen, palette).tolist() == [0, 0, 0, 0, 2]


def test_splitting_gives_every_triangle_vertices_of_its_own_filament():
    faces = np.int32([[0, 1, 2], [1, 3, 2], [2, 3, 4]])
    ids, split, filaments = split_by_filament(faces, np.int32([0, 1, 1]), 2)
    np.testing.assert_array_equal(ids[split], faces)
    np.testing.assert_array_equal(filaments[split], [[0] * 3, [1] * 3, [1] * 3])
    assert len(ids) == 5 + 2


@pytest.fixture
def ball():
    """A sphere, light above and dark below, with a red belt."""
    solid = trimesh.creation.icosphere(subdivisions=3, radius=20.0)
    codes = np.where(solid.vertices[:, 2:] > 0, np.uint8(WHITE), np.uint8(BLACK))
    codes[np.abs(solid.vertices[:, 2]) < 3] = RED
    return TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces), np.uint8(codes))


def test_3mf_has_a_material_for_each_filament_and_one_on_each_triangle(ball, tmp_path):
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=3))
    with zipfile.ZipFile(tmp_path / "a.3mf") as archive:
        root = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    bases = root.findall("c:resources/c:basematerials/c:base", CORE)
    colours = {base.get("displaycolor") for base in bases}
    assert colours == {"#FAF8F0", "#141416", "#C8281E"}
    triangles = root.findall(".//c:triangle", CORE)
    assert len(triangles) == ball.n_faces
    assert {triangle.get("pid") for triangle in triangles} == {"1"}
    assert {triangle.get("p1") for triangle in triangles} == {"0", "1", "2"}
    assert all(triangle.get("p2") is None for triangle in triangles)
    assert len(root.findall(".//c:vertex", CORE)) == ball.n_vertices


def test_lib3mf_reads_the_materials_strictly(ball, tmp_path):
    lib3mf = pytest.importorskip("lib3mf")
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=["#FFFFFF", "#000000"]))
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "a.3mf"))
    assert reader.GetWarningCount() == 0
    objects = model.GetMeshObjects()
    assert objects.MoveNext()
    solid = objects.GetCurrentMeshObject()
    assert solid.IsManifoldAndOriented()
    used = {(p.ResourceID, p.PropertyIDs[0]) for p in solid.GetAllTriangleProperties()}
    assert len(used) == 2


@pytest.mark.parametrize("suffix", [".ply", ".glb", ".obj"])
def test_other_formats_have_one_colour_a_triangle(ball, tmp_path, suffix):
    export(ball, tmp_path / f"a{suffix}", ExportOptions(filaments=2))
    back = load_mesh(tmp_path / f"a{suffix}")
    corner_colours = back.colours[back.faces]
    np.testing.assert_array_equal(corner_colours, np.repeat(corner_colours[:, :1], 3, axis=1))
    assert len(np.unique(back.colours, axis=0)) == 2
    assert back.n_faces == ball.n_faces
    assert back.area == pytest.approx(ball.area, rel=1e-5)

"""Few colours for printers: chosen well, one for every triangle, in the file that slicers read."""

import json
import re
import zipfile
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import pytest
import trimesh

from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.spectra import decode_srgb, srgb_from_linear
from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.files.filaments import (
    choose_filaments,
    choose_for_triangles,
    split_by_filament,
)
from paint3d.files.load import load_mesh, read_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh

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


def test_edges_of_black_on_white_are_black_or_white_though_teal_is_nearer():
    given = ["#f4f1e8", "#1c1b1a", "#b23a2a", "#2ca2a4"]
    white, black, _, teal = (decode_srgb(np.frombuffer(bytes.fromhex(c[1:]), "u1")) for c in given)
    share = np.linspace(0.0, 1.0, 41)[:, None]
    for ink, place in ((black, 1), (teal, 3)):
        edge = srgb_from_linear((1.0 - share) * white + share * ink)
        _, chosen = choose_filaments(edge, np.ones(len(edge)), given)
        assert set(chosen) == {0, place}
        assert abs(int((chosen == 0).sum()) - 20) < 6


def test_greys_between_black_and_white_have_filaments_of_their_own():
    given = ["#f4f1e8", "#c8c6c0", "#6e6c69", "#1c1b1a"]
    white, black = (decode_srgb(np.frombuffer(bytes.fromhex(c[1:]), "u1")) for c in given[::3])
    ramp = srgb_from_linear(white + np.linspace(0.0, 1.0, 61)[:, None] * (black - white))
    _, chosen = choose_filaments(ramp, np.ones(61), given)
    assert (np.diff(chosen) >= 0).all()
    assert set(chosen) == {0, 1, 2, 3}


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


def named_as_written(path):
    """Elements of the model part by their names with prefixes, as slicers compare them."""
    found = []
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda name, attributes: found.append((name, attributes))
    with zipfile.ZipFile(path) as archive:
        parser.Parse(archive.read("3D/3dmodel.model"), True)
    return found


def painted(code):
    """The filament, from 1, of a triangle that slicers read from its last digit on."""
    bits = "".join(f"{int(digit, 16):04b}" for digit in code)
    assert bits[-2:] == "00", "it is split"
    return int(bits[-4:-2], 2) if bits[-4:-2] != "11" else int(bits[:-4], 2) + 3


GIVEN = [f"#{k:02X}{255 - k:02X}{2 * k:02X}" for k in range(0, 96, 6)]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 16])
def test_every_triangle_has_the_same_filament_for_every_slicer(ball, tmp_path, n):
    """As a colour of a group, and as Bambu Studio, Orca and PrusaSlicer paint."""
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=GIVEN[:n]))
    elements = named_as_written(tmp_path / "a.3mf")
    colours = [a["color"] for name, a in elements if name == "m:color"]
    assert colours == GIVEN[:n]
    assert not any("base" in name for name, _ in elements)
    triangles = [a for name, a in elements if name == "triangle"]
    assert len(triangles) == ball.n_faces
    for triangle in triangles:
        assert (triangle["pid"], "p2" in triangle) == ("1", False)
        assert triangle["paint_color"] == triangle["slic3rpe:mmu_segmentation"]
        assert painted(triangle["paint_color"]) == int(triangle["p1"]) + 1


def test_slots_are_filled_beforehand(ball, tmp_path):
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=GIVEN[:3]))
    elements = named_as_written(tmp_path / "a.3mf")
    with zipfile.ZipFile(tmp_path / "a.3mf") as archive:
        model = archive.read("3D/3dmodel.model")
        project = json.loads(archive.read("Metadata/project_settings.config"))
        config = ElementTree.fromstring(archive.read("Metadata/model_settings.config"))
    assert b'<metadata name="Application">BambuStudio-02.00.00.00</metadata>' in model
    assert project["filament_colour"] == GIVEN[:3]
    (item,) = [a for name, a in elements if name == "item"]
    (component,) = [a for name, a in elements if name == "component"]
    assert config.find("object").get("id") == item["objectid"]
    assert config.find("object/part").get("id") == component["objectid"]


def test_more_filaments_than_slicers_know_are_colours_alone(ball, tmp_path):
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=[*GIVEN, "#010203"]))
    triangles = [a for name, a in named_as_written(tmp_path / "a.3mf") if name == "triangle"]
    assert all(set(a) == {"v1", "v2", "v3", "pid", "p1"} for a in triangles)
    with zipfile.ZipFile(tmp_path / "a.3mf") as archive:
        assert b"BambuStudio-" not in archive.read("3D/3dmodel.model")
        assert not any(name.endswith(".config") for name in archive.namelist())


def test_lib3mf_reads_the_filaments_strictly(ball, tmp_path):
    """But for an attribute that Bambu Studio has without a namespace."""
    lib3mf = pytest.importorskip("lib3mf")
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=["#FFFFFF", "#000000"]))
    for name, is_strict in (("a.3mf", False), ("strict.3mf", True)):
        if is_strict:
            with (
                zipfile.ZipFile(tmp_path / "a.3mf") as archive,
                zipfile.ZipFile(tmp_path / name, "w") as plain,
            ):
                for part in archive.namelist():
                    plain.writestr(part, re.sub(rb' paint_color="\w+"', b"", archive.read(part)))
        model = lib3mf.get_wrapper().CreateModel()
        reader = model.QueryReader("3mf")
        reader.SetStrictModeActive(is_strict)
        reader.ReadFromFile(str(tmp_path / name))
        assert reader.GetWarningCount() == (0 if is_strict else ball.n_faces)
        objects = model.GetMeshObjects()
        assert objects.MoveNext()
        solid = objects.GetCurrentMeshObject()
        assert solid.IsManifoldAndOriented()
        used = {(p.ResourceID, p.PropertyIDs[0]) for p in solid.GetAllTriangleProperties()}
        assert len(used) == 2


def test_our_own_reader_takes_the_colours_and_says_nothing(ball, tmp_path):
    export(ball, tmp_path / "a.3mf", ExportOptions(filaments=["#FFFFFF", "#000000"]))
    reading = read_mesh(tmp_path / "a.3mf", texture=True)
    assert reading.notes == ()
    assert {tuple(c) for c in reading.mesh.colours.tolist()} == {(255,) * 3, (0,) * 3}


@pytest.mark.parametrize("suffix", [".ply", ".glb", ".obj"])
def test_other_formats_have_one_colour_a_triangle(ball, tmp_path, suffix):
    export(ball, tmp_path / f"a{suffix}", ExportOptions(filaments=2))
    back = load_mesh(tmp_path / f"a{suffix}")
    corner_colours = back.colours[back.faces]
    np.testing.assert_array_equal(corner_colours, np.repeat(corner_colours[:, :1], 3, axis=1))
    assert len(np.unique(back.colours, axis=0)) == 2
    assert back.n_faces == ball.n_faces
    assert back.area == pytest.approx(ball.area, rel=1e-5)

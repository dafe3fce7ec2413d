"""What an export can be asked for: units, axes, light, density, filaments; and what it refuses."""

import json
import os
import zipfile
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import paint3d
from paint3d.colour.pigments import load_pigment
from paint3d.errors import ExportError, InputError, UnknownNameError
from paint3d.files.export import FORMATS, export, prepare_export
from paint3d.files.export_options import ExportOptions
from paint3d.files.formats.gltf import read_gltf, write_glb
from paint3d.files.formats.records import read_records
from paint3d.files.load import load_mesh
from paint3d.files.project.painting import Painting
from paint3d.mesh.triangle_mesh import TriangleMesh

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
TRIPS = 10 if "PAINT3D_MORE_EXAMPLES" in os.environ else 3  # set by scripts/check --long
MATERIALS = "{http://schemas.microsoft.com/3dmanufacturing/material/2015/02}"


def box(size=(10.0, 20.0, 40.0)):
    """A box whose corners have one vertex a side, with colours that say where they are."""
    solid = trimesh.creation.box(size)
    solid.unmerge_vertices()
    codes = np.uint8(127 + 100 * np.sign(solid.vertices))
    return TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces), codes, "box")


def document_of(path):
    data = path.read_bytes()
    return json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb", ".3mf"])
@pytest.mark.parametrize("unit", ["mm", "cm", "m", "in"])
def test_the_unit_can_be_chosen(tmp_path, suffix, unit):
    export(box(), tmp_path / f"a{suffix}", ExportOptions(unit=unit))
    back = load_mesh(tmp_path / f"a{suffix}", unit=None if suffix == ".3mf" else unit)
    np.testing.assert_allclose(np.ptp(back.vertices, axis=0), (10, 20, 40), rtol=1e-6)


@pytest.mark.parametrize(
    ("suffix", "extent"),
    [(".ply", (10, 20, 40)), (".obj", (10, 20, 40)), (".3mf", (10, 20, 40)),
     (".glb", (0.01, 0.04, 0.02))],
)  # fmt: skip
def test_units_and_axes_are_those_of_the_format(tmp_path, suffix, extent):
    export(box(), tmp_path / f"a{suffix}")
    other = trimesh.load(tmp_path / f"a{suffix}", process=False, force="mesh")
    np.testing.assert_allclose(other.extents, extent, rtol=1e-6)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".3mf", ".glb"])
def test_the_up_axis_can_be_chosen(tmp_path, suffix):
    mesh = box()
    for up_axis in "yz":
        export(mesh, tmp_path / f"a{suffix}", ExportOptions(up_axis=up_axis, unit="mm"))
        other = trimesh.load(tmp_path / f"a{suffix}", process=False, force="mesh")
        tall = (10, 40, 20) if up_axis == "y" else (10, 20, 40)
        np.testing.assert_allclose(other.extents, tall, rtol=1e-6)
        assert other.volume == pytest.approx(8000)  # turned, not mirrored


def test_a_glb_can_be_unlit(tmp_path):
    export(box(), tmp_path / "a.glb")
    assert "extensionsUsed" not in document_of(tmp_path / "a.glb")
    export(box(), tmp_path / "a.glb", ExportOptions(unlit=True))
    document = document_of(tmp_path / "a.glb")
    assert document["extensionsUsed"] == ["KHR_materials_unlit"]
    assert document["materials"][0]["extensions"] == {"KHR_materials_unlit": {}}
    np.testing.assert_array_equal(load_mesh(tmp_path / "a.glb").colours, box().colours)


def test_the_corners_of_a_box_are_closed_in_3mf_and_keep_their_colours(tmp_path):
    mesh = box()
    codes = mesh.colours.copy()
    codes[mesh.faces[0]] = (255, 0, 0)  # one side's corners differ from their neighbours'
    export(TriangleMesh(mesh.vertices, mesh.faces, codes), tmp_path / "a.3mf")
    with zipfile.ZipFile(tmp_path / "a.3mf") as archive:
        root = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    assert len(list(root.iter(f"{CORE}vertex"))) == 8
    colours = [element.get("color") for element in root.iter(f"{MATERIALS}color")]
    corners = [
        [colours[int(triangle.get(place))] for place in ("p1", "p2", "p3")]
        for triangle in root.iter(f"{CORE}triangle")
    ]
    wanted = [[f"#{bytes(code).hex().upper()}" for code in three] for three in codes[mesh.faces]]
    assert corners == wanted
    other = trimesh.load(tmp_path / "a.3mf", process=False, force="mesh")
    assert other.is_watertight


def spotted(name="plane"):
    """An object with dark ink on one side, refined all over."""
    surface = paint3d.PaintedSurface(paint3d.load_mesh(name), resolution=4.0)
    surface.refine_all()
    column = surface.column_of(load_pigment("pine soot"))
    along = surface.mesh.vertices[:, 0]
    ids = np.flatnonzero(along > 0.4 * along.max())
    field = surface.ink
    field.amounts[ids, column] = field.coverage[ids] = field.dirty[ids] = 1
    field.dirty_ids[: len(ids)] = ids
    field.n_dirty[0] = len(ids)
    return surface


def test_exact_leaves_no_vertex_out_and_the_default_does(tmp_path):
    surface = spotted()
    counts = {}
    for name, options in {
        "usual": {},
        "coarse": {"tolerance": 30.0},
        "all": {"exact": True},
    }.items():
        export(surface, tmp_path / "a.ply", ExportOptions(**options))
        counts[name] = load_mesh(tmp_path / "a.ply").n_vertices
    assert counts["all"] == surface.n_vertices
    assert counts["coarse"] <= counts["usual"] < surface.n_vertices
    export(surface, tmp_path / "a.ply", ExportOptions(exact=True))
    back = load_mesh(tmp_path / "a.ply")
    order = surface.paint_mesh.source_order()
    np.testing.assert_array_equal(back.vertices, surface.mesh.vertices[order])
    np.testing.assert_array_equal(back.colours, surface.srgb[order])
    assert back.n_faces == len(surface.paint_mesh.leaf_faces())
    assert back.area == pytest.approx(surface.source.area)


def test_an_unpainted_object_comes_out_as_it_went_in(tmp_path):
    corners = box().vertices
    welded, place = np.unique(corners, axis=0, return_inverse=True)
    faces = np.r_[place[box().faces], [[3, 3, 4]]]  # one without area, and sharp corners
    mesh = TriangleMesh(welded, faces)
    surface = paint3d.PaintedSurface(mesh, resolution=2.0)
    surface.refine_all()
    vertices, kept, normals, srgb = surface.export_arrays()
    np.testing.assert_array_equal(vertices, mesh.vertices)
    np.testing.assert_array_equal(kept, mesh.faces)
    assert (srgb == srgb[0]).all()
    assert (np.einsum("ij,ij->i", normals, welded) > 0).all()
    export(surface, tmp_path / "a.obj")
    assert load_mesh(tmp_path / "a.obj").n_vertices == 8


def test_a_mesh_without_colours_is_white(tmp_path):
    mesh = TriangleMesh(box().vertices, box().faces)
    export(mesh, tmp_path / "a.ply")
    assert (load_mesh(tmp_path / "a.ply").colours == 255).all()


def test_dried_paint_is_exported_too(tmp_path):
    surface = spotted()
    export(surface, tmp_path / "wet.ply")
    surface.dry()
    assert not surface.coverage.any()
    export(surface, tmp_path / "dry.ply")
    assert load_mesh(tmp_path / "dry.ply").colours.min() < 90
    wet, dry = (load_mesh(tmp_path / f"{name}.ply").n_vertices for name in ("wet", "dry"))
    assert dry == wet


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".3mf", ".glb"])
def test_round_trips_through_our_own_reader_change_nothing(tmp_path, suffix):
    surface = spotted("sphere")
    files = [tmp_path / str(trip) / f"ball{suffix}" for trip in range(TRIPS + 1)]  # one name each
    for file in files:
        file.parent.mkdir()
    export(surface, files[0])
    first = load_mesh(files[0])
    vertices, faces, normals, srgb = surface.export_arrays()
    np.testing.assert_array_equal(first.vertices, vertices)
    np.testing.assert_array_equal(first.faces, faces)
    np.testing.assert_array_equal(first.colours, srgb)
    mesh = first
    for trip in range(1, TRIPS + 1):
        again = paint3d.PaintedSurface(mesh, resolution=4.0) if trip == 2 else mesh
        export(again, files[trip])
        mesh = load_mesh(files[trip])
    np.testing.assert_array_equal(mesh.vertices, first.vertices)
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.colours, srgb)
    if suffix in (".ply", ".glb"):  # from which normals are read
        np.testing.assert_array_equal(mesh.normals, normals)
    assert files[TRIPS].read_bytes() == files[1].read_bytes()


@given(
    arrays(
        np.float32,
        (12, 3),
        elements=st.floats(1.9375, 2.0625, width=32).map(
            lambda x: 2.0 ** (int(x * 1e4) % 40 - 20) * x
        )
        | st.floats(-1000.0, 1000.0, width=32).filter(lambda x: x == 0.0 or abs(x) > 1e-34),
    ),
    st.sampled_from("yz"),
)
@settings(max_examples=60, deadline=None)
def test_metres_give_back_the_millimetres_to_the_last_bit(tmp_path_factory, vertices, up_axis):
    path = tmp_path_factory.mktemp("trip") / "a.glb"
    faces = np.arange(12, dtype=np.int32).reshape(-1, 3)
    up = np.tile(np.float32([0.0, 0.0, 1.0]), (12, 1))
    painting = Painting(vertices, faces, up, np.zeros((12, 3), np.uint8), "ink")
    placed = painting.converted("m", up_axis)
    write_glb(path, *placed[:4], steps=placed.steps)
    raw = read_gltf(path.read_bytes(), path.parent)
    back = (raw.vertices * raw.unit_mm).astype(np.float32)
    turned = vertices[:, [0, 2, 1]] * np.float32([1, 1, -1]) if up_axis == "y" else vertices
    np.testing.assert_array_equal(back, turned)


def test_what_float32_lost_of_metres_is_beside_them(tmp_path):
    """Half of the numbers just under a power of two come back as another from metres."""
    vertices = np.linspace(1.96, 1.99, 30, dtype=np.float32).reshape(10, 3)
    in_metres = vertices / np.float32(1000.0)
    assert (in_metres.astype(float) * 1000.0).astype(np.float32).tolist() != vertices.tolist()
    faces = np.int32([[0, 1, 2]])
    mesh = TriangleMesh(vertices, faces, np.zeros((10, 3), np.uint8), "thin")
    export(mesh, tmp_path / "a.glb")
    np.testing.assert_array_equal(load_mesh(tmp_path / "a.glb").vertices, vertices)
    other = trimesh.load(tmp_path / "a.glb", process=False, force="mesh")
    np.testing.assert_array_equal(np.float32(other.vertices)[:, 0], in_metres[:, 0])
    export(box(), tmp_path / "b.glb")  # nothing is lost, nothing added
    attributes = document_of(tmp_path / "b.glb")["meshes"][0]["primitives"][0]["attributes"]
    assert set(attributes) == {"POSITION", "NORMAL", "COLOR_0"}


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"unit": "ft"}, UnknownNameError, "unknown unit 'ft'"),
        ({"up_axis": "x"}, UnknownNameError, "unknown up axis 'x'"),
        ({"tolerance": -1.0}, InputError, "tolerance"),
        ({"tolerance": float("nan")}, InputError, "tolerance"),
        ({"filaments": 0}, InputError, "filaments is 0; expected 1 to 64"),
        ({"filaments": True}, InputError, "expected how many, or a list of colours"),
        ({"filaments": "#112233"}, InputError, "expected how many, or a list of colours"),
        ({"filaments": []}, InputError, "the number of filaments is 0"),
        ({"filaments": ["#12345"]}, InputError, "'#12345' is not a colour"),
        ({"unlit": True}, ExportError, r"\.ply files cannot have unlit; expected one of \.glb"),
    ],
)
def test_wishes_that_cannot_be(tmp_path, options, error, message):
    with pytest.raises(error, match=message):
        export(box(), tmp_path / "a.ply", ExportOptions(**options))
    assert list(tmp_path.iterdir()) == []


def test_every_format_says_no_to_what_it_cannot_do(tmp_path):
    wishes = {"unit": "cm", "up_axis": "y", "unlit": True, "texture": 64, "filaments": 2}
    wishes["packed_normals"] = True
    for suffix, form in FORMATS.items():
        for wish, value in wishes.items():
            if wish not in form.takes:
                with pytest.raises(ExportError, match=wish.replace("_", " ")):
                    export(box(), tmp_path / f"a{suffix}", ExportOptions(**{wish: value}))


@pytest.mark.parametrize("packed", [False, True])
def test_records_in_both_readings_of_the_paper(tmp_path, packed):
    export(box(), tmp_path / "a.p3d.txt", ExportOptions(packed_normals=packed))
    back = read_records(tmp_path / "a.p3d.txt")
    np.testing.assert_allclose(back.vertices, box().vertices)
    np.testing.assert_array_equal(back.srgb, box().colours)
    assert (tmp_path / "a.p3d.txt").read_text().splitlines()[2].count(",") == (6 if packed else 8)


def test_a_material_without_name_is_a_painting(tmp_path):
    surface = SimpleNamespace(
        material=object(),
        export_arrays=lambda tolerance: (
            box().vertices,
            box().faces,
            box().vertices,
            box().colours,
        ),
    )
    export(surface, tmp_path / "a.glb")
    assert document_of(tmp_path / "a.glb")["materials"][0]["name"] == "painting"


def test_what_is_prepared_once_is_written_in_several_formats(tmp_path):
    """The same bytes as an export each, and a wish that a format does not know is refused."""
    mesh = load_mesh("bowl")
    prepared = prepare_export(mesh, tmp_path / "bowl.ply", ExportOptions())
    for suffix in (".ply", ".glb", ".obj", ".p3d.txt"):
        one, other = tmp_path / f"bowl{suffix}", tmp_path / "again" / f"bowl{suffix}"
        other.parent.mkdir(exist_ok=True)
        prepared.into(one).write()
        export(mesh, other)
        assert one.read_bytes() == other.read_bytes()
    with pytest.raises(ExportError, match="a session is saved"):
        prepared.into(tmp_path / "bowl.p3d")
    unlit = prepare_export(mesh, tmp_path / "bowl.glb", ExportOptions(unlit=True))
    with pytest.raises(ExportError, match="unlit"):
        unlit.into(tmp_path / "bowl.ply")

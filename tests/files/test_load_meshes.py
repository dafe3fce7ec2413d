"""Loading mesh files: every format from other people's writers, and bad files by name."""

import base64
import gzip
import io
import json
import os
import struct
import subprocess
import sys
import time
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from paint3d.core.machine import make_memory_file
from paint3d.errors import MeshError, UnknownNameError
from paint3d.files import sandbox
from paint3d.files.export import export
from paint3d.files.formats.gltf import write_glb
from paint3d.files.formats.ply import write_ply
from paint3d.files.load import load_mesh
from paint3d.files.reading import ReadOptions, read_surface, read_surface_apart
from paint3d.files.sandbox import receive, send
from scripts.solids import make_plane

BOX = trimesh.creation.box((10.0, 20.0, 30.0))
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
PLY_HEAD = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n" \
    "property float z\n"  # fmt: skip
PLY_FACE = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
PLY_ROWS = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def written(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "stl_ascii", "off", "glb", "gltf", "3mf"])
def test_a_box_written_by_another_program(tmp_path, kind):
    path = tmp_path / f"box.{kind.removesuffix('_ascii')}"
    if kind == "gltf":
        for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(BOX)).items():
            (tmp_path / ("box.gltf" if name == "model.gltf" else name)).write_bytes(data)
    else:
        BOX.export(path, file_type=kind)
    mesh = load_mesh(path, unit="mm")
    expected = (10, 30, 20) if kind in ("glb", "gltf") else (10, 20, 30)  # glTF is y up
    np.testing.assert_allclose(np.ptp(mesh.bounds, axis=0), expected, rtol=1e-6)
    assert mesh.area == pytest.approx(BOX.area)
    assert (mesh.n_faces, mesh.n_vertices) == (12, 8)
    outward = np.einsum("ij,ij->i", mesh.face_normals, mesh.vertices[mesh.faces].mean(axis=1))
    assert (outward > 0).all()


def test_order_of_vertices_and_faces_is_kept(tmp_path):
    for suffix in ("ply", "obj", "off"):
        BOX.export(tmp_path / f"box.{suffix}")
        mesh = load_mesh(tmp_path / f"box.{suffix}")
        np.testing.assert_allclose(mesh.vertices, BOX.vertices, atol=1e-6)
        np.testing.assert_array_equal(mesh.faces, BOX.faces)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1), ("cm", 10), ("m", 1000), ("in", 25.4)])
def test_units(tmp_path, unit, factor):
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    assert load_mesh(path, unit=unit).bounds[1, 0] == pytest.approx(factor)


def test_gltf_is_in_metres_with_y_up_unless_told_otherwise(tmp_path):
    plane = make_plane()
    export(plane, tmp_path / "a.glb")
    mesh = load_mesh(tmp_path / "a.glb")
    np.testing.assert_allclose(mesh.vertices, plane.vertices, atol=1e-4)
    np.testing.assert_allclose(mesh.normals, plane.normals, atol=1e-6)
    assert load_mesh(tmp_path / "a.glb", unit="mm").bounds[1, 0] == pytest.approx(0.1)


def test_unknown_unit_name_and_suffix(tmp_path):
    with pytest.raises(UnknownNameError, match="unknown unit 'feet'"):
        load_mesh("bowl", unit="feet")
    with pytest.raises(MeshError, match=r"bowll: no such file.*bowl, plate, vase, sphere, plane"):
        load_mesh("bowll")
    with pytest.raises(
        MeshError, match=r"suffix '\.abc' is not known; expected one of \.ply \.obj"
    ):
        load_mesh(written(tmp_path, "a.abc", "x"))
    for name, kind in (("a.usdz", "USD"), ("a.WRL", "VRML"), ("a.fbx", "FBX")):
        with pytest.raises(MeshError, match=rf"{kind} is not read \(Blender saves it as \.glb\)"):
            load_mesh(written(tmp_path, name, "x"))
    with pytest.raises(MeshError, match="it is a folder"):
        load_mesh(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no such files")
def test_what_is_there_and_no_file_is_not_told_to_be_missing(tmp_path):
    os.mkfifo(tmp_path / "pipe.obj")
    (tmp_path / "loop.obj").symlink_to(tmp_path / "loop.obj")
    with pytest.raises(MeshError, match=r"pipe\.obj: it is no plain file; expected a mesh file"):
        load_mesh(tmp_path / "pipe.obj")
    with pytest.raises(MeshError, match=r"loop\.obj: it is a link that leads nowhere; expected"):
        load_mesh(tmp_path / "loop.obj")


def test_a_file_wins_over_a_built_in_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_mesh("plane").n_faces == 512
    (tmp_path / "plane").write_text("not a mesh")
    with pytest.raises(MeshError, match="it has no suffix"):
        load_mesh("plane")


def test_packed_files(tmp_path):
    packed = gzip.compress((TRIANGLE + "f 1 2 3\n").encode())
    assert load_mesh(written(tmp_path, "a.obj.gz", packed)).n_faces == 1
    with pytest.raises(MeshError, match="cannot read it"):
        load_mesh(written(tmp_path, "b.obj.gz", packed[:-12]))


def test_concave_polygons_and_relative_indices(tmp_path):
    arrow = "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf -4 -3 -2 -1\nv 9 9 9\n"
    mesh = load_mesh(written(tmp_path, "a.obj", arrow))
    assert mesh.area == pytest.approx(4.0)
    assert (mesh.face_normals[:, 2] == 1.0).all()


def test_vertex_colours_come_as_srgb(tmp_path):
    codes = np.array([[255, 0, 0], [1, 128, 254], [10, 20, 30]], np.uint8)
    flat = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    up = np.tile(np.float32([0, 0, 1]), (3, 1))
    write_ply(tmp_path / "a.ply", flat, np.array([[0, 1, 2]]), up, codes)
    write_glb(tmp_path / "a.glb", flat, np.array([[0, 1, 2]]), up, codes)
    rows = [f"v {x} {y} {z} {r / 255} {g / 255} {b / 255}"
            for (x, y, z), (r, g, b) in zip(flat, codes.tolist(), strict=True)]  # fmt: skip
    written(tmp_path, "a.obj", "\n".join(rows) + "\nf 1 2 3\n")
    for name in ("a.ply", "a.glb", "a.obj"):
        np.testing.assert_array_equal(load_mesh(tmp_path / name).colours, codes)


def test_a_scene_is_merged_with_its_transforms(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(BOX, transform=trimesh.transformations.translation_matrix((0, 50, 0)))
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    scene.add_geometry(BOX, transform=mirror)
    scene.export(tmp_path / "a.glb")
    mesh = load_mesh(tmp_path / "a.glb", unit="mm")
    assert mesh.n_faces == 24
    assert mesh.bounds[1, 2] == pytest.approx(60.0)
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).volume == pytest.approx(2 * BOX.volume)


BAD_FILES = {
    "empty.ply": (b"", "the file is empty"),
    "not.ply": (b"solid", "does not start with 'ply'"),
    "endless.ply": (b"ply\nformat ascii 1.0\n", "no end"),
    "format.ply": (b"ply\nformat morse 1.0\nend_header\n", "header cannot be understood"),
    "type.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n", "half"),
    "cut.ply": (PLY_HEAD + PLY_FACE + PLY_ROWS[:-4], "ends within the face rows"),
    "nan.ply": (PLY_HEAD + PLY_FACE + PLY_ROWS.replace("1 0 0", "1 nan 0"), "vertex 1 is"),
    "word.ply": (PLY_HEAD + PLY_FACE + PLY_ROWS.replace("1 0 0", "1 x 0"), "has 'x' where"),
    "index.ply": (PLY_HEAD + PLY_FACE + PLY_ROWS.replace("3 0 1 2", "3 0 1 7"),
                  "face 0 refers to vertex 7; expected 0 to 2"),
    "negative.ply": (PLY_HEAD + PLY_FACE + PLY_ROWS.replace("3 0 1 2", "3 0 1 -2"), "vertex -2"),
    "points.ply": (PLY_HEAD + "end_header\n0 0 0\n1 0 0\n0 1 0\n", "3 points and no triangles"),
    "faceless.ply": (PLY_HEAD + PLY_FACE.replace("face 1", "face 0") + PLY_ROWS[:-8],
                     "3 points but no triangles, though it says it has faces"),
    "huge.ply": (PLY_HEAD.replace("vertex 3", "vertex 99999999999999") + PLY_FACE + PLY_ROWS,
                 "99,999,999,999,999 rows of vertex, but what follows has room"),
    "minus.ply": (PLY_HEAD.replace("vertex 3", "vertex -3") + PLY_FACE + PLY_ROWS, "-3 rows"),
    "million.ply": ((PLY_HEAD + PLY_FACE.replace("uchar", "int") + PLY_ROWS).replace(
        "3 0 1 2", "1000000 " + "0 1 2 1 " * 250_000), "face 0 has 1,000,000 corners"),
    "empty.obj": (b"# nothing\n", "no vertices and no triangles"),
    "zero.obj": (TRIANGLE + "f 0 1 2\n", "OBJ counts from 1"),
    "far.obj": (TRIANGLE + "f 1 2 4\n", "face 0 refers to vertex 3; expected 0 to 2"),
    "before.obj": ("f -1 -2 -3\n" + TRIANGLE, "refers to vertex -1"),
    "real.obj": (TRIANGLE + "f 1 2 2.5\n", "has 2.5 where a vertex index"),
    "short.obj": ("v 0 0\n", "expected three numbers"),
    "inf.obj": (TRIANGLE + "v inf 0 0\nf 1 2 3\n", "vertex 3 is"),
    "binary.obj": (bytes(range(256)) * 8, "no vertices"),
    "short.stl": (b"\0" * 60, "at least 84"),
    "cut.stl": (b"\0" * 80 + struct.pack("<I", 2) + b"\0" * 60, "room for 1 at most"),
    "none.stl": (b"\0" * 84, "no vertices"),
    "cut_ascii.stl": ("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n",
                      "1 facets, 0 of them ended, with 2 vertices"),
    "not.off": ("OFX\n1 1 1\n", "does not start with 'OFF'"),
    "counts.off": ("OFF\nmany\n", "not a count"),
    "cut.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n", "the file is cut short"),
    "corners.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "fewer corners than it says"),
    "cut.glb": (b"glTF" + struct.pack("<II", 2, 4000), "12 of 4000 bytes"),
    "old.glb": (b"glTF" + struct.pack("<II", 1, 12), "version 1; expected 2"),
    "text.gltf": ("{", "its JSON cannot be read"),
    "list.gltf": ("[]", "not an object"),
    "scenes.gltf": ('{"scenes": [{"nodes": [5]}]}', r"nodes\[5\], of which there are 0"),
    "loop.gltf": ('{"scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]}', "reached twice"),
    "type.gltf": ('{"scenes": [{"nodes": 7}]}', r"scenes\[0\].nodes is a number; expected a list"),
    "not.3mf": (b"PK", "not a readable 3MF archive"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_files_give_one_line_that_names_file_and_reason(tmp_path, name):
    data, message = BAD_FILES[name]
    path = written(tmp_path, name, data)
    with pytest.raises(MeshError, match=message) as caught:
        read_surface(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("offset", "value", "message"),
    [
        (10, 99, "'3D/3dmodel.model' is packed by method 99; expected it plain or deflated"),
        (10, 14, "packed by method 14"),
        (8, 1, "is encrypted"),
        (8, 64, "not a readable 3MF archive: strong encryption"),
        (6, 99, r"not a readable 3MF archive: zip file version 9\.9"),
        (26, 0x8000, "unpacks to over 1 GiB"),
    ],
)
def test_a_3mf_packed_as_none_may_be(tmp_path, offset, value, message):
    BOX.export(tmp_path / "a.3mf")
    data = bytearray((tmp_path / "a.3mf").read_bytes())
    struct.pack_into("<H", data, data.index(b"PK\1\2") + offset, value)  # of the first entry
    path = written(tmp_path, "a.3mf", bytes(data))
    with pytest.raises(MeshError, match=message) as caught:
        read_surface(path)
    assert str(caught.value).startswith(f"{path}: ")


def gltf(values, indices, **changes):
    data = np.array(values, "<f4").tobytes() + np.array(indices, "<u2").tobytes()
    n = len(values)
    document = {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": n, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 12 * n},
            {"buffer": 0, "byteOffset": 12 * n, "byteLength": 2 * len(indices)},
        ],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
    }
    return json.dumps(document | changes)


CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]


def test_strips_keep_their_orientation(tmp_path):
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}
    text = gltf(CORNERS, [0, 1, 2, 3], meshes=[{"primitives": [primitive]}])
    mesh = load_mesh(written(tmp_path, "a.gltf", text), unit="m")
    np.testing.assert_allclose(mesh.face_normals, [[0, -1, 0]] * 2, atol=1e-6)
    assert mesh.area == pytest.approx(1e6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (gltf(CORNERS, [0, 1, 9]), "refers to vertex 9"),
        (gltf([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [0, 1, 2]), "expected finite numbers"),
        (gltf(CORNERS, [0, 1]), "expected a multiple of 3"),
        (gltf(CORNERS, [0, 1, 2], bufferViews=[]), "bufferViews"),
        (gltf(CORNERS, [0, 1, 2], buffers=[{"byteLength": 9, "uri": "no.bin"}]), "is missing"),
        (gltf(CORNERS, [0, 1, 2], buffers=[{"byteLength": 9, "uri": "data:,*"}]), "not base64"),
        (gltf(CORNERS, [0, 1, 2], buffers=[{"byteLength": 999, "uri": "data:,"}]), "cut short"),
    ],
)
def test_bad_gltf(tmp_path, text, message):
    with pytest.raises(MeshError, match=message):
        read_surface(written(tmp_path, "a.gltf", text))


@pytest.fixture(scope="module")
def bases(tmp_path_factory):
    return list(damaged_bases(tmp_path_factory.mktemp("bases")))


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_damaged_files_load_or_say_so(bases, tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("damaged")
    kind, base = data.draw(st.sampled_from(bases))
    content = bytearray(base)
    for _ in range(data.draw(st.integers(1, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(content)))
    path = written(folder, f"a.{kind}", bytes(content[: cut if cut % 3 == 0 else None]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        message = failure(path)
    assert message is None or message.startswith(f"{path}: ")


def failure(path):
    """Return why a file cannot be loaded, or None."""
    try:
        assert np.isfinite(read_surface(path).mesh.vertices).all()
    except MeshError as cause:
        return str(cause)
    return None


def damaged_bases(folder):
    for kind in ("ply", "obj", "stl", "off", "glb", "3mf"):
        BOX.export(folder / f"base.{kind}")
        yield kind, (folder / f"base.{kind}").read_bytes()
    yield "gltf", gltf(CORNERS, [0, 1, 2]).encode()


@pytest.fixture
def sphere():
    return trimesh.creation.icosphere(subdivisions=3, radius=10.0)


def test_a_point_cloud_becomes_a_surface_and_says_so(tmp_path, sphere, caplog):
    pytest.importorskip("open3d", exc_type=ImportError)
    trimesh.PointCloud(sphere.vertices).export(tmp_path / "a.ply")
    mesh = load_mesh(tmp_path / "a.ply")
    assert mesh.area == pytest.approx(sphere.area, rel=1e-3)
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).volume == pytest.approx(sphere.volume, 1e-3)
    np.testing.assert_allclose(mesh.vertices, sphere.vertices, atol=1e-5)
    assert "a.ply: it is a point cloud: built 1,280 triangles through 642 points" in caplog.text
    with pytest.raises(MeshError, match="642 points but no triangles; expected a surface"):
        load_mesh(tmp_path / "a.ply", from_points=False)


def test_points_of_a_mesh_without_triangles_become_a_surface_only_when_asked(tmp_path, sphere):
    pytest.importorskip("open3d", exc_type=ImportError)
    head = PLY_HEAD.replace("vertex 3", "vertex 642") + PLY_FACE.replace("face 1", "face 0")
    text = head + "".join(f"{x} {y} {z}\n" for x, y, z in sphere.vertices)
    path = written(tmp_path, "a.ply", text)
    with pytest.raises(MeshError, match=r"though it says it has faces.*--from-points"):
        load_mesh(path)
    assert load_mesh(path, from_points=True).n_faces == 1280


def shades():
    """Four pixels of different colour, as PNG: the upper row is red and green."""
    codes = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [40, 80, 120]]], np.uint8)
    file = io.BytesIO()
    Image.fromarray(codes).save(file, "PNG")
    return file.getvalue(), codes.reshape(4, 3)


UV = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]]  # the middles, from the upper left


def test_an_obj_texture_is_read_at_the_vertices(tmp_path):
    picture, codes = shades()
    written(tmp_path, "my picture.png", picture)
    written(tmp_path, "a.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd -s 1 1 1 my picture.png\n")
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
    places = "".join(f"vt {u} {1 - v}\n" for u, v in UV)
    text = f"mtllib a.mtl\n{corners}{places}usemtl skin\nf 1/1 2/2 3/3\nf -2/-2 -3/-3 -1/-1\n"
    path = written(tmp_path, "a.obj", text)
    assert load_mesh(path).colours is None
    np.testing.assert_array_equal(load_mesh(path, texture=True).colours, codes)


def textured_gltf(uri):
    uv = np.array(UV, "<f4").tobytes()
    document = json.loads(gltf(CORNERS, [0, 1, 2, 2, 1, 3]))
    document["buffers"].append({"byteLength": 32, "uri": inline(uv)})
    document["bufferViews"].append({"buffer": 1, "byteLength": 32})
    document["accessors"].append(
        {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}
    )
    document["images"], document["textures"] = [{"uri": uri}], [{"source": 0}]
    surface = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1.0, 1.0, 1.0, 1.0]}
    document["materials"] = [{"pbrMetallicRoughness": surface}]
    primitive = document["meshes"][0]["primitives"][0]
    primitive["material"] = 0
    primitive["attributes"]["TEXCOORD_0"] = 2
    return json.dumps(document)


def inline(data):
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def test_a_gltf_texture_is_read_at_the_vertices(tmp_path):
    picture, codes = shades()
    path = written(tmp_path, "a.gltf", textured_gltf(inline(picture)))
    assert load_mesh(path).colours is None
    np.testing.assert_array_equal(load_mesh(path, texture=True).colours, codes)


@pytest.mark.parametrize("uri", ["../secret.png", "%2e%2e/secret.png", "link.png", "{folder}"])
def test_textures_outside_the_folder_are_not_followed(tmp_path, uri, caplog):
    folder = tmp_path / "inner"
    folder.mkdir()
    secret = written(tmp_path, "secret.png", shades()[0])
    (folder / "link.png").symlink_to(secret)
    path = written(folder, "a.gltf", textured_gltf(uri.format(folder=secret)))
    mesh = load_mesh(path, texture=True)
    assert (mesh.colours == 255).all()
    assert "outside its folder, which is not followed" in caplog.text
    document = json.loads(gltf(CORNERS, [0, 1, 2]))
    document["buffers"][0]["uri"] = uri.format(folder=secret)
    with pytest.raises(MeshError, match="outside its folder"):
        read_surface(written(folder, "b.gltf", json.dumps(document)))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "latin-1"])
@pytest.mark.parametrize("suffix", ["obj", "off"])
def test_text_in_other_encodings(tmp_path, encoding, suffix):
    texts = {"obj": "# Gefäß\n" + TRIANGLE + "f 1 2 3\n",
             "off": "OFF # Gefäß\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}  # fmt: skip
    text = texts[suffix].replace("\n", "\r")
    if encoding == "utf-16-le" or encoding == "utf-16-be":
        text = text.replace("# Gefäß", "# plain name")
    path = written(tmp_path, f"a.{suffix}", text.encode(encoding))
    assert read_surface(path).mesh.area == 0.5


def test_file_names_in_other_encodings(tmp_path):
    name = os.fsdecode(b"gef\xe4\xdf \xe7\xa2\x97.obj")
    path = written(tmp_path, name, TRIANGLE + "f 1 2 3\n")
    assert load_mesh(path).n_faces == 1
    with pytest.raises(MeshError, match="refers to vertex 8"):
        load_mesh(written(tmp_path, name, TRIANGLE + "f 1 2 9\n"))


def in_child(monkeypatch, code):
    """Let the child process run this instead of a reader."""
    start = f"import sys, json, os, signal; sys.path[:] = json.loads(sys.argv.pop())\n{code}\n"
    monkeypatch.setattr(sandbox, "START", start)


LIMITED = "import paint3d.files.reading as r, paint3d.files.sandbox as c\n"


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "reading it crashed \\(SIGSEGV\\)"),
        ("os._exit(0)", "reading it ended early"),
        ("raise SystemError('new to us')", "reading it ended early"),
        (LIMITED + "r.read_surface = lambda *_: bytearray(3 << 30)\nc.main()", "more than 2 GiB"),
    ],
)
def test_a_reader_that_fails_takes_nothing_with_it(tmp_path, monkeypatch, code, message):
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    in_child(monkeypatch, code)
    with pytest.raises(MeshError, match=message) as caught:
        read_surface_apart(path, ReadOptions())
    assert str(caught.value).startswith(f"{path}: ")


FOREVER = ("import time; time.sleep(600)", "while True: pass")


@pytest.mark.parametrize("code", FOREVER)
def test_a_reader_that_never_ends_is_ended(tmp_path, monkeypatch, code):
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    in_child(monkeypatch, code)
    limits = {"seconds": 0.4, "idle_seconds": 600} if "pass" in code else {"idle_seconds": 0.4}
    words = "longer than 0.4 s of computing" if "pass" in code else "stood still for 0.4 s"
    with pytest.raises(MeshError, match=words):
        read_surface_apart(path, ReadOptions(), **limits)


def test_a_child_without_a_parent_that_looks_ends_by_itself(tmp_path, monkeypatch):
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    in_child(
        monkeypatch, f"{LIMITED}def spin(*_):\n while True: pass\nr.read_surface = spin\nc.main()"
    )
    monkeypatch.setattr(sandbox.Watch, "look", lambda self: None)
    with pytest.raises(MeshError, match=r"longer than 0\.1 s of computing"):
        read_surface_apart(path, ReadOptions(), 0.1)


def test_what_a_file_costs_is_not_what_the_clock_says(tmp_path, monkeypatch):
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    in_child(
        monkeypatch,
        "import time; time.sleep(1.5)\nfrom paint3d.files.sandbox import main; main()",
    )
    assert read_surface_apart(path, ReadOptions(), seconds=1).mesh.n_faces == 1


def test_whoever_was_stopped_himself_refuses_no_good_file(tmp_path, monkeypatch):
    """As by Ctrl+Z: both stood still for an hour, and go on."""
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    in_child(
        monkeypatch,
        "import time; time.sleep(0.3)\nfrom paint3d.files.sandbox import main; main()",
    )
    stops = iter([0.0, 0.0, 3600.0])
    stopped, now = [0.0], time.monotonic

    def clock() -> float:
        stopped[0] += next(stops, 0.0)
        return now() + stopped[0]

    monkeypatch.setattr(sandbox, "time", SimpleNamespace(monotonic=clock))
    assert read_surface_apart(path, ReadOptions(), idle_seconds=60).mesh.n_faces == 1
    assert stopped == [3600.0]


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs processes kept to a core")
def test_a_busy_machine_refuses_no_good_file(tmp_path, monkeypatch):
    """Three others share its core: it computes a quarter of the time and is never idle."""
    path = written(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    core = {min(os.sched_getaffinity(0))}
    here = f"import os, time; os.sched_setaffinity(0, {core})\n"
    work = "while time.process_time() < 0.4: pass\n"
    work += "from paint3d.files.sandbox import main; main()"
    in_child(monkeypatch, here + work)
    others = [subprocess.Popen([sys.executable, "-c", here + "while True: pass"]) for _ in range(3)]
    try:
        reading = read_surface_apart(path, ReadOptions(), seconds=2.0, idle_seconds=2.0)
    finally:
        for other in others:
            other.kill()
            other.wait()
    assert reading.mesh.n_faces == 1


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xff\xff\xff\xff{}",
        b"\2\0\0\0{}",
        b'\x35\0\0\0{"rows": {"vertices": 1000000000000}, "facts": {}}   ',
        b'\x24\0\0\0{"rows": {"secrets": 1}, "facts": {}} ' + bytes(12),
        b'\x25\0\0\0{"rows": {"vertices": 1}, "facts": {}} ' + bytes(11),
    ],
)
def test_what_a_child_hands_over_is_checked(data):
    descriptor = make_memory_file()
    os.write(descriptor, data)
    with pytest.raises(MeshError, match="ended early"):
        receive(descriptor)
    os.close(descriptor)


def test_what_a_child_hands_over_arrives():
    descriptor = make_memory_file()
    arrays = {"vertices": np.eye(3, dtype=np.float32), "colours": np.full((3, 3), 7, np.uint8)}
    send(descriptor, arrays, {"name": "cube"})
    got, facts = receive(descriptor)
    os.close(descriptor)
    assert facts == {"name": "cube"}
    for name, array in arrays.items():
        np.testing.assert_array_equal(got[name], array)
        assert not got[name].flags.writeable


def test_the_child_needs_no_heavy_package():
    code = "import sys, paint3d.files.formats.gltf\n"
    code += "import paint3d.files.sandbox, paint3d.files.reading\n"
    code += "print({'numba', 'open3d', 'scipy', 'PIL', 'vtk'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"

"""Formats that trimesh reads for us, in the child process, with our checks after it."""

import base64
import contextlib
import io
import json
import struct
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.errors import MeshError
from paint3d.files.gltf_buffers import unpack_meshopt
from paint3d.files.load import MESH_SUFFIXES, load_mesh, read_mesh
from paint3d.files.readers import read_foreign
from paint3d.files.readers.read_foreign import FOREIGN
from paint3d.files.readers.read_gltf import read_gltf
from paint3d.files.sandbox.reading import FOREIGN_SUFFIXES

CUBE = trimesh.creation.box((1.0, 2.0, 3.0))  # of whatever unit the format has


def collada(path, up="Z_UP"):
    pytest.importorskip("collada")
    data = CUBE.export(file_type="dae")
    text = data.decode() if isinstance(data, bytes) else data
    head, _, tail = text.partition("<up_axis>")
    path.write_text(f"{head}<up_axis>{up}{tail[tail.index('<') :]}")
    return path


@pytest.mark.parametrize(("up", "size"), [("Z_UP", (1, 2, 3)), ("Y_UP", (1, 3, 2))])
def test_collada_with_its_unit_and_its_up(tmp_path, up, size):
    reading = read_mesh(collada(tmp_path / "a.dae", up))
    assert reading.mesh.n_faces == 12
    assert reading.knows_up
    spread = np.ptp(reading.mesh.vertices, axis=0)
    np.testing.assert_allclose(spread, 1000.0 * np.array(size), rtol=1e-5)


def test_packed_collada(tmp_path):
    collada(tmp_path / "a.dae")
    with zipfile.ZipFile(tmp_path / "a.zae", "w") as package:
        package.write(tmp_path / "a.dae", "a.dae")
    assert load_mesh(tmp_path / "a.zae").n_faces == 12


def test_openctm(tmp_path):
    pytest.importorskip("openctm")
    head = b"OCTM" + struct.pack("<I", 5) + b"RAW\0"
    head += struct.pack("<IIIII", len(CUBE.vertices), len(CUBE.faces), 0, 0, 0)
    body = struct.pack("<I", 0) + b"INDX" + CUBE.faces.astype("<u4").tobytes()
    body += b"VERT" + CUBE.vertices.astype("<f4").tobytes()
    (tmp_path / "a.ctm").write_bytes(head + body)
    assert load_mesh(tmp_path / "a.ctm").n_faces == 12


XAML = """<Viewport3D xmlns="http://schemas.microsoft.com/winfx/2006/xaml/presentation">
<ModelVisual3D><ModelVisual3D.Content><Model3DGroup><GeometryModel3D>
<GeometryModel3D.Geometry><MeshGeometry3D Positions="0,0,0 1,0,0 0,1,0 0,0,1"
 Normals="0,0,1 0,0,1 0,0,1 0,0,1" TriangleIndices="0,2,1 0,1,3 0,3,2 1,2,3"/>
</GeometryModel3D.Geometry>
<GeometryModel3D.Material><MaterialGroup><DiffuseMaterial><DiffuseMaterial.Brush>
<SolidColorBrush Color="#FF0000" Opacity="1"/></DiffuseMaterial.Brush></DiffuseMaterial>
</MaterialGroup></GeometryModel3D.Material>
</GeometryModel3D></Model3DGroup></ModelVisual3D.Content></ModelVisual3D></Viewport3D>
"""


def test_xaml(tmp_path):
    (tmp_path / "a.xaml").write_text(XAML)
    assert load_mesh(tmp_path / "a.xaml").n_faces == 4


def test_points_become_a_surface(tmp_path):
    ball = trimesh.creation.icosphere(3, 20.0).vertices
    np.savetxt(tmp_path / "a.xyz", ball, fmt="%.5f")
    reading = read_mesh(tmp_path / "a.xyz")
    assert "point cloud" in reading.notes[0]
    assert reading.mesh.n_vertices == len(ball)


def test_a_drawing_is_a_plate_with_its_holes(tmp_path):
    square = np.array([(0, 0), (40, 0), (40, 40), (0, 40), (0, 0)], float)
    paths = [trimesh.load_path(square), trimesh.load_path(square * 0.5 + 10.0)]
    (tmp_path / "a.dxf").write_text(trimesh.path.util.concatenate(paths).export(file_type="dxf"))
    mesh = load_mesh(tmp_path / "a.dxf", unit="mm")
    assert mesh.double_areas.sum() / 2 == pytest.approx(1200.0)
    assert (mesh.face_normals[:, 2] > 0.99).all()
    assert np.ptp(mesh.vertices, axis=0).tolist() == pytest.approx([40.0, 40.0, 0.0])


@pytest.mark.parametrize(
    ("header", "mm"),
    [
        ("9\n$INSUNITS\n70\n1\n", 25.4),
        ("9\n$INSUNITS\n70\n6\n", 1000.0),
        ("9\n$LUNITS\n70\n2\n", 1.0),  # decimal numbers, of no unit
        ("9\n$LUNITS\n70\n2\n9\n$INSUNITS\n70\n4\n", 1.0),
        ("9\n$LUNITS\n70\n2\n9\n$INSUNITS\n70\n0\n", 1.0),
    ],
)
def test_a_plate_has_the_unit_of_its_drawing(tmp_path, header, mm):
    path = trimesh.load_path(np.array([(0, 0), (2, 0), (2, 1), (0, 1), (0, 0)], float))
    text = path.export(file_type="dxf")
    entities = text[text.index("ENTITIES") :]
    (tmp_path / "a.dxf").write_text(
        f"0\nSECTION\n2\nHEADER\n{header}0\nENDSEC\n0\nSECTION\n2\n{entities}"
    )
    reading = read_mesh(tmp_path / "a.dxf")
    assert np.ptp(reading.mesh.vertices, axis=0).tolist() == pytest.approx([2 * mm, mm, 0.0])


def test_a_drawing_in_svg(tmp_path):
    pytest.importorskip("svg.path")
    shape = "M0 0 H40 V40 H0 Z"
    (tmp_path / "a.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg"><path d="{shape}"/></svg>'
    )
    assert load_mesh(tmp_path / "a.svg").double_areas.sum() / 2 == pytest.approx(1600.0)


def test_what_is_missing_is_named_with_how_to_get_it(monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(read_foreign, "import_module", missing)
    with pytest.raises(MeshError, match=r'trimesh is missing; .* pip install "paint3d\[meshes\]"'):
        read_foreign.read_foreign(b"", ".ctm")
    monkeypatch.setattr(
        read_foreign, "import_module", lambda name: trimesh if name == "trimesh" else missing(name)
    )
    with pytest.raises(MeshError, match=r"COLLADA .* collada is missing; .*paint3d\[meshes\]"):
        read_foreign.read_foreign(b"", ".dae")


@pytest.mark.parametrize("suffix", sorted(FOREIGN))
def test_rubbish_ends_in_one_line(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"\x00rubbish \xff 1 2 3\n" * 3)
    with pytest.raises(MeshError) as caught:
        load_mesh(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("packing", [zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA])
def test_a_damaged_package_ends_in_one_line(tmp_path, packing):
    pytest.importorskip("collada")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", packing) as package:
        package.writestr("a.dae", "<a>" * 1000)
    data = bytearray(packed.getvalue())
    data[45] ^= 0xFF
    data[60] ^= 0xFF
    (tmp_path / "a.zae").write_bytes(data)
    with pytest.raises(MeshError, match="is a ZIP, which cannot be unpacked"):
        load_mesh(tmp_path / "a.zae")


def test_what_trimesh_finds_out_late_is_told_too(tmp_path):
    """It asserts when its colours are asked for, long after it has read the file."""
    path = tmp_path / "a.xaml"
    path.write_text(
        '<Viewport3D xmlns="http://schemas.microsoft.com/winfx/2006/xaml/presentation">'
        "<ModelVisual3D><ModelVisual3D.Content><GeometryModel3D><GeometryModel3D.Geometry>"
        '<MeshGeometry3D Positions="0,0,0 9,0,0 9,9,nan 0,9,4" '
        'Normals="0,0,1 0,0,1 0,0,1 0,0,1" TriangleIndices="0,1,2,0,2,3"/>'
        "</GeometryModel3D.Geometry></GeometryModel3D></ModelVisual3D.Content></ModelVisual3D>"
        "</Viewport3D>"
    )
    with pytest.raises(MeshError, match="XAML is read by trimesh, which says: AssertionError"):
        load_mesh(path, texture=True)


def test_entities_are_refused(tmp_path):
    bomb = '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]>' + XAML
    (tmp_path / "a.xaml").write_text(bomb)
    with pytest.raises(MeshError, match=r"document type|entities"):
        load_mesh(tmp_path / "a.xaml")
    pytest.importorskip("collada")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as package:
        package.writestr("a.dae", bomb)
    (tmp_path / "a.zae").write_bytes(packed.getvalue())
    with pytest.raises(MeshError, match=r"document type|entities"):
        load_mesh(tmp_path / "a.zae")


def test_the_suffixes_are_known_everywhere():
    assert tuple(FOREIGN) == FOREIGN_SUFFIXES
    assert set(FOREIGN_SUFFIXES) <= set(MESH_SUFFIXES)


def packed_by_draco(**changes) -> bytes:
    """A coloured, turned ball and a box, as somebody else packs them."""
    pytest.importorskip("DracoPy")
    ball = trimesh.creation.icosphere(3, radius=0.02)
    ball.visual.vertex_colors = np.tile([200, 30, 40, 255], (len(ball.vertices), 1))
    scene = trimesh.Scene({"ball": ball, "box": trimesh.creation.box((0.01, 0.02, 0.03))})
    return trimesh.exchange.gltf.export_glb(scene, extension_draco=True, **changes)


def test_primitives_packed_by_draco_are_unpacked(tmp_path) -> None:
    file, plain = tmp_path / "packed.glb", tmp_path / "plain.glb"
    file.write_bytes(packed_by_draco())
    assert b"KHR_draco_mesh_compression" in file.read_bytes()
    ball = trimesh.creation.icosphere(3, radius=0.02)
    scene = trimesh.Scene({"ball": ball, "box": trimesh.creation.box((0.01, 0.02, 0.03))})
    plain.write_bytes(trimesh.exchange.gltf.export_glb(scene))
    packed, wanted = load_mesh(file), load_mesh(plain)
    assert packed.n_faces == wanted.n_faces
    areas = [trimesh.Trimesh(m.vertices, m.faces).area for m in (packed, wanted)]
    assert areas[0] == pytest.approx(areas[1], rel=1e-3)
    np.testing.assert_allclose(packed.vertices.min(0), wanted.vertices.min(0), atol=0.01)
    np.testing.assert_allclose(packed.vertices.max(0), wanted.vertices.max(0), atol=0.01)
    assert packed.colours is not None


@given(place=st.floats(0.0, 1.0), byte=st.integers(0, 255), cut=st.floats(0.5, 1.0))
@settings(deadline=None, max_examples=40)
def test_damaged_draco_is_told_or_read(place, byte, cut) -> None:
    data = bytearray(packed_by_draco())
    data[int(place * (len(data) - 1))] = byte
    with contextlib.suppress(MeshError):
        read_gltf(bytes(data[: max(20, int(cut * len(data)))]), Path())


def test_without_dracopy_it_is_named(monkeypatch) -> None:
    data = packed_by_draco()
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(MeshError, match="needs DracoPy: pip install"):
        read_gltf(data, Path())


def packed_by_meshopt(**changes) -> bytes:
    """A ball whose positions and triangles are packed; `changes` are of the positions' view."""
    packer = pytest.importorskip("meshoptimizer")
    ball = trimesh.creation.icosphere(2)
    places, indices = ball.vertices.astype("<f4"), ball.faces.astype("<u4").ravel()
    n, m = len(places), len(indices)
    packed = [packer.encode_vertex_buffer(places, n, 12), packer.encode_index_buffer(indices, m, n)]
    sizes = [len(data) for data in packed]
    how = [
        {"buffer": 0, "byteOffset": 0, "byteLength": sizes[0], "byteStride": 12, "count": n,
         "mode": "ATTRIBUTES", **changes},
        {"buffer": 0, "byteOffset": sizes[0], "byteLength": sizes[1], "byteStride": 4, "count": m,
         "mode": "TRIANGLES"},
    ]  # fmt: skip
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["EXT_meshopt_compression"],
        "buffers": [
            {"byteLength": sum(sizes),
             "uri": "data:;base64," + base64.b64encode(b"".join(packed)).decode()},
            {"byteLength": 12 * n + 4 * m},
        ],
        "bufferViews": [
            {"buffer": 1, "byteLength": 12 * n, "extensions": {"EXT_meshopt_compression": how[0]}},
            {"buffer": 1, "byteOffset": 12 * n, "byteLength": 4 * m,
             "extensions": {"EXT_meshopt_compression": how[1]}},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": n},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": m},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }  # fmt: skip
    return json.dumps(document).encode()


def test_views_packed_by_meshopt_are_unpacked() -> None:
    ball, read = trimesh.creation.icosphere(2), read_gltf(packed_by_meshopt(), Path())
    np.testing.assert_array_equal(read.vertices, ball.vertices.astype("<f4"))
    triangles = read.corners.reshape(-1, 3)
    got = trimesh.Trimesh(read.vertices, triangles, process=False)
    assert got.volume == pytest.approx(ball.volume, rel=1e-6)


def test_filters_and_sequences_of_meshopt_are_undone() -> None:
    """Exponential: eight bits of exponent over 24 of mantissa (EXT_meshopt_compression)."""
    packer = pytest.importorskip("meshoptimizer")
    mantissas = np.array([[3, -5, 7], [0, 1, -1]], np.int32)
    words = (np.int32(-4) << 24) | (mantissas & 0xFFFFFF)
    data = packer.encode_vertex_buffer(words.view("<f4"), 2, 12)
    how = {"count": 2, "byteStride": 12, "mode": "ATTRIBUTES", "filter": "EXPONENTIAL"}
    got = np.frombuffer(unpack_meshopt(data, how), "<f4").reshape(2, 3)
    np.testing.assert_array_equal(got, mantissas / 16.0)
    order = np.array([4, 0, 4, 1, 2, 7], np.uint32)
    data = packer.encode_index_sequence(order, len(order), 8)
    how = {"count": len(order), "byteStride": 2, "mode": "INDICES"}
    np.testing.assert_array_equal(np.frombuffer(unpack_meshopt(data, how), "<u2"), order)


def test_numbers_that_are_not_those_of_the_accessor_are_told() -> None:
    data = packed_by_draco()
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + length])
    primitive = document["meshes"][0]["primitives"][0]
    document["accessors"][primitive["attributes"]["POSITION"]]["count"] += 1
    with pytest.raises(MeshError, match=r"its Draco data has .* where the accessor says"):
        read_gltf(with_document(data, document), Path())
    document = json.loads(data[20 : 20 + length])
    primitive = document["meshes"][0]["primitives"][0]
    primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 99
    with pytest.raises(MeshError, match="has no attribute 99 for POSITION"):
        read_gltf(with_document(data, document), Path())


def with_document(data: bytes, document: dict) -> bytes:
    """The same binary file with another document."""
    length = int.from_bytes(data[12:16], "little")
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    return head + text + rest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mode": "LINES"}, "meshopt mode is 'LINES'"),
        ({"filter": "SHARPEN"}, "meshopt filter is 'SHARPEN'"),
        ({"count": 10**12}, "cannot be unpacked"),
        ({"count": 7.5}, "expected numbers"),
        ({"byteLength": 10**6}, "does not fit into its buffer"),
        ({"byteLength": 40}, "cannot be unpacked"),
    ],
)
def test_bad_meshopt_is_told(changes, message) -> None:
    with pytest.raises(MeshError, match=message):
        read_gltf(packed_by_meshopt(**changes), Path())


def test_without_meshoptimizer_it_is_named(monkeypatch) -> None:
    data = packed_by_meshopt()
    monkeypatch.setitem(sys.modules, "meshoptimizer", None)
    with pytest.raises(MeshError, match="needs meshoptimizer: pip install"):
        read_gltf(data, Path())

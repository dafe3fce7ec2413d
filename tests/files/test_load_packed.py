"""COLLADA, lists of points, and glTF that is packed by Draco and meshopt."""

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
from paint3d.files.formats.collada import read_collada
from paint3d.files.formats.gltf import read_gltf, unpack_meshopt
from paint3d.files.load import load_mesh, read_mesh
from paint3d.files.points import surface_through
from paint3d.files.reading import read_surface

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


def test_points_become_a_surface(tmp_path):
    pytest.importorskip("open3d", exc_type=ImportError)
    ball = trimesh.creation.icosphere(3, 20.0).vertices
    np.savetxt(tmp_path / "a.xyz", ball, fmt="%.5f")
    reading = read_mesh(tmp_path / "a.xyz")
    assert "point cloud" in reading.notes[0]
    assert reading.mesh.n_vertices == len(ball)


def test_points_have_colours_and_commas(tmp_path):
    ball = trimesh.creation.icosphere(3, 20.0).vertices
    pytest.importorskip("open3d", exc_type=ImportError)
    red = np.tile([200, 30, 40], (len(ball), 1))
    np.savetxt(tmp_path / "a.xyz", np.hstack([ball, red]), fmt="%.5f", delimiter=", ")
    assert read_surface(tmp_path / "a.xyz").mesh.colours.tolist() == red.tolist()
    (tmp_path / "b.xyz").write_text("0 0 0\n1 1\n")
    with pytest.raises(MeshError, match="point 1 is '1 1'; expected 3 numbers, as in the first"):
        load_mesh(tmp_path / "b.xyz")


def test_without_open3d_points_are_refused_and_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(MeshError, match=r"point cloud.*pip install 'paint3d\[open3d\]'"):
        surface_through(np.eye(3).repeat(20, axis=0))


def test_what_is_missing_is_named_with_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "collada", None)
    with pytest.raises(MeshError, match=r"needs collada.*pip install 'paint3d\[meshes\]'"):
        read_collada(b"<a/>", tmp_path)


@pytest.mark.parametrize("suffix", [".dae", ".zae", ".xyz"])
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


def test_entities_are_refused(tmp_path):
    pytest.importorskip("collada")
    bomb = '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><a>&b;</a>'
    (tmp_path / "a.dae").write_text(bomb)
    with pytest.raises(MeshError, match=r"document type|entities"):
        load_mesh(tmp_path / "a.dae")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as package:
        package.writestr("a.dae", bomb)
    (tmp_path / "a.zae").write_bytes(packed.getvalue())
    with pytest.raises(MeshError, match=r"document type|entities"):
        load_mesh(tmp_path / "a.zae")


@pytest.mark.parametrize("suffix", [".xaml", ".ctm", ".dxf", ".svg"])
def test_what_is_no_longer_asked_for_is_told_from_what_is_unknown(tmp_path, suffix):
    (tmp_path / f"a{suffix}").write_text("<a/>")
    with pytest.raises(MeshError, match=r"(is not read \(Blender|is a flat drawing).*expected one"):
        load_mesh(tmp_path / f"a{suffix}")


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
    with pytest.raises(MeshError, match=r"needs DracoPy.*pip install"):
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
    codes = np.array([[0, 0, 127, 5], [60, -40, 127, 0], [-100, 80, 127, -1]], np.int8)
    data = packer.encode_vertex_buffer(codes.view("<f4"), 3, 4)
    how = {"count": 3, "byteStride": 4, "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL"}
    got = np.frombuffer(unpack_meshopt(data, how), np.int8).reshape(3, 4)
    np.testing.assert_array_equal(got[:, 3], codes[:, 3])
    x, y = codes[:, 0] / 127.0, codes[:, 1] / 127.0
    z = 1.0 - np.abs(x) - np.abs(y)
    below = np.minimum(z, 0.0)
    wanted = np.stack([x + np.sign(x) * below, y + np.sign(y) * below, z], axis=1)
    wanted *= 127.0 / np.linalg.norm(wanted, axis=1)[:, None]
    np.testing.assert_array_equal(got[:, :3], np.rint(wanted))
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
    with pytest.raises(MeshError, match=r"needs meshoptimizer.*pip install"):
        read_gltf(data, Path())

"""Exported files: read back by other people's programs, written in one step, refused by name."""

import json
import os
import re
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
import pyvista
import trimesh
from PIL import Image

from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, MeshError
from paint3d.files.export import EXPORT_SUFFIXES, check_export_path, export
from paint3d.files.export_options import ExportOptions
from paint3d.files.formats import gltf
from paint3d.files.load import load_mesh
from paint3d.mesh.sheet_mesh import make_sheet
from paint3d.mesh.sheets import parse_sheet
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.full_disk import full_disk


class Painted:
    """A painted sphere: what export needs of a surface."""

    material = SimpleNamespace(name="porcelain")

    def __init__(self):
        ball = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
        self.vertices = np.float32(ball.vertices) + np.float32([10, 20, 30])
        self.faces = np.int32(ball.faces)
        self.normals = np.float32(ball.vertices / 60.0)
        codes = np.arange(self.vertices.size) * 7 % 256  # every code occurs
        self.srgb = codes.astype(np.uint8).reshape(-1, 3)
        self.vertex_areas = np.ones(len(self.vertices))

    def export_arrays(self, tolerance=1.0, srgb=None):
        return self.vertices, self.faces, self.normals, self.srgb if srgb is None else srgb


@pytest.fixture
def painted():
    return Painted()


@pytest.mark.parametrize("suffix", ["ply", "obj"])
def test_trimesh_reads_the_same_mesh_and_colours(painted, tmp_path, suffix):
    export(painted, tmp_path / f"a.{suffix}")
    other = trimesh.load(tmp_path / f"a.{suffix}", process=False)
    np.testing.assert_allclose(other.vertices, painted.vertices, atol=1e-5)
    np.testing.assert_array_equal(other.faces, painted.faces)
    np.testing.assert_array_equal(other.visual.vertex_colors[:, :3], painted.srgb)


def test_a_texture_asked_of_what_says_no_detail_is_refused(painted, tmp_path):
    with pytest.raises(
        ExportError, match="laid on a PaintedSurface or TriangleMesh; got a Painted"
    ):
        export(painted, tmp_path / "a.glb", ExportOptions(texture=64))
    assert list(tmp_path.iterdir()) == []


def test_trimesh_reads_glb_in_metres_with_y_up(painted, tmp_path):
    export(painted, tmp_path / "a.glb")
    other = trimesh.load(tmp_path / "a.glb", process=False, force="mesh")
    x, y, z = painted.vertices.T / 1000.0
    np.testing.assert_allclose(other.vertices, np.stack([x, z, -y], axis=1), atol=1e-7)
    np.testing.assert_array_equal(other.faces, painted.faces)
    assert other.visual.material.metallicFactor == 0
    assert other.volume > 0


def test_trimesh_reads_3mf(painted, tmp_path):
    painted.faces = np.r_[painted.faces, [[5, 5, 6]]]  # 3MF forbids it: left out
    export(painted, tmp_path / "a.3mf")
    other = trimesh.load(tmp_path / "a.3mf", process=False, force="mesh")
    np.testing.assert_allclose(other.vertices, painted.vertices, atol=1e-6)
    np.testing.assert_array_equal(other.faces, painted.faces[:-1])


@pytest.mark.parametrize("filaments", [None, ["#ffffff", "#000000"]])
def test_a_3mf_s_object_is_called_as_its_file(painted, tmp_path, filaments):
    export(painted, tmp_path / "mug & saucer.3mf", ExportOptions(filaments=filaments))
    with zipfile.ZipFile(tmp_path / "mug & saucer.3mf") as archive:
        model = archive.read("3D/3dmodel.model").decode()
    names = set(re.findall(r'<object id="\d+" name="([^"]*)"', model))
    assert names == {"mug &amp; saucer"}


@pytest.mark.parametrize("suffix", ["ply", "obj", "glb", "3mf"])
def test_our_own_reader_gets_back_what_was_written(painted, tmp_path, suffix):
    export(painted, tmp_path / f"a.{suffix}")
    mesh = load_mesh(tmp_path / f"a.{suffix}")
    np.testing.assert_allclose(mesh.vertices, painted.vertices, atol=2e-5)
    np.testing.assert_array_equal(mesh.faces, painted.faces)
    np.testing.assert_array_equal(mesh.colours, painted.srgb)


def test_pyvista_reads_ply(painted, tmp_path):
    export(painted, tmp_path / "a.ply")
    other = pyvista.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(other.points, painted.vertices)
    np.testing.assert_array_equal(other.regular_faces, painted.faces)
    np.testing.assert_array_equal(other.point_data["RGB"], painted.srgb)


@pytest.mark.parametrize("suffix", ["ply", "obj"])
def test_open3d_reads_the_same_mesh_and_colours(painted, tmp_path, suffix):
    open3d = pytest.importorskip("open3d", exc_type=ImportError)
    export(painted, tmp_path / f"a.{suffix}")
    other = open3d.io.read_triangle_mesh(str(tmp_path / f"a.{suffix}"))
    corners, wanted = np.asarray(other.triangles), painted.faces  # OBJ: in order of appearance
    positions, colours = np.asarray(other.vertices), np.asarray(other.vertex_colors) * 255
    np.testing.assert_allclose(positions[corners], painted.vertices[wanted], atol=1e-5)
    np.testing.assert_allclose(colours[corners], painted.srgb[wanted], atol=1e-3)


def test_glb_meets_the_specification(painted, tmp_path):
    export(painted, tmp_path / "a.glb")
    data = (tmp_path / "a.glb").read_bytes()
    size = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + size])
    assert int.from_bytes(data[8:12], "little") == len(data)
    colour = document["accessors"][2]
    assert colour["componentType"] == 5123  # 16 bits: 8 would lose dark codes
    assert colour["normalized"]
    position = document["accessors"][0]
    assert position["max"][1] == pytest.approx(painted.vertices[:, 2].max() / 1000)
    for accessor, view in zip(document["accessors"], document["bufferViews"], strict=True):
        width = {"VEC3": 3, "VEC4": 4, "SCALAR": 1}[accessor["type"]]
        bits = {5126: 4, 5123: 2, 5125: 4}[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == width * bits * accessor["count"]


def test_the_same_painting_gives_the_same_bytes(painted, tmp_path):
    (tmp_path / "again").mkdir()
    for suffix in (".ply", ".glb", ".obj", ".3mf", ".usdz", ".p3d.txt"):
        file, again = tmp_path / f"bowl{suffix}", tmp_path / "again" / f"bowl{suffix}"
        export(painted, file)
        export(painted, again)  # of the same name: a 3MF calls its object so
        assert file.read_bytes() == again.read_bytes()


def test_unknown_suffix_and_folder(painted, tmp_path):
    with pytest.raises(
        ExportError, match=r"'\.fbx' is not known; expected one of \.ply \.glb \.obj"
    ):
        export(painted, tmp_path / "a.fbx")
    with pytest.raises(ExportError, match="it has no suffix"):
        export(painted, tmp_path / "a")
    with pytest.raises(ExportError, match=r"the folder .* does not exist"):
        check_export_path(tmp_path / "nowhere" / "a.ply")
    (tmp_path / "b.ply").mkdir()
    with pytest.raises(ExportError, match="is a folder; expected a file name"):
        export(painted, tmp_path / "b.ply")
    assert os.listdir(tmp_path) == ["b.ply"]
    known = {".ply", ".glb", ".obj", ".3mf", ".usdz", ".html", ".p3d.txt", ".png", ".p3d"}
    assert set(EXPORT_SUFFIXES) == known


def test_bad_arrays_leave_the_old_file_alone(painted, tmp_path):
    path = tmp_path / "a.ply"
    path.write_text("old")
    painted.srgb = painted.srgb / 255.0
    with pytest.raises(MeshError, match="srgb is float64"):
        export(painted, path)
    painted.normals = painted.normals[:-1]
    with pytest.raises(MeshError, match="normals has shape"):
        export(painted, path)
    assert path.read_text() == "old"


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((3, 3)), np.zeros((0, 3)), "there are no faces"),
        (np.zeros((3, 3)), [[0, 1, 3]], "refers to vertex 3; expected 0 to 2"),
        (np.zeros((3, 3)), [[0, 1, -1]], "refers to vertex -1; expected 0 to 2"),
        (np.full((3, 3), 1e20), [[0, 1, 2]], "a coordinate is 1e.20 mm"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], "expected a finite number"),
    ],
)
@pytest.mark.parametrize("suffix", [".ply", ".3mf", ".html"])
def test_arrays_that_make_no_object(tmp_path, suffix, vertices, faces, message):
    bad = SimpleNamespace(
        material=None,
        export_arrays=lambda tolerance: (vertices, faces, vertices * 0 + 1, np.zeros((3, 3), "u1")),
    )
    with pytest.raises(MeshError, match=message):
        export(bad, tmp_path / f"a{suffix}")
    assert os.listdir(tmp_path) == []


def test_a_glb_too_large_for_its_header_is_refused(painted, tmp_path, monkeypatch):
    monkeypatch.setattr(gltf, "LARGEST", 10_000)
    with pytest.raises(ExportError, match="holds 4 GiB at most"):
        export(painted, tmp_path / "a.glb")
    assert os.listdir(tmp_path) == []


def test_a_failed_write_leaves_nothing_behind(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail(error):
        with write_atomically(path) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(ExportError, match=r"a\.txt: cannot write: disk full"):
        fail(OSError(28, "disk full"))
    with pytest.raises(KeyboardInterrupt):
        fail(KeyboardInterrupt())
    assert os.listdir(tmp_path) == ["a.txt"]
    assert path.read_text() == "old"


def test_a_finished_write_replaces_the_file_and_keeps_its_suffix(tmp_path):
    path = tmp_path / "a.p3d.txt"
    path.write_text("old")
    with write_atomically(path) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.name.endswith(".p3d.txt")
        temporary.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert path.stat().st_mode & 0o044 == 0o044 & ~current_umask()


def current_umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_a_missing_or_locked_folder_is_an_export_error(tmp_path):
    with pytest.raises(ExportError, match="cannot write here"), write_atomically(tmp_path / "b/c"):
        pass
    locked = tmp_path / "locked"
    locked.mkdir()
    locked.chmod(0o500)
    if os.access(locked, os.W_OK):
        pytest.skip("this user may write anywhere")
    with pytest.raises(ExportError, match="Permission denied"), write_atomically(locked / "a"):
        pass


def test_a_picture_is_asked_of_the_view(painted, tmp_path, monkeypatch):
    from paint3d.view import shot

    asked = []

    def draw(vertices, faces, normals, srgb, *, gloss=None, **_):
        asked.append((len(vertices), len(faces), gloss))
        return np.full((12, 16, 3), 77, np.uint8)

    monkeypatch.setattr(shot, "draw_picture", draw)
    export(painted, tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert (image.size, image.getpixel((3, 3))) == ((16, 12), (77, 77, 77))
    assert asked[0][:2] == (642, 1280)
    assert 0.0 < asked[0][2].roughness < 1.0


def test_a_picture_of_a_sheet_is_flat_and_of_its_shape(tmp_path, monkeypatch):
    """A scroll stood as a narrow stripe in a picture of 1600 x 1200."""
    from paint3d.view import shot

    asked = []

    def draw(vertices, faces, srgb, frame, size, *_):
        asked.append(size)
        return np.full((*size[::-1], 3), 77, np.uint8)

    monkeypatch.setattr(shot, "draw_flat", draw)
    sheet = PaintedSurface(make_sheet(parse_sheet("sheet:60x240")), 10.0, "xuan")
    export(sheet, tmp_path / "a.png")
    assert asked == [(800, 3200)]


@pytest.mark.parametrize("suffix", EXPORT_SUFFIXES)
def test_a_full_disk_is_told_of_the_file_that_was_asked_for(tmp_path, monkeypatch, suffix):
    from paint3d.view import shot

    noise = np.random.default_rng(1).integers(0, 256, (90, 90, 3)).astype(np.uint8)
    monkeypatch.setattr(shot, "draw_picture", lambda *_, **__: noise)
    surface = PaintedSurface(load_mesh("sphere"), resolution=3.0)
    path = tmp_path / f"a{suffix}"
    with full_disk(5000), pytest.raises(ExportError) as caught:
        export(surface, path)
    assert str(caught.value).startswith(f"{path}: cannot write")
    assert list(tmp_path.iterdir()) == []

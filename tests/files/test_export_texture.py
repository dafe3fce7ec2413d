"""A baked texture, sampled back as a renderer does: near, far, and where charts end."""

import io
import json
import sys

import numpy as np
import pytest
import trimesh
from PIL import Image

import paint3d
from paint3d.colour.pigments import load_pigment
from paint3d.errors import ExportError, InputError
from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.files.kernels.bake import fill_triangles
from paint3d.mesh.triangle_mesh import TriangleMesh


def read(path):
    """Return vertices (mm, z up), faces, uv and image of a textured GLB, by the specification."""
    data = path.read_bytes()
    size = int.from_bytes(data[12:16], "little")
    document, body = json.loads(data[20 : 20 + size]), data[28 + size :]

    def view(k):
        start = document["bufferViews"][k]["byteOffset"]
        return body[start : start + document["bufferViews"][k]["byteLength"]]

    x, y, z = 1000.0 * np.frombuffer(view(0), "<f4").reshape(-1, 3).T
    uv = np.frombuffer(view(2), "<f4").reshape(-1, 2)
    faces = np.frombuffer(view(3), "<u4").reshape(-1, 3)
    image = np.asarray(Image.open(io.BytesIO(view(document["images"][0]["bufferView"]))))
    return np.stack([x, -z, y], axis=1), faces, uv, image


def sample(image, uv):
    """Bilinear with clamped edges, as a graphics card samples; floats."""
    height, width, _ = image.shape
    place = np.clip(uv * (width, height) - 0.5, 0, (width - 1.0, height - 1.0))
    low = np.minimum(place.astype(int), (width - 2, height - 2))
    x, y = (place - low).T[..., None]
    i, j = low[:, 1], low[:, 0]
    upper = (1 - x) * image[i, j] + x * image[i, j + 1]
    lower = (1 - x) * image[i + 1, j] + x * image[i + 1, j + 1]
    return (1 - y) * upper + y * lower


def halved(image):
    """The next mipmap level."""
    height, width = (side // 2 * 2 for side in image.shape[:2])
    blocks = image[:height, :width].astype(float).reshape(height // 2, 2, width // 2, 2, 3)
    return blocks.mean(axis=(1, 3))


def points_on(vertices, faces, uv, n):
    """Random places on a mesh, corners and edges among them, with their texture places."""
    rng = np.random.default_rng(2)
    weights = rng.dirichlet((0.4, 0.4, 0.4), n)
    chosen = faces[rng.integers(0, len(faces), n)]
    return (np.einsum("nk,nkd->nd", weights, array[chosen]) for array in (vertices, uv))


def shade(points):
    """A smooth colour for every place; none is near black."""
    return 150.0 + 60.0 * np.sin(points / 9.0)


@pytest.fixture
def ball():
    pytest.importorskip("xatlas")
    solid = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    codes = np.rint(shade(solid.vertices)).astype(np.uint8)
    return TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces), codes)


def test_a_texture_sampled_back_shows_the_painting_from_near_and_far(ball, tmp_path):
    export(ball, tmp_path / "a.glb", ExportOptions(texture=1024))
    vertices, faces, uv, image = read(tmp_path / "a.glb")
    assert len(faces) == ball.n_faces
    assert max(image.shape) == 1024
    points, places = points_on(vertices, faces, uv, 100_000)
    wanted = shade(points)
    assert np.abs(sample(image.astype(float), places) - wanted).max() < 4
    level = halved(image)
    assert np.abs(sample(level, places) - wanted).max() < 8
    assert np.abs(sample(halved(level), places) - wanted).max() < 20


def test_every_texel_is_filled_with_a_colour_of_the_painting(ball, tmp_path):
    export(ball, tmp_path / "a.glb", ExportOptions(texture=512))
    image = read(tmp_path / "a.glb")[3]
    assert image.min() >= 89


def test_the_texture_lies_on_the_object_as_it_was_before_it_was_refined(tmp_path):
    pytest.importorskip("xatlas")
    mesh = paint3d.load_mesh("plane")
    surface = paint3d.PaintedSurface(mesh, resolution=2.0)
    surface.refine_all()
    column = surface.column_of(load_pigment("pine soot"))
    where = surface.mesh.vertices[:, :2]
    ids = np.flatnonzero(np.hypot(*(where - (20.0, -10.0)).T) < 30.0)
    field = surface.ink
    field.amounts[ids, column] = field.coverage[ids] = field.dirty[ids] = 1
    field.dirty_ids[: len(ids)] = ids
    field.n_dirty[0] = len(ids)
    export(surface, tmp_path / "a.glb", ExportOptions(texture=True))
    vertices, faces, uv, image = read(tmp_path / "a.glb")
    assert len(faces) == mesh.n_faces < len(surface.paint_mesh.leaf_faces()) / 10
    points, places = points_on(vertices, faces, uv, 20_000)
    away = np.hypot(*(points[:, :2] - (20.0, -10.0)).T)
    seen = sample(image.astype(float), places)
    assert seen[away < 27].max() < 90
    assert seen[away > 33].min() > 200


def test_the_glb_is_sound(ball, tmp_path):
    export(ball, tmp_path / "a.glb", ExportOptions(texture=256, unlit=True))
    other = trimesh.load(tmp_path / "a.glb", process=False, force="mesh")
    assert other.visual.material.baseColorTexture.size == read(tmp_path / "a.glb")[3].shape[1::-1]
    assert other.is_winding_consistent
    export(ball, tmp_path / "b.glb", ExportOptions(texture=256, unlit=True))
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_triangles_fill_the_texels_whose_middle_they_cover():
    corners = np.array([(0.0, 0.0), (4.0, 0.0), (0.0, 4.0), (9.0, 9.0)])
    colours = np.uint8([(0, 0, 0), (200, 0, 0), (0, 200, 0), (1, 1, 1)])
    for faces in ([(0, 1, 2)], [(0, 2, 1)]):
        image, filled = np.zeros((5, 5, 3), np.uint8), np.zeros((5, 5), np.uint8)
        fill_triangles(corners, np.array([*faces, (3, 3, 3)], np.int32), colours, image, filled)
        i, j = np.mgrid[:5, :5]
        np.testing.assert_array_equal(filled, i + j < 4)
        np.testing.assert_array_equal(image[0, :, 0], [25, 75, 125, 175, 0])
        np.testing.assert_array_equal(image[:, 1, 1], [25, 75, 125, 0, 0])


def test_a_texture_outside_of_its_square_is_cut_off():
    corners = np.array([(-5.0, -5.0), (20.0, -5.0), (-5.0, 20.0)])
    image, filled = np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.uint8)
    faces, colours = np.int32([(0, 1, 2)]), np.full((3, 3), 255, np.uint8)
    fill_triangles(corners, faces, colours, image, filled)
    assert filled.all()
    assert (image == 255).all()


def test_what_cannot_be(tmp_path, monkeypatch):
    ball = trimesh.creation.icosphere(subdivisions=1)
    mesh = TriangleMesh(np.float32(ball.vertices), np.int32(ball.faces))
    with pytest.raises(
        ExportError, match=r"\.ply files cannot have texture; expected one of \.glb"
    ):
        export(mesh, tmp_path / "a.ply", ExportOptions(texture=True))
    with pytest.raises(InputError, match="expected 16 to 16384"):
        export(mesh, tmp_path / "a.glb", ExportOptions(texture=5))
    with pytest.raises(InputError, match="exclude each other"):
        export(mesh, tmp_path / "a.glb", ExportOptions(texture=True, filaments=2))
    monkeypatch.setitem(sys.modules, "xatlas", None)
    with pytest.raises(ExportError, match="needs xatlas"):
        export(mesh, tmp_path / "a.glb", ExportOptions(texture=True))
    assert list(tmp_path.iterdir()) == []

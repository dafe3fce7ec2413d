"""Own objects keep their picture: materials and textures at load, and what is dropped is said."""

from __future__ import annotations

import base64
import io
import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.files.colours import Look, linear_from_srgb, sample_picture
from paint3d.files.detail import MOST_VERTICES, Draped, show_pictures
from paint3d.files.export import export
from paint3d.files.load import load_mesh
from paint3d.files.reading import Wanted, read_surface
from paint3d.surface.painted_surface import PaintedSurface

CORPUS = Path(__file__).parents[2] / "../shared/corpus"
SQUARE = np.array([[0, 0, 0], [80, 0, 0], [80, 80, 0], [0, 80, 0]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])
PLACES = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], float)


def disc(n: int = 128) -> np.ndarray:
    """A red disc on white, (n, n, 3)."""
    y, x = np.mgrid[:n, :n] / (n - 1) - 0.5
    return np.where((x * x + y * y < 0.1)[..., None], [200, 30, 20], [250, 250, 245]).astype("u1")


def shown(picture: np.ndarray, **others: object):
    looks = (Look(picture=picture),)
    return show_pictures(SQUARE, FACES, Draped(PLACES[FACES], np.zeros(2, int), looks), **others)


def seen_at(mesh, places: np.ndarray) -> np.ndarray:
    """sRGB codes (N, 3) that a viewer interpolates at places of the square."""
    corners = mesh.vertices[mesh.faces][:, :, :2]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    edges = np.stack([b - a, c - a], axis=2)
    codes = np.empty((len(places), 3))
    for k, place in enumerate(places):
        inner = np.linalg.solve(edges, (place - a)[..., None])[..., 0]
        weights = np.column_stack([1 - inner.sum(axis=1), inner])
        face = int(weights.min(axis=1).argmax())
        codes[k] = weights[face] @ mesh.colours[mesh.faces[face]]
    return codes


def test_a_coarse_mesh_is_refined_until_its_picture_shows() -> None:
    mesh = shown(disc())
    assert len(mesh.vertices) < 20_000  # along the disc's rim, not where it is one colour
    np.testing.assert_array_equal(mesh.vertices[:4], SQUARE)
    rng = np.random.default_rng(3)
    places = rng.uniform(1, 79, (300, 2))
    wanted = sample_picture(disc(), np.column_stack([places[:, 0], 80 - places[:, 1]]) / 80)
    seen = linear_from_srgb(np.rint(seen_at(mesh, places)).astype("u1"))
    assert np.mean(np.abs(seen - wanted).max(axis=1) < 0.1) > 0.97
    corners = mesh.vertices[mesh.faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(6400.0)


def test_opposite_borders_of_a_picture_do_not_run_into_each_other() -> None:
    rows = np.linspace(0, 250, 64).astype("u1")
    mesh = shown(np.broadcast_to(rows[:, None, None], (64, 64, 3)))
    places = np.random.default_rng(5).uniform(2, 78, (200, 2))
    wanted = np.interp(80 - places[:, 1], 80 * (np.arange(64) + 0.5) / 64, rows)
    assert np.abs(seen_at(mesh, places)[:, 0] - wanted).max() < 12


def test_halved_triangles_leave_no_cracks() -> None:
    mesh = shown(disc(64))
    _, ids = np.unique(mesh.vertices, axis=0, return_inverse=True)
    ends = np.sort(
        np.stack([ids[mesh.faces], np.roll(ids[mesh.faces], -1, axis=1)], axis=2).reshape(-1, 2)
    )
    edges, count = np.unique(ends, axis=0, return_counts=True)
    points = np.unique(mesh.vertices, axis=0)[edges]
    rim = (np.isin(points, (0.0, 80.0)) & (points[:, :1] == points[:, 1:])).any(axis=(1, 2))
    outer = ((points[:, 0] == points[:, 1]) & np.isin(points[:, 0], (0.0, 80.0)))[:, :2].any(axis=1)
    assert rim.any()
    np.testing.assert_array_equal(count, np.where(outer, 1, 2))


def test_noise_stops_at_the_most_vertices_and_becomes_its_mean() -> None:
    rng = np.random.default_rng(1)
    picture = rng.choice(np.array([0, 255], "u1"), (512, 512, 1)).repeat(3, axis=2)
    mesh = shown(picture, most=2000)
    assert 1000 < len(mesh.vertices) < 2600 < MOST_VERTICES
    light = linear_from_srgb(mesh.colours)[:, 0]
    assert abs(light.mean() - 0.5) < 0.05
    assert light.std() < 0.15


def test_a_round_mesh_stays_round_where_it_is_refined() -> None:
    turn = np.linspace(0, 2 * np.pi, 17)[:-1]
    ring = np.column_stack([40 * np.cos(turn), 40 * np.sin(turn)])
    vertices = np.concatenate([np.column_stack([ring, np.full(16, z)]) for z in (0.0, 60.0)])
    k = np.arange(16)
    after = (k + 1) % 16
    faces = np.concatenate(
        [np.column_stack([k, after, after + 16]), np.column_stack([k, after + 16, k + 16])]
    )
    u, v = k / 16, np.ones(16)
    place = np.stack(
        [
            np.concatenate([np.column_stack([u, u + 1 / 16, u + 1 / 16]),
                            np.column_stack([u, u + 1 / 16, u])]),
            np.concatenate([np.column_stack([v, v, 0 * v]), np.column_stack([v, 0 * v, 0 * v])]),
        ],
        axis=2,
    )  # fmt: skip
    mesh = show_pictures(vertices, faces, Draped(place, np.zeros(32, int), (Look(picture=disc()),)))
    outward = mesh.vertices[:, :2] / np.linalg.norm(mesh.vertices[:, :2], axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", mesh.normals[:, :2], outward).min() > 0.995


def test_the_picture_lies_under_the_paint(tmp_path: Path) -> None:
    surface = PaintedSurface(load_mesh(written_square(tmp_path), texture=True), 2.0)
    vertices = surface.paint_mesh.vertices
    middle = np.linalg.norm(vertices[:, :2] * [1, 1] - 40.0, axis=1) < 15.0
    np.testing.assert_array_equal(surface.srgb[middle][:5], [[200, 30, 20]] * 5)
    red = surface.bare_spectra(np.flatnonzero(middle)[:1].astype(np.int32))[0]
    assert red[-1] > 4 * red[10]  # long waves come back, short ones do not


def written_square(folder: Path) -> Path:
    Image.fromarray(disc()).save(folder / "disc.png")
    (folder / "a.mtl").write_text("newmtl m\nmap_Kd disc.png\nmap_bump b.png\nd 0.5\n")
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE)
    places = "".join(f"vt {u} {1 - v}\n" for u, v in PLACES)
    path = folder / "a.obj"
    path.write_text(f"mtllib a.mtl\n{corners}{places}usemtl m\nf 1/1 2/2 3/3 4/4\n")
    return path


def test_what_an_obj_says_besides_is_told(tmp_path: Path) -> None:
    path = written_square(tmp_path)
    (note,) = read_surface(path, Wanted(texture=True)).notes
    assert note == "left out: relief (a bump map), transparency"
    (note,) = read_surface(path).notes
    assert note == "left out: its colours and pictures"


def test_colours_end_where_materials_end(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n")
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE)
    path = tmp_path / "a.obj"
    path.write_text(f"mtllib a.mtl\n{corners}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n")
    mesh = load_mesh(path, texture=True)
    assert mesh.n_vertices == 6
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], [[255, 0, 0]] * 3)
    np.testing.assert_array_equal(mesh.colours[mesh.faces[1]], [[0, 0, 255]] * 3)


def gltf(**changes: object) -> dict:
    """A textured square of 1 m as a glTF document."""
    file = io.BytesIO()
    Image.fromarray(disc(32)).save(file, "PNG")
    parts = SQUARE.astype("<f4") / 80, PLACES.astype("<f4"), FACES.astype("<u2")
    blob = b"".join(part.tobytes() for part in parts)
    at = np.cumsum([0, *(part.nbytes for part in parts)]).tolist()
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "buffers": [{"byteLength": len(blob), "uri": _inline(blob)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": at[k], "byteLength": parts[k].nbytes} for k in range(3)
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "images": [{"uri": _inline(file.getvalue())}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2,
                             "material": 0}]}
        ],
    }  # fmt: skip
    return document | changes


def _inline(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def read(folder: Path, document: dict):
    path = folder / "a.gltf"
    path.write_text(json.dumps(document))
    return read_surface(path, Wanted(texture=True))


def test_what_a_gltf_says_besides_is_told(tmp_path: Path) -> None:
    surface = {
        "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}},
        "normalTexture": {"index": 0},
        "alphaMode": "BLEND",
    }
    reading = read(tmp_path, gltf(materials=[surface], animations=[{}], skins=[{}]))
    (note,) = reading.notes
    assert note == (
        "left out: animations, metal and gloss from a picture, relief (a normal map), skins, "
        "transparency"
    )
    assert read(tmp_path, gltf()).notes == ()


def test_what_has_no_surface_in_a_gltf_is_told(tmp_path: Path) -> None:
    document = gltf(
        cameras=[{"type": "perspective"}],
        extensions={"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
    )
    document["materials"][0]["emissiveFactor"] = [0.0, 0.2, 0.0]
    document["meshes"][0]["primitives"] += [
        {"attributes": {"POSITION": 0}, "mode": mode} for mode in (0, 3)
    ]
    reading = read(tmp_path, document)
    assert reading.notes == ("left out: cameras, light of its own, lights, lines, points",)
    assert reading.mesh.n_faces >= 2
    document["materials"][0]["emissiveFactor"] = [0.0, 0.0, 0.0]
    assert "light of its own" not in read(tmp_path, document).notes[0]


@pytest.mark.parametrize("texture", [False, True])
def test_lines_and_points_of_an_obj_are_told(tmp_path: Path, texture: bool) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\np 3\n")
    assert read_surface(path, Wanted(texture=texture)).notes == ("left out: lines, points",)


def test_edges_of_a_ply_are_told(tmp_path: Path) -> None:
    text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    text += "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
    text += "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    (tmp_path / "a.ply").write_text(text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0 1\n")
    assert read_surface(tmp_path / "a.ply").notes == ("left out: lines",)


def test_pictures_that_are_not_read_are_told(tmp_path: Path) -> None:
    text = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\n"
    text += "property float x\nproperty float y\nproperty float z\nelement face 1\n"
    text += "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    (tmp_path / "a.ply").write_text(text)
    assert read_surface(tmp_path / "a.ply").notes == ("left out: its pictures",)
    export(load_mesh("plane"), tmp_path / "a.3mf")
    assert read_surface(tmp_path / "a.3mf").notes == ()
    with zipfile.ZipFile(tmp_path / "a.3mf") as plain:
        parts = {name: plain.read(name) for name in plain.namelist()}
    name = next(name for name in parts if name.endswith(".model"))
    space = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
    group = f'<m:texture2dgroup xmlns:m="{space}" id="77" texid="78"/></resources>'
    parts[name] = parts[name].replace(b"</resources>", group.encode())
    with zipfile.ZipFile(tmp_path / "b.3mf", "w") as pictured:
        for name, data in parts.items():
            pictured.writestr(name, data)
    assert read_surface(tmp_path / "b.3mf").notes == ("left out: its pictures",)


def test_a_texture_is_placed_as_its_transform_says(tmp_path: Path) -> None:
    document = gltf()
    texture = document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    texture["extensions"] = {"KHR_texture_transform": {"offset": [0.5, 0.5]}}
    mesh = read(tmp_path, document).mesh
    # the disc's middle is now in the four corners
    np.testing.assert_array_equal(mesh.colours[:4], [[200, 30, 20]] * 4)
    document["samplers"] = [{"wrapS": 33071, "wrapT": 33071}]
    document["textures"] = [{"source": 0, "sampler": 0}]
    mesh = read(tmp_path, document).mesh
    reds = [tuple(c) == (200, 30, 20) for c in mesh.colours[:4].tolist()]
    assert sorted(reds) == [False, False, False, True]  # beyond its border there is no other disc


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus is not here")
@pytest.mark.parametrize(
    "name", ["trimesh/BoxTextured.glb", pytest.param("assimp/spider.obj", marks=pytest.mark.long)]
)
def test_textured_files_of_others_show_their_pictures(name: str) -> None:
    mesh = load_mesh(CORPUS / name, texture=True)
    assert 10_000 < mesh.n_vertices < 1.1 * MOST_VERTICES
    assert len(np.unique(mesh.colours, axis=0)) > 100
    assert re.match("BoxTextured|spider", mesh.name)

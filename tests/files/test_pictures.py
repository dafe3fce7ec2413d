"""Own objects keep their picture: materials and textures at load, and what is dropped is said."""

from __future__ import annotations

import base64
import io
import json
import re
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.errors import MeshError
from paint3d.files.colours import Look, linear_from_srgb, sample_picture
from paint3d.files.detail import MOST_VERTICES, Draped, show_pictures
from paint3d.files.export import export
from paint3d.files.load import load_mesh
from paint3d.files.reading import ReadOptions, read_surface
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
    (note,) = read_surface(path, ReadOptions(texture=True)).notes
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
    return read_surface(path, ReadOptions(texture=True))


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
    assert read_surface(path, ReadOptions(texture=texture)).notes == ("left out: lines, points",)


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


# -- pictures and colours beside a mesh --------------------------------------------------------


CODES = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [40, 80, 120]], np.uint8)
UV = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]]  # the middles, from the upper left
FLAT = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
TWO_FACES = [(0, 1, 2), (2, 1, 3)]


def picture(codes=CODES):
    """Four pixels of different colour, as PNG."""
    file = io.BytesIO()
    Image.fromarray(codes.reshape(2, 2, 3)).save(file, "PNG")
    return file.getvalue()


def with_pictures(path):
    return read_surface(path, ReadOptions(texture=True))


# -- PLY --------------------------------------------------------------------------------------

POSITION = "property float x\nproperty float y\nproperty float z\n"
LIST = "property list uchar int vertex_indices\n"


def ply(folder, vertex="", face="", rows=(), faces=(), comments=("TextureFile a b.png",)):
    """A square in ASCII with these columns and values besides."""
    text = "ply\nformat ascii 1.0\n" + "".join(f"comment {c}\n" for c in comments)
    text += f"element vertex 4\n{POSITION}{vertex}element face 2\n{LIST}{face}end_header\n"
    for k, place in enumerate(FLAT):
        text += " ".join(map(str, [*place, *(rows[k] if rows else ())])) + "\n"
    for k, ids in enumerate(TWO_FACES):
        text += " ".join(map(str, [3, *ids, *(faces[k] if faces else ())])) + "\n"
    (folder / "a.ply").write_text(text)
    (folder / "a b.png").write_bytes(picture())
    return folder / "a.ply"


def wedge(ids):
    return [6, *(x for k in ids for x in (UV[k][0], 1.0 - UV[k][1]))]


TEXCOORD = "property list uchar float texcoord\n"


def test_a_ply_with_places_at_corners(tmp_path):
    path = ply(tmp_path, face=TEXCOORD, faces=[wedge(ids) for ids in TWO_FACES])
    plain = read_surface(path)
    assert (plain.mesh.colours, plain.notes) == (None, ("left out: its pictures",))
    np.testing.assert_array_equal(load_mesh(path, texture=True).colours, CODES)


@pytest.mark.parametrize("names", ["st", "uv", ("texture_u", "texture_v")])
def test_a_ply_with_places_at_vertices(tmp_path, names):
    columns = "".join(f"property float {name}\n" for name in names)
    path = ply(tmp_path, vertex=columns, rows=[(u, 1.0 - v) for u, v in UV])
    shown = with_pictures(path)
    np.testing.assert_array_equal(shown.mesh.colours, CODES)
    assert shown.notes == ()


def test_a_binary_ply_with_two_pictures(tmp_path):
    path = ply(tmp_path)
    head = "ply\nformat binary_little_endian 1.0\ncomment TextureFile a b.png\n"
    head += f"comment TextureFile other.png\nelement vertex 4\n{POSITION}element face 2\n{LIST}"
    head += f"{TEXCOORD}property int texnumber\nend_header\n"
    other = np.full((4, 3), (9, 99, 199), np.uint8)
    (tmp_path / "other.png").write_bytes(picture(other))
    data = head.encode() + np.array(FLAT, "<f4").tobytes()
    for ids, number in zip(TWO_FACES, (0, 1), strict=True):
        data += struct.pack("<B3iB6fi", 3, *ids, *wedge(ids), number)
    path.write_bytes(data)
    mesh = with_pictures(path).mesh
    shown = {tuple(codes) for codes in mesh.colours[mesh.faces[1]].tolist()}
    assert shown == {(9, 99, 199)}
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], CODES[list(TWO_FACES[0])])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("none.png", "which is missing"),
        ("../secret.png", "outside its folder, which is not followed"),
        ("a.ply", "no picture that can be read"),
    ],
)
def test_a_picture_of_a_ply_that_cannot_be_had(tmp_path, name, words):
    (tmp_path / "in").mkdir()
    (tmp_path / "secret.png").write_bytes(picture())
    texcoords = [wedge(ids) for ids in TWO_FACES]
    path = ply(tmp_path / "in", "", TEXCOORD, (), texcoords, (f"TextureFile {name}",))
    reading = with_pictures(path)
    assert reading.mesh.n_faces == 2
    assert len(reading.notes) == 1
    assert words in reading.notes[0]


def test_faces_without_places_or_with_too_few_are_white(tmp_path):
    path = ply(tmp_path, face=TEXCOORD, faces=[wedge(TWO_FACES[0]), [2, 0.5, 0.5]])
    mesh = with_pictures(path).mesh
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], CODES[list(TWO_FACES[0])])
    assert (mesh.colours[mesh.faces[1]] > 130).all(axis=1).any()
    bare = ply(tmp_path)
    assert with_pictures(bare).notes == ("a texture is left out: the mesh has no places on it",)


def test_colours_of_the_faces_of_a_ply(tmp_path):
    columns = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    path = ply(tmp_path, face=columns, faces=[(200, 10, 20), (10, 20, 200)], comments=())
    assert read_surface(path).notes == ("left out: colours of faces",)
    reading = with_pictures(path)
    assert reading.notes == ()
    shown = reading.mesh.colours[reading.mesh.faces]
    assert (shown[0] == (200, 10, 20)).all()
    assert (shown[1] == (10, 20, 200)).all()
    assert reading.mesh.area == pytest.approx(1.0)


# -- 3MF --------------------------------------------------------------------------------------

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIAL = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
RELATIONS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="r" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


def package(path, resources, properties, turn=None):
    """Write the square as a 3MF; `properties` are the attributes of its two triangles."""
    nodes = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in FLAT)
    faces = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {more}/>'
        for (a, b, c), more in zip(TWO_FACES, properties, strict=True)
    )
    turned = "" if turn is None else f' transform="{turn}"'
    model = (
        f'<model xmlns="{CORE}" xmlns:m="{MATERIAL}" unit="millimeter"><resources>{resources}'
        f'<object id="9"><mesh><vertices>{nodes}</vertices><triangles>{faces}</triangles></mesh>'
        f'</object></resources><build><item objectid="9"{turned}/></build></model>'
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("_rels/.rels", RELATIONS)
        archive.writestr("3D/3dmodel.model", model)
        archive.writestr("3D/Textures/a.png", picture())
    return path


TEXTURE = '<m:texture2d id="1" path="/3D/Textures/a.png" contenttype="image/png"{}/>'
TWO_PLACES = (
    '<m:texture2dgroup id="2" texid="1">'
    + "".join(f'<m:tex2coord u="{u}" v="{1.0 - v}"/>' for u, v in UV)
    + "</m:texture2dgroup>"
)
ON_PICTURE = ('pid="2" p1="0" p2="1" p3="2"', 'pid="2" p1="2" p2="1" p3="3"')
GROUP = '<m:colorgroup id="5"><m:color color="#C80A14"/><m:color color="#0A14C8"/></m:colorgroup>'


def test_a_3mf_texture(tmp_path):
    path = package(tmp_path / "a.3mf", TEXTURE.format("") + TWO_PLACES, ON_PICTURE)
    plain = read_surface(path)
    assert (plain.mesh.colours, plain.notes) == (None, ("left out: its pictures",))
    shown = load_mesh(path, texture=True)
    np.testing.assert_array_equal(shown.colours, CODES)
    mirrored = package(tmp_path / "b.3mf", TEXTURE.format("") + TWO_PLACES, ON_PICTURE,
                       "-1 0 0 0 1 0 0 0 1 0 0 0")  # fmt: skip
    mesh = with_pictures(mirrored).mesh
    np.testing.assert_array_equal(mesh.colours, CODES)
    assert (mesh.face_normals[:, 2] > 0.99).all()


def test_a_3mf_texture_that_is_tiled(tmp_path):
    far = TWO_PLACES.replace('u="0.25"', 'u="1.75"')  # mirrored: 0.25 again
    tiled = TEXTURE.format(' tilestyleu="mirror" tilestylev="clamp"')
    shown = with_pictures(package(tmp_path / "a.3mf", tiled + far, ON_PICTURE)).mesh
    corner = np.flatnonzero((shown.vertices == (0, 0, 0)).all(axis=1))
    assert shown.colours[corner[0]].tolist() == [255, 0, 0]


def test_places_absurdly_far_out_are_taken_for_unknown(tmp_path):
    far = TWO_PLACES.replace('u="0.25"', 'u="2147483647"')
    mesh = with_pictures(package(tmp_path / "a.3mf", TEXTURE.format("") + far, ON_PICTURE)).mesh
    assert mesh.n_vertices < 100  # not refined for thousands of millions of pictures


def test_colours_of_a_3mf_stay_apart_at_a_vertex(tmp_path):
    """A colour group gives each corner a colour: without pictures their mean, with them both."""
    flat = ('pid="5" p1="0"', 'pid="5" p1="1"')
    path = package(tmp_path / "a.3mf", GROUP, flat)
    mean = read_surface(path).mesh
    assert mean.n_vertices == 4
    assert mean.colours[1].tolist() == [105, 15, 110]
    apart = with_pictures(path).mesh
    assert apart.n_vertices == 6
    assert (apart.vertices[:4] == mean.vertices).all()
    shown = apart.colours[apart.faces]
    assert (shown[0] == (200, 10, 20)).all()
    assert (shown[1] == (10, 20, 200)).all()


def test_a_colour_beside_a_picture(tmp_path):
    mixed = (ON_PICTURE[0], 'pid="5" p1="1"')
    mesh = with_pictures(
        package(tmp_path / "a.3mf", TEXTURE.format("") + TWO_PLACES + GROUP, mixed)
    ).mesh
    assert (mesh.colours[mesh.faces[1]] == (10, 20, 200)).all()
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], CODES[list(TWO_FACES[0])])


@pytest.mark.parametrize(
    ("resources", "properties", "message"),
    [
        (GROUP, ('pid="5" p1="7"',) * 2, "colour 7 of resource 5, which has 2; expected 0 to 1"),
        (GROUP, ('pid="5" p1="-1"',) * 2, "has colour -1 of resource 5"),
        (TEXTURE.format("") + TWO_PLACES, ('pid="2" p1="0" p2="4" p3="1"',) * 2,
         "has place on a picture 4 of resource 2, which has 4"),
        (GROUP.replace("C80A14", "C80AZZ"), ('pid="5" p1="0"',) * 2, "'#C80AZZ'; expected #RRGGBB"),
    ],
)  # fmt: skip
def test_a_3mf_that_refers_to_what_it_has_not(tmp_path, resources, properties, message):
    path = package(tmp_path / "a.3mf", resources, properties)
    with pytest.raises(MeshError, match=message):
        with_pictures(path)


def test_a_texture_that_a_3mf_does_not_contain(tmp_path):
    gone = TEXTURE.format("").replace("a.png", "b.png")
    reading = with_pictures(package(tmp_path / "a.3mf", gone + TWO_PLACES, ON_PICTURE))
    assert reading.mesh.n_faces == 2
    assert "refers to '/3D/Textures/b.png', which it does not contain" in reading.notes[0]


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus of meshes is not here")
def test_a_sphere_with_a_logo():
    mesh = with_pictures(CORPUS / "3mf/sphere_logo.3mf").mesh
    codes, often = np.unique(mesh.colours // 16, axis=0, return_counts=True)
    assert {(1, 3, 6), (15, 15, 15)} <= {tuple(c) for c in codes[often > 100].tolist()}

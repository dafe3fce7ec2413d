"""Pictures and colours of faces in PLY and 3MF files, read where they are and told where not."""

import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.errors import MeshError
from paint3d.files.load import load_mesh
from paint3d.files.reading import Wanted, read_surface

CODES = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [40, 80, 120]], np.uint8)
UV = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]]  # the middles, from the upper left
SQUARE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
FACES = [(0, 1, 2), (2, 1, 3)]
CORPUS = Path(__file__).parents[2] / "../shared/corpus"


def picture(codes=CODES):
    """Four pixels of different colour, as PNG."""
    file = io.BytesIO()
    Image.fromarray(codes.reshape(2, 2, 3)).save(file, "PNG")
    return file.getvalue()


def with_pictures(path):
    return read_surface(path, Wanted(texture=True))


# -- PLY --------------------------------------------------------------------------------------

POSITION = "property float x\nproperty float y\nproperty float z\n"
LIST = "property list uchar int vertex_indices\n"


def ply(folder, vertex="", face="", rows=(), faces=(), comments=("TextureFile a b.png",)):
    """A square in ASCII with these columns and values besides."""
    text = "ply\nformat ascii 1.0\n" + "".join(f"comment {c}\n" for c in comments)
    text += f"element vertex 4\n{POSITION}{vertex}element face 2\n{LIST}{face}end_header\n"
    for k, place in enumerate(SQUARE):
        text += " ".join(map(str, [*place, *(rows[k] if rows else ())])) + "\n"
    for k, ids in enumerate(FACES):
        text += " ".join(map(str, [3, *ids, *(faces[k] if faces else ())])) + "\n"
    (folder / "a.ply").write_text(text)
    (folder / "a b.png").write_bytes(picture())
    return folder / "a.ply"


def wedge(ids):
    return [6, *(x for k in ids for x in (UV[k][0], 1.0 - UV[k][1]))]


TEXCOORD = "property list uchar float texcoord\n"


def test_a_ply_with_places_at_corners(tmp_path):
    path = ply(tmp_path, face=TEXCOORD, faces=[wedge(ids) for ids in FACES])
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
    data = head.encode() + np.array(SQUARE, "<f4").tobytes()
    for ids, number in zip(FACES, (0, 1), strict=True):
        data += struct.pack("<B3iB6fi", 3, *ids, *wedge(ids), number)
    path.write_bytes(data)
    mesh = with_pictures(path).mesh
    shown = {tuple(codes) for codes in mesh.colours[mesh.faces[1]].tolist()}
    assert shown == {(9, 99, 199)}
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], CODES[list(FACES[0])])


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
    texcoords = [wedge(ids) for ids in FACES]
    path = ply(tmp_path / "in", "", TEXCOORD, (), texcoords, (f"TextureFile {name}",))
    reading = with_pictures(path)
    assert reading.mesh.n_faces == 2
    assert len(reading.notes) == 1
    assert words in reading.notes[0]


def test_faces_without_places_or_with_too_few_are_white(tmp_path):
    path = ply(tmp_path, face=TEXCOORD, faces=[wedge(FACES[0]), [2, 0.5, 0.5]])
    mesh = with_pictures(path).mesh
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], CODES[list(FACES[0])])
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
    nodes = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in SQUARE)
    faces = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {more}/>'
        for (a, b, c), more in zip(FACES, properties, strict=True)
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
PLACES = (
    '<m:texture2dgroup id="2" texid="1">'
    + "".join(f'<m:tex2coord u="{u}" v="{1.0 - v}"/>' for u, v in UV)
    + "</m:texture2dgroup>"
)
ON_PICTURE = ('pid="2" p1="0" p2="1" p3="2"', 'pid="2" p1="2" p2="1" p3="3"')
GROUP = '<m:colorgroup id="5"><m:color color="#C80A14"/><m:color color="#0A14C8"/></m:colorgroup>'


def test_a_3mf_texture(tmp_path):
    path = package(tmp_path / "a.3mf", TEXTURE.format("") + PLACES, ON_PICTURE)
    plain = read_surface(path)
    assert (plain.mesh.colours, plain.notes) == (None, ("left out: its pictures",))
    shown = load_mesh(path, texture=True)
    np.testing.assert_array_equal(shown.colours, CODES)
    mirrored = package(tmp_path / "b.3mf", TEXTURE.format("") + PLACES, ON_PICTURE,
                       "-1 0 0 0 1 0 0 0 1 0 0 0")  # fmt: skip
    mesh = with_pictures(mirrored).mesh
    np.testing.assert_array_equal(mesh.colours, CODES)
    assert (mesh.face_normals[:, 2] > 0.99).all()


def test_a_3mf_texture_that_is_tiled(tmp_path):
    far = PLACES.replace('u="0.25"', 'u="1.75"')  # mirrored: 0.25 again
    tiled = TEXTURE.format(' tilestyleu="mirror" tilestylev="clamp"')
    shown = with_pictures(package(tmp_path / "a.3mf", tiled + far, ON_PICTURE)).mesh
    corner = np.flatnonzero((shown.vertices == (0, 0, 0)).all(axis=1))
    assert shown.colours[corner[0]].tolist() == [255, 0, 0]


def test_places_absurdly_far_out_are_taken_for_unknown(tmp_path):
    far = PLACES.replace('u="0.25"', 'u="2147483647"')
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
        package(tmp_path / "a.3mf", TEXTURE.format("") + PLACES + GROUP, mixed)
    ).mesh
    assert (mesh.colours[mesh.faces[1]] == (10, 20, 200)).all()
    np.testing.assert_array_equal(mesh.colours[mesh.faces[0]], CODES[list(FACES[0])])


@pytest.mark.parametrize(
    ("resources", "properties", "message"),
    [
        (GROUP, ('pid="5" p1="7"',) * 2, "colour 7 of resource 5, which has 2; expected 0 to 1"),
        (GROUP, ('pid="5" p1="-1"',) * 2, "has colour -1 of resource 5"),
        (TEXTURE.format("") + PLACES, ('pid="2" p1="0" p2="4" p3="1"',) * 2,
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
    reading = with_pictures(package(tmp_path / "a.3mf", gone + PLACES, ON_PICTURE))
    assert reading.mesh.n_faces == 2
    assert "refers to '/3D/Textures/b.png', which it does not contain" in reading.notes[0]


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus of meshes is not here")
def test_a_sphere_with_a_logo():
    mesh = with_pictures(CORPUS / "3mf/sphere_logo.3mf").mesh
    codes, often = np.unique(mesh.colours // 16, axis=0, return_counts=True)
    assert {(1, 3, 6), (15, 15, 15)} <= {tuple(c) for c in codes[often > 100].tolist()}

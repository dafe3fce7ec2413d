"""Files of other people's that say more, or less, than most: read, or refused by what they hold."""

import base64
import json
import struct
import zipfile

import numpy as np
import pytest
import trimesh

from paint3d.errors import MeshError
from paint3d.files.load import load_mesh, read_mesh
from paint3d.files.reading import ReadOptions, read_surface

POINTS = "property float x\nproperty float y\nproperty float z\n"
QUAD = "v 0 0 0 {}\nv 1 0 0 {}\nv 1 1 0 {}\nv 0 1 0 {}\nf 1 2 3 4\n"


def written(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


# -- colours ----------------------------------------------------------------------------------


def coloured(*rows):
    return QUAD.format(*(" ".join(map(str, row)) for row in rows))


RED, NO_NUMBER = (1, 0, 0), ("nan", 0, 0)
WHITE_CODES, RED_CODES = [255, 255, 255], [255, 0, 0]


@pytest.mark.parametrize(
    ("rows", "codes", "note"),
    [
        ((RED, RED, NO_NUMBER, RED), [RED_CODES, RED_CODES, WHITE_CODES, RED_CODES],
         "1 of 4 vertex colours are no numbers: made white"),
        ((RED, (1.25, 0, 0), (1, -0.5, 0), RED), [RED_CODES] * 4,
         "2 of 4 vertex colours are not within 0 to 1: brought to the nearest"),
        (((255, 0, 0), (0, 255, 0), (0, 0, 255), (0, 0, 0)),
         [RED_CODES, [0, 255, 0], [0, 0, 255], [0, 0, 0]], "taken as 0 to 255"),
        ([(300, 0, 0)] * 4, None, "left out: its vertex colours, most of which are not within"),
        ([NO_NUMBER] * 4, None, "left out: its vertex colours, none of which is a number"),
    ],
)  # fmt: skip
def test_colours_that_are_none(tmp_path, rows, codes, note):
    reading = read_surface(written(tmp_path, "a.obj", coloured(*rows)))
    assert (None if reading.mesh.colours is None else reading.mesh.colours.tolist()) == codes
    assert len(reading.notes) == 1
    assert note in reading.notes[0]


def test_good_colours_need_no_note(tmp_path):
    reading = read_surface(written(tmp_path, "a.obj", coloured(RED, RED, RED, (0, 0, 0))))
    assert (reading.notes, reading.mesh.colours[3].tolist()) == ((), [0, 0, 0])


def test_one_colour_of_a_ply_and_what_was_done_reach_the_parent(tmp_path):
    colour = "property float red\nproperty float green\nproperty float blue\n"
    head = f"ply\nformat ascii 1.0\nelement vertex 3\n{POINTS}{colour}"
    faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    rows = "0 0 0 1 0 0\n1 0 0 nan nan nan\n0 1 0 0 0 1\n3 0 1 2\n"
    reading = read_mesh(written(tmp_path, "a.ply", head + faces + rows))
    assert reading.mesh.colours.tolist() == [RED_CODES, WHITE_CODES, [0, 0, 255]]
    assert reading.notes == ("1 of 3 vertex colours are no numbers: made white",)


CUBE_PLACES = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
CUBE_QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SHADES = [(200, 30, 30), (30, 200, 30), (30, 30, 200), (0, 0, 0),
          (1, 1, 1), (3, 2, 0), (0, 1, 2), (90, 60, 2)]  # fmt: skip
"""Most of them dark; as everything is with 255 for white."""
PLY_TYPES = {
    "uint": "u4",
    "int": "i4",
    "ushort": "u2",
    "short": "i2",
    "float": "f4",
    "double": "f8",
}


def coloured_ply(kind, order, rows):
    """A cube whose vertices have these colours, of this type."""
    head = f"ply\nformat {order} 1.0\nelement vertex {len(rows)}\n{POINTS}"
    head += "".join(f"property {kind} {name}\n" for name in ("red", "green", "blue"))
    head += f"element face {len(CUBE_QUADS)}\nproperty list uchar int vertex_indices\nend_header\n"
    if order == "ascii":
        lines = [" ".join(map(str, (*p, *c))) for p, c in zip(CUBE_PLACES, rows, strict=True)]
        lines += [" ".join(map(str, (4, *face))) for face in CUBE_QUADS]
        return (head + "\n".join(lines) + "\n").encode()
    mark = "<" if "little" in order else ">"
    table = np.zeros(len(rows), [("xyz", f"{mark}f4", 3), ("rgb", mark + PLY_TYPES[kind], 3)])
    table["xyz"], table["rgb"] = CUBE_PLACES, rows
    faces = np.zeros(len(CUBE_QUADS), [("n", "u1"), ("ids", f"{mark}i4", 4)])
    faces["n"], faces["ids"] = 4, CUBE_QUADS
    return head.encode() + table.tobytes() + faces.tobytes()


def colours_of(tmp_path, name, data):
    reading = read_surface(written(tmp_path, name, data))
    return reading.mesh.colours.tolist(), reading.notes


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("kind", PLY_TYPES)
def test_codes_of_any_type_in_a_ply(tmp_path, kind, order):
    data = coloured_ply(kind, order, SHADES)
    codes, notes = colours_of(tmp_path, "a.ply", data)
    assert codes == [list(shade) for shade in SHADES]
    assert notes == ("its vertex colours are taken as 0 to 255",)
    open3d = pytest.importorskip("open3d")
    judge = open3d.io.read_triangle_mesh(str(tmp_path / "a.ply"))
    np.testing.assert_allclose(255.0 * np.asarray(judge.vertex_colors), codes, atol=1e-4)
    if PLY_TYPES[kind][0] != "f":  # of floats trimesh takes those from 0 to 1 alone
        other = trimesh.load(tmp_path / "a.ply", process=False)
        np.testing.assert_array_equal(other.visual.vertex_colors[:, :3], codes)


@pytest.mark.parametrize(
    ("kind", "end"), [("ushort", 65_535), ("uint", 65_535), ("uint", 2**32 - 1)]
)
@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_codes_of_more_bits_in_a_ply(tmp_path, kind, end, order):
    rows = [tuple(end // 255 * c for c in shade) for shade in SHADES]
    codes, notes = colours_of(tmp_path, "a.ply", coloured_ply(kind, order, rows))
    assert codes == [list(shade) for shade in SHADES]
    full = end == 2 ** (8 * np.dtype(PLY_TYPES[kind]).itemsize) - 1  # as the type says
    assert notes == (() if full else ("its vertex colours are taken as 0 to 65,535",))


def test_bytes_that_a_ply_calls_signed(tmp_path):
    signed = [tuple(c - 256 if c > 127 else c for c in shade) for shade in SHADES]
    codes, _ = colours_of(tmp_path, "a.ply", coloured_ply("char", "ascii", signed))
    assert codes == [list(shade) for shade in SHADES]


def test_shares_that_a_ply_calls_bytes(tmp_path):
    rows = [(0.5, 1, 0)] * 8
    codes, notes = colours_of(tmp_path, "a.ply", coloured_ply("uchar", "ascii", rows))
    assert (codes, notes) == ([[128, 255, 0]] * 8, ())


def test_codes_of_faces_of_a_ply(tmp_path):
    head = f"ply\nformat ascii 1.0\nelement vertex 4\n{POINTS}element face 2\n"
    head += "property list uchar int vertex_indices\nproperty uint red\nproperty uint green\n"
    text = head + "property uint blue\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
    text += "3 0 1 2 200 30 30\n3 0 2 3 3 2 1\n"
    reading = read_surface(written(tmp_path, "a.ply", text), ReadOptions(texture=True))
    assert {tuple(code) for code in reading.mesh.colours.tolist()} == {(200, 30, 30), (3, 2, 1)}
    assert reading.notes == ("its colours of faces are taken as 0 to 255",)


def test_mostly_dark_codes_of_an_obj(tmp_path):
    rows = ((0, 0, 0), (1, 0, 1), (0, 1, 0), (200, 30, 30))
    codes, notes = colours_of(tmp_path, "a.obj", coloured(*rows))
    assert codes == [list(row) for row in rows]
    assert notes == ("its vertex colours are taken as 0 to 255",)


def test_vertices_without_a_colour_are_white_among_codes(tmp_path):
    codes, _ = colours_of(tmp_path, "a.obj", coloured((200, 30, 30), (), (), (0, 0, 200)))
    assert codes == [[200, 30, 30], WHITE_CODES, WHITE_CODES, [0, 0, 200]]


@pytest.mark.parametrize(
    ("rows", "codes", "end"),
    [
        ([(127.5, 0.5, 30), (200.25, 3, 0)] * 2, [[128, 1, 30], [200, 3, 0]] * 2, "255"),
        ([(51_400, 7710, 0), (257, 0, 0)] * 2, [[200, 30, 0], [1, 0, 0]] * 2, "65,535"),
        ([(256, 30, 0), (200, 3, 0), (9, 9, 9), (0, 0, 0)],
         [[255, 30, 0], [200, 3, 0], [9, 9, 9], [0, 0, 0]], "255"),
    ],
)  # fmt: skip
def test_the_range_is_that_of_the_numbers(tmp_path, rows, codes, end):
    found, notes = colours_of(tmp_path, "a.obj", coloured(*rows))
    assert found == codes
    assert notes[0] == f"its vertex colours are taken as 0 to {end}"
    assert len(notes) == (2 if rows[0][0] == 256 else 1)


def test_light_that_is_too_bright_is_no_code(tmp_path):
    rows = ((0.5, 0.25, 0), (3.5, 2.5, 0), (0, 0.5, 0), (1, 0, 0))
    codes, notes = colours_of(tmp_path, "a.obj", coloured(*rows))
    assert codes == [[128, 64, 0], [255, 255, 0], [0, 128, 0], RED_CODES]
    assert notes == ("1 of 4 vertex colours are not within 0 to 1: brought to the nearest that is",)


@pytest.mark.parametrize(
    ("rows", "codes", "notes"),
    [
        (["200 30 30 255"] * 3, [200, 30, 30], ()),
        (["0.5 0.25 1 1"] * 3, [128, 64, 255], ()),
        (["1 0 0 1"] * 3, RED_CODES, ("its vertex colours are taken as 0 to 1",)),
        (["200.0 30.0 30.0 255.0"] * 3, [200, 30, 30],
         ("its vertex colours are taken as 0 to 255",)),
    ],
)  # fmt: skip
def test_colours_of_a_coff(tmp_path, rows, codes, notes):
    places = ("0 0 0", "1 0 0", "0 1 0")
    lines = [f"{place} {row}" for place, row in zip(places, rows, strict=True)]
    text = "\n".join(["COFF", "3 1 0", *lines, "3 0 1 2"]) + "\n"
    assert colours_of(tmp_path, "a.off", text) == ([codes] * 3, notes)


@pytest.mark.parametrize("row", [(0.5, 0.25, 1.0), (128, 64, 255)])
def test_colours_of_a_list_of_points(tmp_path, row):
    places = [(x, y, 0.0) for x in range(8) for y in range(8)]
    text = "".join(" ".join(map(str, (*place, *row))) + "\n" for place in places)
    reading = read_surface(written(tmp_path, "a.xyz", text), ReadOptions(from_points=True))
    assert (reading.mesh.colours == [128, 64, 255]).all()


@pytest.mark.parametrize(("kind", "code"), [(5121, "u1"), (5123, "<u2"), (5126, "<f4")])
def test_codes_of_a_gltf_that_does_not_say_that_they_are(tmp_path, kind, code):
    """Its type is normalized by the specification, which not every writer knows."""
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    colours = np.array([[255, 0, 0, 255]] * 3, code).tobytes()
    data = base64.b64encode(places + colours).decode()
    document = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": kind, "count": 3, "type": "VEC4"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": len(colours)},
        ],
        "buffers": [{"byteLength": 36 + len(colours), "uri": f"data:;base64,{data}"}],
    }  # fmt: skip
    codes, notes = colours_of(tmp_path, "a.gltf", json.dumps(document))
    assert codes == [RED_CODES] * 3
    assert notes == ("its vertex colours are taken as 0 to 255",)


# -- triangle strips --------------------------------------------------------------------------


def striped_grid(n):
    """A sheet of n x n squares as one strip for each row, stitched or not: vertices, strips."""
    places = [(x, y, 0.0) for y in range(n + 1) for x in range(n + 1)]
    strips = []
    for y in range(n):
        low, high = y * (n + 1), (y + 1) * (n + 1)
        strips.append([k for x in range(n + 1) for k in (high + x, low + x)])
    return np.array(places), strips


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("form", ["rows", "minus one", "stitched"])
def test_triangle_strips_of_a_ply(tmp_path, order, form):
    places, strips = striped_grid(5)
    if form == "minus one":  # as the scans of Stanford and Georgia Tech have them
        strips = [[k for strip in strips for k in (*strip, -1)]]
    elif form == "stitched":  # triangles without area lead from one strip to the next
        joined = list(strips[0])
        for strip in strips[1:]:
            joined += [joined[-1], strip[0], *strip]
        strips = [joined]
    head = f"ply\nformat {order} 1.0\nelement vertex {len(places)}\n{POINTS}element tristrips "
    head += f"{len(strips)}\nproperty list int int vertex_indices\nend_header\n"
    if order == "ascii":
        body = "".join(" ".join(map(str, row)) + "\n" for row in places.tolist())
        body += "".join(f"{len(s)} {' '.join(map(str, s))}\n" for s in strips)
        data = (head + body).encode()
    else:
        mark = "<" if "little" in order else ">"
        data = head.encode() + places.astype(f"{mark}f4").tobytes()
        data += b"".join(np.array([len(s), *s], f"{mark}i4").tobytes() for s in strips)
    reading = read_surface(written(tmp_path, "a.ply", data))
    assert reading.mesh.n_faces == 50
    assert reading.mesh.area == pytest.approx(25.0)
    assert (reading.mesh.face_normals[:, 2] > 0.99).all()
    assert reading.notes == ()


def test_a_strip_beyond_the_vertices_is_refused(tmp_path):
    text = f"ply\nformat ascii 1.0\nelement vertex 3\n{POINTS}element tristrips 1\n"
    text += "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"
    with pytest.raises(MeshError, match="refers to vertex 7; expected 0 to 2"):
        read_surface(written(tmp_path, "a.ply", text))


# -- what is no point cloud -------------------------------------------------------------------


def ball_rows():
    return trimesh.creation.icosphere(subdivisions=2, radius=10.0).vertices


def test_an_unknown_element_makes_no_point_cloud(tmp_path):
    rows = ball_rows()
    text = f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n{POINTS}element range_grid 1\n"
    text += "property list uchar int vertex_indices\nend_header\n"
    text += "".join(f"{x} {y} {z}\n" for x, y, z in rows) + "1 0\n"
    path = written(tmp_path, "a.ply", text)
    with pytest.raises(MeshError, match=r"says it has 'range_grid', which is not read; .*--from-p"):
        read_surface(path)


def test_lines_make_no_point_cloud(tmp_path):
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in ball_rows()) + "l 1 2\nl 2 3\n"
    with pytest.raises(MeshError, match="162 points but no triangles, though it says it has lines"):
        read_surface(written(tmp_path, "a.obj", text))


def test_points_that_all_lie_in_one_place(tmp_path):
    pytest.importorskip("open3d", exc_type=ImportError)
    path = written(tmp_path, "a.obj", "v 1 2 3\n" * 40 + "v 1 2 4\n")
    with pytest.raises(MeshError, match="lie in the place of another; expected points that lie"):
        read_surface(path)


LATTICE = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def package(path, mesh, extra=""):
    """Write a 3MF of one object."""
    model = f'<model xmlns="{CORE}" xmlns:b="{LATTICE}" unit="millimeter"><resources>{extra}'
    model += f'<object id="9"><mesh>{mesh}</mesh></object></resources>'
    model += '<build><item objectid="9"/></build></model>'
    kind = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    relations = (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    )
    relations += f'<Relationship Target="/3D/3dmodel.model" Id="r" Type="{kind}"/></Relationships>'
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("_rels/.rels", relations)
        archive.writestr("3D/3dmodel.model", model)
    return path


def nodes(rows):
    inner = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in rows)
    return f"<vertices>{inner}</vertices>"


BEAMS = '<b:beamlattice radius="1" minlength="1"><b:beams><b:beam v1="0" v2="1"/></b:beams>'
BEAMS += "</b:beamlattice>"


def test_a_beam_lattice_is_refused_by_name(tmp_path):
    path = package(tmp_path / "a.3mf", nodes(ball_rows()) + "<triangles/>" + BEAMS)
    with pytest.raises(MeshError, match="it says it has a beam lattice, which is not read"):
        read_surface(path)


def test_a_3mf_without_triangles_is_no_point_cloud(tmp_path):
    path = package(tmp_path / "a.3mf", nodes(ball_rows()) + "<triangles/>")
    with pytest.raises(
        MeshError, match="162 points but no triangles, though it says it has a mesh"
    ):
        read_surface(path)


def test_beams_beside_triangles_are_said_to_be_left_out(tmp_path):
    triangle = '<triangles><triangle v1="0" v2="1" v3="2"/></triangles>'
    path = package(tmp_path / "a.3mf", nodes(ball_rows()) + triangle + BEAMS)
    assert read_surface(path, ReadOptions()).notes == ("left out: beam lattices",)


# -- glTF -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"asset": {"version": "1.0"}, "scene": "main", "scenes": {"main": {}}}',
         "it is glTF version 1.0; expected 2"),
        ('{"scene": "main", "scenes": {"main": {"nodes": ["a"]}}}', "as in glTF version 1"),
        ('{"scenes": ["main"]}', r"its scenes\[0\] is a text; expected an object"),
        ('{"meshes": [{"primitives": [["POSITION"]]}]}',
         r"its meshes\[0\].primitives\[0\] is a list; expected an object"),
        ('{"meshes": [{"primitives": [{"attributes": 7}]}]}',
         r"primitives\[0\].attributes is a number; expected an object"),
        ('{"materials": [{"pbrMetallicRoughness": null}]}',
         r"its materials\[0\].pbrMetallicRoughness is null; expected an object"),
        ('{"nodes": [{"children": "all"}]}', r"nodes\[0\].children is a text; expected a list"),
        ('{"scenes": [{"nodes": ["a"]}]}', r"refers to nodes\[a\], of which there are 0"),
        ('{"asset": [], "scenes": []}', "its asset is a list; expected an object"),
    ],
)  # fmt: skip
def test_gltf_of_another_kind(tmp_path, text, message):
    with pytest.raises(MeshError, match=message):
        read_surface(written(tmp_path, "a.gltf", text))


def test_a_glb_that_ends_before_its_first_chunk(tmp_path):
    data = b"glTF" + struct.pack("<II", 2, 16) + struct.pack("<I4s", 4, b"JSON") + b"{}  "
    with pytest.raises(MeshError, match="no JSON chunk within the 16 bytes that its header speaks"):
        read_surface(written(tmp_path, "a.glb", data))


@pytest.mark.parametrize("kind", [KeyError, IndexError, AttributeError, TypeError, RecursionError])
def test_what_a_reader_stumbles_over_is_told_in_words(tmp_path, monkeypatch, kind):
    def stumble(*_):
        raise kind("'str' object has no attribute 'get'")

    monkeypatch.setattr("paint3d.files.formats.off.read_off", stumble)
    with pytest.raises(MeshError, match="its structure is damaged: ") as caught:
        read_surface(written(tmp_path, "a.off", "OFF"))
    assert ("attribute" in str(caught.value)) == (kind is KeyError)


# -- OFF --------------------------------------------------------------------------------------

CUBE = trimesh.creation.box((1.0, 2.0, 3.0))
CUBE_ROWS = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE.vertices)
CUBE_FACES = "".join(f"3 {a} {b} {c}\n" for a, b, c in CUBE.faces)
COLOURED_ROWS = CUBE_ROWS.replace("\n", " 255 128 0 255\n")


@pytest.mark.parametrize(
    "text",
    [
        f"OFF8 12 18\n{CUBE_ROWS}{CUBE_FACES}",
        f"OFF 8 12 18\n{CUBE_ROWS}{CUBE_FACES}",
        f"8 12 18\n{CUBE_ROWS}{CUBE_FACES}",
        f"# by hand\noff\n8 12 18\n{CUBE_ROWS}{CUBE_FACES}",
        f"OFF\n8 12 0\n{CUBE_ROWS}{CUBE_FACES.replace(' ', chr(10))}",
        f"OFF\n8 12 0\n{CUBE_ROWS.replace(' ', chr(10))}{CUBE_FACES}",
        f"OFF 8 12 0 {CUBE_ROWS} {CUBE_FACES}".replace("\n", " "),
        f"STOFF\n8 12 0\n{CUBE_ROWS.replace(chr(10), ' .5 .5' + chr(10))}{CUBE_FACES}",
        f"OFF\n8 12 0\n{CUBE_ROWS}{CUBE_FACES.replace(chr(10), ' 255 0 0' + chr(10))}",
        f"COFF\n8 12 0\n{COLOURED_ROWS}{CUBE_FACES}",
        f"COFF\n8 12 0\n{COLOURED_ROWS}{CUBE_FACES.replace(' ', chr(10))}",
    ],
)
def test_off_with_its_lines_and_its_word_anyhow(tmp_path, text):
    mesh = read_surface(written(tmp_path, "a.off", text)).mesh
    assert (mesh.n_vertices, mesh.n_faces) == (8, 12)
    assert mesh.area == pytest.approx(CUBE.area)
    assert (mesh.colours is not None) == text.startswith("COFF")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"4OFF\n8 12 0\n{CUBE_ROWS}", "other than three dimensions; expected three"),
        ("OFF BINARY\n", "binary OFF file"),
        ("8 12\n", "does not start with 'OFF'"),
        (f"OFF\n8 12 0\n{CUBE_ROWS}{CUBE_FACES[:60]}", "cut short"),
        (f"OFF\n8 13 0\n{CUBE_ROWS}{CUBE_FACES}x\n", "does not start with its number"),
        ("OFFICE\n8 12 0\n", "does not start with 'OFF'"),
    ],
)
def test_off_that_is_none(tmp_path, text, message):
    with pytest.raises(MeshError, match=message):
        read_surface(written(tmp_path, "a.off", text))


# -- headers ----------------------------------------------------------------------------------


def test_a_comment_that_does_not_say_so_is_passed_over(tmp_path):
    text = (
        "ply\nformat ascii 1.0\nCreated by Blender3D 2.47 - www.blender.org, source file: a.blend\n"
    )
    text += f"element vertex 3\n{POINTS}element face 1\nproperty list uchar uint vertex_indices\n"
    text += "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    reading = read_surface(written(tmp_path, "a.ply", text))
    assert reading.mesh.n_faces == 1
    assert "line 'Created by Blender3D 2.47" in reading.notes[0]


@pytest.mark.parametrize("line", ["elemnt vertex 3", "Property float x", "formt ascii 1.0"])
def test_a_word_of_the_header_that_is_misspelt_is_not(tmp_path, line):
    text = f"ply\nformat ascii 1.0\n{line}\nelement vertex 3\n{POINTS}end_header\n0 0 0\n"
    with pytest.raises(MeshError, match="the header has an unknown line"):
        read_surface(written(tmp_path, "a.ply", text))


def test_a_million_blank_lines_of_an_stl_take_no_longer_than_any_others(tmp_path):
    """Each was searched to the end of all that followed it."""
    facet = "facet normal 0 0 1\n outer loop\n{}endloop\nendfacet\n".format(
        "".join(f"vertex {x} {y} 0\n" for x, y in ((0, 0), (1, 0), (0, 1)))
    )
    path = tmp_path / "blank.stl"
    path.write_text("solid a\n" + "\n" * 1_000_000 + facet + "endsolid a\n", encoding="utf-8")
    assert len(load_mesh(path).faces) == 1

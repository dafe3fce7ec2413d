"""Colours as other programs write them: each is read, or a note says that it is left out."""

import base64
import io
import json
import struct
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from paint3d.errors import MeshError
from paint3d.files.formats.threemf import read_3mf
from paint3d.files.reading import ReadOptions, read_surface
from paint3d.files.references import refers_to
from tests.support.examples import examples

RED, BLUE = (200, 30, 30), (30, 30, 200)
SQUARE = np.array([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)], float)
HALVES = np.array([(0, 1, 2), (0, 2, 3)])
FACES = "left out: colours of faces"


def read(tmp_path, name, content, texture=True):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_surface(path, ReadOptions(texture=texture))


def codes(reading):
    """The distinct colours of a mesh."""
    return {tuple(row) for row in reading.mesh.colours.tolist()}


# -- OBJ -----------------------------------------------------------------------------------------


def obj(tails, comments=""):
    lines = [f"v {x:g} {y:g} {z:g} {tail}" for (x, y, z), tail in zip(SQUARE, tails, strict=True)]
    return "\n".join([*lines, comments, "f 1 2 3", "f 1 3 4"]) + "\n"


@pytest.mark.parametrize(
    "tail",
    [
        "1 0 0",
        "255 0 0",
        "1 0 0 1",  # with an opacity
        "255 0 0 255",
        "1 1 0 0",  # after a weight
        "1 1 0 0 1",  # both
    ],
)
def test_vertex_lines_of_any_length_have_their_colour(tmp_path, tail):
    reading = read(tmp_path, "a.obj", obj([tail] * 4), texture=False)
    assert codes(reading) == {(255, 0, 0)}


def test_weights_are_told_from_opacities_by_what_stays_the_same(tmp_path):
    opaque = obj(["1 0 0 1", "0 1 0 1", "1 0 0 1", "0 1 0 1"])
    assert codes(read(tmp_path, "a.obj", opaque)) == {(255, 0, 0), (0, 255, 0)}
    weighted = obj(["1 1 0 0", "1 0 0 1", "1 1 0 0", "1 0 0 1"])
    assert codes(read(tmp_path, "b.obj", weighted)) == {(255, 0, 0), (0, 0, 255)}


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.obj", obj(["1 1 0 255", "0 1 0 255", "1 1 1 255", "0 0 0 255"])),
        ("a.obj", obj(["1 1 1 0 255", "1 0 1 0 255", "1 1 1 1 255", "1 0 0 0 255"])),
        ("a.off", "COFF 4 2 0\n" + "".join(f"{x} {y} 0 1 1 0 255\n" for x, y, _ in SQUARE)
         + "3 0 1 2\n3 0 2 3\n"),
        ("a.off", "OFF 4 2 0\n" + "".join(f"{x} {y} 0\n" for x, y, _ in SQUARE)
         + "3 0 1 2 1 1 0 255\n3 0 2 3 1 0 0 255\n"),
    ],
)  # fmt: skip
def test_opacities_tell_the_darkest_codes_from_fractions(tmp_path, name, content):
    reading = read(tmp_path, name, content)
    assert reading.mesh.colours.max() == 1


def test_polypaint_is_read_over_several_lines(tmp_path):
    paint = "#MRGB ffc81e1eff1e1ec8\r\n #MRGB FFC81E1EFF1E1EC8"
    assert codes(read(tmp_path, "a.obj", obj([""] * 4, paint), texture=False)) == {RED, BLUE}


def test_polypaint_of_another_mesh_is_told(tmp_path):
    reading = read(tmp_path, "a.obj", obj([""] * 4, "#MRGB ffc81e1e"))
    assert reading.mesh.colours is None
    assert reading.notes == ("left out: its polypaint, of 1 vertices instead of 4",)


def picture():
    """Red at the left, blue at the right."""
    file = io.BytesIO()
    image = np.array([[RED] * 8 + [BLUE] * 8] * 16, np.uint8)
    Image.fromarray(image).save(file, "PNG")
    return file.getvalue()


@pytest.mark.parametrize(
    ("options", "left_to_right"),
    [
        ("", [RED, RED, BLUE, BLUE]),
        ("-s 2 1 1", [RED, BLUE, RED, BLUE]),
        ("-s 2", [RED, BLUE, RED, BLUE]),  # a third or second number may be missing
        ("-o 0.5 0", [BLUE, BLUE, RED, RED]),
        ("-O 0.5 0 0 -clamp off", [BLUE, BLUE, RED, RED]),
        ("-clamp on -o 0.5 0 0", [BLUE, BLUE, BLUE, BLUE]),
        ("-bm 1 -s 2 1 1 -mm 0 1", [RED, BLUE, RED, BLUE]),
    ],
)
@pytest.mark.parametrize("key", ["map_Kd", "map_kd"])
def test_a_map_is_scaled_moved_and_clamped(tmp_path, options, left_to_right, key):
    (tmp_path / "a picture.png").write_bytes(picture())
    (tmp_path / "a.mtl").write_text(f"newmtl a\n{key} {options} a picture.png\n")
    text = "mtllib a.mtl\nusemtl a\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    text += "".join(f"v {10 * x:g} {10 * y:g} 0\n" for x, y, _ in SQUARE)
    reading = read(tmp_path, "a.obj", text + "f 1/1 2/2 3/3 4/4\n")
    x = reading.mesh.vertices[:, 0]
    for k, wanted in enumerate(left_to_right):
        inside = np.abs(x - 90.0 * (k + 0.5) / 4) < 8.0
        if not inside.any():  # of one colour all over: not made finer
            inside = np.ones(len(x), np.bool_)
        np.testing.assert_allclose(np.median(reading.mesh.colours[inside], axis=0), wanted, atol=4)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("map_Ka a.png", ("left out: pictures of ambient light",)),
        ("map_Ka a.png\nmap_Kd a.png", ()),
        ("map_Kd -mm 0.2 0.5 a.png", ("left out: brightness and contrast of a picture (-mm)",)),
        ("map_Kd -mm 0 1 a.png", ()),
    ],
)
def test_what_of_a_material_is_not_shown_is_told(tmp_path, lines, told):
    (tmp_path / "a.png").write_bytes(picture())
    (tmp_path / "a.mtl").write_text(f"newmtl a\n{lines}\n")
    text = "mtllib a.mtl\nusemtl a\nvt 0 0\nvt 1 0\nvt 1 1\n"
    text += "v 0 0 0\nv 9 0 0\nv 9 9 0\nf 1/1 2/2 3/3\n"
    assert read(tmp_path, "a.obj", text).notes == told


def test_several_libraries_stand_in_one_line(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (tmp_path / "b.mtl").write_text("newmtl b\nKd 0 0 1\n")
    halves = "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"
    for line in ("mtllib a.mtl b.mtl\n", 'mtllib "a.mtl" b.mtl\n'):
        text = line + "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in SQUARE) + halves
        assert codes(read(tmp_path, "a.obj", text)) == {(255, 0, 0), (0, 0, 255)}


def test_a_material_that_says_nothing_leaves_the_colours_of_vertices(tmp_path):
    text = "mtllib a.mtl\nusemtl a\n" + obj(["0 1 0"] * 4)
    (tmp_path / "a.mtl").write_text("newmtl a\nKd 1 1 1\n")
    reading = read(tmp_path, "a.obj", text)
    assert (codes(reading), reading.notes) == ({(0, 255, 0)}, ())
    (tmp_path / "a.mtl").write_text("newmtl a\nKd 1 0 0\n")
    reading = read(tmp_path, "a.obj", text)
    assert (codes(reading), reading.notes) == ({(255, 0, 0)}, ("left out: vertex colours",))


def test_one_normal_of_no_length_drops_no_others(tmp_path):
    text = "ply\nformat ascii 1.0\nelement vertex 4\n"
    text += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    text += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    for k, (x, y, z) in enumerate(SQUARE):
        text += f"{x} {y} {z} " + ("0 0 0\n" if k == 1 else "0.6 0 0.8\n")
    reading = read(tmp_path, "a.ply", text + "3 0 1 2\n3 0 2 3\n")
    wanted = [(0.6, 0, 0.8), (0, 0, 1), (0.6, 0, 0.8), (0.6, 0, 0.8)]
    np.testing.assert_allclose(reading.mesh.normals, wanted, atol=1e-6)


# -- PLY -----------------------------------------------------------------------------------------


def ply(properties, rows):
    head = f"ply\nformat ascii 1.0\nelement vertex 4\n{properties}element face 2\n"
    head += "property list uchar int vertex_indices\nend_header\n"
    table = "".join(
        f"{x:g} {y:g} {z:g} {row}\n" for (x, y, z), row in zip(SQUARE, rows, strict=True)
    )
    return head + table + "3 0 1 2\n3 0 2 3\n"


XYZ = "property float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize(
    ("properties", "row"),
    [
        ("".join(f"property uchar {c}\n" for c in "rgb"), "200 30 30"),
        ("".join(f"property uchar {c}\n" for c in "rgba"), "200 30 30 255"),
        ("".join(f"property uint {c}\n" for c in ("red", "green", "blue")), "200 30 30"),
        ("".join(f"property uchar {c}\n" for c in ("Red", "Green", "Blue")), "200 30 30"),
        ("".join(f"property ushort {c}\n" for c in ("red", "green", "blue")), "200 30 30"),
        ("property list uchar uchar rgb\n", "3 200 30 30"),
        ("property list uchar uchar colors\n", "4 200 30 30 255"),
    ],
)
def test_columns_and_lists_of_colours(tmp_path, properties, row):
    assert codes(read(tmp_path, "a.ply", ply(XYZ + properties, [row] * 4))) == {RED}


def test_lists_of_colours_of_faces(tmp_path):
    text = ply(XYZ, [""] * 4).replace(
        "vertex_indices\n", "vertex_indices\nproperty list uchar uchar rgba\n"
    )
    text = text.replace("3 0 1 2\n3 0 2 3\n", "3 0 1 2 4 200 30 30 255\n3 0 2 3 4 30 30 200 255\n")
    assert {RED, BLUE} <= codes(read(tmp_path, "a.ply", text))
    assert read(tmp_path, "a.ply", text, texture=False).notes == (FACES,)


def test_gaussian_splats_have_their_first_harmonic_for_a_colour(tmp_path):
    names = "".join(f"property float f_dc_{k}\n" for k in range(3))
    rows = ["1.0 -0.5 100"] * 4
    reading = read(tmp_path, "a.ply", ply(XYZ + names, rows))
    assert codes(reading) == {(199, 92, 255)}  # 0.5 + 0.2821 f_dc, limited to 1
    assert reading.notes == ("its Gaussian splats are taken as points",)


@pytest.mark.parametrize(
    ("properties", "row", "named"),
    [
        ("property uint rgb\n", "13115934", "rgb"),  # packed
        ("property uchar gray\n", "7", "gray"),
        ("property float scalar_Intensity\n", "7", "scalar_Intensity"),
        ("".join(f"property float f_dc_{k}\n" for k in range(2)), "1 2", "f_dc_0, f_dc_1"),
        ("property uchar specular_red\n", "7", "specular_red"),
    ],
)
def test_columns_named_as_colours_that_are_not_read_are_told(tmp_path, properties, row, named):
    reading = read(tmp_path, "a.ply", ply(XYZ + properties, [row] * 4))
    assert len(reading.notes) == 1
    assert str(reading.notes[0]).startswith(f"left out: what it calls {named}")


def test_of_two_kinds_of_colours_one_is_told(tmp_path):
    names = "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    text = ply(XYZ + names, ["1 2 3"] * 4).replace("vertex_indices\n", "vertex_indices\n" + names)
    text = text.replace("3 0 1 2\n3 0 2 3\n", "3 0 1 2 200 30 30\n3 0 2 3 200 30 30\n")
    reading = read(tmp_path, "a.ply", text)
    assert (codes(reading), reading.notes) == ({RED}, ("left out: vertex colours",))


# -- STL, OFF and XYZ ----------------------------------------------------------------------------


def stl(attributes, header=b""):
    body = b"".join(
        struct.pack("<12fH", 0, 0, 1, *SQUARE[corners].ravel(), attribute)
        for corners, attribute in zip(HALVES, attributes, strict=True)
    )
    return header.ljust(80, b" ") + struct.pack("<I", len(HALVES)) + body


def five_bits(low, middle, high):
    return low | middle << 5 | high << 10


@pytest.mark.parametrize(
    ("header", "attributes", "wanted"),
    [
        (b"", [0x8000 | five_bits(0, 0, 31)] * 2, {(255, 0, 0)}),  # VisCAM: blue is lowest
        (b"", [0x8000 | five_bits(31, 0, 0), 0], {(0, 0, 255), (255, 255, 255)}),
        (b"COLOR=\xc8\x1e\x1e\xff", [0x8000] * 2, {RED}),  # Magics: all as the whole
        (b"x COLOR=\xc8\x1e\x1e\xff", [five_bits(31, 0, 0)] * 2, {(255, 0, 0)}),  # red is lowest
        (b"COLOR=\xc8\x1e\x1e\xff", [five_bits(0, 0, 31), 0x8000], {(0, 0, 255), RED}),
    ],
)
def test_both_kinds_of_facet_colours(tmp_path, header, attributes, wanted):
    assert wanted <= codes(read(tmp_path, "a.stl", stl(attributes, header)))
    plain = read(tmp_path, "a.stl", stl(attributes, header), texture=False)
    assert plain.mesh.colours is None
    assert plain.notes == (FACES,)


def test_attributes_that_say_no_colour_say_nothing(tmp_path):
    reading = read(tmp_path, "a.stl", stl([0, 0x7FFF]))
    assert reading.mesh.colours is None
    assert reading.notes == ()


@pytest.mark.parametrize(
    ("tails", "wanted"),
    [
        (["200 30 30", "30 30 200"], {RED, BLUE}),
        (["200 30 30 255", "30 30 200 255"], {RED, BLUE}),
        (["1.0 0.0 0.0", "0.0 0.0 1.0 0.5"], {(255, 0, 0), (0, 0, 255)}),
        (["200 30 30", ""], {RED, (170, 170, 170)}),
    ],
)
def test_colours_of_off_faces(tmp_path, tails, wanted):
    text = "OFF\n4 2 0\n" + "".join(f"{x:g} {y:g} {z:g}\n" for x, y, z in SQUARE)
    text += "".join(
        f"3 {a} {b} {c} {tail}\n" for (a, b, c), tail in zip(HALVES, tails, strict=True)
    )
    assert wanted <= codes(read(tmp_path, "a.off", text))
    assert read(tmp_path, "a.off", text, texture=False).notes == (FACES,)


def test_numbers_of_colours_and_words_of_a_dialect_are_told(tmp_path):
    text = "OFF\n4 2 0\n" + "".join(f"{x:g} {y:g} {z:g}\n" for x, y, z in SQUARE)
    reading = read(tmp_path, "a.off", text + "3 0 1 2 7\n3 0 2 3 8\n")
    assert reading.notes == ("left out: numbers of colours",)
    reading = read(tmp_path, "a.off", text + "3 0 1 2 a b c\n3 0 2 3 a b c\n")
    assert reading.notes == (FACES,)


@pytest.mark.parametrize(
    ("kind", "tail", "has_normals"),
    [
        ("COFF", "200 30 30 255", False),
        ("NCOFF", "200 30 30 255 0 0 1", True),  # MeshLab: colours first
        ("CNOFF", "0 0 1 200 30 30 255", True),  # Geomview: normals first
        ("CSTOFF", "200 30 30 255 .5 .5", False),
        ("NCSTOFF", "200 30 30 255 0 0 1 .5 .5", True),
        ("STCNOFF", "0 0 1 200 30 30 .5 .5", True),
        ("OFF", "200 30 30", False),  # not spoken of, and clear all the same
        ("OFF", "200 30 30 255", False),
    ],
)
@pytest.mark.parametrize("between", ["\n", " "])
def test_attributes_of_off_vertices_in_both_orders(tmp_path, kind, tail, has_normals, between):
    rows = [f"{x:g} {y:g} {z:g} {tail}" for x, y, z in SQUARE]
    if between == " " and kind == "OFF":
        pytest.skip("lines are all that tells how many numbers a vertex has")
    text = between.join([kind, "4 2 0", *rows, "3 0 1 2", "3 0 2 3"]) + "\n"
    mesh = read(tmp_path, "a.off", text).mesh
    assert {tuple(row) for row in mesh.colours.tolist()} == {RED}
    assert (mesh.normals is not None) == has_normals
    if has_normals:
        np.testing.assert_allclose(mesh.normals, [(0, 0, 1)] * 4)


def test_numbers_that_off_does_not_speak_of_are_told(tmp_path):
    rows = "".join(f"{x:g} {y:g} {z:g} .25 .5 7\n" for x, y, z in SQUARE)
    reading = read(tmp_path, "a.off", "OFF\n4 2 0\n" + rows + "3 0 1 2\n3 0 2 3\n")
    assert reading.notes == ("left out: numbers after the places of vertices",)


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ("p", 0), ("pc", 0), ("pca", 0), ("pn", 0), ("pcn", 0), ("pnc", 0), ("pcan", 0),
        ("pnca", 0), ("pa", 1), ("paa", 1),
    ],
)  # fmt: skip
def test_points_with_colours_and_normals_in_any_order(tmp_path, columns, told):
    rng = np.random.default_rng(3)
    ball = rng.normal(size=(200, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    parts = {"p": 10.0 * ball, "n": ball, "c": np.full((200, 3), RED), "a": np.full((200, 1), 255)}
    table = np.concatenate([parts[letter] for letter in columns], axis=1)
    text = "".join(" ".join(f"{x:.9g}" for x in row) + "\n" for row in table)
    reading = read(tmp_path, "a.xyz", text)
    assert (reading.mesh.colours is not None) == ("c" in columns)
    assert (reading.mesh.normals is not None) == ("n" in columns)
    if "c" in columns:
        assert codes(reading) == {RED}
    if "n" in columns:
        np.testing.assert_allclose(reading.mesh.normals, ball, atol=1e-6)
    left = [str(note) for note in reading.notes if "left out" in note]
    assert left == ["left out: numbers after the places of points"] * told


@pytest.mark.parametrize(("line", "told"), [("color 0.8 0.1 0.1\n", True), ("", False)])
def test_colours_of_an_stl_in_text_are_told(tmp_path, line, told):
    corners = "vertex 0 0 0\nvertex 9 0 0\nvertex 9 9 0\n"
    facet = f"facet normal 0 0 1\n{line}outer loop\n{corners}endloop\nendfacet\n"
    reading = read(tmp_path, "a.stl", f"solid color\n{facet}endsolid\n")
    assert reading.notes == ((FACES,) if told else ())


# -- 3MF -----------------------------------------------------------------------------------------


def threemf(attribute, settings=None, each=("", "")):
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    points = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in SQUARE)
    faces = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {attribute} {own}/>'
        for (a, b, c), own in zip(HALVES, each, strict=True)
    )
    model = (
        f'<model xmlns="{core}" xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06"><resources>'
        f'<object id="1"><mesh><vertices>{points}</vertices><triangles>{faces}</triangles></mesh>'
        '</object></resources><build><item objectid="1"/></build></model>'
    )
    kind = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    relations = f'<Relationships><Relationship Type="{kind}" Target="/a.model"/></Relationships>'
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as package:
        package.writestr("_rels/.rels", relations)
        package.writestr("a.model", model)
        if settings is not None:
            package.writestr(*settings)
    return file.getvalue()


@pytest.mark.parametrize("attribute", ["paint_color", "slic3rpe:mmu_segmentation"])
def test_what_was_painted_in_a_slicer_is_told(tmp_path, attribute):
    reading = read(tmp_path, "a.3mf", threemf(f'{attribute}="8"'), texture=False)
    assert reading.notes == ("left out: colours painted in a slicer",)


ORCA = (
    "Metadata/project_settings.config",
    '{"filament_colour": ["#FFFFFF", "#C81E1E", "#1E1EC8"]}',
)
PRUSA = (
    "Metadata/Slic3r_PE.config",
    "; extruder_colour = ;#C81E1E;#1E1EC8\n; filament_colour = #FFFFFF;#000000;#000000\n",
)


@pytest.mark.parametrize(("attribute", "settings"), [
    ("paint_color", ORCA), ("slic3rpe:mmu_segmentation", PRUSA),
])  # fmt: skip
@pytest.mark.parametrize(
    ("code", "colour", "middle"),
    [
        ("8", RED, (6, 3)),
        ("0C", BLUE, (6, 3)),  # the third filament takes two digits
        ("481", RED, (6, 4.5)),  # the edge across from the first corner is halved
        ("485", RED, (4.5, 1.5)),  # from the second
        ("40C9", BLUE, (7.5, 3)),
        ("4482", RED, (7.5, 4.5)),  # two edges
        ("44483", RED, (6, 3)),  # all three: the part in the middle
    ],
)
def test_what_was_painted_in_a_slicer_is_read(tmp_path, attribute, settings, code, colour, middle):
    """Of the triangle (0, 0) (9, 0) (9, 9): where the middle of the only part in a colour lies."""
    raw = read_3mf(threemf(f'{attribute}="{code}"', settings), texture=True)
    assert raw.notes == ()
    faces, colours = raw.corners.reshape(-1, 3), raw.corner_colours.reshape(-1, 3, 3)[:, 0]
    middles = raw.vertices[faces][:, :, :2].mean(axis=1)
    below = middles[(colours == colour).all(axis=1) & (middles[:, 1] < middles[:, 0])]
    np.testing.assert_allclose(below, [middle])


@given(st.lists(st.recursive(st.integers(0, 5), lambda inner: st.tuples(
    st.integers(1, 3), st.integers(0, 2), st.lists(inner, min_size=4, max_size=4)), max_leaves=20,
), min_size=2, max_size=2))  # fmt: skip
@settings(deadline=None, max_examples=examples(60))
def test_what_is_split_beside_another_has_no_crack(trees):
    """Inner edges belong to two triangles, and nothing is lost of the square's area."""

    def written(tree):  # the first digit last
        if isinstance(tree, int):
            return f"{tree << 2:X}" if tree < 3 else f"{tree - 3:X}C"
        split, first, parts = tree
        return "".join(written(part) for part in parts[: split + 1]) + f"{first << 2 | split:X}"

    data = threemf("", ORCA, [f'paint_color="{written(tree)}"' for tree in trees])
    raw = read_3mf(data, texture=True)
    faces = raw.corners.reshape(-1, 3)
    a, b, c = raw.vertices[faces].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a)[:, 2]
    assert areas.sum() == pytest.approx(2 * 81.0)
    assert (areas > 0.0).all()
    edges = {
        tuple(edge)
        for face in faces.tolist()
        for edge in zip(face, np.roll(face, -1).tolist(), strict=True)
    }
    assert len(edges) == 3 * len(faces)
    for p, q in edges:
        if (q, p) not in edges:
            along = raw.vertices[[p, q], :2]
            assert any((along[:, k] == side).all() for k in (0, 1) for side in (0.0, 9.0))


@pytest.mark.parametrize("code", ["x", "3", "81", "C", "4 8"])
def test_a_painting_that_breaks_off_is_refused(tmp_path, code):
    with pytest.raises(MeshError, match="the painting of a triangle is"):
        read(tmp_path, "a.3mf", threemf(f'paint_color="{code}"', ORCA))


def test_filaments_without_a_colour_are_told(tmp_path):
    reading = read(tmp_path, "a.3mf", threemf('paint_color="3C"', ORCA))
    assert reading.notes == ("left out: colours of filaments that its settings do not name",)


@pytest.mark.parametrize(
    "name", ["Metadata/model_settings.config", "Metadata/Slic3r_PE_model.config"]
)
@pytest.mark.parametrize(("extruder", "told"), [("1", False), ("0", False), ("2", True)])
def test_filaments_of_parts_are_told(tmp_path, name, extruder, told):
    settings = f'<config><object id="1"><metadata key="extruder" value="{extruder}"/></object>'
    reading = read(tmp_path, "a.3mf", threemf("", (name, settings + "</config>")))
    assert reading.notes == (("left out: filaments that a slicer gave its parts",) if told else ())


def test_colours_that_are_not_there_are_told(tmp_path):
    reading = read(tmp_path, "a.3mf", threemf('pid="7" p1="0"'))
    assert reading.notes == ("left out: colours of resources that it does not contain",)


# -- COLLADA -------------------------------------------------------------------------------------


def collada(diffuse, more=""):
    def source(name, values, axes):
        named = "".join(f'<param name="{axis}" type="float"/>' for axis in axes)
        n = len(values.split())
        return (
            f'<source id="{name}"><float_array id="{name}a" count="{n}">{values}</float_array>'
            f'<technique_common><accessor source="#{name}a" count="{n // len(axes)}"'
            f' stride="{len(axes)}">{named}</accessor></technique_common></source>'
        )

    return (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>'
        '<library_images><image id="i"><init_from>a%20b.png</init_from></image></library_images>'
        '<library_effects><effect id="e"><profile_COMMON><newparam sid="u"><surface type="2D">'
        '<init_from>i</init_from></surface></newparam><newparam sid="s"><sampler2D><source>u'
        '</source></sampler2D></newparam><technique sid="c"><lambert><diffuse>'
        f"{diffuse}</diffuse></lambert></technique></profile_COMMON></effect></library_effects>"
        '<library_materials><material id="m"><instance_effect url="#e"/></material>'
        '</library_materials><library_geometries><geometry id="g"><mesh>'
        + source("p", "0 0 0 9 0 0 0 9 0", "XYZ")
        + source("t", "0 0 1 0 0 1", "ST")
        + source("k", "1 0 0 1 0 0 1 0 0", "RGB")
        + '<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
        '<triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/>'
        f'<input semantic="TEXCOORD" source="#t" offset="0"/>{more}<p>0 1 2</p></triangles></mesh>'
        '</geometry></library_geometries><library_visual_scenes><visual_scene id="w"><node>'
        '<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s"'
        ' target="#m"/></technique_common></bind_material></instance_geometry></node>'
        '</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#w"/></scene>'
        "</COLLADA>"
    )


TEXTURE = '<texture texture="s" texcoord="x"/>'


def test_collada_has_its_picture_or_says_why_not(tmp_path):
    pytest.importorskip("collada")
    reading = read(tmp_path, "a.dae", collada(TEXTURE))
    missing = "a texture is left out: it refers to 'a%20b.png', which is missing"
    assert reading.notes == (missing,)
    (tmp_path / "a b.png").write_bytes(b"none")
    (note,) = read(tmp_path, "a.dae", collada(TEXTURE)).notes
    assert "is no picture that can be read" in note
    Image.fromarray(np.full((4, 4, 3), RED, np.uint8)).save(tmp_path / "a b.png")
    reading = read(tmp_path, "a.dae", collada(TEXTURE))
    assert (codes(reading), reading.notes) == ({RED}, ())
    assert refers_to(tmp_path / "a.dae", tmp_path / "a b.png")


def test_collada_says_that_colours_of_vertices_are_left_out(tmp_path):
    pytest.importorskip("collada")
    own = '<input semantic="COLOR" source="#k" offset="0"/>'
    reading = read(tmp_path, "a.dae", collada("<color>1 1 1 1</color>", own))
    assert reading.notes == ("left out: vertex colours",)


# -- glTF ----------------------------------------------------------------------------------------


def gltf(nodes=None, required=(), **more):
    places = np.array([(0, 0, 0), (1, 0, 0), (0, 0, 1)], "<f4")
    moves = np.array([(0, 0, 0), (5, 0, 0)], "<f4")
    turns = np.array([(0, 0, 0, 1), (0, np.sqrt(0.5), 0, np.sqrt(0.5))], "<f4")
    uv = np.array([(0.1, 0.5)] * 3, "<f4")
    arrays = [places, moves, turns, uv]
    starts = np.cumsum([0, *(a.nbytes for a in arrays)])
    data = b"".join(a.tobytes() for a in arrays)
    document = {
        "asset": {"version": "2.0"},
        "extensionsRequired": list(required),
        "scenes": [{"nodes": list(range(len(nodes or [0])))}],
        "nodes": nodes or [{"mesh": 0}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 3}, "material": 0}]}
        ],
        "materials": [{}],
        "buffers": [
            {"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(at), "byteLength": a.nbytes}
            for at, a in zip(starts, arrays, strict=False)
        ],
        "accessors": [
            {"bufferView": k, "componentType": 5126, "count": len(a), "type": f"VEC{a.shape[1]}"}
            for k, a in enumerate(arrays)
        ],
        **more,
    }
    return json.dumps(document)


@pytest.mark.parametrize("name", ["EXT_who_knows", "KHR_gaussian_splatting", "MSFT_lod"])
def test_an_extension_that_is_required_and_unknown_is_refused_by_name(tmp_path, name):
    with pytest.raises(MeshError, match=f"it requires the extension '{name}', which is not read"):
        read(tmp_path, "a.gltf", gltf(required=[name]))


def test_extensions_that_are_known_or_of_materials_alone_may_be_required(tmp_path):
    names = ["KHR_mesh_quantization", "KHR_materials_unlit", "KHR_texture_transform"]
    assert read(tmp_path, "a.gltf", gltf(required=names)).mesh.n_faces == 1


def test_an_extension_that_is_only_used_and_unknown_is_told(tmp_path):
    used = ["KHR_texture_transform", "MSFT_lod", "KHR_materials_ior", "EXT_who_knows"]
    reading = read(tmp_path, "a.gltf", gltf(extensionsUsed=used))
    assert reading.notes == ("left out: what the extensions EXT_who_knows, MSFT_lod say",)


def test_a_mesh_that_is_repeated_stands_in_every_place(tmp_path):
    name = "EXT_mesh_gpu_instancing"
    repeated = {name: {"attributes": {"TRANSLATION": 1, "ROTATION": 2}}}
    nodes = [{"mesh": 0, "translation": [0, 2, 0], "extensions": repeated}]
    mesh = read(tmp_path, "a.gltf", gltf(nodes, [name])).mesh
    assert mesh.n_faces == 2
    once = [(0, 0, 2000), (1000, 0, 2000), (0, -1000, 2000)]  # z is up: (x, -z, y), mm
    turned = [(5000, 0, 2000), (5000, 1000, 2000), (6000, 0, 2000)]
    np.testing.assert_allclose(mesh.vertices, once + turned, atol=1e-3)


@pytest.mark.parametrize("writer", ["trimesh", "Open3D"])
def test_vertex_colours_come_as_their_writers_mean_them(tmp_path, writer):
    """The specification says linear; these write the sRGB codes that they have."""
    if writer == "trimesh":
        trimesh = pytest.importorskip("trimesh")
        mesh = trimesh.Trimesh(SQUARE, HALVES, vertex_colors=[(*RED, 255)] * 4, process=False)
        mesh.export(tmp_path / "a.glb")
    else:
        geometry = pytest.importorskip("open3d")
        vector, index = geometry.utility.Vector3dVector, geometry.utility.Vector3iVector
        mesh = geometry.geometry.TriangleMesh(vector(SQUARE), index(HALVES))
        mesh.vertex_colors = vector([np.array(RED) / 255] * 4)
        geometry.io.write_triangle_mesh(str(tmp_path / "a.glb"), mesh)
    reading = read_surface(tmp_path / "a.glb", ReadOptions())
    assert codes(reading) == {RED}
    assert reading.notes == (f"its vertex colours are taken as sRGB, as {writer} writes them",)


def with_attributes(**attributes):
    there = {"POSITION": 0, "TEXCOORD_0": 3, **attributes}
    return gltf(meshes=[{"primitives": [{"attributes": there, "material": 0}]}])


@pytest.mark.parametrize(
    ("document", "told"),
    [
        (with_attributes(COLOR_1=0), "what it calls COLOR_1"),
        (with_attributes(_COLOR=0, _RGBA_0=0), "what it calls _COLOR, _RGBA_0"),
        (
            gltf([{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {
                "attributes": {"TRANSLATION": 1, "_COLOR_0": 0}}}}]),
            "what it calls _COLOR_0",
        ),
        (
            gltf(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "extensions": {
                "KHR_materials_variants": {"mappings": [{"material": 0, "variants": [0]}]}}}]}]),
            "variants of its materials",
        ),
        (gltf(scenes=[{"nodes": [0]}, {"nodes": [0]}]), "scenes other than the default one"),
    ],
)  # fmt: skip
def test_what_of_a_gltf_is_not_shown_is_told(tmp_path, document, told):
    assert read(tmp_path, "a.gltf", document).notes == (f"left out: {told}",)


def test_what_needs_no_light_is_shown_as_it_is(tmp_path):
    document = gltf(materials=[{"extensions": {"KHR_materials_unlit": {}}}])
    assert read(tmp_path, "a.gltf", document).notes == ()


def test_hidden_parts_are_left_out_with_what_hangs_on_them(tmp_path):
    hidden = {"KHR_node_visibility": {"visible": False}}
    nodes = [{"mesh": 0}, {"extensions": hidden, "mesh": 0, "children": [2]}, {"mesh": 0}]
    document = gltf(nodes, scenes=[{"nodes": [0, 1]}])
    reading = read(tmp_path, "a.gltf", document)
    assert reading.mesh.n_faces == 1
    assert reading.notes == ("left out: hidden parts",)


def test_specular_materials_have_their_diffuse_colour(tmp_path):
    glossy = {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0, 0, 1]}}
    document = gltf(materials=[{"extensions": glossy}])
    reading = read(tmp_path, "a.gltf", document)
    assert codes(reading) == {(255, 0, 0)}
    assert reading.notes == ()
    glossy["KHR_materials_pbrSpecularGlossiness"]["specularGlossinessTexture"] = {"index": 0}
    reading = read(tmp_path, "a.gltf", gltf(materials=[{"extensions": glossy}]))
    assert reading.notes == ("left out: metal and gloss from a picture",)


def textured(texture):
    file = io.BytesIO()
    Image.fromarray(np.full((4, 4, 3), RED, np.uint8)).save(file, "WEBP", lossless=True)
    uri = "data:image/webp;base64," + base64.b64encode(file.getvalue()).decode()
    surface = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    return gltf(materials=[surface], textures=[texture], images=[{"uri": uri}])


def test_webp_pictures_are_read(tmp_path):
    texture = {"extensions": {"EXT_texture_webp": {"source": 0}}}
    assert codes(read(tmp_path, "a.gltf", textured(texture))) == {RED}


def test_pictures_in_another_packing_are_told(tmp_path):
    texture = {"extensions": {"KHR_texture_basisu": {"source": 0}}}
    reading = read(tmp_path, "a.gltf", textured(texture))
    why = "it is packed by KHR_texture_basisu, which is not read"
    assert reading.notes == (f"a texture is left out: {why}",)

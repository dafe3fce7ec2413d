"""Formats that trimesh reads for us, in the child process, with our checks after it."""

import io
import struct
import zipfile

import numpy as np
import pytest
import trimesh

from paint3d.errors import MeshError
from paint3d.files.load import MESH_SUFFIXES, load_mesh, read_mesh
from paint3d.files.readers import read_foreign
from paint3d.files.readers.read_foreign import FOREIGN
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

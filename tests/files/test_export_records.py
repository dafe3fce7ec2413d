"""The paper's record format: nine numbers, seven numbers, and bad lines by number."""

import gzip
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.cli import main
from paint3d.errors import InputError, MeshError
from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.files.formats.records import pack_normals, read_records, unpack_normals, write_records
from paint3d.files.load import load_mesh, read_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface


def sample(n=200):
    rng = np.random.default_rng(5)
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return rng.uniform(-300, 300, (n, 3)), normals, rng.integers(0, 256, (n, 3)).astype(np.uint8)


@pytest.mark.parametrize("packed", [False, True])
def test_round_trip(tmp_path, packed):
    vertices, normals, srgb = sample()
    path = tmp_path / "a.p3d.txt"
    write_records(path, vertices, normals, srgb, initial_position=(10, -5, 0.25), packed=packed)
    back = read_records(path)
    np.testing.assert_allclose(back.vertices, vertices, atol=6e-5)
    np.testing.assert_array_equal(back.srgb, srgb)
    assert back.initial_position.tolist() == [10, -5, 0.25]
    turned = np.linalg.norm(back.normals - normals, axis=1)
    assert turned.max() < (np.radians(1.0) if packed else 1e-5)


def test_the_example_of_the_paper(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("InitialPosition={1, 0, 0}\n{172, 205, 309, 22, 30, 42, 39}.\n")
    back = read_records(path)
    assert back.vertices.tolist() == [[173, 205, 309]]
    assert back.srgb.tolist() == [[30, 42, 39]]
    assert np.linalg.norm(back.normals) == pytest.approx(1.0)


def test_the_file_names_its_columns(tmp_path):
    vertices, normals, srgb = sample(1)
    write_records(tmp_path / "a.txt", vertices, normals, srgb)
    lines = (tmp_path / "a.txt").read_text().splitlines()
    assert lines[0] == "# columns {x, y, z, nx, ny, nz, R, G, B}, mm and sRGB codes"
    assert lines[1] == "InitialPosition={0, 0, 0}"
    assert lines[2].count(",") == 8


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("# x\n", "expected InitialPosition="),
        ("{1, 2, 3}\n", "expected InitialPosition="),
        ("InitialPosition={0, 0, 1e}\n{1}\n", "line 1: a coordinate is not a number"),
        ("InitialPosition={0, 0, 0}\n", "it has no rows"),
        ("InitialPosition={0, 0, 0}\n{1, 2, 3}\n", "line 2: '{1, 2, 3}'; expected"),
        ("InitialPosition={0, 0, 0}\n{1,2,3,4,5,6,7}\n{1,2,3,4,5,6,7\n", "line 3: "),
        ("InitialPosition={0, 0, 0}\n{1,2,3,4,5,6,7}\n{1,2,3,4,5,6,7,8,9}\n", "line 3: "),
        ("InitialPosition={0, 0, 0}\n# x\n{1,2,3,4,5,6,256}\n", "line 3: .* RGB codes from 0 to"),
        ("InitialPosition={0, 0, 0}\n{1,2,3,x,5,6,7}\n", "has 'x' where a number"),
        ("InitialPosition={0, 0, 0}\n{1,2,3,,5,6,7}\n", "a number is missing"),
        ("InitialPosition={0, 0, 0}\n{1,2,3,0,0,0,5,6,7}\n", "a normal has length 0"),
        ("InitialPosition={0, 0, 0}\n{1,2,3,70000,5,6,7}\n", "packed normal is out of range"),
    ],
)
def test_bad_lines(tmp_path, text, message):
    path = tmp_path / "a.txt"
    path.write_text(text)
    with pytest.raises(MeshError, match=message) as caught:
        read_records(path)
    assert str(path) in str(caught.value)


WATCHED = """
import sys
from paint3d.errors import MeshError
from paint3d.files import read_records
try:
    read_records(sys.argv[1])
except MeshError as cause:
    print(cause)
with open("/proc/self/status") as told:
    print(next(line for line in told if line.startswith("VmHWM")).split()[1])
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is not told here")
def test_records_that_unpack_to_much_take_no_memory_of_the_program(tmp_path):
    path = tmp_path / "bomb.p3d.txt.gz"
    with gzip.open(path, "wb", compresslevel=1) as file:
        for _ in range(20):
            file.write(bytes(10 << 20))
    told = [sys.executable, "-c", WATCHED, str(path)]
    done = subprocess.run(told, capture_output=True, text=True, check=True)
    cause, highest = done.stdout.splitlines()
    assert cause.startswith(f"{path}: ")
    assert int(highest) < 200 * 1024  # kB; the file holds as much


def test_bad_arrays_and_files(tmp_path):
    vertices, normals, srgb = sample(3)
    with pytest.raises(InputError, match="normals has shape"):
        write_records(tmp_path / "a.txt", vertices, normals[:2], srgb)
    assert not (tmp_path / "a.txt").exists()
    with pytest.raises(MeshError, match="cannot read it"):
        read_records(tmp_path / "a.txt")


@settings(deadline=None, max_examples=60)
@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_packing_a_normal_turns_it_by_less_than_a_degree(vector):
    normal = np.array([vector]) / np.linalg.norm(vector)
    code = pack_normals(normal)
    assert 0 <= code[0] <= 65535
    assert (unpack_normals(code) @ normal.T).item() > np.cos(np.radians(1.0))


def painted(tmp_path, suffix=".p3d.txt", **options):
    """A bowl's records with two colours, and the mesh that they are of."""
    mesh = load_mesh("bowl")
    codes = np.full((mesh.n_vertices, 3), 238, np.uint8)
    codes[::3] = (51, 20, 9)
    moved = TriangleMesh(mesh.vertices + np.array([100.0, -20.0, 7.5]), mesh.faces, codes)
    export(moved, tmp_path / f"a{suffix}", ExportOptions(**options))
    return moved, load_mesh(tmp_path / f"a{suffix}")


def test_records_are_read_back_as_the_mesh_that_was_written(tmp_path):
    mesh, back = painted(tmp_path)
    np.testing.assert_array_equal(back.faces, mesh.faces)
    np.testing.assert_array_equal(back.colours, mesh.colours)
    np.testing.assert_allclose(back.vertices, mesh.vertices, atol=6e-5)
    written = read_records(tmp_path / "a.p3d.txt").normals
    assert np.einsum("ij,ij->i", back.normals, written).min() > 0.999999
    surface = PaintedSurface(back)
    own = surface.paint_mesh.source_vertices
    np.testing.assert_array_equal(surface.srgb[: len(own)], mesh.colours[own])
    export(back, tmp_path / "b.p3d.txt")
    again, first = load_mesh(tmp_path / "b.p3d.txt"), back
    np.testing.assert_array_equal(again.vertices, first.vertices)
    np.testing.assert_array_equal(again.faces, first.faces)


def test_the_initial_position_is_where_the_object_stands(tmp_path):
    painted(tmp_path)
    assert "InitialPosition={100, -20, 7.5}" in (tmp_path / "a.p3d.txt").read_text()


def test_a_reader_of_the_papers_format_passes_the_faces_over(tmp_path):
    mesh, _ = painted(tmp_path, packed_normals=True)
    lines = (tmp_path / "a.p3d.txt").read_text().splitlines()
    assert len([line for line in lines if line.startswith("{")]) == mesh.n_vertices


def test_the_papers_own_list_of_vertices_becomes_a_surface(tmp_path):
    mesh, _ = painted(tmp_path)
    text = (tmp_path / "a.p3d.txt").read_text()
    (tmp_path / "bare.p3d.txt.gz").write_bytes(
        gzip.compress(text[: text.index("# faces")].encode())
    )
    reading = read_mesh(tmp_path / "bare.p3d.txt.gz")
    assert "point cloud" in reading.notes[0]
    np.testing.assert_array_equal(reading.mesh.colours, mesh.colours)
    assert reading.mesh.n_faces > 0.9 * mesh.n_faces
    with pytest.raises(MeshError, match=r"points but no triangles; expected a surface"):
        load_mesh(tmp_path / "bare.p3d.txt.gz", from_points=False)


def test_a_bad_face_is_named_with_its_line(tmp_path):
    path = tmp_path / "a.p3d.txt"
    row = "InitialPosition={0, 0, 0}\n{0,0,0,0,0,1,9,9,9}\n"
    path.write_text(row + "# faces {a, b, c}, rows from 0\n#{0, 0, 1}\n")
    with pytest.raises(MeshError, match=r"a\.p3d\.txt: line 4: '#\{0, 0, 1\}'; expected a face"):
        load_mesh(path)
    many = path.with_name("b.p3d.txt")
    many.write_text(row + "# faces {a, b, c}, rows from 0\n#{0, 0, " + "9" * 5000 + "}\n")
    with pytest.raises(MeshError, match=r"line 4: .*; expected a face"):
        read_records(many)
    with pytest.raises(MeshError, match=r"the suffix '\.txt' is not known; .*\.p3d\.txt"):
        load_mesh(path.rename(tmp_path / "a.txt"))


def test_a_command_takes_records_for_a_mesh(tmp_path, capsys):
    mesh, _ = painted(tmp_path)
    records, out = str(tmp_path / "a.p3d.txt"), tmp_path / "b.ply"
    assert main.main(["export", records, str(out), "--quiet"]) == 0
    np.testing.assert_array_equal(load_mesh(out).colours, mesh.colours)
    assert main.main(["export", records, str(tmp_path / "b.p3d"), "--quiet"]) == 2
    assert "is a mesh, which no session is made of" in capsys.readouterr().err

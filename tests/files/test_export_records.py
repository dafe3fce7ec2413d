"""The paper's record format: nine numbers, seven numbers, and bad lines by number."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.errors import InputError, MeshError
from paint3d.files.project.records import pack_normals, read_records, unpack_normals, write_records


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
        ("InitialPosition={0, 0, 1e}\n{1}\n", "a.txt:1: a coordinate is not a number"),
        ("InitialPosition={0, 0, 0}\n", "it has no rows"),
        ("InitialPosition={0, 0, 0}\n{1, 2, 3}\n", "a.txt:2: '{1, 2, 3}'; expected"),
        ("InitialPosition={0, 0, 0}\n{1,2,3,4,5,6,7}\n{1,2,3,4,5,6,7\n", "a.txt:3: "),
        ("InitialPosition={0, 0, 0}\n{1,2,3,4,5,6,7}\n{1,2,3,4,5,6,7,8,9}\n", "a.txt:3: "),
        ("InitialPosition={0, 0, 0}\n# x\n{1,2,3,4,5,6,256}\n", "a.txt:3: .* RGB codes from 0 to"),
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

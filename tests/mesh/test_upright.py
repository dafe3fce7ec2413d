"""Own objects stand up: which way is up is said, guessed or left alone, and turning is exact."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from paint3d.errors import UnknownNameError
from paint3d.files.export import export
from paint3d.files.load import load_mesh, read_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import UP_AXES, guess_up, turn_mesh, turn_up
from paint3d.view.preview import Preview
from tests.support.cases import long_but

CORPUS = Path(__file__).parents[2] / "../shared/corpus"


def jug() -> TriangleMesh:
    """A closed bottle with a flat foot, standing along z."""
    turn = np.linspace(0, 2 * np.pi, 25)[:-1]
    rings = [(20, 0), (20, 40), (8, 60), (8, 80)]
    points = [(r * np.cos(t), r * np.sin(t), z) for r, z in rings for t in turn]
    k = np.arange(24)
    after = (k + 1) % 24
    faces = []
    for ring in range(3):
        a, b, c, d = k + 24 * ring, after + 24 * ring, after + 24 * ring + 24, k + 24 * ring + 24
        faces += [np.column_stack([a, b, c]), np.column_stack([a, c, d])]
    points += [(0, 0, 0), (0, 0, 80)]
    faces.append(np.column_stack([after, k, np.full(24, 96)]))
    faces.append(np.column_stack([k + 72, after + 72, np.full(24, 97)]))
    return TriangleMesh(np.array(points, float), np.concatenate(faces), name="jug")


def lying(mesh: TriangleMesh, up: str) -> TriangleMesh:
    """The mesh turned so that its z points along an axis."""
    return turn_mesh(mesh, turn_up(up).T)


@pytest.mark.parametrize("up", UP_AXES)
def test_a_quarter_turn_is_a_rotation_and_exact(up: str) -> None:
    turn = turn_up(up)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    axis = np.zeros(3)
    axis["xyz".index(up[-1])] = -1.0 if up[0] == "-" else 1.0
    np.testing.assert_array_equal(turn @ axis, [0, 0, 1])
    mesh = load_mesh("vase")
    back = turn_mesh(turn_mesh(mesh, turn), turn.T)
    np.testing.assert_array_equal(back.vertices, mesh.vertices)
    assert turn_mesh(mesh, np.eye(3)) is mesh
    assert turn_mesh(mesh, turn, 2.0).area == pytest.approx(4.0 * mesh.area, rel=1e-5)


@pytest.mark.parametrize("up", UP_AXES)
def test_what_stands_on_a_flat_foot_is_stood_on_it(up: str) -> None:
    guess = guess_up(lying(jug(), up))
    assert guess.sure
    assert guess.up == up


@pytest.mark.parametrize(
    ("name", "up"),
    long_but([("bowl", "y"), ("bowl", "-z"), ("plate", "z"), ("plate", "-x")],
             product(("bowl", "plate"), UP_AXES)),
)  # fmt: skip
def test_what_is_hollow_opens_to_the_top(name: str, up: str) -> None:
    guess = guess_up(lying(load_mesh(name), up))
    assert guess.up == up


def test_where_nothing_tells_it_is_not_sure() -> None:
    ball = load_mesh("sphere")
    assert not guess_up(ball).sure
    tetrahedron = TriangleMesh(
        np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float),
        np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]),
    )
    assert not guess_up(tetrahedron).sure


def test_up_is_kept_given_or_guessed_on_loading(tmp_path: Path) -> None:
    path = tmp_path / "jug.ply"
    export(lying(jug(), "y"), path)
    stored = read_mesh(path)
    assert not stored.knows_up
    assert np.ptp(stored.mesh.vertices, axis=0).argmax() == 1  # as it always was
    for up in ("y", "auto"):
        mesh = load_mesh(path, up=up)
        np.testing.assert_array_equal(mesh.vertices, jug().vertices)
    assert read_mesh(path, up="auto").notes[-1].startswith("y is taken for up")
    np.testing.assert_array_equal(
        load_mesh(path, up="-y").vertices[:, 2], -jug().vertices[:, 2] + 0.0
    )
    with pytest.raises(UnknownNameError, match="up axis"):
        load_mesh(path, up="w")


def test_a_format_that_says_so_is_believed(tmp_path: Path) -> None:
    export(jug(), tmp_path / "jug.glb")
    reading = read_mesh(tmp_path / "jug.glb", up="auto")
    assert reading.knows_up
    np.testing.assert_allclose(reading.mesh.vertices, jug().vertices, atol=1e-4)
    assert np.ptp(load_mesh(tmp_path / "jug.glb", up="z").vertices, axis=0).argmax() == 1


def test_a_preview_shows_the_object_as_it_would_stand() -> None:
    preview = Preview(jug(), 80)
    ground = preview.draw(np.eye(3))[0, 0]

    def box(turn: np.ndarray) -> np.ndarray:
        light = preview.draw(turn).astype(int)
        there = np.abs(light - ground.astype(int)).max(axis=2) > 12
        return np.array([np.ptp(np.flatnonzero(there.any(axis=k))) for k in (0, 1)])

    stands, lies = box(np.eye(3)), box(turn_up("y"))
    assert stands[1] > 1.3 * stands[0]  # higher than it is wide
    assert lies[1] < 1.1 * lies[0]


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus is not here")
@pytest.mark.parametrize(
    ("name", "up"),
    [
        ("trimesh/bunny.ply", "y"),
        ("trimesh/rabbit.obj", "y"),
        ("assimp/spider.obj", "y"),
        ("trimesh/teapot.stl", "z"),
        ("trimesh/noimg.obj", "z"),
        ("trimesh/featuretype.3MF", "z"),
    ],
)
def test_objects_of_others_are_stood_up(name: str, up: str) -> None:
    guess = guess_up(load_mesh(CORPUS / name))
    assert (guess.up, guess.sure) == (up, True)

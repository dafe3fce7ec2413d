"""A score of a bowl, painted again on the same bowl meshed anew: strokes lie where they lay."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from paint3d.app.model.document import Document
from paint3d.app.model.score import playing
from paint3d.app.model.score.playing import begun, painted
from paint3d.cli.main import main
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.likeness import digest_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, load_score, save_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import same_vertices
from tests.support.cases import long_but

RESOLUTION_MM = 0.5
MOST_MM = 0.5  # off where it was
PLAIN = """{"format": "paint3d-recording", "version": 1}
{"time_ns": 0, "position": [0, 0, 60], "orientation": [1, 0, 0, 0], "pressure": 0.3}
{"time_ns": 8000000, "position": [1, 0, 60], "orientation": [1, 0, 0, 0], "pressure": 0.3}
"""


@cache
def bowl() -> TriangleMesh:
    return load_mesh("bowl")


def stroke(angles, heights, meant: bool, n: int = 30) -> list:
    """A stroke around the outside of the bowl; by the place that is meant, or the root's."""
    around = np.linspace(*angles, n)
    out = [120.0 * np.cos(around), 120.0 * np.sin(around), np.linspace(*heights, n)]
    return held_at(np.column_stack(out), meant)


def held_at(places: np.ndarray, meant: bool) -> list:
    """A stroke along the places (n, 3) of the bowl that are nearest, the brush upright on it."""
    found, n = ClosestPoints(bowl()).find(places), len(places)
    up = found.normals
    turns = np.column_stack([1.0 + up[:, 2], -up[:, 1], up[:, 0], np.zeros(n)])
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    pressure = np.full(n, 0.45)
    pressure[[0, -1]] = 0.0
    samples = Recording(
        8_000_000 * np.arange(n), found.points + 30.0 * up, turns, pressure,
        contact=found.points if meant else None,
    )  # fmt: skip
    return [{"do": "begin_stroke"}, samples, {"do": "end_stroke"}]


@cache
def score() -> Score:
    """Strokes with a mask of a region and an angle, and one with a mirror image."""
    outside = ClosestPoints(bowl()).find(np.array([[120.0, 0.0, 30.0]])).points[0].tolist()
    mask = {"do": "set_mask", "regions": [{"at": outside, "up_to": "crease", "degrees": 40}],
            "angle": {"direction": [1, 0, 0.2], "degrees": 50}}  # fmt: skip
    mirror = {"do": "set_symmetry", "planes": [{"point": [0, 0, 0], "normal": [0, 1, 0]}]}
    events = (
        *stroke((-0.5, 0.2), (22, 38), True), mask, *stroke((0.2, 1.2), (44, 30), False),
        {"do": "set_mask"}, mirror, *stroke((2.0, 2.5), (26, 40), True),
    )  # fmt: skip
    return Score({"object": "bowl", "resolution_mm": RESOLUTION_MM}, events)


@cache
def first(of=score) -> Document:
    return painted(of(), bowl())


def over_the_rim(around: float, slant: float, n: int = 40) -> list:
    """A stroke up the bowl's outside, over its rim and down inside."""
    way = np.linspace(-12.0, 12.0, n)
    at, beside = around + slant * way / 75.0, np.where(way < 0.0, 80.0, 66.0)
    return held_at(
        np.column_stack([beside * np.cos(at), beside * np.sin(at), 68.0 - np.abs(way)]), True
    )


@cache
def rim() -> Score:
    """Along the rim, on it, and over it, the place being meant."""
    strokes = (
        stroke((0.3, 0.8), (61, 65), True), stroke((1.5, 2.0), (68, 63), True),
        over_the_rim(2.8, 0.3), over_the_rim(3.5, -0.7), stroke((4.2, 4.7), (66, 66), True),
    )  # fmt: skip
    return Score(score().header, tuple(event for one in strokes for event in one))


def subdivided() -> TriangleMesh:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(bowl().vertices, bowl().faces, process=False).subdivide()
    return TriangleMesh(mesh.vertices, mesh.faces)


def decimated(share: int = 3) -> TriangleMesh:
    open3d = pytest.importorskip("open3d")
    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(bowl().vertices.astype(float)),
        open3d.utility.Vector3iVector(np.array(bowl().faces)),
    )
    mesh = mesh.simplify_quadric_decimation(bowl().n_faces // share)
    return TriangleMesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles))


def halved() -> TriangleMesh:
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData.from_regular_faces(bowl().vertices.astype(float), bowl().faces)
    mesh = mesh.decimate(0.5)
    return TriangleMesh(mesh.points, mesh.regular_faces)


def shifted() -> TriangleMesh:
    """Its vertices lie elsewhere on the bowl, as where it is sampled anew."""
    mesh, chance = bowl(), np.random.default_rng(5)
    places = mesh.vertices + chance.normal(0.0, 0.12, mesh.vertices.shape)
    return TriangleMesh(ClosestPoints(bowl()).find(places).points, mesh.faces)


def inked(document: Document) -> np.ndarray:
    return inked_of(document.surface)


def inked_of(surface: PaintedSurface) -> np.ndarray:
    return surface.paint_mesh.vertices[surface.coverage > 0.0].astype(float)


def check_places(of, mesh: TriangleMesh, resolution: float) -> None:
    one, other = inked(first(of)), inked(painted(of(), mesh, resolution))
    off = [cKDTree(b).query(a)[0] for a, b in ((one, other), (other, one))]
    for distances in off:
        print(f"median {np.median(distances):.3f} mm, worst {distances.max():.3f} mm")
        assert np.median(distances) <= 0.5 * MOST_MM
        assert distances.max() <= MOST_MM


@pytest.mark.parametrize(
    ("mesh", "resolution"),
    [(subdivided, 0.5), pytest.param(decimated, 0.4, marks=pytest.mark.long),
     pytest.param(decimated, 0.5, marks=pytest.mark.long), (bowl, 0.3)],
    ids=["subdivided", "decimated", "decimated, as fine", "finer paint"],
)  # fmt: skip
def test_strokes_lie_where_they_lay(mesh, resolution) -> None:
    check_places(score, mesh(), resolution)


@pytest.mark.parametrize(
    ("mesh", "resolution"),
    long_but(
        [(decimated, 0.5), (shifted, 0.3), (bowl, 0.7)],
        [(subdivided, 0.5), (decimated, 0.5), (shifted, 0.3), (bowl, 0.7), (decimated, 0.3),
         (halved, 0.4), (bowl, 0.3)],
    ),
)  # fmt: skip
def test_strokes_over_the_rim_lie_where_they_lay(mesh, resolution) -> None:
    check_places(rim, mesh(), resolution)


def test_the_rim_needs_what_was_painted_on(monkeypatch) -> None:
    """Without it they do not: or what is above would say nothing of it."""
    monkeypatch.setattr(playing, "_original", lambda *_: None)
    with pytest.raises(AssertionError):
        check_places(rim, decimated(), 0.3)


def test_on_the_object_that_it_was_painted_on_nothing_is_taken_over() -> None:
    assert first().surface.original is None
    plain = PaintedSurface(bowl(), RESOLUTION_MM)
    np.testing.assert_array_equal(
        plain.paint_mesh.arrays.sheet_pack, first().surface.paint_mesh.arrays.sheet_pack
    )


def without_normals(mesh: TriangleMesh) -> TriangleMesh:
    return TriangleMesh(mesh.vertices, mesh.faces, name=mesh.name)


def test_a_mesh_that_only_lost_its_normals_takes_them_over() -> None:
    """Its own are computed of the triangles, and lean otherwise on the rim."""
    bare = painted(rim(), without_normals(bowl()))
    same_vertices(bare.surface, first(rim).surface)


def test_a_file_that_is_called_like_a_built_in_object_is_none() -> None:
    """What was painted on it is painted on it again to the bit, by its score's header."""
    own = decimated()
    own = TriangleMesh(own.vertices, own.faces, name="bowl")
    header = {**rim().header, "object": "another"}
    document = painted(Score(header, rim().events), own)
    assert document.surface.original is None
    again = painted(document.score, own)
    assert again.surface.original is None
    same_vertices(document.surface, again.surface)
    finer = begun(document.score, own, 0.4).surface.original  # its own mesh is what it was
    assert finer is not None
    assert finer.mesh is own
    assert begun(document.score, bowl()).surface.original is None
    assert begun(first(rim).score, own).surface.original is not None


def test_another_file_than_was_painted_on_is_warned_of(caplog) -> None:
    for given, n in ((bowl(), 0), (without_normals(bowl()), 1)):
        begun(first(rim).score, decimated(), painted_on=given)
        assert sum("not to the bit" in one.message for one in caplog.records) == n


def test_an_object_that_was_changed_stands_for_itself_there() -> None:
    """Half of the bowl grows by a tenth: its other half is the bowl's still."""
    vertices = bowl().vertices.copy()
    grown = vertices[:, 0] > 0.0
    vertices[grown, 0] *= 1.1
    surface = painted(score(), TriangleMesh(vertices, bowl().faces)).surface
    assert surface.original is not None
    off = ClosestPoints(TriangleMesh(vertices, bowl().faces)).find(inked_of(surface)).points
    np.testing.assert_allclose(off, inked_of(surface), atol=0.01)
    sphere = painted(score(), load_mesh("sphere"), 0.5).surface
    assert sphere.original is None


def test_a_session_and_its_score_know_what_was_painted_on(tmp_path) -> None:
    document = painted(rim(), decimated(), 0.4)
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    of_bowl = {"object": "bowl", "mesh": digest_of(bowl()), "resolution_mm": 0.5}
    for one in (document, again):
        assert one.score.header["painted_on"] == of_bowl
        assert one.score.header["mesh"] == digest_of(decimated())
    first, second = document.surface.paint_mesh.arrays, again.surface.paint_mesh.arrays
    np.testing.assert_array_equal(first.sheet_pack, second.sheet_pack)
    for one in (document, again):
        for event in stroke((5.2, 5.6), (64, 67), True):
            one.feed(list(event.samples())) if isinstance(event, Recording) else getattr(
                one, event["do"]
            )()
    same_vertices(document.surface, again.surface)
    played = painted(document.score, decimated(), painted_on=bowl())
    same_vertices(document.surface, played.surface)


@pytest.mark.long
@pytest.mark.parametrize("resolution", [0.3, 0.4, 0.5])
@pytest.mark.parametrize("share", [2, 3])
def test_strokes_over_the_rim_lie_where_they_lay_however_coarse(share, resolution) -> None:
    check_places(rim, decimated(share), resolution)


def test_a_mask_and_a_mirror_do_what_they_did() -> None:
    """They hold something back and paint something, or what is above would say nothing of them."""
    plain = Score(score().header, tuple(
        e for e in score().events
        if isinstance(e, Recording) or e["do"] not in ("set_mask", "set_symmetry")
    ))  # fmt: skip
    without, of_all = inked(painted(plain, bowl())), inked(first())
    far = cKDTree(of_all).query(without)[0]
    assert (far > 2.0).sum() > 100
    assert (cKDTree(without).query(of_all)[0] > 2.0).sum() > 100


def test_the_command_is_told_what_it_was_painted_on(tmp_path, capsys) -> None:
    """A file of the bowl has another name than the score's object, which is none of ours."""
    file, out = tmp_path / "a.score.jsonl", tmp_path / "a.p3d"
    save_score(Score({**rim().header, "object": "jar"}, rim().events), file)
    for name, mesh in (("jar.obj", bowl()), ("coarse.obj", decimated())):
        normals = np.empty((0, 3)) if mesh.normals is None else mesh.normals
        form = "f {0} {1} {2}" if mesh.normals is None else "f {0}//{0} {1}//{1} {2}//{2}"
        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices]
        lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in normals]
        lines += [form.format(*face) for face in mesh.faces + 1]
        (tmp_path / name).write_text("\n".join(lines) + "\n")
    words = ["replay", str(file), "--on", str(tmp_path / "coarse.obj"), "--out", str(out)]
    assert main([*words, "--painted-on", str(tmp_path / "jar.obj"), "--quiet"]) == 0
    again = load_session(out)
    assert again.surface.original is not None
    jar, coarse = load_mesh(tmp_path / "jar.obj"), load_mesh(tmp_path / "coarse.obj")
    same_vertices(again.surface, painted(load_score(file), coarse, painted_on=jar).surface)
    (tmp_path / "b.jsonl").write_text(PLAIN)
    words = ["replay", str(tmp_path / "b.jsonl"), "--on", "bowl", "--out", str(out), "--force"]
    assert main([*words, "--painted-on", "bowl"]) == 2
    assert "is no whole painting" in capsys.readouterr().err

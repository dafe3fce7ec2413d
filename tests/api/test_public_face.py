"""What `import paint3d` gives to programs: names, examples of docstrings, strokes, writing."""

from __future__ import annotations

import doctest
import inspect
import json
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.calligraphy.kanjivg import find_kanjivg
from paint3d.errors import InputError, MeshError

needs_glyphs = pytest.mark.skipif(find_kanjivg() is None, reason="kanjivg is not installed")


@pytest.fixture
def painter() -> paint3d.Painter:
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6)
    return paint3d.Painter(surface, brush="slender", ink="pine soot")


def extent(surface: paint3d.PaintedSurface) -> tuple[np.ndarray, np.ndarray]:
    points = surface.mesh.vertices[surface.painted]
    return points.min(axis=0), points.max(axis=0)


def test_the_names_are_those_for_users() -> None:
    assert set(dir(paint3d)) == set(paint3d.__all__)
    wanted = {"Painter", "PaintedSurface", "load_mesh", "load_recording", "save_recording",
              "load_brush", "load_material", "DeviceSample", "export"}  # fmt: skip
    assert wanted <= set(dir(paint3d))
    for name in dir(paint3d):
        found = getattr(paint3d, name)
        assert inspect.getdoc(found), name


@needs_glyphs
@pytest.mark.parametrize("module", ["paint3d", "paint3d.api.painter", "paint3d.painter.painter"])
def test_examples_of_docstrings_run(module: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = doctest.testmod(import_module(module))
    assert found.attempted > 3
    assert found.failed == 0


@pytest.mark.parametrize(
    "name",
    ["PaintedSurface", "TriangleMesh", "export", "load_brush", "load_material", "load_mesh",
     "save_recording", "save_session"],
)  # fmt: skip
def test_what_everybody_uses_has_an_example_that_runs(name: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (found,) = doctest.DocTestFinder(recurse=False).find(getattr(paint3d, name), name)
    told = doctest.DocTestRunner().run(found)
    assert told.attempted > 1
    assert told.failed == 0


def test_a_stroke_lies_along_its_points(painter: paint3d.Painter) -> None:
    recording = painter.stroke([(-20, 0, 0), (20, 0, 0)], pressure=0.4, speed=40.0)
    assert recording.duration_s == pytest.approx(1.0)
    low, high = extent(painter.surface)
    assert low[0] == pytest.approx(-20.0, abs=6.0)
    assert high[0] == pytest.approx(20.0, abs=6.0)
    assert abs(low[1] + high[1]) < 1.0  # as wide to the left as to the right


def test_pressure_is_spread_along_a_stroke(painter: paint3d.Painter) -> None:
    painter.stroke([(-30, 0, 0), (30, 0, 0)], pressure=(0.1, 0.8))
    points = painter.surface.mesh.vertices[painter.surface.painted]
    thin, thick = (np.ptp(points[np.abs(points[:, 0] - x) < 3.0, 1]) for x in (-20.0, 20.0))
    assert thick > 1.5 * thin


def test_a_handle_that_leans_leaves_another_mark() -> None:
    marks = []
    for tilt in (0.0, 45.0):
        surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6)
        line = paint3d.Painter(surface, "slender").stroke([(-15, 0, 0), (15, 0, 0)], 0.4, tilt)
        up = 1.0 - 2.0 * (line.orientation[:, 1:3] ** 2).sum(axis=1)  # z of the pen's z axis
        np.testing.assert_allclose(up, np.cos(np.radians(tilt)), atol=1e-6)
        marks.append(surface.coverage.sum())
    assert marks[0] != marks[1]


def test_places_go_around_an_object() -> None:
    surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=1.0)
    painter = paint3d.Painter(surface, "slender")
    painter.stroke([(0.3, 0.6), (0.7, 0.6)], 0.4)
    points = surface.mesh.vertices[surface.painted]
    angles = np.degrees(np.arctan2(points[:, 0], -points[:, 1]))
    assert np.ptp(angles) == pytest.approx(144.0, abs=15.0)


def test_the_name_of_a_file_is_no_recording(painter: paint3d.Painter) -> None:
    with pytest.raises(InputError, match=r"load_recording\(FILE\)"):
        painter.replay("poses.csv")


def test_a_stroke_is_replayed_to_the_bit(painter: paint3d.Painter, tmp_path: Path) -> None:
    recording = painter.stroke([(-20, 5, 0), (0, -5, 0), (20, 5, 0)], (0.0, 0.6, 0.0), 20.0)
    paint3d.save_recording(recording, tmp_path / "a.jsonl")
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6)
    again = paint3d.Painter(surface, brush="slender", ink="pine soot")
    again.replay(recording)
    np.testing.assert_array_equal(surface.srgb, painter.surface.srgb)
    header = json.loads((tmp_path / "a.jsonl").read_text("utf-8").splitlines()[0])
    assert (header["brush"], header["object"]) == ("slender", "plane")


@pytest.mark.parametrize(
    ("points", "options", "words"),
    [
        ([(0, 0, 0)], {}, "1 points that are apart; expected two"),
        ([(0, 0, 0), (0, 0, 0)], {}, "1 points that are apart"),
        ([(0,), (1,)], {}, r"points have shape \(2, 1\)"),
        ("here", {}, "points have shape"),
        ([(0, 0, 0), (9, 0, 0)], {"pressure": 2.0}, "pressure is 2"),
        ([(0, 0, 0), (9, 0, 0)], {"pressure": (0.1, 2.0)}, "pressure is 0.1 to 2; expected 0 to 1"),
        ([(0, 0, 0), (9, 0, 0)], {"tilt": 80.0}, "tilt .degrees. is 80"),
        ([(0, 0, 0), (9, 0, 0)], {"speed": 0.0}, "speed"),
        ([(0.5, 0.5), (1.5, 0.5)], {}, "u is 1.0"),
    ],
)
def test_strokes_that_are_refused(painter: paint3d.Painter, points, options, words) -> None:
    with pytest.raises(InputError, match=words):
        painter.stroke(points, **options)
    assert not painter.surface.painted.any()


@needs_glyphs
def test_writing_drawing_and_a_seal_lie_where_they_are_asked_for(
    painter: paint3d.Painter, tmp_path: Path
) -> None:
    written = painter.write("一", at=(0.5, 0.8), size=25)
    assert [one["text"] for one in written.header["characters"]] == ["一"]
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10">'
        '<path d="M1 5 L9 5" stroke="black" fill="none"/></svg>'
    )
    painter.draw(tmp_path / "a.svg", at=(0.5, 0.5), size=30)
    held = painter.in_brush()
    assert painter.seal("一", at=(0.5, 0.2), size=12) > 0.9
    assert painter.in_brush() == held
    account = painter.ledger()
    kept = sum(account.values()) - account["loaded"]
    assert kept == pytest.approx(account["loaded"], rel=1e-5)
    points = painter.surface.mesh.vertices[painter.surface.painted]
    low, high = painter.surface.source.bounds
    v = (points[:, 1] - low[1]) / (high[1] - low[1])
    for at in (0.8, 0.5, 0.2):
        assert (np.abs(v - at) < 0.1).any()
    assert not (np.abs(v - 0.65) < 0.02).any()


def test_copying_a_photograph_that_is_none_is_refused(painter, tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_text("none")
    with pytest.raises(InputError, match=r"a\.jpg"):
        painter.copy(tmp_path / "a.jpg")


VERTICES = np.array([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)], float)
FACES = np.array([(0, 1, 2), (0, 2, 3)])


def meshes() -> list[object]:
    trimesh = pytest.importorskip("trimesh")
    pyvista = pytest.importorskip("pyvista")
    open3d = pytest.importorskip("open3d")
    o3d, core = open3d, open3d.core
    return [
        (VERTICES, FACES),
        (VERTICES.tolist(), FACES.tolist()),
        paint3d.TriangleMesh(VERTICES, FACES),
        trimesh.Trimesh(VERTICES, FACES, process=False),
        pyvista.PolyData.from_regular_faces(VERTICES, FACES),
        pyvista.PolyData(VERTICES, [4, 0, 1, 2, 3]),  # a square
        o3d.geometry.TriangleMesh(
            o3d.utility.Vector3dVector(VERTICES), o3d.utility.Vector3iVector(FACES)
        ),
        o3d.t.geometry.TriangleMesh(core.Tensor(VERTICES), core.Tensor(FACES)),
    ]


def test_a_surface_takes_what_others_hold_a_mesh_in() -> None:
    for found in meshes():
        source = paint3d.PaintedSurface(found, None).source
        assert source.area == pytest.approx(81.0)
        if not isinstance(found, paint3d.TriangleMesh):
            assert paint3d.load_mesh(found).area == pytest.approx(81.0)
    assert paint3d.load_mesh((VERTICES, FACES), unit="cm").area == pytest.approx(8100.0)


@pytest.mark.parametrize("found", [3, "bowl", (VERTICES,), (VERTICES, FACES, 1), None])
def test_what_holds_no_mesh_is_named(found: object) -> None:
    with pytest.raises(MeshError, match=r"expected \(vertices, faces\), or a mesh of"):
        paint3d.PaintedSurface(found)


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (VERTICES[:, :2], FACES, "vertices"),
        (VERTICES, FACES + 2, "vertex"),
        (np.full((4, 3), np.nan), FACES, "finite"),
    ],
)
def test_arrays_that_are_no_mesh_are_refused(vertices, faces, words) -> None:
    for take in (paint3d.PaintedSurface, paint3d.load_mesh):
        with pytest.raises(MeshError, match=words):
            take((vertices, faces))


def test_a_strokes_pressures_are_met_and_joined_without_a_kink() -> None:
    painter = paint3d.Painter(paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=2.0))
    told = (0.1, 0.5, 0.2, 0.05)
    pressure = painter.stroke([(-30, 0, 0), (30, 0, 0)], pressure=told).pressure
    ends = np.linspace(0, len(pressure) - 1, len(told)).round().astype(int)
    assert pressure[ends] == pytest.approx(told, abs=0.01)
    assert pressure.max() <= 0.5 + 1e-12
    assert pressure.min() >= 0.05 - 1e-12
    turns = np.abs(np.diff(pressure, 2))
    assert turns.max() < 5.0 * np.median(turns[turns > 0])  # straight lines: 100 times and more

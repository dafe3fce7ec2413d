"""Laws of strokes whose samples say which place on the surface is meant, wherever the root is."""

import gzip
import json
import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush_engine.footprint import ink_way, make_stamp
from paint3d.core.quaternion import multiply_quaternions, quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.errors import RecordingError
from paint3d.files.load import load_mesh
from paint3d.files.project import journal as journals
from paint3d.files.project.journal import Journal, read_journal
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.flat_input import lay
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.examples import examples
from tests.support.resampling import resample

MS = 1_000_000
OLD_SAMPLE = [
    ("time_ns", "<i8"), ("position", "<f8", 3), ("orientation", "<f8", 4), ("pressure", "<f8"),
    ("buttons", "<i4"), ("object_position", "<f8", 3), ("object_orientation", "<f8", 4),
]  # fmt: skip


def stroke(places, normals, leans, pressures, header=None):
    """A recording of places on a surface, 8 ms apart; the root is where it cannot be of use."""
    n = len(places)
    z = normals + leans
    z /= np.linalg.norm(z, axis=1)[:, None]
    back = -np.gradient(places, axis=0)
    back -= (back * normals).sum(axis=1)[:, None] * normals
    x = back - ((back * z).sum(axis=1) / (normals * z).sum(axis=1))[:, None] * normals
    x /= np.linalg.norm(x, axis=1)[:, None]
    turn = quaternions_from_matrices(np.stack([x, np.cross(z, x), z], axis=-1))
    return Recording(
        8 * MS * np.arange(n), np.full((n, 3), 7e3), turn, pressures, contact=places,
        header=header or {},
    )  # fmt: skip


def painted(recording, mesh="plane", resolution=1.0, **options):
    surface = PaintedSurface(load_mesh(mesh), resolution, "porcelain")
    painter = Painter(surface, "full", "pine soot", **options)
    painter.replay(recording)
    return surface, painter


def ink_of(surface):
    return surface.amounts.sum(axis=1) * surface.vertex_areas


def line(lean=(0.0, 0.0, 0.0), n=40, pressure=0.3, length=60.0):
    places = np.zeros((n, 3))
    places[:, 0] = np.linspace(-0.5 * length, 0.5 * length, n)
    pressures = np.full(n, pressure)
    pressures[[0, -1]] = 0.0
    return stroke(places, np.tile([0.0, 0.0, 1.0], (n, 1)), np.tile(lean, (n, 1)), pressures)


@given(st.floats(0.0, 60.0), st.floats(0.0, 2.0 * np.pi), st.floats(0.05, 0.5))
@settings(deadline=None, max_examples=examples(25))
def test_the_mark_lies_under_the_pen_however_it_leans(tilt, toward, pressure):
    lean = np.tan(np.radians(tilt)) * np.array([np.cos(toward), np.sin(toward), 0.0])
    upright, _ = painted(line(pressure=pressure))
    surface, _ = painted(line(lean, pressure=pressure))
    ink, points = ink_of(surface), surface.paint_mesh.vertices
    assert abs((ink * points[:, 1]).sum() / ink.sum()) < 0.1
    inner = (np.abs(points[:, 0]) < 20.0) & (ink > 0.0)
    assert abs(points[inner, 1].max() + points[inner, 1].min()) < 1.0  # of vertices 1 mm apart
    assert ink.sum() == pytest.approx(ink_of(upright).sum(), rel=0.15)


@given(st.floats(0.0, 180.0), st.floats(0.05, 0.5))
@settings(deadline=None, max_examples=examples(25))
def test_the_mark_lies_under_the_pen_however_it_is_turned(degrees, pressure):
    recording = line(pressure=pressure)
    half = np.radians(0.5 * degrees)
    roll = np.tile([np.cos(half), 0.0, 0.0, np.sin(half)], (len(recording), 1))
    turned = multiply_quaternions(recording.orientation, roll)
    surface, _ = painted(replace(recording, orientation=turned), resolution=0.5)
    inner = (np.abs(surface.paint_mesh.vertices[:, 0]) < 20.0) & (ink_of(surface) > 0.0)
    across = surface.paint_mesh.vertices[inner, 1]
    assert abs(across.max() + across.min()) < 1.0  # twice the middle


def test_a_lean_to_the_side_of_the_bend_is_no_limit_of_the_tilt():
    lean = np.tan(np.radians(70.0))
    _, aside = painted(line((0.0, lean, 0.0)), resolution=2.0)
    _, forward = painted(line((lean, 0.0, 0.0)), resolution=2.0)
    assert aside.report()["tilt_limited"] == 0
    assert forward.report()["tilt_limited"] > 0


@pytest.mark.parametrize("hairs", [0, 100])
def test_inside_the_bowl_nothing_is_missing_and_nothing_lies_elsewhere(hairs):
    mesh = load_mesh("bowl")
    near = ClosestPoints(mesh)
    for lean in ((0.0, 0.0, 0.0), (0.6, -0.3, 0.1)):
        way = np.stack([np.linspace(-45, 45, 60), np.full(60, 8.0), np.full(60, 300.0)], axis=1)
        hits = near.cast(way, np.tile([0.0, 0.0, -1.0], (60, 1)))
        assert hits.hit.all()
        found = near.find(hits.points)
        pressures = np.full(60, 0.25)
        pressures[[0, -1]] = 0.0
        recording = stroke(found.points, found.normals, np.tile(lean, (60, 1)), pressures)
        surface, painter = painted(recording, "bowl", 1.0, hairs=hairs)
        points = surface.paint_mesh.vertices[ink_of(surface) > 0.0]
        away = np.linalg.norm(points[:, None] - found.points[None], axis=2).min(axis=1)
        assert away.max() < 15.0
        gaps = np.linalg.norm(points[:, None] - found.points[None, 3:-3], axis=2).min(axis=0)
        assert gaps.max() < 1.5
        assert painter.ledger()["off_surface"] < 0.05 * ink_of(surface).sum()


def extruded(profile, length=100.0, step=4.0):
    """A surface over a line in x and z (N, 2), as long along y, mm; its front is to the left."""
    profile = np.asarray(profile, float)
    ys = np.arange(-0.5 * length, 0.5 * length + step, step)
    vertices = np.array([[x, y, z] for y in ys for x, z in profile])
    n = len(profile)
    first = np.array([k * n + i for k in range(len(ys) - 1) for i in range(n - 1)])
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + n], axis=1),
            np.stack([first + 1, first + n + 1, first + n], axis=1),
        ]
    )
    return TriangleMesh(vertices, faces)


def painted_on(mesh, places, lean=(0.0, 0.0, 0.0), pressure=0.25):
    """What a stroke leaves over those places of a mesh: the vertices with ink, and the way."""
    found = ClosestPoints(mesh).find(np.asarray(places, float))
    pressures = np.full(len(places), pressure)
    pressures[[0, -1]] = 0.0
    leans = np.tile(lean, (len(places), 1))
    surface = PaintedSurface(mesh, 0.6, "porcelain")
    recording = stroke(found.points, found.normals, leans, pressures)
    Painter(surface, "full", "pine soot").replay(recording)
    return surface.paint_mesh.vertices[ink_of(surface) > 0.0].astype(float), found.points


def test_a_ridge_beside_the_brush_stays_clean():
    """Its rounded top looks away from the brush: carried along its normals it lies under it."""
    turn = np.linspace(np.pi, 0.0, 9)
    top = np.stack([6.0 + 2.0 * np.cos(turn), 8.0 + 2.0 * np.sin(turn)], axis=1)
    mesh = extruded([(-40.0, 0.0), (0.0, 0.0), (4.0, 0.0), *top, (8.0, 0.0), (40.0, 0.0)])
    way = np.stack([np.zeros(50), np.linspace(-25.0, 25.0, 50), np.zeros(50)], axis=1)
    inked, _ = painted_on(mesh, way)
    assert inked[:, 2].max() < 3.0
    inner = inked[np.abs(inked[:, 1]) < 15.0]
    assert abs(inner[:, 0].min() + inner[:, 0].max()) < 1.2  # twice the middle


def test_the_plane_is_that_of_the_surface_under_the_footprint():
    """The tuft's sphere holds more of the slopes beside a ledge than of the ledge."""
    mesh = extruded([(-10.0, 40.0), (0.0, 0.0), (12.0, 0.0), (14.0, -8.0), (24.0, -48.0)])
    surface = PaintedSurface(mesh, 0.6, "porcelain")
    painter = Painter(surface, "full", "pine soot")
    for x in (4.0, 6.0, 8.0):
        place = (x, 1.0, 0.0)
        contact = painter.contact((x, 1.0, 30.0), (1.0, 0.0, 0.0, 0.0), 0.25, place)
        np.testing.assert_allclose(contact.normal, (0.0, 0.0, 1.0), atol=0.1)
    contact = painter.contact((12.0, 1.0, 30.0), (1.0, 0.0, 0.0, 0.0), 0.25, (12.0, 1.0, 0.0))
    assert 0.4 < contact.normal[2] < 0.95  # half of each face


def test_a_hasty_stroke_stays_on_its_side_of_a_thin_wall():
    """Its places lie 36 mm and 120 ms apart, and what is between them 2.4 of 3.1 mm in the wall."""
    mesh = load_mesh("bowl")
    near = ClosestPoints(mesh)
    turn = np.radians(np.arange(0.0, 130.0, 30.0))
    eye = 300.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1) + [0.0, 0.0, 50.0]
    hits = near.cast(eye, -eye * [1.0, 1.0, 0.0])
    found = near.find(hits.points)
    pressures = np.full(len(turn), 0.25)
    quick = stroke(found.points, found.normals, 0.0 * found.normals, pressures)
    surface, _ = painted(replace(quick, time_ns=15 * quick.time_ns), "bowl", 1.0)
    ink, mesh = ink_of(surface), surface.paint_mesh
    outward = (mesh.normals * mesh.vertices * [1.0, 1.0, 0.0]).sum(axis=1) > 0.0
    assert ink.sum() > 100.0
    assert ink[~outward].sum() < 0.001 * ink.sum()


def test_a_lift_where_the_brush_stands_draws_no_dot():
    """Whatever time it takes: the ink of a stroke is that of the stroke."""
    n = 40
    moving = line(n=n)
    places = np.concatenate([moving.contact[:-1], np.tile(moving.contact[-2], (12, 1))])
    places[n - 1 :, 0] += 1e-9 * np.arange(1, 13)  # a way for the tangent
    pressures = np.concatenate([moving.pressure[:-1], np.linspace(0.3, 0.0, 12)])
    normals = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    stays, _ = painted(stroke(places, normals, 0.0 * normals, pressures))
    pressures[n - 1 :] = 0.3
    pressures[-1] = 0.0
    jumps, _ = painted(stroke(places, normals, 0.0 * normals, pressures))
    assert ink_of(stays).sum() == pytest.approx(ink_of(jumps).sum(), rel=1e-3)


def test_ink_is_given_for_the_way_on_and_not_for_leaving():
    small, large = make_stamp(), make_stamp()
    for stamp, half in ((small, 2.0), (large, 5.0)):
        stamp.values["tip"], stamp.values["heel"] = half, -half
        stamp.values["bend"], stamp.values["cross"] = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        stamp.values["widest"], stamp.values["centred"] = 0.4 * half, 1.0
    assert ink_way(large, small) == 0.0
    large.values["pressure"] = 0.1  # a light touch
    assert ink_way(small, large) == pytest.approx(0.75)
    large.values["pressure"] = 0.5
    assert ink_way(small, large) == pytest.approx(3.0)
    small.values["foot"] = (2.0, 0.0, 0.0)  # the place moves
    assert ink_way(large, small) == pytest.approx(2.0)


def test_live_samples_give_the_bits_of_the_replay():
    recording = line((0.4, 0.3, 0.0))
    whole, _ = painted(recording)
    live = PaintedSurface(load_mesh("plane"), 1.0, "porcelain")
    painter = Painter(live, "full", "pine soot")
    samples = list(recording.samples())
    for k in range(0, len(samples), 7):
        painter.advance(samples[k : k + 7])
    painter.finish()
    np.testing.assert_array_equal(live.amounts, whole.amounts)
    np.testing.assert_array_equal(live.srgb, whole.srgb)


def mixed():
    """A stroke that means places, and one that does not."""
    one = line(n=8)
    contact = np.concatenate([one.contact, np.full((8, 3), np.nan)])
    return Recording(
        8 * MS * np.arange(16), np.tile(one.position, (2, 1)), np.tile(one.orientation, (2, 1)),
        np.tile(one.pressure, 2), contact=contact,
    )  # fmt: skip


@pytest.mark.parametrize("suffix", [".jsonl", ".csv", ".jsonl.gz"])
def test_files_keep_the_places(tmp_path, suffix):
    recording = mixed()
    save_recording(recording, tmp_path / f"a{suffix}")
    back = load_recording(tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(back.contact, recording.contact)
    means = [sample.contact is not None for sample in back.samples()]
    assert means == [True] * 8 + [False] * 8


def test_places_in_other_units_are_mm_too(tmp_path):
    path = tmp_path / "a.jsonl"
    save_recording(line(n=4), path)
    head, *rest = path.read_text().splitlines()
    head = {**json.loads(head), "units": "cm"}
    path.write_text("\n".join([json.dumps(head), *rest]))
    np.testing.assert_allclose(load_recording(path).contact, 10.0 * line(n=4).contact)


def test_journals_and_sessions_keep_the_places(tmp_path):
    recording = mixed()
    with Journal(tmp_path / "a.p3dj", {}) as journal:
        journal.append(recording.samples())
    back, loss = read_journal(tmp_path / "a.p3dj")
    assert not loss
    np.testing.assert_array_equal(back.contact, recording.contact)
    surface = PaintedSurface(load_mesh("plane"), 4.0, "porcelain")
    header = {"brush": "full"}
    strokes = (line(n=8), Recording(**{**vars(line(n=4)), "contact": None, "header": header}))
    save_session(Session(surface, (recording,), {}, strokes), tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    np.testing.assert_array_equal(session.recordings[0].contact, recording.contact)
    np.testing.assert_array_equal(session.strokes[0].contact, strokes[0].contact)
    assert session.strokes[1].contact is None


def test_a_journal_from_before_places_opens(tmp_path):
    path = tmp_path / "a.p3dj"
    Journal(path, {}).close()
    old = np.zeros(3, OLD_SAMPLE)
    old["time_ns"], old["orientation"] = (1, 2, 3), (1.0, 0.0, 0.0, 0.0)
    old["object_orientation"], old["pressure"] = (1.0, 0.0, 0.0, 0.0), 0.5
    content = old.tobytes()
    crc = zlib.crc32(content, zlib.crc32(b"S" + len(content).to_bytes(4, "little")))
    head = journals.BLOCK.pack(b"S", len(content), crc)
    data = path.read_bytes()
    closing = len(data) - journals.BLOCK.size
    path.write_bytes(data[:closing] + head + content + data[closing:])
    back, loss = read_journal(path)
    assert not loss
    assert len(back) == 3
    assert back.contact is None


def test_another_rate_keeps_the_places():
    again = resample(line(n=40), 333.0)
    np.testing.assert_allclose(again.contact[:, 1:], 0.0, atol=1e-12)
    assert (np.diff(again.contact[:, 0]) > 0.0).all()
    assert again.contact[-1, 0] == pytest.approx(30.0)


class _Tilted:
    """A chart of a plane that leans."""

    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, 0.8, 0.6]])

    def points(self, xy):
        return np.pad(xy, ((0, 0), (0, 1))) @ self.turn.T

    def tangents(self, xy):
        return np.broadcast_to(self.turn, (len(xy), 3, 3))


def test_a_pad_that_is_laid_on_an_object_means_where_its_pen_was():
    n = 5
    position = np.stack([np.arange(n), np.ones(n), 2.0 * np.ones(n)], axis=1)
    pad = {"header": {"space": "pad"}, "orientation": np.tile([1.0, 0, 0, 0], (n, 1))}
    laid = lay(Recording(np.arange(n), position, pressure=np.ones(n), **pad), _Tilted())
    np.testing.assert_allclose(laid.contact, _Tilted().points(position[:, :2]))
    assert lay(Recording(np.arange(n), position, **pad), _Tilted()).contact is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contact": np.zeros((3, 3))}, "shape"),
        ({"contact": np.array([[0, 0, np.inf]] * 4)}, "finite"),
        ({"contact": np.array([[0, np.nan, 0]] * 4)}, "finite"),
        ({"contact": np.zeros((4, 3)), "pressure": None}, "without a pressure"),
    ],
)
def test_places_that_are_none_are_refused(changes, words):
    with pytest.raises(RecordingError, match=words):
        Recording(**{**vars(line(n=4)), **changes})


@pytest.mark.parametrize(
    ("sample", "words"),
    [
        ({"contact": [0, 0]}, "expected 3 numbers"),
        ({"contact": [0, 0, 0], "pressure": None}, "without a pressure"),
        ({"contakt": [0, 0, 0]}, "expected 'contact'"),
    ],
)
def test_bad_places_in_files_are_named(tmp_path, sample, words):
    path = tmp_path / "a.jsonl.gz"
    one = {"time_ns": 0, "position": [0, 0, 0], "orientation": [1, 0, 0, 0], "pressure": 0.5}
    one = {key: value for key, value in {**one, **sample}.items() if value is not None}
    lines = [json.dumps({"format": "paint3d-recording", "version": 1}), json.dumps(one)]
    path.write_bytes(gzip.compress("\n".join(lines).encode()))
    with pytest.raises(RecordingError, match=words):
        load_recording(path)

"""Sessions: what is saved comes back to the bit, old files open, and no file does harm."""

import dataclasses
import errno
import io
import json
import os
import struct
import subprocess
import sys
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.colour.pigments import WATER, Pigment, load_pigment
from paint3d.device.recorded import Recording
from paint3d.errors import ExportError, InputError, SessionError
from paint3d.files.project import session as sessions
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.mesh.refined_mesh import refinement_log, repeat_refinement
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface import state as states
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import restore_surface, surface_state
from tests.support.surface_cases import UPRIGHT, flat, poses, sheet

DATA = Path(__file__).parents[1] / "data"
LANDING = np.array([0.0, 0.1, 0.3, 0.4, 0.4, 0.3, 0.1, 0.0])


def stroke(x=-15.0, header=None):
    n = len(LANDING)
    points = np.column_stack([np.linspace(x, x + 30.0, n), np.zeros((n, 2))])
    made = poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), LANDING, tilt=UPRIGHT)
    return made if header is None else Recording(made.time_ns, made.position, made.orientation,
                                                 made.pressure, header=header)  # fmt: skip


def painted(mesh=None, resolution=0.8):
    """A surface with paint that dried, wet paint over part of it, water, and refined vertices."""
    surface = PaintedSurface(mesh or sheet(flat, (40.0, 40.0), 5.0), resolution, "xuan")
    Painter(surface, "full", "pine soot").replay(stroke())
    surface.dry()
    Painter(surface, "slender", "cinnabar").replay(stroke(-5.0))
    water = surface.column_of(WATER)
    surface.ink.amounts[7, water] = 0.25
    surface.touch(np.array([7], np.int32))
    return surface


def creased_mesh():
    """A box with colours: its corners are split into vertices with a normal each."""
    corners = np.array([[x, y, z] for x in (-40, 40) for y in (-40, 40) for z in (-9, 0)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = [face for a, b, c, d in quads for face in ([a, b, c], [a, c, d])]
    codes = (np.arange(24).reshape(8, 3) * 9 + 20).astype(np.uint8)
    return TriangleMesh(corners, faces, codes, "chest")


def same(one: PaintedSurface, two: PaintedSurface) -> None:
    np.testing.assert_array_equal(two.srgb, one.srgb)
    np.testing.assert_array_equal(two.amounts, one.amounts)
    np.testing.assert_array_equal(two.coverage, one.coverage)
    assert two.ink.load.tolist() == one.ink.load.tolist()
    assert two.ink.off_surface.tolist() == one.ink.off_surface.tolist()
    assert two.dry_ink() == one.dry_ink()
    assert two.wet_ink() == one.wet_ink()
    for got, was in zip(two.export_arrays(), one.export_arrays(), strict=True):
        np.testing.assert_array_equal(got, was)


@pytest.mark.parametrize("mesh", [None, creased_mesh()])
def test_a_saved_session_comes_back_to_the_bit(tmp_path, mesh):
    surface = painted(mesh)
    recordings = (stroke(), stroke(-5.0, {"brush": "slender", "note": "\u7b2c\u4e8c"}))
    settings = {"brush": "slender", "numbers": [1, 2.5, None]}
    save_session(Session(surface, recordings, settings), tmp_path / "a.p3d")
    opened = load_session(tmp_path / "a.p3d")
    same(surface, opened.surface)
    assert opened.settings == settings
    for got, was in zip(opened.recordings, recordings, strict=True):
        for column in sessions.SAMPLES:
            np.testing.assert_array_equal(getattr(got, column), getattr(was, column))
        assert got.header == was.header
    save_session(opened, tmp_path / "b.p3d")
    assert (tmp_path / "b.p3d").read_bytes() == (tmp_path / "a.p3d").read_bytes()


def test_painting_goes_on_where_it_was_saved(tmp_path):
    surface = painted()
    save_session(Session(surface), tmp_path / "a.p3d")
    again = load_session(tmp_path / "a.p3d").surface
    for one in (surface, again):
        Painter(one, "full", "indigo").replay(stroke(-20.0))
    same(surface, again)


def loaded_brush(painter):
    """What a brush looks like half way: dipped twice, with a stroke behind it."""
    painter.dip({"pine soot": 0.3, "water": 0.7})
    painter.dip("cinnabar", reach=0.25)
    painter.replay(stroke())


def rinsed_brush(painter):
    painter.dip("cinnabar")
    painter.rinse()


@pytest.mark.parametrize("habit", [loaded_brush, rinsed_brush])
def test_the_brush_lies_there_as_it_was_left(tmp_path, habit):
    surface = PaintedSurface(sheet(flat, (40.0, 40.0), 5.0), 0.8, "xuan")
    first = Painter(surface, "full", "indigo", pickup=0.05)
    habit(first)
    save_session(Session(surface), tmp_path / "a.p3d")
    again = load_session(tmp_path / "a.p3d").surface
    assert again.ink.transfer.tolist() == surface.ink.transfer.tolist()
    second = Painter(again, "full", ink=None)
    accounts = second.ledger()
    assert accounts["loaded"] == pytest.approx(
        sum(accounts[name] for name in ("in_brush", "wet", "dry", "off_surface")), abs=1e-12
    )
    for painter in (first, second):
        painter.replay(stroke(-20.0))
    same(surface, again)
    assert again.ink.reservoirs.tolist() == surface.ink.reservoirs.tolist()


@pytest.mark.parametrize("n_reservoirs", [1, 3])
def test_accounts_of_the_brush_may_be_less_than_nothing_by_rounding(tmp_path, n_reservoirs):
    """They are sums: a brush painted dry may be left with -1e-17, and a mask gives back."""
    surface = painted(None)
    ink = surface.ink
    reservoirs = np.full((n_reservoirs, len(ink.load)), -1e-17)
    surface.ink = ink._replace(reservoirs=reservoirs)
    ink.load[:], ink.off_surface[:] = reservoirs.sum(axis=0), -250.0
    save_session(Session(surface), tmp_path / "a.p3d")
    again = load_session(tmp_path / "a.p3d").surface
    for name in ("load", "off_surface", "reservoirs"):
        np.testing.assert_array_equal(getattr(again.ink, name), getattr(surface.ink, name))
    ink.load[:] = reservoirs[:] = -1.0
    save_session(Session(surface), tmp_path / "b.p3d")
    with pytest.raises(SessionError, match="load holds -1 to -1; expected -1e-06 to 1e"):
        load_session(tmp_path / "b.p3d")


def test_a_brush_that_never_saw_ink_has_none_to_take_up():
    with pytest.raises(InputError, match="never had any; expected an ink"):
        Painter(PaintedSurface(sheet(flat, (40.0, 40.0), 5.0), 0.8), ink=None)


@pytest.mark.parametrize("paint_between", [False, True])
def test_water_goes_on_where_it_was_saved(tmp_path, paint_between):
    surface = PaintedSurface(sheet(flat, (40.0, 40.0), 5.0), 0.8, "xuan")
    Painter(surface, "full", "pine soot").replay(stroke())
    surface.diffuse(0.5)
    if paint_between:
        Painter(surface, "full", "cinnabar").replay(stroke(-20.0))
    save_session(Session(surface), tmp_path / "a.p3d")
    again = load_session(tmp_path / "a.p3d").surface
    assert again.flow.water == surface.flow.water > 0.0
    save_session(Session(again), tmp_path / "b.p3d")
    assert (tmp_path / "b.p3d").read_bytes() == (tmp_path / "a.p3d").read_bytes()
    for one in (surface, again):
        one.diffuse(2.0)
    same(surface, again)
    assert again.flow.water == surface.flow.water


@pytest.mark.parametrize("pieces", [0, 1, 2, 5])
def test_water_is_followed_beside_a_hand_as_where_it_was_saved(tmp_path, pieces):
    """Beside a hand few blocks are opened at a time, not counting those where water has been."""
    surface = PaintedSurface(sheet(flat, (100.0, 100.0), 5.0), 1.0, "xuan")
    for y in (-20.0, 0.0, 20.0):
        Painter(surface, "full", "pine soot").replay(stroke(y))
    for _ in range(pieces):
        surface.follow_flow(0.05)
    if pieces == 1:
        assert len(surface.open_blocks()) >= 6
        assert len(surface.flow.waiting)
    save_session(Session(surface), tmp_path / "a.p3d")
    again = load_session(tmp_path / "a.p3d").surface
    save_session(Session(again), tmp_path / "b.p3d")
    assert (tmp_path / "b.p3d").read_bytes() == (tmp_path / "a.p3d").read_bytes()
    for _ in range(8):
        for one in (surface, again):
            one.follow_flow(0.05)
        assert again.flow.water == surface.flow.water > 0.0
    same(surface, again)


def test_blocks_beside_water_are_known_again_where_they_were_known_before(tmp_path):
    """Where all is dry too: whether water gets in there is asked of all that stands around."""
    surface = PaintedSurface(sheet(flat, (100.0, 100.0), 5.0), 1.0, "xuan")
    for start in (-40.0, 0.0):
        Painter(surface, "full", "pine soot").replay(stroke(start))
        surface.diffuse(0.5)
        if start < 0.0:
            surface.dry()
    save_session(Session(surface), tmp_path / "a.p3d")
    again = load_session(tmp_path / "a.p3d").surface
    again.diffuse(0.1)
    graph = again.flow_graph
    vertices, depths = again.flow.depths()
    wet = np.unique(graph.block_of(vertices[depths > 0.0]))
    runs = zip(graph.first_beside[wet], graph.last_beside[wet], strict=True)
    beside = np.setdiff1d(np.concatenate([graph.beside[a:b] for a, b in runs]), wet)
    known = beside[graph.was_open[beside]]
    assert len(known) > 0
    assert graph.block_open[known].all()


def test_water_of_older_files_goes_on_in_even_steps():
    mesh = sheet(flat, (40.0, 40.0), 5.0)
    surface = PaintedSurface(mesh, 0.8, "xuan")
    Painter(surface, "full", "pine soot").replay(stroke())
    surface.diffuse(0.5)
    state = {k: v for k, v in surface_state(surface).items() if k != "flow_owed"}
    rim = np.zeros(len(state["flow_vertices"]), np.uint8)
    old = state | {"version": 4, "flow_rim": rim, "flow_order": state["flow_vertices"][:5]}
    again = restore_surface(mesh, old | {"flow_pace": np.array([0.2])})
    assert again.flow.water == surface.flow.water > 0.0
    assert again.flow.patience == pytest.approx(0.2)
    for pace, message in (
        (0.0, "flow_pace is 0"),
        (-1.0, "flow_pace holds -1"),
        ([1.0, 2.0], "flow_pace"),
    ):
        with pytest.raises(SessionError, match=message):
            restore_surface(mesh, old | {"flow_pace": np.atleast_1d(pace)})


def test_water_of_files_without_fine_pigment_goes_on_and_loses_nothing():
    mesh = sheet(flat, (40.0, 40.0), 5.0)
    surface = PaintedSurface(mesh, 0.8, "xuan")
    Painter(surface, "full", {"pine soot": 0.3, "cinnabar": 0.4, "water": 0.3}).replay(stroke())
    surface.diffuse(0.5)
    state = {k: v for k, v in surface_state(surface).items() if k != "flow_fine"}
    again = restore_surface(mesh, state)
    laid = again.wet_ink() + again.dry_ink()
    kept = again.flow.keep()
    np.testing.assert_allclose(kept["fine"], 0.12 * kept["pigment"])
    again.diffuse(5.0)
    assert again.wet_ink() + again.dry_ink() == pytest.approx(laid, rel=1e-6)


@pytest.mark.parametrize("unsaid", [("fine",), ("grain_um",), ("fine", "grain_um")])
def test_pigments_of_files_that_do_not_say_how_fine_they_are_are_the_programs_own(unsaid):
    mesh = sheet(flat, (40.0, 40.0), 5.0)
    surface = PaintedSurface(mesh, 0.8, "xuan")
    mine = Pigment("iron gall", "", np.linspace(2.0, 9.0, 31), np.full(31, 0.5))
    own = [load_pigment(name) for name in ("carmine", "oil soot", "azurite 3")]
    for ink in (mine, *own):
        surface.column_of(ink)
    state = surface_state(surface)
    for pigment in state["pigments"]:
        for name in unsaid:
            del pigment[name]
    again = restore_surface(mesh, state)
    assert again.pigments[0].is_like(mine)
    assert again.pigments[1:] == own
    assert again.column_of(mine) == 0


def test_grains_that_a_file_says_stay_and_what_pores_let_pass_of_them():
    """Also of an ink of the palette that was another when the painting was begun."""
    mesh = sheet(flat, (40.0, 40.0), 5.0)
    surface = PaintedSurface(mesh, 0.8, "xuan")
    carmine = dataclasses.replace(load_pigment("carmine"), fine=0.9, grain_um=7.0)
    mine = dataclasses.replace(carmine, name="mine", grain_um=3.0)
    Painter(surface, "full", {mine: 0.2, carmine: 0.2, "water": 0.6}).replay(stroke())
    surface.diffuse(0.5)
    state = surface_state(surface)
    again = restore_surface(mesh, state)
    assert {p.name: p.grain_um for p in again.pigments if p.grain_um} == {
        "mine": 3.0,
        "carmine": 7.0,
    }
    assert again.column_of(load_pigment("carmine")) == surface.column_of(carmine)
    for one in (surface, again):
        one.diffuse(5.0)
    np.testing.assert_array_equal(again.amounts, surface.amounts)
    said = [p for p in state["pigments"] if p["name"] == "mine"]
    said[0]["grain_um"] = 1e4
    with pytest.raises(SessionError, match="grain_um of mine is 10000"):
        restore_surface(mesh, state)


@pytest.mark.parametrize(
    ("part", "value", "message"),
    [
        ("flow_owed", 1e300, "flow_owed holds 0 to 1e\\+300"),
        ("flow_pigment", 1e300, "flow_pigment holds \\S+ to 1e\\+300"),
        ("flow_water", -1e-3, "flow_water holds -0.001"),
        ("flow_fine", 1e7, "flow_fine is more than flow_pigment"),
    ],
)
def test_water_beyond_all_measure_is_refused(part, value, message):
    mesh = sheet(flat, (40.0, 40.0), 5.0)
    surface = PaintedSurface(mesh, 0.8, "xuan")
    Painter(surface, "full", "pine soot").replay(stroke())
    surface.diffuse(0.5)
    state = dict(surface_state(surface))
    state[part] = np.array(state[part], np.float64)
    state[part].flat[0] = value
    with pytest.raises(SessionError, match=message):
        restore_surface(mesh, state)


def test_the_numbers_kept_do_not_depend_on_the_lattice(monkeypatch):
    surface = painted(creased_mesh())
    state = surface_state(surface)
    monkeypatch.setattr("paint3d.mesh.refined_mesh._REFINED_CELL", 9.0)
    again = restore_surface(surface.source, state)
    assert again.paint_mesh.n_cells != surface.paint_mesh.n_cells
    fresh = surface_state(again)
    for name, value in state.items():
        np.testing.assert_array_equal(fresh[name], value)


def test_colours_of_a_mesh_that_nobody_painted_on_are_exported_as_they_came(tmp_path):
    surface = painted(creased_mesh())
    paint3d.export(surface, tmp_path / "a.ply")
    exported = paint3d.load_mesh(tmp_path / "a.ply")
    _, _, _, srgb = surface.export_arrays()
    np.testing.assert_array_equal(exported.colours, srgb)
    bare = ~surface.painted[: surface.paint_mesh.n_base_vertices]
    source = surface.paint_mesh.source_vertices
    assert bare.all()
    np.testing.assert_array_equal(surface.srgb[: len(source)], creased_mesh().colours[source])


def test_a_session_of_version_1_opens():
    """Written by the first program that saved sessions; the file is never to be written anew."""
    opened = load_session(DATA / "session_v1.p3d")
    told = json.loads((DATA / "session_v1.json").read_text())
    surface = opened.surface
    assert surface.n_vertices == told["vertices"]
    assert opened.settings == told["settings"]
    assert [len(recording) for recording in opened.recordings] == told["samples"]
    assert [pigment.name for pigment in surface.pigments] == told["pigments"]
    # vertices stood for thirds of the triangles around them then
    assert surface.wet_ink() == pytest.approx(told["wet"], rel=2e-3)
    assert surface.dry_ink() == pytest.approx(told["dry"], rel=2e-3)
    shown = surface.srgb[surface.paint_mesh.source_order()]
    assert np.abs(shown.astype(int) - np.array(told["srgb"])).max() <= 1


def test_older_versions_are_taken_step_by_step(tmp_path, monkeypatch):
    surface = painted()
    path = tmp_path / "a.p3d"
    save_session(Session(surface, (), {"old": 1}), path)

    def renamed(parts):
        parts[0]["settings"]["renamed"] = parts[0]["settings"].pop("old")
        return parts

    def halved(state):
        return {**state, "version": 8, "load": 0.5 * state["load"]}

    monkeypatch.setattr(sessions, "VERSION", 3)
    monkeypatch.setitem(sessions.UPGRADES, 2, renamed)
    monkeypatch.setattr(states, "STATE_VERSION", 8)
    monkeypatch.setitem(states.UPGRADES, 7, halved)
    opened = load_session(path)
    assert opened.settings == {"renamed": 1}
    assert opened.surface.ink.load.tolist() == (0.5 * surface.ink.load).tolist()


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "a.p3d"
    save_session(Session(painted(), (stroke(),), {}), path)
    return path


def changed(saved, folder, **changes):
    """A session with some parts replaced: bytes as they are, arrays as .npy, others as JSON."""
    path = folder / "changed.p3d"
    with zipfile.ZipFile(saved) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            value = changes.pop(name.removesuffix(".npy"), None)
            data = old.read(name)
            if name == "session.json":
                text = json.loads(data)
                text["surface"] |= changes.pop("surface", {})
                data = json.dumps(text | changes.pop("text", {})).encode()
            if isinstance(value, np.ndarray):
                file = io.BytesIO()
                np.save(file, value)
                data = file.getvalue()
            new.writestr(name, data if not isinstance(value, bytes) else value)
    assert not changes
    return path


def i32(*values):
    return np.array(values, np.int32)


BAD = {
    "newer": ({"text": {"version": 99}}, "version is 99; this program knows up to 2"),
    "other": ({"text": {"format": "poem"}}, "says it is 'poem'"),
    "truth": ({"text": {"version": True}}, "expected 'paint3d-session'"),
    "state": ({"surface": {"version": 99}}, "state has version 99"),
    "no material": ({"surface": {"material": None}}, "material is None"),
    "light": ({"surface": {"pigments": [{"name": "x", "chinese": "", "K": [-1] * 31,
                                         "S": [0] * 31}]}}, "K of x is -1"),
    "black": ({"surface": {"pigments": [{"name": "x", "chinese": "", "K": [1e300] * 31,
                                         "S": [0] * 31}]}}, "K of x is 1e\\+300 at 400 nm"),
    "digits": ({"surface": {"pigments": [{"name": "x", "chinese": "", "K": [10**400] * 31,
                                          "S": [0] * 31}]}}, "K of x is not an array of numbers"),
    "flood": ({"surface/load": np.array([1e300, 0, 0])}, "load holds 0 to 1e\\+300"),
    "spectra": ({"surface": {"pigments": [{"name": "x"}]}}, "incomplete near"),
    "fine": ({"surface": {"resolution": 0.004}}, "resolution \\(mm\\) is 0\\.004; expected"),
    "coarse": ({"surface": {"resolution": 1.1e6}}, "resolution \\(mm\\) is 1\\.1e\\+06; expected"),
    "coarsest": ({"surface": {"resolution": 1e308}}, "resolution \\(mm\\) is 1e\\+308; expected"),
    "long": ({"surface": {"resolution": 10**400}}, "a whole number of over 300 digits"),
    "words": ({"mesh/vertices": np.array([["a"] * 3])}, "is no array of plain numbers"),
    "faces": ({"mesh/faces": i32(0, 1, 10**6).reshape(1, 3)}, "refers to vertex 1000000"),
    "splits": ({"surface/splits": i32(0, 10**9)}, "bisection [01] of the refinement log halves"),
    "negative": ({"surface/splits": i32(-1)}, "halves triangle -1"),
    "order": ({"surface/splits": i32(9**8)}, "would not halve"),
    "vertex": ({"surface/touched": i32(-5)}, "touched holds -5"),
    "twice": ({"surface/dried": i32(5, 5)}, "dried holds a vertex twice"),
    "rows": ({"surface/coverage": np.zeros(3, np.float32)}, "coverage has shape"),
    "much": ({"surface/load": np.array([-1.0, 0, 0])}, "load holds -1 to"),
    "tuft": ({"surface/stations": np.zeros((4, 3))}, "stations and load differ"),
    "long tuft": ({"surface/stations": np.zeros((999, 3))}, "the brush has 999 stations"),
    "no tuft": ({"surface/stations": np.zeros((0, 3))}, "the brush has 0 stations"),
    "habit": ({"surface/habit": np.array([0.0, -1.0, 0.0])}, "habit holds -1 to"),
    "nan": ({"surface/load": np.array([np.nan, 0, 0])}, "expected a finite number"),
    "blocks": ({"surface/open_blocks": i32(3, 10**7)}, "was in blocks 3 to 10000000; expected 0"),
    "block": ({"surface/open_blocks": i32(-1)}, "was in blocks -1 to -1"),
    "flow": ({"surface": {"flows": True}}, "incomplete near 'flow_vertices'"),
    "time": ({"recordings/0/time_ns": np.zeros(8, np.int64)}, "expected more than 0"),
    "magic": ({"mesh/faces": b"words"}, "'mesh/faces.npy' is no array"),
    "short": ({"mesh/faces": b""}, "is no array"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_sessions_are_refused_in_one_line(saved, tmp_path, name):
    changes, message = BAD[name]
    path = changed(saved, tmp_path, **changes)
    with pytest.raises(SessionError, match=message) as caught:
        load_session(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def npy(description: str) -> bytes:
    head = description.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + bytes(64)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            npy("{'descr': '|O', 'fortran_order': False, 'shape': (8,), }"),
            "is no array of plain numbers",
        ),
        (npy("{'descr': '<f8', 'fortran_order': False, 'shape': (10**18,), }"), "is no array"),
        (
            npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"),
            "says it is",
        ),
        (npy("{'descr': '<f8', 'fortran_order': False, 'shape': (-8,), }"), "is no array"),
        (npy("__import__('os').system('touch /tmp/executed')"), "is no array"),
    ],
)
def test_arrays_are_data_and_no_larger_than_the_file(saved, tmp_path, data, message):
    with pytest.raises(SessionError, match=message):
        load_session(changed(saved, tmp_path, **{"surface/load": data}))


def test_archives_that_lie_or_are_packed_are_refused(tmp_path):
    path = tmp_path / "a.p3d"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("session.json", " " * 100_000_000)
    with pytest.raises(SessionError, match="larger than the file"):
        load_session(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_BZIP2) as archive:
        archive.writestr("session.json", os.urandom(9))
    with pytest.raises(SessionError, match="is packed"):
        load_session(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("../../escaped.npy", b"x")
    with pytest.raises(SessionError, match=r"no session\.json"):
        load_session(path)
    path.write_bytes(b"PK\3\4 and no more")
    with pytest.raises(SessionError, match="damaged, or no session"):
        load_session(path)
    with pytest.raises(SessionError, match="cannot read it"):
        load_session(tmp_path / "none.p3d")


def test_an_entry_that_holds_more_than_it_says_is_not_unpacked(tmp_path):
    """A bomb: its sizes are lies, in both places where a zip archive has them."""
    path, told, held = tmp_path / "a.p3d", 20_000, 200_000_000
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("session.json", b" " * held)
    data = path.read_bytes().replace(struct.pack("<I", held), struct.pack("<I", told))
    path.write_bytes(data)
    tracemalloc.start()
    try:
        with pytest.raises(SessionError):
            load_session(path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < held / 4


@pytest.mark.parametrize(
    ("offset", "value", "message"),
    [
        (10, 99, "'session.json' is packed by something else than deflate"),
        (8, 1, "is packed"),
        (8, 64, "damaged, or no session: strong encryption"),
        (6, 99, r"damaged, or no session: zip file version 9\.9"),
    ],
)
def test_archives_packed_as_none_is_are_refused(saved, tmp_path, offset, value, message):
    path = tmp_path / "a.p3d"
    data = bytearray(saved.read_bytes())
    struct.pack_into("<H", data, data.index(b"PK\1\2") + offset, value)  # of the first entry
    path.write_bytes(data)
    with pytest.raises(SessionError, match=message) as caught:
        load_session(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_names_that_lead_out_of_the_archive_are_passed_over(saved, tmp_path):
    path = tmp_path / "inner" / "a.p3d"
    path.parent.mkdir()
    path.write_bytes(saved.read_bytes())
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("../escaped.txt", b"x")
        archive.writestr("/tmp/escaped.txt", b"x")
    load_session(path)
    assert [file.name for file in tmp_path.iterdir()] == ["inner"]


def test_every_flipped_byte_is_noticed(saved, tmp_path):
    good = saved.read_bytes()
    rng = np.random.default_rng(5)
    path = tmp_path / "a.p3d"
    for at in rng.integers(0, len(good), 40):
        data = bytearray(good)
        data[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(data)
        try:
            surface = load_session(path).surface
        except SessionError:
            continue
        same(surface, load_session(saved).surface)  # a byte that means nothing, such as a date


def test_a_log_is_repeated_in_order_and_with_little_room():
    surface = painted()
    log = refinement_log(surface.paint_mesh)
    again = PaintedSurface(surface.source, surface.resolution).paint_mesh
    repeat_refinement(again, log)
    np.testing.assert_array_equal(again.vertices, surface.paint_mesh.vertices)
    np.testing.assert_array_equal(again.leaf_faces(), surface.paint_mesh.leaf_faces())
    np.testing.assert_array_equal(refinement_log(again), log)
    assert again.vertex_areas.tolist() == surface.paint_mesh.vertex_areas.tolist()


def test_a_pulled_drive_leaves_the_old_file(saved, tmp_path, monkeypatch):
    path = tmp_path / "a.p3d"
    path.write_bytes(b"the old one")

    def pulled(_):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", pulled)
    with pytest.raises(ExportError, match="cannot write: Input/output error"):
        save_session(load_session(saved), path)
    assert path.read_bytes() == b"the old one"
    assert [file.name for file in tmp_path.iterdir()] == ["a.p3d"]


def test_settings_that_json_cannot_hold_are_refused(saved, tmp_path):
    for value in (object(), float("nan")):
        with pytest.raises(ExportError, match="settings cannot be saved"):
            save_session(Session(load_session(saved).surface, (), {"x": value}), tmp_path / "a.p3d")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="ptrace is Linux'")
def test_a_save_cut_at_any_system_call_leaves_the_old_file_or_the_new_one(tmp_path):
    code = (
        "import sys, pathlib; from scripts.cut_saves import *\n"
        "if not traces(): sys.exit(77)\n"
        "folder = pathlib.Path(sys.argv[1])\n"
        "calls, old = cut_everywhere(folder)\n"
        "print(calls, old, survives_full_disk(folder, range(0, 8_000, 799)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, tmp_path],
        capture_output=True,
        text=True,
        check=False,
        cwd=DATA.parents[1],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    if done.returncode == 77:
        pytest.skip("processes cannot be traced here")
    assert done.returncode == 0, done.stderr
    calls, old, failed = map(int, done.stdout.split())
    assert calls > 40
    assert 0 < old < calls
    assert failed == 11

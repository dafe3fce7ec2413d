"""Paint that is erased: by the pen's other end, by E, on one layer, undone, saved and replayed."""

from __future__ import annotations

import dataclasses
import struct
import time
from collections.abc import Sequence

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.input.devices import NoDevices
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.score.playing import painted, score_of_strokes
from paint3d.app.model.stroke_log import ERASES
from paint3d.app.window.hand.device_input import DeviceInput
from paint3d.cli.painting import PaintingOptions, paint_onto
from paint3d.device.descriptor import parse_descriptor
from paint3d.device.digitizer import find_digitizer_layout
from paint3d.device.sample import ERASER, StylusReading
from paint3d.errors import Paint3DError
from paint3d.painter.painter import Painter
from paint3d.painter.recorded_tools import eraser_runs
from paint3d.recording.recording import load_recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.app.test_layers import ACROSS, ALONG, close, paint, shown, small_plane
from tests.support.app.event_player import PENS
from tests.support.app.gestures import BUTTON, HAND, KIND, NO_KEY, drag, live, type_key, wait_for
from tests.support.app.hands import line
from tests.support.app.windows import opened, settled
from tests.support.descriptors import pen

BESIDE = 8.6  # mm, of the print of an upright brush from its root


def erase(document, start, end, n: int = 12) -> None:
    document.begin_stroke(erase=True)
    document.feed(line(start, end, n=n))
    document.end_stroke()


@pytest.fixture
def document() -> Document:
    document = small_plane()
    document.dip("cinnabar")
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("pine soot")
    paint(document, *ALONG)
    return document


def test_it_takes_off_what_lies_under_it_of_its_own_layer_alone(document) -> None:
    document.set_visible(1, False)
    cinnabar = shown(document)
    document.set_visible(1)
    full, held = shown(document), document.surface.ink.load.sum()
    erase(document, (0.0, -12.0), (0.0, 12.0), n=24)
    after, mesh = shown(document), document.surface.paint_mesh.vertices
    at = np.abs(mesh[: document.surface.n_vertices] - [BESIDE, 0.0, 0.0]) < [0.6, 6.0, 9.0]
    middle = at.all(axis=1)[: len(cinnabar)]
    assert (np.abs(full[: len(cinnabar)][middle].astype(int) - cinnabar[middle]) > 20).any()
    np.testing.assert_allclose(after[: len(cinnabar)][middle], cinnabar[middle], atol=2)
    far = np.abs(mesh[: len(full), 1]) > 19.0
    np.testing.assert_array_equal(after[: len(full)][far], full[far])
    close(document)
    assert document.surface.ink.load.sum() == pytest.approx(held)
    document.undo()
    np.testing.assert_array_equal(shown(document)[: len(full)], full)
    document.redo()
    np.testing.assert_array_equal(shown(document), after)


def test_batches_make_no_difference_and_a_mirror_erases_too() -> None:
    found = []
    for size in (1, 5, 24):
        document = small_plane()
        paint(document, (-25.0, 0.0), (15.0, 0.0))
        document.set_symmetry(Symmetry((MirrorPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),)))
        samples = line((0.0, -8.0), (0.0, 8.0), n=24)
        document.begin_stroke(erase=True)
        for k in range(0, len(samples), size):
            document.feed(samples[k : k + size])
        document.end_stroke()
        found.append(shown(document))
        close(document)
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
    vertices = document.surface.paint_mesh.vertices[: len(found[0])]
    bare = document.surface.painted_coverage()[: len(vertices)]
    for x in (-BESIDE, BESIDE):
        spot = (np.abs(vertices[:, :2] - [x, 0.0]) < 0.5).all(axis=1)
        assert bare[spot].max() < 0.05
    spot = (np.abs(vertices[:, :2]) < 0.5).all(axis=1)
    assert bare[spot].max() > 0.5


def test_wet_ink_dries_first_and_does_not_come_back() -> None:
    document = small_plane(material="xuan")
    paint(document, (-20.0, 0.0), (15.0, 0.0))
    document.let_time_pass(0.5)
    erase(document, (0.0, -10.0), (0.0, 10.0), n=24)
    document.let_time_pass(5.0)
    vertices = document.surface.paint_mesh.vertices[: document.surface.n_vertices]
    spot = (np.abs(vertices[:, :2] - [BESIDE, 0.0]) < 0.5).all(axis=1)
    assert document.surface.painted_coverage()[: len(vertices)][spot].max() < 0.05
    close(document)


def test_cancelling_leaves_all_as_it_was(document) -> None:
    full = shown(document)
    document.begin_stroke(erase=True)
    document.feed(line((0.0, -12.0), (0.0, 12.0), n=24))
    document.cancel_stroke()
    np.testing.assert_array_equal(shown(document)[: len(full)], full)
    close(document)


def test_files_and_scores_erase_again(document, tmp_path) -> None:
    erase(document, (0.0, -12.0), (0.0, 12.0), n=24)
    seen = shown(document)
    document.save(tmp_path / "one.p3d")
    opened = Document.open(tmp_path / "one.p3d")
    np.testing.assert_array_equal(shown(opened), seen)
    played = painted(document.score, document.surface.source)
    np.testing.assert_array_equal(shown(played), seen)
    alone = score_of_strokes(document.strokes, document.surface)
    begun = [e for e in alone.events if isinstance(e, dict) and e["do"] == "begin_stroke"]
    assert [e.get("erase", False) for e in begun] == [False, False, True]


def test_a_recording_of_a_pen_that_was_turned_over_erases_again(tmp_path) -> None:
    """As one goes through a file, painted anew and onto a painting, and saved from strokes."""
    document = small_plane()
    paint(document, (-20.0, 0.0), (15.0, 0.0))
    erase(document, (0.0, -10.0), (0.0, 10.0), n=24)
    paint(document, (-20.0, 18.0), (15.0, 18.0))
    save_recording(document.recording(), tmp_path / "turned.jsonl")
    recording = load_recording(tmp_path / "turned.jsonl")
    assert [turned for _, _, turned in eraser_runs(recording.buttons)] == [False, True, False]
    painter = Painter(PaintedSurface(document.surface.source, resolution=1.5))
    painter.replay(recording)
    onto = small_plane()
    paint_onto(onto, recording, PaintingOptions(on="plane", quiet=True), {})
    assert [bool(stroke.tags.get(ERASES)) for stroke in onto.strokes] == [False, True, False]
    for surface in (document.surface, painter.surface, onto.surface):
        vertices = surface.paint_mesh.vertices[: surface.n_vertices]
        shares = surface.painted_coverage()[: len(vertices)]
        at = {y: (np.abs(vertices[:, :2] - [BESIDE, y]) < 0.5).all(axis=1) for y in (0.0, 18.0)}
        assert shares[at[0.0]].max() < 0.05
        assert shares[at[18.0]].max() > 0.5
    unturned = Painter(PaintedSurface(document.surface.source, resolution=1.5))
    unturned.replay(dataclasses.replace(recording, buttons=recording.buttons & ~ERASER))
    ledger = painter.ledger()
    assert sum(ledger.values()) - ledger["loaded"] == pytest.approx(ledger["loaded"])
    assert ledger["dry"] + ledger["wet"] < 0.8 * unturned.ledger()["wet"]


KEY = QtCore.Qt.Key


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:120x120", 1.5, "xuan", drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def bare(request) -> None:
    if "window" in request.fixturenames:
        window = request.getfixturevalue("window")
        while window.document.can_undo:
            window.stage.paint_thread.post("undo").result(300)
        settled(window)


def ink(window) -> float:
    surface = window.document.surface
    return surface.wet_ink() + surface.dry_ink()


def turned_pen(canvas, kind, x: float, y: float, pressure: float) -> None:
    """One event of the pen's other end."""
    down = BUTTON.NoButton if kind == KIND.TabletRelease else BUTTON.LeftButton
    place = QtCore.QPointF(x, y)
    event = QtGui.QTabletEvent(
        kind, PENS["eraser"], place, canvas.mapToGlobal(place), pressure, 0.0, 0.0, 0.0, 0.0,
        0.0, NO_KEY, BUTTON.LeftButton, down,
    )  # fmt: skip
    event.setTimestamp(HAND.now_ms)
    QtWidgets.QApplication.sendEvent(canvas, event)


def test_the_pens_other_end_erases(window) -> None:
    canvas = window.canvas
    drag(canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    before = ink(window)
    x, y = 0.5 * canvas.width(), 0.5 * canvas.height()
    HAND.begin()
    for k in range(16):
        kind = (KIND.TabletPress, KIND.TabletMove, KIND.TabletRelease)[(k > 0) + (k == 15)]
        turned_pen(canvas, kind, x, y + 8.0 * (k - 8), 0.6)
        live(0.008)
        HAND.pass_by(0.008)
    settled(window)
    assert ink(window) < 0.95 * before
    assert len(window.document.strokes) == 2
    assert "eraser" in window.panels.history.list.item(1).text()


RUBBER, TURNED, TIP, NEAR = 8, 16, 1, 32  # bits of the report of `descriptors.pen`


def read_from(flags: int, ends: Sequence[tuple[float, float]], t0: int) -> list[StylusReading]:
    """What a HID pen sends that is led from place to place, mm on the pad, y towards the hand."""
    layout = find_digitizer_layout(parse_descriptor(pen()))
    places = np.round(100.0 * np.linspace(*ends, 24)).astype(int)
    found = []
    for k, (x, y) in enumerate(places):
        is_down = 0 < k < 23
        state = flags if is_down else (flags & TURNED) | NEAR
        report = struct.pack("<BBHHHHbbH", 7, state, x, y, 0, 5000 * is_down, 0, 0, 0)
        found.append(layout.decode(report, t0 + 8_000_000 * k))
    return found


class PenOnly(NoDevices):
    """The pen's readings, once."""

    def __init__(self, readings: list[StylusReading]) -> None:
        super().__init__()
        self.readings = readings

    def take_stylus(self) -> list[StylusReading]:
        taken, self.readings = self.readings, []
        return taken


def test_the_other_end_of_a_hid_pen_erases(window) -> None:
    workspace, panel, before = window.workspace, window.panels.devices, window.both_hands
    before.close()
    inked = 0.0
    ways = (
        (TIP | NEAR, ((10.0, 80.0), (40.0, 80.0))),
        (RUBBER | TURNED | NEAR, ((25, 95), (25, 65))),
    )
    for n, (flags, ends) in enumerate(ways, 1):
        readings = read_from(flags, ends, time.monotonic_ns())
        window.both_hands = DeviceInput(workspace, panel, PenOnly(readings))
        wait_for(lambda n=n: len(window.document.strokes) == n)
        settled(window)
        window.both_hands.close()
        inked, last = ink(window), inked
    window.both_hands = DeviceInput(workspace, panel)
    assert inked < 0.95 * last
    assert [bool(s.tags.get(ERASES)) for s in window.document.strokes] == [False, True]
    window.player.play(list(window.document.recording().samples()), None)
    wait_for(lambda: not window.player.is_playing)
    assert [bool(s.tags.get(ERASES)) for s in window.document.strokes[2:]] == [False, True]


def test_e_turns_the_brush_into_an_eraser_and_back(window) -> None:
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    before = ink(window)
    type_key(window.canvas, KEY.Key_E)
    wait_for(lambda: window.workspace.actions["erase"].isChecked())
    assert window.hud.describe(window.workspace.painting.held).startswith("Eraser")
    drag(window.canvas, (0.5, 0.4), (0.5, 0.6))
    settled(window)
    erased = ink(window)
    assert erased < 0.95 * before
    type_key(window.canvas, KEY.Key_E)
    assert window.hud.describe(window.workspace.painting.held).startswith("ink")
    drag(window.canvas, (0.4, 0.3), (0.6, 0.3))
    settled(window)
    assert ink(window) > erased


def test_a_water_brush_leaves_no_colour(window) -> None:
    type_key(window.canvas, KEY.Key_R, QtCore.Qt.KeyboardModifier.ShiftModifier)
    settled(window)
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    (stroke,) = window.document.strokes
    assert set(stroke.ink) == {"water"}
    codes = window.document.surface.srgb.astype(int)
    assert np.ptp(codes, axis=0).max() <= 3


def test_blotting_paper_lifts_what_is_wet_and_leaves_what_is_dry() -> None:
    document = small_plane(material="xuan")
    document.dip("cinnabar")
    paint(document, (-15.0, -12.0), (15.0, -12.0))
    document.dry()
    document.dip("pine soot")
    paint(document, (-15.0, 8.0), (15.0, 8.0))
    document.let_time_pass(0.3)
    before, surface = shown(document), document.surface
    wet, dry = surface.wet_ink(), surface.dry_ink()
    document.blot()
    assert surface.wet_ink() == 0.0
    assert surface.dry_ink() == pytest.approx(dry + 0.2 * wet, rel=0.02)
    close(document)
    after = shown(document)
    vertices = surface.paint_mesh.vertices[: len(before)]
    low, high = vertices[:, 1] < -2.0, vertices[:, 1] > -2.0
    np.testing.assert_array_equal(after[: len(before)][low], before[low])
    assert after[: len(before)][high].astype(int).sum() > before[high].astype(int).sum()
    document.let_time_pass(5.0)
    np.testing.assert_array_equal(shown(document)[: len(after)], after)  # no water is left
    played = painted(document.score, surface.source)
    np.testing.assert_array_equal(shown(played), shown(document))
    document.undo()
    np.testing.assert_array_equal(shown(document)[: len(before)], before)
    with pytest.raises(Paint3DError):
        document.blot(2.0)


@pytest.mark.parametrize("material", ["porcelain", "silk", "sized xuan", "xuan"])
def test_a_dry_brush_takes_up_what_is_wet_where_it_is_asked_to(material: str) -> None:
    document = small_plane(material=material)
    document.dip("pine soot")
    paint(document, (-15.0, 0.0), (15.0, 0.0))
    document.rinse()
    document.set_pickup(0.2)
    surface, painter = document.surface, document.painter
    before = surface.wet_ink()
    paint(document, (-15.0, 0.0), (15.0, 0.0))
    assert surface.wet_ink() < 0.8 * before
    assert painter.in_brush() == pytest.approx(before - surface.wet_ink())
    close(document)
    document.dry()
    document.rinse()
    dry = surface.dry_ink()
    paint(document, (-15.0, 0.0), (15.0, 0.0))
    assert surface.dry_ink() == dry
    assert painter.in_brush() == 0.0


def test_its_key_blots(window) -> None:
    window.stage.paint_thread.post("dip", "pine soot").result(300)
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    before = ink(window)
    type_key(window.canvas, KEY.Key_E, QtCore.Qt.KeyboardModifier.ShiftModifier)
    wait_for(lambda: ink(window) < 0.4 * before)

"""What lies on the table: the copybook, devices."""

from types import SimpleNamespace

import numpy as np
import pytest

from paint3d.app.model.copybook import Copybook
from paint3d.app.model.document import Document
from paint3d.app.model.input.devices import DeviceHub, StrokeCutter
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.device.hid_nodes import HidNode
from paint3d.device.sample import StylusReading
from paint3d.device.space_mouse import MouseEvent
from paint3d.errors import DeviceError, InputError
from paint3d.pose.two_hands import TwoHands
from scripts.solids import make_plane
from tests.support.app.hands import UPRIGHT, line, sample

MS = 1_000_000


@pytest.fixture
def book():
    return Copybook(make_plane(), "十一", 50.0)


def test_ghosts_lie_on_the_surface_in_their_squares(book):
    assert [ghost.text for ghost in book.ghosts] == ["十", "一"]
    assert [len(ghost.outlines) for ghost in book.ghosts] == [2, 1]
    for ghost in book.ghosts:
        middle = ghost.square.chart.frame.origin
        for ring in (*ghost.outlines, ghost.frame):
            assert np.abs(ring[:, 2]).max() < 0.1
            assert np.abs(ring - middle)[:, :2].max() < 30.0
            np.testing.assert_allclose(ring[0], ring[-1])
        assert len(ghost.medians) == len(ghost.outlines)
    assert book.next == 0


def test_what_is_painted_over_a_ghost_is_scored(book):
    settings = WritingSettings(load_brush("zhongbaiyun"), 50.0)
    written = write_text(make_plane(), "十一", open_glyphs(None), settings)
    document = Document.new(make_plane(), 1.0, brush="zhongbaiyun")
    pressed = np.array(written.recording.pressure > 0.0)
    starts = np.flatnonzero(pressed[1:] & ~pressed[:-1])
    ends = np.flatnonzero(pressed[:-1] & ~pressed[1:]) + 2
    samples = list(written.recording.samples())
    scores = []
    for start, end in zip(starts, ends, strict=True):
        document.dip()
        document.begin_stroke()
        document.feed(samples[start:end])
        document.end_stroke()
        scores.append(book.note(document.strokes[-1], document.surface))
    assert [(s.text, s.n_strokes) for s in scores] == [("十", 1), ("十", 2), ("一", 1)]
    assert scores[0].likeness is None
    assert min(scores[1].likeness.iou, scores[2].likeness.iou) > 0.75
    assert scores[1].seconds > scores[0].seconds > 0.1
    assert document.strokes[2].tags["character"] == "一"
    assert book.next is None
    document.dry()
    dried = book.ghosts[1].compare(document.surface)
    assert dried.iou == pytest.approx(scores[2].likeness.iou)
    document.undo()
    document.undo()
    book.follow(document.strokes)
    assert book.next == 1
    assert book.ghosts[1].compare(document.surface) is None
    document.begin_stroke()
    document.feed(line((-90, -90), (-80, -90)))
    document.end_stroke()
    assert book.note(document.strokes[-1], document.surface) is None


def test_what_no_copybook_has_is_told():
    with pytest.raises(InputError, match="no glyph"):
        Copybook(make_plane(), "☃")
    with pytest.raises(InputError, match="size"):
        Copybook(make_plane(), "一", 0.1)


class Stand:
    """Stands in for the plugged devices: events that were put there come once."""

    def __init__(self):
        self.failures = {"/dev/hidraw9": DeviceError("may not be opened; add the rule X")}
        self.mouse, self.stylus, self.calibrated = [], [], 0

    def nodes(self):
        return [HidNode("/dev/hidraw1", "hidraw", 1, 2, "SpaceMouse", "", 1, 8, "mouse")]

    def mice(self):
        return [self]

    def styli(self):
        return []

    def calibrate_rest(self):
        self.calibrated += 1

    def take_mouse(self):
        events, self.mouse = self.mouse, []
        return events

    def take_stylus(self):
        readings, self.stylus = self.stylus, []
        return readings

    def stop(self):
        self.mouse = None


def test_buttons_ask_the_document_or_steer_the_object():
    stand, now = Stand(), [0]
    desk = DeviceHub(stand, actions={0: "recentre", 1: "dip", 2: "undo", 3: "toggle_turning",
                                      4: "calibrate_rest"}, clock=lambda: now[0])  # fmt: skip
    push = np.array([1.0, 0, 0, 0, 0, 0])
    stand.mouse = [MouseEvent(MS * k, push, buttons) for k, buttons in ((1, 0), (2, 6), (3, 8))]
    stand.stylus = [StylusReading(MS * k, np.zeros(3), UPRIGHT, 0.5) for k in range(1, 60)]
    now[0] = 70 * MS
    taken = desk.take()
    assert taken.commands == ["dip", "undo"]
    assert len(taken.samples) == 59
    assert taken.object_pose.position[0] != 0.0
    assert not desk.hands.steering.turning
    assert desk.force_n == pytest.approx(3.95)
    assert desk.rate_hz("right") == pytest.approx(1000.0)
    assert desk.rate_hz("left") == pytest.approx(1000.0)
    assert desk.lateness_ms("right") == pytest.approx(0.0, abs=1e-9)
    stand.mouse = [MouseEvent(71 * MS, np.zeros(6), 16), MouseEvent(72 * MS, np.zeros(6), 1)]
    now[0] = 90 * MS
    assert desk.take().commands == []
    assert stand.calibrated == 1
    np.testing.assert_allclose(desk.take().object_pose.position, 0.0, atol=1e-9)
    views = desk.views()
    assert [(v.name, v.hand, v.is_open) for v in views] == [
        ("SpaceMouse", "left", True), ("/dev/hidraw9", "", False)
    ]  # fmt: skip
    assert "rule" in str(views[1].error)
    desk.stop()
    assert stand.mouse is None


def test_a_cap_that_moves_while_its_rest_is_taken_is_told_and_all_goes_on():
    class Moved(Stand):
        def calibrate_rest(self):
            raise DeviceError("the cap moved by 40% of its range")

    stand, hands = Moved(), TwoHands(time_ns=0)
    actions = {0: "calibrate_rest", 1: "undo"}
    desk = DeviceHub(stand, hands, actions, clock=lambda: 70 * MS)
    push = np.array([1.0, 0, 0, 0, 0, 0])
    stand.mouse = [
        MouseEvent(MS, push, 0),
        MouseEvent(2 * MS, push, 3),
        MouseEvent(5 * MS, push, 3),
    ]
    taken = desk.take()
    assert [str(failure) for failure in taken.failures] == ["the cap moved by 40% of its range"]
    assert taken.commands == ["undo"]
    assert taken.object_pose.position[0] != 0.0
    assert desk.take().failures == ()


class Servo:
    """Stands in for force feedback."""

    last_force = np.array([0.0, 3.0, 4.0])
    told = None
    runs = True

    def is_running(self):
        return self.runs

    def status(self):
        return SimpleNamespace(fault="")

    def take(self):
        return [StylusReading(MS, np.array([1.0, 2.0, 3.0]), UPRIGHT, None)]

    def publish(self, object_pose=None):
        self.told = object_pose

    def stop(self):
        self.told = "stopped"


def test_a_haptic_stylus_paints_and_its_force_is_shown():
    servo, stand = Servo(), Stand()
    desk = DeviceHub(stand, clock=lambda: 20 * MS, hands=TwoHands(), feedback=servo)
    (one,) = desk.take().samples
    assert one.pressure is None
    np.testing.assert_array_equal(one.position, [1, 2, 3])
    assert desk.force_n == pytest.approx(5.0)
    np.testing.assert_allclose(servo.told, [0, 0, 0, 1, 0, 0, 0])
    desk.stop()
    assert servo.told == "stopped"


def test_a_servo_that_was_killed_is_let_go_of_and_said_so(caplog):
    servo = Servo()
    desk = DeviceHub(Stand(), clock=lambda: 20 * MS, hands=TwoHands(), feedback=servo)
    desk.take()
    servo.runs = False
    assert len(desk.take().samples) == 1  # what it had said until then
    assert servo.told == "stopped"
    assert desk.force_n == 0.0
    assert desk.take().samples == []
    assert [record.getMessage() for record in caplog.records] == [
        "force feedback has ended: its process stopped"
    ]


def test_a_stream_is_cut_into_strokes():
    pressures = [0, 0, 0.2, 0.4, 0, 0, 0.3, 0]
    samples = [sample(k + 1, k, 0, p) for k, p in enumerate(pressures)]
    cutter = StrokeCutter()
    for size in (1, 3, 8):
        parts = []
        for k in range(0, 8, size):
            parts += cutter.cut(samples[k : k + size])
        flat = []
        for part in parts:
            flat += [part] if isinstance(part, str) else [s.time_ns for s in part]
        assert flat == [
            "begin_stroke",
            2,
            3,
            4,
            5,
            "end_stroke",
            "begin_stroke",
            6,
            7,
            8,
            "end_stroke",
        ]
    lifted = StrokeCutter(lambda s: s.position[2] < 35.0)
    heights = [sample(k + 1, 0, 0, None, h) for k, h in enumerate([40, 34, 33, 40])]
    assert [p if isinstance(p, str) else len(p) for p in lifted.cut(heights)] == [
        "begin_stroke", 4, "end_stroke"
    ]  # fmt: skip

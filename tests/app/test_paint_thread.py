"""The painting thread: all samples, in order, and nobody waits."""

import threading
import time

import numpy as np
import pytest

from paint3d.app.model.paint_thread import PaintThread
from paint3d.errors import InputError
from tests.support.app.hands import line, paint, same_vertices, small_plane


@pytest.fixture
def paint_thread():
    paint_thread = PaintThread(small_plane())
    yield paint_thread
    paint_thread.stop()


def frames_until_still(paint_thread):
    """All frames until what was asked for is done and shown."""
    frames = []
    while not paint_thread.is_still:
        frame = paint_thread.take_frame()
        frames += [] if frame is None else [frame]
        time.sleep(0.002)
    return frames


def test_every_sample_is_painted_as_without_a_thread(paint_thread):
    samples = line((-30, 0), (30, 0), n=600)
    paint_thread.post("begin_stroke")
    for k in (0, 7, 200, 201):  # also batches that are painted in pieces
        last = {0: 7, 7: 200, 200: 201, 201: 600}[k]
        paint_thread.feed(samples[k:last])
    paint_thread.post("end_stroke")
    frames = frames_until_still(paint_thread)
    alone = small_plane()
    paint(alone, (-30, 0), (30, 0), n=600)
    with paint_thread.paused() as document:
        np.testing.assert_array_equal(document.surface.amounts, alone.surface.amounts)
        shown = document.surface.srgb
    bare = small_plane().surface
    told = np.concatenate([frame.vertex_ids for frame in frames])
    painted = np.flatnonzero((shown != bare.srgb[0]).any(axis=1))
    assert len(painted) > 20
    assert set(painted.tolist()) <= set(told.tolist())


def test_a_frame_tells_that_triangles_came(paint_thread):
    paint_thread.feed([])
    assert not any(frame.has_grown for frame in frames_until_still(paint_thread))
    for k in range(2):  # the second time the same place is painted, and nothing comes
        paint_thread.post("begin_stroke")
        paint_thread.feed(line((-30, 0), (30, 0), n=100, t0=1 + k * 10_000_000_000))
        paint_thread.post("end_stroke")
        assert any(frame.has_grown for frame in frames_until_still(paint_thread)) == (k == 0)


def test_who_only_reads_is_shown_nothing_new(paint_thread):
    paint_thread.feed([])
    frames_until_still(paint_thread)
    for _ in range(3):  # as a view that turns does
        with paint_thread.paused() as document:
            assert document is not None
        assert paint_thread.is_still
        time.sleep(0.01)
        assert paint_thread.take_frame() is None


def test_a_fault_is_an_event_and_painting_goes_on(paint_thread):
    asked = paint_thread.post("feed", line((0, 0), (1, 0)))
    with pytest.raises(InputError):
        asked.result(timeout=300)
    paint_thread.feed(line((0, 0), (1, 0)))
    with pytest.raises(AttributeError):
        paint_thread.post("no_such_thing").result(timeout=300)
    kinds = [(event.kind, event.doing) for event in paint_thread.take_events()]
    assert kinds[:2] == [("error", "feed"), ("error", "painting")]
    assert kinds[2][0] == "internal"
    paint_thread.post("begin_stroke")
    paint_thread.feed(line((0, 0), (20, 0)))
    paint_thread.post("end_stroke").result(timeout=300)
    assert not paint_thread.take_events()
    assert sum(len(frame.vertex_ids) for frame in frames_until_still(paint_thread)) > 20


def test_nobody_waits_while_it_paints(paint_thread):
    started, release = threading.Event(), threading.Event()

    def hold(document):
        started.set()
        release.wait(300)

    paint_thread.post(hold)
    assert started.wait(300)
    paint_thread.take_frame()
    paint_thread.feed(line((0, 0), (20, 0)))
    waiting = paint_thread.post("rinse")
    assert paint_thread.take_frame() is None
    assert paint_thread.queue_length == 2
    release.set()
    waiting.result(timeout=300)


def test_a_frame_counts_all_that_was_asked_for_and_that_it_does_not_show(paint_thread):
    """Also what was asked for after it was made: a replay once took such a frame for its stroke."""
    frames_until_still(paint_thread)
    paint_thread.post(lambda document: None).result(timeout=300)  # made with nothing waiting
    started, release = threading.Event(), threading.Event()
    paint_thread.post(lambda document: started.set() or release.wait(300))
    assert started.wait(300)
    paint_thread.post("rinse")
    left = paint_thread.take_frame().queue_length
    release.set()
    assert left == 2
    assert frames_until_still(paint_thread)[-1].queue_length == 0


def test_the_brush_is_shown_before_it_touches(paint_thread):
    paint_thread.hover(line((5, 6), (6, 6))[0])
    frame = frames_until_still(paint_thread)[-1]
    assert frame.brush.load == 1.0
    assert not frame.brush.painting
    assert frame.brush.pressed is None
    np.testing.assert_allclose(frame.brush.position[:2], [5, 6], atol=1e-3)
    assert frame.brush.srgb.max() < 60


def test_a_stopped_thread_takes_nothing(paint_thread):
    paint_thread.stop()
    with pytest.raises(RuntimeError, match="stopped"):
        paint_thread.post("undo")


def test_room_is_made_while_the_hand_rests_and_nothing_painted_changes():
    surfaces = []
    for rests in (False, True):
        document = small_plane(0.3)
        mesh = document.surface.paint_mesh
        grown = 0
        for k in range(9):
            paint(document, (-40, 8 * k - 30), (40, 8 * k - 30))
            before = mesh.capacity
            if rests:
                document.prepare_next_stroke()
            grown += mesh.capacity > before
        assert (grown > 0) == rests
        surfaces.append(document.surface)
    same_vertices(*surfaces)


def test_nobody_else_uses_the_document_that_the_painting_thread_has(paint_thread):
    document = paint_thread.look(60.0)
    for use in (document.dry, document.undo, document.refresh, lambda: document.feed([])):
        with pytest.raises(RuntimeError, match="MainThread uses the document"):
            use()
    with paint_thread.paused() as held:
        assert held is document
        held.refresh()
    assert paint_thread.post("add_layer").result() is None
    assert paint_thread.post(lambda own: own.refresh()).result().size >= 0
    paint_thread.stop()
    document.undo()


def test_a_snapshot_is_what_the_last_step_left_and_does_not_change(paint_thread):
    before = paint_thread.painting
    paint_thread.post("add_layer", "over").result(timeout=300)
    paint_thread.post("begin_stroke")
    paint_thread.feed(line((-3, 0), (3, 0)))
    paint_thread.post("end_stroke").result(timeout=300)
    after = paint_thread.painting
    assert [layer.name for layer in after.layers][1:] == ["over"]
    assert (after.active_layer, len(after.strokes), after.can_undo) == (1, 1, True)
    assert (len(before.layers), before.active_layer, before.strokes) == (1, 0, ())
    paint_thread.post("undo").result(timeout=300)
    assert (len(after.strokes), len(paint_thread.painting.undone_strokes)) == (1, 1)

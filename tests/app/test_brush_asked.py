"""The brush that the hand asked for, while the painting is behind."""

import numpy as np
import pytest

from paint3d.app.model.brush_in_hand import BRUSH_COMMANDS, brush_after
from paint3d.app.model.input.hand import Hand, PointerInput
from paint3d.app.model.paint_thread import PaintThread
from paint3d.brush.presets import load_brush
from paint3d.mesh.bvh import ClosestPoints
from tests.support.app.hands import small_plane

MS = 1_000_000


def write(paint_thread, hand, y, pressure=0.4):
    """A line of 40 mm, with the brush that the painting thread says."""
    place, down = (-20.0, y, 90.0), (0.0, 0.0, -1.0)
    event = PointerInput(MS, origin=place, direction=down, pressure=pressure)
    samples = list(hand.begin(event, paint_thread.brush))
    for k in range(1, 20):
        place = (-20.0 + 2.0 * k, y, 90.0)
        event = PointerInput(8 * MS * k, origin=place, direction=down, pressure=pressure)
        samples += hand.move(event, paint_thread.brush)
    samples += hand.end(160 * MS, paint_thread.brush)
    paint_thread.post("begin_stroke")
    paint_thread.feed(samples)
    paint_thread.post("end_stroke")


@pytest.mark.parametrize(
    "change",
    [("set_brush", "gongbi"), ("scale_brush", 0.5), ("step_brush", -4), ("resize_brush", 20.0),
     ("dip", "cinnabar"), ("add_layer", "over")],
)  # fmt: skip
def test_a_stroke_right_after_a_change_is_painted_as_after_waiting(change):
    shown = []
    for held in (True, False):
        document = small_plane()
        paint_thread = PaintThread(document)
        hand = Hand(ClosestPoints(document.surface.source))
        write(paint_thread, hand, -20.0)
        if held:
            with paint_thread.paused():  # the painting is behind
                before = paint_thread.brush
                paint_thread.post(*change)
                asked = paint_thread.brush
                assert (asked != before) == (change[0] in BRUSH_COMMANDS)
                write(paint_thread, hand, 20.0)
        else:
            paint_thread.post(*change).result()
            write(paint_thread, hand, 20.0)
        paint_thread.post("refresh").result()
        paint_thread.stop()
        assert not held or document.painter.brush == asked
        surface = document.surface
        order = np.lexsort(surface.paint_mesh.vertices.T)
        there = surface.paint_mesh.vertices[:, 1] > 10
        assert surface.painted[there].sum() > 20
        shown.append((surface.srgb[order], [s.brush for s in document.strokes]))
    np.testing.assert_array_equal(shown[0][0], shown[1][0])
    assert shown[0][1] == shown[1][1]


def test_what_is_refused_is_not_taken():
    brush = load_brush("full")
    assert brush_after(brush, "set_brush", ["no such brush"]) == brush
    assert brush_after(brush, "scale_brush", [1000.0]) == brush
    assert brush_after(brush, "set_brush", []) == brush
    paint_thread = PaintThread(small_plane())
    paint_thread.post("begin_stroke")
    with paint_thread.paused():
        asked = paint_thread.post("set_brush", "gongbi")
    with pytest.raises(Exception, match="during a stroke"):
        asked.result()
    assert paint_thread.brush == paint_thread.painting.brush == small_plane().painter.brush
    paint_thread.stop()

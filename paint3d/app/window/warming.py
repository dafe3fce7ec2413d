"""Compiling, ahead of the first stroke, what the window's own thread will run."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.input.hand import Hand, PointerInput
from paint3d.brush_engine.stroke_loop import paint_samples
from paint3d.core.kernel import is_ahead, is_compiled
from paint3d.device.sample import DeviceSample
from paint3d.mesh.bvh import ClosestPoints
from paint3d.pose.brush_pose import object_poses
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.view.brush_shape import BrushStand, tuft_rings
from paint3d.view.kernels.chunks import cone_of
from paint3d.view.kernels.drape import drape_points
from paint3d.view.kernels.enlarge import enlarge
from paint3d.view.kernels.shine import add_shine
from paint3d.view.live_layers import Enlarger
from paint3d.view.live_object import LiveObject

__all__ = ["is_first_start", "is_warm", "warm_up"]

_MS = 1_000_000
_LOOK_S = 0.1
_warm: list[bool] = []
_one_at_a_time = threading.Lock()


def is_first_start() -> bool:
    """Whether the kernels have never been compiled here, so that it takes a minute."""
    return not is_compiled(paint_samples)


def is_warm() -> bool:
    """Whether nothing is to be got ready: kernels were compiled ahead, and not changed since."""
    return all(map(is_ahead, (paint_samples, drape_points, cone_of, add_shine, enlarge)))


def warm_up(progress: Callable[[float], None] = lambda _: None) -> None:
    """Paint a stroke that nobody sees; once, some tenths of a second, a minute the first time.

    Parameters
    ----------
    progress : callable
        Called with the share done between the steps; what it raises stops them.
    """
    while not _one_at_a_time.acquire(timeout=_LOOK_S):  # one that was given up goes on for a while
        progress(0.0)
    try:
        if not _warm:
            _paint_unseen(progress)
            _warm.append(True)
    finally:
        _one_at_a_time.release()


def _paint_unseen(progress: Callable[[float], None]) -> None:
    document = Document.new("plane", 4.0, "xuan")
    hand, brush = Hand(ClosestPoints(document.surface.source)), document.painter.brush
    shown = LiveObject(document.surface)
    for upload in shown.uploads(document.refresh()):
        cone_of(upload.points, upload.faces, np.zeros(4))
    progress(0.2)
    document.begin_stroke()
    samples = hand.begin(_over(0), brush)
    assert samples is not None, "the pen is over the sheet"
    for k in range(1, 6):
        samples += hand.move(_over(k), brush)
    document.feed(samples)
    progress(0.7)
    document.end_stroke()
    document.let_time_pass(0.05)
    progress(0.9)
    shown.uploads(document.refresh())
    _turn(shown)
    _stand(document, samples[-1])
    progress(0.98)
    document.undo()


def _over(k: int) -> PointerInput:
    """A pen over the sheet."""
    place, down = (2.0 * k, 0.0, 90.0), (0.0, 0.0, -1.0)
    return PointerInput(10 * _MS * (k + 1), origin=place, direction=down, pressure=0.5)


def _turn(shown: LiveObject) -> None:
    """Make ready what is drawn while the view moves."""
    coarse = shown.coarse_for(1.0, 1000)
    assert coarse is not None, "it is asked for the first time"
    lamps, lobes, out = np.zeros((1, 6)), np.ones((3, 2)), coarse.colours.copy()
    add_shine(
        coarse.points, coarse.normals, coarse.colours, np.zeros(3), lamps, lobes, PLAIN_SHINE, out
    )
    Enlarger((1, 1), (2, 2)).enlarge(np.zeros((1, 1, 4), np.uint8), np.zeros((2, 2, 4), np.uint8))


def _stand(document: Document, sample: DeviceSample) -> None:
    """Find how the brush stands, as for drawing it."""
    painter, tree = document.painter, document.surface.contact_tree
    pressed = document.tuft_follower.follow(painter, object_poses([sample]))
    stand = BrushStand.of(painter.tuft, sample.position, np.eye(3), pressed)
    rings, _ = tuft_rings(painter.tuft, stand)
    points = np.ascontiguousarray(rings[:, 0])
    out, landed = np.zeros((len(points), 6)), np.zeros(len(points), np.uint8)
    drape_points(tree, points, np.array([0.0, 0.0, -1.0]), 50.0, out, landed)
    stand.outline()

"""The studio's picture beside its painting thread: a sheet of a million vertices, all refined.

A hand of its own thread writes over the sheet at a device's rate while pictures are drawn as often
as it goes, 30 times and 4 times a second. A mark goes along with the hand's samples now and then:
it is painted when all before it are, and seen when the next picture is there.
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, field

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.window.stage import Stage
from paint3d.bench.result import Check, Result
from paint3d.device.sample import DeviceSample
from paint3d.view.camera import View, fit_camera
from paint3d.view.live_object import LiveObject

__all__ = ["measure"]

_VERTICES = 1_000_000
_SHEET_MM2, _FACE_AREA = 200.0 * 200.0, 0.2384  # of a refined face over the resolution squared
_SIZE = (1280, 800)
_RATE_HZ = 250.0
_MARK_EVERY = 25  # samples
_SECONDS = 5.0
_UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
_PACES = (("as fast as it goes", 0.0), ("30 a second", 1 / 30), ("4 a second", 1 / 4))
_RANGES = (1000, 10_000, 100_000)


@dataclass
class _Hand:
    """Writes in a thread of its own, and notes what waits."""

    stage: Stage
    seconds: float
    marks: dict[int, list[float]] = field(default_factory=dict)  # posted, painted
    queue: list[int] = field(default_factory=list)

    def write(self) -> None:
        """One stroke, in real time."""
        easel = self.stage.easel
        easel.post("begin_stroke")
        start = time.perf_counter()
        n = int(self.seconds * _RATE_HZ)
        for k in range(n):
            time.sleep(max(0.0, start + k / _RATE_HZ - time.perf_counter()))
            easel.feed([_sample(k, n)])
            self.queue.append(easel.queue_length)
            if k % _MARK_EVERY == 0:
                self._mark(k)
        easel.post("end_stroke").result()

    def _mark(self, k: int) -> None:
        times = self.marks[k] = [time.perf_counter()]
        self.stage.easel.post(lambda document: times.append(time.perf_counter()))


def _sample(k: int, n: int) -> DeviceSample:
    """Lines to and fro down the sheet, 180 mm/s, as a hand that presses and lifts a little."""
    t = k / _RATE_HZ
    x = 70.0 * math.asin(math.sin(2.4 * t)) / (0.5 * math.pi)
    y = 75.0 - 150.0 * k / n
    pressure = 0.0 if k in (0, n - 1) else 0.35 + 0.15 * math.sin(9.0 * t)
    place = np.array([x, y, 35.0])
    time_ns = int(4_000_000 * (k + 1))
    return DeviceSample(time_ns, place, _UPRIGHT, pressure, 0, np.zeros(3), _UPRIGHT)


def _stage(share: float) -> Stage:
    resolution = math.sqrt(_SHEET_MM2 / (2.0 * _FACE_AREA * _VERTICES * share))
    document = Document.new("plane", resolution, "xuan")
    document.surface.refine_all()
    stage = Stage(_SIZE)
    stage.open(document)
    view = View((0.0, -0.45, 1.0), (0.0, 1.0, 0.0))
    stage.set_camera(fit_camera(stage.points, view, _SIZE[0] / _SIZE[1]))
    while not stage.is_lit:
        stage.follow()
        time.sleep(0.02)
    stage.draw()
    return stage


def _paint(stage: Stage, pace_s: float, seconds: float) -> dict[str, float]:
    """Write while pictures are drawn at a pace; what that took."""
    stage.easel.post("dip").result()
    hand = _Hand(stage, seconds)
    thread = threading.Thread(target=hand.write)
    frames, sizes, seen, drawn = [], [], {}, 0.0
    thread.start()
    while thread.is_alive():
        now = time.perf_counter()
        if now - drawn < pace_s:
            time.sleep(0.001)
            continue
        before = stage.scene.uploaded
        if stage.follow() is None:
            time.sleep(0.001)
            continue
        there = [k for k, times in hand.marks.items() if len(times) > 1 and k not in seen]
        drawn = now
        stage.draw()
        frames.append(stage.scene.frame_s)
        sizes.append(stage.scene.uploaded - before)
        seen.update(dict.fromkeys(there, time.perf_counter()))
    thread.join()
    delays = [at - hand.marks[k][0] for k, at in seen.items()]
    half = len(hand.queue) // 2
    return {
        "pictures": len(frames) / seconds,
        "frame": float(np.median(frames)),
        "delay": float(np.median(delays)),
        "late": float(np.quantile(delays, 0.95)),
        "size": float(np.median(sizes)),
        "queue": float(max(hand.queue)),
        "growth": float(np.mean(hand.queue[half:]) - np.mean(hand.queue[:half])),
    }


def _uploads(stage: Stage) -> list[tuple[int, int, float]]:
    """Dirty vertices near each other, what they send, and how long that takes (s)."""
    with stage.easel.paused() as document:
        shown = LiveObject(document.surface)
        shown.uploads(np.empty(0, np.int32))
        vertices = document.surface.paint_mesh.vertices
        order = np.argsort(np.hypot(vertices[:, 0], vertices[:, 1])).astype(np.int32)
        found = []
        for n in (*_RANGES, len(order)):
            if n > len(order):
                continue
            started = time.perf_counter()
            uploads = shown.uploads(order[:n])
            spent = time.perf_counter() - started
            found.append((n, sum(upload.n_bytes for upload in uploads), spent))
    return found


def measure(share: float = 1.0) -> Result:
    """Frame time, input-to-ink time, upload and queue.

    Parameters
    ----------
    share : float
        Of a million vertices, and of 5 s for each pace.
    """
    stage = _stage(share)
    try:
        vertices = stage.easel.document.surface.n_vertices
        rows, checks = [], []
        for name, pace in _PACES:
            got = _paint(stage, pace, max(1.0, _SECONDS * share))
            rows.append(
                (
                    name, got["pictures"], 1e3 * got["frame"], 1e3 * got["delay"],
                    1e3 * got["late"], got["size"] / 1e3, got["queue"], got["growth"],
                )
            )  # fmt: skip
            checks.append(Check(f"growth of the queue, {name}", got["growth"], 2.0, unit="samples"))
        uploads = _uploads(stage)
        renderer = stage.scene.renderer_name
        n_patches = len(uploads)
    finally:
        stage.close()
    whole = uploads[-1][1]
    told = ", ".join(f"{n:,}: {size / 1e3:,.0f} kB in {1e3 * s:.1f} ms" for n, size, s in uploads)
    for n, size, _ in uploads[:-1]:
        if n == 10_000 and n_patches > 1:
            checks.append(
                Check("upload for 10,000 dirty vertices, of the whole", size / whole, 0.1)
            )
    columns = (
        "pictures", "a second", "frame ms", "input to ink ms", "95 % ms", "upload kB",
        "longest queue", "growth",
    )  # fmt: skip
    notes = [
        f"{vertices:,} vertices, {_SIZE[0]} x {_SIZE[1]} pixels, drawn by {renderer}.",
        f"Upload by dirty vertices near each other: {told}.",
        f"The hand is read {_RATE_HZ:g} times a second; the queue counts batches of one sample; "
        "its growth is the second half's mean over the first's.",
    ]
    return Result("The studio: painting and picture at once", columns, rows, checks, notes)

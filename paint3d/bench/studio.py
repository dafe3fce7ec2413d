"""The studio's pictures: painting and turning, on a bowl and on a sheet of a million vertices.

A hand in a thread of its own writes at a device's rate while pictures are drawn as fast as
possible; on the sheet, which is refined all over, 30 times and 4 times a second too. Marks are
queued among the hand's samples: one is painted when all samples before it are, and seen in the next
picture. Turning, every picture has a new view.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.input.navigation import orbit
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.window.files.open_result import OpenResult
from paint3d.app.window.stage import Stage
from paint3d.bench.result import Check, Result
from paint3d.core.arrays import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.mesh.bvh import ClosestPoints
from paint3d.view.camera import Camera, View, fit_camera
from paint3d.view.live_object import LiveObject

__all__ = ["measure"]

_VERTICES = 1_000_000
_SHEET_MM2, _FACE_AREA = 200.0 * 200.0, 0.2384  # of a refined face over the resolution squared
_BOWL_MM = 0.4
_SIZE = (1280, 800)
_RATE_HZ = 250.0
_MARK_EVERY = 25  # samples
_SECONDS = 5.0
_UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
_ABOVE = 35.0  # mm: the brush's root over what it paints
_PACES = (("as it goes", 0.0), ("30 a second", 1 / 30), ("4 a second", 1 / 4))
_RANGES = (1000, 10_000, 100_000)
_BOWL_VIEW, _SHEET_VIEW = View((0.12, -1.0, 0.62)), View((0.0, -0.45, 1.0), (0.0, 1.0, 0.0))
_WANTED = {"bowl": 30.0, "sheet": 12.0}  # pictures a second, where software draws
_CARD_WANTED = 60.0
_OLDEST_MS = 100.0
_COLUMNS = (
    "pictures", "a second", "CPU ms", "of it here", "frame ms", "hand ms",
    "input to ink ms", "95 % ms", "upload kB", "longest queue", "growth",
)  # fmt: skip

Path = Callable[[float], tuple[AnyArray, AnyArray]]
"""Position of the brush's root, mm, and its orientation, at a fraction of the time."""


@dataclass
class _Hand:
    """Writes in a thread of its own, and records the queue and the marks."""

    stage: Stage
    path: Path
    seconds: float
    fed: dict[int, float] = field(default_factory=dict)
    marks: dict[int, list[float]] = field(default_factory=dict)  # posted, painted
    queue: list[int] = field(default_factory=list)
    cpu_s: float = 0.0
    rests: bool = False

    def write(self) -> None:
        """Write one stroke in real time."""
        paint_thread = _paint_thread(self.stage)
        paint_thread.post("begin_stroke")
        start = time.perf_counter()
        n = int(self.seconds * _RATE_HZ)
        for k in range(n):
            time.sleep(max(0.0, start + k / _RATE_HZ - time.perf_counter()))
            sample = self._sample(k, n)
            self.fed[sample.time_ns] = time.perf_counter()
            paint_thread.feed([sample])
            self.queue.append(paint_thread.queue_length)
            if k % _MARK_EVERY == 0:
                times = self.marks[k] = [time.perf_counter()]
                paint_thread.post(lambda _, times=times: times.append(time.perf_counter()))
        self.rests = True
        paint_thread.post("end_stroke").result()
        self.cpu_s = time.thread_time()

    def _sample(self, k: int, n: int) -> DeviceSample:
        """Make sample k of n, of a hand that presses and lifts a little."""
        position, orientation = self.path(k / n)
        pressure = 0.0 if k in (0, n - 1) else 0.35 + 0.15 * math.sin(9.0 * k / _RATE_HZ)
        time_ns = int(4_000_000 * (k + 1))
        return DeviceSample(time_ns, position, orientation, pressure, 0, np.zeros(3), _UPRIGHT)

    def age(self) -> float:
        """Return the time since the newest sample that was painted was fed, s."""
        newest = _paint_thread(self.stage).newest
        fed = math.nan if newest is None else self.fed.get(newest.time_ns, math.nan)
        return 0.0 if math.isnan(fed) else time.perf_counter() - fed


def _over_the_sheet(seconds: float) -> Path:
    """Make a path of lines to and fro down the sheet, 180 mm/s."""

    def path(t: float) -> tuple[AnyArray, AnyArray]:
        x = 70.0 * math.asin(math.sin(2.4 * t * seconds)) / (0.5 * math.pi)
        return np.array([x, 75.0 - 150.0 * t, _ABOVE]), _UPRIGHT

    return path


def _around_the_bowl(stage: Stage) -> Path:
    """Make a path to and fro on the visible side of the bowl, and down."""
    surface = ClosestPoints(_paint_thread(stage).painting.source)

    def path(t: float) -> tuple[AnyArray, AnyArray]:
        turn = 0.7 * math.sin(14.0 * t) - 0.5 * math.pi
        out = np.array([math.cos(turn), math.sin(turn), 0.0])
        hit = surface.cast((200.0 * out + [0.0, 0.0, 55.0 - 20.0 * t])[None], -out[None])
        normal = surface.find(hit.points).normals[0]
        half = np.array([1.0 + normal[2], -normal[1], normal[0], 0.0])  # from z to the normal
        return hit.points[0] + _ABOVE * normal, half / np.linalg.norm(half)

    return path


def _paint_thread(stage: Stage) -> PaintThread:
    """Return the painting thread of a stage with an open document."""
    assert stage.paint_thread is not None, "a document is open"
    return stage.paint_thread


def _stand(document: Document, view: View) -> tuple[Stage, Camera]:
    """Open a document on a stage; return when it is lit and drawn."""
    stage = Stage(_SIZE)
    stage.open(OpenResult.of(document))
    camera = fit_camera(stage.points, view, _SIZE[0] / _SIZE[1])
    stage.set_camera(camera)
    while not (stage.is_lit and stage.is_drawn):
        stage.follow()
        stage.draw()
        time.sleep(0.002)
    return stage, camera


def _sheet(scale: float) -> Document:
    resolution = math.sqrt(_SHEET_MM2 / (2.0 * _FACE_AREA * _VERTICES * scale))
    document = Document.new("plane", resolution, "xuan")
    document.surface.refine_all()
    return document


def _paint(stage: Stage, path: Path, pace_s: float, seconds: float) -> dict[str, float]:
    """Paint while pictures are drawn at a pace; return what that took."""
    _paint_thread(stage).post("dip").result()
    hand = _Hand(stage, path, seconds)
    thread = threading.Thread(target=hand.write)
    frames, sizes, ages, seen, drawn = [], [], [], {}, 0.0
    started = time.perf_counter()
    painting, cpu, own = (
        _paint_thread(stage).post(_thread_s).result(),
        time.process_time(),
        _thread_s(),
    )
    thread.start()
    while thread.is_alive():
        now = time.perf_counter()
        if now - drawn < pace_s:
            time.sleep(0.001)
            continue
        before = stage.scene.uploaded
        there = [k for k, times in hand.marks.items() if len(times) > 1 and k not in seen]
        stage.follow()
        fetched = time.perf_counter()
        newest_s = hand.age() if _paint_thread(stage).newest is not None else 0.0
        if stage.draw() is None:
            time.sleep(0.001)
            continue
        drawn, done = now, time.perf_counter()
        seen.update(dict.fromkeys(there, done))
        if not hand.rests:
            ages.append(newest_s + done - fetched)
        frames.append(done - now)
        sizes.append(stage.scene.uploaded - before)
    thread.join()
    cpu, own = time.process_time() - cpu, _thread_s() - own
    painting = _paint_thread(stage).post(_thread_s).result() - painting
    delays = [at - hand.marks[k][0] for k, at in seen.items()]
    half = len(hand.queue) // 2
    return {
        "pictures": len(frames) / (done - started),
        "frame": float(np.median(frames)),
        "drawing": (cpu - painting - hand.cpu_s) / len(frames),
        "own": own / len(frames),
        "age": float(np.quantile(ages, 0.95)),
        "delay": float(np.median(delays)),
        "late": float(np.quantile(delays, 0.95)),
        "size": float(np.median(sizes)),
        "queue": float(max(hand.queue)),
        "growth": float(np.mean(hand.queue[half:]) - np.mean(hand.queue[:half])),
    }


def _turn(stage: Stage, camera: Camera, seconds: float) -> dict[str, float]:
    """Turn the view while pictures are drawn as fast as possible; return what that took."""
    stage.hide_brush()
    frames, start = [], time.perf_counter()
    cpu, own = time.process_time(), _thread_s()
    while time.perf_counter() - start < seconds:
        now = time.perf_counter()
        camera = orbit(camera, 6.0, 4.0 * math.sin(3.0 * (now - start)), _SIZE[1])
        stage.set_camera(camera)
        stage.follow()
        stage.draw()
        frames.append(time.perf_counter() - now)
    n = len(frames)
    return {
        "pictures": n / (time.perf_counter() - start),
        "frame": float(np.median(frames)),
        "drawing": (time.process_time() - cpu) / n,
        "own": (_thread_s() - own) / n,
        "age": float(np.quantile(frames, 0.95)),
    }


def _thread_s(document: Document | None = None) -> float:
    """Return the CPU time of the calling thread, s."""
    return time.thread_time()


def _uploads(stage: Stage) -> list[tuple[int, int, float]]:
    """Measure uploads by numbers of neighbouring dirty vertices: number, bytes, time, s."""
    with _paint_thread(stage).paused() as document:
        assert document is not None, "it is open"
        shown = LiveObject(document.surface)
        shown.uploads(np.empty(0, np.int32))
        vertices = document.surface.paint_mesh.vertices
        order = np.argsort(np.hypot(vertices[:, 0], vertices[:, 1])).astype(np.int32)
        measured = []
        for n in (*_RANGES, len(order)):
            if n > len(order):
                continue
            started = time.perf_counter()
            uploads = shown.uploads(order[:n])
            spent = time.perf_counter() - started
            measured.append((n, sum(upload.n_bytes for upload in uploads), spent))
    return measured


def measure(scale: float = 1.0) -> Result:
    """Measure pictures a second and what each takes, hand-to-ink time, upload and queue.

    Parameters
    ----------
    scale : float
        Of a million vertices, and of 5 s for each row.
    """
    seconds = max(1.0, _SECONDS * scale)
    rows, checks = [], []

    def add(name: str, what: str, got: dict[str, float], check: bool = True) -> None:
        milli = [1e3 * got[key] for key in ("drawing", "own", "frame", "age")]
        ink = [1e3 * got[key] if key in got else None for key in ("delay", "late")]
        queue = [got.get("queue"), got.get("growth")]
        size = got["size"] / 1e3 if "size" in got else None
        rows.append((f"{name}, {what}", got["pictures"], *milli, *ink, size, *queue))
        if check:
            wanted = _WANTED[name] if stage.scene.is_software else _CARD_WANTED
            checks.append(Check(f"pictures, {name}, {what}", got["pictures"], wanted, False, "/s"))
            checks.append(Check(f"hand, {name}, {what}", 1e3 * got["age"], _OLDEST_MS, unit="ms"))
        if "growth" in got:
            title = f"growth of the queue, {name}, {what}"
            checks.append(Check(title, got["growth"], 2.0, unit="samples"))

    stage, camera = _stand(Document.new("bowl", _BOWL_MM), _BOWL_VIEW)
    try:
        add("bowl", "painting", _paint(stage, _around_the_bowl(stage), 0.0, seconds))
        add("bowl", "turning", _turn(stage, camera, seconds))
    finally:
        stage.close()
    stage, camera = _stand(_sheet(scale), _SHEET_VIEW)
    try:
        vertices = _paint_thread(stage).painting.n_vertices
        for pace, pace_s in _PACES:
            got = _paint(stage, _over_the_sheet(seconds), pace_s, seconds)
            add("sheet", "painting" + f", {pace}" * (pace_s > 0.0), got, pace_s == 0.0)
        add("sheet", "turning", _turn(stage, camera, seconds))
        uploads = _uploads(stage)
        renderer = stage.scene.renderer_name
    finally:
        stage.close()
    whole = uploads[-1][1]
    sizes = ", ".join(f"{n:,}: {size / 1e3:,.0f} kB in {1e3 * s:.1f} ms" for n, size, s in uploads)
    for n, size, _ in uploads[:-1]:
        if n == 10_000:
            checks.append(
                Check("upload for 10,000 dirty vertices, of the whole", size / whole, 0.1)
            )
    notes = [
        f"The sheet has {vertices:,} vertices; {_SIZE[0]} x {_SIZE[1]} pixels, by {renderer}.",
        "CPU is the time of all cores for drawing a picture, 'here' of the thread that draws, "
        "without painting and the hand.",
        "'Hand' is the age of the hand's newest sample in a picture, 95th percentile.",
        f"Upload by dirty vertices near each other: {sizes}.",
        f"The hand is read {_RATE_HZ:g} times a second; the queue counts batches of one sample; "
        "its growth is the second half's mean over the first's.",
    ]
    return Result("The studio: painting, turning and the picture", _COLUMNS, rows, checks, notes)

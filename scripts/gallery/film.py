"""A film of one character, written on the bowl by the brush that is seen.

python scripts/gallery/film.py --out docs/gallery
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parent))
from sheets import run

from paint3d.app.model.document import Document
from paint3d.app.window.files.open_result import OpenResult
from paint3d.app.window.playing.recordings import tool_changes_of
from paint3d.app.window.stage import Stage
from paint3d.painter.recorded_tools import recorded_amount, recorded_brush, recorded_ink
from paint3d.recording.recording import HandTime, Recording, load_recording
from paint3d.view.camera import Camera

SIZE, FINER = (720, 540), 2
RATE, FASTER = 12, 3.0  # pictures a second, and how much faster than the hand
HOLD_S = 1.5  # that what is written is shown
FOCUS, LOOKS, HIGH, ANGLE = (-3.0, -66.8, 36.5), (28.0, 18.0), 74.0, 24.0  # mm and degrees


def film(recording: Recording) -> Iterator[Image.Image]:
    """Pictures while it is painted on a new bowl, and of the bowl after that."""
    stage = Stage((FINER * SIZE[0], FINER * SIZE[1]))
    stage.as_filmed = True
    stage.open(OpenResult.of(Document.new("bowl", 0.2, "porcelain")))
    turn, rise, angle = np.radians([*LOOKS, ANGLE])
    away = np.array([np.sin(turn), -np.cos(turn), np.tan(rise)]) * np.cos(rise)
    distance = 0.5 * HIGH / np.tan(0.5 * angle)
    focus = np.array(FOCUS)
    stage.set_camera(Camera(focus + distance * away, focus, np.array([0.0, 0.0, 1.0]), angle))
    while not stage.is_lit:
        stage.follow()
        time.sleep(0.01)
    samples = list(recording.samples())
    when = HandTime().pass_samples(recording.time_ns)
    loads, strengths = tool_changes_of(recording)
    hand = stage.open_paint_thread
    hand.use_sample_time_alone(True)
    hand.post("set_brush", recorded_brush(recording.header))
    amount = recorded_amount(recording.header).words()
    hand.post("dip", recorded_ink(recording.header), None, amount)
    hand.post("begin_stroke", loads=tuple(loads), strengths=tuple(strengths))
    fed = 0
    for k in range(int(when[-1] * RATE / FASTER)):
        due = int(np.searchsorted(when, k * FASTER / RATE, side="right"))
        hand.feed(samples[fed:due], all_time=True)
        fed = due
        yield picture(stage)
    hand.feed(samples[fed:], all_time=True)
    hand.post("end_stroke")
    stage.hide_brush()
    last = picture(stage)
    yield from (last for _ in range(int(HOLD_S * RATE)))
    stage.close()


def picture(stage: Stage) -> Image.Image:
    """What is seen when all that was asked for is painted."""
    thread = stage.open_paint_thread
    thread.post(lambda document: None).result()
    while not thread.is_still:
        stage.follow()
    pixels = stage.picture()[::-1, :, :3]
    return Image.fromarray(np.ascontiguousarray(pixels)).resize(SIZE, Image.Resampling.BOX)


def main() -> None:
    """Make the film."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/gallery"))
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        recording = Path(folder, "yong.jsonl.gz")
        run("write", "永", "--on", "bowl", "--size", 48, "--at", "0.5,0.57", "--ink", "thick",
            "--recording", recording, "--out", Path(folder, "yong.p3d"))  # fmt: skip
        first, *others = film(load_recording(recording))
    first.save(
        options.out / "stroke.webp", save_all=True, append_images=others,
        duration=round(1000 / RATE), loop=0, quality=85, method=6,
    )  # fmt: skip


if __name__ == "__main__":
    main()

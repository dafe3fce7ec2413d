"""Pictures of what a hand's events leave, painted and photographed in the real window.

xvfb-run -a -s "-screen 0 1400x900x24" python -m scripts.gallery.hand --out docs/gallery

Plays the recordings of tests/app/recordings and writes one picture of each; with --beside, old
pictures of the same gestures (a folder with those named in `BESIDE`) are put to the left of them.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from PySide6 import QtCore

from paint3d.app.window.start import make_program
from paint3d.app.window.studio import StudioWindow
from tests.support.app.event_player import (
    EventPlayer,
    EventRecording,
    open_for,
    pixel_of,
    process,
    settle,
)
from tests.support.app.windows import pretend_saved

WINDOW = (1280, 800)  # as the recordings of shares of the picture are meant
NAMES = (
    "tilt_chart", "bowl_lines", "yong_on_paper", "yong_in_bowl", "band", "brush_switch",
    "directions", "falling_pressure", "pale_ink", "zigzag", "bamboo",
)  # fmt: skip
BESIDE = {
    "tilt_chart": "a02_tilt.png",
    "bowl_lines": "a03_bowl_inside.png",
    "yong_in_bowl": "a03_bowl_yong.png",
    "yong_on_paper": "b00_yong_paper.png",
    "band": "a06_timestamps_band.png",
    "brush_switch": "a07_brush_switch_lost.png",
    "directions": "b07_chart.png",
    "falling_pressure": "b07_chart.png",
    "zigzag": "b07_chart.png",
    "pale_ink": "b03_tones.png",
    "bamboo": "b05_bamboo_wet.png",
}
RED = (214, 40, 40)


def picture_of(window: StudioWindow, name: str, options: argparse.Namespace) -> Image.Image:
    """Play a recording, and see what it left."""
    recording = EventRecording.load(name)
    open_for(window, recording.header, options.resolution)
    EventPlayer(window).play(
        recording, "as recorded" if name == "band" else "pictures", pictures_a_second=20.0,
        real_time=bool(recording.header.get("wet")),
    )  # fmt: skip
    settle(window)
    window.stage.hide_brush()
    while not window.stage.is_lit:
        process(20)
    image = Image.fromarray(np.ascontiguousarray(window.stage.picture()[::-1, :, :3]))
    if options.way:
        draw_ways(image, window, recording)
    return cropped(image, window, recording)


def draw_ways(image: Image.Image, window: StudioWindow, recording: EventRecording) -> None:
    """Draw where the pen went."""
    ratio = image.width / window.canvas.width()
    pen = ImageDraw.Draw(image)
    for stroke in recording.strokes():
        places = [pixel_of(window, e.place, recording.header.get("aspect")) for e in stroke]
        pen.line([(ratio * x, ratio * y) for x, y in places], fill=RED, width=1)


def cropped(
    image: Image.Image, window: StudioWindow, recording: EventRecording, margin: int = 60
) -> Image.Image:
    """What lies about the strokes; all of the height where they are on the object."""
    ratio = image.width / window.canvas.width()
    places = np.array([
        pixel_of(window, e.place, recording.header.get("aspect"))
        for stroke in recording.strokes() for e in stroke
    ])  # fmt: skip
    low = np.maximum(0, ratio * places.min(axis=0) - margin).astype(int)
    high = (ratio * places.max(axis=0) + margin).astype(int)
    return image.crop((*low, min(image.width, high[0]), min(image.height, high[1])))


def side_by_side(pictures: Sequence[Image.Image], height: int = 640) -> Image.Image:
    """Pictures of one height, from left to right."""
    scaled = [p.resize((round(p.width * height / p.height), height)) for p in pictures]
    whole = Image.new("RGB", (sum(p.width for p in scaled) + 12 * (len(scaled) - 1), height))
    x = 0
    for one in scaled:
        whole.paste(one, (x, 0))
        x += one.width + 12
    return whole


def main() -> None:
    """Make the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=NAMES)
    parser.add_argument("--out", type=Path, default=Path("docs/gallery"))
    parser.add_argument("--beside", type=Path, help="folder of older pictures")
    parser.add_argument("--resolution", type=float, default=0.4, help="mm")
    parser.add_argument("--way", action="store_true", help="draw the pen's way in red")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(XDG_CONFIG_HOME=folder, PAINT3D_STATE=f"{folder}/state")
        window = StudioWindow(make_program(), dark=False)
        window.resize(*WINDOW)
        window.show()
        process(50)
        for name in options.names:
            image = picture_of(window, name, options)
            old = options.beside / BESIDE[name] if options.beside and name in BESIDE else None
            if old is not None and old.exists():
                image = side_by_side([Image.open(old).convert("RGB"), image])
            image.save(options.out / f"hand_{name}.png", optimize=True)
            print(options.out / f"hand_{name}.png", image.size, flush=True)
        QtCore.QCoreApplication.processEvents()
        pretend_saved(window.stage.paint_thread)
        window.close()


if __name__ == "__main__":
    main()

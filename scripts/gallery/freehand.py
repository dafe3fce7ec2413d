"""Pictures of what a free hand draws: the eight strokes of 永, wet and dry, and lift-offs."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import PchipInterpolator

sys.path.insert(0, str(Path(__file__).parent))
from ink import sheet
from writing import seen_from_above

from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

PER_MM = 20  # pixels
RESOLUTION = 0.1  # mm
CELL = 40.0  # mm
RATE = 250.0  # samples a second
HAND_MM_S = 60.0
PAUSE_S = 0.4  # for pressing all the way down

# What the hand does for each stroke: x, y (mm), pressure.
STROKES = (
    ("侧", ((-5, 6, 0), (-2, 3, 0.2), (3, -3, 0.34), (4, -5, 0.3), (1, -4, 0.1), (-1, -2, 0))),
    ("勒", ((-14, 1, 0), (-12, -1, 0.26), (-9, -0.8, 0.2), (0, 0, 0.17), (9, 0.8, 0.2),
            (13, 1.5, 0.3), (14, 0.3, 0.28), (12.5, 0.3, 0.12), (11, 0.5, 0))),
    ("努", ((-1.5, 16, 0), (0.5, 13.5, 0.28), (0.3, 10, 0.2), (0.1, 0, 0.19), (-0.1, -6, 0.19),
            (0, -10, 0.15), (0.1, -14, 0.07), (0, -17.5, 0))),
    ("趯", ((-1.5, 16, 0), (0.7, 13.5, 0.27), (0.5, 10, 0.2), (0.5, -7, 0.2), (0.3, -11, 0.27),
            (-1.5, -12.5, 0.26), (-4.5, -10.5, 0.13), (-9, -6.5, 0))),
    ("策", ((-13, -4, 0), (-10.5, -5.5, 0.27), (-8, -4.8, 0.22), (0, -1, 0.15), (13, 6, 0))),
    ("掠", ((7, 16, 0), (8.7, 13, 0.27), (7, 7, 0.2), (2, -2, 0.18), (-7, -11, 0.12),
            (-16, -16, 0))),
    ("啄", ((6, 8, 0), (7.5, 5.5, 0.28), (5, 2, 0.2), (-2, -3, 0.1), (-9, -6.5, 0))),
    ("磔", ((-16, 13, 0), (-13.5, 11.5, 0.08), (-5, 3, 0.15), (4, -6, 0.28), (9, -10, 0.38),
            (12, -10.7, 0.29), (18, -10, 0))),
)  # fmt: skip
WAYS = ((1.0, 0), (0.2, 1_000))  # how full, and how many hairs
INK = {"pine soot": 0.25, "water": 0.75}  # as a writer grinds it
LIFTS = (40.0, 110.0, 250.0)  # mm/s
LIFT_S = 0.08
ENLARGED = 4


def moved(keys: NDArray, centre: tuple[float, float], speed: float = HAND_MM_S) -> Recording:
    """A hand that goes from place to place, rows of x, y (mm) and pressure, about a centre."""
    way = np.hypot(*np.diff(keys[:, :2], axis=0).T)
    steps = way / speed + PAUSE_S * np.abs(np.diff(keys[:, 2]))
    return timed(keys, np.concatenate([[0.0], np.cumsum(steps)]), centre)


def timed(keys: NDArray, times: NDArray, centre: tuple[float, float]) -> Recording:
    """The same, at such times (s): the tuft comes down from the upper left."""
    t = np.arange(0.0, times[-1], 1.0 / RATE)
    x, y, pressure = PchipInterpolator(times, keys)(t).T
    position = np.column_stack([centre[0] + x, centre[1] + y, np.full(len(t), 30.0)])
    half = 0.5 * math.radians(135.0)
    turned = np.tile([math.cos(half), 0.0, 0.0, math.sin(half)], (len(t), 1))
    return Recording(np.round(t * 1e9).astype(np.int64), position, turned, pressure)


def painted(surface: PaintedSurface, recording: Recording, load: float, hairs: int) -> None:
    """Paint a recording with a brush so full, dragged by the paper."""
    ink = INK if load == 1.0 else "pine soot"  # what dries out is thick
    painter = Painter(surface, "full", ink, azimuth="dragged", hairs=hairs)
    painter.wipe(1.0 - load)
    painter.replay(recording)


def eight_strokes(file: Path, _glyphs: Path) -> None:
    """Wet with a solid tuft, dry with 1,000 hairs."""
    width, height = CELL * len(STROKES), CELL * len(WAYS)
    surface = PaintedSurface(sheet(width, height), RESOLUTION, "xuan")
    for row, (load, hairs) in enumerate(WAYS):
        for column, (_, keys) in enumerate(STROKES):
            centre = CELL * (column + 0.5) - 0.5 * width, 0.5 * height - CELL * (row + 0.5)
            painted(surface, moved(np.array(keys, float), centre), load, hairs)
    box = (-0.5 * width, -0.5 * height, 0.5 * width, 0.5 * height)
    seen_from_above(surface, box, round(PER_MM * width)).save(file)


def lift_off(file: Path, _glyphs: Path) -> None:
    """Ends of strokes at three speeds, as large as above and four times enlarged."""
    wide, high, tail = 60.0, 20.0, 15.0
    surface = PaintedSurface(sheet(wide + 8.0, high * len(LIFTS) + 8.0), RESOLUTION, "xuan")
    pictures = []
    for row, speed in enumerate(LIFTS):
        y = 0.5 * high * (len(LIFTS) - 1) - high * row
        start, end = -24.0, 24.0
        last = end - speed * LIFT_S
        keys = np.array([(start, 0, 0), (start + 2, 0, 0.22), (last, 0, 0.22), (end, 0, 0)], float)
        times = np.array([0.0, 0.25, 0.25 + (last - start) / speed, 0.0])
        times[-1] = times[-2] + LIFT_S
        painted(surface, timed(keys, times, (0.0, y)), 1.0, 0)
    for row, _ in enumerate(LIFTS):
        y = 0.5 * high * (len(LIFTS) - 1) - high * row
        box = (-0.5 * wide, y - 0.5 * high, 0.5 * wide, y + 0.5 * high)
        whole = seen_from_above(surface, box, round(PER_MM * wide))
        low = y - 0.5 * whole.height / PER_MM / ENLARGED
        near = (24.0 - tail, low, 24.0, 2.0 * y - low)
        end_of_it = seen_from_above(surface, near, round(ENLARGED * PER_MM * tail))
        pictures.append((whole, end_of_it))
    height = sum(whole.height for whole, _ in pictures)
    page = Image.new("RGB", (pictures[0][0].width + pictures[0][1].width, height))
    top = 0
    for whole, end_of_it in pictures:
        page.paste(whole, (0, top))
        page.paste(end_of_it.resize((end_of_it.width, whole.height)), (whole.width, top))
        top += whole.height
    page.save(file)


PICTURES = {"eight_strokes.png": eight_strokes, "liftoff.png": lift_off}

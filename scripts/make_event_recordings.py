"""Make the recordings of device events that the studio's tests play into its window.

python scripts/make_event_recordings.py --out tests/app/recordings

What a pen, a mouse and fingers do over the picture: tilted strokes, lines and a
character in the bowl, a band in bursts of events, brushes changed in haste, starts in all
directions, falling pressure, pale ink. The format is in `tests/app/README.md`.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyph_sources import load_glyphs, open_glyphs
from paint3d.calligraphy.planning import on_paper

RATE_HZ = 100.0
STEP_MS = round(1000.0 / RATE_HZ)
TILT_45 = (35, 35)  # degrees to the right and towards the user: 45 altogether, as it is held
Pressure = float | Callable[[float], float]


class Desk:
    """Collects events of devices, one after the other.

    Parameters
    ----------
    about : str
        What the recording shows.
    header : keyword arguments
        Of the recording: object, material, brush, ink, wet, view, places.
    """

    def __init__(self, about: str, **header: object) -> None:
        self.header = {"format": "paint3d device events", "version": 1, "about": about, **header}
        self.rows: list[dict[str, object]] = []
        self.now_ms = 0

    def put(self, device: str, kind: str, place: Iterable[float] | None = None, **more) -> None:
        """Send one event, now."""
        row: dict[str, object] = {"device": device, "kind": kind}
        if place is not None:
            names = ("x", "y", "z")
            row |= {n: round(float(c), 4) for n, c in zip(names, place, strict=False)}
        row |= {name: value for name, value in more.items() if value is not None}
        self.rows.append(row | {"time_ms": self.now_ms, "handled_ms": self.now_ms + 3})

    def rest(self, ms: int) -> None:
        """Do nothing for a while."""
        self.now_ms += ms

    def key(self, key: str) -> None:
        """Press and let go a key."""
        self.put("key", "press", key=key)
        self.rest(40)
        self.put("key", "release", key=key)
        self.rest(60)

    def stroke(
        self,
        way: NDArray,
        pressure: Pressure,
        speed: float | Callable[[float], float],
        *,
        tilt: tuple[float, float] = (0, 0),
        rotation: float | None = None,
        device: str = "pen",
        stand_ms: int = 0,
        unit: float = 1.0,
    ) -> None:
        """A stroke along a line.

        Parameters
        ----------
        way : (N, 2) or (N, 3)
            mm, or shares of the picture.
        pressure : float or callable
            0 to 1; a callable gives it for the share of the way that lies behind.
        speed : float or callable
            mm/s, by share.
        tilt : (float, float)
            Degrees to the right and towards the user.
        rotation : float, optional
            Degrees.
        device : {"pen", "mouse"}
        stand_ms : int
            How long it stands where it came down.
        unit : float
            Of the way, mm: for shares of the picture, about how much of the object it shows.
        """
        places, shares = sampled(way, speed, unit)
        held: dict[str, object] = {}
        if device == "pen":
            held = {"tilt": list(tilt) if any(tilt) else None, "rotation": rotation}
        still = stand_ms // STEP_MS
        places = np.concatenate([np.repeat(places[:1], still, axis=0), places])
        shares = np.concatenate([np.zeros(still), shares])
        self.put(device, "move", places[0], **held)
        self.rest(STEP_MS)
        for k, (place, share) in enumerate(zip(places, shares, strict=True)):
            force = pressure(share) if callable(pressure) else pressure
            if device == "pen":
                held["pressure"] = round(min(1.0, max(0.002, float(force))), 3)
            self.put(device, "move" if k else "press", place, buttons=["left"], **held)
            self.rest(STEP_MS)
        held.pop("pressure", None)
        self.put(device, "release", places[-1], **held)
        self.rest(STEP_MS)
        self.put(device, "move", places[-1], **held)
        self.rest(240)

    def burst(self, ms: int) -> None:
        """Hand events over only every so often, as a slow picture lets them."""
        for row in self.rows:
            row["handled_ms"] = ms * (row["time_ms"] // ms + 1)

    def write(self, path: Path) -> None:
        """Write the recording."""
        lines = [json.dumps(row, ensure_ascii=False) for row in (self.header, *self.rows)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def sampled(
    way: NDArray, speed: float | Callable[[float], float], unit: float
) -> tuple[NDArray, NDArray]:
    """Places along a way as the device tells them, and the share of the way behind each."""
    way = np.asarray(way, float)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    total = unit * lengths[-1]
    at, shares = 0.0, [0.0]
    while at < total:
        now = speed(at / total) if callable(speed) else speed
        at = min(total, at + now / RATE_HZ)
        shares.append(at / total)
    found = np.array(shares) * lengths[-1]
    return np.stack([np.interp(found, lengths, c) for c in way.T], axis=1), np.array(shares)


def line(start: Iterable[float], end: Iterable[float]) -> NDArray:
    """A straight way."""
    return np.array([tuple(start), tuple(end)], float)


def ray(centre: tuple[float, float], degrees: float, length: float) -> NDArray:
    """A straight way about a middle."""
    angle = math.radians(degrees)
    half = 0.5 * length * np.array([math.cos(angle), math.sin(angle)])
    return np.array([np.array(centre) - half, np.array(centre) + half])


def curve(points: Iterable[tuple[float, float]], n: int = 60) -> NDArray:
    """A smooth way through points (Catmull-Rom)."""
    points = np.array(list(points), float)
    ends = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
    parts = []
    for k in range(1, len(ends) - 2):
        a, b, c, d = ends[k - 1 : k + 3]
        t = np.linspace(0.0, 1.0, n, endpoint=k == len(ends) - 3)[:, None]
        parts.append(
            0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2)
            + 0.5 * (3 * b - a - 3 * c + d) * t**3
        )
    return np.concatenate(parts)


def steps(*pairs: tuple[float, float]) -> Callable[[float], float]:
    """A course through (share, value), straight between."""
    shares, values = zip(*pairs, strict=True)
    return lambda share: float(np.interp(share, shares, values))


def pressed(height: float, landing: float = 0.08, lifting: float = 0.08) -> Callable:
    """Down, held, and up again."""
    return steps((0.0, 0.05), (landing, height), (1.0 - lifting, height), (1.0, 0.03))


# -- the recordings -------------------------------------------------------------------------------


def sheet(about: str, **more: object) -> Desk:
    """A desk with a sheet of paper, seen from above; places in mm on it."""
    header = {"object": "plane", "material": "xuan", "brush": "full", "ink": "pine soot"}
    return Desk(about, **{**header, "view": "top", "places": "object", **more})


def bowl(about: str, **more: object) -> Desk:
    """A desk with the bowl as it is seen at first; places in shares of a 900 x 734 picture."""
    header = {"object": "bowl", "material": "porcelain", "brush": "full", "ink": "pine soot"}
    return Desk(
        about, **{**header, "view": "first", "places": "canvas", "aspect": 900 / 734, **more}
    )


def tilt_chart() -> Desk:
    """Rows: 0 to 60 degrees; columns: the way the pen leans."""
    desk = sheet("strokes of a pen that leans 0 to 60 degrees (rows) to 8 sides (columns)")
    for row, degrees in enumerate((0, 15, 30, 45, 60)):
        for column in range(8):
            side = math.radians(45.0 * column)
            slope = math.tan(math.radians(degrees))
            tilt = [
                round(math.degrees(math.atan(slope * c)), 1)
                for c in (math.cos(side), -math.sin(side))
            ]
            x, y = -84.0 + 24.0 * column, 80.0 - 38.0 * row
            desk.stroke(line((x, y + 10.0), (x, y - 10.0)), 0.25, 120.0, tilt=tuple(tilt))
            desk.key("D")
    return desk


def bowl_lines() -> Desk:
    """Straight lines inside the bowl at five heights, one down its side, one outside."""
    desk = bowl("straight lines inside the bowl, upright")
    for y in (205, 264, 322, 381, 425):
        desk.stroke(line((324 / 900, y / 734), (595 / 900, y / 734)), 0.25, 90.0, unit=190.0)
    desk.stroke(line((243 / 900, 218 / 734), (303 / 900, 432 / 734)), 0.25, 90.0, unit=190.0)
    desk.stroke(line((324 / 900, 527 / 734), (600 / 900, 541 / 734)), 0.25, 90.0, unit=190.0)
    return desk


YONG = (
    (steps((0, 0.04), (0.5, 0.3), (0.85, 0.34), (1, 0.05)), steps((0, 60), (1, 50))),
    (
        steps((0, 0.05), (0.06, 0.2), (0.2, 0.14), (0.28, 0.28), (0.4, 0.22), (0.8, 0.25),
              (0.86, 0.28), (1, 0.02)),
        steps((0, 60), (0.25, 45), (0.5, 110), (0.8, 60), (1, 140)),
    ),
    (
        steps((0, 0.05), (0.08, 0.18), (0.3, 0.14), (0.42, 0.24), (0.6, 0.16), (1, 0.02)),
        steps((0, 70), (0.38, 45), (0.6, 120), (1, 220)),
    ),
    (steps((0, 0.05), (0.12, 0.24), (0.4, 0.16), (1, 0.02)), steps((0, 60), (1, 200))),
    (
        steps((0, 0.03), (0.15, 0.1), (0.72, 0.42), (0.8, 0.42), (1, 0.02)),
        steps((0, 90), (0.7, 70), (0.78, 40), (1, 130)),
    ),
)  # fmt: skip
"""Pressure and speed along the five strokes of 永."""


def yong_ways(em: float) -> list[NDArray]:
    """The five strokes' ways (N, 2), mm, about the middle of the square, y up."""
    glyph = load_glyphs(open_glyphs(None), "永")["永"]
    return [on_paper(stroke.median, em)[::4] - 0.5 * em for stroke in glyph.strokes]


def yong_on_paper() -> Desk:
    """永 by a pen held as it is held."""
    desk = sheet("永 on paper, by a pen that leans 45 degrees")
    for way, (pressure, speed) in zip(yong_ways(150.0), YONG, strict=True):
        desk.stroke(way, pressure, speed, tilt=TILT_45)
        desk.rest(200)
    return desk


def yong_in_bowl() -> Desk:
    """The same inside the bowl."""
    desk = bowl("永 inside the bowl, by a pen that leans 45 degrees", brush="zhongbaiyun")
    for way, (pressure, speed) in zip(yong_ways(1.0), YONG, strict=True):
        shares = np.array([0.5, 0.4]) + way * np.array([0.36 * 734 / 900, -0.36])
        desk.stroke(shares, lambda s, p=pressure: 0.7 * p(s), speed, tilt=TILT_45, unit=190.0)
        desk.rest(200)
    return desk


def band() -> Desk:
    """A band that changes its pace, handed over as pictures of 150 ms let it."""
    desk = sheet("a band by 1000 hairs, its events handed over every 150 ms", brush="feibai")
    way = curve([(-90, -75), (-58, -48), (-40, -15), (0, 12), (38, 24), (92, 68)])
    pressure = steps((0, 0.05), (0.06, 0.32), (0.5, 0.26), (0.75, 0.2), (1, 0.02))
    desk.stroke(way, pressure, steps((0, 70), (0.4, 150), (0.75, 260), (1, 320)))
    desk.burst(150)
    return desk


def brush_switch() -> Desk:
    """Brushes changed by keys while the painting is held, and painted with at once."""
    desk = sheet("brushes changed by keys between strokes, the painting being held", brush="dakai")
    for k, key in enumerate(("7", "6", "1", "8", "4")):
        y = 80.0 - 36.0 * k
        if k == 1:
            desk.put("painting", "hold")
        desk.key(key)
        desk.stroke(line((-70.0, y), (40.0, y)), 0.3, 220.0)
    desk.put("painting", "go on")
    return desk


def directions() -> Desk:
    """Strokes in 24 directions, each after one in another."""
    desk = sheet("strokes in 24 directions, each after one in another")
    for k in range(24):
        direction = 15.0 * (7 * k % 24)
        centre = (-80.0 + 32.0 * (k % 6), 72.0 - 48.0 * (k // 6))
        desk.stroke(ray(centre, direction, 26.0), 0.22, 130.0)
        desk.key("D")
    return desk


def long_directions() -> Desk:
    """Two tufts long, so that the start can be held against the middle."""
    desk = sheet("long strokes in 8 directions, each after one in another", brush="gongbi")
    for k in range(8):
        centre = (-72.0 + 48.0 * (k % 4), 45.0 - 90.0 * (k // 4))
        desk.stroke(ray(centre, 45.0 * (3 * k % 8), 44.0), 0.35, 140.0)
        desk.key("D")
    return desk


def falling_pressure() -> Desk:
    """Leaves, tapers, and strokes lifted fast."""
    desk = sheet("pressure that falls slowly (above) and at once (below)")
    leaf = steps((0, 0.02), (0.55, 0.5), (1, 0.01))
    taper = steps((0, 0.05), (0.12, 0.4), (1, 0.01))
    flick = steps((0, 0.05), (0.2, 0.25), (0.85, 0.22), (1, 0.05))
    desk.stroke(line((-85, 75), (75, 75)), leaf, 110.0)
    desk.key("D")
    desk.stroke(line((-85, 35), (75, 35)), taper, 110.0)
    desk.key("D")
    for k in range(4):
        start = (-80.0 + 42.0 * k, -75.0)
        end = (-60.0 + 42.0 * k, -10.0)
        desk.stroke(line(start, end), flick, steps((0, 90), (0.6, 200), (1, 500)))
    return desk


def pale_ink() -> Desk:
    """Dabs and lines in ink of 95 % water."""
    ink = {"pine soot": 0.05, "water": 0.95}
    desk = sheet("dabs and lines in pale ink", ink=ink)
    for y, height in ((75, 0.2), (40, 0.35), (5, 0.2)):
        way = curve([(-85, y), (-30, y + 4), (5, y - 1), (30, y - 3)], 20)
        desk.stroke(way, pressed(height), 120.0, stand_ms=60 if y == 5 else 0)
    dab = steps((0, 0.05), (0.5, 0.35), (1, 0.03))
    for k in range(6):
        x, y = 60.0 + 25.0 * (k % 2), 75.0 - 35.0 * (k // 2)
        desk.stroke(line((x, y + 1.0), (x, y - 1.0)), dab, 12.0)
    desk.stroke(line((-30.0, 90.0), (-30.0, -30.0)), 0.25, 140.0)
    return desk


def zigzag() -> Desk:
    """Turns, sharp and round."""
    desk = sheet("a zigzag and a spiral: turns within a stroke")
    corners = [(-85, 80), (20, 76), (-80, 40), (25, 32), (-78, 0), (30, -8)]
    desk.stroke(np.array(corners, float), pressed(0.22, 0.03, 0.03), 190.0)
    desk.key("D")
    angle = np.linspace(0.0, 3.5 * math.pi, 160)
    radius = np.linspace(6.0, 36.0, 160)
    spiral = np.stack([50.0 + radius * np.cos(angle), -50.0 + radius * np.sin(angle)], axis=1)
    desk.stroke(spiral, 0.2, 190.0)
    return desk


def bamboo() -> Desk:
    """A stalk of four joints, twigs, and leaves, in wet ink."""
    ink = {"pine soot": 0.4, "water": 0.6}
    desk = sheet("a bamboo in wet ink", ink=ink, wet=True, brush="full")
    stalk = steps((0, 0.1), (0.06, 0.3), (0.2, 0.22), (0.8, 0.22), (0.95, 0.3), (1, 0.05))
    foot = np.array([-38.0, -92.0])
    for k, length in enumerate((36.0, 42.0, 44.0, 40.0)):
        top = foot + length * np.array([0.09, 1.0])
        desk.stroke(line(foot, top), lambda s, k=k: (1.0 - 0.06 * k) * stalk(s), 90.0)
        foot = top + np.array([0.3, 3.5])
    desk.key("D")
    twig = steps((0, 0.1), (0.2, 0.07), (1, 0.03))
    for start, end in (((-28, -8), (10, 30)), ((-23, 36), (28, 70)), ((-24, 36), (-58, 66))):
        desk.stroke(line(start, end), twig, 200.0)
    leaf = steps((0, 0.03), (0.3, 0.3), (1, 0.01))
    leaves = (
        ((10, 30), (42, -2)), ((9, 30), (20, -20)), ((10, 31), (58, 26)),
        ((28, 70), (66, 48)), ((27, 69), (48, 30)), ((28, 70), (80, 76)),
        ((-58, 66), (-84, 36)), ((-57, 66), (-66, 28)), ((-58, 66), (-92, 66)),
    )  # fmt: skip
    for k, (start, end) in enumerate(leaves):
        middle = 0.5 * (np.array(start) + end) + np.array([3.0, 3.0])
        desk.stroke(curve([start, tuple(middle), end], 12), leaf, steps((0, 110), (1, 260)))
        if k % 3 == 2:
            desk.key("D")
    return desk


def mouse_lines() -> Desk:
    """A mouse's events have times too."""
    desk = sheet("lines by a mouse, handed over every 120 ms")
    for k in range(4):
        y = 60.0 - 40.0 * k
        way = curve([(-70, y), (-20, y + 10), (20, y - 10), (70, y)])
        desk.stroke(way, 1.0, steps((0, 80), (1, 260)), device="mouse")
    desk.burst(120)
    return desk


def touch_turns() -> Desk:
    """Two fingers draw apart, turn and go on; one finger drags."""
    desk = bowl("two fingers come apart and turn, and one drags")
    both = np.linspace(0.0, 1.0, 30)
    for k, share in enumerate(both):
        angle, reach = 0.6 * share, 0.06 + 0.1 * share
        kind = "press" if k == 0 else "move"
        for finger, sign in ((1, 1.0), (2, -1.0)):
            place = (0.5 + sign * reach * math.cos(angle), 0.5 + sign * reach * math.sin(angle))
            desk.put("touch", kind, place, id=finger)
        desk.rest(16)
    for finger in (1, 2):
        desk.put("touch", "release", place, id=finger)
    desk.rest(400)
    for k, x in enumerate(np.linspace(0.3, 0.6, 25)):
        desk.put("touch", "press" if k == 0 else "move", (x, 0.5), id=1)
        desk.rest(16)
    desk.put("touch", "release", (0.6, 0.5), id=1)
    return desk


MAKERS = (
    tilt_chart, bowl_lines, yong_on_paper, yong_in_bowl, band, brush_switch, directions,
    long_directions, falling_pressure, pale_ink, zigzag, bamboo, mouse_lines, touch_turns,
)  # fmt: skip
RECORDINGS: dict[str, Callable[[], Desk]] = {make.__name__: make for make in MAKERS}


def check(desk: Desk) -> None:
    """Events come in the order of their times, and are handled after they happened."""
    for before, after in pairwise(desk.rows):
        assert before["time_ms"] <= after["time_ms"]
        assert before["handled_ms"] <= after["handled_ms"]
    assert all(row["time_ms"] <= row["handled_ms"] for row in desk.rows)


def main() -> None:
    """Write the recordings."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("tests/app/recordings"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name, make in RECORDINGS.items():
        desk = make()
        check(desk)
        desk.write(options.out / f"{name}.jsonl")
        print(f"{name}: {len(desk.rows)} events, {desk.now_ms / 1000:.1f} s")


if __name__ == "__main__":
    main()

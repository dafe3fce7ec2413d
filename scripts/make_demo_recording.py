#!/usr/bin/env python3
"""Plan the demo's recording: 漫步人生 down the side of the porcelain bowl, written by two hands.

The right hand writes the strokes of an unpacked npm `hanzi-writer-data` (2.0.1); the left hand
holds the bowl, turns the place that is written on towards the writer, and sways a little. The same
glyphs give the same bytes:

    scripts/make_demo_recording.py --glyphs node_modules/hanzi-writer-data
"""

from __future__ import annotations

import argparse
import gzip
import json
import math
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.device.recorded import Recording
from paint3d.errors import Paint3DError
from paint3d.files.load import load_mesh
from paint3d.frames import (
    multiply_quaternions,
    quaternions_from_matrices,
    rotate,
    slerp,
)
from paint3d.kernels.tuft import Tuft
from paint3d.mesh.chart import SurfaceChart, SurfaceFrame, frame_at, make_chart
from paint3d.mesh.closest import ClosestPoints
from paint3d.stroke.formats_jsonl import write_jsonl
from paint3d.stroke.glyphs import load_glyph
from paint3d.stroke.ladder import build_ladder
from paint3d.stroke.planning import plan_glyph
from paint3d.stroke.timing import Motion, time_courses

TEXT = "漫步人生"
OBJECT, BRUSH, INK = "bowl", "xiaokai", "pine soot"
EM_MM = 12.5
PITCH = 0.93  # ems from one character to the next
TOP_MM = (
    7.5  # from the rim to the first em square: nearer, the lip tilts the plane of the footprint
)
WIDEST = 0.2  # ems: the ladder's last footprint
LICENCE = (
    "Stroke shapes: hanzi-writer-data 2.0.1 (Make Me a Hanzi), derived from Arphic PL KaitiM; "
    "Arphic Public License. Motion: paint3d, MIT."
)
WRITING_PLACE = np.array([0.0, 0.0, 110.0])  # world, mm: where the tip meets the bowl
LEAN = math.radians(25.0)  # of the writing place towards the writer
SWAY = math.radians(4.0), 11.0  # turn of the bowl about its axis while writing: rad, s
NOD = math.radians(2.5), 8.3  # and towards the writer
LOOK = math.radians(12.0)  # turn of the bowl while the brush is dipped
DRIFT_MM, DRIFT_S = 1.5, 13.0
DECIMALS = {"position": 4, "orientation": 6, "pressure": 6}


def main(arguments: list[str] | None = None) -> int:
    """Plan and write the recording; say what it holds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    shipped = Path(__file__).parents[1] / "paint3d/stroke/data/demo.jsonl.gz"
    parser.add_argument("--glyphs", type=Path, required=True, help="unpacked hanzi-writer-data")
    parser.add_argument("--out", type=Path, default=shipped, help="default: %(default)s")
    options = parser.parse_args(arguments)
    try:
        recording = make_recording(options.glyphs)
    except Paint3DError as error:
        print(f"{parser.prog}: error: {error}", file=sys.stderr)
        return 2
    n_bytes = write(recording, options.out)
    print(f"{options.out}: {len(recording)} samples, {recording.duration_s:.1f} s, {n_bytes} bytes")
    return 0


def make_recording(glyphs: Path) -> Recording:
    """Plan the text, lay it on the bowl and let both hands move."""
    tuft = build_tuft(load_brush(BRUSH))
    ladder = build_ladder(tuft, WIDEST * EM_MM)
    courses = [plan_glyph(load_glyph(glyphs, character), EM_MM, ladder) for character in TEXT]
    motion = time_courses(courses, EM_MM)
    charts = column_of_charts(motion)
    share = dip_shares(motion)
    position, orientation = lay(motion, charts, share, tuft)
    place, object_orientation = hold(motion, charts, share)
    drift = 2.0 * np.pi * motion.time_s[:, None] / DRIFT_S + np.array([0.0, 1.0, 2.0])
    anchor = WRITING_PLACE + DRIFT_MM * np.sin(drift)
    object_position = anchor - rotate(object_orientation, place)
    return Recording(
        np.round(motion.time_s * 1e9).astype(np.int64),
        object_position + rotate(object_orientation, position),
        multiply_quaternions(object_orientation, orientation),
        np.maximum(0.0, -motion.height) / tuft.full_press,
        motion.buttons,
        object_position,
        object_orientation,
        header=header(charts),
    )


def header(charts: list[SurfaceChart]) -> dict[str, object]:
    """What the recording says about itself; frames as in the report of `paint3d write`."""
    characters = []
    for character, chart in zip(TEXT, charts, strict=True):
        corner = chart.points([[-0.5 * EM_MM, -0.5 * EM_MM]])[0]
        frame = {
            "origin": corner.round(4).tolist(),
            "x_axis": chart.frame.x_axis.round(6).tolist(),
            "y_axis": chart.frame.y_axis.round(6).tolist(),
            "em_mm": EM_MM,
        }
        characters.append({"text": character, "frame": frame})
    return {
        "devices": {"right": "planned, 250 Hz", "left": "planned, 250 Hz"},
        "brush": BRUSH,
        "ink": INK,
        "object": OBJECT,
        "licence": LICENCE,
        "characters": characters,
    }


def column_of_charts(motion: Motion) -> list[SurfaceChart]:
    """One chart around the middle of each character's em square, down the bowl's front."""
    surface = ClosestPoints(load_mesh(OBJECT))
    low, high = surface.mesh.bounds
    middle = frame_at(surface, (0.0, low[1], 0.6 * high[2]), (0.0, 0.0, 1.0))
    rim = surface_run(surface, middle, float(high[2]))
    offsets = rim - TOP_MM - EM_MM * (0.5 + PITCH * np.arange(len(TEXT)))
    line = make_chart(surface, middle, 1.0, float(np.abs(offsets).max()) + 1.0, spacing=0.5)
    centres = line.points(np.column_stack([np.zeros(len(TEXT)), offsets]))
    charts = []
    for k, centre in enumerate(centres):
        frame = frame_at(surface, centre, (0.0, 0.0, 1.0))
        near = dip_shares(motion)[:, k] > 0.0
        far = np.abs(motion.handle[near] - 0.5 * EM_MM).max(axis=0)
        reach = np.maximum(far, 0.5 * EM_MM) + 0.5
        charts.append(make_chart(surface, frame, *reach, spacing=0.5))
    return charts


def surface_run(surface: ClosestPoints, frame: SurfaceFrame, top: float) -> float:
    """Length of the way (mm) up the wall from a frame to the rim, `top` mm high."""
    chart = make_chart(surface, frame, 1.0, 1.2 * (top - frame.origin[2]), spacing=0.25)
    ys = np.linspace(0.0, chart.half_height, 2000)
    heights = chart.points(np.column_stack([np.zeros_like(ys), ys]))[:, 2]
    return float(ys[np.argmax(heights)])


def dip_shares(motion: Motion) -> NDArray[np.float64]:
    """How much of every sample (N, characters) belongs to each character: blends in the dips."""
    n = int(motion.group.max()) + 1
    shares = (motion.group[:, None] == np.arange(n)).astype(np.float64)
    for k in range(1, n):
        inside = np.flatnonzero((motion.group == k) & (motion.buttons != 0))
        t = np.linspace(0.0, 1.0, len(inside))
        rise = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
        shares[inside, k], shares[inside, k - 1] = rise, 1.0 - rise
    return shares


def lay(
    motion: Motion, charts: list[SurfaceChart], shares: NDArray, tuft: Tuft
) -> tuple[NDArray, NDArray]:
    """Return the root's positions and object_from_pen quaternions on the bowl."""
    position = np.zeros((len(motion.time_s), 3))
    orientation = np.tile([1.0, 0.0, 0.0, 0.0], (len(motion.time_s), 1))
    bend = np.stack([np.cos(motion.azimuth), np.sin(motion.azimuth)], axis=1)
    root = tuft.length + motion.height
    for k, chart in enumerate(charts):
        here = np.flatnonzero(shares[:, k] > 0.0)
        xy = motion.handle[here] - 0.5 * EM_MM
        frames = chart.tangents(xy)
        x = np.einsum("nij,nj->ni", frames[:, :, :2], bend[here])
        z = frames[:, :, 2]
        turned = quaternions_from_matrices(np.stack([x, np.cross(z, x), z], axis=-1))
        share = shares[here, k]
        position[here] += share[:, None] * (chart.points(xy) + root[here, None] * z)
        orientation[here] = slerp(orientation[here], turned, share)
    return position, orientation


def hold(motion: Motion, charts: list[SurfaceChart], shares: NDArray) -> tuple[NDArray, NDArray]:
    """Return the written place in the object (N, 3) and the bowl's world_from_object (N, 4)."""
    place = shares @ np.array([chart.frame.origin for chart in charts])
    held = np.array([comfortable(chart.frame) for chart in charts])
    orientation = held[motion.group]
    for k in range(1, len(charts)):
        dip = (motion.group == k) & (shares[:, k - 1] > 0.0)
        orientation[dip] = slerp(
            np.tile(held[k - 1], (dip.sum(), 1)), orientation[dip], shares[dip, k]
        )
    away = 1.0 - (shares**2).sum(axis=1)  # 0 while writing, 1/2 in the middle of a dip
    t = 2.0 * np.pi * motion.time_s
    about_axis = SWAY[0] * np.sin(t / SWAY[1]) + 2.0 * LOOK * away
    nod = NOD[0] * np.sin(t / NOD[1] + 1.0)
    turned = multiply_quaternions(orientation, turns(about_axis, 2))
    return place, multiply_quaternions(turns(nod, 0), turned)


def comfortable(frame: SurfaceFrame) -> NDArray:
    """world_from_object that turns a place up, leaning towards the writer at -y."""
    sine, cosine = math.sin(LEAN), math.cos(LEAN)
    wanted = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
    there = np.stack([frame.x_axis, frame.y_axis, frame.normal], axis=-1)
    return quaternions_from_matrices((wanted @ there.T)[None])[0]


def turns(angle: NDArray, axis: int) -> NDArray:
    """Quaternions (N, 4) of turns about a coordinate axis."""
    quaternions = np.zeros((len(angle), 4))
    quaternions[:, 0], quaternions[:, 1 + axis] = np.cos(0.5 * angle), np.sin(0.5 * angle)
    return quaternions


def write(recording: Recording, file: Path) -> int:
    """Write rounded numbers (0.1 um, 1e-6), gzipped without a time stamp; return the size."""
    first, *lines = write_jsonl(recording)
    text = first + "".join(rounded(line) for line in lines)
    packed = gzip.compress(text.encode(), compresslevel=9, mtime=0)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(packed)
    return len(packed)


def rounded(line: str) -> str:
    """One sample's line with numbers as long as they need to be."""

    def shorten(entry: dict) -> dict:
        for key, value in entry.items():
            if isinstance(value, dict):
                shorten(value)
            elif key in DECIMALS:
                digits = DECIMALS[key]
                many = isinstance(value, list)
                entry[key] = [round(v, digits) for v in value] if many else round(value, digits)
        return entry

    return json.dumps(shorten(json.loads(line)), separators=(",", ":")) + "\n"


if __name__ == "__main__":
    raise SystemExit(main())

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
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.layout import Layout, layout_text
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.core.quaternion import (
    multiply_quaternions,
    quaternions_from_matrices,
    rotate,
    slerp,
)
from paint3d.device.recorded import Recording
from paint3d.errors import Paint3DError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceFrame
from paint3d.recording.recording import write_jsonl

TEXT = "漫步人生"
OBJECT, INK = "bowl", "pine soot"
EM_MM = 13.5
LAYOUT = Layout(at=(0.5, 0.55))  # high enough to keep clear of the foot
LICENCE = (
    "Stroke shapes: hanzi-writer-data 2.0.1 (Make Me a Hanzi), derived from Arphic PL KaitiM; "
    "Arphic Public License. Motion: paint3d, MIT."
)
WRITING_PLACE = np.array([0.0, 0.0, 110.0])  # world, mm: where the tip meets the bowl
LEAN = math.radians(25.0)  # of the writing place towards the writer
SWAY = math.radians(4.0), 11.0  # turn of the bowl about its axis while writing: rad, s
NOD = math.radians(2.5), 8.3  # and towards the writer
LOOK = math.radians(12.0)  # turn of the bowl on the way to the next character
DRIFT_MM, DRIFT_S = 1.5, 13.0
DECIMALS = {"position": 4, "orientation": 6, "pressure": 6}


def main(arguments: list[str] | None = None) -> int:
    """Plan and write the recording; say what it holds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    shipped = Path(__file__).parents[1] / "paint3d/calligraphy/data/demo.jsonl.gz"
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
    """Write the text down the bowl with the right hand, and let the left hand hold the bowl."""
    mesh = load_mesh(OBJECT)
    settings = WritingSettings(load_brush(choose_brush(EM_MM)), EM_MM)
    header = {
        "devices": {"right": "planned, 250 Hz", "left": "planned, 250 Hz"},
        "ink": INK,
        "licence": LICENCE,
    }
    right = write_text(mesh, TEXT, open_glyphs(glyphs), settings, LAYOUT, header=header).recording
    placed = layout_text(ClosestPoints(mesh), TEXT, EM_MM, LAYOUT)
    frames = [character.square.chart.frame for character in placed]
    time_s = 1e-9 * right.time_ns
    point, turned = hold(time_s, character_weights(right, len(frames)), frames)
    drift = 2.0 * np.pi * time_s[:, None] / DRIFT_S + np.array([0.0, 1.0, 2.0])
    anchor = WRITING_PLACE + DRIFT_MM * np.sin(drift)
    held = anchor - rotate(turned, point)
    return replace(
        right,
        position=held + rotate(turned, right.position),
        orientation=multiply_quaternions(turned, right.orientation),
        object_position=held,
        object_orientation=turned,
    )


def character_weights(recording: Recording, n: int) -> NDArray[np.float64]:
    """Compute weights of the characters at every sample (N, n), blended between them."""
    down = recording.pressure > 0.0
    dipped = np.append(False, np.diff((recording.buttons != 0).astype(int)) == 1)
    dipped[0] = recording.buttons[0] != 0
    group = np.cumsum(dipped) - 1
    if group.max() != n - 1:
        raise ValueError(f"the brush is dipped {group.max() + 1} times; expected {n}")
    weights = np.zeros((len(down), n))
    begins = 0
    for k in range(n):
        written = np.flatnonzero(down & (group == k))
        if k > 0:
            t = np.linspace(0.0, 1.0, written[0] - begins)
            rise = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
            weights[begins : written[0], k] = rise
            weights[begins : written[0], k - 1] = 1.0 - rise
        last = written[-1] + 1 if k < n - 1 else len(down)
        weights[written[0] if k > 0 else 0 : last, k] = 1.0
        begins = last
    return weights


def hold(time_s: NDArray, weights: NDArray, frames: list[SurfaceFrame]) -> tuple[NDArray, NDArray]:
    """Return the written place in the object (N, 3) and the bowl's world_from_object (N, 4)."""
    point = weights @ np.array([frame.origin for frame in frames])
    held = np.array([comfortable(frame) for frame in frames])
    orientation = held[np.argmax(weights, axis=1)]
    for k in range(1, len(frames)):
        way = (weights[:, k] > 0.0) & (weights[:, k - 1] > 0.0)
        both = np.ones((way.sum(), 1))
        orientation[way] = slerp(both * held[k - 1], both * held[k], weights[way, k])
    away = 1.0 - (weights**2).sum(axis=1)  # 0 while writing, 1/2 in the middle of a way
    t = 2.0 * np.pi * time_s
    about_axis = SWAY[0] * np.sin(t / SWAY[1]) + 2.0 * LOOK * away
    nod = NOD[0] * np.sin(t / NOD[1] + 1.0)
    turned = multiply_quaternions(orientation, turns(about_axis, 2))
    return point, multiply_quaternions(turns(nod, 0), turned)


def comfortable(frame: SurfaceFrame) -> NDArray:
    """Compute the world_from_object that turns a point up, leaning towards the writer at -y."""
    sine, cosine = math.sin(LEAN), math.cos(LEAN)
    wanted = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
    there = np.stack([frame.x_axis, frame.y_axis, frame.normal], axis=-1)
    return quaternions_from_matrices((wanted @ there.T)[None])[0]


def turns(angle: NDArray, axis: int) -> NDArray:
    """Make quaternions (N, 4) of turns about a coordinate axis."""
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
    """Round the numbers of one sample's line."""

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

#!/usr/bin/env python3
"""Learn how strokes of kaishu are shaped, by their types.

Writes paint3d/calligraphy/data/stroke_shapes.json.

Outlines and medians come from an unpacked npm `hanzi-writer-data`, the strokes' types from PyPI
`kanjivg`; characters count whose strokes are the same in both, in number and in course.

    scripts/build_stroke_shapes.py --glyphs node_modules/hanzi-writer-data
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, intersection, linestrings, prepare

from paint3d.calligraphy.glyph_sources import open_glyph_folder
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.kanjivg import find_kanjivg, load_lines
from paint3d.calligraphy.stroke_shapes import BODY, ZONE, corners_of, cut_line, is_hooked
from paint3d.errors import Paint3DError

SOURCE = (
    "Learned from outlines of hanzi-writer-data 2.0.1 (Make Me a Hanzi, derived from Arphic PL "
    "KaitiM; Arphic Public License), by the stroke types of KanjiVG (CC BY-SA 3.0)."
)
SHIPPED = Path(__file__).parents[1] / "paint3d/calligraphy/data/stroke_shapes.json"
HOOK = 0.3  # of a stroke's length, at most
FEWEST = 12  # strokes of a type
MOST = 150
FARTHEST = 130.0  # units between the ends of a stroke in both sources
REACH = 2.4  # half widths that a section or an end may reach from the line


def main(arguments: list[str] | None = None) -> int:
    """Learn and write the table; say how many strokes each type had."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--glyphs", type=Path, required=True, help="unpacked hanzi-writer-data")
    parser.add_argument("--out", type=Path, default=SHIPPED, help="default: %(default)s")
    options = parser.parse_args(arguments)
    try:
        seen = gather(options.glyphs)
    except Paint3DError as error:
        print(f"{parser.prog}: error: {error}", file=sys.stderr)
        return 2
    shapes = {kind: summarize(rows) for kind, rows in sorted(seen.items()) if len(rows) >= FEWEST}
    table = {"source": SOURCE, "units": "half widths; em 1024", "shapes": shapes}
    lines = json.dumps(table, ensure_ascii=False, separators=(",", ":")).replace('},"', '},\n"')
    options.out.write_text(lines + "\n", encoding="utf-8")
    print({kind: len(rows) for kind, rows in sorted(seen.items(), key=lambda p: -len(p[1]))})
    return 0


def gather(folder: Path) -> dict[str, list[dict]]:
    """Measurements of strokes by type, at most MOST of each, from characters in a mixed order."""
    source, lines_folder = open_glyph_folder(folder), find_kanjivg()
    if lines_folder is None:
        raise Paint3DError("the package kanjivg is not installed")
    names = sorted(p.stem for p in source.folder.glob("?.json") if ord(p.stem) > 0x2FFF)
    order = np.random.default_rng(1).permutation(len(names))
    seen: dict[str, list[dict]] = defaultdict(list)
    for text in (names[k] for k in order):
        if not (lines_folder / f"{ord(text):05x}.svg").is_file():
            continue
        lines = load_lines(lines_folder, text)
        kinds = {kind for line in lines for kind in (line.kind, line.kind[:1]) if kind}
        if all(len(seen[kind]) >= MOST for kind in kinds):
            continue
        glyph = source.load(text)
        if not same_character(glyph, lines):
            continue
        for stroke, line in zip(glyph.strokes, lines, strict=True):
            for kind in {line.kind, line.kind[:1]}:
                if kind and len(seen[kind]) < MOST:
                    row = measure(stroke, kind, len(lines))
                    if row is not None:
                        seen[kind].append(row)
    return seen


def same_character(glyph: Glyph, lines: list) -> bool:
    """Return whether all strokes agree in both sources, both scaled to one box."""
    if len(glyph.strokes) != len(lines):
        return False
    boxes = []
    for points in ([s.median for s in glyph.strokes], [s.line for s in lines]):
        every = np.concatenate(points)
        low, size = every.min(axis=0), np.maximum(np.ptp(every, axis=0), 200.0)
        boxes.append([(p - low) / size * 800.0 for p in points])
    apart = [
        max(np.linalg.norm(a[0] - b[0]), np.linalg.norm(a[-1] - b[-1]))
        for a, b in zip(*boxes, strict=True)
    ]
    return max(apart) < FARTHEST


def measure(stroke: GlyphStroke, kind: str, n_strokes: int) -> dict | None:
    """Half width, extents and sections of a stroke's segments; None where it is not as its type."""
    polygon = Polygon(stroke.outline).buffer(0.0)
    prepare(polygon)
    n_corners = corners_of(kind)
    segments = cut_line(stroke.median, n_corners, HOOK if is_hooked(kind) else 0.0)
    if len(segments) != n_corners + 1:
        return None
    half = body_half_width(polygon, segments)
    if half is None:
        return None
    rows = []
    for segment in segments:
        before, after = (extent(polygon, segment, half, end) for end in (False, True))
        lo, hi = sections(polygon, segment, segment.stations(half, before, after), half)
        rows.append({"before": before / half, "after": after / half, "lo": lo, "hi": hi})
    row = {
        "half": half,
        "length": sum(segment.length for segment in segments),
        "legs": rows,
        "n": n_strokes,
    }
    if n_corners:
        row["last"] = segments[-1].length, turn(segments[-2].points, segments[-1].points)
    return row


def body_half_width(polygon: Polygon, segments: list) -> float | None:
    """Half the median width (units) of the segments' middle parts."""
    widths = []
    for segment in segments:
        lo, hi = sections(polygon, segment, np.linspace(0.25, 0.75, 9) * segment.length, 60.0)
        widths.extend((hi - lo)[np.isfinite(hi - lo)] * 60.0)
    return 0.5 * float(np.median(widths)) if len(widths) > 4 else None


def extent(polygon: Polygon, segment, half: float, end: bool) -> float:
    """Measure how far (units) the shape extends beyond a segment's end."""
    steps = np.linspace(0.0, REACH * half, 25)
    lo, _ = sections(polygon, segment, segment.length + steps if end else -steps, half)
    gone = np.flatnonzero(~np.isfinite(lo))
    return float(steps[max(gone[0] - 1, 0)] if len(gone) else steps[-1])


def sections(polygon: Polygon, segment, distances: NDArray, half: float) -> tuple[NDArray, NDArray]:
    """Measure where sections across a line leave the shape to both sides, half widths."""
    points, lefts = segment.at(distances)
    lo, hi = np.full(len(points), np.nan), np.full(len(points), np.nan)
    aside = REACH * half * lefts
    cuts = intersection(polygon, linestrings(np.stack([points - aside, points + aside], axis=1)))
    for k, (cut, point, left) in enumerate(zip(cuts, points, lefts, strict=True)):
        pieces = [g for g in getattr(cut, "geoms", [cut]) if g.length > 0.0]
        spans = [sorted((np.array(g.coords) - point) @ left) for g in pieces]
        if spans:
            span = min(spans, key=lambda s: max(s[0], -s[-1], 0.0))
            if max(span[0], -span[-1]) < 1.2 * half:
                lo[k], hi[k] = span[0] / half, span[-1] / half
    return lo, hi


def turn(before: NDArray, after: NDArray) -> float:
    """Angle (rad) by which the last segment's chord turns from the end of the one before."""
    a, b = before[-1] - before[-30], after[-1] - after[0]
    return math.atan2(a[0] * b[1] - a[1] * b[0], a @ b)


def summarize(rows: list[dict]) -> dict:
    """Medians over the strokes of a type, and the half width's law."""
    facts = np.array([[1.0, math.log(r["n"]), math.log(r["length"])] for r in rows])
    law = np.linalg.lstsq(facts, np.log([r["half"] for r in rows]), rcond=None)[0]
    segments = []
    for k in range(len(rows[0]["legs"])):
        each = [r["legs"][k] for r in rows]
        ends = ("before", "after")
        segment = {key: round(float(np.median([e[key] for e in each])), 3) for key in ends}
        for key in ("lo", "hi"):
            values = np.array([e[key] for e in each])
            middle = np.nanmedian(values, axis=0)
            segment[key] = (
                np.interp(
                    np.arange(2 * ZONE + BODY),
                    np.flatnonzero(np.isfinite(middle)),
                    middle[np.isfinite(middle)],
                )
                .round(3)
                .tolist()
            )
        segments.append(segment)
    shape = {"strokes": len(rows), "law": law.round(4).tolist(), "legs": segments}
    if "last" in rows[0]:
        lengths, turns = np.median([r["last"] for r in rows], axis=0)
        shape["last"] = [round(float(lengths), 1), round(float(turns), 3)]
    return shape


if __name__ == "__main__":
    raise SystemExit(main())

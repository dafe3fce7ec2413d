"""Whole paintings, files of strokes and drawings, to be fuzzed."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from scripts.fuzz.mutation import damage, damage_json
from scripts.fuzz.target import Target, file_of, written

__all__ = ["DRAWINGS"]

_LONGEST_S = 5.0  # that is played of a score
_LINES = Path(__file__).parents[2] / "examples" / "bamboo.score.jsonl"


def _score_seeds() -> list[tuple[str, bytes]]:
    import gzip

    lines = _LINES.read_bytes().splitlines(keepends=True)
    layers = [
        b'{"do": "add_layer"}\n', b'{"do": "rename_layer", "place": 1, "name": "leaves"}\n',
        b'{"do": "select_layer", "place": 1}\n', b'{"do": "let_time_pass", "seconds": 2}\n',
        b'{"do": "undo"}\n', b'{"do": "dry"}\n', b'{"do": "rinse"}\n',
    ]  # fmt: skip
    short = b"".join(lines[:16])
    return [
        (".score.jsonl", short),
        (".score.jsonl.gz", gzip.compress(short, mtime=0)),
        *((".score.jsonl", short + line) for line in layers),
    ]


def _check_score(suffix: str, content: bytes) -> None:
    from paint3d.recording.score import load_score

    score = load_score(file_of(suffix, content))
    assert len(score.events) == len(score.lines)


_SAID = (
    {"do": "set_brush", "brush": "full", "length_mm": 20, "hairs": 12},
    {"do": "dip", "ink": {"own": 0.4, "water": 0.6}, "amount": {"wetted": 0.6}},
    {"do": "dip", "ink": "cinnabar", "reach": 0.3},
    {"do": "dip", "ink": {"azurite 1": 0.5, "own": 0.5}, "amount": {"fullness": 0.4}},
    {"do": "rinse"}, {"do": "let_time_pass", "seconds": 0.5},
    {"do": "set_azimuth", "azimuth": "dragged"}, {"do": "set_tags", "tags": {"trial": 1}},
    {"do": "set_mask", "angle": {"direction": [0, 0, 1], "degrees": 40}},
    {"do": "set_mask", "regions": [{"at": [0, 1, 0], "up_to": "piece"}], "inverted": True},
    {"do": "set_symmetry", "planes": [{"point": [0, 0, 0], "normal": [0, 1, 0]}]},
    {"do": "set_symmetry", "radial": {"count": 3}},
    {"do": "add_layer", "name": "a"}, {"do": "scale_brush", "factor": 1.2},
    {"do": "follow_time", "seconds": 0.05, "times": 2}, {"do": "undo", "refused": True},
    {"do": "wipe", "share": 0.5}, {"do": "set_pickup", "pickup": 0.05},
    {"do": "replay_history", "upto": 0},
    {"do": "press_seal", "rings": [[[-5, -5], [5, -5], [0, 6]]], "at": [2, 3, 0], "up": [0, 1, 0],
     "ink": "cinnabar", "coats": 1.2, "pad_mm": 3, "wear": 1, "seed": 2},
)  # fmt: skip


def _played_seeds() -> list[tuple[str, bytes]]:
    """Scores of one stroke and something before it, small enough to be played."""
    own = {"K": [1.0] * 31, "S": [0.5] * 31, "fine": 0.3, "grain_um": 12.0}
    head = {"format": "paint3d-recording", "version": 2, "object": "plane", "material": "xuan"}
    head |= {"resolution_mm": 4.0, "brush": "full", "ink": "pine soot", "pigments": {"own": own}}
    ways = ((0, -15, 0.0), (0, -14, 0.4), (6, 2, 0.3), (9, 9, 0.0))
    places = (
        {"time_ns": 40_000_000 * k, "position": [x, y, 35], "orientation": [1, 0, 0, 0],
         "pressure": press} for k, (x, y, press) in enumerate(ways)
    )  # fmt: skip
    stroke = [{"do": "begin_stroke"}, *places, {"do": "end_stroke"}]
    return [
        (".jsonl", "\n".join(map(json.dumps, (head, *between, *stroke))).encode())
        for between in ([], *([said] for said in _SAID))
    ]


def _damage_score(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Mostly a value of one line, which then still is JSON."""
    lines = data.split(b"\n")
    if chance.random() < 0.3:
        return damage(data, chance, others)
    k = chance.randrange(len(lines))
    lines[k] = damage_json(lines[k], chance)
    return b"\n".join(lines)


def _check_played(suffix: str, content: bytes) -> None:
    """Play it on a small plane, at a resolution of our own."""
    from paint3d.app.model.score.playing import begun, play
    from paint3d.app.model.score.stepping import seconds_of
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.recording.score import load_score

    score = load_score(file_of(suffix, content))
    assert seconds_of(score) >= 0.0
    corners = np.array([[-20, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]], np.float32)
    document = begun(score, TriangleMesh(corners, [(0, 1, 2), (0, 2, 3)], name="plane"), 4.0)
    began = time.process_time()
    for _ in play(document, score):
        if time.process_time() - began > _LONGEST_S:  # a great number of times, as it may say
            break
    assert np.isfinite(document.surface.amounts).all()


def _strokes_seeds() -> list[tuple[str, bytes]]:
    from paint3d.calligraphy.page.page import Photograph
    from paint3d.calligraphy.page.strokes_file import save_strokes
    from paint3d.calligraphy.page.svg_drawing import load_svg

    page = load_svg(file_of(".svg", _SVG))
    corners = np.array([[3.0, 4.0], [90.0, 2.0], [95.0, 61.0], [1.0, 60.0]])
    photograph = Photograph(Path("a.jpg"), corners, (50, 80), 0.5, np.array([2.0, 40.0]))
    made = written(".strokes.json", partial(save_strokes, page))
    said = b'"order": 7, "dryness": [0.2, 0.5], "strength": 0.4'
    taken = replace(page, photograph=photograph)
    return [
        made,
        (made[0], made[1].replace(b'"order": 1', said)),
        written(".strokes.json", partial(save_strokes, taken)),
    ]


def _damage_strokes(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    return damage(data, chance, others) if chance.random() < 0.4 else damage_json(data, chance)


def _check_strokes(suffix: str, content: bytes) -> None:
    from paint3d.calligraphy.page.strokes_file import load_strokes

    for piece in load_strokes(file_of(suffix, content)).pieces:
        assert np.isfinite(piece.at).all()
        assert all(np.isfinite(stroke.median).all() for stroke in piece.glyph.strokes)


_SVG = (
    b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100"><style>.a{fill:none;'
    b'stroke:#222;stroke-width:8}</style><defs><path id="p" d="M10 10 C 20 20, 40 20, 50 10 z"/>'
    b'</defs><g transform="rotate(10) translate(5,6)"><path class="a" d="M10,50 Q 60 0 120,60 '
    b'T 190 50"/><use href="#p" x="20" y="30"/></g><rect x="5" y="70" width="60" height="12"/>'
    b'<circle cx="150" cy="80" r="12" fill="black"/><polygon points="90,90 100,60 110,90"/></svg>'
)


_ODD_SVG = (
    b'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    b'width="50%" viewBox="-10 -10 220 120" preserveAspectRatio="xMinYMax slice"><symbol id="s" '
    b'viewBox="0 0 9 9"><ellipse cx="4" cy="4" rx="4" ry="2"/></symbol><svg x="9" y="9" width="50" '
    b'height="20"><use xlink:href="#s" width="9" height="5"/></svg><g id="a" style="stroke:red;'
    b'stroke-dasharray:4 2;stroke-linecap:round;fill-rule:evenodd" opacity=".5" '
    b'transform="matrix(1 .2 0 1 3 4) skewX(9)"><path d="m10,10h30v9.5e0l-5-5a5 9 30 1 0 20 9q1 2 '
    b'3-4t2 2s1 2 3 4zM1 1"/><line x1="1" y1="2" x2="60" y2="9" stroke-width="3mm"/><line '
    b'display="none"/></g><text x="3">a</text></svg>'
)


_CLIPPED_SVG = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="90" height="60"><defs><clipPath id="c" '
    b'clip-path="url(#d)" transform="scale(2)"><use href="#r" x="1"/><path clip-rule="evenodd" '
    b'd="M0 0h20v20h-20zM5 5h10v10h-10z"/></clipPath><clipPath id="d"><circle r="50%"/></clipPath>'
    b'<rect id="r" width="1em" height="2ex"/><linearGradient id="g"/></defs><g font-size="120%" '
    b'style="clip-path:url(#c)"><rect x="5%" width="50%" height="9vh" fill="url(#g)"/><use '
    b'href="#r" y="9"/><svg x="9" width="50%" height="50%"><ellipse rx="9%" ry="1rem" '
    b'style="stroke-width:2%;fill:url(#lost) #000"/></svg></g></svg>'
)


def _svg_seeds() -> list[tuple[str, bytes]]:
    line = b'<svg width="3cm" height="2in"><polyline fill="none" stroke="black" stroke-width="2mm" '
    short = line + b'points="1 1 20,30 40,5"/></svg>'
    return [(".svg", kind) for kind in (_SVG, _ODD_SVG, _CLIPPED_SVG, short)]


def _check_svg(suffix: str, content: bytes) -> None:
    from paint3d.calligraphy.page.svg_drawing import load_svg

    for piece in load_svg(file_of(suffix, content)).pieces:
        assert np.isfinite(piece.at).all()


DRAWINGS: dict[str, Target] = {
    "score": Target("whole paintings, line by line", _score_seeds, _check_score),
    "played": Target("whole paintings, painted", _played_seeds, _check_played, _damage_score),
    "strokes": Target("files of strokes", _strokes_seeds, _check_strokes, _damage_strokes),
    "svg": Target("drawings in SVG", _svg_seeds, _check_svg),
}

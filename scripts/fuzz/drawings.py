"""Whole paintings, files of strokes and drawings, to be fuzzed."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from scripts.fuzz.target import Target, file_of, written

__all__ = ["DRAWINGS"]

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


def _strokes_seeds() -> list[tuple[str, bytes]]:
    from paint3d.calligraphy.page.strokes_file import save_strokes
    from paint3d.calligraphy.page.svg_drawing import load_svg

    page = load_svg(file_of(".svg", _SVG))
    made = written(".strokes.json", partial(save_strokes, page))
    return [made, (made[0], made[1].replace(b'"order": 1', b'"order": 7, "dryness": [0.2, 0.5]'))]


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


def _svg_seeds() -> list[tuple[str, bytes]]:
    line = b'<svg width="3cm" height="2in"><polyline fill="none" stroke="black" stroke-width="2mm" '
    return [(".svg", _SVG), (".svg", line + b'points="1 1 20,30 40,5"/></svg>')]


def _check_svg(suffix: str, content: bytes) -> None:
    from paint3d.calligraphy.page.svg_drawing import load_svg

    for piece in load_svg(file_of(suffix, content)).pieces:
        assert np.isfinite(piece.at).all()


DRAWINGS: dict[str, Target] = {
    "score": Target("whole paintings, line by line", _score_seeds, _check_score),
    "strokes": Target("files of strokes", _strokes_seeds, _check_strokes),
    "svg": Target("drawings in SVG", _svg_seeds, _check_svg),
}

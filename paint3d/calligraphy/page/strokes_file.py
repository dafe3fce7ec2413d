"""Strokes as a plain file between taking a shape apart and painting it: ``*.strokes.json``.

Such a file is made to be looked at and corrected: strokes are split, joined, turned round, put in
another order or left out with any editor, and painted by ``paint3d write --strokes``.
"""

from __future__ import annotations

import json
import os
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import LEAST_STRENGTH, Glyph, GlyphStroke
from paint3d.calligraphy.page.page import Page, Photograph, Piece
from paint3d.core.arrays import as_array, as_number
from paint3d.core.atomic import write_atomically
from paint3d.errors import InputError

__all__ = ["load_strokes", "save_strokes"]

_FORMAT = "paint3d strokes 1"
_DECIMALS = 3
_MOST_BYTES = 200_000_000
_LONGEST_SHEET = 3200  # pixels of a photographed sheet laid flat
_PER_UNIT = (1e-4, 1e3)  # pixels to a glyph unit


def save_strokes(page: Page, file: Path) -> None:
    """Write a page.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    pieces = [_piece_words(piece) for piece in page.pieces]
    head: dict[str, Any] = {"format": _FORMAT, "source": page.source, "licence": page.licence}
    if page.photograph is not None:
        head["photograph"] = _photograph_words(page.photograph, file)
    lines = [f"{json.dumps(key)}: {_as_json(value)}," for key, value in head.items()]
    body = ",\n".join(_write_piece(piece) for piece in pieces)
    with write_atomically(file) as part:
        text = "{\n" + "\n".join(lines) + f'\n"pieces": [\n{body}\n]\n}}\n'
        part.write_text(text, encoding="utf-8")


def _photograph_words(photograph: Photograph, file: Path) -> dict[str, Any]:
    """A photograph as JSON: its path relative to the file of strokes, and its sheet's corners."""
    try:
        where = photograph.file.parent.resolve() / photograph.file.name
        there = Path(os.path.relpath(where, file.parent.resolve())).as_posix()
    except ValueError:  # on another drive
        there = photograph.file.name
    return {
        "file": there,
        "corners": _round(photograph.corners),
        "size": list(photograph.size),
        "per_unit": photograph.per_unit,
        "origin": _round(photograph.origin),
        "invert": photograph.invert,
        "sha256": photograph.digest,
    }


def _write_piece(piece: dict[str, Any]) -> str:
    """A piece as JSON, one stroke a line."""
    strokes = ",\n  ".join(json.dumps(stroke) for stroke in piece["strokes"])
    head = _as_json({k: v for k, v in piece.items() if k != "strokes"})
    return f'{head[:-1]}, "strokes": [\n  {strokes}\n]}}'


def _as_json(value: Any) -> str:
    """JSON to be read; what of a name is no UTF-8 as escapes, which give back the same name."""
    text = json.dumps(value, ensure_ascii=False)
    try:
        text.encode()
    except UnicodeEncodeError:
        return json.dumps(value)
    return text


def _piece_words(piece: Piece) -> dict[str, Any]:
    glyph = piece.glyph
    strokes = [_stroke_words(k + 1, stroke) for k, stroke in enumerate(glyph.strokes)]
    words = {
        "text": glyph.text,
        "at": _round(np.array(piece.at)),
        "box": _round(np.array(glyph.box)),
        "strokes": strokes,
    }
    flags = {"solid": glyph.solid, "joined": glyph.joined}
    return {**words, **{name: True for name, holds in flags.items() if holds}}


def _stroke_words(order: int, stroke: GlyphStroke) -> dict[str, Any]:
    rings = [_round(ring) for ring in (stroke.outline, *stroke.holes)]
    words: dict[str, Any] = {"order": order, "line": _round(stroke.median), "rings": rings}
    if stroke.dryness:
        words["dryness"] = list(stroke.dryness)
    if stroke.strength < 1.0:
        words["strength"] = round(stroke.strength, _DECIMALS)
    return words


def _round(values: NDArray[np.float64]) -> Any:
    return (np.round(values, _DECIMALS) + 0.0).tolist()


def load_strokes(file: Path | str) -> Page:
    """Read a page.

    Raises
    ------
    InputError
        If the file cannot be read, or is not such a page; the message says where.
    """
    path = Path(file)
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(
                "{file}: larger than {most:,} bytes; expected strokes",
                file=path,
                most=_MOST_BYTES,
            )
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as cause:
        raise InputError("{file}: {cause}", file=path, cause=cause) from None
    except (ValueError, RecursionError) as cause:
        raise InputError(
            "{file}: not JSON ({cause}); expected strokes", file=path, cause=cause
        ) from None
    if not isinstance(data, dict) or data.get("format") != _FORMAT:
        raise InputError(
            '{file}: expected an object with "format": "{expected}"',
            file=path,
            expected=_FORMAT,
        )
    known: dict[str, Glyph] = {}
    pieces = [
        _parse_piece(piece, f"{path}: piece {k + 1}", known)
        for k, piece in enumerate(_require_list(data, "pieces", f"{path}"))
    ]
    source, licence = (_require_text(data, key, f"{path}") for key in ("source", "licence"))
    photograph = None
    if data.get("photograph") is not None:
        photograph = _parse_photograph(data["photograph"], path)
    return Page(tuple(pieces), source, licence, photograph)


def _parse_photograph(data: Any, path: Path) -> Photograph:
    """The photograph that strokes say they are from; whether it is there is not looked at."""
    name = f"{path}: photograph"
    corners = as_array(_require_list(data, "corners", name), f"{name}: corners", (4, 2))
    height, width = as_array(_require_list(data, "size", name), f"{name}: size", (2,)).tolist()
    origin = as_array(_require_list(data, "origin", name), f"{name}: origin", (2,))
    per_unit = as_number(data.get("per_unit"), f"{name}: per_unit", *_PER_UNIT)
    for side in (height, width):
        if not (side.is_integer() and 1 <= side <= _LONGEST_SHEET):
            raise InputError(
                "{name}: size is {side:g}; expected 1 to {most} pixels",
                name=name,
                side=side,
                most=_LONGEST_SHEET,
            )
    there = _require_text(data, "file", name)
    windows = PureWindowsPath(there)
    if windows.anchor or PurePosixPath(there).is_absolute() or "\\" in there or not windows.name:
        raise InputError(
            "{name}: file is {there!r}; expected its place seen from {file}",
            name=name,
            there=there,
            file=path.name,
        )
    file = path.parent / there
    invert = data.get("invert", False) is True
    digest = _require_text(data, "sha256", name).lower() if "sha256" in data else ""
    return Photograph(file, corners, (int(height), int(width)), per_unit, origin, invert, digest)


def _parse_piece(data: Any, name: str, known: dict[str, Glyph]) -> Piece:
    """A piece; its glyph is one of those known already where it is the same."""
    at = as_array(_require_list(data, "at", name), f"{name}: at", (2,))
    key = json.dumps({**data, "at": None}, sort_keys=True)
    if key not in known:
        known[key] = _parse_glyph(data, name)
    return Piece(known[key], (float(at[0]), float(at[1])))


def _parse_glyph(data: dict[str, Any], name: str) -> Glyph:
    strokes = _require_list(data, "strokes", name)
    read = [_parse_stroke(stroke, f"{name}, stroke {k + 1}") for k, stroke in enumerate(strokes)]
    read.sort(key=lambda one: one[0])
    box = as_array(_require_list(data, "box", name), f"{name}: box", (4,))
    if not (box[2:] > box[:2]).all():
        raise InputError(
            "{name}: box is {box}; expected left, lower, right, upper side",
            name=name,
            box=box.tolist(),
        )
    left, lower, right, upper = box.tolist()
    return Glyph(
        _require_text(data, "text", name),
        tuple(stroke for _, stroke in read),
        (left, lower, right, upper),
        solid=data.get("solid", False) is True,
        joined=data.get("joined", False) is True,
    )


def _parse_stroke(data: Any, name: str) -> tuple[float, GlyphStroke]:
    """Its number in the order of writing, and the stroke."""
    rings = [
        as_array(ring, f"{name}: ring {k + 1}", (None, 2))
        for k, ring in enumerate(_require_list(data, "rings", name))
    ]
    if not rings or min(map(len, rings)) < 3:
        raise InputError(
            "{name}: expected rings of 3 points or more, the outer one first",
            name=name,
        )
    line = as_array(_require_list(data, "line", name), f"{name}: line", (None, 2))
    if len(line) < 2:
        raise InputError("{name}: line has {n} points; expected 2 or more", name=name, n=len(line))
    dryness = as_array(data.get("dryness", []), f"{name}: dryness", (None,))
    if ((dryness < 0.0) | (dryness > 1.0)).any():
        raise InputError(
            "{name}: dryness is {dryness}; expected numbers from 0 to 1",
            name=name,
            dryness=dryness.tolist(),
        )
    order = as_number(data.get("order"), f"{name}: order")
    strength = as_number(data.get("strength", 1.0), f"{name}: strength", LEAST_STRENGTH, 1.0)
    holes = tuple(rings[1:])
    return order, GlyphStroke(rings[0], line, holes, tuple(dryness.tolist()), strength)


def _require_list(data: Any, key: str, name: str) -> list[Any]:
    value = data.get(key) if isinstance(data, dict) else None
    if not isinstance(value, list):
        raise InputError("{name}: expected an object with a list named {key}", name=name, key=key)
    return value


def _require_text(data: dict[str, Any], key: str, name: str) -> str:
    value = data.get(key)
    if not isinstance(value, str):
        raise InputError(
            "{name}: {key} is {value!r}; expected text",
            name=name,
            key=key,
            value=value,
        )
    return value

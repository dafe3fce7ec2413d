"""Centre lines of characters from the package `kanjivg` (KanjiVG, CC BY-SA 3.0), if installed.

Each character is an SVG of 109 x 109 units with one path a stroke, in writing order, marked with
its type: one of the stroke characters from U+31C0 on, sometimes with a letter.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import DESCENDER, EM_UNITS, split_path
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["LineStroke", "find_kanjivg", "load_lines", "parse_lines"]

# ---- Where it is ---------------------------------------------------------------------------------
# Where the package `kanjivg` keeps its characters, if it is installed.


@lru_cache(maxsize=1)
def find_kanjivg() -> Path | None:
    """The folder with the characters, or None where the package is not installed."""
    for entry in sys.path:  # where pip has put it; `importlib.metadata` takes 10 ms to find it
        folder = Path(entry, "kanji")
        if not os.path.isdir(folder):  # nor where one may not look: `Path.is_dir` raises there
            continue
        if next(folder.parent.glob("kanjivg-*.dist-info"), None) is not None:
            return folder
    return _find_anywhere()


def _find_anywhere() -> Path | None:
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        package = distribution("kanjivg")
    except PackageNotFoundError:
        return None
    folder = Path(str(package.locate_file("kanji")))
    return folder if folder.is_dir() else None


# ---- Characters ----------------------------------------------------------------------------------


_BOX = 109.0
_NUMBERS = {"M": 2, "L": 2, "C": 6, "S": 4, "Z": 0}
_SIZES = {**_NUMBERS, **{command.lower(): size for command, size in _NUMBERS.items()}}
_POINTS_PER_CURVE = 24


@dataclass(frozen=True, eq=False)
class LineStroke:
    """A stroke without a width.

    Attributes
    ----------
    kind : str
        Its type, such as "㇐" or "㇕b"; empty where the file does not say.
    line : (N, 2) float64
        In writing order, glyph units.
    """

    kind: str
    line: NDArray[np.float64]


def load_lines(folder: Path, text: str) -> list[LineStroke]:
    """The strokes of one character.

    Raises
    ------
    InputError
        If the folder has no file for the character, or it is broken.
    """
    file = folder / f"{ord(text):05x}.svg"
    try:
        return parse_lines(file.read_text(encoding="utf-8"), file.name)
    except FileNotFoundError:
        raise InputError(
            "{folder} has no {file} for {text!r}",
            folder=folder,
            file=file.name,
            text=text,
        ) from None
    except (OSError, UnicodeDecodeError) as cause:
        raise InputError("{file}: cannot be read ({cause})", file=file, cause=cause) from None


def parse_lines(svg: str, name: str = "svg") -> list[LineStroke]:
    """The strokes in the text of a file.

    Raises
    ------
    InputError
        If it is not XML, has no strokes, or one of them is no path of M, L, C and S.
    """
    try:
        root = ElementTree.fromstring(svg)
    except ElementTree.ParseError as cause:
        raise InputError("{name}: not XML ({cause})", name=name, cause=cause) from None
    strokes: list[LineStroke] = []
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        kinds = [value for key, value in path.attrib.items() if key.endswith("}type")]
        kind = kinds[0].split("/")[0].strip() if kinds else ""
        line = _line(path.get("d", ""), f"{name}: stroke {len(strokes) + 1}")
        strokes.append(LineStroke(kind, line))
    if not strokes:
        raise InputError("{name}: no strokes; expected paths", name=name)
    return strokes


def _line(path: str, name: str) -> NDArray[np.float64]:
    """Points along a path, in glyph units."""
    points: list[AnyArray] = []
    control = None  # second control point of the curve before
    for command, numbers in split_path(path, name, _SIZES):
        kind = command.upper()
        if (kind == "M") != (not points) or kind == "Z":
            raise InputError(
                "{name}: {command} out of place; expected one open line",
                name=name,
                command=command,
            )
        values = np.array(numbers).reshape(-1, _NUMBERS[kind] // 2, 2)
        for group in values:
            here = points[-1] if points else np.zeros(2)
            group = group + here if command.islower() else group
            if kind in "ML":
                points.append(group[0])
                control = None
                continue
            first = group[0] if kind == "C" else (here if control is None else 2 * here - control)
            control, end = group[-2], group[-1]
            t = np.linspace(0.0, 1.0, _POINTS_PER_CURVE + 1)[1:, None]
            s = 1.0 - t  # the cubic's Bernstein polynomials
            curve = s**3 * here + 3 * s * s * t * first + 3 * s * t * t * control + t**3 * end
            points.extend(list(curve))
    line = np.array(points)
    if len(line) < 2 or not np.ptp(line, axis=0).any():
        raise InputError("{name} has no length; expected a line", name=name)
    scale = EM_UNITS / _BOX
    return np.column_stack([line[:, 0] * scale, EM_UNITS - DESCENDER - line[:, 1] * scale])

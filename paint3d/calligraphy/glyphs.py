"""Glyphs: stroke outlines and centre lines read from a folder of `hanzi-writer-data`.

A glyph lives in an em square of 1024 units with y upwards. Its lower left corner is the point
(0, -124) of the data, so a unit (x, y) lies at em / 1024 * (x, y + 124) on paper.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_array
from paint3d.core.polyline import bezier_points
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = [
    "DESCENDER",
    "EM_BOX",
    "EM_UNITS",
    "LEAST_STRENGTH",
    "Box",
    "Glyph",
    "GlyphStroke",
    "flatten_path",
    "load_glyph",
    "split_path",
]

# ---- Path commands -------------------------------------------------------------------------------
# The commands of an SVG path.


_TOKEN = re.compile(r"([A-Za-z])|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|[\s,]+")


def split_path(path: str, name: str, sizes: Mapping[str, int]) -> list[tuple[str, list[float]]]:
    """Split a path into its commands with their numbers.

    Parameters
    ----------
    path : str
    name : str
        Of the path, for messages.
    sizes : mapping
        Of each command that may come, how many numbers it takes; some may take several times as
        many.

    Raises
    ------
    InputError
        If there is anything else in the path, or a command has not its numbers.
    """
    if not isinstance(path, str):
        raise InputError("{name} is {file!r}; expected an SVG path", name=name, file=path)
    commands: list[tuple[str, list[float]]] = []
    at = 0
    while at < len(path):
        match = _TOKEN.match(path, at)
        if match is None or (match[1] or "M") not in sizes or (match[2] and not commands):
            raise InputError(
                "{name}: cannot read {file!r}; expected {sizes}",
                name=name,
                file=path[at : at + 12].strip(),
                sizes=" ".join(sizes),
            )
        if match[1]:
            commands.append((match[1], []))
        elif match[2]:
            commands[-1][1].append(float(match[2]))
        at = match.end()
    for command, numbers in commands:
        size = sizes[command]
        if (size == 0 and numbers) or (size and (not numbers or len(numbers) % size)):
            raise InputError(
                "{name}: {command} has {n} numbers; expected {size}",
                name=name,
                command=command,
                n=len(numbers),
                size=size,
            )
    return commands


# ---- Glyphs --------------------------------------------------------------------------------------


EM_UNITS = 1024.0
LEAST_STRENGTH = 0.05
"""Of a stroke's ink: paler ones are not seen."""
DESCENDER = 124.0
Box: TypeAlias = tuple[float, float, float, float]
"""Left, lower, right and upper side, glyph units."""
EM_BOX: Box = (0.0, -DESCENDER, EM_UNITS, EM_UNITS - DESCENDER)

_NUMBERS = {"M": 2, "L": 2, "Q": 4, "C": 6, "Z": 0}
_FLATNESS = 0.15  # units that a chord may stray from its curve


@dataclass(frozen=True, eq=False)
class GlyphStroke:
    """A stroke of a glyph, in glyph units.

    Attributes
    ----------
    outline : (N, 2) float64
        Closed polygon; the last point is not the first one again.
    median : (M, 2) float64
        Centre line in writing order.
    holes : tuple of (K, 2) float64
        Closed polygons that are left out of the outline, as in a stroke that closes on itself.
    dryness : tuple of float
        How dry the brush was at even stations along the line, 0 to 1, where that is known.
    strength : float
        How black its ink is: the fraction of the light that it takes, over what black ink takes.
    """

    outline: NDArray[np.float64]
    median: NDArray[np.float64]
    holes: tuple[NDArray[np.float64], ...] = ()
    dryness: tuple[float, ...] = ()
    strength: float = 1.0

    def polygon(self) -> Polygon | MultiPolygon:
        """The region that it fills; repaired where its outline crosses itself."""
        import shapely

        area = shapely.Polygon(self.outline, self.holes)
        return area if area.is_valid else area.buffer(0.0)

    @classmethod
    def filling(
        cls, region: Polygon, median: AnyArray, dryness: Sequence[float] = (), strength: float = 1.0
    ) -> GlyphStroke:
        """The stroke along a line (M, 2) that fills a region."""
        outer, *holes = (
            np.array(ring.coords)[:-1] for ring in (region.exterior, *region.interiors)
        )
        return cls(outer, median, tuple(holes), tuple(dryness), strength)

    def mapped(self, change: Callable[[AnyArray], AnyArray]) -> GlyphStroke:
        """The stroke with all its points (N, 2) changed."""
        holes = tuple(change(hole) for hole in self.holes)
        return replace(self, outline=change(self.outline), median=change(self.median), holes=holes)


@dataclass(frozen=True, eq=False)
class Glyph:
    """A character, a word or a piece of a drawing, and its strokes in writing order.

    Attributes
    ----------
    text : str
    strokes : tuple of GlyphStroke
    box : Box
        What it is laid on a surface by: the em square, or a box of its own.
    solid : bool
        Whether it is a filled shape, of which nothing is to stay bare: it is written without
        variation, and the brush is dipped as often as it takes. What the strokes leave of their
        outlines is dabbed, unless one says how dry or how pale it is.
    joined : bool
        Whether one shape was taken apart into its strokes, as of a font: they vary as one, so that
        they stay together.
    """

    text: str
    strokes: tuple[GlyphStroke, ...]
    box: Box = EM_BOX
    solid: bool = False
    joined: bool = False

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of the box, glyph units."""
        left, lower, right, upper = self.box
        return 0.5 * (left + right), 0.5 * (lower + upper)


def load_glyph(folder: Path | str, text: str) -> Glyph:
    """Read one character from a folder of `hanzi-writer-data`.

    Parameters
    ----------
    folder : path
        Holds one JSON file per character.
    text : str
        A single character.

    Raises
    ------
    InputError
        If `text` is not one character, the folder has no file for it, or the file is broken.
    """
    if len(text) != 1:
        raise InputError("text is {text!r}; expected a single character", text=text)
    file = Path(folder) / f"{text}.json"
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
        paths, medians = data["strokes"], data["medians"]
    except FileNotFoundError:
        raise InputError(
            "{folder} has no glyph for {text!r}; expected a file {file}",
            folder=folder,
            text=text,
            file=file.name,
        ) from None
    except OSError as cause:
        raise InputError("{file}: {cause}", file=file, cause=cause) from None
    except (ValueError, KeyError, TypeError) as cause:
        raise InputError(
            "{file}: not a glyph ({cause}); expected strokes and medians",
            file=file,
            cause=cause,
        ) from None
    if not isinstance(paths, list) or not isinstance(medians, list) or len(paths) != len(medians):
        raise InputError("{file}: expected as many medians as strokes", file=file)
    strokes = []
    for k, (path, points) in enumerate(zip(paths, medians, strict=True)):
        median = as_array(points, f"{file}: medians[{k}]", (None, 2))
        if len(median) < 2:
            raise InputError(
                "{file}: medians[{k}] has {n} points; expected 2 or more",
                file=file,
                k=k,
                n=len(median),
            )
        strokes.append(GlyphStroke(flatten_path(path, f"{file}: strokes[{k}]"), median))
    return Glyph(text, tuple(strokes))


def flatten_path(path: str, name: str = "path") -> NDArray[np.float64]:
    """Turn an SVG path of absolute M, L, Q, C and Z into a polygon (N, 2).

    Raises
    ------
    InputError
        If the path has other commands, a wrong number of coordinates, more than one closed curve,
        or fewer than three different points.
    """
    points: list[NDArray[np.float64]] = []
    closed = False
    for command, numbers in split_path(path, name, _NUMBERS):
        if closed or (command == "M") != (not points):
            raise InputError(
                "{name}: {command} out of place; expected one closed curve from M",
                name=name,
                command=command,
            )
        closed = command == "Z"
        pairs = np.array(numbers, np.float64).reshape(-1, 2)
        per = _NUMBERS[command] // 2
        for first in range(0, len(pairs), per or 1):
            controls = pairs[first : first + per]
            curved = per > 1
            hull = np.vstack([points[-1], controls]) if curved else controls
            points.extend(bezier_points(hull, _FLATNESS) if curved else controls)
    polygon = np.array(points, np.float64).reshape(-1, 2)
    if len(polygon):
        polygon = polygon[np.any(polygon != np.roll(polygon, 1, axis=0), axis=1)]
    if len(polygon) < 3:
        raise InputError(
            "{name}: {n} different points; expected 3 or more",
            name=name,
            n=len(polygon),
        )
    return polygon

"""Strokes on a plane as SVG: one path a stroke, in millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError

__all__ = ["write_svg"]


def write_svg(
    path: Path,
    groups: Sequence[tuple[str, Sequence[Sequence[AnyArray]]]],
    bounds: tuple[float, float, float, float],
    title: str = "",
) -> None:
    """Write the outlines of strokes.

    Parameters
    ----------
    path : Path
    groups : sequence of (str, sequence of sequences of (N, 2) arrays)
        Strokes of one colour, as ``#rrggbb``: the rings of each, mm, y upwards; holes run the other
        way round.
    bounds : (low x, low y, high x, high y)
        Of the sheet, mm.
    title : str

    Raises
    ------
    ExportError
        If there is nothing to write, or the file cannot be written.
    """
    if not any(strokes for _, strokes in groups):
        raise ExportError("{file}: there are no strokes; expected at least one", file=path)
    x, y, right, top = bounds
    width, height = right - x, top - y
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="{x:g} {-top:g} {width:g} {height:g}">',
        f"<title>{_escape(title)}</title>",
    ]
    for colour, strokes in groups:
        lines.append(f'<g fill="{colour}" fill-rule="nonzero">')
        lines += [f'<path d="{"".join(map(_ring, rings))}"/>' for rings in strokes]
        lines.append("</g>")
    lines.append("</svg>")
    with write_atomically(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _ring(points: AnyArray) -> str:
    flipped = np.round(np.asarray(points) * [1.0, -1.0], 4) + 0.0
    first, *others = (f"{px:.7g} {py:.7g}" for px, py in flipped)
    return f"M{first}L{' '.join(others)}Z"


def _escape(text: str) -> str:
    printable = "".join(c if c.isprintable() else " " for c in text)
    return printable.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")

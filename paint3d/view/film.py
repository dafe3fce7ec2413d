"""Films: pictures one after the other, in a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO

from PIL import Image

from paint3d.core.machine import reserve_space
from paint3d.errors import ExportError
from paint3d.view.mp4 import find_encoder, write_mp4

__all__ = ["FILMS", "MOST_PIXELS", "film_form", "is_held_whole", "write_film"]

FILMS = {".mp4": "MP4", ".webp": "WEBP", ".gif": "GIF"}
"""What the formats of films are called by who writes them."""
MOST_PIXELS = 4e8
"""Of all pictures of a film that is held in memory until it is written."""


def film_form(path: Path) -> str:
    """The format of a film by its suffix, if it can be written here.

    Raises
    ------
    ExportError
        If the suffix is that of no film, or what writes .mp4 is not installed.
    """
    form = FILMS.get(path.suffix.lower())
    if form is None:
        raise ExportError(f"{path}: a film is written as {', '.join(FILMS)}")
    if form == "MP4":
        find_encoder()
    return form


def is_held_whole(form: str) -> bool:
    """Whether pictures of such a film stay in memory until it is written."""
    return form != "MP4"


def write_film(
    part: Path,
    pictures: Iterator[Image.Image],
    n: int,
    form: str,
    rate: float,
    how: Mapping[str, Any] | None = None,
) -> None:
    """Write a film; its pictures are asked for one after the other.

    What it will take of the disk is kept free for it when two pictures are there: where there is no
    room for it, no more are asked for. For an .mp4, whose size nobody can tell, nothing is.

    Parameters
    ----------
    part : Path
        A file that is there, and is written over.
    pictures : iterator of Image
        All of one size.
    n : int
        How many, 2 at least.
    form : str
        One of those of `FILMS`.
    rate : float
        Pictures a second. A GIF counts hundredths of a second, a WebP thousandths.
    how : mapping, optional
        What Pillow is told besides for a GIF or a WebP, such as its quality and its profile.

    Raises
    ------
    ExportError, OSError
        If it cannot be written.
    """
    if form == "MP4":
        write_mp4(part, pictures, rate)
        return
    how = how or {}
    with open(part, "r+b") as file:
        first, second = next(pictures), next(pictures)
        reserve_space(file, _film_bytes(first, second, n, form, how))
        _write(file, first, chain([second], pictures), form, rate, how)
        file.truncate()


def _write(
    file: BinaryIO,
    first: Image.Image,
    others: Iterable[Image.Image],
    form: str,
    rate: float,
    how: Mapping[str, Any],
) -> None:
    duration = round(1e3 / rate)
    first.save(file, form, save_all=True, append_images=others, duration=duration, loop=0, **how)


def _film_bytes(
    first: Image.Image, second: Image.Image, n: int, form: str, how: Mapping[str, Any]
) -> int:
    """About what a film of n pictures takes that begins with these two."""
    sizes = []
    for others in ([], [second]):
        _write(short := BytesIO(), first, others, form, 1.0, how)
        sizes.append(len(short.getvalue()))
    return sizes[0] + (n - 1) * max(0, sizes[1] - sizes[0])

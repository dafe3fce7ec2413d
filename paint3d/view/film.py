"""Films: pictures one after the other, in a file."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from typing import BinaryIO

from PIL import Image

__all__ = ["FILMS", "film_bytes", "write_film"]

FILMS = {".gif": "GIF", ".webp": "WEBP"}
"""What the formats of films are called by who writes them."""


def write_film(
    file: BinaryIO, first: Image.Image, others: Iterable[Image.Image], form: str, rate: float
) -> None:
    """Write a film; its pictures are asked for one after the other."""
    duration = round(1e3 / rate)
    first.save(file, form, save_all=True, append_images=others, duration=duration, loop=0)


def film_bytes(first: Image.Image, second: Image.Image, n: int, form: str) -> int:
    """About what a film of n pictures takes that begins with these two."""
    sizes = []
    for others in ([], [second]):
        write_film(short := BytesIO(), first, others, form, 1.0)
        sizes.append(len(short.getvalue()))
    return sizes[0] + (n - 1) * max(0, sizes[1] - sizes[0])

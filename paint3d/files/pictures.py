"""A picture of a painting, or a film of it turning, written to a file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from PIL import Image

from paint3d.colour.viewing import Viewing
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, InputError
from paint3d.files.export import gloss_of
from paint3d.files.export_options import ExportOptions
from paint3d.files.progress import Progress
from paint3d.files.project.painting import Exportable, Painting, read_painting
from paint3d.files.writers.colour_tags import picture_tags
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.view.shot import Shot, take_shot, take_turning

__all__ = ["FILM_SUFFIXES", "PICTURE_SUFFIXES", "Turning", "write_picture"]

PICTURE_SUFFIXES, FILM_SUFFIXES = (".png", ".webp"), (".gif", ".webp")
_FORMS = {".png": "PNG", ".webp": "WEBP", ".gif": "GIF"}
_QUALITY = 92  # of a WebP
_MOST_PIXELS = 4e8  # of all pictures of a film


class Turning(NamedTuple):
    """How a film of an object turning once is to be: how long, s, and pictures a second."""

    seconds: float = 4.0
    rate: float = 12.0

    @property
    def n_pictures(self) -> int:
        """How many pictures it has, 2 at least."""
        return max(2, round(self.seconds * self.rate))


def write_picture(
    painting: Exportable | TriangleMesh,
    path: str | os.PathLike[str],
    shot: Shot | None = None,
    turning: Turning | None = None,
    material: str | None = None,
    progress: Progress | None = None,
    viewing: Viewing | None = None,
) -> None:
    """Write a picture (.png, .webp), or a film of the object turning once (.gif, .webp).

    Parameters
    ----------
    painting : PaintedSurface or TriangleMesh
    path : path-like
        An existing file is replaced at the end, in one step; after a failure it is as it was.
    shot : Shot, optional
        Default: onto the painted side, in the studio.
    turning : Turning, optional
        Make a film.
    material : str, optional
        Whose gloss is shown; by default that of the painting, and glazed porcelain for meshes.
    progress : callable, optional
        Called with the share done; what it raises leaves everything as it was.
    viewing : Viewing, optional
        In which light, by which observer and for which screen; a .gif has sRGB only.

    Raises
    ------
    InputError
        If the shot cannot be taken so.
    ExportError
        If the suffix does not fit, the film would be too large, or the file cannot be written.
    """
    path, shot = Path(path), shot or Shot()
    form = _form_of(path, shot, turning)
    if viewing is not None and viewing.gamut != "srgb" and form == "GIF":
        raise InputError(f"{path}: a .gif is in sRGB; expected .png or .webp for {viewing.gamut}")
    read = read_painting(painting, ExportOptions(viewing=viewing))
    assert isinstance(read, Painting), "no texture was asked for"
    gloss = gloss_of(material or read.material)
    arrays, how = read[:4], _how(form) | picture_tags(read.gamut, form)
    with write_atomically(path, progress) as part:
        if turning is None:
            Image.fromarray(take_shot(arrays, shot, gloss)).save(part, form, **how)
            return
        pictures = map(Image.fromarray, take_turning(arrays, shot, turning.n_pictures, gloss))
        told = _told(pictures, turning.n_pictures, progress)
        first = next(told)
        duration = round(1e3 / turning.rate)
        first.save(
            part, form, save_all=True, append_images=chain(told), duration=duration, loop=0,
            **how,
        )  # fmt: skip


def _form_of(path: Path, shot: Shot, turning: Turning | None) -> str:
    """The name of a file's format by its suffix, if it can hold what is asked."""
    suffix = path.suffix.lower()
    known = PICTURE_SUFFIXES if turning is None else FILM_SUFFIXES
    if suffix not in known:
        what = "picture" if turning is None else "film"
        shown = f"the suffix {suffix!r} is not that of one" if suffix else "it has no suffix"
        raise ExportError(f"{path}: a {what} is wanted, and {shown}; expected {' or '.join(known)}")
    if suffix == ".gif" and shot.transparent:
        raise InputError(f"{path}: a .gif has no soft edges to nothing; expected .webp")
    if turning is not None:
        width, height = shot.size or (0, 0)
        if width * height * turning.n_pictures > _MOST_PIXELS:
            raise ExportError(
                f"{path}: {turning.n_pictures} pictures of {width} x {height} pixels are too "
                "many; expected a shorter or smaller film"
            )
    return _FORMS[suffix]


def _how(form: str) -> dict[str, Any]:
    return {"quality": _QUALITY} if form == "WEBP" else {}


def _told(
    pictures: Iterator[Image.Image], n: int, progress: Progress | None
) -> Iterator[Image.Image]:
    for k, picture in enumerate(pictures):
        yield picture
        if progress is not None:
            progress(0.98 * (k + 1) / n)

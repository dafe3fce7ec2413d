"""A picture of a painting, or a film of it turning, written to a file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from paint3d.colour.materials import Material
from paint3d.colour.viewing import Viewing
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, InputError, Message
from paint3d.files.colour_tags import picture_tags
from paint3d.files.export import gloss_of
from paint3d.files.export_options import ExportOptions
from paint3d.files.progress import Progress, part_of
from paint3d.files.project.painting import Exportable, Painting, read_painting
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.view.film import FILMS, MOST_PIXELS, Growth, film_form, is_held_whole, write_film
from paint3d.view.shot import MOST_LIGHTS, Moment, Shot, take_film, take_shot, take_turning
from paint3d.view.studio import Gloss

__all__ = [
    "Filmed",
    "Turning",
    "write_growth",
    "write_picture",
]

_PICTURE_SUFFIXES, _FILM_SUFFIXES = (".png", ".webp"), tuple(FILMS)
_FORMS = {".png": "PNG", **FILMS}
_SAVE_OPTIONS = {  # Pillow's, by form; a PNG a fifth larger in a quarter of the time
    "WEBP": {"quality": 92},
    "PNG": {"compress_level": 2},
}
_READ, _TAKEN = 0.6, 0.97  # of the time, about, until the painting is read and the picture there


class Turning(NamedTuple):
    """A film of an object turning once: how long, s, and pictures a second."""

    seconds: float = 4.0
    rate: float = 12.0

    @property
    def n_pictures(self) -> int:
        """Number of its pictures, 2 at least."""
        return max(2, round(self.seconds * self.rate))


def write_picture(
    painting: Exportable | TriangleMesh,
    path: str | os.PathLike[str],
    shot: Shot | None = None,
    turning: Turning | None = None,
    material: str | Material | None = None,
    progress: Progress | None = None,
    viewing: Viewing | None = None,
) -> None:
    """Write a picture (.png, .webp), or a film of the object turning once (.mp4, .gif, .webp).

    Parameters
    ----------
    painting : PaintedSurface or TriangleMesh
    path : path-like
        An existing file is replaced at the end, in one step; after a failure it is as it was.
    shot : Shot, optional
        Default: onto the painted side, in the studio.
    turning : Turning, optional
        Make a film.
    material : str or Material, optional
        Whose gloss is shown; by default that of the painting, and glazed porcelain for meshes.
    progress : callable, optional
        Called with the fraction done; what it raises leaves everything as it was.
    viewing : Viewing, optional
        In which light, by which observer and for which screen; .gif and .mp4 have sRGB only.

    Raises
    ------
    InputError
        If the shot cannot be taken so.
    ExportError
        If the suffix does not fit, the film would be too large, or the file cannot be written.
    """
    path, shot = Path(path), shot or Shot()
    form = _check_form(path, shot, turning)
    if viewing is not None and viewing.gamut != "srgb" and form in ("GIF", "MP4"):
        raise InputError(
            "{file}: a .{form} is in sRGB; expected .png or .webp for {gamut}",
            file=path,
            form=form.lower(),
            gamut=viewing.gamut,
        )
    other = None if material is None else Gloss.of(material)
    roughness = None if other is None else other.seen_roughness
    reading = part_of(progress, 0.0, _READ) if turning is None else None
    read = read_painting(painting, ExportOptions(viewing=viewing), reading, roughness)
    assert isinstance(read, Painting), "no texture was asked for"
    gloss = gloss_of(read, other)
    arrays = *read[:3], read.shown_srgb
    options = _SAVE_OPTIONS.get(form, {}) | picture_tags(read.gamut, form)
    with write_atomically(path, progress) as part:
        if turning is None:
            pixels = take_shot(arrays, shot, gloss, read.edges)
            if progress is not None:
                progress(_TAKEN)
            Image.fromarray(pixels).save(part, form, **options)
            return
        n = turning.n_pictures
        pictures = map(Image.fromarray, take_turning(arrays, shot, n, gloss, read.edges))
        write_film(part, _report_pictures(pictures, n, progress), n, form, turning.rate, options)


class Filmed(NamedTuple):
    """A film of a painting that grows: pictures a second, and s a turn takes (0: none).

    The finished painting stays for `hold` s.
    """

    rate: float = 24.0
    turn_s: float = 0.0
    hold: float = 1.0

    @property
    def n_held(self) -> int:
        """Number of pictures for which the finished painting stays."""
        return round(self.hold * self.rate)

    def check(self, path: Path, shot: Shot, n_pictures: int) -> str:
        """The format of a film of so many pictures, held ones left out, if it can be made.

        Raises
        ------
        ExportError, InputError
            If not.
        """
        if self.turn_s:
            shot.check_turning()
        n, form = n_pictures + self.n_held, film_form(path)
        width, height = shot.size or (0, 0)
        if is_held_whole(form) and width * height * n > MOST_PIXELS:
            raise ExportError(
                "{file}: {n} pictures of {width} x {height} pixels are too many; expected a "
                "shorter or smaller film, or .mp4",
                file=path,
                n=n,
                width=width,
                height=height,
            )
        return form


def write_growth(
    growth: Growth,
    path: str | os.PathLike[str],
    shot: Shot,
    filmed: Filmed,
    progress: Progress | None = None,
) -> int:
    """Write a film (.mp4, .gif, .webp) of how a painting came about; return how many pictures.

    Parameters
    ----------
    growth : Growth
        Ended.
    path : path-like
        An existing file is replaced at the end, in one step; after a failure it is as it was.
    shot : Shot
        The view is found for the finished painting, and stays.
    filmed : Filmed
    progress : callable, optional
        Called with the fraction done; what it raises leaves everything as it was.

    Raises
    ------
    InputError
        If the shot cannot be taken so.
    ExportError
        If the film would be too large, or the file cannot be written.
    """
    path, surface = Path(path), growth.surface
    form = filmed.check(path, shot, growth.n_pictures)
    arrays = surface.export_arrays(None)
    ids = surface.paint_mesh.source_order()
    n, a_turn = growth.n_pictures + filmed.n_held, filmed.rate * filmed.turn_s

    def moments() -> Iterator[Moment]:
        for k in range(n):
            if k < growth.n_pictures:  # the last one stays
                srgb, roughness = next(grown)
            rough = None if roughness is None else roughness[ids]
            yield Moment(srgb[ids], 2.0 * np.pi * k / a_turn if a_turn else 0.0, rough)

    grown = growth.pictures()
    n_lights = min(MOST_LIGHTS, max(1, round(a_turn))) if a_turn else 0
    drawn = take_film(arrays, shot, moments(), Gloss.of(surface.material), n_lights)
    with write_atomically(path, progress) as part:
        pictures = _report_pictures(map(Image.fromarray, drawn), n, progress)
        write_film(part, pictures, n, form, filmed.rate, _SAVE_OPTIONS.get(form, {}))
    return n


def _check_form(path: Path, shot: Shot, turning: Turning | None) -> str:
    """The name of a file's format by its suffix, if it can hold what is asked."""
    suffix = path.suffix.lower()
    known = _PICTURE_SUFFIXES if turning is None else _FILM_SUFFIXES
    if suffix not in known:
        what = Message("a picture") if turning is None else Message("a film")
        if suffix:
            raise ExportError(
                "{file}: {what} is wanted, and the suffix {suffix!r} is not that of one; expected "
                "{known}",
                file=path,
                what=what,
                suffix=suffix,
                known=" or ".join(known),
            )
        raise ExportError(
            "{file}: {what} is wanted, and it has no suffix; expected {known}",
            file=path,
            what=what,
            known=" or ".join(known),
        )
    if suffix in (".gif", ".mp4") and shot.transparent:
        raise InputError(
            "{file}: a {suffix} has no soft edges to nothing; expected .webp",
            file=path,
            suffix=suffix,
        )
    if turning is not None and is_held_whole(film_form(path)):
        width, height = shot.size or (0, 0)
        if width * height * turning.n_pictures > MOST_PIXELS:
            raise ExportError(
                "{file}: {n_pictures} pictures of {width} x {height} pixels are too many; expected "
                "a shorter or smaller film",
                file=path,
                n_pictures=turning.n_pictures,
                width=width,
                height=height,
            )
    return _FORMS[suffix]


def _report_pictures(
    pictures: Iterator[Image.Image], n: int, progress: Progress | None
) -> Iterator[Image.Image]:
    for k, picture in enumerate(pictures):
        yield picture
        if progress is not None:
            progress(0.98 * (k + 1) / n)

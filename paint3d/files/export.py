"""Export of a painting to a file, in the format its suffix names."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically
from paint3d.errors import ExportError, UnknownNameError
from paint3d.files.contents import plain_name
from paint3d.files.export_options import ExportOptions
from paint3d.files.finish import Finish
from paint3d.files.progress import Progress, part_of
from paint3d.files.project.painting import Exportable, Painting, Untextured, read_painting
from paint3d.files.project.session import SESSION_SUFFIX, Session, save_session
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

if TYPE_CHECKING:
    from paint3d.view.studio import Gloss

__all__ = [
    "EXPORT_SUFFIXES",
    "FORMATS",
    "PreparedExport",
    "check_export_path",
    "export",
    "gloss_of",
    "prepare_export",
]

DEFAULT_ROUGHNESS = 0.5
ANY_MESH = frozenset({"unit", "up_axis", "filaments"})


class Format(NamedTuple):
    """Writer of a format, its unit and up axis, and the options it knows."""

    write: Callable[[Path, Painting, ExportOptions, str], None]
    unit: str = "mm"
    up_axis: str = "z"
    takes: frozenset[str] = ANY_MESH


def export(
    surface: Exportable | TriangleMesh,
    path: str | os.PathLike[str],
    options: ExportOptions | None = None,
    progress: Progress | None = None,
) -> None:
    """Write a painting to `path`; the suffix chooses the format.

    .ply binary PLY (mm, sRGB bytes); .glb glTF 2.0 (metres, y up, linear colours); .obj (mm, sRGB
    after the position); .3mf (mm, sRGB at each corner, for printers); .usdz (metres, y up, linear
    displayColor); .p3d.txt the paper's records; .html a page that shows the object, by itself;
    .png a picture; .p3d a session, to which no option applies.

    Parameters
    ----------
    surface : PaintedSurface or TriangleMesh
        A mesh is written with the colours that it came with.
    path : path-like
        An existing file is replaced at the end, in one step; after a failure it is as it was.
    options : ExportOptions, optional
        How the file is to be written; without, what is right in its format.
    progress : callable, optional
        Called with about the fraction done; what it raises leaves everything as it was.

    Raises
    ------
    ExportError
        If the suffix is not known, the format cannot do what is asked, or the file cannot be
        written.

    Examples
    --------
    >>> import paint3d
    >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
    >>> line = paint3d.Painter(surface).stroke([(-20, 0, 0), (20, 0, 0)])
    >>> paint3d.export(surface, "line.glb")
    >>> paint3d.export(surface, "inches.ply", paint3d.ExportOptions(unit="in"))
    >>> paint3d.load_mesh("line.glb").colours.shape[1]
    3
    """
    path = Path(path)
    suffix = check_export_path(path)
    if suffix == SESSION_SUFFIX:
        if not isinstance(surface, PaintedSurface):
            kind = type(surface).__name__
            raise ExportError(
                "{file}: a session holds a PaintedSurface; got a {kind}",
                file=path,
                kind=kind,
            )
        save_session(Session(surface), path, progress)
        return
    wishes = options or ExportOptions()
    prepared = prepare_export(surface, path, wishes, part_of(progress, 0.0, 0.6))
    prepared.write(part_of(progress, 0.6, 1.0))


@dataclass(frozen=True, eq=False)
class PreparedExport:
    """Data of an export, taken from a surface that may be painted on meanwhile."""

    path: Path
    suffix: str
    options: ExportOptions
    painting: Painting | Untextured

    def into(self, path: Path) -> PreparedExport:
        """The same painting, prepared for another file and its format.

        Raises
        ------
        ExportError
            If the suffix is not known, or the format cannot do what is asked.
        """
        suffix = _check_suffix(path, self.options)
        return replace(self, path=path, suffix=suffix)

    def write(self, progress: Progress | None = None) -> None:
        """Write the file.

        Parameters
        ----------
        progress : callable, optional
            Called with the fraction done now and then, and with 1 before the file takes its place;
            what it raises leaves everything as it was.

        Raises
        ------
        ExportError
            If the file cannot be written.
        """
        form, options, painting = FORMATS[self.suffix], self.options, self.painting
        report = part_of(progress, 0.0, 0.3) or (lambda fraction: None)
        report(0.0)
        if isinstance(painting, Untextured):
            painting = painting.baked()
        report(0.5)
        unit = options.unit or form.unit
        painting = painting.converted(unit, options.up_axis or form.up_axis)
        material = plain_name(painting.material)
        title = plain_name(self.path.name[: -len(self.suffix)]) or material
        report(1.0)
        with write_atomically(self.path, progress) as temporary:
            form.write(temporary, painting._replace(title=title, material=material), options, unit)


def prepare_export(
    surface: Exportable | TriangleMesh,
    path: str | os.PathLike[str],
    options: ExportOptions,
    progress: Progress | None = None,
) -> PreparedExport:
    """Take from a surface what an export needs; nothing is written yet.

    Parameters
    ----------
    surface : PaintedSurface or TriangleMesh
    path : path-like
        Its suffix is that of one of `FORMATS`.
    options : ExportOptions
    progress : callable, optional
        Called with the fraction done, now and then; what it raises stops it.

    Raises
    ------
    ExportError
        If the suffix is not known, or the format cannot do what is asked.
    """
    path = Path(path)
    suffix = _check_suffix(path, options)
    return PreparedExport(path, suffix, options, read_painting(surface, options, progress))


def _check_suffix(path: Path, options: ExportOptions) -> str:
    suffix = check_export_path(path)
    if suffix not in FORMATS:
        raise ExportError(
            "{file}: a session is saved; expected one of {formats}",
            file=path,
            formats=" ".join(FORMATS),
        )
    wishes = {wish for form in FORMATS.values() for wish in form.takes}
    formats = {
        wish: " ".join(s for s, form in FORMATS.items() if wish in form.takes) for wish in wishes
    }
    options.refuse_others(FORMATS[suffix].takes, suffix, formats)
    return suffix


def check_export_path(path: str | os.PathLike[str]) -> str:
    """Return the known suffix of a path, so that a bad suffix or folder is known before the work.

    Raises
    ------
    ExportError
        If the suffix is not known, the folder is missing, or a package that writes the format is.
    """
    path = Path(path)
    name = path.name.lower()
    suffix = next((s for s in EXPORT_SUFFIXES if name.endswith(s)), None)
    if suffix is None:
        known = " ".join(EXPORT_SUFFIXES)
        if path.suffix:
            raise ExportError(
                "{file}: the suffix {suffix!r} is not known; expected one of {known}",
                file=path,
                suffix=path.suffix,
                known=known,
            )
        raise ExportError(
            "{file}: it has no suffix; expected one of {known}", file=path, known=known
        )
    if not path.parent.is_dir():
        raise ExportError(
            "{file}: the folder {parent} does not exist",
            file=path,
            parent=path.parent,
        )
    if suffix == ".usdz":
        from paint3d.files.formats.usdz import check_usd

        check_usd()
    return suffix


# Each function imports its writer by itself, since most programs write one format.


def _write_ply(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.files.formats.ply import write_ply

    write_ply(path, painting.vertices, painting.faces, painting.normals, painting.srgb)


def _write_glb(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.files.formats.gltf import write_glb, write_textured_glb

    finish, unlit, steps = _finish(painting), options.unlit, painting.steps
    if painting.texture is None:
        write_glb(path, *painting[:3], painting.shown_srgb, finish, unlit=unlit, steps=steps)
    else:
        write_textured_glb(path, *painting[:3], painting.texture, finish, unlit=unlit, steps=steps)


def _write_obj(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.files.formats.obj import write_obj

    write_obj(path, *painting[:4], name=painting.material, unit=unit)


def _write_3mf(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.files.formats.threemf import write_3mf

    write_3mf(
        path,
        painting.vertices,
        painting.faces,
        painting.srgb,
        name=painting.title,
        unit=unit,
        palette=painting.palette,
        face_filaments=painting.face_filaments,
    )


def _write_usdz(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.colour.spectra import decode_srgb
    from paint3d.colour.viewing import linear_srgb_of
    from paint3d.files.formats.usdz import write_usdz

    colours: AnyArray = painting.shown_srgb
    if painting.gamut != "srgb":  # USD's colours are linear, and may be outside of sRGB
        linear = linear_srgb_of(decode_srgb(colours), painting.gamut)
        colours = linear.astype("<f4")
    write_usdz(
        path,
        *painting[:3],
        colours,
        _finish(painting),
        unit=unit,
        up_axis=options.up_axis or FORMATS[".usdz"].up_axis,
    )


def _write_records(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.files.formats.records import standing_position, write_records

    arrays = painting.vertices, painting.normals, painting.srgb
    write_records(
        path,
        *arrays,
        faces=painting.faces,
        initial_position=standing_position(painting.vertices),
        packed=options.packed_normals,
    )


def _write_png(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from PIL import Image

    from paint3d.files.colour_tags import picture_tags
    from paint3d.view.shot import AUTO, FLAT, Shot, take_shot  # VTK: only for pictures

    is_flat = painting.is_sheet and options.size is None
    shot = Shot(FLAT if is_flat else AUTO, options.size)
    arrays = *painting[:3], painting.shown_srgb
    pixels = take_shot(arrays, shot, gloss_of(painting), painting.edges)
    Image.fromarray(pixels).save(path, format="PNG", **picture_tags(painting.gamut, "PNG"))


def _finish(painting: Painting) -> Finish:
    gloss = gloss_of(painting)
    roughness = DEFAULT_ROUGHNESS if gloss is None else gloss.roughness
    look = painting.look if painting.texture is None else painting.texture.look
    return Finish(painting.material, roughness, None if look is None else look.roughness(roughness))


def _write_html(path: Path, painting: Painting, options: ExportOptions, unit: str) -> None:
    from paint3d.files.formats.html import write_html

    gloss = gloss_of(painting)
    write_html(
        path,
        *painting[:4],
        title=painting.title,
        edges=painting.edges,
        paper=(0.0, 0.0) if gloss is None else gloss.paper,
        note=options.note,
    )


def gloss_of(painting: Painting, gloss: Gloss | None = None) -> Gloss | None:
    """Return how a painting shines, wet parts too; None where its material does not say it.

    A `gloss` is taken in place of the material's.
    """
    gloss = gloss or _gloss_of_material(painting)
    if gloss is None or painting.look is None:
        return gloss
    return replace(gloss, each=painting.look.roughness(gloss.seen_roughness))


def _gloss_of_material(painting: Painting) -> Gloss | None:
    from paint3d.view.studio import Gloss

    try:
        return Gloss.of(painting.material)
    except UnknownNameError:
        return None if painting.finish is None else Gloss(*painting.finish)


FORMATS: dict[str, Format] = {
    ".ply": Format(_write_ply),
    ".glb": Format(_write_glb, "m", "y", ANY_MESH | {"unlit", "texture"}),
    ".obj": Format(_write_obj),
    ".3mf": Format(_write_3mf),
    ".usdz": Format(_write_usdz, "m", "y", ANY_MESH | {"gamut"}),
    ".p3d.txt": Format(_write_records, takes=frozenset({"packed_normals"})),
    ".html": Format(_write_html, takes=frozenset({"filaments"})),
    ".png": Format(_write_png, takes=frozenset({"filaments", "size", "gamut"})),
}
EXPORT_SUFFIXES = (*FORMATS, SESSION_SUFFIX)

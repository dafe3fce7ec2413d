"""Write a saved painting in another format, which the suffix of the file chooses."""

from __future__ import annotations

import argparse
import logging
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import (
    BUILT_IN_OBJECTS,
    UNITS,
    add_force_option,
    add_quiet_option,
    check_input_file,
    check_output_file,
    check_overwriting,
    group_of,
)
from paint3d.cli.picture import add_light_options, viewing_of
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import add_painting_argument, open_painting

if TYPE_CHECKING:
    from paint3d.files.export_options import ExportOptions
    from paint3d.files.progress import Progress
    from paint3d.files.project.session import Session
    from paint3d.mesh.triangle_mesh import TriangleMesh

_LOG = logging.getLogger("paint3d")

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d export vase.p3d vase.html
paint3d export vase.p3d vase.html --view-only
paint3d export vase.p3d vase.3mf --filaments 4
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    add_painting_argument(parser)
    parser.add_argument("file", metavar="FILE", type=Path, help="where to write it")
    form = group_of(parser, "the file written")
    form.add_argument(
        "--tolerance",
        metavar="DE",
        type=float,
        default=1.0,
        help="dE00 by which a colour may be missed where vertices are left out (default: 1)",
    )
    form.add_argument("--exact", action="store_true", help="leave no vertex out")
    form.add_argument(
        "--out-unit",
        choices=UNITS,
        help="length of one unit in the file written (default: the format's own)",
    )
    form.add_argument(
        "--up-axis", choices=("y", "z"), help="axis that points up (default: the format's own)"
    )
    form.add_argument(
        "--unlit", action="store_true", help="glTF: show the colours as they are, without light"
    )
    form.add_argument(
        "--texture",
        metavar="PIXELS",
        nargs="?",
        type=int,
        const=True,
        default=False,
        help="glTF: bake the colours into a texture, so many pixels long (default: as needed)",
    )
    form.add_argument(
        "--filaments",
        metavar="K",
        type=_parse_filaments,
        help="reduce to so many colours, or to the nearest of these, as #rrggbb,#rrggbb",
    )
    form.add_argument(
        "--packed-normals",
        action="store_true",
        help=".p3d.txt: seven numbers a vertex, as the paper prints them, instead of nine",
    )
    form.add_argument(
        "--view-only",
        action="store_true",
        help=".html: a page that turns the object, and nothing else (default: one that also shows "
        "how it was painted, and lets one paint on it, where that can be)",
    )
    add_light_options(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def _parse_filaments(text: str) -> int | list[str]:
    return int(text) if text.isascii() and text.isdigit() else text.split(",")


def run(options: argparse.Namespace) -> None:
    """Open the painting and write the file.

    A page (.html) is one that paints where that can be, else one that shows the object and why.

    Raises
    ------
    Paint3DError
        If the painting cannot be opened, or the file cannot be written.
    """
    from paint3d.errors import ExportError
    from paint3d.files.export import EXPORT_SUFFIXES, export
    from paint3d.files.export_options import ExportOptions
    from paint3d.files.project.session import Session, is_session_path, save_session

    check_output_file(options.file, EXPORT_SUFFIXES)
    check_overwriting((options.file,), (options.painting,), force=options.force)
    check_input_file(options.painting, "a painting (.p3d), a mesh", BUILT_IN_OBJECTS)
    viewing = viewing_of(options)
    painting = open_painting(options)
    with ProgressBar("writing", enabled=not options.quiet) as progress:
        if is_session_path(options.file):
            if not isinstance(painting, Session):
                raise ExportError(
                    "{file}: {painting} is a mesh, which no session is made of; expected another "
                    "suffix (paint3d paint opens a mesh and saves sessions)",
                    file=options.file,
                    painting=options.painting,
                )
            save_session(painting, options.file, progress)
            why_not = None
        else:
            wishes = ExportOptions(
                tolerance=options.tolerance,
                exact=options.exact,
                unit=options.out_unit,
                up_axis=options.up_axis,
                unlit=options.unlit,
                texture=options.texture,
                filaments=options.filaments,
                packed_normals=options.packed_normals,
                viewing=viewing,
            )
            is_page = options.file.suffix.lower() == ".html" and not options.view_only
            why_not = _write_page(painting, options.file, wishes, progress) if is_page else None
            if why_not is not None:
                wishes = replace(wishes, note=f"It cannot be painted on here: {why_not}.")
            if not is_page or why_not is not None:
                surface = painting.surface if isinstance(painting, Session) else painting
                export(surface, options.file, wishes, progress)
    if why_not is not None:
        _LOG.warning("%s only shows the painting: %s", options.file, why_not)
    if not options.quiet:
        sys.stdout.write(f"{options.file}\n")


def _write_page(
    painting: Session | TriangleMesh, file: Path, wishes: ExportOptions, progress: Progress | None
) -> str | None:
    """Write a page that paints; return None, or why it cannot paint."""
    from paint3d.errors import ExportError, InputError
    from paint3d.files.export_options import ExportOptions
    from paint3d.files.progress import part_of
    from paint3d.files.project.session import Session
    from paint3d.page import folder
    from paint3d.page.single_file import page_score, write_single_file

    if not isinstance(painting, Session):
        return "it is no session (.p3d), which knows how it was painted"
    if wishes != ExportOptions():
        return "it was to be written with other colours, vertices, a unit or an axis"
    try:
        folder.check_built(folder.BUILT, folder.KERNELS)
    except ExportError as cause:
        what = str(cause).partition(":")[0]  # without paths, as the page may be passed on
        return f"{what} ({cause.hint})"
    try:
        score = page_score(painting, part_of(progress, 0.0, 0.5))
    except InputError as cause:
        return str(cause)
    rest = part_of(progress, 0.5, 1.0)
    write_single_file(painting, score, file, rest, page=folder.BUILT, kernels=folder.KERNELS)
    return None

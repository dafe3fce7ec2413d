"""List the brushes with their parameters, draw them, and give a file to start one's own from."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.lists.columns import table_lines, terminal_columns
from paint3d.cli.options import (
    add_actions,
    add_force_option,
    add_quiet_option,
    check_output_folder,
    check_overwriting,
)
from paint3d.cli.progress import ProgressBar
from paint3d.errors import ExportError

if TYPE_CHECKING:
    from paint3d.brush.spec import BristleSpec, BrushSpec

__all__ = ["EXAMPLES", "add_arguments", "brush_lines", "run"]

EXAMPLES = """
paint3d brushes
paint3d brushes show full > mine.toml
"""

_COLUMNS = (
    ("H", "hardness"), ("l1", "tip_segment_mm"), ("n", "n_segments"), ("mu", "friction"),
    ("b", "spread_by_pressure"), ("c", "spread_by_friction"), ("L", "length_mm"),
    ("root", "root_diameter_mm"), ("taper", "taper"), ("press", "full_press_mm"),
)  # fmt: skip
_PICTURE_INK = "pine soot"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "--pictures",
        metavar="DIR",
        type=Path,
        help="also write NAME.png for each: footprints at 15, 40, 70 and 100 %% of the force, "
        "and a stroke; the folder is made where missing",
    )
    add_quiet_option(parser)
    add = add_actions(parser, required=False)
    show = add(
        "show",
        "print a brush as a file to start your own from, or check one",
        "paint3d brushes show full > mine.toml",
    )
    show.add_argument("brush", metavar="NAME|FILE", help="a brush of the list, or a file to check")
    fit = add(
        "fit",
        "make a brush file of what was measured on a real brush: presses, or bent hairs",
        "paint3d brushes fit presses.csv --out mine.toml",
        "Make a brush file of what was measured on a real brush. TABLE has the columns depth_mm, "
        "width_mm, offset_mm, drag_mm (footprints of an upright brush), or angle, height, offset, "
        "imprint, upper, lower, spread (bent hairs, in hair lengths), or angle, x0, z0 ... x3, z3 "
        "(their Bezier points, mm); docs/brushes.md.",
    )
    fit.add_argument("table", metavar="TABLE.csv", type=Path, help="what was measured")
    fit.add_argument("--out", metavar="FILE.toml", type=Path, required=True, help="the brush file")
    fit.add_argument(
        "--base",
        metavar="NAME|FILE",
        default="calibrated",
        help="what all that was not measured is taken from (default: calibrated)",
    )
    fit.add_argument(
        "--length",
        metavar="MM",
        type=float,
        help="of the tuft, tip to ferrule (default: the base's)",
    )
    fit.add_argument(
        "--hairs", metavar="N", type=int, help="single hairs, for bent hairs (default: 1000)"
    )
    add_force_option(fit)
    add_quiet_option(fit)


def run(options: argparse.Namespace) -> None:
    """Write the table, the pictures or the file.

    Raises
    ------
    Paint3DError
        If the brush cannot be used, or a picture cannot be written.
    """
    from paint3d.brush.presets import brush_note, load_presets

    if options.action == "show":
        from paint3d.brush.presets import brush_text, load_brush

        brush = load_brush(options.brush)
        sys.stdout.write(brush_text(brush, brush_note(brush.name)))
        return
    if options.action == "fit":
        _fit(options)
        return
    from paint3d.app.model.persistence.own_brushes import own_brush_path, own_brushes

    presets = load_presets()
    if options.pictures is not None:
        _draw(presets.values(), options.pictures, quiet=options.quiet)
    if not options.quiet:
        notes = {name: brush_note(name) for name in presets}
        own, problems = own_brushes()
        notes |= {name: f"your own: --brush {own_brush_path(name)}" for name in own}
        lines = brush_lines([*presets.values(), *own.values()], notes, terminal_columns())
        sys.stdout.write("\n".join(lines) + "\n")
        sys.stderr.writelines(f"paint3d: note: {problem}\n" for problem in problems)


def _fit(options: argparse.Namespace) -> None:
    """Write the brush that fits a table of measurements, and print how well."""
    import dataclasses

    from paint3d.app.model.brush_in_hand import resized
    from paint3d.brush.fitting import (
        fit_presses,
        is_table_of_shapes,
        press_errors,
        read_presses,
        read_shapes,
    )
    from paint3d.brush.presets import (
        check_brush_name,
        check_not_preset,
        load_brush,
        load_presets,
        write_brush,
    )
    from paint3d.core.parameter_file import is_parameter_file

    if not is_parameter_file(options.out.name) or options.out.suffix.lower() == ".json":
        raise ExportError(
            "{out}: expected the name of a brush file, such as mine.toml",
            out=options.out,
        )
    check_output_folder(options.out.parent)
    name = options.out.stem
    check_brush_name(name)
    check_not_preset(name, load_presets())
    check_overwriting((options.out,), (options.base, options.table), force=options.force)
    base = load_brush(options.base)
    if options.length is not None and options.length != base.length_mm:
        base = resized(base, options.length)
    if is_table_of_shapes(options.table):
        rows = read_shapes(options.table, base.length_mm)
        hairs = _hairs(base, options.hairs)
        brush = dataclasses.replace(
            base, name=name, bristles=dataclasses.replace(hairs, table=rows)
        )
        angles = sorted({row[0] for row in rows})
        quality = f"{len(rows)} bent hairs at {', '.join(f'{a:g}' for a in angles)} degrees"
    else:
        presses = read_presses(options.table)
        if options.hairs is not None:
            base = dataclasses.replace(base, bristles=_hairs(base, options.hairs))
        with ProgressBar("fitting", enabled=not options.quiet) as progress:
            brush = fit_presses(presses, base, name, progress)
        quality = "off by (RMS): width {:.2f}, heel {:.2f}, length {:.2f} mm".format(
            *press_errors(brush, presses)
        )
    note = f"fitted to {options.table.name}: {quality}"
    write_brush(options.out, brush, load_presets(), note)
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {quality}\n")


def _hairs(base: BrushSpec, count: int | None) -> BristleSpec:
    """Return the base's hairs, in another number if one is given."""
    import dataclasses

    from paint3d.brush.spec import BristleSpec

    hairs = base.bristles or BristleSpec()
    return hairs if count is None else dataclasses.replace(hairs, n_hairs=count)


def brush_lines(
    brushes: Iterable[BrushSpec], notes: dict[str, str], columns: int | None = None
) -> list[str]:
    """Return a table of brushes: a head, then one brush a line, lengths in mm.

    Parameters
    ----------
    brushes : iterable of BrushSpec
    notes : dict
        Purposes by name.
    columns : int, optional
        How wide it may be; see `table_lines`.
    """
    rows = [("name", "hair", *(head for head, _ in _COLUMNS), "hairs", "for")]
    for brush in brushes:
        numbers = [f"{getattr(brush, field):g}" for _, field in _COLUMNS]
        hairs = "solid" if brush.bristles is None else str(brush.bristles.n_hairs)
        rows.append((brush.name, brush.hair, *numbers, hairs, notes.get(brush.name, "")))
    return table_lines(rows, columns)


def _draw(brushes: Iterable[BrushSpec], folder: Path, *, quiet: bool) -> None:
    """Write a picture of each brush."""
    check_output_folder(folder)
    from PIL import Image

    from paint3d.core.atomic import write_atomically
    from paint3d.view.brush_shape import draw_brush

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError("{folder}: {cause}", folder=folder, cause=error) from None
    brushes = list(brushes)
    with ProgressBar("drawing", enabled=not quiet) as progress:
        for k, brush in enumerate(brushes):
            pixels = draw_brush(brush, _PICTURE_INK)
            with write_atomically(folder / f"{brush.name}.png") as file:
                Image.fromarray(pixels).save(file, format="PNG")
            progress((k + 1) / len(brushes))

"""Open the desktop studio: paint on an object with mouse, pen or two hands."""

from __future__ import annotations

import argparse
import os

from paint3d.cli.options import (
    BUILT_IN_HELP,
    BUILT_IN_OBJECTS,
    add_quiet_option,
    add_stylus_option,
    add_up_option,
    check_input_file,
)
from paint3d.cli.painting import PaintingOptions
from paint3d.cli.progress import say_if_compiling
from paint3d.errors import InputError

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d paint bowl
paint3d paint jug.stl --unit cm --material bisque
paint3d paint vase.p3d --stylus openhaptics
"""

_LANGUAGES = ("en", "zh")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "target",
        metavar="MESH | SESSION",
        nargs="?",
        help=f"what to paint on: a mesh file, a saved painting, {BUILT_IN_HELP} (default: what a "
        "crash left, or a page that asks)",
    )
    chosen = {"material": "as chosen last", "resolution": "as chosen last"}
    PaintingOptions.add_to(parser, "material", "resolution", "unit", unsaid=chosen)
    add_up_option(parser, "auto")
    add_stylus_option(parser, " (default: as chosen)")
    parser.add_argument("--language", choices=_LANGUAGES, help="of the window (default: as chosen)")
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Open the window and stay until it is closed.

    Raises
    ------
    InputError
        If PySide6 or a display is missing.
    Paint3DError
        If the target cannot be opened.
    """
    if options.target is not None:
        check_input_file(options.target, "a mesh, a painting (.p3d)", BUILT_IN_OBJECTS)
    if options.material is not None:
        from paint3d.colour.materials import load_material

        load_material(options.material)
    os.environ.setdefault("QT_LOGGING_RULES", "qt.qpa.*=false")
    try:
        from paint3d.app.window.program import make_program, show_opening

        make_program()
        opening = show_opening()
        say_if_compiling(quiet=options.quiet)
        from paint3d.app.window.start import run_studio
    except ImportError as cause:
        raise InputError(
            "the studio needs PySide6, which cannot be loaded ({cause}); expected pip install "
            "'paint3d[studio]'",
            cause=cause,
        ) from None
    run_studio(
        options.target,
        resolution=options.resolution,
        material=options.material,
        language=options.language,
        unit=options.unit,
        up=None if options.up == "auto" else options.up,
        stylus=options.stylus,
        opening=opening,
    )

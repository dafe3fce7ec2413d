"""Open the desktop studio: paint on an object with mouse, pen or two hands."""

from __future__ import annotations

import argparse
import os
from importlib import import_module
from pathlib import Path

from paint3d.cli.options import (
    add_quiet_option,
    add_stylus_option,
    add_surface_options,
    add_up_option,
)
from paint3d.cli.progress import say_if_compiling
from paint3d.errors import InputError, MeshError

HELP = "the desktop studio"

_LANGUAGES = ("en", "zh")
# Once Qt is there it reads the source of every module that is imported, for a word: 70 ms of them.
_BEFORE_QT = ("paint3d.app.model.document", "paint3d.view.live_scene")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "target",
        metavar="MESH | SESSION",
        nargs="?",
        help="what to paint on: a mesh file, a saved painting, or bowl, plate, vase, sphere, "
        "plane (default: what a crash left, or a bowl)",
    )
    add_surface_options(parser)
    add_up_option(parser, "auto")
    parser.set_defaults(material=None, resolution=None)  # as was chosen last in the window
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
    from paint3d.colour.materials import load_material
    from paint3d.files.load import BUILT_IN_OBJECTS

    if options.material is not None:
        load_material(options.material)
    target = options.target
    if target is not None and target not in BUILT_IN_OBJECTS and not Path(target).is_file():
        known = ", ".join(BUILT_IN_OBJECTS)
        raise MeshError(f"{target}: there is no such file; expected a mesh, a .p3d or {known}")
    say_if_compiling(quiet=options.quiet)
    os.environ.setdefault("QT_LOGGING_RULES", "qt.qpa.*=false")
    try:
        for module in _BEFORE_QT:
            import_module(module)
        from paint3d.app.window.start import run_studio
    except ImportError as cause:
        raise InputError(
            f"the studio needs PySide6, which cannot be loaded ({cause}); "
            "expected pip install 'paint3d[studio]'"
        ) from None
    run_studio(
        target,
        resolution=options.resolution,
        material=options.material,
        language=options.language,
        up=None if options.up == "auto" else options.up,
        stylus=options.stylus,
    )

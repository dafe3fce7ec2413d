"""Paint the shipped recording of four characters on the bowl and write it in several formats."""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from importlib.resources import as_file, files
from pathlib import Path

from paint3d.cli.options import (
    DIPS,
    MATERIALS,
    add_dip_option,
    add_quiet_option,
    check_output_folder,
)
from paint3d.cli.painting import PaintingOptions, paint, prepare
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import timed, write_report, write_results
from paint3d.errors import ExportError

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d demo --out demo
"""

_FILES = ("bowl.ply", "bowl.glb", "bowl.p3d.txt", "bowl.png", "bowl.p3d")
_PICTURE = "bowl.png"
_RECORDING = "data/demo.jsonl.gz"
_RESOLUTION_MM = 0.12  # strokes of small characters are down to half a millimetre wide


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("paint3d-demo"),
        help="folder to write to; it is made where missing (default: ./paint3d-demo)",
    )
    parser.add_argument(
        "--no-view", action="store_true", help="do not open the picture when it is written"
    )
    PaintingOptions.add_to(parser, "material", "hairs", "spread")
    add_dip_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Paint, write the files, and show the picture where there is a display.

    Raises
    ------
    ExportError
        If the folder or a file cannot be written.
    InputError
        If the material is not known or cannot be read.
    """
    if options.material not in (None, *MATERIALS):
        from paint3d.colour.materials import load_material

        load_material(options.material)  # refused before anything is written
    check_output_folder(options.out)
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError("{folder}: {cause}", folder=options.out, cause=error) from None
    if not options.quiet:
        sys.stdout.write(f"painting the bowl, into {options.out}\n")
        sys.stdout.flush()
    from paint3d.brush.presets import load_brush
    from paint3d.calligraphy.dips import apply_dip_option
    from paint3d.colour.materials import load_material
    from paint3d.files.load import load_mesh  # heavy, so after the first line of output
    from paint3d.recording.recording import load_recording

    with (
        as_file(files("paint3d.calligraphy").joinpath(_RECORDING)) as path,
        ProgressBar("reading", enabled=not options.quiet) as progress,
    ):
        recording = load_recording(path, progress=progress)
        mesh = load_mesh("bowl")
    wanted = PaintingOptions.of(options, resolution=_RESOLUTION_MM)
    brush = load_brush(str(recording.header["brush"]))
    material = load_material(wanted.material)
    recording = apply_dip_option(recording, brush, options.dip or DIPS, material)
    seconds: dict[str, float] = {}
    painting = paint(prepare(mesh, wanted, seconds), recording, wanted, seconds)
    written = [options.out / name for name in _FILES]
    with timed(painting.seconds, "export"):
        write_results(painting, written, quiet=options.quiet)
    write_report(options.out / "report.json", painting)
    if not options.quiet:
        sys.stdout.write(f"{painting.summarize()}\n")
        sys.stdout.writelines(f"{file}\n" for file in [*written, options.out / "report.json"])
    if not options.no_view:
        _show(options.out / _PICTURE)


def _show(picture: Path) -> None:
    """Open the picture in the desktop's viewer; without a display, do nothing."""
    on_mac = sys.platform == "darwin"
    if not (on_mac or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return
    viewer = shutil.which("open" if on_mac else "xdg-open")
    if viewer is None:
        return
    subprocess.Popen(
        [viewer, str(picture.resolve())],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )

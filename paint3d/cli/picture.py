"""Take a picture of a painting, a film of it turning, or draw the outlines of its strokes."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import (
    BUILT_IN_OBJECTS,
    FILES,
    FILM,
    LIGHT,
    MATERIALS,
    add_force_option,
    add_fps_option,
    add_pixels_option,
    add_quiet_option,
    check_input_file,
    check_output_file,
    check_overwriting,
    group_of,
    own_file,
    parse_number,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import add_painting_argument, is_recording, open_painting
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.colour.viewing import Viewing

__all__ = [
    "EXAMPLES",
    "FILM_SIZE",
    "LIGHTS",
    "VIEWS",
    "add_arguments",
    "add_light_options",
    "add_view_options",
    "run",
    "viewing_of",
]

# ---- Light ---------------------------------------------------------------------------------------
# Options of the light, the observer and the screen that a painting is shown in.


_ADAPTATIONS, _GAMUTS = ("cat16", "bradford", "none"), ("srgb", "p3", "rec2020")


def add_light_options(parser: argparse.ArgumentParser) -> None:
    """Add --illuminant, --observer, --adaptation and --gamut."""
    light = group_of(parser, LIGHT)
    light.add_argument(
        "--illuminant",
        metavar="LIGHT",
        default="D65",
        help="the light it is seen in: A, D50, D65, F2, F11, LED-B3 and others of the CIE, a "
        "temperature such as 2700K, or a spectrum's FILE.spd, .csv or .spdx (default: D65)",
    )
    light.add_argument(
        "--observer",
        metavar="DEGREES",
        type=int,
        choices=(2, 10),
        default=2,
        help="2 or 10: the CIE's standard observer of 1931 or of 1964 (default: 2)",
    )
    light.add_argument(
        "--adaptation",
        choices=_ADAPTATIONS,
        default="cat16",
        help="of the eye to the light; none: white has the colour of the light (default: cat16)",
    )
    light.add_argument(
        "--gamut",
        choices=_GAMUTS,
        default="srgb",
        help="colours that the file can hold; p3 and rec2020 for .png, .webp and .usdz "
        "(default: srgb)",
    )


def viewing_of(options: argparse.Namespace) -> Viewing | None:
    """Return the viewing conditions of the options; None if they change nothing.

    Raises
    ------
    InputError
        If the light is not known, or colour-science is missing.
    """
    from paint3d.colour.viewing import Viewing

    viewing = Viewing(options.illuminant, options.observer, options.adaptation, options.gamut)
    return None if viewing.is_plain else viewing


# ---- The command ---------------------------------------------------------------------------------


EXAMPLES = """
paint3d picture bowl.p3d --out bowl.png --view 30,20 --pixels 800x600
paint3d picture bowl.glb --out turning.gif --turn 6
"""

_SUFFIXES = (".png", ".webp", ".gif", ".mp4", ".svg")
_ALWAYS_FILMS = (".gif", ".mp4")
VIEWS = ("auto", "front", "right", "back", "left", "above", "top", "bottom", "flat")
LIGHTS = ("studio", "soft", "raking", "none")  # as `view.studio`, known here before NumPy is
FILM_SIZE = (640, 480)
_TURN_S, _FPS = 4.0, 12.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    add_painting_argument(parser)
    group_of(parser, FILES).add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        required=True,
        help=".png or .webp; .mp4 or .gif, or .webp with --turn, a film; .svg the outlines of the "
        "strokes that a recording, or the recordings of a session, leave on the plane",
    )
    view = group_of(parser, "what is seen")
    add_view_options(view, "1600x1200, films 640x480, flat: the shape of the object")
    parser.set_defaults(view="auto", light="studio", zoom=1.0)
    view.add_argument(
        "--transparent", action="store_true", help="leave out the ground and what is behind"
    )
    view.add_argument(
        "--material",
        metavar="NAME|FILE",
        help=f"whose gloss is shown: {', '.join(MATERIALS)}, or a file of your own (default: the "
        "painting's own; of a mesh porcelain)",
    )
    film = group_of(parser, FILM)
    film.add_argument(
        "--turn",
        metavar="SECONDS",
        type=_parse_turn,
        nargs="?",
        const=_TURN_S,
        help="a film in which the object turns once in so many seconds (default: 4; .gif and .mp4 "
        "always)",
    )
    add_fps_option(film)
    add_light_options(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def add_view_options(group: argparse._ActionsContainer, pixels: str) -> None:
    """Add view, size and light of a picture, all None by default.

    Parameters
    ----------
    group : parser or group of options
    pixels : str
        The help's text of the default of ``--pixels``.
    """
    group.add_argument(
        "--view",
        metavar="VIEW",
        type=_parse_view,
        help=f"{', '.join(VIEWS)}, or azimuth and height in degrees, such as 30,20. front is -y; "
        "flat: from above, to scale, without light or border (default: auto, onto the paint)",
    )
    add_pixels_option(group, pixels)
    group.add_argument("--zoom", metavar="X", type=float, help="0.1 to 20 (default: 1)")
    group.add_argument(
        "--light",
        choices=LIGHTS,
        help="raking comes from low on the left; none shows every colour as it was painted, in a "
        "parallel projection (default: studio)",
    )


def _parse_view(text: str) -> str | tuple[float, float]:
    if text in VIEWS:
        return text
    try:
        azimuth, height = (float(part) for part in text.split(","))
    except ValueError:
        azimuth = height = math.nan
    if not (abs(azimuth) <= 360.0 and abs(height) <= 90.0):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a view; expected one of {', '.join(VIEWS)}, or azimuth (-360 to "
            "360) and height (-90 to 90) in degrees, such as 30,20"
        )
    return azimuth, height


def _parse_turn(text: str) -> float:
    return parse_number(text, "a time", "0.1 to 120 seconds", lambda n: 0.1 <= n <= 120.0)


def run(options: argparse.Namespace) -> None:
    """Open the painting and write the picture.

    Raises
    ------
    Paint3DError
        If the painting cannot be opened, or the picture cannot be made or written.
    """
    check_output_file(options.out, _SUFFIXES)
    read = (options.painting, own_file(options.material))
    check_overwriting((options.out,), read, force=options.force)
    if options.out.suffix.lower() == ".svg":
        _draw_outlines(options)
    else:
        _take_picture(options)
    if not options.quiet:
        sys.stdout.write(f"{options.out}\n")


def _draw_outlines(options: argparse.Namespace) -> None:
    from paint3d.app.model.stroke_log import strokes_of
    from paint3d.cli.results import brush_of, check_is_plane, export_recordings
    from paint3d.errors import ExportError
    from paint3d.files.project.session import Session
    from paint3d.recording.recording import load_recording

    if is_recording(options.painting):
        check_input_file(options.painting, "a recording")
        recording = load_recording(options.painting)
        strokes = [(recording, brush_of(recording))]
    else:
        painting = open_painting(options)
        if not isinstance(painting, Session) or not (painting.recordings or painting.strokes):
            raise ExportError(
                "{painting} holds no strokes; expected a recording, or a session with recordings, "
                "for an .svg of strokes",
                painting=options.painting,
            )
        check_is_plane(painting.surface.source)
        strokes = [(recording, brush_of(recording)) for recording in painting.recordings]
        by_hand = strokes_of(painting.strokes, painting.settings.get("brushes"))
        brushes = [stroke.brush for stroke in by_hand]
        strokes += zip(painting.strokes, brushes, strict=True)
    with ProgressBar("drawing", enabled=not options.quiet):
        export_recordings(strokes, options.out)


def _take_picture(options: argparse.Namespace) -> None:
    if is_recording(options.painting):
        raise InputError(
            "{painting} is a recording; expected a painting, or --out FILE.svg (paint3d replay "
            "paints it)",
            painting=options.painting,
        )
    check_input_file(options.painting, "a painting (.p3d), a mesh", BUILT_IN_OBJECTS)
    from paint3d.colour.materials import load_material
    from paint3d.files.pictures import Turning, write_picture
    from paint3d.files.project.session import Session
    from paint3d.view.shot import Shot

    material = None if options.material is None else load_material(options.material)
    turning = None
    if options.turn is not None or options.out.suffix.lower() in _ALWAYS_FILMS:
        turning = Turning(options.turn or _TURN_S, options.fps or _FPS)
    size = options.pixels or (FILM_SIZE if turning is not None else None)
    shot = Shot(options.view, size, options.light, options.transparent, options.zoom)
    viewing = viewing_of(options)
    painting = open_painting(options)
    surface = painting.surface if isinstance(painting, Session) else painting
    with ProgressBar("drawing", enabled=not options.quiet) as progress:
        write_picture(surface, options.out, shot, turning, material, progress, viewing)

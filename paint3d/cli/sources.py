"""Sources of `paint3d write`: a text in known characters or in a font, a drawing, strokes."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import FILES, group_of
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.calligraphy.fonts.typesetting import FontText
    from paint3d.calligraphy.page.page import Composer
    from paint3d.calligraphy.writing import Written
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording

__all__ = [
    "STROKES_FILE",
    "TRIALS",
    "WHAT",
    "add_drawing_options",
    "add_rehearsals_option",
    "add_source_options",
    "check_source",
    "lay_on",
    "open_page",
    "parse_face",
    "save_written",
]

WHAT = "what is written"
STROKES_FILE = (".strokes.json",)
TRIALS = 2
_MOST_TRIALS = 9

_OF_A_FONT = ("font_number", "features", "font_axes", "direction", "language")


def add_source_options(parser: argparse.ArgumentParser) -> None:
    """Add the sources other than a text, and the file to save their strokes in."""
    source = group_of(parser, WHAT)
    _add_font_options(source)
    add_drawing_options(source, "write a drawing instead of a text")
    source.add_argument(
        "--strokes",
        metavar="FILE",
        type=Path,
        help="write what --save-strokes kept (.strokes.json), as it may have been corrected",
    )
    group_of(parser, FILES).add_argument(
        "--save-strokes",
        metavar="FILE",
        type=Path,
        help="also keep the strokes of a font's text or a drawing in a plain file (.strokes.json)",
    )
    add_rehearsals_option(source, "of --strokes that say how dry or how pale they are: ")


def add_rehearsals_option(parser: argparse._ActionsContainer, which: str = "") -> None:
    """Add ``--rehearsals``; `which` begins its help; None by default."""
    parser.add_argument(
        "--rehearsals",
        metavar="N",
        type=_parse_rehearsals,
        help=f"{which}paint it so often beforehand, to see how dry and how pale it comes out and "
        f"correct that (default: {TRIALS})",
    )


def _parse_rehearsals(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) <= _MOST_TRIALS):
        raise argparse.ArgumentTypeError(f"{text!r}; expected 0 to {_MOST_TRIALS}")
    return int(text)


def add_drawing_options(parser: argparse._ActionsContainer, what: str) -> None:
    """Add ``--svg``, with its help, and ``--ids``."""
    parser.add_argument("--svg", metavar="FILE", type=Path, help=what)
    parser.add_argument(
        "--ids",
        metavar="A,B",
        type=_parse_names,
        help="of the drawing, only the elements and groups with these ids",
    )


def _add_font_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--font",
        metavar="FONT",
        help="write the text in a font: a .ttf, .otf or .ttc, or a name that `paint3d fonts` lists",
    )
    parser.add_argument(
        "--font-number",
        metavar="N",
        type=parse_face,
        help="which face of a .ttc, from 0 (default: 0)",
    )
    parser.add_argument(
        "--features",
        metavar="TAG=N,...",
        type=_parse_features,
        help="features of the font, such as liga=0,ss01",
    )
    parser.add_argument(
        "--font-axes",
        metavar="AXIS=V,...",
        type=_parse_axes,
        help="of a variable font, such as wght=700",
    )
    parser.add_argument(
        "--direction",
        choices=("ltr", "rtl", "ttb"),
        help="of the font's lines (default: as the text begins; ttb with --layout columns)",
    )
    parser.add_argument(
        "--language", metavar="CODE", help="of the text, such as ar, sr, ja: fonts may heed it"
    )


def parse_face(text: str) -> int:
    """Parse a whole number, 0 or more."""
    if not (text.isascii() and text.isdigit() and len(text) < 7):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number; expected 0 or more")
    return int(text)


def _parse_features(text: str) -> dict[str, int]:
    """Parse tags of four letters with a number; alone 1, with a minus before it 0."""
    features = {}
    for part in text.split(","):
        tag, _, number = part.strip().partition("=")
        value = number or ("0" if tag.startswith("-") else "1")
        tag = tag.lstrip("+-")
        if len(tag) != 4 or not tag.isascii() or not value.isdigit():
            raise argparse.ArgumentTypeError(f"{part!r}; expected a feature such as liga=0")
        features[tag] = int(value)
    return features


def _parse_axes(text: str) -> dict[str, float]:
    values = {}
    for part in text.split(","):
        tag, _, number = part.strip().partition("=")
        try:
            values[tag] = float(number)
        except ValueError:
            values[tag] = math.nan
        if len(tag) != 4 or not math.isfinite(values[tag]):
            raise argparse.ArgumentTypeError(f"{part!r}; expected an axis such as wght=700")
    return values


def _parse_names(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"{text!r}; expected names, such as leaf,stem")
    return names


def check_source(options: argparse.Namespace) -> None:
    """Refuse options that do not go together, before any work.

    Raises
    ------
    InputError
        If there is nothing to write, more than one thing, or an option of another one.
    """
    given = [
        name
        for name, value in (
            ("a text", options.text),
            ("--svg", options.svg),
            ("--strokes", options.strokes),
        )
        if value is not None
    ]
    if len(given) != 1:
        got = " and ".join(given) or "nothing to write"
        raise InputError("got {got}; expected one of TEXT, --svg FILE and --strokes FILE", got=got)
    if options.rehearsals is not None and options.strokes is None:
        raise InputError("--rehearsals is given without strokes; expected --strokes FILE")
    if options.ids is not None and options.svg is None:
        raise InputError("--ids is given without a drawing; expected --svg FILE")
    if options.font is not None and options.text is None:
        raise InputError("--font is given without a text; expected TEXT")
    if options.save_strokes is not None and options.svg is None and options.font is None:
        raise InputError(
            "--save-strokes is given without a font or a drawing; expected --font or --svg"
        )
    for name in _OF_A_FONT if options.font is None else ():
        if getattr(options, name) is not None:
            option = name.replace("_", "-")
            raise InputError(
                "--{option} is given without a font; expected --font FONT",
                option=option,
            )


def open_page(options: argparse.Namespace) -> Composer | None:
    """Open the page to write; None for a text in known characters.

    Raises
    ------
    InputError
        If a font, a drawing or a file of strokes cannot be used.
    """
    if options.svg is not None:
        from paint3d.calligraphy.page.svg_drawing import load_svg

        return load_svg(options.svg, options.ids or ())
    if options.strokes is not None:
        from paint3d.calligraphy.page.strokes_file import load_strokes

        return load_strokes(options.strokes)
    return _open_text(options) if options.font is not None else None


def _open_text(options: argparse.Namespace) -> FontText:
    """Set the text in a font; strokes of known characters are from a folder or `kanjivg`."""
    from paint3d.calligraphy.fonts.font_file import open_font
    from paint3d.calligraphy.fonts.shaping import Style
    from paint3d.calligraphy.fonts.typesetting import set_text
    from paint3d.calligraphy.glyph_sources import open_glyphs
    from paint3d.calligraphy.kanjivg import find_kanjivg

    known = options.glyphs is not None or find_kanjivg() is not None
    templates = open_glyphs(options.glyphs) if known else None
    font = open_font(options.font, options.font_number or 0, options.font_axes)
    style = Style(options.features or {}, options.direction, options.language)
    return set_text(options.text, font, style, templates, options.layout)


def save_written(written: Written, file: Path) -> None:
    """Save the strokes of a text or a drawing, as it was composed.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    from paint3d.calligraphy.page.strokes_file import save_strokes

    assert written.page is not None
    save_strokes(written.page, file)


# ---- Pads ----------------------------------------------------------------------------------------
# Recordings from a flat pad, laid on the object.


def lay_on(
    mesh: TriangleMesh,
    recording: Recording,
    place: tuple[float, float] | None,
    width_mm: float | None,
) -> Recording | LaidPad:
    """Return the recording in the world: laid on the mesh if it is a pad's, else as it is.

    A pad's recording that knows no dips gets one before every stroke.

    Parameters
    ----------
    mesh : TriangleMesh
    recording : Recording
    place : (float, float) or None
        Of its middle, as `paint3d.mesh.placement.place` takes it; None: the middle.
    width_mm : float or None
        None: as wide as it was drawn.

    Raises
    ------
    InputError
        If it does not fit there, or a place is given for a recording that has its own.
    """
    if not recording.is_pad:
        if place is not None or width_mm is not None:
            raise InputError(
                "--at and --size lay a pad's recording; this one has its own place in the world"
            )
        return recording
    from paint3d.painter.flat_input import lay_at

    return lay_at(recording, mesh, place or (0.5, 0.5), width_mm)

"""In which light, by which observer and on what screen a painting is shown: the options."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from paint3d.colour.viewing import Viewing

__all__ = ["add_light_options", "viewing_of"]

_ADAPTATIONS, _GAMUTS = ("cat16", "bradford", "none"), ("srgb", "p3", "rec2020")


def add_light_options(parser: argparse.ArgumentParser) -> None:
    """Add --illuminant, --observer, --adaptation and --gamut."""
    parser.add_argument(
        "--illuminant",
        metavar="LIGHT",
        default="D65",
        help="the light it is seen in: A, D50, D65, F2, F11, LED-B3 and others of the CIE, a "
        "temperature such as 2700K, or a spectrum's FILE.spd, .csv or .spdx (default: D65)",
    )
    parser.add_argument(
        "--observer",
        metavar="DEGREES",
        type=int,
        choices=(2, 10),
        default=2,
        help="2 or 10: the CIE's standard observer of 1931 or of 1964 (default: 2)",
    )
    parser.add_argument(
        "--adaptation",
        choices=_ADAPTATIONS,
        default="cat16",
        help="of the eye to the light; none: white has the colour of the light (default: cat16)",
    )
    parser.add_argument(
        "--gamut",
        choices=_GAMUTS,
        default="srgb",
        help="colours that the file can hold; p3 and rec2020 for .png, .webp and .usdz "
        "(default: srgb)",
    )


def viewing_of(options: argparse.Namespace) -> Viewing | None:
    """What the options say; None where they change nothing.

    Raises
    ------
    InputError
        If the light is not known, or colour-science is missing.
    """
    from paint3d.colour.viewing import Viewing

    found = Viewing(options.illuminant, options.observer, options.adaptation, options.gamut)
    return None if found.is_plain else found

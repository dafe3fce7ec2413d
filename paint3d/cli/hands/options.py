"""Options about the hands' devices."""

from __future__ import annotations

import argparse

__all__ = ["add_stylus_option"]


def add_stylus_option(parser: argparse.ArgumentParser, default: str) -> None:
    """Let the stylus be chosen; None where it is not."""
    parser.add_argument(
        "--stylus",
        metavar="KIND",
        type=_parse_stylus,
        help="auto, hid, openhaptics (Touch, Phantom; =/PATH/libHD.so), inverse3 "
        f"(Haply; =ws://HOST:PORT) or none{default}",
    )


def _parse_stylus(text: str) -> str:
    from paint3d.errors import InputError
    from paint3d.haptics.stylus_choice import check_stylus

    try:
        return check_stylus(text)
    except InputError as cause:
        raise argparse.ArgumentTypeError(str(cause)) from None

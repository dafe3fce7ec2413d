"""A finished copy beside its photograph, and how alike they are."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

import numpy as np

from paint3d.cli.progress import ProgressBar

if TYPE_CHECKING:
    from paint3d.calligraphy.photo.copying import CopiedSheet
    from paint3d.calligraphy.writing import Written
    from paint3d.cli.results import Painting

__all__ = ["show_beside"]

_GAP = 24  # pixels between the two pictures


def show_beside(
    sheet: CopiedSheet, written: Written, painting: Painting, options: argparse.Namespace
) -> None:
    """Write the sheet and the painting side by side, and tell the figures.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    from PIL import Image

    from paint3d.calligraphy.photo.likeness import likeness_of, painted_sheet
    from paint3d.core.atomic import write_atomically

    with ProgressBar("comparing", enabled=not options.quiet):
        assert written.page is not None
        placed = list(zip(written.page.pieces, written.placed, strict=True))
        painted = painted_sheet(sheet, placed, painting.surface)
        figures = likeness_of(sheet, painted)
        gap = np.full((sheet.picture.shape[0], _GAP, 3), 255, np.uint8)
        both = np.concatenate([sheet.picture, gap, painted.picture], axis=1)
        with write_atomically(options.beside) as part:
            kind = "PNG" if options.beside.suffix.lower() == ".png" else "JPEG"
            Image.fromarray(both).save(part, kind)
    if not options.quiet:
        sys.stdout.write(f"{options.beside}: {figures.told()}\n")

#!/usr/bin/env python
"""Draw the palette as a glaze chart: each pigment from a thin wash to a full coat and beyond.

Usage: python scripts/gallery/palette.py [--out FILE]

Every row is one pigment over three dry grounds (white chart, black soot, clay); within each the
coats grow by equal factors from 0.03 to 2. The colours are those of the 31-band reference.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from paint3d.colour.layers import layer_reflectance
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import Pigment, load_palette
from paint3d.colour.spectra import srgb_from_reflectance

OUT = Path(__file__).parents[2] / "docs/gallery/palette.png"
COATS = np.geomspace(0.03, 2.0, 12)
CELL, ROW, LABEL, GAP, TOP = 38, 40, 330, 24, 64
PAPER, INK, PALE = (250, 249, 246), (40, 38, 36), (120, 116, 110)
FONTS = (
    "/usr/share/fonts/opentype/noto/NotoSerifCJK-Regular.ttc",
    "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
    "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
    "/usr/share/fonts/truetype/arphic/ukai.ttc",
)


def grounds() -> dict[str, NDArray]:
    """What the pigments are laid over: reflectances (31,)."""
    soot = load_palette()["pine soot"]
    white = load_material("porcelain").reflectance
    return {
        "over white": white,
        "over dried soot": layer_reflectance(soot.K, soot.S, 2.0, white),
        "over clay": load_material("terracotta").reflectance,
    }


def find_font(size: int) -> tuple[ImageFont.FreeTypeFont | ImageFont.ImageFont, bool]:
    """A font, and whether it has Chinese characters."""
    for name in FONTS:
        if Path(name).exists():
            return ImageFont.truetype(name, size), True
    return ImageFont.load_default(size), False


def swatch(pigment: Pigment, ground: NDArray) -> NDArray:
    """(12, 3) uint8 of one pigment over one ground."""
    return srgb_from_reflectance(layer_reflectance(pigment.K, pigment.S, COATS[:, None], ground))


def draw_chart() -> Image.Image:
    """The chart as a picture."""
    palette, below = list(load_palette().values()), grounds()
    strip = CELL * len(COATS)
    width = LABEL + len(below) * (strip + GAP) + GAP
    image = Image.new("RGB", (width, TOP + ROW * len(palette) + GAP), PAPER)
    draw = ImageDraw.Draw(image)
    large, has_chinese = find_font(20)
    small, _ = find_font(14)
    for g, (title, ground) in enumerate(below.items()):
        x = LABEL + g * (strip + GAP)
        draw.text((x, 12), title, INK, large)
        draw.text((x, 38), f"{COATS[0]:.2g} to {COATS[-1]:.2g} coats", PALE, small)
        bare = tuple(int(c) for c in srgb_from_reflectance(ground))
        bottom = TOP + ROW * len(palette)
        draw.rectangle((x - 8, TOP - 6, x + strip + 7, bottom + 5), fill=bare)
        for row, pigment in enumerate(palette):
            y = TOP + row * ROW
            for k, colour in enumerate(swatch(pigment, ground)):
                left = x + k * CELL
                box = (left, y + 4, left + CELL - 1, y + ROW - 5)
                draw.rectangle(box, fill=tuple(int(c) for c in colour))
    for row, pigment in enumerate(palette):
        y = TOP + row * ROW
        name = f"{pigment.chinese}  {pigment.name}" if has_chinese else pigment.name
        draw.text((GAP, y + 2), name, INK, large)
        basis = pigment.basis if len(pigment.basis) < 46 else pigment.basis[:44] + "…"
        draw.text((GAP, y + 24), basis, PALE, find_font(11)[0])
    return image


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    draw_chart().save(options.out, optimize=True)


if __name__ == "__main__":
    main()

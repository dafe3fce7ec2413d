"""Any hand: other scripts, a font's running hand, a logo, and a drawing, by their commands.

Fonts: Amiri, Lohit Devanagari and Kaushan Script (OFL), and Kouzan's gyosho, a free brush font.
The photographed character of any hand is `photographs.py`, the poem with its seal `seals.py`.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image
from seals import run
from trimesh.creation import revolve
from writing import beside, stacked

TILE = 760, 600
GYOSHO = "/usr/share/fonts/truetype/kouzan-mouhitsu/kouzan-mouhitsu-gyosho.ttf"
CUP = (  # mm: radius and height, up the outside, over the rim and down the inside
    (0, 0), (22, 0), (25, 1), (26, 3), (34, 72), (36, 86), (36.5, 88), (35.5, 89), (34.5, 88),
    (32, 70), (24, 6), (20, 4), (0, 4),
)  # fmt: skip
LOGO = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="-60 -60 120 120">
<defs><path id="leaf" d="M0 0 C-16 -14 -15 -36 0 -52 C15 -36 16 -14 0 0Z M0 -14 C4 -24 4 -32 0 -40
C-4 -32 -4 -24 0 -14Z" fill-rule="evenodd"/></defs>
<g><use href="#leaf"/><use href="#leaf" transform="rotate(72)"/><use href="#leaf"
transform="rotate(144)"/><use href="#leaf" transform="rotate(216)"/><use href="#leaf"
transform="rotate(288)"/></g>
<circle r="56" fill="none" stroke="black" stroke-width="3"/></svg>"""
CARP = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 150" fill="none" stroke="black"
stroke-linecap="round" stroke-linejoin="round" stroke-width="2.6">
<path stroke-width="4" d="M30 78 C46 46 92 34 132 48 C158 57 172 70 186 76"/>
<path stroke-width="4" d="M30 78 C44 104 92 118 134 104 C158 96 172 84 186 76"/>
<path d="M62 50 C74 64 74 96 60 104"/><circle cx="46" cy="70" r="4"/>
<path d="M30 78 C36 82 42 83 48 82"/><path d="M32 84 C26 92 24 98 26 104"/>
<path d="M36 88 C32 98 34 104 38 110"/>
<path d="M92 40 C106 20 132 16 150 26 C142 34 138 40 134 48"/>
<path d="M106 38 L118 26 M118 40 L132 24"/>
<path d="M186 76 C200 58 214 50 228 46 C220 60 218 70 218 78 C220 88 224 98 230 108 C214 102 200 94
186 76Z"/><path d="M196 76 L216 60 M196 78 L214 78 M196 80 L216 96"/>
<path d="M82 108 C80 122 88 132 100 136 C102 126 104 118 104 112"/>
<path d="M138 104 C140 114 146 120 154 122 C154 114 152 106 150 98"/>
<path d="M84 62 C90 66 90 72 84 76 M84 78 C90 82 90 88 84 92 M100 56 C106 60 106 66 100 70
M100 72 C106 76 106 82 100 86 M100 88 C106 92 106 98 100 102 M116 58 C122 62 122 68 116 72
M116 74 C122 78 122 84 116 88 M132 62 C138 66 138 72 132 76 M132 78 C138 82 138 88 132 92
M148 68 C153 72 153 78 148 82"/>
<path stroke-width="1.6" d="M14 132 C40 124 60 140 86 132 C112 124 132 140 158 132"/></svg>"""


def draw_any_hand(file: Path, _: Path) -> None:
    """Six objects, each written on by one command."""
    tiles: list[Image.Image] = []
    with TemporaryDirectory() as folder:
        at = partial(Path, folder)
        at("logo.svg").write_text(LOGO)
        at("carp.svg").write_text(CARP)
        revolve(np.array(CUP, float), sections=160).export(at("cup.ply"))
        for name, view, zoom, words in (
            ("vase", "front", 2.1, ("سلام", "--font", "Amiri", "--on", "vase", "--size", 74)),
            ("bowl", "front", 1.1, ("行雲流水明月清風", "--font", GYOSHO, "--on", "bowl", "--size",
                                    33, "--layout", "row", "--around")),
            ("sphere", "front", 1.0, ("शान्ति", "--font", "Lohit Devanagari", "--on", "sphere",
                                      "--size", 40, "--ink", "cinnabar")),
            ("cup", "front", 1.2, ("--svg", at("logo.svg"), "--on", at("cup.ply"), "--up", "z",
                                   "--size", 44, "--material", "porcelain", "--ink", "indigo")),
            ("plate", "above", 1.1, ("--svg", at("carp.svg"), "--on", "plate", "--size", 122)),
            ("plane", "above", 1.5, ("Amélie", "--font", "Kaushan Script", "--on", "plane",
                                     "--material", "xuan", "--size", 46)),
        ):  # fmt: skip
            painting = at(f"{name}.p3d")
            run("write", *words, "--resolution", 0.2, "--out", painting)
            run("picture", painting, "--view", view, "--zoom", zoom, "--pixels",
                f"{2 * TILE[0]}x{2 * TILE[1]}", "--out", at(f"{name}.png"))  # fmt: skip
            with Image.open(at(f"{name}.png")) as picture:
                tiles.append(picture.convert("RGB").resize(TILE, Image.LANCZOS))
    stacked([beside(tiles[:3]), beside(tiles[3:])]).save(file)


PICTURES = {"any_hand.png": draw_any_hand}

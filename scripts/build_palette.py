"""Build the palette: K and S per coat of the inks and colours to paint with.

Usage: python scripts/build_palette.py FOLDER [--out FILE]

FOLDER holds the published measurements: drawdowns.csv (CC0), kimera_relative_KS.csv (MIT) and
usgs_reflectance.csv (public domain). The two inks are computed (scripts/soot.py), azurite,
malachite and lapis lazuli by the size of their grains (scripts/grains.py), indigo and gamboge by
their bands (scripts/bands.py). In order of preference another pigment comes from

- drawdowns over black and white: K and S as fitted by scripts/fit_drawdowns.py, here without
  Saunderson's correction, so that they give the measured reflectance less the gloss, which was
  measured with it and is the picture's to add; one drawdown is one coat;
- K and S relative to a white paint: scaled so that one coat hides 98 %;
- the reflectance R of an opaque layer: K/S = (1 - R)^2 / 2R, one S for all wavelengths, scaled
  likewise. That is a guess of S, good for strongly scattering pigments.

A coat of every grade of a stone holds as much of it as a coat of the second, which hides 98 %.
Hiding is the luminance of one coat over black by that over a chart of 80 %. What is ground in water
and glue is thinner than a drawdown or a layer that hides: of some, a coat holds the part in
`COATS` of it. Dyes and lakes that are painted as washes (indigo, carmine) hide only when almost
black: their coat is the one that takes the chart's lightness L* 80 % of the way down to the opaque
layer's. A dip's parts of these coats are volume, so no density is written. A pigment that could not
be had under clear terms is replaced by a named substitute. The output is the same bytes on every
run.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
from bands import gamboge, indigo
from fit_drawdowns import HEADER, fit, read_drawdowns, without_gloss
from grains import SIZES_UM, STONES, grade, powders
from numpy.typing import NDArray
from scipy.optimize import brentq
from soot import SOOTS, soot_ink

from paint3d.colour.difference import lab_from_reflectance
from paint3d.colour.layers import layer_reflectance
from paint3d.colour.spectra import WAVELENGTHS, xyz_from_reflectance

OUT = Path(__file__).parents[1] / "paint3d/colour/data/palette.csv"
HIDING, CHART, DEPTH = 0.98, 0.8, 0.8
WASHES = {"indigo", "carmine"}

GELDOF = "Geldof et al., Heritage Science 6:17 (2018), fligt/revigo-spectra, {}"
KIMERA = "Kimera acrylics, miciwan/PaintMixing, {}"
USGS = "USGS Spectral Library 7 (Kokaly et al. 2017, Data Series 1035), {}"
LICENCES = {"drawdown": "CC0-1.0", "kimera": "MIT", "usgs": "public domain (US government)"}
SOURCES = {"drawdown": GELDOF, "kimera": KIMERA, "usgs": USGS}
BASES = {"drawdown": "measured K,S", "kimera": "measured K,S", "usgs": "masstone"}

# name, Chinese name, table, row or column of it, what it stands in for ("" where it is the thing);
# for stones the number of the grade
COLOURS = [
    ("cinnabar", "朱砂", "drawdown", "Vermillion", "synthetic cinnabar (vermilion)"),
    ("minium", "铅丹", "drawdown", "Minium", ""),
    ("azurite 1", "头青", "grains", "azurite", 0),
    ("azurite", "石青", "grains", "azurite", 1),
    ("azurite 3", "三青", "grains", "azurite", 2),
    ("azurite 4", "四青", "grains", "azurite", 3),
    ("malachite 1", "头绿", "grains", "malachite", 0),
    ("malachite", "石绿", "grains", "malachite", 1),
    ("malachite 3", "三绿", "grains", "malachite", 2),
    ("malachite 4", "四绿", "grains", "malachite", 3),
    ("ochre", "赭石", "usgs", "Terra_Pozzuoli_GDS806_ASDFRa", "red-brown earth of Pozzuoli"),
    ("yellow ochre", "土黄", "kimera", "yellow oxide", "substitute: synthetic goethite"),
    ("red ochre", "土红", "kimera", "red oxide", "substitute: synthetic hematite"),
    ("hematite", "赤铁矿", "usgs", "Hematite_GDS27_BECKa", ""),
    ("gamboge", "藤黄", "band", "", ""),
    ("orpiment", "雌黄", "drawdown", "ChromeYellowOtero", "substitute: chrome yellow"),
    ("realgar", "雄黄", "kimera", "orange", "substitute: organic orange"),
    ("indigo", "花青", "band", "", ""),
    ("lapis lazuli", "青金石", "grains", "lapis lazuli", 1),
    ("verdigris", "铜绿", "usgs", "Verdigris_GDS789_ASDFRa", ""),
    ("emerald green", "巴黎绿", "drawdown", "EmeraldGreen", ""),
    ("carmine", "胭脂", "drawdown", "Cochineal", "substitute: cochineal lake"),
    ("shell white", "蛤粉", "usgs", "Aragonite_GDS1073_ASDNGc", "substitute: mineral aragonite"),
    ("lead white", "铅白", "drawdown", "LeadWhite", ""),
    ("titanium white", "钛白", "kimera", "white", ""),
]

INKS = [("pine soot", "松烟墨"), ("oil soot", "油烟墨")]
SOOT_SOURCE = (
    "index of soot: Dalzell, Sarofim, J. Heat Transfer 91 (1969); sizes of its particles: "
    "Boku-undo; scripts/soot.py"
)
SOOT_BASIS = "computed from spheres of {:g} to {:g} nm in glue (strength set by eye)"
STONE_SOURCE = "powders of {}, and the stone's index (Handbook of Mineralogy); scripts/grains.py"
STONE_BASIS = "computed from a powder for grains of {:g} um in paint (sizes set by eye)"
BANDS = {
    "indigo": (
        "its band: Ratnapandian, thesis, RMIT University (2013); scripts/bands.py",
        "computed from one band at 660 nm (widths and grey set by eye)",
    ),
    "gamboge": (
        "its colour when thick: Maerz, Paul, A Dictionary of Color (1930); scripts/bands.py",
        "computed from one edge in violet (strength set by eye)",
    ),
}
"""Source and basis of what is computed from a band."""

COATS = {
    "cinnabar": 0.065,
    "minium": 0.1,
    "orpiment": 0.1,
    "realgar": 0.25,
    "ochre": 0.35,
    "yellow ochre": 0.4,
    "red ochre": 0.4,
    "hematite": 0.35,
    "lapis lazuli": 0.4,
}
"""What a coat holds, over a drawdown or a coat that hides 98 %; 1 for others.

Set by eye, such that a colour gets paler with water as painters know it; a drawdown is some .05 to
.1 mm of paint, two fifths of it cinnabar by volume, and a coat .03 mm of a liquid that flows off a
brush.
"""

GLOSSES = {"oil soot": 0.4, "gamboge": 0.3}
"""How glossy a coat dries; set by eye: oil soot is known for its gloss, gamboge is a resin."""

FINES = {
    "pine soot": 0.3,
    "oil soot": 0.35,
    "cinnabar": 0.02,
    "minium": 0.04,
    "azurite 1": 0.0,
    "azurite": 0.0,
    "azurite 3": 0.01,
    "azurite 4": 0.03,
    "malachite 1": 0.0,
    "malachite": 0.0,
    "malachite 3": 0.01,
    "malachite 4": 0.03,
    "ochre": 0.05,
    "yellow ochre": 0.06,
    "red ochre": 0.06,
    "hematite": 0.03,
    "gamboge": 0.8,
    "orpiment": 0.01,
    "realgar": 0.01,
    "indigo": 0.4,
    "lapis lazuli": 0.0,
    "verdigris": 0.03,
    "emerald green": 0.03,
    "carmine": 0.97,
    "shell white": 0.03,
    "lead white": 0.05,
    "titanium white": 0.08,
}
"""The share that no pore of paper holds back.

No measurement of it was to be had. Pine soot's is what the halo was set by; the others are set by
eye, in the order of their grains. Oil soot's are the smaller ones (Boku-undo: 15 to 80 nm, but glue
keeps soot in flocks: Swider, Hackley, Winter, J. Cultural Heritage 4, 2003). Gamboge is a gum (a
fifth) that dissolves and a resin that it turns to an emulsion (CAMEO, Museum of Fine Arts, Boston);
carmine is a dye in water, save for what is laked; indigo does not dissolve, but is ground and
washed for days until it floats. Stones are sold by grain, 40 to 5 um here, and lie between the
fibres or on them.
"""


GRAINS_UM = {
    "cinnabar": 4.0,
    "minium": 3.0,
    "ochre": 3.0,
    "yellow ochre": 1.0,
    "red ochre": 1.0,
    "hematite": 4.0,
    "orpiment": 10.0,
    "realgar": 10.0,
    "indigo": 0.5,
    "verdigris": 8.0,
    "emerald green": 8.0,
    "shell white": 5.0,
    "lead white": 1.0,
    "titanium white": 0.3,
}
"""Diameter of the grains of the rest, um, set by eye; of stones that of their grade, 0 of others.

For soot, whose flocs a material's `passing` is of, and dyes, of which hardly anything is left.
"""


def scale_to_hiding(k: NDArray, s: NDArray) -> tuple[NDArray, NDArray]:
    """Scale K and S (31,) so that one coat hides 98 %."""

    def excess(log_scale: float) -> float:
        scale = np.exp(log_scale)
        films = [layer_reflectance(k * scale, s * scale, 1.0, chart) for chart in (0.0, CHART)]
        over_black, over_white = xyz_from_reflectance(films)[:, 1]
        return over_black / over_white - HIDING

    scale = np.exp(brentq(excess, -12.0, 12.0, xtol=1e-12))
    return k * scale, s * scale


def scale_to_depth(k: NDArray, s: NDArray) -> tuple[NDArray, NDArray]:
    """Scale K and S (31,) so that one coat darkens the chart 80 % as much as an opaque layer."""

    def lightness(log_scale: float) -> float:
        film = layer_reflectance(k, s, np.exp(log_scale), np.full_like(k, CHART))
        return lab_from_reflectance(film)[0]

    light, dark = lightness(-30.0), lightness(12.0)
    wanted = light + DEPTH * (dark - light)
    scale = np.exp(brentq(lambda x: lightness(x) - wanted, -12.0, 12.0, xtol=1e-12))
    return k * scale, s * scale


def drawdown_reader(path: Path) -> Callable[[str], tuple[NDArray, NDArray]]:
    """Read K and S per drawdown, by the name of the paint."""
    data = without_gloss(read_drawdowns(path))
    log_ks, _ = fit(data, (0.0, 0.0), pulls=(0.005, 0.005, 0.0))
    k, s = np.exp(log_ks).transpose(1, 2, 0)
    return lambda name: (k[data.paints.index(name)], s[data.paints.index(name)])


def kimera_reader(path: Path) -> Callable[[str], tuple[NDArray, NDArray]]:
    """Read relative K and S, by the name of the paint, unscaled."""
    with path.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))

    def read(name: str) -> tuple[NDArray, NDArray]:
        matches = [row for row in rows if row["pigment"] == name]
        table = {float(r["wavelength_nm"]): (r["K_rel"], r["S_rel_to_white"]) for r in matches}
        k, s = np.array([table[nm] for nm in WAVELENGTHS], dtype=float).T
        return k, s

    return read


def usgs_reader(path: Path) -> Callable[[str], tuple[NDArray, NDArray]]:
    """Read K/S of an opaque layer, with S = 1, by the name of the column."""
    with path.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))

    def read(name: str) -> tuple[NDArray, NDArray]:
        table = {float(row["wavelength_nm"]): float(row[name]) for row in rows}
        r = np.array([table[nm] for nm in WAVELENGTHS])
        return (1.0 - r) ** 2 / (2.0 * r), np.ones_like(r)

    return read


def palette_rows(folder: Path) -> list[list[str]]:
    """Make all rows of the table, inks first."""
    readers = {
        "drawdown": drawdown_reader(folder / "drawdowns.csv"),
        "kimera": kimera_reader(folder / "kimera_relative_KS.csv"),
        "usgs": usgs_reader(folder / "usgs_reflectance.csv"),
    }
    rows = []
    for name, chinese in INKS:
        basis = SOOT_BASIS.format(*SOOTS[name])
        rows.append(_row(name, chinese, SOOT_SOURCE, basis, "MIT", *soot_ink(name)))
    for name, chinese, table, key, note in COLOURS:
        if table in ("grains", "band"):
            rows.append(_computed_row(folder, name, chinese, key, note))
            continue
        k, s = readers[table](key)
        if name in WASHES:
            k, s = scale_to_depth(k, s)
        elif table != "drawdown":
            k, s = scale_to_hiding(k, s)
        basis = BASES[table] + (f" ({note})" if note else "")
        rows.append(_row(name, chinese, SOURCES[table].format(key), basis, LICENCES[table], k, s))
    return rows


def _computed_row(folder: Path, name: str, chinese: str, stone: str, number: int) -> list[str]:
    """Make the row of a grade of a stone, or of a dye."""
    if not stone:
        k, s = scale_to_depth(*indigo()) if name == "indigo" else gamboge()
        return _row(name, chinese, *BANDS[name], "MIT", k, s)
    powder = powders(folder)
    k, s = grade(STONES[stone], SIZES_UM[number], powder)
    second = grade(STONES[stone], SIZES_UM[1], powder)
    per_coat = scale_to_hiding(*second)[0][0] / second[0][0]
    names = dict.fromkeys([*(of for of, _ in STONES[stone].powders), STONES[stone].coarsest])
    source = STONE_SOURCE.format(USGS.format(", ".join(names)))
    size = SIZES_UM[number]
    words = name, chinese, source, STONE_BASIS.format(size), LICENCES["usgs"]
    return _row(*words, k * per_coat, s * per_coat, size)


def _row(name, chinese, source, basis, licence, k, s, grain_um=None) -> list[str]:
    grain_um = GRAINS_UM.get(name, 0.0) if grain_um is None else grain_um
    numbers = GLOSSES.get(name, 0.0), FINES[name], grain_um
    per_coat = np.concatenate([k, s]) * COATS.get(name, 1.0)
    values = [f"{number:g}" for number in numbers] + [f"{value:.5g}" for value in per_coat]
    return [name, chinese, source, basis, licence, "no", *values]


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder with the three tables")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    bands = [f"{letter}_{nm:.0f}" for letter in "KS" for nm in WAVELENGTHS]
    header = [*HEADER, "gloss", "fine", "grain_um", *bands]
    rows = [header, *palette_rows(options.folder)]
    with options.out.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()

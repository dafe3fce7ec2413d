"""Build the table of surface materials: what lies below the paint.

Usage: python scripts/build_materials.py FOLDER [--out FILE]

FOLDER holds usgs_reflectance.csv (public domain) and substrates.csv. The reflectances are
measured; roughness, coat, absorbency and grain are chosen by eye, on a scale of 0 to 1, and so are
friction and how they drink: the column `note` says it of each. The output is the same bytes on
every run.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from paint3d.colour.spectra import WAVELENGTHS

OUT = Path(__file__).parents[1] / "paint3d/colour/data/materials.csv"
USGS = "USGS Spectral Library 7 (Kokaly et al. 2017, Data Series 1035), {}"
CHART = "drawdown charts of Geldof et al., Heritage Science 6:17 (2018), {}"

LOOKS = ["roughness", "coat", "absorbency", "grain", "friction"]
DRINKS = ["pores_mm", "residual", "advance", "spread_mm2_s", "passing", "drying_mm_s", "tooth_mm"]
# How each drinks, in the order of DRINKS; chosen by eye. The pores of xuan follow from its
# grammage and the density of cellulose (0.037 to 0.062 mm); water leaves an open film of it at
# about 4e-5 mm/s in a room, and xuan by both faces. Alum and glue fill most of the pores of sized
# xuan and make the rest shed water, so that it hardly goes on from where it was laid.
DRINK = {
    "porcelain": (0.0, 0.3, 0.3, 0.0, 1.0, 4e-5, 0.0),
    "bisque": (0.2, 0.08, 0.2, 3.0, 0.9, 4e-5, 0.35),
    "xuan": (0.06, 0.15, 0.3, 10.0, 0.25, 8e-5, 0.5),
    "plaster": (0.5, 0.08, 0.2, 3.0, 0.9, 4e-5, 0.4),
    "terracotta": (0.3, 0.08, 0.2, 3.0, 0.9, 4e-5, 0.55),
    "sized xuan": (0.02, 0.5, 0.95, 0.004, 0.3, 4e-5, 0.45),
    "tinted xuan": (0.045, 0.3, 0.55, 1.0, 0.25, 6e-5, 0.5),
    "silk": (0.015, 0.5, 0.9, 0.008, 0.4, 4e-5, 0.25),
}
EYE = "all but the reflectance set by eye; "
NOTES = {
    "porcelain": EYE + "a glaze drinks nothing, and hairs glide on it",
    "bisque": EYE + "it drinks in depth",
    "xuan": "pores from the grammage of xuan and the density of cellulose; drying: water leaves an "
    "open film at about 4e-5 mm/s in a room, and xuan by both faces; the rest set by eye; friction "
    "1 by definition",
    "plaster": EYE + "it drinks in depth",
    "terracotta": EYE + "the coarsest of these to hairs",
    "sized xuan": EYE + "alum and glue close its pores: ink stays where it is laid",
    "tinted xuan": EYE + "half sized: between raw and sized xuan",
    "silk": EYE + "sized for painting, threads draw a little; the tooth is about their pitch",
}

# name, Chinese name, file, column, basis, roughness, coat, absorbency, grain,
# friction over that of raw xuan
MATERIALS = [
    ("porcelain", "瓷", "substrates", "Leneta white chart (REVIGO mean)",
     "substitute for white glaze: glossy white chart", 0.15, 1.0, 0.0, 0.0, 0.6),
    ("bisque", "素胎", "usgs_reflectance", "Kaolinite_KGa-1_(wxl)_BECKb",
     "proxy: kaolinite, the clay of porcelain bodies", 0.8, 0.0, 0.6, 0.3, 1.1),
    ("xuan", "宣纸", "usgs_reflectance", "Kaolinite_CM9_BECKb",
     "substitute: kaolinite, a filler of paper (the measured paper is tinted yellow)",
     0.95, 0.0, 1.0, 0.5, 1.0),
    ("plaster", "石灰", "usgs_reflectance", "Calcite_CO2004_BECKb",
     "proxy: calcite, what lime plaster sets to", 0.9, 0.0, 0.7, 0.4, 1.15),
    ("terracotta", "陶", "substrates", "Med red building brick GDS353 (USGS, terracotta proxy)",
     "proxy: red brick", 0.9, 0.0, 0.8, 0.6, 1.25),
    ("sized xuan", "熟宣", "usgs_reflectance", "Kaolinite_CM9_BECKb",
     "substitute: as xuan; alum and glue are clear", 0.85, 0.05, 0.25, 0.35, 0.85),
    ("tinted xuan", "色宣", "usgs_reflectance", "Kaolinite_CM9_BECKb",
     "substitute: as xuan, dyed by so little of Yellow_ochre_GDS794_Germany_ASDFRa that it is "
     "cream, as old paper (R^.88 of the one and R^.12 of the other)", 0.9, 0.0, 0.6, 0.45, 0.95),
    ("silk", "绢", "usgs_reflectance", "Kaolinite_KGa-1_(wxl)_BECKb",
     "substitute: of the measured whites the one nearest to the cream of undyed silk, by eye",
     0.6, 0.15, 0.3, 0.3, 0.75),
]  # fmt: skip
DYES = {"tinted xuan": ("Yellow_ochre_GDS794_Germany_ASDFRa", 0.12)}  # column, and its power


def read_column(path: Path, name: str) -> list[float]:
    """Reflectance at 400, 410, ... 700 nm from one column."""
    with path.open(newline="", encoding="utf-8") as stream:
        table = {float(row["wavelength_nm"]): float(row[name]) for row in csv.DictReader(stream)}
    return [table[nm] for nm in np.asarray(WAVELENGTHS)]


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder with the two tables")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    header = ["name", "chinese", "source", "basis", "licence", "note"]
    header += LOOKS + DRINKS
    rows = [header + [f"R_{nm:.0f}" for nm in WAVELENGTHS]]
    for name, chinese, table, column, basis, *look in MATERIALS:
        usgs = "REVIGO" not in column
        source = (USGS if usgs else CHART).format(column)
        licence = "public domain (US government)" if usgs else "CC0-1.0"
        values = np.array(read_column(options.folder / f"{table}.csv", column))
        if name in DYES:
            dye, power = DYES[name]
            dye_values = np.array(read_column(options.folder / f"{table}.csv", dye))
            values = values ** (1.0 - power) * dye_values**power
        rows.append(
            [
                name,
                chinese,
                source,
                basis,
                licence,
                NOTES[name],
                *look,
                *DRINK[name],
                *(f"{v:.5g}" for v in values),
            ]
        )
    with options.out.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()

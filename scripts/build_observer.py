"""Build paint3d/colour/data/observer.csv: CIE 1931 2-degree observer and D65, 400-700 nm by 10 nm.

Usage: python scripts/build_observer.py [--out FILE]

The tables are the CIE's, as carried by colour-science, which is needed here only: the package
reads the small file. The output is the same bytes on every run.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import colour
import numpy as np

OUT = Path(__file__).parents[1] / "paint3d/colour/data/observer.csv"


def observer_rows() -> list[str]:
    """Rows "wavelength,x,y,z,d65" for 400, 410, ... 700 nm."""
    shape = colour.SpectralShape(400, 700, 10)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    daylight = colour.SDS_ILLUMINANTS["D65"].copy().align(shape)
    table = np.column_stack([observer.values, daylight.values])
    return [
        f"{nm:.0f}," + ",".join(f"{value:.9g}" for value in row)
        for nm, row in zip(shape.wavelengths, table, strict=True)
    ]


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    out = parser.parse_args().out
    lines = ["wavelength_nm,x_bar,y_bar,z_bar,d65", *observer_rows()]
    out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

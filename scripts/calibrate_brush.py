"""Compare a brush with measured presses: width, heel offset and length of the footprint.

    python scripts/calibrate_brush.py TABLE.csv [--brush NAME]

The table has the columns depth_mm, width_mm, drag_mm and offset_mm (presses of an upright brush).
The offset is where the footprint begins behind the handle, the drag how long it is from there.
Readings of one depth are averaged first: they scatter by more than the model is wrong.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.errors import InputError, Paint3DError

COLUMNS = ("depth_mm", "width_mm", "offset_mm", "drag_mm")


def read_presses(path: Path) -> NDArray:
    """Mean reading (N, 4) per depth: depth, width, heel offset, length, mm."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows or not set(COLUMNS) <= rows[0].keys():
        raise InputError(f"{path}: expected the columns {', '.join(COLUMNS)}")
    readings = np.array([[float(row[column]) for column in COLUMNS] for row in rows])
    depths = np.unique(readings[:, 0])
    return np.array([readings[readings[:, 0] == depth].mean(axis=0) for depth in depths])


def predict(brush: str, depths: NDArray) -> NDArray:
    """Width, heel offset and length (N, 3), mm, of the upright brush at depths (N,), mm."""
    tuft = build_tuft(load_brush(brush))
    sizes = np.zeros((len(depths), 3))
    for size, depth in zip(sizes, depths, strict=True):
        footprint = make_footprint(tuft, float(depth), 0.5 * np.pi)
        if not footprint.is_empty:
            size[:] = footprint.width, footprint.reach[-1], footprint.length
    return sizes


def rms_errors(brush: str, path: Path) -> tuple[float, float, float]:
    """RMS over the depths, mm: width, heel offset, length."""
    presses = read_presses(path)
    errors = predict(brush, presses[:, 0]) - presses[:, 1:]
    width, offset, length = np.sqrt((errors**2).mean(axis=0))
    return float(width), float(offset), float(length)


def main() -> int:
    """Run the comparison and print one line per depth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path)
    parser.add_argument("--brush", default="calibrated")
    arguments = parser.parse_args()
    try:
        presses = read_presses(arguments.table)
        sizes = predict(arguments.brush, presses[:, 0])
        errors = rms_errors(arguments.brush, arguments.table)
    except (OSError, Paint3DError) as error:
        print(f"calibrate_brush: error: {error}", file=sys.stderr)
        return 2
    print("depth    width model    heel model    length model   (mm)")
    for (depth, *measured), size in zip(presses, sizes, strict=True):
        pairs = "   ".join(f"{m:5.1f} {s:5.1f}" for m, s in zip(measured, size, strict=True))
        print(f"{depth:5.1f}    {pairs}")
    print("RMS: width {:.2f}, heel {:.2f}, length {:.2f} mm".format(*errors))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Files of parameters and measurements to be fuzzed: brushes, materials, pigments, calibrations."""

from __future__ import annotations

import dataclasses
import json
from functools import partial

import numpy as np

from scripts.fuzz.target import Target, file_of, written

__all__ = ["PARAMETERS"]


def _brush_seeds() -> list[tuple[str, bytes]]:
    from paint3d.brush.presets import load_brush

    full = {k: v for k, v in dataclasses.asdict(load_brush("full")).items() if v is not None}
    named = json.dumps({**full, "name": "mine"}, default=list).encode()
    hairs = b'base = "xiaokai"\nfriction = 0.3\nnote = "a"\n'
    hairs += b"[bristles]\nn_hairs = 40\nsplay = 0.2\n"
    return [(".json", named), (".toml", hairs), (".toml", b'base = "full"\nname = "b"\n')]


def _check_brush(suffix: str, content: bytes) -> None:
    from paint3d.brush.presets import load_presets, read_brush

    assert np.isfinite(read_brush(file_of(suffix, content), load_presets()).length_mm)


def _material_seeds() -> list[tuple[str, bytes]]:
    own = b'colour = "#e8e0d0"\nroughness = 0.8\ncoat = 0.0\nabsorbency = 0.5\ngrain = 0.3\n'
    own += b'chinese = "\xe7\xbb\xa2"\nfriction = 0.9\n'
    based = json.dumps({"base": "xuan", "pores_mm": 0.1, "source": "s", "name": "m"}).encode()
    return [(".toml", own), (".json", based)]


def _check_material(suffix: str, content: bytes) -> None:
    from paint3d.colour.materials import load_materials, read_material

    material = read_material(file_of(suffix, content), load_materials())
    assert np.isfinite(material.reflectance).all()


def _pigments_seeds() -> list[tuple[str, bytes]]:
    bands = range(400, 701, 50)
    k_and_s = ",".join(f"{letter}_{nm}" for letter in "KS" for nm in bands)
    strong = f"name,chinese,licence,{k_and_s}\na,\u58a8,MIT{',2.5' * 14}\nb,,,{'0.1,' * 13}1\n"
    masstone = "name," + ",".join(f"R_{nm}" for nm in bands) + f"\nred{',0.4' * 7}\n"
    columns = "".join(f"{nm} {nm / 1000:.3f}\n" for nm in bands)
    return [(".csv", strong.encode()), (".csv", masstone.encode()), (".txt", columns.encode())]


def _check_pigments(suffix: str, content: bytes) -> None:
    from paint3d.colour.pigments import load_pigments_csv

    assert load_pigments_csv(file_of(suffix, content))


def _presses_seeds() -> list[tuple[str, bytes]]:
    from paint3d.brush.fitting import PRESS_COLUMNS

    rows = "".join(f"{k},{2 * k},{0.1 * k},{3 * k}\n" for k in range(1, 6))
    return [(".csv", (",".join(PRESS_COLUMNS) + "\n" + rows).encode())]


def _check_presses(suffix: str, content: bytes) -> None:
    from paint3d.brush.fitting import read_presses

    assert np.isfinite(read_presses(file_of(suffix, content))).all()


def _calibration_seeds() -> list[tuple[str, bytes]]:
    from paint3d.pose.calibration import fit_calibration, save_calibration

    corners = np.array([[0.0, 0.0, 0.0], [80.0, 0.0, 0.0], [0.0, 60.0, 5.0]])
    found = fit_calibration(corners, 2.0 * corners + [1.0, 2.0, 3.0], scaled=True)
    return [written(".json", partial(save_calibration, found))]


def _check_calibration(suffix: str, content: bytes) -> None:
    from paint3d.pose.calibration import load_calibration

    found = load_calibration(file_of(suffix, content))
    assert np.isfinite(found.shift).all()


PARAMETERS: dict[str, Target] = {
    "brush": Target("brushes of one's own", _brush_seeds, _check_brush),
    "material": Target("materials of one's own", _material_seeds, _check_material),
    "pigments": Target("tables of pigments, spectra", _pigments_seeds, _check_pigments),
    "presses": Target("measured presses", _presses_seeds, _check_presses),
    "calibration": Target("calibrations of devices", _calibration_seeds, _check_calibration),
}

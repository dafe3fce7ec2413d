"""K and S of azurite, malachite and lapis lazuli as paint, by the size of their grains.

The first two are sold in grades, coarse and deep to fine and pale (tou qing to si qing, tou lu to
si lu). No spectrum of the paints could be had under clear terms; dry powders are measured (USGS),
and paler and greyer than paint, for their grains lie in air. So, in three steps:

1. what is reflected at the grains' faces, which glue takes away, is taken off: nine tenths of what
   the coarsest powder of a stone reflects where it is darkest beyond spheres that let nothing
   through. Without this step azurite is slate, for its powder is flat from 540 to 700 nm at .05;
2. spheres of the stone's mean index in air give, by Mie's theory and K = 2 C_abs / V and
   S = 3/4 (1 - g) C_sca / V (as for soot), the K/S of any absorption; the one that gives the
   powder's is the stone's;
3. spheres of the same stone, of a grade's size, in a lean binder give K and S of the paint. Such
   paint is matt, faces of its grains lie in air: the index around them is taken as 1.33.

The indices are those of the mineralogists' tables (Anthony et al., Handbook of Mineralogy V, 2003:
azurite 1.730, 1.758, 1.838; malachite 1.655, 1.875, 1.909; lazurite 1.500), here their means. Set
by eye are the index around the grains, the grades' sizes, and those of the powders of azurite, .1
mm, and lapis lazuli, .04 mm, which are not stated: so sizes have a meaning beside each other only.
The malachite is the mean (of the logarithm of the absorption) of a stone of Bisbee, below 74 um,
and of the pure compound, which is bluer: stones differ as much.

A check that nothing was fitted to: measured fractions of the stone of Bisbee (below 5 um to
1.2 mm) grow darker with size much less than spheres do, for sieved grains keep dust on them and are
fibres grown together; what the program calls so is what is washed, and does grow dark.

Usage: python scripts/grains.py FOLDER

prints colours of opaque layers of all grades, and that check.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from soot import efficiencies

from paint3d.colour.difference import lab_from_reflectance
from paint3d.colour.layers import layer_reflectance
from paint3d.colour.spectra import WAVELENGTHS

LEAN = 1.33
GREEN_NM = 550.0  # grains are much larger than a wave: one table does for all wavelengths
SPREAD = 0.5  # standard deviation of the logarithm of the diameter, by volume
ABSORBED = np.geomspace(1e-6, 3e-2, 24)
SIZES_UM = (40.0, 20.0, 10.0, 5.0)
"""Mean diameters of grades 1 to 4."""


class Stone(NamedTuple):
    """A mineral: mean index, measured powders with their sizes in um, and its coarsest powder."""

    index: float
    powders: tuple[tuple[str, float], ...]
    coarsest: str


STONES = {
    "azurite": Stone(1.775, (("Azurite_WS316_BECKa", 100.0),), "Azurite_WS316_BECKa"),
    "malachite": Stone(
        1.813,
        (("Malachite_HS254.2B_ASDFRb", 30.0), ("Malachite_GDS801_synthetic_ASDFRa", 5.0)),
        "Malachite_HS254.4B_ASDFRb",
    ),
    "lapis lazuli": Stone(
        1.500,
        (("Lazurite_GDS792_RussianPrem_ASDFRa", 40.0),),
        "Lazurite_GDS792_RussianPrem_ASDFRa",
    ),
}
FRACTIONS = (("1B", 3.0), ("2B", 30.0), ("3B", 140.0), ("4B", 600.0))


@lru_cache(maxsize=64)
def strengths(index: float, size_um: float, around: float) -> tuple[NDArray, NDArray]:
    """Compute K and S (24,) per um of solid stone, by the imaginary index `ABSORBED`."""
    at = np.linspace(-2.0, 2.0, 7)
    weights = np.exp(-0.5 * at**2) / np.exp(-0.5 * at**2).sum()
    k, s = np.zeros(len(ABSORBED)), np.zeros(len(ABSORBED))
    for diameter, part in zip(size_um * np.exp(SPREAD * at), weights, strict=True):
        for i, absorbed in enumerate(ABSORBED):
            size = np.pi * diameter * 1e3 * around / GREEN_NM
            extinct, scattered, g = efficiencies(complex(index, absorbed) / around, size)
            per_um = 1.5 * part / diameter  # section over volume
            k[i] += 2.0 * per_um * (extinct - scattered)
            s[i] += 0.75 * per_um * scattered * (1.0 - g)
    return k, s


def ratio_of(reflectance: NDArray) -> NDArray:
    """Compute K/S of an opaque layer."""
    return (1.0 - reflectance) ** 2 / (2.0 * reflectance)


def absorption(index: float, size_um: float, reflectance: NDArray) -> NDArray:
    """Find the imaginary index (31,) with which a powder in air has this reflectance."""
    k, s = strengths(index, size_um, 1.0)
    return np.exp(np.interp(np.log(ratio_of(reflectance)), np.log(k / s), np.log(ABSORBED)))


def at_faces(stone: Stone, powder: Callable[[str], NDArray]) -> float:
    """Compute the reflectance of the grains' faces in air, beyond that of opaque spheres."""
    k, s = strengths(stone.index, stone.powders[0][1], 1.0)
    black = float(layer_reflectance(k[-1], s[-1], 1e9, 0.0))
    return 0.9 * float(powder(stone.coarsest).min() - black)


def stone_absorption(stone: Stone, powder: Callable[[str], NDArray]) -> NDArray:
    """Compute a stone's imaginary index (31,): of its first powder's strength at 550 nm."""
    faces = at_faces(stone, powder)
    logs = [
        np.log(absorption(stone.index, size, (powder(name) - faces) / (1.0 - faces)))
        for name, size in stone.powders
    ]
    green = list(WAVELENGTHS).index(GREEN_NM)
    return np.exp(np.mean([log - log[green] for log in logs], axis=0) + logs[0][green])


def grade(stone: Stone, size_um: float, powder: Callable[[str], NDArray]) -> tuple:
    """Compute K and S (31,) of paint, per um of solid stone, of grains of a size."""
    absorbed = np.log(stone_absorption(stone, powder))
    k, s = (np.log(of) for of in strengths(stone.index, size_um, LEAN))
    logs = np.log(ABSORBED)
    return np.exp(np.interp(absorbed, logs, k)), np.exp(np.interp(absorbed, logs, s))


def powders(folder: Path) -> Callable[[str], NDArray]:
    """Read measured reflectances (31,) by their columns in usgs_reflectance.csv."""
    with (folder / "usgs_reflectance.csv").open(newline="", encoding="utf-8") as stream:
        rows = {float(row["wavelength_nm"]): row for row in csv.DictReader(stream)}
    return lambda name: np.array([float(rows[nm][name]) for nm in WAVELENGTHS])


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder with usgs_reflectance.csv")
    powder = powders(parser.parse_args().folder)
    for name, stone in STONES.items():
        print(f"{name}: faces of the grains in air reflect {at_faces(stone, powder):.3f}")
        for size in SIZES_UM:
            k, s = grade(stone, size, powder)
            lab = lab_from_reflectance(layer_reflectance(k, s, 1e9, 0.0))
            print(f"  grains of {size:3.0f} um: L* a* b* " + " ".join(f"{x:5.1f}" for x in lab))
    stone = STONES["malachite"]
    absorbed = absorption(stone.index, 30.0, powder("Malachite_HS254.2B_ASDFRb"))
    print("fractions of malachite in air, L*: measured, and spheres from the second")
    for fraction, size in FRACTIONS:
        measured = lab_from_reflectance(powder(f"Malachite_HS254.{fraction}_ASDFRb"))[0]
        k, s = strengths(stone.index, size, 1.0)
        ratio = np.exp(np.interp(np.log(absorbed), np.log(ABSORBED), np.log(k / s)))
        spheres = lab_from_reflectance(layer_reflectance(ratio, np.ones(31), 1e9, 0.0))[0]
        print(f"  {size:3.0f} um: {measured:4.1f} {spheres:5.1f}")


if __name__ == "__main__":
    main()

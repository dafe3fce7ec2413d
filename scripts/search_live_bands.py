"""Choose the 12 of 31 bands for live mixtures, and their weights in R, G and B.

Usage: python scripts/search_live_bands.py [--out FILE]

Random mixtures of the palette over all materials are coloured with 31 bands; the 12 bands and
their weights are those that come closest, in a linearised CIE L*a*b* with the differences of
strong colours scaled down as in CIEDE2000. Bands are swapped one by one until no swap helps;
then all is searched again with the worst colours counting more. White stays exactly white.
Prints the error on mixtures not used in the search. The output is the same bytes on every run.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.difference import delta_e, lab_from_linear_rgb
from paint3d.colour.layers import layer_reflectance
from paint3d.colour.materials import load_materials
from paint3d.colour.pigments import load_palette
from paint3d.colour.spectra import N_BANDS, WAVELENGTHS, rgb_weights

OUT = Path(__file__).parents[1] / "paint3d/colour/data/live_bands.csv"
N_LIVE = 12


def random_mixtures(count: int, seed: int) -> NDArray:
    """Reflectances (count, 31) of one to four pigments, 0.01 to 10 coats, over any material."""
    rng = np.random.default_rng(seed)
    palette, materials = list(load_palette().values()), list(load_materials().values())
    parts = np.zeros((count, len(palette)))
    for row in parts:
        chosen = rng.choice(len(palette), rng.integers(1, 5), replace=False)
        row[chosen] = rng.dirichlet(np.ones(chosen.size))
    k, s = (parts @ np.array([getattr(p, letter) for p in palette]) for letter in "KS")
    coats = 10 ** rng.uniform(-2, 1, (count, 1))
    backing = np.array([m.reflectance for m in materials])[rng.integers(len(materials), size=count)]
    return layer_reflectance(k, s, coats, backing)


def lab_slopes(rgb: NDArray) -> NDArray:
    """d Lab / d linear RGB (N, 3, 3), a and b divided by 1 + 0.045 C."""
    lab, slopes = lab_from_linear_rgb(rgb), np.empty((len(rgb), 3, 3))
    for channel in range(3):
        moved = rgb.copy()
        moved[:, channel] += 1e-6
        slopes[:, :, channel] = (lab_from_linear_rgb(moved) - lab) / 1e-6
    slopes[:, 1:] /= (1 + 0.045 * np.hypot(lab[:, 1], lab[:, 2]))[:, None, None]
    return slopes


def normal_equations(spectra: NDArray, importance: NDArray) -> tuple[NDArray, NDArray, float]:
    """Normal matrix (93, 93), right side (93,), and constant of the squared error."""
    rgb = spectra @ rgb_weights()
    slopes = lab_slopes(rgb) * np.sqrt(importance)[:, None, None]
    rows = np.einsum("nij,nw->niwj", slopes, spectra).reshape(-1, 3 * N_BANDS)
    wanted = np.einsum("nij,nj->ni", slopes, rgb).ravel()
    return rows.T @ rows, rows.T @ wanted, float(wanted @ wanted)


def solve(bands: list[int], system: tuple) -> tuple[float, NDArray]:
    """Error and weights (12, 3) of a choice of bands, with each colour's weights adding to 1."""
    matrix, right, constant = system
    index = (3 * np.array(bands)[:, None] + np.arange(3)).ravel()
    sums = np.tile(np.eye(3), len(bands))
    a, b = matrix[np.ix_(index, index)], right[index]
    scale = np.trace(a) / len(a)
    both = np.block([[a, scale * sums.T], [scale * sums, np.zeros((3, 3))]])
    x = np.linalg.solve(both, np.concatenate([b, scale * np.ones(3)]))[: len(index)]
    return constant - 2 * x @ b + x @ a @ x, x.reshape(-1, 3)


def search(system: tuple) -> list[int]:
    """Swap bands for better ones until none is found."""
    bands = np.linspace(2, 28, N_LIVE).round().astype(int).tolist()
    best = solve(bands, system)[0]
    while True:
        trials = [
            sorted([*bands[:i], w, *bands[i + 1 :]])
            for i in range(N_LIVE)
            for w in range(N_BANDS)
            if w not in bands
        ]
        costs = [solve(trial, system)[0] for trial in trials]
        if min(costs) >= best * (1 - 1e-9):
            return bands
        best, bands = min(costs), trials[int(np.argmin(costs))]


def differences(spectra: NDArray, bands: list[int], weights: NDArray) -> NDArray:
    """dE00 (N,) between 12 and 31 bands, both clipped to what a screen shows."""
    full = np.clip(spectra @ rgb_weights(), 0, 1)
    live = np.clip(spectra[:, bands] @ weights, 0, 1)
    return delta_e(lab_from_linear_rgb(live), lab_from_linear_rgb(full))


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    spectra = random_mixtures(6000, seed=1)
    importance = np.ones(len(spectra))
    for _ in range(2):
        bands = search(normal_equations(spectra, importance))
        weights = solve(bands, normal_equations(spectra, importance))[1]
        worst = differences(spectra, bands, weights)
        importance = 1.0 + 0.3 * worst / worst.mean()
    left = differences(random_mixtures(20000, seed=2), bands, weights)
    print(f"dE00 mean {left.mean():.3f}, 99 % {np.quantile(left, 0.99):.2f}, max {left.max():.2f}")
    rows = [
        f"{WAVELENGTHS[band]:.0f}," + ",".join(f"{v:.8f}" for v in row)
        for band, row in zip(bands, weights, strict=True)
    ]
    options.out.write_text("\n".join(["wavelength_nm,red,green,blue", *rows]) + "\n", "utf-8")


if __name__ == "__main__":
    main()

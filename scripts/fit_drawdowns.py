"""Fit K and S of every paint in a table of drawdowns; print how well they predict.

Usage: python scripts/fit_drawdowns.py FOLDER [--out FILE]

FOLDER holds drawdowns.csv: paints measured over a black and a white chart, with their mass
fractions. A recipe is mass and a film is volume, so masses are divided by the densities of the
paints (`OILS`) first. One fit takes all paints and wavelengths together (two-constant
Kubelka-Munk, one drawdown as one coat, Saunderson's correction, residual in cube-root reflectance,
a slight pull of log K towards the next wavelength and a stronger one of log S, which particles
change slowly with it, and a slight one of log S towards the mean of all paints, for a film that
hides tells K/S alone). A drawdown is as thick as its paint left it: the logarithm of each film's
thickness is free, with a pull to 0. Written: K, S and density of each paint, the table that
`paint3d.mixture_reflectance` uses. Printed: what is left of the fit, what it predicts, one coat
thick, for samples left out of it, and what blending RGB gives. The output is the same bytes on
every run.

The protocol of what is left out: all 34 samples are dealt to five folds in the table's order, so
that a paint's film and its tint are never left out together; each fold is fitted from scratch, and
a sample that is left out is predicted if each of its paints occurs among the rest. Told apart are
films of one paint (from its tint alone: ten times the concentration), tints (from the hiding film
alone, which does not tell how strong the paint is), and mixtures whose paints occur in other
mixtures (the ramp of bone black in zinc white). It asks for ten times the concentration, or a
tenth, of what was fitted; mixtures in use lie between the films that are measured. The pulls and
densities are therefore taken from elsewhere (docs/ink.md), not from these folds. Mixtures of other
ratios were measured by the authors too; they are kept out of this table, and figures for them
cannot be had here.
"""

from __future__ import annotations

import argparse
import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solveh_banded

from paint3d.colour.difference import delta_e, lab_from_linear_rgb, lab_from_reflectance
from paint3d.colour.layers import SAUNDERSON, layer_reflectance, to_internal, to_measured
from paint3d.colour.spectra import WAVELENGTHS, linear_rgb_from_reflectance

OUT = Path(__file__).parents[1] / "paint3d/colour/data/drawdown_paints.csv"
SOURCE = (
    "fitted on drawdowns of Geldof, Proano Gaibor, Kirchner, Ligterink, "
    "Heritage Science 6:17 (2018), repository fligt/revigo-spectra"
)
PULLS = (0.01, 0.15, 0.01)  # of log K and log S to the next wavelength, of log S to its mean
EVENNESS = 0.2  # pull of the log of a film's thickness to 0: .01 of the residual for .05 of it
BOUNDS = np.log([1e-4, 300.0])
OIL_DENSITY = 0.93  # g/cm3, of linseed oil
OILS = {
    "ZincWhite": (5.6, 0.19),
    "ZincWhiteLinseed": (5.6, 0.19),
    "LeadWhite": (6.7, 0.10),
    "BariumSulphate": (4.4, 0.12),
    "CalciumCarbonate": (2.7, 0.25),
    "BoneBlack": (2.3, 0.45),
    "ChromeYellow": (6.0, 0.18),
    "ChromeYellowOtero": (6.0, 0.18),
    "Minium": (8.9, 0.10),
    "Vermillion": (8.1, 0.15),
    "EmeraldGreen": (3.3, 0.25),
    "UltramarineBlue": (2.35, 0.30),
    "CobaltBlue": (3.9, 0.35),
    "PrussianBlue": (1.83, 0.50),
    "Eosin": (1.9, 0.45),
    "Eosin1Wax": (1.9, 0.45),
    "Eosin2PbWax": (2.5, 0.40),
    "Cochineal": (1.9, 0.45),
    "ViridianGreen": (3.3, 0.40),
}
"""Density of each pigment, g/cm3, and the share of oil in its paint by mass (oil absorption)."""
HEADER = ["name", "chinese", "source", "basis", "licence", "saunderson"]


@dataclass(frozen=True)
class Drawdowns:
    """M samples of P paints: mass fractions (M, P), charts and films (M, 2, 31) as measured."""

    paints: list[str]
    fractions: NDArray
    charts: NDArray
    films: NDArray

    @property
    def volumes(self) -> NDArray:
        """Fractions by volume (M, P), from masses and densities."""
        parts = self.fractions / [density(name) for name in self.paints]
        return parts / parts.sum(axis=1, keepdims=True)

    def without(self, samples: NDArray) -> Drawdowns:
        """Return the table without some samples."""
        keep = ~np.isin(np.arange(len(self.fractions)), samples)
        return Drawdowns(self.paints, self.fractions[keep], self.charts[keep], self.films[keep])


def density(name: str) -> float:
    """Compute the density of a paint, g/cm3, from its pigment and the oil that it takes up."""
    pigment, oil = OILS[name]
    return 1.0 / ((1.0 - oil) / pigment + oil / OIL_DENSITY)


def read_drawdowns(path: Path) -> Drawdowns:
    """Read drawdowns.csv; paints in the order in which they first appear."""
    with path.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    recipes = [json.loads(row["mass_fractions_json"]) for row in rows]
    paints = list(dict.fromkeys(name for recipe in recipes for name in recipe))
    fractions = np.array([[recipe.get(name, 0.0) for name in paints] for recipe in recipes])

    def spectra(*kinds: str) -> NDArray:
        return np.array(
            [[[float(r[f"{k}_{nm:.0f}"]) for nm in WAVELENGTHS] for k in kinds] for r in rows]
        )

    charts, films = spectra("chart_black", "chart_white"), spectra("over_black", "over_white")
    return Drawdowns(paints, fractions, charts, films)


def without_gloss(data: Drawdowns) -> Drawdowns:
    """Subtract the gloss of surfaces: .04, or nine tenths of the darkest band.

    The films were measured with their gloss: none of 34 but the ultramarines' falls below .039 at
    any wavelength, which is what a smooth surface of index 1.5 reflects.
    """

    def off(spectra: NDArray) -> NDArray:
        outer = np.minimum(0.04, 0.9 * spectra.min(axis=(1, 2), keepdims=True))
        return (spectra - outer) / (1.0 - outer)

    return Drawdowns(data.paints, data.fractions, off(data.charts), off(data.films))


def predict(
    log_ks: NDArray, data: Drawdowns, gloss: tuple[float, float], thickness: ArrayLike = 0.0
) -> NDArray:
    """Films (M, 2, 31) as measured, from log K, log S (31, 2, P), log thickness (M,) in coats."""
    k, s = np.einsum("wip,mp->imw", np.exp(log_ks), data.volumes)
    coats = np.exp(np.asarray(thickness))[..., None, None]
    backing = np.clip(to_internal(data.charts, *gloss), 0, 1)
    return to_measured(layer_reflectance(k[:, None], s[:, None], coats, backing), *gloss)


def _residual(log_ks, thickness, data, gloss) -> NDArray:
    """(31, 2 M) of cube-root reflectance, model minus measurement."""
    left = np.cbrt(predict(log_ks, data, gloss, thickness)) - np.cbrt(data.films)
    return np.moveaxis(left, 2, 0).reshape(WAVELENGTHS.size, -1)


def _slopes(log_ks, thickness, data, gloss) -> tuple[NDArray, NDArray, NDArray]:
    """Residual (31, 2 M), its slopes (31, 2 M, N) by K and S, and (31, 2 M, M) by thickness."""
    base = _residual(log_ks, thickness, data, gloss)
    n, m = log_ks[0].size, thickness.size
    by_ks, by_thickness = np.empty((*base.shape, n)), np.zeros((*base.shape, m))
    for j in range(n):
        moved = log_ks.copy()
        moved.reshape(WAVELENGTHS.size, n)[:, j] += 1e-6
        by_ks[:, :, j] = (_residual(moved, thickness, data, gloss) - base) / 1e-6
    thicker = (_residual(log_ks, thickness + 1e-6, data, gloss) - base) / 1e-6
    films = np.arange(2 * m)
    by_thickness[:, films, films // 2] = thicker
    return base, by_ks, by_thickness


def _above_mean(log_ks: NDArray) -> NDArray:
    """(31, P) log S less its mean over all paints and wavelengths."""
    return log_ks[:, 1] - log_ks[:, 1].mean()


def _cost(log_ks, thickness, data, gloss, pulls) -> float:
    bumps, apart = np.diff(log_ks, axis=0), _above_mean(log_ks)
    pulled = pulls[0] ** 2 * (bumps[:, 0] ** 2).sum() + pulls[1] ** 2 * (bumps[:, 1] ** 2).sum()
    pulled += pulls[2] ** 2 * (apart**2).sum() + EVENNESS**2 * (thickness**2).sum()
    return float((_residual(log_ks, thickness, data, gloss) ** 2).sum() + pulled)


def _step(slopes, log_ks, thickness, damping, pulls) -> tuple[NDArray, NDArray]:
    """Solve one damped Gauss-Newton step of log K, log S and thickness.

    Wavelengths are coupled by the pull and by the films' thickness, which is eliminated (Schur).
    """
    base, by_ks, by_thickness = slopes
    hessian = np.einsum("wri,wrj->wij", by_ks, by_ks)
    gradient = np.einsum("wri,wr->wi", by_ks, base)
    n_waves, n = gradient.shape
    pull, to_mean = np.repeat(np.square(pulls[:2]), n // 2), pulls[2] ** 2
    scattering = slice(n // 2, n)
    hessian[:, range(n // 2, n), range(n // 2, n)] += to_mean
    gradient[:, scattering] += to_mean * _above_mean(log_ks)
    flat = log_ks.reshape(n_waves, n)
    ends = np.ones(n_waves)
    ends[1:-1] = 2.0
    pulled = ends[:, None] * flat
    pulled[1:] -= flat[:-1]
    pulled[:-1] -= flat[1:]
    band = np.zeros((n + 1, n_waves * n))
    for d in range(n):
        diagonal = np.zeros((n_waves, n))
        diagonal[:, : n - d] = np.diagonal(hessian, offset=-d, axis1=1, axis2=2)
        band[d] = diagonal.ravel()
    band[0] += np.outer(ends, pull).ravel() + damping
    band[n, : (n_waves - 1) * n] = -np.tile(pull, n_waves - 1)
    across = np.einsum("wri,wrm->wim", by_ks, by_thickness).reshape(n_waves * n, -1)
    right = np.column_stack([(gradient + pull * pulled).ravel(), across])
    solved = solveh_banded(band, right, lower=True)
    own = np.einsum("wri,wrj->ij", by_thickness, by_thickness)
    own += (EVENNESS**2 + damping) * np.eye(thickness.size)
    wanted = np.einsum("wrm,wr->m", by_thickness, base) + EVENNESS**2 * thickness
    thicker = -np.linalg.solve(own - across.T @ solved[:, 1:], wanted - across.T @ solved[:, 0])
    return -(solved[:, 0] + solved[:, 1:] @ thicker).reshape(log_ks.shape), thicker


def fit(
    data: Drawdowns,
    gloss: tuple[float, float],
    pulls: tuple[float, float, float] = PULLS,
) -> tuple[NDArray, NDArray]:
    """Least-squares log K and log S (31, 2, P), and log thickness (M,); Levenberg-Marquardt.

    `pulls` are the weights of log K and of log S to the next wavelength, and of log S to its mean.
    """
    log_ks = np.zeros((WAVELENGTHS.size, 2, len(data.paints)))
    thickness = np.zeros(len(data.fractions))
    damping, cost = 1e-3, _cost(log_ks, thickness, data, gloss, pulls)
    for _ in range(60):
        slopes = _slopes(log_ks, thickness, data, gloss)
        while damping < 1e6:
            step, thicker = _step(slopes, log_ks, thickness, damping, pulls)
            trial = np.clip(log_ks + np.clip(step, -1.5, 1.5), *BOUNDS)
            thick = thickness + np.clip(thicker, -0.5, 0.5)
            trial_cost = _cost(trial, thick, data, gloss, pulls)
            if trial_cost < cost:
                break
            damping *= 4.0
        gain = cost - trial_cost
        if gain <= 0:
            break
        log_ks, thickness, cost, damping = trial, thick, trial_cost, max(damping / 4.0, 1e-9)
        if gain < 1e-6 * cost:
            break
    return log_ks, thickness


def differences(log_ks, data: Drawdowns, gloss) -> NDArray:
    """dE00 (M, 2) of the films over black and white."""
    model = predict(log_ks, data, gloss)
    return delta_e(lab_from_reflectance(model), lab_from_reflectance(data.films))


def rgb_differences(log_ks, data: Drawdowns, gloss) -> NDArray:
    """dE00 (M, 2) when the linear RGB of the pure films is blended by mass instead."""
    mixed = []
    for sample, fractions in enumerate(data.fractions):
        pure = Drawdowns(
            data.paints,
            np.eye(len(data.paints)),
            np.repeat(data.charts[sample : sample + 1], len(data.paints), axis=0),
            data.films,
        )
        mixed.append(
            np.tensordot(fractions, linear_rgb_from_reflectance(predict(log_ks, pure, gloss)), 1)
        )
    return delta_e(lab_from_linear_rgb(np.array(mixed)), lab_from_reflectance(data.films))


def left_out_differences(data: Drawdowns, gloss, folds: int) -> tuple[NDArray, NDArray]:
    """Samples left out of the fit (K-fold, each fit from scratch): which, and dE00 (L, 2).

    Samples are dealt to the folds in the table's order. One whose paint occurs nowhere else among
    what is left cannot be predicted, and is not counted.
    """
    which, apart_of = [], []
    for fold in range(folds):
        out = np.arange(fold, len(data.fractions), folds)
        rest = data.without(out)
        apart = differences(fit(rest, gloss)[0], data, gloss)
        for sample in out:
            if (rest.fractions[:, data.fractions[sample] > 0].sum(axis=0) > 0).all():
                which.append(sample)
                apart_of.append(apart[sample])
    return np.array(which), np.array(apart_of)


def _paints_recur(data: Drawdowns, sample: int) -> bool:
    """Return whether every paint of a mixture occurs in another mixture too."""
    mixtures = data.fractions[(data.fractions > 0).sum(axis=1) > 1] > 0
    return bool((mixtures.sum(axis=0)[data.fractions[sample] > 0] > 1).all())


def write_paints(path: Path, data: Drawdowns, log_ks: NDArray) -> None:
    """Write K and S per coat in the layout that `paint3d.colour.pigments` reads."""
    bands = [f"{letter}_{nm:.0f}" for letter in "KS" for nm in WAVELENGTHS]
    pure = data.fractions[(data.fractions > 0).sum(axis=1) == 1].sum(axis=0) > 0
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([*HEADER, "density", *bands])
        for i, name in enumerate(data.paints):
            basis = "measured K,S" if pure[i] else "measured K,S (from mixtures only)"
            values = [f"{value:.5g}" for value in np.exp(log_ks[:, :, i].T).ravel()]
            weighed = f"{density(name):.2f}"
            writer.writerow([name, "", SOURCE, basis, "CC0-1.0", "yes", weighed, *values])


def _line(label: str, values: NDArray) -> str:
    return (
        f"{label:<44} mean {values.mean():5.2f}  median {np.median(values):5.2f}  "
        f"max {values.max():5.2f}  (n = {values.size})"
    )


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder with drawdowns.csv")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    data = read_drawdowns(options.folder / "drawdowns.csv")
    log_ks, thickness = fit(data, SAUNDERSON)
    mixtures = (data.fractions > 0).sum(axis=1) > 1
    low, high = np.exp(thickness).min(), np.exp(thickness).max()
    print(f"films are {low:.2f} to {high:.2f} coats thick")
    print("dE00 against the measured films, each of one coat")
    print(_line("fit, all samples", differences(log_ks, data, SAUNDERSON)))
    print(_line("fit, mixtures", differences(log_ks, data, SAUNDERSON)[mixtures]))
    rgb = rgb_differences(log_ks, data, SAUNDERSON)
    which, apart = left_out_differences(data, SAUNDERSON, folds=5)
    print(_line("left out (5-fold), all that can be predicted", apart))
    shared = np.array([_paints_recur(data, sample) for sample in which]) & mixtures[which]
    kinds = {
        "films of one paint": ~mixtures[which],
        "tints": mixtures[which] & ~shared,
        "paints in other mixtures": shared,
    }
    for name, chosen in kinds.items():
        print(_line(f"    {name}", apart[chosen]))
    print(_line("    RGB blending of the mixtures", rgb[which[mixtures[which]]]))
    write_paints(options.out, data, log_ks)


if __name__ == "__main__":
    main()

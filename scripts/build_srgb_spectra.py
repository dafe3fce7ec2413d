"""Build the three spectra that any sRGB colour is a sum of, to paint over coloured meshes.

Usage: python scripts/build_srgb_spectra.py [--out FILE]

A mesh file gives colours, Kubelka-Munk theory needs a spectrum. Mallett, Yuksel: *Spectral
Primary Decomposition for Rendering with sRGB Reflectance*, EGSR 2019, take red, green and blue
spectra that lie in [0, 1], add up to 1, give exactly their primaries under D65, and are otherwise
as smooth as can be (least sum of squared differences of neighbours). With linear red, green and
blue as weights any colour of the gamut is then the reflectance of something that could exist,
and comes back exactly. Ours are solved anew for 400 to 700 nm by 10 nm. The output is the same
bytes on every run.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import N_BANDS, WAVELENGTHS, rgb_weights

OUT = Path(__file__).parents[1] / "paint3d/colour/data/srgb_spectra.csv"


def smoothest_spectra() -> NDArray:
    """(31, 3) red, green, blue: the quadratic programme by an active-set method.

    All three are unknowns, channel by channel; values that leave [0, 1] are held at the border,
    and let go where the cost would fall, until neither happens.
    """
    n = 3 * N_BANDS
    steps = np.diff(np.eye(N_BANDS), axis=0)
    hessian = np.kron(np.eye(3), steps.T @ steps)
    colour = np.kron(np.eye(3), rgb_weights().T)
    whole = np.kron(np.ones(3), np.eye(N_BANDS))
    equations = np.vstack([colour[:6], whole])  # the third channel's follow from the sum
    values = np.concatenate([np.eye(3)[:2].ravel(), np.ones(N_BANDS)])
    low = np.zeros(n, bool)  # at most 1 follows from at least 0 and the sum
    for _ in range(200):
        rows = np.vstack([equations, np.eye(n)[low]])
        right = np.concatenate([values, np.zeros(low.sum())])
        zero = np.zeros((len(rows), len(rows)))
        kkt = np.block([[hessian, rows.T], [rows, zero]])
        solved = np.linalg.lstsq(kkt, np.concatenate([np.zeros(n), right]), rcond=1e-13)[0]
        x, push = solved[:n], -solved[n + len(equations) :]
        wrong = x < -1e-12
        free = np.flatnonzero(low)[push < -1e-10]
        if not wrong.any() and not free.size:
            return np.maximum(x, 0.0).reshape(3, N_BANDS).T
        low |= wrong
        low[free] = False
    raise RuntimeError("the active set did not settle")


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    rows = [
        f"{nm:.0f}," + ",".join(f"{value:.12f}" for value in row)
        for nm, row in zip(WAVELENGTHS, smoothest_spectra(), strict=True)
    ]
    options.out.write_text("\n".join(["wavelength_nm,red,green,blue", *rows]) + "\n", "utf-8")


if __name__ == "__main__":
    main()

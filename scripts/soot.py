"""K and S of soot in glue, by its particles' size: what the inks of the palette are computed from.

No measured reflectance of sumi or lamp black over thickness could be had under clear terms, so it
is computed, in three steps:

1. the complex index of soot that was collected from a propane flame and pressed (Dalzell, Sarofim:
   Optical constants of soot and their application to heat-flux calculations, J. Heat Transfer 91,
   100, 1969). With that of soot in the flame (Chang, Charalampopoulos, Proc. R. Soc. Lond. A 430,
   577, 1990) washes are browner, by 7 in b* at most for oil soot and by 1 for pine soot;
2. absorption and scattering of spheres of it in dried glue of index 1.53 (Bohren, Huffman:
   Absorption and Scattering of Light by Small Particles, 1983, chapter 4), and from these
   K = 2 C_abs / V and S = 3/4 (1 - g) C_sca / V (Mudgett, Richards, Appl. Opt. 10, 1485, 1971);
3. films of it under a smooth surface that throws half of the light from inside back (Saunderson
   1942, k2 = 0.5), and K and S without that correction, band by band: those of the same opaque
   layer, that come closest to the films over paper, glaze and black. The palette's paints give the
   measured reflectance themselves. What is thrown back outside, the gloss, is left out, for
   pictures are lit with it.

Makers give the particles of oil soot as 15 to 80 nm and those of pine soot as 20 to 400 nm
(Boku-undo): taken here as two standard deviations of the logarithm of the diameter to either side.

Usage: python scripts/soot.py

prints lightness and cast over thickness, and the third step's error.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from paint3d.colour.difference import delta_e, lab_from_reflectance
from paint3d.colour.layers import layer_reflectance, to_internal, to_measured
from paint3d.colour.materials import load_material
from paint3d.colour.spectra import WAVELENGTHS

GLUE = 1.53
INSIDE = 0.5
GREEN = 15  # the band of 550 nm
COATS = np.array([0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0, 4.0])
GROUNDS = (("xuan", 1.0), ("porcelain", 1.0), ("", 0.3))  # material, weight; "": black


class Soot(NamedTuple):
    """A soot: the diameters (nm) between which most of its particles are, by number."""

    least_nm: float
    most_nm: float

    def by_volume(self) -> tuple[NDArray, NDArray]:
        """Compute diameters (25,), nm, and the fraction of the volume that each stands for."""
        spread = 0.25 * np.log(self.most_nm / self.least_nm)
        median = np.sqrt(self.least_nm * self.most_nm) * np.exp(3.0 * spread**2)
        at = np.linspace(-3.0, 3.0, 25)
        weight = np.exp(-0.5 * at**2)
        return median * np.exp(spread * at), weight / weight.sum()


SOOTS = {"pine soot": Soot(20.0, 400.0), "oil soot": Soot(15.0, 80.0)}
STRENGTH = 4.8
"""Absorption of a coat at 550 nm, before the third step: such that what a brush that runs dry
still touches is as black, beside its gaps, as in scans of dry strokes (docs/model.md, flying
white). It is 1.2 percent of soot by volume in 0.03 mm of liquid."""


def index_of(nm: float) -> complex:
    """Interpolate the complex index of soot at a wavelength; constant below 436 nm."""
    at = (435.8, 450.0, 550.0, 650.0, 806.5)
    real = np.interp(nm, at, (1.57, 1.56, 1.57, 1.56, 1.57))
    return complex(real, np.interp(nm, at, (0.46, 0.50, 0.53, 0.52, 0.49)))


def efficiencies(relative: complex, size: float) -> tuple[float, float, float]:
    """Compute a sphere's efficiencies of extinction and scattering, and its asymmetry g.

    `relative` is its index over the medium's, `size` its circumference over the wavelength there.
    """
    n = int(np.ceil(size + 4.0 * size ** (1.0 / 3.0) + 2.0)) + 2
    inside = relative * size
    log_derivative = np.zeros(int(max(n, abs(inside))) + 17, complex)
    for k in range(len(log_derivative) - 1, 0, -1):
        log_derivative[k - 1] = k / inside - 1.0 / (log_derivative[k] + k / inside)
    last, psi, last_chi, chi = np.cos(size), np.sin(size), -np.sin(size), np.cos(size)
    a, b = np.zeros(n, complex), np.zeros(n, complex)
    for k in range(1, n + 1):
        last, psi = psi, (2 * k - 1) * psi / size - last
        last_chi, chi = chi, (2 * k - 1) * chi / size - last_chi
        xi, last_xi = psi - 1j * chi, last - 1j * last_chi
        for terms, ratio in ((a, 1.0 / relative), (b, relative)):
            u = log_derivative[k] * ratio + k / size
            terms[k - 1] = (u * psi - last) / (u * xi - last_xi)
    k = np.arange(1, n + 1)
    extinction = 2.0 / size**2 * np.sum((2 * k + 1) * (a + b).real)
    scattering = 2.0 / size**2 * np.sum((2 * k + 1) * (abs(a) ** 2 + abs(b) ** 2))
    ahead = np.sum((2 * k + 1) / (k * (k + 1)) * (a * b.conj()).real)
    k = k[:-1]
    neighbours = (a[:-1] * a[1:].conj() + b[:-1] * b[1:].conj()).real
    ahead += np.sum(k * (k + 2) / (k + 1) * neighbours)
    return extinction, scattering, 4.0 / size**2 * ahead / scattering


def strengths_per_um(soot: Soot, glue: float = GLUE) -> tuple[NDArray, NDArray]:
    """Compute K and S (31,) of solid soot in glue, 1/um, before the third step."""
    diameters, weights = soot.by_volume()
    k, s = np.zeros(len(WAVELENGTHS)), np.zeros(len(WAVELENGTHS))
    for i, nm in enumerate(np.asarray(WAVELENGTHS)):
        relative = index_of(nm) / glue
        for diameter, part in zip(diameters, weights, strict=True):
            extinct, scattered, g = efficiencies(relative, np.pi * diameter * glue / nm)
            per_um = 1.5e3 * part / diameter  # section over volume
            k[i] += 2.0 * per_um * (extinct - scattered)
            s[i] += 0.75 * per_um * scattered * (1.0 - g)
    return k, s


def films(k: NDArray, s: NDArray, ground: NDArray) -> NDArray:
    """Compute the reflectance (COATS, 31) over a measured ground, without the gloss."""
    below = to_internal(ground, 0.0, INSIDE)
    return to_measured(layer_reflectance(k, s, COATS[:, None], below), 0.0, INSIDE)


def grounds() -> list[NDArray]:
    """Return the reflectances of the grounds that the third step is fitted over."""
    return [load_material(name).reflectance if name else np.zeros(31) for name, _ in GROUNDS]


def as_seen(k: NDArray, s: NDArray) -> tuple[NDArray, NDArray]:
    """Fit the K and S (31,) that give the films' reflectance without a correction.

    Exactly that of an opaque one, which fixes K/S, and nearly that of the others.
    """
    wanted = np.array([films(k, s, ground) for ground in grounds()])
    opaque = to_measured(layer_reflectance(k, s, 1e3, 0.0), 0.0, INSIDE)
    scattered = 2.0 * opaque / (1.0 - opaque) ** 2  # S/K
    weights = np.array([weight for _, weight in GROUNDS])[:, None]
    seen = np.empty(len(k))
    for band in range(len(k)):
        below = np.array([ground[band] for ground in grounds()])[:, None]

        def apart(log_k: NDArray, band: int = band, below: NDArray = below) -> NDArray:
            strength = np.exp(log_k[0])
            got = layer_reflectance(strength, strength * scattered[band], COATS, below)
            return np.ravel(weights * (np.cbrt(got) - np.cbrt(wanted[:, :, band])))

        start = [np.log(1.4 * k[band])]
        seen[band] = np.exp(least_squares(apart, start, xtol=1e-12, ftol=1e-12).x[0])
    return seen, seen * scattered


def soot_ink(name: str) -> tuple[NDArray, NDArray]:
    """Compute K and S (31,) of a coat of an ink of `SOOTS`, as the palette holds them."""
    k, s = strengths_per_um(SOOTS[name])
    scale = STRENGTH / k[GREEN]
    return as_seen(k * scale, s * scale)


def main() -> None:
    """Run as the module's first lines say."""
    for name, soot in SOOTS.items():
        k, s = strengths_per_um(soot)
        scale = STRENGTH / k[GREEN]
        print(f"{name}: K {k[GREEN]:.1f}, S {s[GREEN]:.2f} per um of soot at 550 nm")
        seen = as_seen(k * scale, s * scale)
        for ground in ("xuan", "porcelain"):
            below = load_material(ground).reflectance
            wanted = lab_from_reflectance(films(k * scale, s * scale, below))
            got = lab_from_reflectance(layer_reflectance(*seen, COATS[:, None], below))
            print(f"  {ground}: coats, L* a* b*, dE00 of the third step")
            for coats, lab, error in zip(COATS, got, delta_e(got, wanted), strict=True):
                print(f"    {coats:5.2f}  {lab[0]:5.1f} {lab[1]:5.1f} {lab[2]:5.1f}  {error:4.1f}")


if __name__ == "__main__":
    main()

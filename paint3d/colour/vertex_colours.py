"""Colours of a painted surface's vertices: from amounts of pigment to sRGB, fast.

`ColourModel` has two paths, and two methods for the live one:

- `reference`: all 31 bands, any mixture;
- `live`, several pigments: 12 bands chosen for the palette (`scripts/searchlive_bands.py`),
  twice as fast, within mean 0.09 and maximum 0.5 dE00 of the reference on random mixtures;
  mixtures with any other pigment, where these bands could be wrong by 4 dE00, take all 31;
- `live`, one pigment: a table over the layer's thickness, three times as fast, within 0.001 dE00.

Where several pigments are known and one of them is glossy, each vertex has the gloss of what lies
there: that is `GlazeModel`'s work, with all bands on both paths.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.colour.glazing import GlazeModel, make_ground
from paint3d.colour.kernels.kubelka_munk import (
    Film,
    OneInk,
    Shown,
    Wet,
    mixture_colours,
    single_colours,
)
from paint3d.colour.layers import SAUNDERSON, layer_reflectance, to_internal, to_measured
from paint3d.colour.pigments import Pigment, load_palette
from paint3d.colour.spectra import (
    N_BANDS,
    WAVELENGTHS,
    linear_rgb_from_reflectance,
    rgb_weights,
    srgb_codes,
    srgb_from_linear,
)
from paint3d.core.arrays import AnyArray, as_array
from paint3d.core.polyline import interpolate
from paint3d.errors import InputError

__all__ = ["ColourModel", "live_bands"]

_LIVE = Path(__file__).parent / "data" / "live_bands.csv"
_N_THICKNESSES, _N_SHADES = 2048, 1 << 15
_NO_RGB = np.empty((0, 3), np.float32)


@lru_cache(maxsize=1)
def live_bands() -> tuple[AnyArray, AnyArray]:
    """Return indices (12,) of the live bands among the 31, and their weights (12, 3)."""
    table = np.loadtxt(_LIVE, delimiter=",", skiprows=1)
    return np.searchsorted(WAVELENGTHS, table[:, 0]), table[:, 1:]


class ColourModel:
    """Colours of vertices that carry some of P pigments on one backing.

    Paint on a vertex covers a fraction c of its area, in one wet mixture; the colour is the mean
    by area, (1 - c) bare + c layer, in linear RGB (docs/model.md, equation (17);
    Guo 2017, section 4.3).

    Parameters
    ----------
    pigments : sequence of Pigment
        At least one; the columns of the amounts. A film has as much of Saunderson's correction
        as it holds of paint that was fitted with it, and takes the backing as seen through that.
    backing : (31,) array_like
        Reflectance of the bare surface as measured, in [0, 1].
    path : {"live", "reference"}

    Attributes
    ----------
    bare_linear_rgb : (3,) float32
        The bare surface.

    Raises
    ------
    InputError
        If there is no pigment, the backing is out of range or the path is unknown.

    Notes
    -----
    The kernels work in float32, with tanh to 1.2e-5: 0.01 dE00 against doubles. Colours do not
    depend on the order of the vertices or the number of threads, to the bit. Million vertices a
    CPU second with 8 lanes: one pigment live 65, three live 36, three with 31 bands 20.
    """

    def __init__(
        self,
        pigments: Sequence[Pigment],
        backing: ArrayLike,
        path: Literal["live", "reference"] = "live",
    ) -> None:
        if path not in ("live", "reference"):
            raise InputError("colour path is {file!r}; expected live or reference", file=path)
        if not pigments:
            raise InputError("a colour model needs at least one pigment")
        ground = as_array(backing, "backing", (N_BANDS,))
        if ground.min() < 0 or ground.max() > 1:
            raise InputError(
                "backing is {least:g} to {most:g}; expected 0 to 1",
                least=ground.min(),
                most=ground.max(),
            )
        self.pigments = tuple(pigments)
        self.path = path
        self._ground = ground
        self.bare_linear_rgb = linear_rgb_from_reflectance(ground).astype(np.float32)
        self._look: Film | OneInk | GlazeModel
        if path == "live" and len(pigments) == 1:
            self._look = self._table()
        elif any(p.saunderson for p in pigments):
            self._look = GlazeModel(pigments)
        elif path == "live" and all(load_palette().get(p.name) is p for p in pigments):
            self._look = self._film(*live_bands())
        else:
            self._look = self._film(np.arange(N_BANDS), rgb_weights())

    def _film(self, bands: AnyArray, weights: AnyArray) -> Film:
        """Constants of the mixture kernel for some of the 31 bands and their weights (N, 3)."""
        paints = [(p.K[bands], p.S[bands]) for p in self.pigments]
        return Film(
            np.ascontiguousarray(np.transpose(paints, (2, 0, 1)), dtype=np.float32),
            np.column_stack([self._ground[bands], weights]).astype(np.float32),
            self.bare_linear_rgb[None],
        )

    def _table(self) -> OneInk:
        """Tabulate the colour of one pigment over y = coats / (bend + coats) in [0, 1]."""
        pigment = self.pigments[0]
        strength = float((pigment.K + pigment.S).max())
        bend = np.float32(2.0 / max(strength, 1e-3))
        y = np.linspace(0.0, 1.0, _N_THICKNESSES)
        coats = bend * y / np.maximum(1.0 - y, 1e-7)
        gloss = SAUNDERSON if pigment.saunderson else (0.0, 0.0)
        below = np.maximum(to_internal(self._ground, *gloss), 0.0)
        films = layer_reflectance(pigment.K, pigment.S, coats[:, None], below)
        rgb = linear_rgb_from_reflectance(to_measured(films, *gloss))
        fine = np.linspace(0.0, 1.0, _N_SHADES)
        shades = srgb_from_linear(np.clip(interpolate(fine, y, rgb), 0.0, 1.0))
        return OneInk(rgb.astype(np.float32), shades, bend, self.bare_linear_rgb[None])

    @property
    def single(self) -> OneInk:
        """The table of one pigment alone, on the live path."""
        assert isinstance(self._look, OneInk), "there are several, or it is the reference"
        return self._look

    def srgb(
        self,
        amounts: NDArray[np.float32],
        coverage: NDArray[np.float32],
        out: NDArray[np.uint8],
        vertex_ids: NDArray[np.int32] | None = None,
        linear_rgb: NDArray[np.float32] | None = None,
    ) -> NDArray[np.uint8]:
        """Fill the colours of some vertices, or of all.

        Parameters
        ----------
        amounts : (V, P) float32
            Coats times the covered fraction, >= 0.
        coverage : (V,) float32
            Covered fraction in [0, 1]; a vertex at 0 is bare, whatever its amounts.
        out : (V, 3) uint8
            sRGB; only the rows of `vertex_ids` are written.
        vertex_ids : (N,) int32, optional
        linear_rgb : (V, 3) float32, optional
            Filled likewise, before colours out of gamut are clipped.

        Returns
        -------
        ndarray
            `out`.

        Raises
        ------
        InputError
            If an array has the wrong type or shape, or an id is not a vertex. The values of
            amounts and coverage are the surface's own and are not checked here.
        """
        ids = np.arange(coverage.size, dtype=np.int32) if vertex_ids is None else vertex_ids
        n, count = coverage.size, len(self.pigments)
        _check(amounts, "amounts", (n, count), np.float32)
        _check(coverage, "coverage", (n,), np.float32)
        _check(out, "out", (n, 3), np.uint8)
        _check(ids, "vertex_ids", (ids.size,), np.int32)
        if linear_rgb is not None:
            _check(linear_rgb, "linear_rgb", (n, 3), np.float32)
        if ids.size and ids.view(np.uint32).max() >= n:  # one below 0 is a large one
            raise InputError(
                "vertex_ids are {least} to {most}; expected 0 to {last}",
                least=ids.min(),
                most=ids.max(),
                last=n - 1,
            )
        rgb = _NO_RGB if linear_rgb is None else linear_rgb
        wet, shown = Wet(ids, amounts, coverage), Shown(srgb_codes(), rgb, out)
        if isinstance(self._look, OneInk):
            single_colours(wet, self._look, shown)
        elif isinstance(self._look, GlazeModel):
            below = make_ground(self._ground)
            self._look.srgb(amounts, coverage, below, out, ids, linear_rgb)
        else:
            mixture_colours(wet, self._look, shown)
        return out


def _check(array: AnyArray, name: str, shape: tuple[int, ...], dtype: type) -> None:
    if array.dtype != dtype or array.shape != shape or not array.flags.c_contiguous:
        raise InputError(
            "{name} is {array_dtype} {array_shape}; expected {dtype} {shape}, contiguous",
            name=name,
            array_dtype=array.dtype,
            array_shape=array.shape,
            dtype=np.dtype(dtype),
            shape=shape,
        )

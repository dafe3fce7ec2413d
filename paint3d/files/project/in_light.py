"""A painting as it looks in another light, by another observer, or on a wider screen."""

from __future__ import annotations

import logging
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.glazing import srgb_primaries
from paint3d.colour.spectra import decode_srgb
from paint3d.colour.viewing import GAMUTS, Codes, Viewing
from paint3d.colour.wet_look import WetLook
from paint3d.core.arrays import AnyArray
from paint3d.files.progress import Progress

__all__ = ["InLight", "look_of", "tell_clipped"]

log = logging.getLogger("paint3d")
_OWN_LIGHT = Viewing()


class InLight:
    """What can be exported, with the colours that it has when it is looked at so.

    Parameters
    ----------
    surface : Exportable
        A `PaintedSurface`, whose spectra are known, or a mesh, whose colours get the smooth
        spectra that have them under D65.
    viewing : Viewing
    """

    def __init__(self, surface: Any, viewing: Viewing) -> None:
        self._surface, self._viewing = surface, viewing
        self.material = surface.material

    @cached_property
    def seen(self) -> Codes:
        """Codes of every vertex, and how many are out of gamut."""
        return codes_in_light(self._surface, self._viewing)

    @property
    def srgb(self) -> NDArray[np.uint8]:
        """(V, 3) codes, of the gamut."""
        return self.seen.rgb

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(V,) mm2."""
        areas: NDArray[np.float64] = self._surface.vertex_areas
        return areas

    @property
    def wet_look(self) -> WetLook | None:
        """The surface's own."""
        return look_of(self._surface, None)

    def look_on(self, roughness: float) -> WetLook | None:
        """The surface's own."""
        return look_of(self._surface, roughness)

    @property
    def paint_mesh(self) -> Any:
        """The surface's own, of one that has a wet look."""
        return self._surface.paint_mesh

    def export_ids(
        self, tolerance: float | None, srgb: NDArray[np.uint8], progress: Progress | None = None
    ) -> tuple[AnyArray, AnyArray]:
        """The surface's own, of one that has a wet look."""
        found: tuple[AnyArray, AnyArray] = self._surface.export_ids(tolerance, srgb, progress)
        return found

    def export_arrays(
        self,
        tolerance: float | None = 1.0,
        srgb: NDArray[np.uint8] | None = None,
        progress: Progress | None = None,
    ) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
        """As the surface's own, with these colours."""
        codes = self.srgb if srgb is None else srgb
        arrays: tuple[AnyArray, AnyArray, AnyArray, AnyArray]
        told = {} if progress is None else {"progress": progress}
        arrays = self._surface.export_arrays(tolerance, codes, **told)
        return arrays

    def detail_arrays(self) -> tuple[AnyArray, ...]:
        """As the surface's own, with these colours."""
        return *self._surface.detail_arrays()[:-1], self.srgb


def look_of(surface: Any, roughness: float | None) -> WetLook | None:
    """How wet what can be exported looks, on its own material or one so rough; None: as that."""
    found: WetLook | None
    if roughness is None:
        found = getattr(surface, "wet_look", None)
    else:
        found = getattr(surface, "look_on", lambda _: None)(roughness)
    return found


def codes_in_light(surface: Any, viewing: Viewing) -> Codes:
    """Codes (V, 3) of a surface's vertices; see `InLight`."""
    spectra = getattr(surface, "spectra", None)
    if spectra is not None:
        return viewing.codes_of(len(surface.srgb), spectra)
    codes = surface.srgb
    if viewing.is_plain:
        return Codes(codes, 0)
    primaries = srgb_primaries().T
    return viewing.codes_of(len(codes), lambda ids: decode_srgb(codes[ids]) @ primaries)


def tell_clipped(surface: Any, viewing: Viewing | None) -> int:
    """Warn of colours that a gamut does not hold, where there are any; return how many."""
    if isinstance(surface, InLight):
        n_clipped, n = surface.seen.n_clipped, len(surface.srgb)
    elif hasattr(surface, "spectra"):
        ids = np.flatnonzero(surface.painted).astype(np.int32)
        if not may_leave_srgb(surface.pigments):
            return 0
        found = _OWN_LIGHT.codes_of(len(ids), lambda some: surface.spectra(ids[some]))
        n_clipped, n = found.n_clipped, surface.n_vertices
    else:
        return 0
    if n_clipped:
        gamut = GAMUTS[viewing.gamut if viewing is not None else "srgb"].title
        wider = " (--gamut p3 or rec2020 keeps more)" if gamut == "sRGB" else ""
        log.warning(
            "%s of %s vertices have colours outside %s and are shown in the nearest that it has%s",
            f"{n_clipped:,}", f"{n:,}", gamut, wider,
        )  # fmt: skip
    return n_clipped


def may_leave_srgb(pigments: Any) -> bool:
    """Whether any pigment is there that has a colour: black and water leave no gamut."""
    return any(np.ptp(p.K) > 0.0 or np.ptp(p.S) > 0.0 for p in pigments)

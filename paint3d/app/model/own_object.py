"""Import of an object of one's own: its up, its unit, its material."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import Material
from paint3d.files.load import UNITS_MM
from paint3d.files.reading import Reading
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import Upright, turn_mesh, turn_up

__all__ = [
    "ObjectChoice",
    "first_choice",
    "is_implausible",
    "likely_unit",
    "longest_side",
    "sensible_resolution",
]

_SMALL_MM, _LARGE_MM = 5.0, 3000.0  # outside these an object is hardly one to paint by hand
_LIKELY_MM = 150.0
_MOST_CELLS = 250_000  # into which a surface is cut: more take seconds before the first stroke
_EDGES_A_CELL = 5.0
_STEPS_A_MM = 20.0  # of a resolution that is proposed


class ObjectChoice(NamedTuple):
    """The choices made for an object.

    Attributes
    ----------
    turn : (3, 3) float64
        Rotation.
    scale : float
        Factor on every length.
    material : str or Material
        Of the surface.
    resolution : float
        mm.
    coloured : bool
        Whether it keeps the colours that it came with.
    """

    turn: NDArray[np.float64]
    scale: float
    material: str | Material
    resolution: float
    coloured: bool = True

    def apply(self, mesh: TriangleMesh) -> TriangleMesh:
        """Return the mesh as it was chosen to stand."""
        turned = turn_mesh(mesh, self.turn, self.scale)
        if self.coloured or turned.colours is None:
            return turned
        return TriangleMesh(turned.vertices, turned.faces, None, turned.name, turned.normals)


def longest_side(mesh: TriangleMesh) -> float:
    """Longest side of the box around a mesh, mm."""
    return float(np.ptp(mesh.bounds, axis=0).max())


def is_implausible(size_mm: float) -> bool:
    """Return whether an object so long was probably measured in another unit."""
    return not _SMALL_MM <= size_mm <= _LARGE_MM


def likely_unit(size: float) -> str:
    """The unit in which an object so long in its file's units is likeliest to be measured."""
    lengths = {unit: size * mm for unit, mm in UNITS_MM.items()}
    return min(lengths, key=lambda unit: abs(math.log(max(lengths[unit], 1e-300) / _LIKELY_MM)))


def sensible_resolution(area_mm2: float, wanted: float) -> float:
    """Finest resolution, mm, at which a surface is ready in a moment; not below wanted."""
    least = math.sqrt(area_mm2 / _MOST_CELLS) / _EDGES_A_CELL
    return wanted if least <= wanted else math.ceil(_STEPS_A_MM * least) / _STEPS_A_MM


def first_choice(
    reading: Reading, guess: Upright | None, material: str | Material, resolution: float
) -> ObjectChoice:
    """Propose a choice: the known or guessed up, the likeliest unit, a sensible resolution.

    Parameters
    ----------
    reading : Reading
    guess : Upright or None
        None where it is known which way is up.
    material : str or Material
    resolution : float
        mm; what is wanted.
    """
    size, scale = longest_side(reading.mesh), 1.0
    if is_implausible(size):
        scale = UNITS_MM[likely_unit(size / reading.unit_mm)] / reading.unit_mm
    turn = np.eye(3) if guess is None or not guess.sure else turn_up(guess.up)
    resolution = sensible_resolution(reading.mesh.area * scale * scale, resolution)
    return ObjectChoice(turn, scale, material, resolution)

"""What the hairs of a tuft are: how many, how thick, how they hold together."""

from __future__ import annotations

import dataclasses

from paint3d.core.arrays import as_number
from paint3d.errors import BrushError

__all__ = ["MOST_HAIRS", "TABLES", "BristleSpec", "hair_ranges"]

MOST_HAIRS = 10_000
TABLES = ("energy", "measured")

_RANGES = {
    "hair_mm": (0.01, 2.0),
    "film": (0.0, 0.2),
    "threshold_mm": (0.0, 1.0),
    "unevenness": (0.0, 0.2),
    "parting": (0.0, 1.0),
    "splay": (0.0, 1.0),
    "appetite": (0.0, 0.95),
    "levelling_mm": (0.1, 1e4),
    "set_share": (0.001, 0.5),
}


def hair_ranges() -> dict[str, tuple[float, float]]:
    """Least and greatest value of every number of the hairs."""
    return {"n_hairs": (1.0, float(MOST_HAIRS)), **_RANGES}


@dataclasses.dataclass(frozen=True, slots=True)
class BristleSpec:
    """A tuft of single hairs, checked.

    Parameters
    ----------
    n_hairs : int
        1 to 10,000.
    table : {"energy", "measured"}
        Where bent shapes come from: the least bending energy of the brush, or the shapes measured
        on a real brush (FastBrush).
    hair_mm : float
        Thickness of a dry hair, mm.
    film : float
        Ink around a full hair on either side, as a share of the tuft's diameter at the root; hairs
        closer than that flow together.
    threshold_mm : float
        How near the surface a hair must be to leave ink, mm.
    unevenness : float
        How much shorter than the longest hair the shortest is, as a share.
    parting : float
        How far the clumps of a dry tuft part, 0 to 1.
    splay : float
        How far the hairs of a dry tuft lie side by side instead of coming to a point, 0 to 1.
    appetite : float
        How differently hairs give, 0 (all alike) to 1.
    levelling_mm : float
        Way over which neighbouring wet hairs share their ink, mm.
    set_share : float
        Descent over which a remembered bend is pressed out, of the tuft's length.

    Raises
    ------
    BrushError
        Naming the parameter, what was got and what was expected.
    """

    n_hairs: int = 1000
    table: str = "energy"
    hair_mm: float = 0.12
    film: float = 0.011
    threshold_mm: float = 0.15
    unevenness: float = 0.02
    parting: float = 0.9
    splay: float = 0.85
    appetite: float = 0.6
    levelling_mm: float = 30.0
    set_share: float = 0.06

    def __post_init__(self) -> None:
        count = as_number(self.n_hairs, "n_hairs", 1, MOST_HAIRS, BrushError)
        if count != int(count):
            raise BrushError(f"n_hairs is {self.n_hairs}; expected a whole number")
        object.__setattr__(self, "n_hairs", int(count))
        if self.table not in TABLES:
            raise BrushError(f"table is {self.table!r}; expected {' or '.join(TABLES)}")
        for name, (low, high) in _RANGES.items():
            as_number(getattr(self, name), name, low, high, BrushError)

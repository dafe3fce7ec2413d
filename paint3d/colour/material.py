"""What a surface is made of: what shines through thin paint, how it looks, drinks and rubs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from paint3d.core.arrays import as_array, as_number
from paint3d.core.types import AnyArray
from paint3d.errors import PigmentError

__all__ = ["WAVE_RANGE_MM", "WET_COAT_MM", "Material", "glazed_roughness", "material_ranges"]

_FRICTION = (0.2, 2.0)
_MOST_SPREAD = 2.5  # times the friction that a brush was rated on: what shapes are tabulated for
_RANGES = {
    "roughness": (0.0, 1.0),
    "coat": (0.0, 1.0),
    "absorbency": (0.0, 1.0),
    "grain": (0.0, 1.0),
    "friction": _FRICTION,
    "pores_mm": (0.0, 10.0),
    "residual": (0.0, 0.95),
    "advance": (0.0, 1.0),
    "spread_mm2_s": (0.0, 1000.0),
    "passing": (0.0, 1.0),
    "drying_mm_s": (0.0, 1.0),
    "tooth_mm": (0.0, 10.0),
}
_BUMPS = 2.0  # lengths of a bump from one to the next
_GLAZE_ROUGHNESS = 0.07  # of the one lobe that is used: VTK's own coat is weighed by Fresnel twice
_RATED = {"rated_absorbency": "absorbency", "rated_friction": "friction"}

WAVE_RANGE_MM = (0.1, 20.0)
"""Least and greatest distance of bumps that is felt and seen, mm."""
WET_COAT_MM = 0.03
"""Depth of the liquid in one wet coat, mm: a full stroke brushed on. Chosen by eye."""


def glazed_roughness(roughness: float, coat: float) -> float:
    """Roughness that a body of this one has under a glaze so strong, all 0 to 1."""
    return roughness + coat * (_GLAZE_ROUGHNESS - roughness)


def material_ranges() -> dict[str, tuple[float, float]]:
    """Least and greatest value of every number of a material."""
    return _RANGES | {name: _RANGES[of] for name, of in _RATED.items()}


@dataclass(frozen=True, eq=False)
class Material:
    """What an object is made of.

    Parameters
    ----------
    name : str
    reflectance : (31,) array_like
        Reflectance at 400, 410, ... 700 nm, in [0, 1].
    roughness : float
        Of the reflection, 0 (mirror) to 1 (matt).
    coat : float
        Strength of a clear glaze over it, 0 to 1.
    absorbency : float
        How readily ink soaks in, 0 (glaze) to 1 (raw paper). It draws ink out of the brush:
        `uptake`.
    grain : float
        How coarse the surface is to a brush, 0 to 1.
    pores_mm : float
        Water that the pores below 1 mm2 hold, as a depth in mm (thickness x porosity); 0 for what
        drinks nothing, and then ink stays where it is laid.
    residual : float
        Share of it that stays where it is, held by the fibres.
    advance : float
        Share of it that must be there before water goes on into what is dry. The more it is above
        the residual, the earlier the border is pinned and the darker its rim dries.
    spread_mm2_s : float
        Diffusivity of water in full pores, mm2/s.
    passing : float
        Speed of soot over that of the water that carries it, 0 to 1; coarser grains go slower.
    drying_mm_s : float
        Depth of water that evaporates in a second.
    tooth_mm : float
        Length of the bumps that break a dry stroke, 0 for none.
    friction : float
        How many times as much hairs rub on it as on raw xuan, .2 to 2: with the brush's own mu it
        is mu of Guo 2015, Eqs. 2 and 5 (`slip`).
    rated_absorbency, rated_friction : float, optional
        Those at which brushes give their ink, spread and drag as `BrushSpec` says. NaN: its own.
    chinese, source, basis, licence, note : str
        Its Chinese name; whose measurement the reflectance is, for what it stands in, and its
        terms; where the other numbers are from.

    Raises
    ------
    PigmentError
        If the name is empty or a value is not finite or outside its range.
    """

    name: str
    reflectance: AnyArray
    roughness: float
    coat: float
    absorbency: float
    grain: float
    pores_mm: float = 0.0
    residual: float = 0.3
    advance: float = 0.3
    spread_mm2_s: float = 0.0
    passing: float = 1.0
    drying_mm_s: float = 4e-5
    tooth_mm: float = 0.5
    rated_absorbency: float = math.nan
    chinese: str = ""
    source: str = ""
    basis: str = ""
    licence: str = ""
    friction: float = 1.0
    rated_friction: float = math.nan
    note: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            raise PigmentError("a material has no name")
        values = as_array(
            self.reflectance, f"reflectance of {self.name}", (31,), error=PigmentError
        ).copy()
        if values.min() < 0 or values.max() > 1:
            raise PigmentError(
                f"reflectance of {self.name} is {values.min():g} to {values.max():g}; "
                "expected 0 to 1"
            )
        values.flags.writeable = False
        object.__setattr__(self, "reflectance", values)
        for rated, own in _RATED.items():
            stated = getattr(self, rated)
            if isinstance(stated, float) and math.isnan(stated):
                object.__setattr__(self, rated, getattr(self, own))
        for key, (low, high) in material_ranges().items():
            number = as_number(
                getattr(self, key), f"{key} of {self.name}", low, high, error=PigmentError
            )
            object.__setattr__(self, key, number)
        if self.slip > _MOST_SPREAD:
            raise PigmentError(
                f"friction of {self.name} is {self.friction:g}, {self.slip:.3g} times its "
                f"rated_friction {self.rated_friction:g}; expected at most {_MOST_SPREAD:g} times"
            )

    @property
    def seen_roughness(self) -> float:
        """Roughness of what mirrors: the body, or the glaze over it, 0 to 1."""
        return glazed_roughness(self.roughness, self.coat)

    @property
    def wave_mm(self) -> float:
        """How far apart the bumps of its grain are, mm: as they are felt and seen."""
        shortest, longest = WAVE_RANGE_MM
        return min(max(_BUMPS * self.tooth_mm, shortest), longest)

    @property
    def uptake(self) -> float:
        """How many times as fast a brush gives its ink as on the surface that it was rated on.

        Guo 2017, section 4.2.2, adapts eta to brush and surface: here by (1 + absorbency) over the
        same of `rated_absorbency`. The factor is set by eye.
        """
        return (1.0 + self.absorbency) / (1.0 + self.rated_absorbency)

    @property
    def slip(self) -> float:
        """How many times as much hairs rub on it as where a brush was rated.

        Friction belongs to brush and surface (Guo 2015, section 4): what is painted has
        mu = `BrushSpec.friction` times this, what is felt `BrushSpec.friction` times `friction`.
        """
        return self.friction / self.rated_friction

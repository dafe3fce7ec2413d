"""Dishes of ink on the table: poured, stirred, dipped into, emptied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from paint3d.arrays import as_number
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import InputError
from paint3d.ink.pigments import WATER, load_pigment

__all__ = ["Dish", "Dishes"]

_MOST_DISHES = 64
_MOST_DROPS = 1e6
_WHITE = np.full(31, 0.9)  # a porcelain dish


@dataclass(frozen=True)
class Dish:
    """What is in a dish: drops of inks, by name, stirred.

    Attributes
    ----------
    drops : mapping of str to float
        Empty for an empty dish.

    Raises
    ------
    UnknownNameError
        For an ink that is not known.
    InputError
        If drops are no number above 0.
    """

    drops: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        checked: dict[str, float] = {}
        for name, count in dict(self.drops).items():
            own = load_pigment(name).name if ":" not in name else name
            load_pigment(name)
            count = as_number(count, f"drops of {own}", 1e-9, _MOST_DROPS)
            checked[own] = checked.get(own, 0.0) + count
        object.__setattr__(self, "drops", checked)

    @property
    def parts(self) -> dict[str, float]:
        """Share of each ink in the mixture, of sum 1; as `Document.dip` takes it."""
        total = sum(self.drops.values())
        return {name: count / total for name, count in self.drops.items()}

    def with_drops(self, ink: str, count: float = 1.0) -> Dish:
        """With some more drops of an ink, stirred in."""
        name = load_pigment(ink).name if ":" not in ink else ink
        return Dish({**self.drops, name: self.drops.get(name, 0.0) + count})

    def with_dish(self, other: Dish) -> Dish:
        """With all that is in another dish poured in."""
        mixed = dict(self.drops)
        for name, count in other.drops.items():
            mixed[name] = mixed.get(name, 0.0) + count
        return Dish(mixed)

    def srgb(self, coats: float = 1.0) -> tuple[int, int, int]:
        """How the mixture looks in the dish, so many coats deep; white where there is none."""
        inked = {name: w for name, w in self.parts.items() if load_pigment(name) is not WATER}
        shown = _WHITE
        if inked:
            shown = mixture_reflectance(inked, coats * sum(inked.values()), _WHITE)
        red, green, blue = (int(code) for code in srgb_from_reflectance(shown))
        return red, green, blue


class Dishes:
    """The dishes on the table, by their places from 0.

    Parameters
    ----------
    dishes : sequence of Dish
    """

    def __init__(self, dishes: Sequence[Dish] = ()) -> None:
        if len(dishes) > _MOST_DISHES:
            raise InputError(f"{len(dishes)} dishes; expected {_MOST_DISHES} at most")
        self._dishes = list(dishes)

    @classmethod
    def of(cls, *inks: str) -> Dishes:
        """A dish for each of some inks."""
        return cls([Dish({ink: 1.0}) for ink in inks])

    @classmethod
    def from_json(cls, saved: object) -> Dishes:
        """The dishes that `to_json` described.

        Raises
        ------
        InputError
            If it describes none.
        """
        if not isinstance(saved, list) or not all(isinstance(one, Mapping) for one in saved):
            raise InputError(f"dishes are {saved!r:.60}; expected a list of drops by ink")
        return cls([Dish(one) for one in saved])

    def to_json(self) -> list[dict[str, float]]:
        """The dishes as JSON holds them."""
        return [dict(dish.drops) for dish in self._dishes]

    def __len__(self) -> int:
        return len(self._dishes)

    def __getitem__(self, place: int) -> Dish:
        if not 0 <= place < len(self._dishes):
            raise InputError(f"dish {place}; expected 0 to {len(self._dishes) - 1}")
        return self._dishes[place]

    def add(self, dish: Dish | None = None) -> int:
        """Put a dish on the table; its place.

        Raises
        ------
        InputError
            If there are 64.
        """
        if len(self._dishes) >= _MOST_DISHES:
            raise InputError(f"there are {_MOST_DISHES} dishes; expected no more")
        self._dishes.append(dish or Dish())
        return len(self._dishes) - 1

    def remove(self, place: int) -> None:
        """Take a dish away."""
        self._dishes.remove(self[place])

    def empty(self, place: int) -> None:
        """Pour a dish out."""
        self._put(place, Dish())

    def pour(self, place: int, ink: str, drops: float = 1.0) -> None:
        """Pour some drops of an ink into a dish and stir."""
        self._put(place, self[place].with_drops(ink, drops))

    def pour_dish(self, place: int, other: int) -> None:
        """Pour one dish into another and stir."""
        self._put(place, self[place].with_dish(self[other]))

    def mixture(self, place: int) -> dict[str, float]:
        """What a brush that is dipped into a dish takes up, as `Document.dip` takes it.

        Raises
        ------
        InputError
            If the dish is empty.
        """
        if not self[place].drops:
            raise InputError(f"dish {place} is empty; expected ink in it")
        return self[place].parts

    def _put(self, place: int, dish: Dish) -> None:
        self[place]
        self._dishes[place] = dish

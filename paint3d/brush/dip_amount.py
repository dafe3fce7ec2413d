"""How much ink a dip takes up: what share of the tuft it wets, and how full that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from paint3d.brush_engine.tuft import Tuft
from paint3d.core.arrays import as_number
from paint3d.errors import InputError

__all__ = ["DipAmount"]

_LEAST_WETTED = 1e-3  # share of a tuft
_FULLEST, _EMPTIEST = 3.0, 0.05


@dataclass(frozen=True)
class DipAmount:
    """What a brush holds after a dip, against the load of its preset.

    A share f of its tuft is wet and filled g times as full as the preset says. It holds f g of the
    preset's load, and gives R (1 - exp(-eta' pe ds / f)) of what it holds (docs/model.md, equation
    (10)): at first g times what a whole dip gives, whatever the share, and it runs dry the sooner,
    the smaller this is. So a large brush writes a few small characters, and is dipped again.

    Attributes
    ----------
    wetted : float
        f, .001 to 1.
    fullness : float
        g, .05 to 3.

    Raises
    ------
    InputError
        If one of them is out of range.
    """

    wetted: float = 1.0
    fullness: float = 1.0

    def __post_init__(self) -> None:
        as_number(self.wetted, "wetted share of the tuft", _LEAST_WETTED, 1.0)
        as_number(self.fullness, "fullness of a dip", _EMPTIEST, _FULLEST)

    @classmethod
    def of(cls, words: object) -> DipAmount:
        """The amount that a recording's header tells: ``{"wetted": .., "fullness": ..}``.

        Raises
        ------
        InputError
            For anything else.
        """
        if not isinstance(words, Mapping) or set(words) - {"wetted", "fullness"}:
            raise InputError(f"a dip is {words!r:.60}; expected wetted and fullness")
        return cls(**words)

    def words(self) -> dict[str, Any]:
        """What `of` takes."""
        return {"wetted": self.wetted, "fullness": self.fullness}

    def of_tuft(self, tuft: Tuft) -> Tuft:
        """A tuft that holds so much when it is full, and gives as such a one does."""
        return tuft._replace(
            load=tuft.load * self.wetted * self.fullness,
            transfer_per_mm=tuft.transfer_per_mm / self.wetted,
        )

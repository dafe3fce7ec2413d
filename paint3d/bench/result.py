"""Result of a benchmark: a table, and figures with their bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from paint3d.errors import InputError

__all__ = ["Check", "Result"]

Cell = str | int | float | None


@dataclass(frozen=True)
class Check:
    """A figure and its bound.

    Attributes
    ----------
    name : str
    value : float
    bound : float
    at_most : bool
        True if the value should not exceed the bound, False if it should reach it.
    unit : str
    """

    name: str
    value: float
    bound: float
    at_most: bool = True
    unit: str = ""

    @property
    def is_met(self) -> bool:
        """True if the figure keeps its bound."""
        return self.value <= self.bound if self.at_most else self.value >= self.bound


@dataclass(frozen=True)
class Result:
    """A table and its checks.

    Attributes
    ----------
    title : str
    columns : sequence of str
        With their units.
    rows : sequence of sequences
        One cell a column.
    checks : sequence of Check
    notes : sequence of str
        What a reader must know to judge the figures.

    Raises
    ------
    InputError
        If a row is not as long as the columns.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    checks: Sequence[Check] = ()
    notes: Sequence[str] = ()

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise InputError(
                    "a row has {n} cells; expected {columns}",
                    n=len(row),
                    columns=len(self.columns),
                )

    def as_dict(self) -> dict[str, Any]:
        """Return everything, ready for JSON."""
        return {
            "title": self.title,
            "columns": list(self.columns),
            "rows": [list(row) for row in self.rows],
            "checks": [
                {
                    "name": check.name,
                    "value": check.value,
                    "wanted": f"{'<=' if check.at_most else '>='} {check.bound:g}",
                    "unit": check.unit,
                    "kept": check.is_met,
                }
                for check in self.checks
            ],
            "notes": list(self.notes),
        }

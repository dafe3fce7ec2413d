"""Cases of tests: those that are run every time, and those that only a long check runs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

__all__ = ["long_but"]


def long_but(kept: Iterable[Any], cases: Iterable[Any]) -> list[Any]:
    """Mark all cases as long but those kept, which are run every time."""
    kept, cases = list(kept), list(cases)
    assert all(case in cases for case in kept), "some that is kept is no case"
    return [
        case
        if case in kept
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.long)
        for case in cases
    ]

"""Packages that read fonts, drawings and photographs: imported when one is first asked for."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from paint3d.errors import InputError

__all__ = ["import_optional"]


def import_optional(name: str) -> Any:
    """One of the packages that read fonts, drawings and photographs.

    Raises
    ------
    InputError
        If it is not installed; the message says how to.
    """
    try:
        return import_module(name)
    except ImportError:
        raise InputError(
            "fonts, drawings and photographs need {package}, which is not installed",
            package=name.split(".")[0],
            hint="pip install 'paint3d[hand]'",
        ) from None

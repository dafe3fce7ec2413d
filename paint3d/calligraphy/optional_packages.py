"""Packages that read fonts, drawings and photographs: imported when one is first asked for."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from paint3d.errors import InputError

__all__ = ["import_optional"]


def import_optional(name: str) -> Any:
    """Import one of the packages that read fonts, drawings and photographs.

    Raises
    ------
    InputError
        If it is not installed; the message says how to.
    """
    try:
        return import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise InputError(
            "fonts, drawings and photographs need {package}, which is not installed",
            package=package,
            hint="pip install " + ("'paint3d[hand]'" if package == "skimage" else package),
        ) from None

"""Versions of the program, of Python and of the packages that decide what is painted."""

from __future__ import annotations

import sys
from functools import cache

__all__ = ["find_versions"]

_PACKAGES = (
    "paint3d",
    "numpy",
    "scipy",
    "numba",
    "llvmlite",
    "trimesh",
    "open3d",
    "pyvista",
    "vtk",
    "colour-science",
    "hidapi",
)


def find_versions() -> dict[str, str]:
    """Versions by name; a package that is absent is listed as ``not installed``."""
    import platform

    found = {"python": sys.version.split()[0], "system": platform.platform()}
    return found | {package: _version(package) for package in _PACKAGES}


@cache
def _version(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"

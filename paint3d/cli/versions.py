"""Versions of the program, of Python and of the packages that decide what is painted."""

from __future__ import annotations

import platform
import sys

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
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": sys.version.split()[0], "system": platform.platform()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found

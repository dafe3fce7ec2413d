"""The public face of a package: a few names of its modules, each loaded when it is first used.

A room says in its ``__init__.py`` what it is for, and in the ``__init__.pyi`` beside it, where type
checkers and editors look, which of its names others are meant to use, and in which module each is.
So one may write ``from paint3d.mesh import TriangleMesh``, and importing the room loads none of
them (Scientific Python's SPEC 1). Inside the package everybody imports from the modules.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path

__all__ = ["late_face", "names_of"]


def late_face(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return the ``__getattr__`` and ``__dir__`` of a package by its name."""

    def load(name: str) -> object:
        homes = names_of(package)
        if name == "__all__":
            return sorted(homes)
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        if homes[name] == package:
            return import_module(f"{package}.{name}")
        value: object = getattr(import_module(homes[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return load, lambda: sorted({*vars(sys.modules[package]), *names_of(package)})


@cache
def names_of(package: str) -> dict[str, str]:
    """Return the names in the face of a package, and the module that each is from."""
    import ast

    stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi")
    return {
        name.name: str(line.module)
        for line in ast.parse(stub.read_text(encoding="utf-8")).body
        if isinstance(line, ast.ImportFrom)
        for name in line.names
    }

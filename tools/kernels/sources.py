"""Sources that a kernel depends on: its own, and all of the package that these import."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

__all__ = ["ROOT", "digest", "sources_of"]

ROOT = Path(__file__).parents[2]  # of the checkout
_PACKAGE = "paint3d"
_DECORATORS = "paint3d/core/kernel.py"  # with their options, which count
_NO_CODE = "paint3d/errors.py"  # exceptions: no machine code depends on one


def digest(path: str) -> str:
    """Hash a source, by its path from the root."""
    return hashlib.sha256((ROOT / path).read_bytes()).hexdigest()


def sources_of(modules: Iterable[str], alone: Iterable[str] = ()) -> list[str]:
    """List the paths, from the root, of all sources that modules depend on.

    Whatever is imported when it is imported counts, used or not: a change that is not seen would
    leave old code running. Not so what makes kernels known to Python, for how they are found
    changes none of them, and the package's own list of public names. Of those `alone` only their
    own source counts.
    """
    own = {path for module in alone for path in _files_of(module)}
    followed: set[str] = set()
    waiting = [*modules]
    while waiting:
        for path in _files_of(waiting.pop()):
            if path not in followed:
                followed.add(path)
                if path != _DECORATORS:
                    waiting.extend(_imported(path))
    return sorted(own | followed)


def _files_of(module: str) -> Iterator[str]:
    """Yield the file of a module, and those of the packages around it."""
    parts = module.split(".")
    for n in range(2, len(parts) + 1):
        base = "/".join(parts[:n])
        for path in (f"{base}/__init__.py", f"{base}.py"):
            if path != _NO_CODE and (ROOT / path).is_file():
                yield path


@functools.cache
def _imported(path: str) -> frozenset[str]:
    """Return the modules of the package that a source imports; names that may be modules count."""
    modules: set[str] = set()
    waiting: list[ast.stmt] = list(ast.parse((ROOT / path).read_text("utf-8")).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"{path}: imports by relative names")
            if (node.module or "").split(".")[0] == _PACKAGE:
                modules |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names if alias.name.split(".")[0] == _PACKAGE}
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting.extend(node.orelse)
        elif not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            waiting.extend(
                part for part in ast.iter_child_nodes(node) if isinstance(part, ast.stmt)
            )
    return frozenset(modules)

"""Which module of the package imports which, read from the sources."""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterable, Mapping
from pathlib import Path

__all__ = ["circles", "import_graph", "reached"]

Graph = Mapping[str, set[str]]


@functools.cache
def import_graph(package: Path) -> dict[str, set[str]]:
    """Module to the modules of the package that it names, also for types only and inside functions.

    A module imports the packages that it lies in.
    """
    files = {_name(file, package): file for file in package.rglob("*.py")}
    known = frozenset(files)
    return {name: _imports(file, name, known) for name, file in files.items()}


def _name(file: Path, package: Path) -> str:
    parts = file.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports(file: Path, name: str, known: frozenset[str]) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names} & known
            found |= inner or {node.module}
    return (found & known) - {name}


def reached(graph: Graph, roots: Iterable[str]) -> set[str]:
    """Modules that are loaded, sooner or later, with some."""
    seen: set[str] = set()
    todo = list(roots)
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += graph[module]
            todo += [module.rpartition(".")[0]] if "." in module else []
    return seen


def circles(graph: Graph) -> list[set[str]]:
    """Modules that import each other around a circle."""
    after = {module: reached_from(graph, module) for module in graph}
    found: list[set[str]] = []
    for module in graph:
        circle = {other for other in after[module] if module in after[other]}
        if circle and circle not in found:
            found.append(circle)
    return found


def reached_from(graph: Graph, module: str) -> set[str]:
    """What one imports, directly or through others."""
    seen: set[str] = set()
    todo = list(graph[module])
    while todo:
        other = todo.pop()
        if other not in seen:
            seen.add(other)
            todo += graph[other]
    return seen

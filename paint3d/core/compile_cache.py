"""The cache of kernels that numba compiled: its folder, and deletion of what is stale.

numba compiles a kernel again when its own file has changed, but not when a kernel that it calls in
another file has. After an edit, or a change of versions in a working copy, old and new code would
run side by side unnoticed. So the state of all sources is recorded beside the compiled code, and
where a file has changed, the code compiled from it and from all files that import it is deleted.

Nor does numba check the field names of the named tuples that kernels take: it knows fields by
position, so two that change places would be confused. Kernels need not import the tuples they
take; but these are defined in folders of kernels, and where the fields of one have changed, all
compiled code is deleted.

numba writes beside the source or to the user's cache folder, and refuses to work where it can
write to neither: then it gets a private folder among the temporary files.
"""

from __future__ import annotations

import ast
import contextlib
import json
import logging
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any

from numba import config, njit

from paint3d.core.own_folders import can_write, find_home, private_folder

__all__ = ["compiled_folder", "drop_stale", "is_kept"]

_FOLDERS = (  # of the package, with kernels and the tuples that they take
    "core",
    "*/kernels",
    "brush_engine",
    "brush_engine/bristles",
)
_RECORD = "sources.json"
_IMPORT = re.compile(r"^from paint3d(?:\.([\w.]+))? import (\([^)]*\)|.*)$", re.MULTILINE)
_PACKAGE = Path(__file__).parents[1]


log = logging.getLogger("paint3d")


def _has_folder() -> bool:
    """Return whether numba finds a folder that it can write compiled code to."""
    configured = str(getattr(config, "CACHE_DIR", ""))
    beside = Path(__file__).with_name("__pycache__")
    users = os.environ.get("XDG_CACHE_HOME", find_home() or "")
    if not (configured or os.path.isabs(users) or can_write(beside)):
        return False  # it would make a folder named ~ in the working one, or numba
    try:
        njit(cache=True)(_has_folder)
    except RuntimeError:  # no locator available
        return False
    return True


def _use_private_folder() -> None:
    """Make this process, and those that it starts, write compiled kernels to a private folder."""
    folder = private_folder() / "numba"
    log.warning(
        "no home that can be written: compiled code is kept in %s; NUMBA_CACHE_DIR names another "
        "folder",
        folder,
    )
    os.environ["NUMBA_CACHE_DIR"] = os.fspath(folder)
    setattr(config, "CACHE_DIR", os.fspath(folder))  # noqa: B010  # untyped attribute


if not _has_folder():
    _use_private_folder()


def _nothing() -> None:
    """Do nothing: a function to ask numba for its cache folder with."""


def compiled_folder(sources: Path) -> Path:
    """Return the folder in which numba caches what it compiles from modules in `sources`."""
    there = _nothing.__code__.replace(co_filename=os.fspath(sources / "__init__.py"))
    return _cache_of(njit(cache=True)(FunctionType(there, {}, "nothing")))


def _cache_of(kernel: Any) -> Path:
    """Return the folder in which numba caches a kernel."""
    return Path(kernel.stats.cache_path)


def is_kept(kernel: Any) -> bool:
    """Return whether code of a kernel is cached for this version of Python."""
    name = f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.py_func.__qualname__}"
    version = f"py{sys.version_info.major}{sys.version_info.minor}"
    return any(_cache_of(kernel).glob(f"{name}-*.{version}*.nbi"))


def drop_stale(
    package: Path = _PACKAGE, compiled: Callable[[Path], Path] = compiled_folder
) -> None:
    """Delete the code compiled from changed sources and from those that import them.

    Parameters
    ----------
    package : Path
        Its folders of kernels are checked.
    compiled : callable
        Maps a folder of sources to that of numba's files,
        ``<module>.<function>-<line>.<python>.nbi`` and ``.nbc``.
    """
    files = {
        path.relative_to(package).with_suffix("").as_posix(): path
        for pattern in _FOLDERS
        for folder in package.glob(pattern)
        for path in folder.glob("*.py")
    }
    record = compiled(package / _FOLDERS[0]) / _RECORD
    before = _read_record(record)
    now: dict[str, list[Any]]
    now = {name: [path.stat().st_size, path.stat().st_mtime_ns] for name, path in files.items()}
    if {name: state[:2] for name, state in before.items()} == now:
        return
    changed = {
        name for name in now.keys() | before.keys() if now.get(name) != before.get(name, [])[:2]
    }
    for name, state in now.items():
        state.append(_tuple_fields(files[name]) if name in changed else before[name][2])
    if any(now.get(name, [{}])[-1] != before.get(name, [{}])[-1] for name in changed):
        stale = set(files) | changed
    else:
        stale = _with_importers(changed, files)
    with contextlib.suppress(OSError):  # a folder that cannot be written has none of our files
        _delete_compiled(stale, package, compiled)
        record.parent.mkdir(parents=True, exist_ok=True)
        temporary = record.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps(now), "utf-8")
        temporary.replace(record)


def _delete_compiled(stale: set[str], package: Path, compiled: Callable[[Path], Path]) -> None:
    """Delete the code compiled from the modules in `stale`."""
    for folder in {name.rpartition("/")[0] for name in stale}:
        if not (package / folder).is_dir():
            continue  # deleted, and its compiled code with it or out of reach
        try:
            cache = compiled(package / folder)
        except RuntimeError:  # without sources numba names no folder, and none is needed
            continue
        for path in cache.glob("*.nb[ic]"):
            if f"{folder}/{path.name.partition('.')[0]}" in stale:
                path.unlink(missing_ok=True)


def _read_record(record: Path) -> dict[str, list[Any]]:
    """Read the sources' recorded sizes, times and tuples; none where that fails."""
    try:
        states = json.loads(record.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    is_valid = isinstance(states, dict) and all(
        isinstance(state, list) and len(state) == 3 for state in states.values()
    )
    return states if is_valid else {}


def _tuple_fields(source: Path) -> dict[str, list[str]]:
    """Return the fields of the named tuples that a source defines."""
    return {
        node.name: [
            line.target.id
            for line in node.body
            if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name)
        ]
        for node in ast.parse(source.read_text("utf-8")).body
        if isinstance(node, ast.ClassDef)
        and any(isinstance(base, ast.Name) and base.id == "NamedTuple" for base in node.bases)
    }


def _with_importers(changed: set[str], files: dict[str, Path]) -> set[str]:
    """Return `changed` and all modules that import them, directly or indirectly."""
    imports = {name: _imported(path.read_text("utf-8")) for name, path in files.items()}
    stale = set(changed)
    while True:
        more = {name for name, used in imports.items() if name not in stale and used & stale}
        if not more:
            return stale
        stale |= more


def _imported(source: str) -> set[str]:
    """Return the modules that a source imports from the package, and names that may be modules."""
    modules = set()
    for module, names in _IMPORT.findall(source):
        folder = module.replace(".", "/")
        words = [word.split()[0] for word in names.strip("()").split(",") if word.strip()]
        modules |= {folder, *(f"{folder}/{word}" for word in words)}
    return modules

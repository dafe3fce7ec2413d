"""Where compiled kernels are kept; those that call others whose source has changed are dropped.

numba compiles a kernel anew when the file it stands in has changed, not when a kernel that it calls
in another file has. After an edit, or a change of versions in a working copy, old and new code
would run side by side and nobody would know. So the state of all sources is kept beside the
compiled code, and where a file has changed, what is compiled of it and of all files that import it
is deleted.

Nor does numba look at the fields of the named tuples that kernels take: it knows them by their
place, so that two that change places would be taken for each other. Kernels that are handed such a
tuple need not import it; but it stands in a folder of kernels, and where the fields of one there
have changed, all that is compiled is deleted.

numba keeps them beside the source or in the user's cache folder, and refuses to work where it can
write to neither: then they are kept in a private folder among the temporary files.
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
from numba.core.dispatcher import Dispatcher

from paint3d.core.own_folders import can_write, find_home, private_folder

__all__ = ["compiled_folder", "drop_stale", "is_kept"]

_FOLDERS = (  # of the package: where kernels are, and tuples that they take
    "core",
    "*/kernels",
    "brush_engine",
    "brush_engine/bristles",
)
_RECORD = "sources.json"
_IMPORT = re.compile(r"^from paint3d(?:\.([\w.]+))? import (\([^)]*\)|.*)$", re.MULTILINE)
_PACKAGE = Path(__file__).parents[1]


log = logging.getLogger("paint3d")


def _numba_folder() -> str:
    """The folder that numba was told to keep what it compiles in; "" for none."""
    return str(getattr(config, "CACHE_DIR", ""))


def _finds_a_folder() -> bool:
    """Whether numba has where to keep what it compiles."""
    beside = Path(__file__).with_name("__pycache__")
    users = os.environ.get("XDG_CACHE_HOME", find_home() or "")
    if not (_numba_folder() or os.path.isabs(users) or can_write(beside)):
        return False  # it would make a folder named ~ in the working one, or numba
    try:
        njit(cache=True)(_finds_a_folder)
    except RuntimeError:  # no locator available
        return False
    return True


def _give_a_folder() -> None:
    """Have this process, and those that it starts, keep compiled kernels in a private folder."""
    folder = private_folder() / "numba"
    log.warning(
        "no home that can be written: compiled code is kept in %s; NUMBA_CACHE_DIR names another "
        "folder",
        folder,
    )
    os.environ["NUMBA_CACHE_DIR"] = os.fspath(folder)
    setattr(config, "CACHE_DIR", os.fspath(folder))  # noqa: B010  # its own, unknown to types


if not _finds_a_folder():
    _give_a_folder()


def _nothing() -> None:
    """Nothing; numba tells where it would keep it."""


def compiled_folder(sources: Path) -> Path:
    """The folder in which numba keeps what is compiled of the modules in another."""
    there = _nothing.__code__.replace(co_filename=os.fspath(sources / "__init__.py"))
    return _kept_by(njit(cache=True)(FunctionType(there, {}, "nothing")))


def _kept_by(kernel: Any) -> Path:
    """The folder in which numba keeps a kernel that it keeps."""
    return Path(kernel.stats.cache_path)


def is_kept(kernel: Dispatcher) -> bool:
    """Whether code of a kernel is kept for this version of Python."""
    name = f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.py_func.__qualname__}"
    version = f"py{sys.version_info.major}{sys.version_info.minor}"
    return any(_kept_by(kernel).glob(f"{name}-*.{version}*.nbi"))


def drop_stale(
    package: Path = _PACKAGE, compiled: Callable[[Path], Path] = compiled_folder
) -> None:
    """Delete what is compiled of changed sources and of those that import them.

    Parameters
    ----------
    package : Path
        Its folders that hold kernels are looked at.
    compiled : callable
        From a folder of sources to that of numba's files,
        ``<module>.<function>-<line>.<python>.nbi`` and ``.nbc``.
    """
    files = {
        path.relative_to(package).with_suffix("").as_posix(): path
        for pattern in _FOLDERS
        for folder in package.glob(pattern)
        for path in folder.glob("*.py")
    }
    record = compiled(package / _FOLDERS[0]) / _RECORD
    before = _read(record)
    now: dict[str, list[Any]]
    now = {name: [path.stat().st_size, path.stat().st_mtime_ns] for name, path in files.items()}
    if {name: state[:2] for name, state in before.items()} == now:
        return
    changed = {
        name for name in now.keys() | before.keys() if now.get(name) != before.get(name, [])[:2]
    }
    for name, state in now.items():
        state.append(_tuples(files[name]) if name in changed else before[name][2])
    if any(now.get(name, [{}])[-1] != before.get(name, [{}])[-1] for name in changed):
        stale = set(files) | changed
    else:
        stale = _with_importers(changed, files)
    with contextlib.suppress(OSError):  # a folder that cannot be written holds nothing of ours
        _delete(stale, package, compiled)
        record.parent.mkdir(parents=True, exist_ok=True)
        temporary = record.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps(now), "utf-8")
        temporary.replace(record)


def _delete(stale: set[str], package: Path, compiled: Callable[[Path], Path]) -> None:
    """Delete what is compiled of the modules that are named."""
    for folder in {name.rpartition("/")[0] for name in stale}:
        if not (package / folder).is_dir():
            continue  # gone, and its compiled code with it or out of reach
        try:
            kept = compiled(package / folder)
        except RuntimeError:  # no source is left in it: numba does not say, and nobody asks again
            continue
        for path in kept.glob("*.nb[ic]"):
            if f"{folder}/{path.name.partition('.')[0]}" in stale:
                path.unlink(missing_ok=True)


def _read(record: Path) -> dict[str, list[Any]]:
    """The sources' sizes, times and tuples when it was written; none where it cannot be read."""
    try:
        found = json.loads(record.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    whole = isinstance(found, dict) and all(
        isinstance(state, list) and len(state) == 3 for state in found.values()
    )
    return found if whole else {}


def _tuples(source: Path) -> dict[str, list[str]]:
    """The fields of the named tuples that a source defines."""
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
    """Return modules and all that import them, directly or by others."""
    imports = {name: _imported(path.read_text("utf-8")) for name, path in files.items()}
    stale = set(changed)
    while True:
        more = {name for name, used in imports.items() if name not in stale and used & stale}
        if not more:
            return stale
        stale |= more


def _imported(source: str) -> set[str]:
    """What a source imports of the package: modules, and names that may be modules."""
    found = set()
    for module, names in _IMPORT.findall(source):
        folder = module.replace(".", "/")
        words = [word.split()[0] for word in names.strip("()").split(",") if word.strip()]
        found |= {folder, *(f"{folder}/{word}" for word in words)}
    return found

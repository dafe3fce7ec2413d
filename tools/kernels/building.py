"""Build the library: parts of the entries, each compiled by a process of its own, and linked.

Of every part is known what it was made from, so that after an edit only the parts that it reaches
are made again, and a second run makes nothing.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tools.kernels.checking import checked_table
from tools.kernels.processors import architecture_of
from tools.kernels.sources import ROOT, digest, sources_of
from tools.kernels.table import Entry, read_table

__all__ = [
    "FOLDER",
    "PAGE_FOLDER",
    "BuildError",
    "Part",
    "build",
    "is_built",
    "link_wasm",
    "parts",
]

FOLDER = ROOT / "paint3d" / "core" / "machine_code"
PAGE_FOLDER = ROOT / "paint3d" / "page" / "machine_code"
_FORMAT = 2  # as `paint3d.core.kernel_library` reads it
_INDEX = "index.json"
_HERE = Path(__file__).parent
_COMPILERS = ("lowering", "numba_inside", "optimising", "part", "processors")
_VERSIONS = ("numba", "llvmlite", "numpy")
# What is lowered by one process, the longest first: the groups of its entries, which are optimised
# beside one another, by the rooms they are in.
_ROOMS = {"wasm32": ("brush_engine", "colour", "mesh", "pose", "surface")}  # others have all
_PARTS = {
    "brush": [
        ("brush_engine.bristles", "bench.kernels.standing_bristles"),
        ("brush_engine", "bench"),
    ],
    "rooms": [("",)],
}


class BuildError(Exception):
    """The library cannot be built here; the message says why."""


@dataclass(frozen=True)
class Part:
    """Entries that are compiled by one process."""

    name: str
    groups: list[dict[str, Entry]]  # by the names of their functions of C

    def steps(self, processors: list[str]) -> int:
        """Count the progress messages of its process: see `part.compile_part`."""
        return sum(map(len, self.groups)) + 1 + len(self.groups) * len(processors)

    def stamp(self) -> str:
        """Hash all that it is compiled from."""
        sources = {source for group in self.groups for e in group.values() for source in _of(e)}
        made_from = [
            repr(self.groups),
            *((path, digest(path)) for path in sorted(sources)),
            *((name, digest(f"tools/kernels/{name}.py")) for name in _COMPILERS),
            *((name, version(name)) for name in _VERSIONS),
            ("Python", sys.version_info[:2]),
        ]
        return hashlib.sha256(json.dumps(made_from).encode()).hexdigest()[:16]


def _of(entry: Entry) -> list[str]:
    return sources_of(entry.modules, entry.tuples)


def parts(architecture: str) -> list[Part]:
    """List the entries of the table for an architecture, by part."""
    remaining = {}
    for entry in read_table().entries:
        symbol = f"paint3d_{entry.module.replace('.', '_')}_{entry.name}"
        count = sum(name.startswith(symbol) for name in remaining)
        if entry.module.startswith(_ROOMS.get(architecture, ("",))):
            remaining[f"{symbol}_{count}"] = entry
    all_parts = []
    for name, rooms in _PARTS.items():
        groups = []
        for prefix in rooms:
            group = {s: e for s, e in remaining.items() if e.module.startswith(prefix)}
            remaining = {s: e for s, e in remaining.items() if s not in group}
            groups.append(group)
        all_parts.append(Part(name, groups))
    return all_parts


def _stamps(processors: list[str]) -> dict[str, Any]:
    c = [digest(path.relative_to(ROOT).as_posix()) for path in sorted(_HERE.glob("*.c"))]
    return {
        "parts": {part.name: part.stamp() for part in parts(architecture_of(processors[0]))},
        "processors": processors,
        "c": [*c, sys.version_info[:2]],
    }


def is_built(processors: list[str], folder: Path = FOLDER) -> bool:
    """Return whether the library exists and is up to date."""
    try:
        index = json.loads((folder / _INDEX).read_text("utf-8"))
        names = [*filter(None, [index["caller"]]), *index["code"].values()]
    except (OSError, ValueError, LookupError):
        return False
    is_whole = all((folder / name).is_file() for name in names)
    return is_whole and index["made_from"] == json.loads(json.dumps(_stamps(processors)))


def build(
    processors: list[str],
    folder: Path = FOLDER,
    say: Callable[[int, int], None] = lambda done, of: None,
) -> None:
    """Build what is missing or out of date.

    Parameters
    ----------
    processors : list of str
        Of one architecture: ``x86-64-v2`` (2009), ``x86-64-v3`` (2013, AVX2), ``x86-64-v4``
        (AVX-512), ``aarch64``,
        ``wasm32``.
    folder : Path
        Beside the package's decorators, where they look for it.
    say : callable
        Told how many steps are done, and of how many.

    Raises
    ------
    BuildError
        A compiler for that architecture or Python's headers are missing, or a kernel cannot be
        compiled.
    TableError
        The table does not say what the sources say.
    """
    if is_built(processors, folder):
        return
    checked_table()
    architecture = architecture_of(processors[0])
    stamps = _stamps(processors)
    folder.mkdir(parents=True, exist_ok=True)
    kept = folder / "parts"
    with tempfile.TemporaryDirectory(dir=folder, prefix="building-") as work:
        caller = Path(work) / f"caller-{_short(stamps['c'])}.abi3.so"
        if architecture == "wasm32":
            _find_zig()  # says first of all what is missing
        else:
            _compile_caller(caller, architecture)
        wanted = parts(architecture)
        places = {part.name: kept / _part_folder(part, processors) for part in wanted}
        waiting = [part for part in wanted if not places[part.name].is_dir()]
        steps = _Steps(1 + sum(part.steps(processors) for part in waiting), say)
        with ThreadPoolExecutor(max(1, len(waiting))) as pool:
            made = [
                pool.submit(_compile, part, processors, places[part.name], steps.next)
                for part in waiting
            ]
            for one in made:
                one.result()
        code = {one: _link(one, list(places.values()), Path(work)) for one in processors}
        callers = [caller.name] if caller.is_file() else []  # what runs WebAssembly calls it itself
        index = _index(places, stamps, next(iter(callers), None), code)
        for name in (*callers, *code.values()):
            (Path(work) / name).replace(folder / name)
        text = Path(work) / _INDEX
        text.write_text(json.dumps(index), "utf-8")
        text.replace(folder / _INDEX)
    _drop_old(folder, {_INDEX, "parts", *callers, *code.values()})
    _drop_old(kept, {place.name for place in places.values()})
    steps.next()


class _Steps:
    """Counts what several threads have done."""

    def __init__(self, of: int, say: Callable[[int, int], None]) -> None:
        self._done, self._of, self._say, self._lock = 0, of, say, threading.Lock()

    def next(self) -> None:
        with self._lock:
            self._done += 1
            self._say(self._done, self._of)


def _short(thing: Any) -> str:
    return hashlib.sha256(json.dumps(thing).encode()).hexdigest()[:12]


def _part_folder(part: Part, processors: list[str]) -> str:
    return f"{part.name}-{'-'.join(processors)}-{part.stamp()}"


def _compile(part: Part, processors: list[str], place: Path, say: Callable[[], None]) -> None:
    """Compile a part in a process of its own, which writes a line at every step."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place.parent, prefix=f"{part.name}-") as work:
        words = ["--part", part.name, "--into", work, "--for", *processors]
        with (
            tempfile.TemporaryFile("w+") as errors,
            subprocess.Popen(
                [sys.executable, "-m", "tools.kernels", *words],
                cwd=ROOT,
                stdout=subprocess.PIPE,
                stderr=errors,
            ) as run,
        ):
            assert run.stdout is not None, "it is a pipe"
            for _ in run.stdout:
                say()
            if run.wait():
                errors.seek(0)
                output = errors.read()[-2000:]
                raise BuildError(f"kernels of {part.name} cannot be compiled:\n{output}")
        if not place.is_dir():  # another may have made it meanwhile
            Path(work).rename(place)
            Path(work).mkdir()  # for the folder's own end


def _link(processor: str, places: list[Path], work: Path) -> str:
    """Link the shared library for a processor; return its name."""
    objects = [path for place in places for path in sorted(place.glob(f"*-{processor}.o"))]
    if architecture_of(processor) == "wasm32":
        return link_wasm(objects, [*places], work)
    exports = work / "exports"
    exports.write_text("{ global: paint3d_*; local: *; };\n")
    target = work / "kernels.so"
    _gcc(architecture_of(processor), "-shared", "-s", f"-Wl,--version-script={exports}",
         "-Wl,-z,defs", "-Wl,--gc-sections", *objects, _HERE / "runtime.c", "-lm", "-o", target,
         )  # fmt: skip
    name = f"{processor}-{hashlib.sha256(target.read_bytes()).hexdigest()[:12]}.so"
    target.rename(work / name)
    return name


def link_wasm(objects: list[Path], places: list[Path], work: Path) -> str:
    """Link the WebAssembly module, with zig's C library; return its name.

    Parameters
    ----------
    objects, places : list of Path
        Object files, and the folders that `part.compile_part` has filled.
    work : Path
        The folder that gets it.

    Raises
    ------
    BuildError
        If zig is missing, or cannot link.
    """
    symbols = [
        symbol
        for place in places
        for symbol in json.loads((place / "entries.json").read_text("utf-8"))
    ]
    target = work / "kernels.wasm"
    exports = [f"-Wl,--export={name}" for name in ("malloc", "free", "paint3d_release", *symbols)]
    _run_compiler(
        [*_find_zig(), "cc", "-target", "wasm32-wasi", "-O2", "-mexec-model=reactor", "-s"],
        *objects, _HERE / "runtime.c", *exports, "-o", target,
    )  # fmt: skip
    name = f"wasm32-{hashlib.sha256(target.read_bytes()).hexdigest()[:12]}.wasm"
    target.rename(work / name)
    return name


def _find_zig() -> list[str]:
    """Return the command line of zig, whose package is an extra."""
    if importlib.util.find_spec("ziglang") is None:
        raise BuildError("ziglang is missing: pip install 'paint3d[page]'")
    return [sys.executable, "-m", "ziglang"]


def _compile_caller(target: Path, architecture: str) -> None:
    import numpy as np

    headers = [sysconfig.get_path("include"), np.get_include()]
    if not (Path(headers[0]) / "Python.h").is_file():
        raise BuildError(f"Python's headers are missing from {headers[0]}: install python3-dev")
    include = [f"-I{path}" for path in headers]
    _gcc(architecture, "-shared", "-s", *include, _HERE / "caller.c", "-o", target)


def _gcc(architecture: str, *words: str | Path) -> None:
    """Compile C, or link, for an architecture: with a cross-compiler where it is not our own."""
    is_own = architecture == platform.machine()
    names = ["gcc", "cc"] if is_own else [f"{architecture}-linux-gnu-gcc"]
    compiler = next(filter(None, map(shutil.which, names)), None)
    if compiler is None:
        raise BuildError(f"{names[0]} is missing")
    _run_compiler([compiler, "-O2", "-fPIC", "-fvisibility=hidden"], *words)


def _run_compiler(compiler: list[str], *words: str | Path) -> None:
    run = subprocess.run([*compiler, *map(str, words)], capture_output=True, text=True, check=False)
    if run.returncode:
        raise BuildError(f"{Path(compiler[0]).name}: {run.stderr[-2000:]}")


def _index(
    folders: dict[str, Path], stamps: dict[str, Any], caller: str | None, code: dict[str, str]
) -> dict[str, Any]:
    """Make the index that `paint3d.core.kernel_library` reads."""
    sources: dict[str, int] = {}
    kernels: dict[str, Any] = {}
    architecture = architecture_of(next(iter(code)))
    for part in parts(architecture):
        described = json.loads((folders[part.name] / "entries.json").read_text("utf-8"))
        for group in part.groups:
            for symbol, entry in group.items():
                made_from = [sources.setdefault(path, len(sources)) for path in _of(entry)]
                kernel = kernels.setdefault(entry.kernel, {"sources": made_from, "codes": []})
                kernel["codes"].append(described[symbol])
    return {
        "format": _FORMAT,
        "made_from": stamps,
        "architecture": architecture,
        "caller": caller,
        "code": code,
        "sources": [[path, digest(path)] for path in sources],
        "kernels": kernels,
    }


def _drop_old(folder: Path, keep: set[str]) -> None:
    """Delete files of earlier builds; running programs keep what they have loaded."""
    for path in folder.iterdir():
        if path.name not in keep and not path.name.startswith("building-"):
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)

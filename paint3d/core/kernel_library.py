"""Kernels that were compiled ahead of time: a shared library beside the package.

A wheel contains it, `scripts/install` builds it for a checkout (`python -m tools.kernels`). A
kernel is taken from it only if every source that it was compiled from is unchanged, to the byte;
so after an edit numba compiles the kernels that it affects, and no outdated code is ever run.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib.machinery
import importlib.util
import json
import logging
import os
import pickle
from collections.abc import Callable
from functools import cache, update_wrapper
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from paint3d.core.numba_kernels import DeferredKernel, can_compile

__all__ = ["FOLDER", "INDEX", "Library", "is_unchanged", "library"]

FOLDER = Path(__file__).with_name("machine_code")
INDEX = "index.json"  # written last: the files that it names are complete
FORMAT = 2
_ROOT = Path(__file__).parents[2]

log = logging.getLogger("paint3d")


@cache
def library() -> Library | None:
    """Load the library; None if there is none that this machine can run."""
    try:
        index = json.loads((FOLDER / INDEX).read_text("utf-8"))
        return Library(FOLDER, index) if index["format"] == FORMAT else None
    except FileNotFoundError:
        return None
    except (OSError, ImportError, ValueError, LookupError) as error:
        log.warning("the compiled kernels in %s cannot be used: %s", FOLDER, error)
        return None


class Library:
    """Machine code for one kind of processor, and the extension module that calls it.

    Parameters
    ----------
    folder : Path
    index : dict
        The `INDEX` that `tools.kernels` wrote there.

    Attributes
    ----------
    processor : str
        Such as ``x86-64-v3`` or ``aarch64``.

    Raises
    ------
    LookupError
        There is no code for this processor.
    OSError, ImportError
        A file is missing or cannot be loaded.
    """

    def __init__(self, folder: Path, index: dict[str, Any]) -> None:
        caller = _load_caller(folder / index["caller"])
        processors = caller.processors()  # this one's kinds, the best first
        self.processor = next((name for name in processors if name in index["code"]), "")
        if not self.processor:
            raise LookupError(f"there is none for this processor, {processors[0]}")
        self._code = ctypes.CDLL(os.fspath(folder / index["code"][self.processor]))
        self._kernels: dict[str, Any] = index["kernels"]
        self._sources: list[tuple[str, str]] = index["sources"]
        self.kernel_type = _make_kernel_type(caller.Entry)

    def find(self, function: Callable[..., Any], options: dict[str, Any]) -> Any:
        """Return the compiled kernel, which is called like the function; or None.

        Parameters
        ----------
        function : callable
        options : dict
            Of numba's `njit`, used for arguments of types that it was not compiled for.
        """
        name = f"{function.__module__}.{function.__qualname__}"
        kernel = self._kernels.get(name)
        if kernel is None or not all(is_unchanged(*self._sources[k]) for k in kernel["sources"]):
            return None
        first = None  # of a chain: each entry passes arguments that do not fit to its `other`
        for code in reversed(kernel["codes"]):
            entry = self.kernel_type(
                address=self._address(code["symbol"]),
                release=self._address("paint3d_release"),
                takes=code["takes"].encode(),
                gives=code["gives"].encode(),
                records=tuple(map(_dtype, code["records"])),
                n_takes=code["n_takes"],
                n_gives=code["n_gives"],
            )
            update_wrapper(entry, function)
            entry.expected, entry.options, entry.other = code["expected"], options, first
            first = entry
        return first

    def _address(self, symbol: str) -> int:
        return ctypes.cast(getattr(self._code, symbol), ctypes.c_void_p).value or 0


def _load_caller(path: Path) -> ModuleType:
    loader = importlib.machinery.ExtensionFileLoader("caller", os.fspath(path))
    spec = importlib.util.spec_from_file_location("caller", path, loader=loader)
    assert spec is not None, "the loader is given"
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


@cache
def is_unchanged(path: str, digest: str) -> bool:
    """Return whether a source still has the digest of the one that was compiled."""
    try:
        return hashlib.sha256((_ROOT / path).read_bytes()).hexdigest() == digest
    except OSError:
        return False


def _dtype(record: dict[str, Any]) -> np.dtype[Any]:
    """Make the type of a record from its description in the index."""
    formats = [of if isinstance(of, str) else (of[0], tuple(of[1])) for of in record["formats"]]
    description: Any = {**record, "formats": formats}
    dtype: np.dtype[Any] = np.dtype(description)
    return dtype


def _make_kernel_type(entry: type) -> type:
    """Derive the type of compiled kernels from the extension module's."""

    class LibraryKernel(entry, DeferredKernel):  # type: ignore[misc]
        """A kernel of the library; numba compiles it for other kernels and other arguments."""

        expected: dict[str, Any]
        other: Any  # the same kernel for other types; None for the last

        def _unfit(self, args: tuple[Any, ...], kwargs: dict[str, Any] | None) -> Any:
            """Call a kernel that takes these arguments, as this one does not (from `caller.c`)."""
            if self.other is not None:
                return self.other(*args, **(kwargs or {}))
            if not can_compile():
                raise TypeError(self._say_unfit(args, kwargs or {}))
            return self.jit(*args, **(kwargs or {}))

        def _failed(self, code: int, pickled: bytes) -> None:
            """Raise the error that the kernel ended with (from `caller.c`)."""
            if not pickled:
                raise MemoryError(f"{self.__wrapped__.__qualname__} has no memory ({code})")
            error, args, _ = pickle.loads(pickled)
            raise error(*args)

        def _say_unfit(self, args: tuple[Any, ...], kwargs: dict[str, Any]) -> str:
            name = f"{self.__wrapped__.__module__}.{self.__wrapped__.__qualname__}"
            if kwargs or len(args) != len(self.expected):
                return f"{name} takes {', '.join(self.expected)} in this order, got {len(args)}"
            for (what, expected), value in zip(self.expected.items(), args, strict=True):
                mismatch = _explain_mismatch(what, expected, value)
                if mismatch:
                    return f"{name}: {mismatch}"
            return f"{name}: a number is out of range"

    return LibraryKernel


def _explain_mismatch(name: str, expected: str | dict[str, Any], value: Any) -> str:
    """Say how a value differs from the expected type; "" if it fits."""
    if isinstance(expected, dict):
        if not isinstance(value, tuple) or len(value) != len(expected):
            return f"{name}: expected ({', '.join(expected)}), got {type(value).__name__}"
        parts = zip(expected.items(), value, strict=True)
        return next(
            filter(None, (_explain_mismatch(f"{name}.{k}", e, v) for (k, e), v in parts)), ""
        )
    if "[" not in expected:
        fits = {
            "f8": isinstance(value, float | int | np.integer) and not isinstance(value, bool),
            "f4": isinstance(value, np.float32),
            "i8": isinstance(value, int | np.integer) and not isinstance(value, bool),
            "b1": isinstance(value, bool | np.bool_),
        }[expected]
        return "" if fits else f"{name}: expected {expected}, got {value!r}"
    dtype, _, axes = expected.partition("[")
    wanted = f"{name}: expected a C-contiguous array {expected}"
    if not isinstance(value, np.ndarray):
        return f"{wanted}, got {type(value).__name__}"
    is_known = not dtype.isidentifier() or value.dtype == np.dtype(dtype)
    if (
        value.ndim == axes.count(":")
        and is_known
        and value.flags.c_contiguous
        and value.flags.aligned
    ):
        return ""
    order = "" if value.flags.c_contiguous else ", not contiguous"
    order += "" if value.flags.aligned else ", not aligned"
    return f"{wanted}, got {value.dtype} {value.shape}{order}"

"""Kernels that numba compiles when they are first called, and keeps."""

from __future__ import annotations

import importlib.util
import os
import platform
from collections.abc import Callable
from functools import cache, update_wrapper
from typing import Any

from paint3d.errors import KernelError

__all__ = [
    "ONLY",
    "DeferredKernel",
    "can_compile",
    "compile_with_numba",
    "llvm_name",
    "processor_of",
]

ONLY = "PAINT3D_KERNELS"  # "numba" or "library": take kernels from there or not at all
_LEVEL_3 = {"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"}  # of x86-64
_LEVEL_2 = {"cx16", "popcnt", "sse4.1", "sse4.2", "ssse3"}


def can_compile() -> bool:
    """Whether what is not compiled can be."""
    return os.environ.get(ONLY) != "library" and importlib.util.find_spec("numba") is not None


def compile_with_numba(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Decorate a function with numba's `njit`: it is compiled when it is first called.

    Raises
    ------
    KernelError
        numba is not installed, or is not to be asked.
    """
    if not can_compile():
        name = f"{function.__module__}.{function.__qualname__}"
        raise KernelError(
            f"{name} is not among the compiled kernels, and "
            + (
                f"{ONLY}=library leaves none to numba"
                if os.environ.get(ONLY) == "library"
                else "numba, which would compile it, is not installed: pip install numba"
            )
        )
    _prepare()
    from numba import njit

    return njit(**{"cache": True, "nogil": True, **options})(function)


@cache
def _prepare() -> None:
    """Have numba compile for a kind of processor, as the library is, and drop what is stale.

    Some of the last bits of single hairs rest on which instruction estimates 1/sqrt(x). Code for
    the very processor would take another one where there is AVX-512; so all processors of a kind
    paint the same, with the library and without.
    """
    import numba
    from llvmlite import binding

    config: Any = numba.config  # its own, unknown to types
    if config.CPU_NAME is None:
        has = {name for name, on in binding.get_host_cpu_features().items() if on}
        processor = processor_of(platform.machine(), has)
        if processor:
            config.CPU_NAME, config.CPU_FEATURES = llvm_name(processor), ""  # what all of them have
            os.environ["NUMBA_CPU_NAME"] = config.CPU_NAME  # numba reads it again, at times
            os.environ["NUMBA_CPU_FEATURES"] = config.CPU_FEATURES
    from paint3d.core.compile_cache import drop_stale

    drop_stale()  # before the first is loaded


def processor_of(machine: str, features: set[str]) -> str:
    """The best kind of processor that code is made for, by what one has; "" for none.

    Parameters
    ----------
    machine : str
        As `platform.machine` says it.
    features : set of str
        As LLVM names them.
    """
    if machine in ("aarch64", "arm64"):
        return "aarch64"
    if machine not in ("x86_64", "AMD64") or not features >= _LEVEL_2:
        return ""
    return "x86-64-v3" if features >= _LEVEL_3 else "x86-64-v2"


def llvm_name(processor: str) -> str:
    """What LLVM calls a kind of processor."""
    return "generic" if processor == "aarch64" else processor


class DeferredKernel:
    """A kernel for which numba is not imported before it is called or looked into."""

    __wrapped__: Callable[..., Any]
    options: dict[str, Any]
    _jit: Any = None

    @classmethod
    def of(cls, function: Callable[..., Any], options: dict[str, Any]) -> DeferredKernel:
        """The kernel of a function."""
        kernel = cls()
        update_wrapper(kernel, function)
        kernel.options = options
        return kernel

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Compile and call it."""
        return self.jit(*args, **kwargs)

    @property
    def jit(self) -> Any:
        """The same as numba's dispatcher."""
        if self._jit is None:
            self._jit = compile_with_numba(self.__wrapped__, self.options)
        return self._jit

    @property
    def py_func(self) -> Callable[..., Any]:
        """The function as it is written."""
        return self.__wrapped__

    @property
    def _numba_type_(self) -> Any:
        """What it is to a kernel that calls it and is compiled by numba."""
        return self.jit._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.jit, name)

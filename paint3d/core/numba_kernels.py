"""Kernels that numba compiles at their first call, and caches."""

from __future__ import annotations

import importlib.util
import os
import platform
from collections.abc import Callable
from functools import cache, update_wrapper
from typing import Any

from paint3d.errors import KernelError

__all__ = [
    "APART",
    "ONLY",
    "DeferredKernel",
    "can_compile",
    "compile_with_numba",
    "llvm_name",
    "processor_of",
]

ONLY = "PAINT3D_KERNELS"  # "numba" or "library": the only source of kernels
APART = "apart"  # the option that numba's `njit` does not know: see `paint3d.core.kernel.uncounted`
_LEVEL_3 = {"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"}  # of x86-64
_LEVEL_2 = {"cx16", "popcnt", "sse4.1", "sse4.2", "ssse3"}


def can_compile() -> bool:
    """Return whether numba may and can compile kernels."""
    return os.environ.get(ONLY) != "library" and importlib.util.find_spec("numba") is not None


def compile_with_numba(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Decorate a function with numba's `njit`: it is compiled when it is first called.

    Raises
    ------
    KernelError
        If numba is not installed, or `ONLY` excludes it.
    """
    if not can_compile():
        name = f"{function.__module__}.{function.__qualname__}"
        if os.environ.get(ONLY) == "library":
            raise KernelError(
                "{kernel} is not among the compiled kernels, and {setting} leaves none to numba",
                kernel=name,
                setting=f"{ONLY}=library",
            )
        raise KernelError(
            "{kernel} is not among the compiled kernels, and numba, which would compile it, is not "
            "installed",
            kernel=name,
            hint="pip install numba",
        )
    _prepare()
    from numba import njit

    known = {name: value for name, value in options.items() if name != APART}
    return njit(**{"cache": True, "nogil": True, **known})(function)


@cache
def _prepare() -> None:
    """Make numba compile for a kind of processor, like the library, and drop stale code.

    Some last bits of single hairs depend on the instruction that estimates 1/sqrt(x). Code for the
    exact processor would use another one where there is AVX-512; compiled for its kind, all
    processors of a kind paint the same, with the library and without.
    """
    import numba
    from llvmlite import binding

    config: Any = numba.config  # untyped attributes
    if config.CPU_NAME is None:
        has = {name for name, on in binding.get_host_cpu_features().items() if on}
        processor = processor_of(platform.machine(), has)
        if processor:
            config.CPU_NAME = llvm_name(processor)
            config.CPU_FEATURES = ""  # only those that all of the kind have
            os.environ["NUMBA_CPU_NAME"] = config.CPU_NAME  # numba may read it again
            os.environ["NUMBA_CPU_FEATURES"] = config.CPU_FEATURES
    from paint3d.core.compile_cache import drop_stale

    drop_stale()  # before the first kernel is loaded


def processor_of(machine: str, features: set[str]) -> str:
    """Return the best kind of processor that code is made for, by its features; "" for none.

    Parameters
    ----------
    machine : str
        As given by `platform.machine`.
    features : set of str
        By their names in LLVM.
    """
    if machine in ("aarch64", "arm64"):
        return "aarch64"
    if machine not in ("x86_64", "AMD64") or not features >= _LEVEL_2:
        return ""
    return "x86-64-v3" if features >= _LEVEL_3 else "x86-64-v2"


def llvm_name(processor: str) -> str:
    """Return LLVM's name for a kind of processor."""
    return "generic" if processor == "aarch64" else processor


class DeferredKernel:
    """A kernel that imports numba only when it is called or inspected."""

    __wrapped__: Callable[..., Any]
    options: dict[str, Any]
    _jit: Any = None

    @classmethod
    def of(cls, function: Callable[..., Any], options: dict[str, Any]) -> DeferredKernel:
        """Make the kernel of a function."""
        kernel = cls()
        update_wrapper(kernel, function)
        kernel.options = options
        return kernel

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Compile and call it."""
        return self.jit(*args, **kwargs)

    @property
    def jit(self) -> Any:
        """numba's dispatcher of the function."""
        if self._jit is None:
            self._jit = compile_with_numba(self.__wrapped__, self.options)
        return self._jit

    @property
    def py_func(self) -> Callable[..., Any]:
        """The Python function."""
        return self.__wrapped__

    @property
    def _numba_type_(self) -> Any:
        """numba's type of it, for kernels that call it."""
        return self.jit._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.jit, name)

"""Where a kernel's machine code comes from: the library that was built ahead, else numba."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from paint3d.core.kernel_library import library
from paint3d.core.numba_kernels import ONLY, DeferredKernel, compile_with_numba

__all__ = ["compiled", "is_ahead", "is_compiled"]


def compiled(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """What is called in a function's place; `options` are those of numba's `njit`."""
    ahead = None if os.environ.get(ONLY) == "numba" else library()
    if ahead is None:
        return compile_with_numba(function, options)
    return ahead.find(function, options) or DeferredKernel.of(function, options)


def is_ahead(kernel: Any) -> bool:
    """Whether a kernel is taken from the library, so that calling it costs no more at first."""
    ahead = library()
    return ahead is not None and isinstance(kernel, ahead.kernel_type)


def is_compiled(kernel: Any) -> bool:
    """Whether a kernel can be called without being compiled first.

    Raises
    ------
    KernelError
        It never can: it is not in the library, and numba is not installed.
    """
    if is_ahead(kernel):
        return True
    by_numba = getattr(kernel, "jit", kernel)  # or an error that says that there is none
    from paint3d.core.compile_cache import is_kept

    return is_kept(by_numba)

"""Where a kernel's machine code comes from: the library that was built ahead, else numba."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from paint3d.core.kernel_library import library
from paint3d.core.numba_kernels import ONLY, DeferredKernel, compile_with_numba

__all__ = ["compiled", "is_compiled"]


def compiled(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """What is called in a function's place; `options` are those of numba's `njit`."""
    ahead = None if os.environ.get(ONLY) == "numba" else library()
    if ahead is None:
        return compile_with_numba(function, options)
    return ahead.find(function, options) or DeferredKernel.of(function, options)


def is_compiled(kernel: Any) -> bool:
    """Whether a kernel can be called without being compiled first."""
    ahead = library()
    if ahead is not None and isinstance(kernel, ahead.kernel_type):
        return True
    from paint3d.core.compile_cache import is_kept

    return is_kept(kernel)

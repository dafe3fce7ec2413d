"""The decorators of every hot loop: compiled, and run without the interpreter's lock.

Kernels are written in numba's subset of Python. Those that Python calls were compiled when the
package was built; numba compiles those that are missing or have changed since: see `compiled`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from paint3d.core.kernel_library import library
from paint3d.core.numba_kernels import ONLY, DeferredKernel, compile_with_numba

__all__ = ["compiled", "is_ahead", "is_compiled", "kernel", "uncounted"]

# ---- Where machine code comes from ---------------------------------------------------------------
# The library that was built ahead of time, or else numba.


def compiled(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return the compiled kernel of a function; `options` are those of numba's `njit`."""
    ahead = None if os.environ.get(ONLY) == "numba" else library()
    if ahead is None:
        return compile_with_numba(function, options)
    return ahead.find(function, options) or DeferredKernel.of(function, options)


def is_ahead(kernel: Any) -> bool:
    """Return whether a kernel comes from the library, so that its first call compiles nothing."""
    ahead = library()
    return ahead is not None and isinstance(kernel, ahead.kernel_type)


def is_compiled(kernel: Any) -> bool:
    """Return whether a kernel can be called without being compiled first.

    Raises
    ------
    KernelError
        If it is not in the library and numba is not installed.
    """
    if is_ahead(kernel):
        return True
    by_numba = getattr(kernel, "jit", kernel)  # raises KernelError without numba
    from paint3d.core.compile_cache import is_kept

    return is_kept(by_numba)


# ---- Decorators ----------------------------------------------------------------------------------


def kernel(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function when it is first called with arguments of new types.

    Parameters
    ----------
    function : callable
        In numba's subset of Python.
    **options
        Of numba's `njit`: ``error_model="numpy"`` (dividing by zero gives inf), ``inline``,
        ``fastmath``.
    """
    return _decorate(function, {"_nrt": True, **options})


def uncounted(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function without reference counts of the arrays that it takes.

    numba counts references to every array of every named tuple that a kernel takes, up at its
    beginning and down at its end, with a locked instruction each. Painting calls a dozen kernels
    for a footprint, and the surface and the scratch arrays are a hundred: some three thousand such
    instructions, a quarter of the time. The caller holds the arrays anyway.

    Such a kernel must not allocate arrays (nor assign one to a slice of another, which may raise
    an error with a text) nor return any: one that does, and is called by such a kernel, is a
    `kernel`. Options as there, and ``forceinline`` for a function called in one place: passing a
    hundred arrays, each with its shape and strides, takes half a microsecond. But its code, and
    the time to compile it, are added to its caller's.

    ``apart`` promises that no array which it writes shares memory with another that it takes.
    LLVM cannot see how far look-ups reach, so without the promise a loop that looks up and writes
    stays scalar. Kernels of the library are compiled by it; bytes are the same without.
    """
    return _decorate(function, {"_nrt": False, **options})


def _decorate(function: Callable[..., Any] | None, options: dict[str, Any]) -> Any:
    if function is not None:
        return compiled(function, options)
    return lambda function: compiled(function, options)

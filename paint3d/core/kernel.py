"""The decorators of every hot loop: compiled, and run without the interpreter's lock.

Kernels are written in numba's subset of Python. Those that Python calls were compiled when the
package was built; numba compiles what is not there, or has changed since: see `compiled`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from paint3d.core.kernel_library import library
from paint3d.core.numba_kernels import ONLY, DeferredKernel, compile_with_numba

__all__ = ["compiled", "is_ahead", "is_compiled", "kernel", "uncounted"]

# ---- Where machine code comes from ---------------------------------------------------------------
# Where a kernel's machine code comes from: the library that was built ahead, else numba.


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


# --------------------------------------------------------------------------------------------------


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
    """Compile a function without counting who holds the arrays that it is handed.

    numba counts references to every array of every named tuple that a kernel is handed, up at its
    beginning and down at its end, with a locked instruction each. Painting calls a dozen kernels
    for a footprint, and the surface and the scratch arrays are a hundred: some three thousand such
    instructions, a quarter of the time. Whoever calls holds the arrays anyway.

    A kernel compiled so may make no arrays (nor assign one to a slice of another, which may raise
    an error with a text), and return none: one that does, and is called by such a kernel, is a
    `kernel`. Options as there, and ``forceinline`` for what is called in one place: handing over
    a hundred arrays, each with its shape and strides, takes half a microsecond. But whatever calls
    it is as much larger, and compiled as much longer.
    """
    return _decorate(function, {"_nrt": False, **options})


def _decorate(function: Callable[..., Any] | None, options: dict[str, Any]) -> Any:
    if function is not None:
        return compiled(function, options)
    return lambda function: compiled(function, options)

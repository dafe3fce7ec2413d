"""The kinds of processor that code is made for."""

from __future__ import annotations

import platform
import sys

__all__ = ["ARCHITECTURES", "architecture_of", "made_for", "own_least", "own_processor"]

ARCHITECTURES = {
    "x86_64": ("x86-64-v2", "x86-64-v3", "x86-64-v4"),
    "aarch64": ("aarch64",),
    "wasm32": ("wasm32",),
}
"""The processors of each, the least first, as `paint3d.core.kernel_library` names them; wasm32 is
WebAssembly with its vectors of 128 bits, for pages."""


def architecture_of(processor: str) -> str:
    """The architecture of a processor, as compilers name it."""
    return next(name for name, some in ARCHITECTURES.items() if processor in some)


_WIDE = "x86-64-v4"
_LEVEL_4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}


def made_for(processor: str, modules: set[str]) -> str:
    """The kind that a group of entries, from these modules, is made for in a processor's library.

    Of single hairs AVX-512 would change last bits (its estimate of 1/sqrt(x) is another one), and
    elsewhere there is little that gains by it: only strokes of solid tufts use it.
    """
    is_wide = "brush_engine.stroke_loop" in modules
    return processor if processor != _WIDE or is_wide else "x86-64-v3"


def own_least() -> str:
    """The least kind of processor of this machine's architecture, on Linux."""
    return ARCHITECTURES[platform.machine()][0]


def own_processor() -> str:
    """The best kind that this machine is; "" where none is, or it does not run Linux."""
    from llvmlite import binding

    from paint3d.core.numba_kernels import processor_of

    has = {name for name, on in binding.get_host_cpu_features().items() if on}
    if sys.platform != "linux":
        return ""
    best = processor_of(platform.machine(), has)
    return _WIDE if best == "x86-64-v3" and has >= _LEVEL_4 else best

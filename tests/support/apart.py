"""``python -m tests.support.apart HAIRS``: paint with kernels that check arrays for overlap.

A stroke is painted by the brush engine's kernels in plain Python. Those that promise that their
arrays lie apart look whether they do. Prints their names, those that have been called.
"""

from __future__ import annotations

import functools
import itertools
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

_PLAIN = (
    "paint3d.brush_engine",
    "paint3d.core.quaternion",
    "paint3d.mesh.kernels.mesh_arrays",
    "paint3d.pose.kernels",
)
_TABLES = {"tabulate_bending", "tabulate_spheres", "fill_noise"}  # made once, and long
called: set[str] = set()


def arrays_in(value: Any, name: str) -> Iterator[tuple[str, np.ndarray]]:
    """Yield all arrays of an argument, with their names."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        for of, part in zip(getattr(value, "_fields", range(len(value))), value, strict=True):
            yield from arrays_in(part, f"{name}.{of}")


def looking(function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function to assert first that its arrays do not overlap."""
    code = function.__code__
    names = code.co_varnames[: code.co_argcount]

    @functools.wraps(function)
    def look(*args: Any) -> Any:
        called.add(f"{function.__module__}.{function.__name__}")
        arrays = [a for name, arg in zip(names, args, strict=True) for a in arrays_in(arg, name)]
        for (one, a), (other, b) in itertools.combinations(arrays, 2):
            assert not np.shares_memory(a, b), f"{function.__name__}: {one} and {other} overlap"
        return function(*args)

    return look


class Record(np.void):
    """A record whose fields are attributes, as kernels have it."""

    def __getattribute__(self, name: str) -> Any:
        fields = np.void.__getattribute__(self, "dtype").fields
        return self[name] if name in fields else np.void.__getattribute__(self, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value


def paint_plainly(hairs: int) -> None:
    """Paint a short stroke that turns, over a plane, with a wet brush and with a dry one."""
    from paint3d.core import kernel

    compiled, zeros = kernel.compiled, np.zeros

    def plain(function: Callable[..., Any], options: dict[str, Any]) -> Any:
        if function.__module__.startswith(_PLAIN) and function.__name__ not in _TABLES:
            return looking(function) if options.get("apart") else function
        return compiled(function, options)

    def zeros_of_records(shape: Any, dtype: Any = float, **options: Any) -> np.ndarray:
        kind = np.dtype(dtype)
        return zeros(shape, np.dtype((Record, kind)) if kind.names else kind, **options)

    kernel.compiled, np.zeros = plain, zeros_of_records  # type: ignore[assignment]
    from paint3d.brush_engine.bristles import state
    from paint3d.device.recorded import Recording
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.painter import Painter
    from paint3d.surface.painted_surface import PaintedSurface

    state.MEMORY = np.dtype((Record, state.MEMORY))
    t = np.linspace(0.0, 1.0, 3)
    position = np.stack([4.0 * t - 2.0, t * t, 30.0 + 0.0 * t], axis=1)
    orientation = np.stack([np.cos(0.2 * t), 0.0 * t, 0.0 * t, np.sin(0.2 * t)], axis=1)
    time_ns = (t * 1.2e8).astype(np.int64)
    stroke = Recording(time_ns, position, orientation, 0.0 * t + 0.8)
    narrow = Recording(time_ns, position, orientation, 0.0 * t + 0.1)
    corners = [[-40.0, -40.0, 0.0], [40.0, -40.0, 0.0], [40.0, 40.0, 0.0], [-40.0, 40.0, 0.0]]
    plane = TriangleMesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]], np.int32))

    def painter_on(resolution: float) -> Painter:
        surface = PaintedSurface(plane, resolution, "plaster")
        surface.refine_all()  # by the compiled kernels
        transfer = surface.ink.transfer
        surface.ink = surface.ink._replace(transfer=transfer.view((Record, transfer.dtype)))
        return Painter(surface, "full", hairs=hairs)

    fine = painter_on(0.6)  # whose cells lie within an outline
    fine.replay(Recording(time_ns[:2] // 8, position[:2], orientation[:2], 0.0 * t[:2] + 0.8))
    painter = painter_on(1.2)
    surface = painter.surface
    painter.replay(stroke)
    painter.replay(narrow)
    surface.ink.amounts[:] *= 0.1  # as where it has dried
    painter.replay(stroke)
    painter.fill_to(0.05)
    painter.replay(stroke)
    assert np.count_nonzero(surface.coverage) > 20


if __name__ == "__main__":
    paint_plainly(int(sys.argv[1]))
    sys.stdout.write("\n".join(sorted(called)))

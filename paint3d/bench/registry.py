"""The benchmarks by name; each is loaded when it runs."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module

from paint3d.bench.result import Result
from paint3d.bench.stopwatch import load_average, watch_steal
from paint3d.errors import InputError, UnknownNameError

__all__ = ["BENCHMARKS", "run_benchmark"]

BENCHMARKS: dict[str, tuple[str, str]] = {
    "replay": ("replaying.measure", "the demo on a bowl of a million vertices, against the hand"),
    "scaling": ("dabs.measure_scaling", "a footprint's cost at 100 thousand to 4 million vertices"),
    "dab": ("dabs.measure", "a whole dab over 2,000 and 20,000 vertices, and pen-down"),
    "kernel": ("gathering.measure", "gather, project, deposit against SciPy and NumPy"),
    "memory": ("processes.measure_memory", "memory of a painting on 4 million vertices"),
    "import": ("processes.measure_import", "starting, in a new process"),
    "start": ("start.measure", "how long one waits: commands and the studio, first and again"),
    "haptics": ("haptics.measure", "the force servo's beat and round trip beside a busy program"),
    "bristles": ("bristles.measure", "bending 1 to 10,000 hairs, on a plane and on a curved patch"),
    "colours": ("colouring.measure", "vertex colours a second"),
    "studio": ("studio.measure", "the studio's picture beside its painting thread"),
    "wet": ("wet.measure", "strokes on paper while their ink spreads, against the hand"),
    "files": ("files.measure", "exporting a million triangles in every format"),
}
"""Name: (where its function is, what it measures)."""


def run_benchmark(name: str, scale: float = 1.0) -> Result:
    """Run one benchmark.

    Parameters
    ----------
    name : str
        A key of `BENCHMARKS`.
    scale : float
        Of the full size, above 0 and at most 1; bounds are meant for the full size.

    Raises
    ------
    UnknownNameError
        For a name that is not a benchmark's.
    InputError
        For a scale out of range.
    Paint3DError
        If a process that a benchmark starts fails.
    """
    if name not in BENCHMARKS:
        raise UnknownNameError("benchmark", name, BENCHMARKS)
    if not 0.0 < scale <= 1.0:
        raise InputError("scale is {scale:g}; expected above 0, and at most 1", scale=scale)
    module, function = BENCHMARKS[name][0].split(".")
    measure: Callable[[float], Result] = getattr(import_module(f"paint3d.bench.{module}"), function)
    before, steal = load_average(), watch_steal()
    result = measure(scale)
    load = f"Load average {before} before, {load_average()} after, on {os.cpu_count()} cores"
    lost = steal()
    load += "." if lost is None else f", of which the host gave {100.0 * lost:.0f} % to others."
    return replace(result, notes=[*result.notes, load])

"""Vertex colours a second: the live path with one and three pigments, and all 31 bands."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from paint3d.bench.result import Result
from paint3d.bench.stopwatch import alternate
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import load_palette
from paint3d.colour.vertex_colours import ColourModel

__all__ = ["measure"]

_VERTICES = 1_000_000
_ROUNDS = 7
_SEED = 1


def measure(scale: float = 1.0) -> Result:
    """Colour a million painted vertices by every path; they take turns."""
    n = max(1000, int(_VERTICES * scale))
    random = np.random.default_rng(_SEED)
    pigments = list(load_palette().values())[:3]
    backing = load_material("porcelain").reflectance
    coverage = random.random(n, dtype=np.float32)
    out = np.zeros((n, 3), np.uint8)
    ids = np.arange(n, dtype=np.int32)
    paths: tuple[tuple[Literal["live", "reference"], int], ...]
    paths = (("live", 1), ("live", 3), ("reference", 1), ("reference", 3))
    competitors: dict[str, Callable[[], object]] = {}
    for path, count in paths:
        model = ColourModel(pigments[:count], backing, path=path)
        amounts = coverage[:, None] * random.random((n, count), dtype=np.float32)
        competitors[f"{path} {count}"] = partial(model.srgb, amounts, coverage, out, ids)
    for colour in competitors.values():
        colour()
    times = alternate(_ROUNDS, competitors)
    rows = [
        [path, count, 31 if path == "reference" else ("table" if count == 1 else 12),
         n / times[f"{path} {count}"].wall_s / 1e6, n / times[f"{path} {count}"].cpu_s / 1e6]
        for path, count in paths
    ]  # fmt: skip
    return Result(
        f"Colours of {n:,} vertices in order",
        ["path", "pigments", "bands", "million/s", "million/CPU s"],
        rows,
    )

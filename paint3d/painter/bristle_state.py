"""State of a painter's single hairs: the ink in each, and the tuft's memory."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from paint3d.brush.bristles import build_bristles
from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.brush_engine.bristles.ink_transfer import sum_hairs
from paint3d.brush_engine.bristles.state import MEMORY_SIZE, SPLIT, WAY, Hairs, make_hairs
from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["HairTuft", "complete_memory"]


def complete_memory(memory: AnyArray) -> AnyArray:
    """Append a closed split to a memory saved before the split was stored."""
    return np.append(memory, 0.0) if len(memory) == MEMORY_SIZE - 1 else memory


class HairTuft:
    """A tuft of single hairs (B) with ink (P pigments) in each.

    Parameters
    ----------
    brush : BrushSpec
    hairs : BristleSpec

    Attributes
    ----------
    load : (B, P) float64
        Ink in each hair, coats x mm2.
    memory : (6,) float64
        See `brush_engine.bristles.state`: the remaining bend, how far clumps have parted, and
        path lengths.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """

    def __init__(self, brush: BrushSpec, hairs: BristleSpec) -> None:
        self.spec = hairs
        self.bristles = build_bristles(brush, hairs)
        self.load = np.zeros((hairs.n_hairs, 0))
        self.memory = np.zeros(MEMORY_SIZE)
        self._work: Hairs | None = None

    def shape(self) -> None:
        """Bring the tuft to a point: straighten it and join its clumps."""
        self.memory[:WAY] = 0.0
        self.memory[SPLIT] = 0.0

    def dip(self, load: AnyArray, full: float, reach: float = 1.0) -> None:
        """Distribute the tuft's load (P,) over the hairs after a dip.

        The lower fraction `reach` of each hair is full, `full` being the load of a full tuft, coats
        x mm2; above, a hair keeps its own. The surface's reservoirs say which ink lies where along
        them.
        """
        self._add_pigments(len(load))
        self.memory[WAY:] = 0.0
        if reach >= 1.0:
            self.load[:] = load / len(self.load)
            return
        own = (1.0 - reach) * self.load.sum(axis=1) + reach * full / len(self.load)
        self.load[:] = own[:, None] * load / max(own.sum(), 1e-300)

    def total(self) -> AnyArray:
        """Sum the ink of all hairs (P,)."""
        total = np.empty(self.load.shape[1])
        sum_hairs(self.load, total)  # the kernels' order of summation, to the bit
        return total

    def rescale(self, load: AnyArray) -> None:
        """Rescale the hairs' ink to the total `load` (P,), each keeping its fraction of it."""
        self._add_pigments(len(load))
        total = self.total()
        for p in np.flatnonzero(total != load):
            if total[p] > 0.0:
                self.load[:, p] *= load[p] / total[p]
            else:
                self.load[:, p] = load[p] / len(self.load)

    def _add_pigments(self, n_pigments: int) -> None:
        """Grow `load` to at least this many columns."""
        missing = n_pigments - self.load.shape[1]
        if missing > 0:
            self.load = np.pad(self.load, ((0, 0), (0, missing)))

    def keep(self) -> dict[str, AnyArray]:
        """Snapshot, for `restore`, the ink of every hair and the tuft's memory."""
        return {"load": self.load.copy(), "memory": self.memory.copy()}

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Return to a snapshot of `keep`."""
        self.load = kept["load"].copy()
        self.memory[:] = kept["memory"]
        self._work = None

    def work(self, surface: PaintedSurface) -> Hairs:
        """Return the arrays for the kernels, first matching the load to the surface's."""
        ink = surface.ink
        if self.load.shape[1] != len(ink.load) or (self.total() != ink.load).any():
            self.rescale(ink.load)
            ink.load[:] = self.total()
        work = self._work
        if work is None or work.load is not self.load:
            new = make_hairs(self.bristles, self.load, self.memory)
            if work is not None and work.load.shape == self.load.shape:  # a stroke goes on
                for name in ("pace", "roll", "turned", "track"):
                    getattr(new, name)[:] = getattr(work, name)
            work = new
        self._work = work
        return work

"""Water on a surface, and the ink that it has not heard of yet."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from paint3d.core.types import AnyArray
from paint3d.surface.flow import Flow
from paint3d.surface.ink_store import InkStore
from paint3d.surface.vertex_sets import union

__all__ = ["Water"]


class Water:
    """The water on the layer that is painted on; there is none until it is asked for.

    Parameters
    ----------
    store : InkStore

    Attributes
    ----------
    fresh : list of (N,) int32, or None
        Vertices whose ink may have changed since the water was told; None while there is none.
    """

    def __init__(self, store: InkStore) -> None:
        self._store = store
        self._flow: Flow | None = None
        self._still: Flow | None = None  # one that was dropped: its graph may serve again
        self.fresh: list[AnyArray] | None = None

    @property
    def flow(self) -> Flow:
        """The water and its way, from the first time that it is asked for."""
        if self._flow is None:
            self._flow, self._still = self._still or Flow(self._store), None
            self._flow.clear()
            self.fresh = [np.flatnonzero(self._store.coverage > 0.0).astype(np.int32)]
        return self._flow

    @property
    def patience(self) -> float:
        """Time that may pass before there is anything to do, s; infinite if all is dry."""
        n_dirty = self._store.ink.n_dirty[0]
        if self._flow is None:
            return 0.0 if n_dirty or self._store.coverage.any() else np.inf
        is_fresh = n_dirty > 0 or any(len(ids) for ids in self.fresh or ())
        return 0.0 if is_fresh else self._flow.patience

    def depths(self) -> tuple[AnyArray, AnyArray] | None:
        """Vertices (C,) int32 and the depth of water on each, mm; None where there is none."""
        if self._flow is None or not self._flow.is_wet:
            return None
        return self._flow.depths()

    def advance(self, seconds: float, step: float | None) -> None:
        """See `Flow.advance`."""
        self.flow.advance(seconds, step, self._take_fresh())

    def follow(self, seconds: float, most_nodes: int) -> bool:
        """See `Flow.follow`."""
        keeps_up = self.flow.follow(seconds, self._take_fresh(), most_nodes)
        self.fresh = [*(self.fresh or ()), self.flow.waiting]
        return keeps_up

    def keep(self) -> dict[str, AnyArray] | None:
        """What `restore` takes, or None where no water has ever moved.

        Besides what `Flow.keep` says, fresh (N,) int32: vertices whose ink came since.
        """
        if self._flow is None:
            return None
        fresh = [*(self.fresh or ()), self._dirty()]
        return {**self._flow.keep(), "fresh": union(fresh, self._store.paint_mesh.capacity)}

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Go on as on the surface that it was kept from."""
        kept, count = dict(kept), len(self._store.pigments)
        for name in ("pigment", "fine", "written"):  # pigments may have come since
            missing = count - kept[name].shape[1]
            kept[name] = np.pad(kept[name], ((0, 0), (0, missing)))
        self.flow.restore(kept)
        self.fresh = [kept["fresh"]]

    def drop(self) -> None:
        """Let there be none in motion."""
        self._still = self._flow or self._still
        self._flow, self.fresh = None, None

    def _take_fresh(self) -> AnyArray:
        """Vertices (N,) int32 whose ink may have changed since the water was told."""
        fresh = [*(self.fresh or ()), self._dirty()]
        self.fresh = []
        return np.concatenate(fresh)

    def _dirty(self) -> AnyArray:
        ink = self._store.ink
        return ink.dirty_ids[: int(ink.n_dirty[0])]

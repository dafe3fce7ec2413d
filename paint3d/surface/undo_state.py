"""The steps of an `UndoHistory` as plain arrays, numbers and words; `undo_reading` takes them back.

What is written are deltas as `packed_delta` has them, one column for each of their arrays, and the
layers that are not there now but come back with a step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from paint3d.colour.spectra import N_BANDS
from paint3d.core.types import AnyArray
from paint3d.mesh.refinement_log import saved_ids
from paint3d.surface.delta import BrushLoad
from paint3d.surface.layer_stack import StackState
from paint3d.surface.packed_delta import PackedDelta, PackedFlow
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.ragged import pack_arrays
from paint3d.surface.state import BRUSH_TRANSFER, layer_state
from paint3d.surface.undo import Painting, Step, UndoHistory

__all__ = ["OVER", "UNDO_VERSION", "SavedSteps", "undo_state"]

UNDO_VERSION = 1
_STEP_BYTES = 1000  # about what a step takes besides its vertices
OVER = ("dry_low", "dry_middle", "dry_high")
"""Columns of what dried rows show over the grounds of `colour.kernels.layering`."""

State = dict[str, Any]


@dataclass(frozen=True)
class SavedSteps:
    """Steps as a file holds them.

    Attributes
    ----------
    state : dict
        See `undo_state`.
    done, undone : sequence
        Labels of the steps that are in it, as `UndoHistory` has them.
    kept : sequence
        What the painter remembered, for each of the K paintings in order.
    """

    state: State
    done: Sequence[object]
    undone: Sequence[object]
    kept: Sequence[Any]


def undo_state(surface: PaintedSurface, history: UndoHistory, most_bytes: int) -> SavedSteps:
    """Return the steps that are nearest to now and fit into so many bytes.

    Parameters
    ----------
    surface : PaintedSurface
        As the history has left it.
    history : UndoHistory
    most_bytes : int

    Returns
    -------
    SavedSteps
        Its state holds version; done and undone, how many steps; of the S steps (those done,
        what came since one was undone, those undone) parts (S,) int32, how many parts; of the Q
        parts stack (Q,) int32, which of the `stacks` it is, or -1 for a painting; stacks, lists
        of layers and the one painted on, layers by their places now and above these by their
        places in layers, which says of those that are not there now what `surface_state` says of
        the others, with gone0_ and so on before the names of what is on them. Of the K paintings
        there are the columns (`ragged`) vertices, amounts, coverage, dry_... and stations, and
        dry_count (K,) int32, load and off_surface (K, P) and habit (K, 3) float64, flow (K,)
        int32, which of the F flows, or -1; of these flow_rows, flow_size (F,) int32, and the
        columns flow_... of `surface_state`.
    """
    chosen = _nearest(history, most_bytes)
    steps = [*chosen.done, chosen.since, *reversed(chosen.undone)]
    parts = [part for step in steps for part in step.parts]
    keys = _keys(surface, parts)
    stacks = [part for part in parts if isinstance(part, StackState)]
    kinds = np.full(len(parts), -1, np.int32)
    kinds[[isinstance(part, StackState) for part in parts]] = np.arange(len(stacks))
    deltas = [chosen.packed[id(part)] for part in parts if isinstance(part, Painting)]
    state = {
        "version": UNDO_VERSION,
        "done": len(chosen.done),
        "undone": len(chosen.undone),
        "stacks": [[[keys[k] for k in one.keys], keys[one.active]] for one in stacks],
        "parts": np.array([len(step.parts) for step in steps], np.int32),
        "stack": kinds,
        **_columns(deltas, len(surface.pigments)),
        **_gone_layers(surface, keys),
    }
    return SavedSteps(
        state,
        [step.label for step in chosen.done],
        [step.label for step in reversed(chosen.undone)],
        [part.kept for part in parts if isinstance(part, Painting)],
    )


@dataclass
class _Chosen:
    done: list[Step]
    since: Step
    undone: list[Step]  # the next one first
    packed: dict[int, PackedDelta]


def _nearest(history: UndoHistory, most_bytes: int) -> _Chosen:
    """The steps that fit, those that are done before those that were undone."""
    done, since, undone = history.steps()
    flows: dict[int, PackedFlow] = {}
    packed: dict[int, PackedDelta] = {}
    seen: set[int] = set()
    left = most_bytes

    def fits(step: Step) -> bool:
        nonlocal left
        own = {}
        for place, part in enumerate(step.parts):
            left -= _STEP_BYTES
            if not isinstance(part, Painting):
                continue
            delta = history.packed(step, place, flows)
            own[id(step.parts[place])] = delta
            left -= delta.n_bytes
            if delta.flow is not None and id(delta.flow) in seen:
                left += delta.flow.n_bytes
            seen.add(id(delta.flow))
        packed.update(own)
        return left >= 0

    if not fits(since):
        return _Chosen([], Step(None, 0), [], {})
    near_done = _while(fits, reversed(done))
    near_undone = _while(fits, reversed(undone)) if len(near_done) == len(done) else []
    return _Chosen(near_done[::-1], since, near_undone, packed)


def _while(fits: Callable[[Step], bool], steps: Iterator[Step]) -> list[Step]:
    found = []
    for step in steps:
        if not fits(step):
            break
        found.append(step)
    return found


def _keys(surface: PaintedSurface, parts: Sequence[object]) -> dict[int, int]:
    """Numbers of the layers in a file: by place, then of those that are not there now."""
    now = surface.layers.state().keys if surface.layers is not None else ()
    named = (key for part in parts if isinstance(part, StackState) for key in part.keys)
    return {key: k for k, key in enumerate(dict.fromkeys([*now, *named]))}


def _gone_layers(surface: PaintedSurface, keys: Mapping[int, int]) -> State:
    """What is on the layers that are not there now."""
    stack = surface.layers
    state: State = {"layers": []}
    if stack is None or len(keys) == len(stack):
        return state
    now, ids = stack.state(), saved_ids(surface.paint_mesh)
    for k, key in enumerate([key for key in keys if key not in now.keys]):
        stack.put(StackState((*now.keys, key), key))
        state["layers"].append(asdict(stack.layers[-1]))
        state |= {f"gone{k}_{name}": value for name, value in layer_state(surface, ids).items()}
    stack.put(now)
    return state


def _columns(deltas: Sequence[PackedDelta], n_pigments: int) -> State:
    """The arrays of K deltas."""
    p = (n_pigments,)
    state: State = {
        **pack_arrays("vertices", [d.vertex_ids for d in deltas], np.int32),
        **pack_arrays("amounts", [_wide(d.amounts, *p) for d in deltas], np.float32, p),
        **pack_arrays("coverage", [d.coverage for d in deltas], np.float32),
        "dry_count": np.array([d.dry.count for d in deltas], np.int32),
        **pack_arrays("dry_rows", [d.dry.rows for d in deltas], np.int32),
        **pack_arrays("dry_vertices", [d.dry.vertex_ids for d in deltas], np.int32),
        **pack_arrays("dry_spectra", [d.dry.spectra for d in deltas], np.uint16, (N_BANDS,)),
        **pack_arrays("dry_amounts", [_wide(d.dry.amounts, *p) for d in deltas], np.float32, p),
        **pack_arrays("dry_share", [d.dry.share for d in deltas], np.float32),
        **pack_arrays("stations", [_wide(d.brush.reservoirs, *p) for d in deltas], np.float64, p),
        "load": _rows([_wide(d.brush.load[None], *p) for d in deltas], n_pigments),
        "off_surface": _rows([_wide(d.brush.off_surface[None], *p) for d in deltas], n_pigments),
        "habit": _rows([_habit(d.brush) for d in deltas], len(BRUSH_TRANSFER)),
    }
    filters = all(d.dry.over[0].shape[1] for d in deltas)
    for k, name in enumerate(OVER if filters else ()):
        state |= pack_arrays(name, [d.dry.over[k] for d in deltas], np.uint16, (N_BANDS,))
    return state | _flow_columns(deltas, n_pigments)


def _flow_columns(deltas: Sequence[PackedDelta], n_pigments: int) -> State:
    places: dict[int, int] = {}
    flows: list[PackedFlow] = []
    of = np.full(len(deltas), -1, np.int32)
    for k, delta in enumerate(deltas):
        if delta.flow is not None:
            of[k] = places.setdefault(id(delta.flow), len(flows))
            if of[k] == len(flows):
                flows.append(delta.flow)
    state: State = {
        "flow": of,
        "flow_size": np.array([flow.n for flow in flows], np.int32),
        "flow_names": sorted(flows[0].arrays) if flows else [],
        **pack_arrays("flow_rows", [flow.rows for flow in flows], np.int32),
    }
    for name in state["flow_names"]:
        arrays = [flow.arrays[name] for flow in flows]
        if arrays[0].ndim == 2:
            arrays = [_wide(array, n_pigments) for array in arrays]
        dtype, shape = arrays[0].dtype, arrays[0].shape[1:]
        state |= pack_arrays(f"flow_{name}", arrays, dtype, shape)
    return state


def _wide(array: AnyArray, n_pigments: int) -> AnyArray:
    """An array (..., p) with a column for every pigment that is known now."""
    return np.pad(array, ((0, 0), (0, n_pigments - array.shape[1])))


def _habit(brush: BrushLoad) -> AnyArray:
    return np.array(brush.transfer[BRUSH_TRANSFER].tolist())


def _rows(arrays: Sequence[AnyArray], width: int) -> AnyArray:
    return np.concatenate([np.empty((0, width)), *arrays])

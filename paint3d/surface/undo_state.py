"""The steps of an `UndoHistory` as plain arrays, numbers and words, and back again.

What is written are deltas as `undo` packs them, one column for each of their arrays, and the
layers that are not there now but come back with a step.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from paint3d.colour.spectra import N_BANDS
from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import InputError, SessionError
from paint3d.mesh.refined_mesh import saved_ids
from paint3d.surface.dry_layers import DryRows
from paint3d.surface.layer_stack import LayerStack, StackState
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import (
    BRUSH_TRANSFER,
    MOST_INK,
    MOST_RESERVOIRS,
    ROUNDING,
    checked_flow,
    layer_state,
    restore_layer,
)
from paint3d.surface.undo import (
    BrushLoad,
    PackedDelta,
    PackedFlow,
    Painting,
    Step,
    UndoHistory,
    is_by_vertex,
)

__all__ = [
    "OVER",
    "UNDO_VERSION",
    "Ragged",
    "SavedSteps",
    "pack_arrays",
    "restore_undo",
    "undo_state",
    "unpack_arrays",
]

# ---- Ragged arrays -------------------------------------------------------------------------------
# Many arrays of different lengths as one column, each different one kept once.
#
# A file has no room for an entry an array; and what a step left as it was is in many steps the
# same.


Ragged = dict[str, AnyArray]
"""By name: the column, NAME_starts (U + 1,) int64 of the U different arrays in it, and NAME_of
(K,) int32, which of them each of the K arrays is."""


def pack_arrays(
    name: str, arrays: Sequence[AnyArray], dtype: DTypeLike, shape: tuple[int, ...] = ()
) -> Ragged:
    """Join K arrays of some type, each (n, *shape), to a column."""
    places: dict[bytes, int] = {}
    different: list[AnyArray] = []
    of = np.empty(len(arrays), np.int32)
    for k, array in enumerate(arrays):
        array = np.ascontiguousarray(array, dtype).reshape(-1, *shape)
        key = hashlib.blake2b(array.view(np.uint8).data, digest_size=16).digest()
        of[k] = places.setdefault(key, len(different))
        if of[k] == len(different):
            different.append(array)
    starts = np.concatenate([[0], np.cumsum([len(array) for array in different], dtype=np.int64)])
    column = np.concatenate([np.empty((0, *shape), dtype), *different])
    return {name: column, f"{name}_starts": starts.astype(np.int64), f"{name}_of": of}


def unpack_arrays(
    state: Mapping[str, object],
    name: str,
    count: int,
    dtype: DTypeLike,
    shape: tuple[Any, ...] = (),
) -> list[AnyArray]:
    """The K arrays of a column, as views of it; they may come from a stranger.

    Raises
    ------
    SessionError
        If the column is not of this type, or not shared out to `count` arrays.
    """
    column, starts, of = (np.asarray(state[name + end]) for end in ("", "_starts", "_of"))
    if column.dtype != dtype or column.shape[1:] != shape or column.ndim != 1 + len(shape):
        raise SessionError(f"{name} is {column.dtype} {column.shape}")
    whole = starts.dtype == np.int64 and starts.ndim == 1 and len(starts) > 0
    if not whole or starts[0] != 0 or starts[-1] != len(column) or (np.diff(starts) < 0).any():
        raise SessionError(f"{name} has {len(column)} rows that are not shared out")
    if column.dtype.kind == "f" and not np.isfinite(column).all():
        raise SessionError(f"{name} holds what is no number")
    if of.dtype != np.int32 or of.shape != (count,):
        raise SessionError(f"{name} is given {of.shape} times; expected {count}")
    if count and not 0 <= of.min() <= of.max() < len(starts) - 1:
        raise SessionError(f"{name} is given from {of.min()} to {of.max()}")
    different = [column[a:b] for a, b in pairwise(starts)]
    return [different[k] for k in of]


# --------------------------------------------------------------------------------------------------


# --------------------------------------------------------------------------------------------------


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


# ---- Reading -------------------------------------------------------------------------------------
# The steps of an undo history out of a file that may come from a stranger.
#
# Nothing is believed: a step that could not follow from the surface as it is, and from the steps
# between, is refused. What `undo_state` wrote comes back to the bit.


_MOST_STEPS = 1_000_000
_MOST_FLOWS = 100_000
_MOST_FLOW_ROWS = 1 << 28  # of all flows together, as they are checked
_ABOUT = {"name": str, "visible": bool, "locked": bool}

ReadState = Mapping[str, Any]


def restore_undo(
    surface: PaintedSurface,
    history: UndoHistory,
    state: Mapping[str, Any],
    done: Sequence[object],
    undone: Sequence[object],
    kept: Sequence[object],
) -> None:
    """Let a new history have the steps of one that was saved with the surface.

    Parameters
    ----------
    surface : PaintedSurface
    history : UndoHistory
    state : mapping
        Of `undo_state`; it may come from a stranger: everything is checked before anything is done.
    done, undone : sequence
        Labels.
    kept : sequence
        What the painter remembered, for each painting.

    Raises
    ------
    SessionError
        If the state is newer than this program, incomplete, or not that of this surface.
    """
    try:
        version = state["version"]
        if type(version) is not int or not 1 <= version <= UNDO_VERSION:
            raise SessionError(f"they are of version {version!r:.20}; expected {UNDO_VERSION}")
        counts, kinds = _integers(state, "parts"), _integers(state, "stack")
        n_steps = len(done) + 1 + len(undone)
        numbers = state["done"], state["undone"]
        if numbers != (len(done), len(undone)) or len(counts) != n_steps:
            raise SessionError(f"{len(counts)} steps are counted as {numbers!r:.60}")
        if n_steps > _MOST_STEPS or counts.min() < 0 or counts.sum(dtype=np.int64) != len(kinds):
            raise SessionError(f"{n_steps} steps do not share out {len(kinds)} parts")
        deltas = _deltas(surface, state, int(np.count_nonzero(kinds < 0)))
        if len(kept) != len(deltas):
            raise SessionError(f"{len(deltas)} paintings are remembered as {len(kept)}")
        parts = _parts(kinds, _stacks(surface, state), deltas, kept)
        steps = [
            Step(label, 0, [*itertools.islice(parts, n)])
            for label, n in zip([*done, None, *undone], counts, strict=True)
        ]
        ways = steps[: len(done)], steps[len(done)], steps[len(done) + 1 :]
        _check_course(surface, *ways)
    except SessionError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as cause:
        raise SessionError(f"they are incomplete near {cause}") from None
    except InputError as cause:
        raise SessionError(str(cause)) from None
    history.resume(*ways)


def _parts(
    kinds: AnyArray,
    stacks: Sequence[StackState],
    deltas: Sequence[PackedDelta],
    kept: Sequence[Any],
) -> Iterator[StackState | Painting]:
    """The parts of all steps, in order."""
    if kinds.max(initial=-1) >= len(stacks) or kinds.min(initial=0) < -1:
        raise SessionError(f"a part is {kinds.min()} to {kinds.max()} of {len(stacks)} stacks")
    paintings = (Painting(d, k, d.n_bytes) for d, k in zip(deltas, kept, strict=True))
    return (stacks[kind] if kind >= 0 else next(paintings) for kind in kinds)


def _layers(surface: PaintedSurface) -> LayerStack:
    """The stack that the steps were made on.

    Raises
    ------
    SessionError
        If there is none.
    """
    if surface.layers is None:
        raise SessionError("the surface has no layers; expected those that the steps were made on")
    return surface.layers


def _stacks(surface: PaintedSurface, state: ReadState) -> list[StackState]:
    """The stacks of layers, with the layers that are not there now added to what is known."""
    stack, about = _layers(surface), state["layers"]
    now = stack.state()
    keys = list(now.keys)
    numbers = np.empty(surface.n_vertices, np.int32)
    numbers[saved_ids(surface.paint_mesh)] = np.arange(surface.n_vertices, dtype=np.int32)
    try:
        for k, one in enumerate(about):
            stack.put(now)
            if {name: type(value) for name, value in one.items()} != _ABOUT:
                raise SessionError(f"a layer is described by {one!r:.80}")
            stack.add(one["name"], len(stack))
            stack.describe(len(stack) - 1, **one)
            keys.append(stack.state().active)
            own = f"gone{k}_"
            content = {n.removeprefix(own): v for n, v in state.items() if n.startswith(own)}
            restore_layer(surface, content, numbers)
    finally:
        stack.put(now)
    found = []
    for own, active in state["stacks"]:
        whole = all(type(k) is int and 0 <= k < len(keys) for k in [*own, active])
        if not whole or active not in own or len(set(own)) < len(own):
            raise SessionError(f"layers {own!r:.60} are none of {len(keys)}")
        found.append(StackState(tuple(keys[k] for k in own), keys[active]))
    return found


def _deltas(surface: PaintedSurface, state: ReadState, count: int) -> list[PackedDelta]:
    """The K deltas, each checked by itself."""
    n, p = surface.n_vertices, (len(surface.pigments),)

    def column(name: str, dtype: type, shape: tuple[Any, ...] = ()) -> list[AnyArray]:
        return unpack_arrays(state, name, count, dtype, shape)

    _check_ink(state, ("amounts", "dry_amounts", "habit"))
    _check_ink(state, ("stations", "load"), least=-ROUNDING)
    _check_ink(state, ("off_surface",), least=-MOST_INK)
    _check_ink(state, ("coverage", "dry_share"), 1.0)
    load = as_array(state["load"], "load", (count, *p), np.float64, SessionError)
    off = as_array(state["off_surface"], "off_surface", (count, *p), np.float64, SessionError)
    shape = (count, len(BRUSH_TRANSFER))
    own = as_array(state["habit"], "habit", shape, np.float64, SessionError)
    transfers = np.repeat(surface.ink.transfer[None], count, axis=0)  # with the material's grain
    for name, values in zip(BRUSH_TRANSFER, own.T, strict=True):
        transfers[name][:, 0] = values
    brushes = [
        BrushLoad(*held) for held in zip(load, off, column("stations", np.float64, p), transfers,
                                       strict=True)
    ]  # fmt: skip
    bands = (N_BANDS,)
    bare = [np.empty((0, 0), np.uint16)] * count
    over = [
        column(name, np.uint16, bands) if surface.dry_layers.has_filters else bare for name in OVER
    ]
    rows = [
        column("dry_rows", np.int32), column("dry_vertices", np.int32),
        column("dry_spectra", np.uint16, bands), column("dry_amounts", np.float32, p),
        column("dry_share", np.float32), zip(*over, strict=True),
    ]  # fmt: skip
    counts = _integers(state, "dry_count")
    flows = _flows(surface, state)
    of = _integers(state, "flow")
    if len(of) != count or len(counts) != count:
        raise SessionError(f"{count} paintings have {len(of)} flows, and dried {len(counts)} times")
    if of.max(initial=-1) >= len(flows) or of.min(initial=0) < -1:
        raise SessionError(f"water is {of.min()} to {of.max()} of {len(flows)}")
    deltas = [
        PackedDelta(ids, amounts, coverage, DryRows(int(counted), *dry), brush,
                    flows[k] if k >= 0 else None)
        for ids, amounts, coverage, counted, dry, brush, k in zip(
            column("vertices", np.int32), column("amounts", np.float32, p),
            column("coverage", np.float32), counts, zip(*rows, strict=True), brushes, of,
            strict=True,
        )
    ]  # fmt: skip
    distinct = _Distinct(n)
    for delta in deltas:
        _check_delta(delta, distinct)
    return deltas


def _check_ink(
    state: ReadState, names: Sequence[str], most: float = MOST_INK, least: float = 0.0
) -> None:
    for name in names:
        values = np.asarray(state[name])
        if values.dtype.kind != "f" or (
            values.size and not least <= values.min() <= values.max() <= most
        ):
            raise SessionError(f"{name} holds what is no ink; expected {least:g} to {most:g}")


class _Distinct:
    """Checks numbers of vertices; the same array is looked at once."""

    def __init__(self, n: int) -> None:
        self._n = n
        self._seen: set[tuple[int, int]] = set()

    def __call__(self, ids: AnyArray, name: str) -> None:
        where = ids.__array_interface__["data"][0], len(ids)
        if where in self._seen or not len(ids):
            return
        ordered = np.sort(ids)
        if not 0 <= ordered[0] <= ordered[-1] < self._n or (np.diff(ordered) == 0).any():
            raise SessionError(
                f"{name} holds {ordered[0]} to {ordered[-1]}, or a vertex twice; expected 0 to "
                f"{self._n - 1}"
            )
        self._seen.add(where)


def _check_delta(delta: PackedDelta, distinct: _Distinct) -> None:
    dry, brush = delta.dry, delta.brush
    distinct(delta.vertex_ids, "vertices of a step")
    distinct(dry.vertex_ids, "dried vertices of a step")
    if not len(delta.amounts) == len(delta.coverage) <= len(delta.vertex_ids):
        raise SessionError(f"{len(delta.vertex_ids)} vertices have {len(delta.amounts)} amounts")
    filled = [array for array in dry.over if array.shape[1]]
    lengths = {len(array) for array in (*dry[1:6], *filled)}
    if len(lengths) > 1 or dry.count < 0:
        raise SessionError(f"rows of dry paint are {lengths} in one step")
    if not 1 <= len(brush.reservoirs) <= MOST_RESERVOIRS:
        raise SessionError(f"the brush has {len(brush.reservoirs)} stations")


def _flows(surface: PaintedSurface, state: ReadState) -> list[PackedFlow]:
    """The water of the steps."""
    sizes, names = _integers(state, "flow_size"), state["flow_names"]
    count, n, p = len(sizes), surface.n_vertices, len(surface.pigments)
    if count > _MOST_FLOWS or sizes.max(initial=0) > n or sizes.min(initial=0) < 0:
        raise SessionError(f"water is kept {count} times, on up to {sizes.max(initial=0)} vertices")
    if sizes.sum(dtype=np.int64) > _MOST_FLOW_ROWS:
        raise SessionError(f"water is kept on {sizes.sum(dtype=np.int64):,} vertices in all")
    columns = {"rows": unpack_arrays(state, "flow_rows", count, np.int32)}
    for name in names:
        array = np.asarray(state[f"flow_{name}"])
        columns[name] = unpack_arrays(state, f"flow_{name}", count, array.dtype, array.shape[1:])
    flows = []
    for k, size in enumerate(sizes):
        own = {name: column[k] for name, column in columns.items()}
        flow = PackedFlow(int(size), own.pop("rows"), own)
        flows.append(_checked(flow, n, p))
    return flows


def _checked(flow: PackedFlow, n: int, n_pigments: int) -> PackedFlow:
    """A flow that water could leave, with the arrays that are known only."""
    rows = flow.rows
    if len(rows) and (np.diff(rows) <= 0).any() | (rows[0] < 0) | (rows[-1] >= flow.n):
        raise SessionError("rows of a flow are not in order")
    for name, array in flow.arrays.items():
        if is_by_vertex(name, array) and len(array) != len(rows):
            raise SessionError(f"flow_{name} has {len(array)} rows; expected {len(rows)}")
    whole = {f"flow_{name}": array for name, array in flow.unpacked(_SameNumbers()).items()}
    known = checked_flow(whole, n, n_pigments, lambda ids: ids)
    if len(known["vertices"]) != flow.n:
        raise SessionError(f"a flow of {flow.n} vertices has {len(known['vertices'])}")
    own = {name: flow.arrays[name] for name in known if name in flow.arrays}
    missing = {name: known[name][rows] for name in known if name not in own}  # of older files
    return PackedFlow(flow.n, rows, own | missing)


class _SameNumbers:
    """Numbers of vertices that are left as they are; see `VertexNumbers`."""

    @staticmethod
    def now(saved: AnyArray) -> AnyArray:
        return saved


def _check_course(
    surface: PaintedSurface, done: Sequence[Step], since: Step, undone: Sequence[Step]
) -> None:
    """Go the steps back and forth with nothing but the numbers of dried vertices.

    Raises
    ------
    SessionError
        Where what dried could not have been so.
    """
    numbers = saved_ids(surface.paint_mesh)
    for way in ([since, *reversed(done)], [since, *reversed(undone)]):
        stack = _layers(surface)
        dried = {key: numbers[dry.vertex_ids] for key, dry in stack.dry_by_key().items()}
        active = stack.state().active
        for step in way:
            for part in reversed(step.parts):
                if isinstance(part, StackState):
                    active = part.active
                elif isinstance(part, Painting) and isinstance(part.delta, PackedDelta):
                    dried[active] = _exchanged(dried[active], part.delta.dry)


def _exchanged(now: AnyArray, then: DryRows) -> AnyArray:
    """(D',) dried vertices after an exchange with rows of another time."""
    rows, ids = then.rows, then.vertex_ids
    shared = rows < len(now)
    came = max(then.count - len(now), 0)
    new = np.sort(rows[~shared])
    follows = (
        (not len(rows) or 0 <= rows.min() <= rows.max() < then.count)
        and len(np.unique(rows)) == len(rows)
        and len(new) == came
        and np.array_equal(new, len(now) + np.arange(came))
        and np.array_equal(now[rows[shared]], ids[shared])
        and not np.isin(ids[~shared], now).any()
    )
    if not follows:
        raise SessionError(f"{len(rows)} rows of dry paint do not follow from {len(now)}")
    if then.count <= len(now):
        return now[: then.count]
    after = np.empty(then.count, np.int32)
    after[: len(now)] = now
    after[rows[~shared]] = ids[~shared]
    return after


def _integers(state: ReadState, name: str) -> AnyArray:
    values = np.asarray(state[name])
    if values.dtype != np.int32 or values.ndim != 1:
        raise SessionError(f"{name} is {values.dtype} {values.shape}; expected (n,) int32")
    return values

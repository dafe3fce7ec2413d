"""Conversion of the steps of an `UndoHistory` to plain arrays, numbers and strings, and back.

The deltas are stored as `undo` packs them, one column for each of their arrays, with the layers
that are not in the stack at present but come back with a step.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from paint3d.colour.spectra import N_BANDS
from paint3d.core.array_state import pack_arrays, unpack_arrays
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError, SessionError
from paint3d.mesh.refined_mesh import saved_ids
from paint3d.surface.dry_layers import DryRows
from paint3d.surface.layer_stack import BLENDS, LayerStack, StackState
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import (
    BRUSH_TRANSFER,
    MOST_INK,
    MOST_RESERVOIRS,
    ROUNDING,
    checked_flow,
    integers_in,
    layer_state,
    read_group,
    restore_layer,
)
from paint3d.surface.undo import (
    BrushLoad,
    PackedDelta,
    PackedFlow,
    PaintedPart,
    Step,
    UndoHistory,
    is_by_vertex,
)

__all__ = [
    "OVER",
    "UNDO_VERSION",
    "SavedSteps",
    "restore_undo",
    "undo_state",
]

# ---- Writing -------------------------------------------------------------------------------------


UNDO_VERSION = 1
_STEP_BYTES = 1000  # about what a part takes besides its vertices
OVER = ("dry_low", "dry_middle", "dry_high")
"""Columns of what dried rows show over the grounds of `colour.kernels.glazing`."""

State = dict[str, Any]


@dataclass(frozen=True)
class SavedSteps:
    """Steps in the form that is written to a file.

    Attributes
    ----------
    state : dict
        See `undo_state`.
    done, undone : sequence
        Labels of the steps in it, in the order of `UndoHistory`.
    kept : sequence
        The painter's state with each of the K paintings in order.
    """

    state: State
    done: Sequence[object]
    undone: Sequence[object]
    kept: Sequence[Any]


def undo_state(surface: PaintedSurface, history: UndoHistory, most_bytes: int) -> SavedSteps:
    """Return the steps nearest to the present that fit into `most_bytes`.

    Parameters
    ----------
    surface : PaintedSurface
        In the history's present state.
    history : UndoHistory
    most_bytes : int

    Returns
    -------
    SavedSteps
        Its state holds version and done and undone, the numbers of steps. For the S steps (done,
        changes since an undo, undone) parts (S,) int32 is the number of parts; for the Q parts
        stack (Q,) int32 is the index in `stacks`, or -1 for a painting.

        Each of the stacks is a list of layers, the active one, the opacity and blend of each, and
        the group of each where there are any; older files lack these. Layers are numbered by their
        places in the present stack, and then by their indices in layers: that describes, as
        `surface_state` does, those that are not in the present stack; the arrays of their paint
        are prefixed with gone0_ and so on.

        For the K paintings there are the columns (`Ragged`) vertices, amounts, coverage, dry_...
        and stations, and dry_count (K,) int32, load and off_surface (K, P) and habit (K, 3)
        float64, and flow (K,) int32, the index of one of F flows, or -1. For the flows there are
        flow_rows, flow_size (F,) int32, and the columns flow_... of `surface_state`.
    """
    chosen = _nearest(history, most_bytes)
    steps = [*chosen.done, chosen.since, *reversed(chosen.undone)]
    parts = [part for step in steps for part in step.parts]
    # Layers of the present stack are numbered first, then those that only a step has.
    now = surface.layers.state().keys if surface.layers is not None else ()
    named = (key for part in parts if isinstance(part, StackState) for key in part.keys)
    numbers = {key: k for k, key in enumerate(dict.fromkeys([*now, *named]))}
    stacks = [part for part in parts if isinstance(part, StackState)]
    kinds = np.full(len(parts), -1, np.int32)
    kinds[[isinstance(part, StackState) for part in parts]] = np.arange(len(stacks))
    deltas = [chosen.packed[id(part)] for part in parts if isinstance(part, PaintedPart)]
    state = {
        "version": UNDO_VERSION,
        "done": len(chosen.done),
        "undone": len(chosen.undone),
        "stacks": [
            [
                [numbers[k] for k in one.keys],
                numbers[one.active],
                [list(s) for s in one.looks],
                *([[group and asdict(group) for group in one.groups]] if any(one.groups) else []),
            ]
            for one in stacks
        ],
        "parts": np.array([len(step.parts) for step in steps], np.int32),
        "stack": kinds,
        **_columns(deltas, len(surface.pigments)),
        **_gone_layers(surface, list(numbers)),
    }
    return SavedSteps(
        state,
        [step.label for step in chosen.done],
        [step.label for step in reversed(chosen.undone)],
        [part.kept for part in parts if isinstance(part, PaintedPart)],
    )


@dataclass
class _Chosen:
    """The steps to save, and their deltas by the identity of their parts."""

    done: list[Step]
    since: Step
    undone: list[Step]  # the next one first
    packed: dict[int, PackedDelta]


def _nearest(history: UndoHistory, most_bytes: int) -> _Chosen:
    """Return the nearest steps that fit; undone ones only if all done ones do."""
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
            if not isinstance(part, PaintedPart):
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
    near_done = list(itertools.takewhile(fits, reversed(done)))
    near_undone: list[Step] = []
    if len(near_done) == len(done):
        near_undone = list(itertools.takewhile(fits, reversed(undone)))
    return _Chosen(near_done[::-1], since, near_undone, packed)


def _gone_layers(surface: PaintedSurface, keys: Sequence[int]) -> State:
    """Return the layers among `keys` that are not in the present stack, with their paint."""
    stack = surface.layers
    state: State = {"layers": []}
    if stack is None or len(keys) == len(stack):
        return state
    now, ids = stack.state(), saved_ids(surface.paint_mesh)
    for k, key in enumerate([key for key in keys if key not in now.keys]):
        stack.put(StackState((*now.keys, key), key))
        about = asdict(stack.layers[-1])
        del about["group"]  # each stack says which it is in
        state["layers"].append(about)
        state |= {f"gone{k}_{name}": value for name, value in layer_state(surface, ids).items()}
    stack.put(now)
    return state


def _columns(deltas: Sequence[PackedDelta], n_pigments: int) -> State:
    """Return the arrays of K deltas, as `undo_state` names them."""
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
        **pack_arrays("dry_share", [d.dry.coverage for d in deltas], np.float32),
        **pack_arrays("stations", [_wide(d.brush.reservoirs, *p) for d in deltas], np.float64, p),
        "load": _rows([_wide(d.brush.load[None], *p) for d in deltas], n_pigments),
        "off_surface": _rows([_wide(d.brush.off_surface[None], *p) for d in deltas], n_pigments),
        "habit": _rows(
            [np.array(d.brush.transfer[BRUSH_TRANSFER].tolist()) for d in deltas],
            len(BRUSH_TRANSFER),
        ),
    }
    filters = all(d.dry.over[0].shape[1] for d in deltas)
    for k, name in enumerate(OVER if filters else ()):
        state |= pack_arrays(name, [d.dry.over[k] for d in deltas], np.uint16, (N_BANDS,))
    return state | _flow_columns(deltas, n_pigments)


def _flow_columns(deltas: Sequence[PackedDelta], n_pigments: int) -> State:
    """Return the arrays of the flows of K deltas, each flow once."""
    index_of: dict[int, int] = {}
    flows: list[PackedFlow] = []
    of = np.full(len(deltas), -1, np.int32)
    for k, delta in enumerate(deltas):
        if delta.flow is not None:
            of[k] = index_of.setdefault(id(delta.flow), len(flows))
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
    """Return an array (K, p) with a column for every pigment known now."""
    return np.pad(array, ((0, 0), (0, n_pigments - array.shape[1])))


def _rows(arrays: Sequence[AnyArray], width: int) -> AnyArray:
    """Stack rows of `width` columns; no rows give an array (0, width)."""
    return np.concatenate([np.empty((0, width)), *arrays])


# ---- Reading -------------------------------------------------------------------------------------
# Restoring the steps of an undo history from an untrusted file.
#
# Everything is verified: a step that could not follow from the present surface and the steps in
# between is refused. What `undo_state` wrote is restored bit by bit.


_MOST_STEPS = 1_000_000
_MOST_FLOWS = 100_000
_MOST_FLOW_ROWS = 1 << 28  # of all flows together, since checking unpacks them
_ABOUT = {"name": str, "visible": bool, "locked": bool, "opacity": float, "blend": str}
_USUAL = {"opacity": 1.0, "blend": "normal"}  # of older files

ReadState = Mapping[str, Any]


def restore_undo(
    surface: PaintedSurface,
    history: UndoHistory,
    state: Mapping[str, Any],
    done: Sequence[object],
    undone: Sequence[object],
    kept: Sequence[object],
) -> None:
    """Give a new history the steps of one that was saved with the surface.

    Parameters
    ----------
    surface : PaintedSurface
    history : UndoHistory
    state : mapping
        From `undo_state`; it is untrusted: everything is checked before the history is changed.
    done, undone : sequence
        Labels.
    kept : sequence
        The painter's state with each painting.

    Raises
    ------
    SessionError
        If the state is newer than this program, incomplete, or belongs to another surface.
    """
    try:
        version = state["version"]
        if type(version) is not int or not 1 <= version <= UNDO_VERSION:
            raise SessionError(
                "they are of version {version!r:.20}; expected {undo_version}",
                version=version,
                undo_version=UNDO_VERSION,
            )
        counts, kinds = integers_in(state, "parts"), integers_in(state, "stack")
        n_steps = len(done) + 1 + len(undone)
        numbers = state["done"], state["undone"]
        if numbers != (len(done), len(undone)) or len(counts) != n_steps:
            raise SessionError(
                "{n} steps are counted as {numbers!r:.60}",
                n=len(counts),
                numbers=numbers,
            )
        if n_steps > _MOST_STEPS or counts.min() < 0 or counts.sum(dtype=np.int64) != len(kinds):
            raise SessionError(
                "{n_steps} steps do not share out {n} parts",
                n_steps=n_steps,
                n=len(kinds),
            )
        deltas = _deltas(surface, state, int(np.count_nonzero(kinds < 0)))
        if len(kept) != len(deltas):
            raise SessionError(
                "{n} paintings are remembered as {kept}",
                n=len(deltas),
                kept=len(kept),
            )
        parts = _parts(kinds, _stacks(surface, state), deltas, kept)
        steps = [
            Step(label, 0, [*itertools.islice(parts, n)])
            for label, n in zip([*done, None, *undone], counts, strict=True)
        ]
        course = steps[: len(done)], steps[len(done)], steps[len(done) + 1 :]
        _check_course(surface, *course)
    except SessionError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as cause:
        raise SessionError("they are incomplete near {cause}", cause=cause) from None
    except InputError as cause:
        raise SessionError(cause) from None
    history.resume(*course)


def _parts(
    kinds: AnyArray,
    stacks: Sequence[StackState],
    deltas: Sequence[PackedDelta],
    kept: Sequence[Any],
) -> Iterator[StackState | PaintedPart]:
    """Return the parts of all steps, in order."""
    if kinds.max(initial=-1) >= len(stacks) or kinds.min(initial=0) < -1:
        raise SessionError(
            "a part is {least} to {most} of {n} stacks",
            least=kinds.min(),
            most=kinds.max(),
            n=len(stacks),
        )
    paintings = (PaintedPart(d, k, d.n_bytes) for d, k in zip(deltas, kept, strict=True))
    return (stacks[kind] if kind >= 0 else next(paintings) for kind in kinds)


def _layers(surface: PaintedSurface) -> LayerStack:
    """Return the stack that the steps were made on.

    Raises
    ------
    SessionError
        If the surface has none.
    """
    if surface.layers is None:
        raise SessionError("the surface has no layers; expected those that the steps were made on")
    return surface.layers


def _stacks(surface: PaintedSurface, state: ReadState) -> list[StackState]:
    """Return the saved stacks, after making layers outside the present stack known to it."""
    stack, about = _layers(surface), state["layers"]
    now = stack.state()
    keys = list(now.keys)
    numbers = np.empty(surface.n_vertices, np.int32)
    numbers[saved_ids(surface.paint_mesh)] = np.arange(surface.n_vertices, dtype=np.int32)
    try:
        for k, one in enumerate(about):
            stack.put(now)
            one = {**_USUAL, **one}
            if {name: type(value) for name, value in one.items()} != _ABOUT:
                raise SessionError("a layer is described by {one!r:.80}", one=one)
            stack.add(one["name"], len(stack))
            stack.set_properties(len(stack) - 1, **one)
            keys.append(stack.state().active)
            own = f"gone{k}_"
            content = {n.removeprefix(own): v for n, v in state.items() if n.startswith(own)}
            restore_layer(surface, content, numbers)
    finally:
        stack.put(now)
    stacks = []
    for own, active, *rest in state["stacks"]:
        whole = all(type(k) is int and 0 <= k < len(keys) for k in [*own, active])
        if not whole or active not in own or len(set(own)) < len(own):
            raise SessionError("layers {own!r:.60} are none of {n}", own=own, n=len(keys))
        looks = tuple((opacity, blend) for opacity, blend in (rest[0] if rest else ()))
        for opacity, blend in looks:
            as_number(opacity, "opacity of a layer", 0.0, 1.0)
            if blend not in BLENDS:
                raise SessionError("a layer is blended by {blend!r:.40}", blend=blend)
        if len(looks) not in (0, len(own)):
            raise SessionError("{n} looks are for {own} layers", n=len(looks), own=len(own))
        saved = rest[1] if len(rest) > 1 else [None] * len(own)
        groups = tuple(None if group is None else read_group(group) for group in saved)
        if len(groups) != len(own):
            raise SessionError("{n} groups are for {own} layers", n=len(groups), own=len(own))
        stack.know_groups(groups)
        stacks.append(StackState(tuple(keys[k] for k in own), keys[active], looks, groups))
    return stacks


def _deltas(surface: PaintedSurface, state: ReadState, count: int) -> list[PackedDelta]:
    """Return the K deltas, each checked by itself."""
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
    habits = as_array(state["habit"], "habit", shape, np.float64, SessionError)
    transfers = np.repeat(surface.ink.transfer[None], count, axis=0)  # with the material's grain
    for name, values in zip(BRUSH_TRANSFER, habits.T, strict=True):
        transfers[name][:, 0] = values
    stations = column("stations", np.float64, p)
    brushes = [BrushLoad(*own) for own in zip(load, off, stations, transfers, strict=True)]
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
    counts = integers_in(state, "dry_count")
    flows = _flows(surface, state)
    of = integers_in(state, "flow")
    if len(of) != count or len(counts) != count:
        raise SessionError(
            "{count} paintings have {n} flows, and dried {counts} times",
            count=count,
            n=len(of),
            counts=len(counts),
        )
    if of.max(initial=-1) >= len(flows) or of.min(initial=0) < -1:
        raise SessionError(
            "water is {least} to {most} of {n}",
            least=of.min(),
            most=of.max(),
            n=len(flows),
        )
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
            raise SessionError(
                "{name} holds what is no ink; expected {least:g} to {most:g}",
                name=name,
                least=least,
                most=most,
            )


class _Distinct:
    """Check that vertex numbers are valid and distinct; a shared array is checked once."""

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
                "{name} holds {first} to {last}, or a vertex twice; expected 0 to {n}",
                name=name,
                first=ordered[0],
                last=ordered[-1],
                n=self._n - 1,
            )
        self._seen.add(where)


def _check_delta(delta: PackedDelta, distinct: _Distinct) -> None:
    dry, brush = delta.dry, delta.brush
    distinct(delta.vertex_ids, "vertices of a step")
    distinct(dry.vertex_ids, "dried vertices of a step")
    if not len(delta.amounts) == len(delta.coverage) <= len(delta.vertex_ids):
        raise SessionError(
            "{n} vertices have {delta_amounts} amounts",
            n=len(delta.vertex_ids),
            delta_amounts=len(delta.amounts),
        )
    filled = [array for array in dry.over if array.shape[1]]
    lengths = {len(array) for array in (*dry[1:6], *filled)}
    if len(lengths) > 1 or dry.count < 0:
        raise SessionError("rows of dry paint are {lengths} in one step", lengths=lengths)
    if not 1 <= len(brush.reservoirs) <= MOST_RESERVOIRS:
        raise SessionError("the brush has {n} stations", n=len(brush.reservoirs))


def _flows(surface: PaintedSurface, state: ReadState) -> list[PackedFlow]:
    """Return the F flows of the steps, each checked."""
    sizes, names = integers_in(state, "flow_size"), state["flow_names"]
    count, n, p = len(sizes), surface.n_vertices, len(surface.pigments)
    if count > _MOST_FLOWS or sizes.max(initial=0) > n or sizes.min(initial=0) < 0:
        raise SessionError(
            "water is kept {count} times, on up to {most} vertices",
            count=count,
            most=sizes.max(initial=0),
        )
    if sizes.sum(dtype=np.int64) > _MOST_FLOW_ROWS:
        raise SessionError(
            "water is kept on {sizes:,} vertices in all",
            sizes=sizes.sum(dtype=np.int64),
        )
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
    """Check that water could leave such a flow; return it without unknown arrays."""
    rows = flow.rows
    if len(rows) and (np.diff(rows) <= 0).any() | (rows[0] < 0) | (rows[-1] >= flow.n):
        raise SessionError("rows of a flow are not in order")
    for name, array in flow.arrays.items():
        if is_by_vertex(name, array) and len(array) != len(rows):
            raise SessionError(
                "flow_{name} has {n} rows; expected {rows}",
                name=name,
                n=len(array),
                rows=len(rows),
            )
    whole = {f"flow_{name}": array for name, array in flow.unpacked(_SameNumbers()).items()}
    known = checked_flow(whole, n, n_pigments, lambda ids: ids)
    if len(known["vertices"]) != flow.n:
        raise SessionError(
            "a flow of {n} vertices has {known}",
            n=flow.n,
            known=len(known["vertices"]),
        )
    own = {name: flow.arrays[name] for name in known if name in flow.arrays}
    missing = {name: known[name][rows] for name in known if name not in own}  # from older files
    return PackedFlow(flow.n, rows, own | missing)


class _SameNumbers:
    """The identity mapping of vertex numbers; see `VertexNumbers`."""

    @staticmethod
    def now(saved: AnyArray) -> AnyArray:
        return saved


def _check_course(
    surface: PaintedSurface, done: Sequence[Step], since: Step, undone: Sequence[Step]
) -> None:
    """Dry-run all steps back and forth on the numbers of dried vertices alone.

    Raises
    ------
    SessionError
        If a step's dried rows do not follow from those before it.
    """
    numbers = saved_ids(surface.paint_mesh)
    for direction in ([since, *reversed(done)], [since, *reversed(undone)]):
        stack = _layers(surface)
        dried = {key: numbers[dry.vertex_ids] for key, dry in stack.dry_by_key().items()}
        active = stack.state().active
        for step in direction:
            for part in reversed(step.parts):
                if isinstance(part, StackState):
                    active = part.active
                elif isinstance(part, PaintedPart) and isinstance(part.delta, PackedDelta):
                    dried[active] = _exchange_ids(dried[active], part.delta.dry)


def _exchange_ids(now: AnyArray, then: DryRows) -> AnyArray:
    """Return the dried vertices (D',) after exchanging those of now (D,) with rows `then`."""
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
        raise SessionError(
            "{n} rows of dry paint do not follow from {now}",
            n=len(rows),
            now=len(now),
        )
    if then.count <= len(now):
        return now[: then.count]
    after = np.empty(then.count, np.int32)
    after[: len(now)] = now
    after[rows[~shared]] = ids[~shared]
    return after

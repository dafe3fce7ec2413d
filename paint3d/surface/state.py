"""Bit-exact conversion of a painted surface to plain arrays, numbers and strings, and back.

Whatever follows from the mesh and the ink is not stored: refined vertices are stored as a log of
bisections, colours not at all. Pigments and the material are stored with their spectra, so a
painting looks the same after the palette has changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import Material, load_materials
from paint3d.colour.pigments import USUAL_FINE, WATER, Pigment, load_palette
from paint3d.colour.spectra import N_BANDS
from paint3d.core.array_state import record_words
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError, Paint3DError, SessionError
from paint3d.mesh.likeness import Original
from paint3d.mesh.refined_mesh import refinement_log, repeat_refinement, saved_ids
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.layer_stack import BLENDS, MOST_NAME, Group, Layer
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "BRUSH_TRANSFER",
    "FLOW_VERTICES",
    "MOST_INK",
    "MOST_RESERVOIRS",
    "ROUNDING",
    "STATE_VERSION",
    "UPGRADES",
    "checked_flow",
    "integers_in",
    "layer_state",
    "restore_layer",
    "restore_surface",
    "surface_state",
]

STATE_VERSION = 7
BRUSH_TRANSFER = ["pickup", "capacity", "reservoir_mm"]
"""Fields of `InkField.transfer` that belong to the brush ("habit" in files), not the material."""
MOST_RESERVOIRS = 256
_MOST_PIGMENTS = 256
FLOW_VERTICES = ("vertices", "fresh")
"""Arrays of `PaintedSurface.keep_flow` that hold vertex numbers."""
_OVER = ("dried_low", "dried_middle", "dried_high")
_DEEPEST_MM = 1e3
MOST_INK = 1e9  # coats, and coats x mm2: a brush holds some thousand
ROUNDING = 1e-6  # coats x mm2 by which a brush's load may be negative: it is a rounded sum
_Record = TypeVar("_Record", Material, Pigment)
_LONGEST_PACE, _LONGEST_OWED = 3600.0, 1e9  # s

_FLOW = {  # upper bound of each
    "water": _DEEPEST_MM, "inside": _DEEPEST_MM, "soaked": 1.0, "owed": _LONGEST_OWED,
    "pace": _LONGEST_PACE,
}  # fmt: skip

State = dict[str, Any]
UPGRADES: dict[int, Callable[[State], State]] = {
    1: lambda state: {**state, "version": 2, "flows": False},  # without water
    2: lambda state: {**state, "version": 3, **_uniform_brush(len(state["pigments"]))},
    3: lambda state: {**state, "version": 4, "layers": None, "active": 0, **_full_shares(state)},
    4: lambda state: {**state, "version": 5, **_pace_by_vertex(state)},
    5: lambda state: {**state, "version": 6},  # with how fast the water rose, no longer used
    6: lambda state: {**state, "version": 7, "open_blocks": np.zeros(0, np.int32)},
}
"""Upgrade of each old version to the next one; `restore_surface` applies them in turn."""


def surface_state(surface: PaintedSurface) -> State:
    """Return everything that `restore_surface` needs besides the mesh.

    Returns
    -------
    dict
        version, resolution (mm or None), material, pigments (dicts of numbers and words), and
        arrays: splits (n,) int32, the refinement log; touched (T,) int32, numbers of the vertices
        with wet ink (`mesh.refined_mesh.saved_ids`); amounts (T, P) and coverage (T,) float32;
        dried (D,) int32, the vertices with dry ink; dried_spectra (D, 31) uint16 and dried_amounts
        (D, P) and dried_share (D,) float32; load and off_surface (P,) float64; stations (N, P)
        float64, the load along the tuft, N = 1 if it is uniform; habit (3,) float64, pick-up
        (1/mm), capacity (coats x mm2) and length of a reservoir (mm) of `TRANSFER`.

        flows (bool) says whether there is water in motion (`WetPatch`); if so, for the C vertices
        with any trace of it: flow_vertices (C,) int32, flow_water (C,), flow_pigment, flow_fine
        and flow_loose (C, P) float64, flow_inside, flow_soaked, flow_laid, flow_owed, flow_pace
        (C,) and flow_written (C, P) float32; flow_fresh (N,) int32 vertices. Older files have no
        flow_fine: the same fraction of all pigment is fine; nor flow_loose: none is; nor flow_laid:
        brushes laid all water. open_blocks (B,) int32
        are the blocks of its `FlowGraph` where water has been.

        layers is None, or a list of what `Layer` says of each, the lowest first;
        active is the place of the one that the arrays above belong to. The arrays of any other
        layer, at place K, are prefixed with layerK_ (layerK_touched ...). With layers there are
        also dried_low, dried_middle and dried_high (D, 31) uint16: what dried rows show over the
        grounds of `colour.kernels.glazing`.

        original (its name), original_vertices, original_faces, original_normals and
        original_resolution (mm) describe the mesh that was painted on before remeshing, if any.
    """
    ids = saved_ids(surface.paint_mesh)
    ink = surface.ink
    return {
        "version": STATE_VERSION,
        "resolution": surface.resolution,
        "material": record_words(surface.material),
        "pigments": [record_words(pigment) for pigment in surface.pigments],
        "splits": refinement_log(surface.paint_mesh),
        "load": ink.load.copy(),
        "off_surface": ink.off_surface.copy(),
        "stations": ink.reservoirs.copy(),
        "habit": np.array(ink.transfer[BRUSH_TRANSFER].tolist()[0]),
        **layer_state(surface, ids),
        **_resting_layers(surface, ids),
        "open_blocks": surface.open_blocks(),
        **_original_state(surface),
    }


def _original_state(surface: PaintedSurface) -> State:
    """Return the mesh that was painted on before remeshing, if any, as `surface_state` names it."""
    original = surface.original
    if original is None:
        return {}
    arrays = {name: getattr(original.mesh, name) for name in ("vertices", "faces", "normals")}
    given = {f"original_{name}": array for name, array in arrays.items() if array is not None}
    return {"original": original.mesh.name, "original_resolution": original.resolution, **given}


def _original_in(state: State) -> Original | None:
    """Return what `_original_state` stored, or None."""
    if "original_resolution" not in state:
        return None
    resolution = as_number(state["original_resolution"], "its original's resolution", 0.005, 1e6)
    vertices, faces = state["original_vertices"], state["original_faces"]
    name, normals = str(state["original"]), state.get("original_normals")
    return Original(TriangleMesh(vertices, faces, None, name, normals), resolution)


def layer_state(surface: PaintedSurface, ids: NDArray[np.int32]) -> State:
    """Return the paint on the active layer, as `surface_state` names it.

    Parameters
    ----------
    surface : PaintedSurface
    ids : (V,) int32
        The vertices' numbers in a file.
    """
    ink, dry, n = surface.ink, surface.dry_layers, surface.n_vertices
    inked = np.flatnonzero((ink.coverage[:n] != 0) | (ink.amounts[:n] != 0).any(axis=1))
    rows = inked[np.argsort(ids[inked], kind="stable")]
    state = {
        "touched": ids[rows],
        "amounts": ink.amounts[rows],
        "coverage": ink.coverage[rows],
        "dried": ids[dry.vertex_ids],
        "dried_spectra": dry.spectra.copy(),
        "dried_amounts": dry.amounts.copy(),
        "dried_share": dry.coverage.copy(),
        **_flow_state(surface, ids),
    }
    if dry.has_filters:
        state |= {name: over.copy() for name, over in zip(_OVER, dry.over, strict=True)}
    return state


def _resting_layers(surface: PaintedSurface, ids: AnyArray) -> State:
    """Return the list of layers and the paint on those that are not active."""
    stack = surface.layers
    if stack is None:
        return {"layers": None, "active": 0}
    active = stack.active
    layers = [asdict(layer) for layer in stack.layers]
    for about in layers:
        if about["group"] is None:
            del about["group"]
    state: State = {"layers": layers, "active": active}
    for place in range(len(stack)):
        if place != active:
            stack.activate(place)
            own = layer_state(surface, ids)
            state |= {f"layer{place}_{name}": value for name, value in own.items()}
    stack.activate(active)
    return state


def _full_shares(state: State) -> State:
    """Return dried_share for files without it: paint covers whole vertices."""
    return {"dried_share": np.ones(len(np.atleast_1d(state["dried"])), np.float32)}


def _pace_by_vertex(state: State) -> State:
    """Return flow_pace and flow_owed per vertex for files with one step for all, on every layer."""
    upgraded: State = {}
    for name in state:
        if name.endswith("flow_pace"):
            count = len(np.atleast_1d(state[name.replace("pace", "vertices")]))
            pace = np.asarray(state[name], np.float64)
            upgraded[name] = np.full(count, pace[0] if pace.shape == (1,) else np.nan)
            upgraded[name.replace("pace", "owed")] = np.zeros(count)
    return upgraded


def _uniform_brush(n_pigments: int) -> State:
    """Return stations and habit for files without them: the load is uniform along the tuft."""
    return {"stations": np.zeros((1, n_pigments)), "habit": np.zeros(len(BRUSH_TRANSFER))}


def _flow_state(surface: PaintedSurface, ids: AnyArray) -> State:
    """Return the water of the active layer, with vertices by their numbers in a file."""
    kept = surface.keep_flow()
    if kept is None:
        return {"flows": False}
    for name in FLOW_VERTICES:
        kept[name] = ids[kept[name]]
    order = np.argsort(kept["vertices"])
    fresh = np.sort(kept.pop("fresh"))
    kept = {name: array[order] for name, array in kept.items()} | {"fresh": fresh}
    return {"flows": True, **{f"flow_{name}": array for name, array in kept.items()}}


def restore_surface(
    mesh: TriangleMesh,
    state: Mapping[str, Any],
    progress: Callable[[float], None] | None = None,
) -> PaintedSurface:
    """Return the surface that `surface_state` described.

    Parameters
    ----------
    mesh : TriangleMesh
        The object as it was before painting.
    state : mapping
        Of this version or an older one. It is untrusted: everything is checked.
    progress : callable, optional
        Called with the fraction done, now and then; an exception from it stops the call.

    Raises
    ------
    SessionError
        If the state is newer than this program, incomplete, or belongs to another mesh.
    """
    try:
        state = _upgrade(dict(state))
        material = _as_record(Material, state["material"], load_materials())
        surface = PaintedSurface(mesh, state["resolution"], material, _original_in(state))
        palette = {**load_palette(), WATER.name: WATER}
        pigments = [_as_record(Pigment, entry, palette) for entry in state["pigments"]]
        if len(pigments) > _MOST_PIGMENTS or len({p.name for p in pigments}) < len(pigments):
            raise SessionError(
                "it has {n} pigments with repeated or too many names",
                n=len(pigments),
            )
        repeat_refinement(surface.paint_mesh, integers_in(state, "splits"), progress)
        if surface.n_vertices > surface.paint_mesh.n_base_vertices:
            surface.make_room()
        for pigment in pigments:
            surface.column_of(pigment)
        ink, shape = surface.ink, surface.ink.load.shape
        ink.load[:] = _amounts(state, "load", shape, np.float64, least=-ROUNDING)
        ink.off_surface[:] = _amounts(state, "off_surface", shape, np.float64, least=-MOST_INK)
        _put_brush(surface, state)
        _put_layers(surface, state)
        surface.recall_blocks(_saved_blocks(state, surface))
    except (KeyError, TypeError, AttributeError) as cause:
        raise SessionError("the surface's state is incomplete near {cause}", cause=cause) from None
    except SessionError:
        raise
    except Paint3DError as cause:
        raise SessionError("the surface's state cannot be used: {cause}", cause=cause) from None
    return surface


def _upgrade(state: State) -> State:
    version = state.get("version")
    if type(version) is not int or version < 1:
        raise SessionError(
            "the surface's state has version {version!r}; expected a number",
            version=version,
        )
    if version > STATE_VERSION:
        raise SessionError(
            "the surface's state has version {version}; this program knows up to {state_version}",
            version=version,
            state_version=STATE_VERSION,
        )
    while state["version"] < STATE_VERSION:
        state = UPGRADES[state["version"]](state)
    return state


def _put_layers(surface: PaintedSurface, state: State) -> None:
    """Restore the layers and the paint on each."""
    n = surface.n_vertices
    now = np.empty(n, np.int32)
    now[saved_ids(surface.paint_mesh)] = np.arange(n, dtype=np.int32)
    layers, active = state["layers"], state["active"]
    if layers is None:
        restore_layer(surface, state, now)
        return
    if type(active) is not int or not 0 <= active < len(layers):
        raise SessionError(
            "layer {active!r:.20} of {n} is painted on",
            active=active,
            n=len(layers),
        )
    stack = surface.use_layers()
    for place, about in enumerate(layers):
        about = dict(about)
        if place:
            stack.add(about["name"], place)
        known = {field.name for field in fields(Layer)}
        if not {"name", "visible", "locked"} <= set(about) <= known or not all(
            isinstance(about[name], bool) for name in ("visible", "locked")
        ):
            raise SessionError(
                "layer {place} is described by {about!r:.80}",
                place=place,
                about=about,
            )
        group = about.pop("group", None)
        stack.set_properties(place, **about)
        stack.put_in_group(place, None if group is None else read_group(group))
        prefix = "" if place == active else f"layer{place}_"
        own = {
            name.removeprefix(prefix): value
            for name, value in state.items()
            if name.startswith(prefix)
        }
        restore_layer(surface, own, now)
    if not stack.has_whole_groups:
        raise SessionError("a group of layers lies in two parts")
    stack.activate(active)
    surface.touch(stack.painted_ids())


def read_group(about: object) -> Group:
    """A group of layers as a file describes it.

    Raises
    ------
    SessionError
        If it describes none.
    """
    kinds = {"key": int, "name": str, "visible": bool, "folded": bool, "opacity": float,
             "blend": str}  # fmt: skip
    if not isinstance(about, dict) or {k: type(v) for k, v in about.items()} != kinds:
        raise SessionError("a group of layers is described by {about!r:.80}", about=about)
    group = Group(**about)
    in_range = 0.0 <= group.opacity <= 1.0 and 0 < len(group.name.strip()) <= MOST_NAME
    if group.key < 1 or group.blend not in BLENDS or not in_range:
        raise SessionError("a group of layers is described by {about!r:.80}", about=about)
    return group


def restore_layer(surface: PaintedSurface, state: State, now: NDArray[np.int32]) -> None:
    """Put the paint of a `layer_state` on the active layer, which must be empty.

    Parameters
    ----------
    surface : PaintedSurface
    state : mapping
        It is untrusted.
    now : (V,) int32
        The vertex of each number in the file.

    Raises
    ------
    SessionError
        If the state is invalid or belongs to another surface.
    """
    n, count, ink = len(now), len(surface.pigments), surface.ink
    wet = now[_vertices(state, "touched", n)]
    ink.amounts[wet] = _amounts(state, "amounts", (len(wet), count), np.float32)
    ink.coverage[wet] = _amounts(state, "coverage", (len(wet),), np.float32, 1.0)
    dry = now[_vertices(state, "dried", n)]
    spectra = _spectra(state, "dried_spectra", len(dry))
    amounts = _amounts(state, "dried_amounts", (len(dry), count), np.float32)
    coverage = _amounts(state, "dried_share", (len(dry),), np.float32, 1.0)
    if (len(wet) or len(dry)) and not count:
        raise SessionError("there is ink without pigments")
    over = None
    if surface.layers is not None:
        over = tuple(_spectra(state, name, len(dry)) for name in _OVER)
    capacity = surface.paint_mesh.capacity
    surface.dry_layers.restore(capacity, dry, spectra, amounts, coverage, over)
    surface.touch(np.concatenate([wet, dry[ink.coverage[dry] == 0.0]]))
    if state["flows"]:
        count = len(surface.pigments)
        surface.restore_flow(checked_flow(state, n, count, lambda ids: now[ids]))


def _spectra(state: Mapping[str, Any], name: str, n: int) -> NDArray[np.uint16]:
    spectra = np.asarray(state[name])
    if spectra.dtype != np.uint16 or spectra.shape != (n, N_BANDS):
        raise SessionError(
            "{name} is {spectra_dtype} {spectra_shape}",
            name=name,
            spectra_dtype=spectra.dtype,
            spectra_shape=spectra.shape,
        )
    return spectra


def _put_brush(surface: PaintedSurface, state: State) -> None:
    """Restore the ink along the tuft and the brush's transfer parameters."""
    ink = surface.ink
    n = len(np.atleast_1d(state["stations"]))
    if not 1 <= n <= MOST_RESERVOIRS:
        raise SessionError(
            "the brush has {n} stations; expected 1 to {most}",
            n=n,
            most=MOST_RESERVOIRS,
        )
    stations = _amounts(state, "stations", (n, len(ink.load)), np.float64, least=-ROUNDING)
    if n > 1 and not np.allclose(stations.sum(axis=0), ink.load, rtol=1e-6, atol=1e-9):
        raise SessionError("stations and load differ in what the brush holds")
    habit = _amounts(state, "habit", (len(BRUSH_TRANSFER),), np.float64)
    for name, value in zip(BRUSH_TRANSFER, habit, strict=True):
        ink.transfer[name] = value
    surface.ink = ink._replace(reservoirs=stations.copy())


def checked_flow(
    state: Mapping[str, Any],
    n_vertices: int,
    n_pigments: int,
    now: Callable[[AnyArray], AnyArray],
) -> dict[str, AnyArray]:
    """Check a file's ``flow_...`` arrays and return them for `PaintedSurface.restore_flow`.

    Parameters
    ----------
    state : mapping
    n_vertices, n_pigments : int
    now : callable
        Maps numbers (N,) in the file to vertices (N,).

    Raises
    ------
    SessionError
        If an array is not one that moving water could leave.
    """
    kept: dict[str, AnyArray]
    kept = {name: now(_vertices(state, f"flow_{name}", n_vertices)) for name in FLOW_VERTICES}
    shape: tuple[int, ...] = (len(kept["vertices"]),)
    for name, most in _FLOW.items():
        dtype = np.float64 if name == "water" else np.float32
        kept[name] = _amounts(state, f"flow_{name}", shape, np.float64, most).astype(dtype)
    kept["laid"] = kept["water"].astype(np.float32)  # in older files
    if "flow_laid" in state:
        kept["laid"] = _amounts(state, "flow_laid", shape, np.float32)
    shape = (*shape, n_pigments)
    kept["pigment"] = _amounts(state, "flow_pigment", shape, np.float64)
    kept["fine"] = USUAL_FINE * kept["pigment"]
    kept["loose"] = np.zeros_like(kept["pigment"])
    rest = kept["pigment"]
    for name in ("fine", "loose"):
        if f"flow_{name}" in state:  # missing in older files
            part = _amounts(state, f"flow_{name}", shape, np.float64)
            if (part > rest + 1e-6 * kept["pigment"]).any():
                raise SessionError(
                    "flow_{name} is more than flow_pigment; expected a part of it", name=name
                )
            kept[name] = np.minimum(part, rest)  # exceeds it by rounding at most
            rest = rest - kept[name]
    kept["written"] = _amounts(state, "flow_written", shape, np.float32)
    if not kept["pace"].all():
        raise SessionError("flow_pace is 0; expected a time")
    return kept


def _vertices(state: Mapping[str, Any], name: str, n: int) -> NDArray[np.int32]:
    """Return an array of distinct vertex numbers, 0 to n - 1."""
    ids = integers_in(state, name)
    if len(ids) and not 0 <= int(ids.min()) <= int(ids.max()) < n:
        raise SessionError(
            "{name} holds {least} to {most}; expected 0 to {last}",
            name=name,
            least=ids.min(),
            most=ids.max(),
            last=n - 1,
        )
    if np.bincount(ids, minlength=1).max() > 1:
        raise SessionError("{name} holds a vertex twice", name=name)
    return ids


def _amounts(
    state: Mapping[str, Any],
    name: str,
    shape: tuple[int, ...],
    dtype: type,
    most: float = MOST_INK,
    least: float = 0.0,
) -> AnyArray:
    values = as_array(state[name], name, shape, dtype, SessionError)
    if values.size and not least <= values.min() <= values.max() <= most:
        raise SessionError(
            "{name} holds {least:g} to {most:g}; expected {least_2:g} to {most_2:g}",
            name=name,
            least=values.min(),
            most=values.max(),
            least_2=least,
            most_2=most,
        )
    return values


def _saved_blocks(state: Mapping[str, Any], surface: PaintedSurface) -> NDArray[np.int32]:
    blocks = integers_in(state, "open_blocks")
    if len(blocks) and not 0 <= blocks.min() <= blocks.max() < surface.flow_graph.n_blocks:
        raise SessionError(
            "water was in blocks {least} to {most}; expected 0 to {n_blocks}",
            least=blocks.min(),
            most=blocks.max(),
            n_blocks=surface.flow_graph.n_blocks - 1,
        )
    return blocks


def integers_in(state: Mapping[str, Any], name: str) -> NDArray[np.int32]:
    """A saved (n,) int32 array; a SessionError where it is another."""
    values = np.asarray(state[name])
    if values.dtype != np.int32 or values.ndim != 1:
        raise SessionError(
            "{name} is {values_dtype} {values_shape}; expected (n,) int32",
            name=name,
            values_dtype=values.dtype,
            values_shape=values.shape,
        )
    return values


def _as_record(kind: type[_Record], entry: object, table: Mapping[str, _Record]) -> _Record:
    """Return the table's own record if it is equal (its colour tables apply), else a new one."""
    if not isinstance(entry, Mapping):
        raise SessionError(
            "a {kind} is {entry!r:.60}; expected its properties",
            kind=kind.__name__.lower(),
            entry=entry,
        )
    names = {field.name for field in fields(kind) if field.init}
    given = {key: value for key, value in entry.items() if key in names}
    if not all(isinstance(given.get(key, ""), str) for key in ("name", "chinese")):
        raise SessionError("a {kind} has a name that is no text", kind=kind.__name__.lower())
    try:
        record = kind(**given)
    except InputError as cause:
        raise SessionError(cause) from None
    own = table.get(record.name)
    if own is None:
        return record
    theirs, ours = record_words(record), record_words(own)
    if all(theirs[key] == ours[key] for key in given):  # older files lack some fields
        return own
    return record

"""Layers as in a paint program: named, shown or hidden, in any order, painted one at a time.

Every layer lies on those below it as if they had dried first, so it glazes over them and never
mixes with them; a lower layer shows through those above. The active layer, which is painted on, has
its ink in the surface's own arrays, so the engine knows nothing of layers. Of a resting layer only
the painted vertices are stored: wet ink as it is, and dried rows as functions of what is below
(`colour.kernels.glazing`). The visible result is composited from the bottom up, vertex by vertex,
with the kernels that paint one layer. Water moves on the active layer and waits on the others.

A layer's opacity mixes what shows with it and without it, band by band. A layer that multiplies
shows what it would over white, times what is below: opaque paint then glazes, too.

Layers that lie next to each other can be a group. A normal group passes through: its layers lie on
what is below the group as if there were none, and its opacity mixes what shows with all of them and
without. A group that multiplies is composited over white first.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.glazing import GlazeModel
from paint3d.colour.kernels.glazing import GROUNDS, SPECTRUM_STEPS, see_through
from paint3d.colour.spectra import N_BANDS
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import InputError
from paint3d.surface.dry_layers import DryLayers
from paint3d.surface.flow import Water
from paint3d.surface.ink_store import InkStore, union

__all__ = ["BLENDS", "MOST_NAME", "Group", "Layer", "LayerStack", "StackState", "group_span"]

BLENDS = ("normal", "multiply")
"""How a layer lies on those below it."""

MOST_NAME = 200
"""Characters in the name of a layer or a group."""

_MOST_LAYERS = 256
_NONE = -1  # key of no layer
_AT_ONCE = 1 << 16  # vertices composited per chunk


@dataclass(frozen=True)
class Group:
    """Properties of a group of layers.

    Attributes
    ----------
    key : int
        From 1; identifies it in its stack.
    name : str
    visible : bool
    folded : bool
        Whether a list shows the group without its layers.
    opacity : float
    blend : {"normal", "multiply"}
    """

    key: int
    name: str
    visible: bool = True
    folded: bool = False
    opacity: float = 1.0
    blend: str = "normal"

    @property
    def is_plain(self) -> bool:
        """Whether its layers show as if they were in no group."""
        return self.visible and self.opacity == 1.0 and self.blend == "normal"


@dataclass(frozen=True)
class Layer:
    """Name and flags of a layer.

    Attributes
    ----------
    name : str
    visible : bool
    locked : bool
        Whether painting on it is refused.
    opacity : float
        How much of it shows, 0 to 1.
    blend : {"normal", "multiply"}
    group : Group or None
        That it is in.
    """

    name: str
    visible: bool = True
    locked: bool = False
    opacity: float = 1.0
    blend: str = "normal"
    group: Group | None = None

    @property
    def is_seen(self) -> bool:
        """Whether it is shown, and so is its group."""
        return self.visible and (self.group is None or self.group.visible)

    @property
    def is_plain(self) -> bool:
        """Whether it shows as it was painted."""
        return self.opacity == 1.0 and self.blend == "normal"


def group_span(layers: Sequence[Layer], place: int) -> tuple[int, int]:
    """The places of the lowest and the uppermost layer of a group; of a layer in none, its own."""
    group = layers[place].group
    if group is None:
        return place, place
    places = [k for k, layer in enumerate(layers) if layer.group == group]
    return places[0], places[-1]


@dataclass(eq=False)
class _Content:
    """Paint of a resting layer: wet vertices (N,), dried rows and water."""

    dry: DryLayers
    ids: AnyArray = field(default_factory=lambda: np.empty(0, np.int32))
    amounts: AnyArray = field(default_factory=lambda: np.empty((0, 0), np.float32))
    coverage: AnyArray = field(default_factory=lambda: np.empty(0, np.float32))
    flow: Mapping[str, AnyArray] | None = None
    dry_ids: AnyArray = field(default_factory=lambda: np.empty(0, np.int32))  # sorted
    dry_rows: AnyArray = field(default_factory=lambda: np.empty(0, np.int32))  # row of each


class StackState(NamedTuple):
    """The layers in order, the lowest first, and the active one, by their keys.

    And the opacity and blend of each, and its group; empty where they stay as they are.
    """

    keys: tuple[int, ...]
    active: int
    looks: tuple[tuple[float, str], ...] = ()
    groups: tuple[Group | None, ...] = ()

    def exchange(self, surface: _Layered) -> tuple[StackState, AnyArray]:
        """Set the surface's stack to this state, as a part of an undo step."""
        return surface.use_layers().exchange(self)


class _Layered(Protocol):
    """Interface of a surface that can have layers."""

    def use_layers(self) -> LayerStack:
        """The stack."""
        ...


class LayerStack:
    """The layers of a surface, the lowest first; there is always at least one.

    A *place* is a layer's index in the stack; its key identifies it wherever it is moved.

    Parameters
    ----------
    store : InkStore
        The paint on it becomes the first layer.
    water : Water
        The water of the active layer.
    """

    def __init__(self, store: InkStore, water: Water) -> None:
        self._store, self._water = store, water
        self._about = {0: Layer("1")}
        self._contents: dict[int, _Content] = {}
        self._keys, self._active = [0], 0
        self._group_of: dict[int, int] = {}  # key of a layer to that of its group
        self._groups: dict[int, Group] = {}
        _add_filters(store)

    def __len__(self) -> int:
        return len(self._keys)

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Name and flags of each layer, the lowest first."""
        return tuple(replace(self._about[key], group=self._group(key)) for key in self._keys)

    @property
    def active(self) -> int:
        """Place of the active layer, from 0 for the lowest."""
        return self._keys.index(self._active)

    @property
    def is_plain(self) -> bool:
        """Whether there is one layer, and it is visible: nothing has to be composited."""
        (about, *others) = self.layers
        plain = about.group is None or about.group.is_plain
        return not others and about.visible and about.is_plain and plain

    @property
    def seen(self) -> tuple[tuple[int, float], ...]:
        """The keys of the visible layers, the lowest first, and how much of each shows."""
        return tuple((k, self._opacity(k)) for k in self._keys if self._is_seen(k))

    def _group(self, key: int) -> Group | None:
        """Return the group of a layer."""
        return self._groups[self._group_of[key]] if key in self._group_of else None

    def _is_seen(self, key: int) -> bool:
        group = self._group(key)
        return self._about[key].visible and (group is None or group.visible)

    def _opacity(self, key: int) -> float:
        group = self._group(key)
        return self._about[key].opacity * (1.0 if group is None else group.opacity)

    # -- editing the stack ------------------------------------------------------------------

    def add(self, name: str, place: int) -> None:
        """Insert an empty layer at a place and make it the active one.

        It joins the group that it comes to lie in, or the active layer's next to it.

        Raises
        ------
        InputError
            If the place or the name is invalid, or there are 256 layers.
        """
        self._check_room()
        if not 0 <= place <= len(self._keys):
            raise InputError("layer {place}; expected 0 to {n}", place=place, n=len(self._keys))
        key = max(self._about) + 1
        self._about[key] = Layer(_checked_name(name))
        self._contents[key] = _Content(DryLayers(len(self._store.pigments), filters=True))
        beside = self._active in self._keys[max(place - 1, 0) : place + 1]
        group = self._group_of.get(self._active, 0) if beside else 0
        self._keys.insert(place, key)
        self._join(key, group or self._group_around(place))
        self.activate(place)

    def _group_around(self, place: int) -> int:
        """Return the key of the group that both neighbours of a place are in; 0 for none."""
        sides = self._keys[max(place - 1, 0) : place], self._keys[place + 1 : place + 2]
        below, above = (self._group_of.get(side[0], 0) if side else 0 for side in sides)
        return below if below == above else 0

    def _join(self, key: int, group: int) -> None:
        """Put a layer in a group, or in none (0)."""
        self._group_of.pop(key, None)
        if group:
            self._group_of[key] = group

    def _check_room(self, more: int = 1) -> None:
        if len(self._keys) + more > _MOST_LAYERS:
            raise InputError("there are {most} layers; expected no more", most=_MOST_LAYERS)

    def duplicate(self, place: int, name: str) -> None:
        """Insert a copy of a layer above it, wet ink and water included, and make it active.

        Raises
        ------
        InputError
            If there is no layer at that place, the name is invalid, or there are 256 layers.
        """
        self._check_room()
        key, new = self._key(place), max(self._about) + 1
        about = replace(self._about[key], name=_checked_name(name), locked=False)
        self._contents[self._active] = self._unload()
        self._about[new] = about
        self._keys.insert(place + 1, new)
        self._join(new, self._group_of.get(key, 0))
        self._active = new
        self._load(copy.deepcopy(self._contents[key]))

    def merge(self, place: int, glaze: GlazeModel | None) -> None:
        """Lay a layer on the one below it for good, and make what comes of them active.

        Both must have dried. What they show together is kept as one coat, with their opacities and
        blends in it; the layer that comes of them shows plainly.

        Raises
        ------
        InputError
            If there is no layer at that place, or none below it, or one of them is in a group
            without the other.
        """
        upper = self._key(place)
        if place == 0:
            raise InputError("this is the lowest layer; expected one with another below it")
        if self._group_of.get(upper) != self._group_of.get(self._keys[place - 1]):
            raise InputError(
                "the layer below is in another group; expected both in one: move this one first"
            )
        lower, store, new = self._keys[place - 1], self._store, max(self._about) + 1
        self._contents[self._active] = self._unload()
        contents = [self._contents[key] for key in (lower, upper)]
        capacity, count = store.paint_mesh.capacity, len(store.pigments)
        ids = union([content.dry_ids for content in contents], capacity)
        over = tuple(
            np.full((len(ids), N_BANDS), round(grey * SPECTRUM_STEPS), np.uint16)
            for grey in GROUNDS
        )
        spectra = store.bare_spectra(ids)
        amounts = np.zeros((len(ids), count), np.float32)
        coverage = np.zeros(len(ids), np.float32)
        self._active = _NONE  # both rest
        for key in (lower, upper) if len(ids) else ():
            assert glaze is not None, "something has dried, so a pigment is known"
            for ground in (*over, spectra):
                self._lay_over(glaze, key, ids, ground)
            amounts += self._ink_of(key, ids)
            coverage = np.maximum(coverage, self._coverage_of(key, ids))
        dry = DryLayers(count, filters=True)
        dry.restore(capacity, ids, spectra, amounts, coverage, over)
        self._about[new] = Layer(self._about[lower].name)
        self._keys[place - 1 : place + 1] = [new]
        self._join(new, self._group_of.get(lower, 0))
        self._active = new
        self._load(_Content(dry))

    def remove(self, place: int) -> None:
        """Remove a layer with its paint.

        Raises
        ------
        InputError
            If there is no layer at that place, or it is the only one.
        """
        key = self._key(place)
        if len(self._keys) == 1:
            raise InputError("this is the only layer; expected another one to stay")
        if key == self._active:
            self.activate(place - 1 if place else 1)
        self._keys.remove(key)

    def move(self, place: int, to: int, within: int | None = None) -> None:
        """Move a layer to another place; the others keep their order.

        Parameters
        ----------
        place, to : int
        within : int, optional
            Place, before the move, of a layer whose group it joins; -1 for no group. By default it
            joins the group that it comes to lie in, else stays in its own where that is next to it.

        Raises
        ------
        InputError
            If there is no such place, or a group would lie in two parts.
        """
        key = self._key(place)
        self._key(to)
        if within is None or within < 0:
            group = 0
        else:
            group = self._group_key(within)
        before = list(self._keys), dict(self._group_of)
        self._keys.remove(key)
        self._keys.insert(to, key)
        if within is None:
            own = self._group_of.get(key, 0)
            beside = [*self._keys[max(to - 1, 0) : to], *self._keys[to + 1 : to + 2]]
            stays = own and any(self._group_of.get(other) == own for other in beside)
            group = self._group_around(to) or (own if stays else 0)
        self._join(key, group)
        self._check_groups(before)

    def _check_groups(self, before: tuple[list[int], dict[int, int]]) -> None:
        """Raise, and put keys and groups back, if a group lies in two parts."""
        order = [self._group_of.get(key, 0) for key in self._keys]
        if not _is_whole(order):
            self._keys, self._group_of = before
            raise InputError("a group would lie in two parts; expected its layers next to it")

    # -- groups -----------------------------------------------------------------------------

    def group(self, place: int, last: int, name: str) -> None:
        """Make a group of the layers from a place to the last.

        Raises
        ------
        InputError
            If there is no such layer, the name is invalid, or another group would lie in two parts.
        """
        self._key(place)
        self._key(last)
        if last < place:
            raise InputError("layers {place} to {last}; expected the lowest first",
                             place=place, last=last)  # fmt: skip
        new = Group(max(self._groups, default=0) + 1, _checked_name(name))
        before = list(self._keys), dict(self._group_of)
        for key in self._keys[place : last + 1]:
            self._group_of[key] = new.key
        self._check_groups(before)
        self._groups[new.key] = new

    def ungroup(self, place: int) -> None:
        """Dissolve the group of a layer; its layers stay where they are.

        Raises
        ------
        InputError
            If there is no layer at that place, or it is in no group.
        """
        group = self._group_key(place)
        for key in [key for key, own in self._group_of.items() if own == group]:
            if key in self._keys:
                del self._group_of[key]

    def duplicate_group(self, place: int, name: str) -> None:
        """Copy a group with its layers above it, and make the copy of its uppermost active.

        Raises
        ------
        InputError
            If there is no layer at that place, it is in no group, the name is invalid, or there are
            too many layers.
        """
        group, (first, last) = self._group_key(place), self.group_span(place)
        self._check_room(last - first + 1)
        about = replace(
            self._groups[group], key=max(self._groups) + 1, name=_checked_name(name), folded=False
        )
        self._groups[about.key] = about
        for k in range(first, last + 1):
            self.duplicate(k, self._about[self._keys[k]].name)
            self._keys.insert(last + 1 + k - first, self._keys.pop(k + 1))
            self._group_of[self._active] = about.key

    def move_group(self, place: int, to: int) -> None:
        """Move a group so that its lowest layer comes to lie at a place.

        Raises
        ------
        InputError
            If there is no layer at either place, the first is in no group, or another group would
            lie in two parts.
        """
        self._group_key(place)
        first, last = self.group_span(place)
        if not 0 <= to < len(self._keys) - (last - first):
            raise InputError(
                "layer {place}; expected 0 to {n}", place=to, n=len(self._keys) - 1 - (last - first)
            )
        before, moved = (list(self._keys), dict(self._group_of)), self._keys[first : last + 1]
        del self._keys[first : last + 1]
        self._keys[to:to] = moved
        self._check_groups(before)

    def remove_group(self, place: int) -> None:
        """Remove a group with its layers.

        Raises
        ------
        InputError
            If there is no layer at that place, it is in no group, or no other layer would stay.
        """
        self._group_key(place)
        first, last = self.group_span(place)
        if last - first + 1 == len(self._keys):
            raise InputError("these are all layers; expected another one to stay")
        for _ in range(first, last + 1):
            self.remove(first)

    def set_group_properties(self, place: int, **changes: Any) -> None:
        """Change what is said of the group of a layer: any attribute of a `Group` but its key.

        Raises
        ------
        InputError
            If there is no layer at that place, it is in no group, or a value is invalid.
        """
        group = self._group_key(place)
        self._groups[group] = replace(self._groups[group], **_checked(changes))

    def put_in_group(self, place: int, group: Group | None) -> None:
        """Put a layer in a group that is known from a file, or in none.

        Raises
        ------
        InputError
            If there is no layer at that place.
        """
        self._join(self._key(place), 0 if group is None else group.key)
        if group is not None:
            self._groups[group.key] = group

    def know_groups(self, groups: Sequence[Group | None]) -> None:
        """Hold groups for steps that lead back to them, so that no other takes the key of one.

        Raises
        ------
        InputError
            If one of them would lie in two parts.
        """
        if not _is_whole([0 if group is None else group.key for group in groups]):
            raise InputError("a group would lie in two parts; expected its layers next to it")
        for group in filter(None, groups):
            self._groups.setdefault(group.key, group)

    @property
    def has_whole_groups(self) -> bool:
        """Whether the layers of each group lie next to each other."""
        return _is_whole([self._group_of.get(key, 0) for key in self._keys])

    def group_span(self, place: int) -> tuple[int, int]:
        """Return the places of the lowest and the uppermost layer of a group.

        Raises
        ------
        InputError
            If there is no layer at that place, or it is in no group.
        """
        self._group_key(place)
        return group_span(self.layers, place)

    def _group_key(self, place: int) -> int:
        key = self._key(place)
        if key not in self._group_of:
            raise InputError("layer {place} is in no group; expected one of a group", place=place)
        return self._group_of[key]

    def set_properties(self, place: int, **changes: Any) -> None:
        """Change a layer's name, whether it is visible or locked, its opacity, or its blend.

        Raises
        ------
        InputError
            If there is no layer at that place, or the name or another value is invalid.
        """
        key = self._key(place)
        self._about[key] = replace(self._about[key], **_checked(changes))

    def activate(self, place: int) -> None:
        """Make the layer at a place the active one; nothing visible changes."""
        key = self._key(place)
        if key == self._active:
            return
        self._contents[self._active] = self._unload()
        self._active = key
        self._load(self._contents.pop(key))

    def state(self) -> StackState:
        """Return the state of the stack; it can be put back even after layers were removed."""
        looks = tuple((self._about[key].opacity, self._about[key].blend) for key in self._keys)
        groups = tuple(self._group(key) for key in self._keys)
        return StackState(tuple(self._keys), self._active, looks, groups)

    def exchange(self, state: StackState) -> tuple[StackState, AnyArray]:
        """Put a state; return the previous one and the vertices (N,) to recolour."""
        back, before = self.state(), self.painted_ids()
        self.put(state)
        touched = union([before, self.painted_ids()], self._store.paint_mesh.capacity)
        self._store.touch(touched)
        return back, touched

    def put(self, state: StackState) -> None:
        """Restore the layers of a state."""
        self._keys = [*dict.fromkeys([*state.keys, self._active])]
        self.activate(self._keys.index(state.active))
        self._keys = list(state.keys)
        for key, (opacity, blend) in zip(state.keys, state.looks, strict=False):
            self._about[key] = replace(self._about[key], opacity=opacity, blend=blend)
        for key, group in zip(state.keys, state.groups, strict=False):
            self._join(key, 0 if group is None else group.key)
            if group is not None:  # its name and the like are no steps
                own = self._groups.get(group.key, group)
                self._groups[group.key] = replace(own, opacity=group.opacity, blend=group.blend)

    def dry_by_key(self) -> dict[int, DryLayers]:
        """Return the dried paint of every known layer, including removed ones."""
        own = {key: content.dry for key, content in self._contents.items()}
        return own | {self._active: self._store.dry_layers}

    def _key(self, place: int) -> int:
        if not 0 <= place < len(self._keys):
            raise InputError(
                "layer {place}; expected 0 to {last}",
                place=place,
                last=len(self._keys) - 1,
            )
        return self._keys[place]

    def _unload(self) -> _Content:
        """Move the active layer's paint out of the surface's arrays."""
        store = self._store
        ink = store.ink
        ids = np.flatnonzero((ink.coverage > 0.0) | ink.amounts.any(axis=1)).astype(np.int32)
        dry = store.dry_layers
        order = np.argsort(dry.vertex_ids).astype(np.int32)
        content = _Content(
            dry, ids, ink.amounts[ids], ink.coverage[ids], self._water.keep(),
            dry.vertex_ids[order], order,
        )  # fmt: skip
        ink.amounts[ids] = 0.0
        ink.coverage[ids] = 0.0
        self._water.drop()
        dry.pack()
        return content

    def _load(self, content: _Content) -> None:
        """Move a resting layer's paint into the surface's arrays."""
        store = self._store
        count, ink = len(store.pigments), store.ink
        ink.amounts[content.ids, : content.amounts.shape[1]] = content.amounts
        ink.coverage[content.ids] = content.coverage
        store.dry_layers = content.dry
        store.dry_layers.fit(store.paint_mesh.capacity, count)
        if content.flow is not None:
            self._water.restore(content.flow)

    # -- compositing ------------------------------------------------------------------------

    def colour(self, glaze: GlazeModel, vertex_ids: AnyArray, srgb: AnyArray) -> None:
        """Fill `srgb` (cap, 3) for some distinct vertices (N,) int32."""
        for start in range(0, len(vertex_ids), _AT_ONCE):
            ids = vertex_ids[start : start + _AT_ONCE]
            srgb[ids] = self._codes(glaze, self.spectra(glaze, ids))

    def _codes(self, glaze: GlazeModel, spectra: AnyArray) -> NDArray[np.uint8]:
        """Return the sRGB (N, 3) of reflectances (N, 31): a ground under wet paint without ink."""
        n = len(spectra)
        every = np.arange(n, dtype=np.int32)
        ground = self._store.ground()._replace(
            slots=every, spectra=spectra, linear_rgb=np.empty((0, 3), np.float32)
        )
        codes = np.empty((n, 3), np.uint8)
        no_ink = np.zeros((n, len(self._store.pigments)), np.float32)
        glaze.srgb(no_ink, np.zeros(n, np.float32), ground, codes, every)
        return codes

    def colours_alone(
        self, glaze: GlazeModel, place: int
    ) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
        """Return the vertices (N,) with paint on a layer, and their sRGB (N, 3) with it alone.

        Raises
        ------
        InputError
            If there is no layer at that place.
        """
        key = self._key(place)
        if key == self._active:
            store = self._store
            sets: list[AnyArray] = [
                np.flatnonzero(store.coverage > 0.0), store.dry_layers.vertex_ids
            ]  # fmt: skip
        else:
            sets = [self._contents[key].ids, self._contents[key].dry_ids]
        ids = union(sets, self._store.paint_mesh.capacity)
        spectra = self._store.bare_spectra(ids)
        self._lay_plainly(glaze, key, ids, spectra)
        return ids, self._codes(glaze, spectra)

    def spectra(self, glaze: GlazeModel, vertex_ids: AnyArray) -> NDArray[np.uint16]:
        """Return the reflectance (N, 31) uint16 of distinct vertices, in steps of 1/65535."""
        spectra = self._store.bare_spectra(vertex_ids)
        for group, keys in self._runs():
            if group is None or group.is_plain:
                for key in keys:
                    self._lay_over(glaze, key, vertex_ids, spectra)
                continue
            shown = spectra.copy()
            if group.blend == "multiply":
                shown.fill(SPECTRUM_STEPS)
            for key in keys:
                self._lay_over(glaze, key, vertex_ids, shown)
            _mix(spectra, shown, group.opacity, group.blend)
        return spectra

    def _runs(self) -> list[tuple[Group | None, list[int]]]:
        """Return the visible layers, the lowest first, those of a group together with it."""
        runs: list[tuple[Group | None, list[int]]] = []
        for key in filter(self._is_seen, self._keys):
            group = self._group(key)
            if runs and runs[-1][0] == group:
                runs[-1][1].append(key)
            else:
                runs.append((group, [key]))
        return runs

    def _lay_over(self, glaze: GlazeModel, key: int, ids: AnyArray, spectra: AnyArray) -> None:
        """Composite one layer over the spectra (N, 31) of vertices (N,), in place."""
        about = self._about[key]
        if about.is_plain:
            self._lay_plainly(glaze, key, ids, spectra)
            return
        shown = spectra.copy()
        if about.blend == "multiply":
            shown.fill(SPECTRUM_STEPS)
        self._lay_plainly(glaze, key, ids, shown)
        _mix(spectra, shown, about.opacity, about.blend)

    def _lay_plainly(self, glaze: GlazeModel, key: int, ids: AnyArray, spectra: AnyArray) -> None:
        """Composite one layer as it was painted; see `_lay_over`."""
        dry, rows, wet, amounts, coverage = self._paint_at(key, ids)
        dried = np.flatnonzero(rows >= 0).astype(np.int32)
        if len(dried):
            see_through(dried, rows[dried], *dry.over, spectra)
        if len(wet):
            ground = self._store.ground()._replace(
                slots=wet, spectra=spectra, linear_rgb=np.empty((0, 3), np.float32)
            )
            every = np.arange(len(wet), dtype=np.int32)
            seen = self._store.seen_amounts(ids[wet], amounts, coverage)
            glaze.dry(seen, coverage, ground, every, wet)

    def _paint_at(
        self, key: int, ids: AnyArray
    ) -> tuple[DryLayers, AnyArray, AnyArray, AnyArray, AnyArray]:
        """Return a layer's dried paint and its wet paint on vertices (N,).

        Returns
        -------
        dry : DryLayers
        rows : (N,) int32
            Rows of `dry`, -1 where nothing has dried.
        wet : (M,) int32
            Indices into `ids` of the vertices with wet ink.
        amounts, coverage : (M, P) float32, (M,) float32
        """
        store, count = self._store, len(self._store.pigments)
        if key == self._active:
            ink, dry = store.ink, store.dry_layers
            wet = np.flatnonzero(ink.coverage[ids] > 0.0).astype(np.int32)
            return dry, dry.rows_of(ids), wet, ink.amounts[ids[wet]], ink.coverage[ids[wet]]
        content = self._contents[key]
        rows = np.full(len(ids), -1, np.int32)
        at, dried = _find(content.dry_ids, ids)
        rows[dried] = content.dry_rows[at]
        at, wet = _find(content.ids, ids)
        amounts = content.amounts[at]
        amounts = np.pad(amounts, ((0, 0), (0, count - amounts.shape[1])))
        return content.dry, rows, wet, amounts, content.coverage[at]

    def painted_ids(self) -> NDArray[np.int32]:
        """Return the vertices (N,) int32 with paint on any layer, visible or not."""
        store = self._store
        sets: list[AnyArray] = [np.flatnonzero(store.coverage > 0.0), store.dry_layers.vertex_ids]
        for content in self._resting():
            sets += [content.ids, content.dry_ids]
        return union(sets, store.paint_mesh.capacity)

    def paint_on(self, place: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the ink (V, P) of a layer, wet and dry, and the fraction (V,) that it covers.

        Ink is in coats times the covered fraction.

        Raises
        ------
        InputError
            If there is no layer at that place.
        """
        ids = np.arange(self._store.n_vertices, dtype=np.int32)
        key = self._key(place)
        return self._ink_of(key, ids), self._coverage_of(key, ids)

    def coverage_at(self, vertex_ids: AnyArray) -> NDArray[np.float32]:
        """Return the greatest fraction (N,) of vertices that paint on visible layers covers."""
        coverage = np.zeros(len(vertex_ids), np.float32)
        for key in filter(self._is_seen, self._keys):
            shows = np.float32(self._opacity(key))
            coverage = np.maximum(coverage, shows * self._coverage_of(key, vertex_ids))
        return coverage

    def _coverage_of(self, key: int, ids: AnyArray) -> NDArray[np.float32]:
        """Return the fraction (N,) of vertices that one layer's paint covers, wet or dry."""
        covered = np.zeros(len(ids), np.float32)
        dry, rows, wet, _, coverage = self._paint_at(key, ids)
        dried = np.flatnonzero(rows >= 0)
        covered[dried] = dry.coverage[rows[dried]]
        covered[wet] = np.maximum(covered[wet], coverage)
        return covered

    def coats_at(self, vertex_ids: AnyArray) -> NDArray[np.float64]:
        """Return the ink (N, P) of all visible layers on vertices (N,), wet and dry.

        In coats times the covered fraction.
        """
        coats = np.zeros((len(vertex_ids), len(self._store.pigments)))
        for key in filter(self._is_seen, self._keys):
            coats += self._ink_of(key, vertex_ids)
        return coats

    def _ink_of(self, key: int, ids: AnyArray) -> NDArray[np.float32]:
        """Return the ink (N, P) of one layer on vertices (N,), wet and dry, as `coats_at` does."""
        dry, rows, wet, wet_amounts, _ = self._paint_at(key, ids)
        amounts = np.zeros((len(ids), len(self._store.pigments)), np.float32)
        dried = np.flatnonzero(rows >= 0)
        amounts[dried, : dry.amounts.shape[1]] = dry.amounts[rows[dried]]
        amounts[wet] += wet_amounts
        return amounts

    def parts_at(self, vertex_id: int) -> AnyArray:
        """Return the wet, else dry ink (P,) of the topmost visible layer with any on a vertex."""
        ids = np.array([vertex_id], np.int32)
        for key in reversed(self._keys):
            if not self._is_seen(key):
                continue
            dry, rows, _, amounts, _ = self._paint_at(key, ids)
            if amounts.any():
                return np.asarray(amounts[0], np.float64)
            if rows[0] >= 0:
                parts = np.zeros(len(self._store.pigments))
                parts[: dry.amounts.shape[1]] = dry.amounts[rows[0]]  # pigments may have come since
                return parts
        return np.zeros(len(self._store.pigments))

    # -- ink balance ------------------------------------------------------------------------

    def resting_ink(self, areas: AnyArray, lasting: AnyArray) -> tuple[float, float]:
        """Return the wet and the dry pigment on the resting layers, coats x mm2."""
        wet = dry = 0.0
        for content in self._resting():
            columns = lasting[: content.amounts.shape[1]].astype(np.float64)
            wet += float(areas[content.ids] @ (content.amounts @ columns))
            amounts = content.dry.amounts.sum(axis=1, dtype=np.float64)
            dry += float(areas[content.dry.vertex_ids] @ amounts)
        return wet, dry

    def add_coverage(self, coverage: AnyArray) -> None:
        """Raise `coverage` (V,) to the fraction covered by resting layers, visible or not."""
        for content in self._resting():
            for ids, own in (
                (content.ids, content.coverage),
                (content.dry.vertex_ids, content.dry.coverage),
            ):
                coverage[ids] = np.maximum(coverage[ids], own)

    def _resting(self) -> Sequence[_Content]:
        return [self._contents[key] for key in self._keys if key != self._active]


def _mix(below: AnyArray, shown: AnyArray, opacity: float, blend: str) -> None:
    """Mix reflectances (N, 31) with what they show under a layer or a group, in place."""
    without, above = below.astype(np.float64), shown.astype(np.float64)
    if blend == "multiply":
        above *= without / SPECTRUM_STEPS
    below[:] = np.rint(without + opacity * (above - without))


def _is_whole(groups: Sequence[int]) -> bool:
    """Whether equal numbers, but 0, lie next to each other."""
    runs = [g for k, g in enumerate(groups) if g and (k == 0 or groups[k - 1] != g)]
    return len(runs) == len(set(runs))


def _checked(changes: dict[str, Any]) -> dict[str, Any]:
    """Changes to a layer or a group, once they are valid."""
    if "name" in changes:
        _checked_name(changes["name"])
    if "opacity" in changes:
        changes["opacity"] = as_number(changes["opacity"], "opacity", 0.0, 1.0)
    if changes.get("blend", BLENDS[0]) not in BLENDS:
        raise InputError(
            "blend is {blend!r}; expected {known}",
            blend=changes["blend"],
            known=" or ".join(BLENDS),
        )
    return changes


def _checked_name(name: object) -> str:
    if not isinstance(name, str) or not 0 < len(name.strip()) <= MOST_NAME:
        raise InputError("a layer's name is {name!r:.60}; expected a word", name=name)
    return name


def _find(known: AnyArray, ids: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Intersect sorted `known` (K,) with `ids` (N,); return the indices of matches in both."""
    if not len(known):
        return np.empty(0, np.int64), np.empty(0, np.int32)
    at = np.minimum(np.searchsorted(known, ids), len(known) - 1)
    found = np.flatnonzero(known[at] == ids).astype(np.int32)
    return at[found], found


def _add_filters(store: InkStore) -> None:
    """Compute what the dried rows of a surface show over the grey grounds.

    Everything that dried on a vertex is taken as one mixed coat: its order is not known.
    """
    dry = store.dry_layers
    if dry.has_filters:
        return
    over = tuple(np.zeros((dry.count, N_BANDS), np.uint16) for _ in GROUNDS)
    rows, covered = np.arange(dry.count, dtype=np.int32), dry.coverage.copy()
    bare = store.ground()._replace(
        slots=np.empty(0, np.int32), linear_rgb=np.empty((0, 3), np.float32)
    )
    for grey, array in zip(GROUNDS, over, strict=True):
        if dry.count:
            ground = bare._replace(spectra=array, material=np.full(N_BANDS, grey, np.float32))
            assert store.glaze is not None, "something has dried, so a pigment is known"
            seen = store.seen_amounts(dry.vertex_ids, dry.amounts.copy(), covered)
            store.glaze.dry(seen, covered, ground, rows, rows)
    dry.add_filters(over)

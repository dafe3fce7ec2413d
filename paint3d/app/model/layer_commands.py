"""What can be done with a document's layers."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

from paint3d.errors import InputError, LayerError
from paint3d.painter.painter import Painter
from paint3d.surface.ink_store import union
from paint3d.surface.layer_stack import Layer, LayerStack
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory

__all__ = ["LayerCommands"]


class LayerCommands:
    """Layers of a `Document`."""

    surface: PaintedSurface
    painter: Painter
    modified: bool
    differ_from_saved: Callable[[], None]
    _undo: UndoHistory
    _passing: bool
    _refuse_in_stroke: Callable[[str], None]
    _gather: Callable[[], None]

    @property
    def layers(self) -> tuple[Layer, ...]:
        """What is said of each layer, the lowest first."""
        return self.surface.use_layers().layers

    @property
    def active_layer(self) -> int:
        """Place of the layer that is painted on, from 0 for the lowest."""
        return self.surface.use_layers().active

    def select_layer(self, place: int) -> None:
        """Paint on another layer from now on.

        Raises
        ------
        InputError
            If there is none at that place, or a stroke is going on.
        """
        self._restack(None, lambda stack: stack.activate(place))

    def add_layer(self, name: str | None = None, place: int | None = None) -> None:
        """Put an empty layer above the one that is painted on, or at a place, and paint on it.

        Raises
        ------
        InputError
            If the name or the place is none, or there are too many.
        """
        names = {layer.name for layer in self.layers}
        name = name or next(str(n) for n in count(1) if str(n) not in names)
        place = self.active_layer + 1 if place is None else place
        self._restack("add layer", lambda stack: stack.add(name, place))

    def remove_layer(self, place: int) -> None:
        """Take a layer away with what is on it: a step that can be undone.

        Raises
        ------
        InputError
            If there is none at that place, it is the only one, or a stroke is going on.
        """
        self._restack("remove layer", lambda stack: stack.remove(place))

    def move_layer(self, place: int, to: int) -> None:
        """Put a layer at another place: a step that can be undone.

        Raises
        ------
        InputError
            If there is no such place, or a stroke is going on.
        """
        self._restack("move layer", lambda stack: stack.move(place, to))

    def rename_layer(self, place: int, name: str) -> None:
        """Name a layer."""
        self.surface.use_layers().describe(place, name=name)
        self.differ_from_saved()

    def set_visible(self, place: int, visible: bool = True) -> None:
        """Show or hide a layer.

        Raises
        ------
        InputError
            If there is none at that place, or a stroke is going on.
        """
        self._refuse_in_stroke("showing or hiding a layer")
        self.surface.use_layers().describe(place, visible=bool(visible))
        self.surface.touch(self.surface.use_layers().painted_ids())
        self.differ_from_saved()

    def set_locked(self, place: int, locked: bool = True) -> None:
        """Refuse painting on a layer, or allow it again."""
        self.surface.use_layers().describe(place, locked=bool(locked))
        self.differ_from_saved()

    def _restack(self, step: str | None, action: Callable[[LayerStack], None]) -> None:
        """Change which layers there are; ink that goes or comes with them is no longer loaded."""
        self._refuse_in_stroke("another order of layers")
        if step is not None and self._passing:
            raise InputError(f"{step} was asked for during a replay; expected its end first")
        surface, painter = self.surface, self.painter
        stack = surface.use_layers()
        self._gather()
        if step is not None:
            self._undo.begin(step)
        before, shown = surface.wet_ink() + surface.dry_ink(), stack.painted_ids()
        self._undo.change(stack.state, lambda: action(stack))
        painter.loaded += surface.wet_ink() + surface.dry_ink() - before
        if step is not None:
            surface.touch(union([shown, stack.painted_ids()], surface.paint_mesh.capacity))
            self.modified = True
        else:
            self.differ_from_saved()

    def _paintable(self) -> Layer:
        """The layer that is painted on."""
        layer = self.layers[self.active_layer]
        for state, why in ((layer.locked, "locked"), (not layer.visible, "hidden")):
            if state:
                raise LayerError(layer.name, why)
        return layer

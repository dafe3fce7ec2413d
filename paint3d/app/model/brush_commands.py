"""What can be done with a document's brush and inks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from paint3d.app.model.brush_size import resized, scaled, stepped
from paint3d.app.model.persistence.brush_words import brush_from_words
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import as_number
from paint3d.errors import InputError
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

Ink = str | Pigment | Mapping[Any, float]

_MOST_PICKUP = 1000.0  # 1/mm, as in recordings

__all__ = ["BrushCommands", "Ink"]


class BrushCommands:
    """Brush and ink of a `Document`."""

    surface: PaintedSurface
    painter: Painter
    inks: list[Ink]
    _dipped: bool
    _refuse_in_stroke: Callable[[str], None]

    def set_brush(self, brush: str | BrushSpec | Mapping[str, Any]) -> None:
        """Take another brush, dipped in the same ink.

        Raises
        ------
        InputError
            If a stroke is going on, or there is no such brush.
        """
        self._refuse_in_stroke("another brush")
        if isinstance(brush, Mapping):
            brush = brush_from_words(brush)
        elif isinstance(brush, str):  # it may be that of a session, which names no file
            brush = load_brush(brush, own_files=False)
        self.painter.change_brush(brush)
        self._dipped = True

    def scale_brush(self, factor: float) -> None:
        """Take the brush so many times as large; see `brush_size.scaled`."""
        self.set_brush(scaled(self.painter.brush, factor))

    def resize_brush(self, length_mm: float) -> None:
        """Take the brush with a tuft of this length."""
        self.set_brush(resized(self.painter.brush, length_mm))

    def step_brush(self, steps: int) -> None:
        """Take the brush larger or smaller by some presses of ] or [, as far as it goes."""
        self.set_brush(stepped(self.painter.brush, steps))

    def set_azimuth(self, azimuth: str) -> None:
        """Let the pose's roll turn the tuft ("commanded"), or the surface pull it ("dragged").

        Raises
        ------
        InputError
            If it is neither, or a stroke is going on.
        """
        self._refuse_in_stroke("another azimuth")
        if azimuth not in ("commanded", "dragged"):
            raise InputError(f"azimuth is {azimuth!r}; expected 'commanded' or 'dragged'")
        self.painter.azimuth = azimuth

    def set_pickup(self, pickup: float) -> None:
        """Let the brush take up wet ink: so large a share per mm of way at full pressure.

        Raises
        ------
        InputError
            If it is below 0 or over 1000, or a stroke is going on.
        """
        self._refuse_in_stroke("another pick-up")
        share = as_number(pickup, "pickup (1/mm)", 0.0, _MOST_PICKUP)
        self.surface.ink.transfer["pickup"] = share

    @property
    def pickup(self) -> float:
        """Share of the wet ink under the brush that it takes up per mm of way at full pressure."""
        return float(self.surface.ink.transfer["pickup"].item())

    def dip(
        self,
        ink: Ink | None = None,
        reach: float | None = None,
        amount: Mapping[str, float] | None = None,
    ) -> None:
        """Dip the brush; see `Painter.dip`. During a stroke it is dipped where it is.

        `amount` is what `DipAmount.words` gives.
        """
        self.painter.dip(ink, reach, None if amount is None else DipAmount.of(amount))
        self._dipped = True
        if ink is not None:
            self.inks[0] = ink

    def rinse(self) -> None:
        """Wash the brush out."""
        self.painter.rinse()

    def wipe(self, share: float = 0.5) -> None:
        """Wipe a share of the ink off the brush, 0 to 1."""
        self.painter.wipe(share)

    def swap_inks(self) -> None:
        """Dip the brush in the other ink."""
        self._refuse_in_stroke("another ink")
        self.inks.reverse()
        self.dip(self.inks[0])

    def pick_colour(self, vertex_id: int) -> dict[str, float] | None:
        """Dip the brush in what is on a vertex, as it is mixed there; what that is.

        Returns
        -------
        dict or None
            Parts of the inks by name, of sum 1; None where there is no paint, and nothing is
            done.

        Raises
        ------
        InputError
            If there is no such vertex.
        """
        surface = self.surface
        if not 0 <= vertex_id < surface.n_vertices:
            raise InputError(f"vertex {vertex_id}; expected 0 to {surface.n_vertices - 1}")
        parts = surface.parts_at(vertex_id)
        if not parts.any():
            return None
        parts /= parts.sum()
        found = {p: float(w) for p, w in zip(surface.pigments, parts, strict=True) if w > 1e-3}
        self.dip(found)
        return {pigment.name: part for pigment, part in found.items()}

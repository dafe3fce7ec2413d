"""Commands of brush, ink, strokes and layers, each by the name of its action."""

from __future__ import annotations

from collections.abc import Callable

from paint3d.app.model.frame import Snapshot
from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick, face_at, nearest_vertex
from paint3d.app.window.history.stroke_editing import Recalling
from paint3d.app.window.ink.ink_panel import TIP_REACH
from paint3d.app.window.job import JobProgress, result_of
from paint3d.app.window.panels import Panels
from paint3d.app.window.playing.player import Player
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.brush.presets import brush_names
from paint3d.colour.pigments import WATER
from paint3d.core.arrays import AnyArray
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.view.camera import picture_axes

__all__ = ["PaintActions"]

_STEADY = 0.4
_TURNS = 6
_MASK_DEGREES = 75.0
_PATIENCE_S = 0.3  # that the window waits for a step of the painting


class PaintActions:
    """Commands that act on the painting; ``do_<action>`` for each."""

    def __init__(
        self, workspace: Workspace, panels: Panels, recalling: Recalling, player: Player
    ) -> None:
        self._workspace, self._panels = workspace, panels
        self._recalling, self._player = recalling, player
        self._turns, self._mask_degrees = _TURNS, _MASK_DEGREES

    def _post(self, command: str, *arguments: object) -> None:
        self._workspace.post(command, *arguments)

    @property
    def _painting(self) -> Snapshot:
        return self._workspace.painting

    # -- edit -------------------------------------------------------------------------------

    def do_undo(self) -> None:
        """Undo the last step; of a replay, as far as it came."""
        if self._workspace.stage.paint_thread is None:
            return
        self._player.take_back()
        self._recalling.undo()

    def do_cancel_stroke(self) -> None:
        """Take back the current stroke, or stop a replay; give the focus to the picture.

        A chosen stroke is no longer marked.
        """
        self._workspace.hand.cancel()
        self._player.do_stop()
        self._panels.history.stop()
        self._panels.history.chosen.emit(None)
        self._workspace.canvas.setFocus()

    # -- brush ------------------------------------------------------------------------------

    def do_smaller(self) -> None:
        """Take a smaller brush of the same kind."""
        self._post("step_brush", -1)

    def do_larger(self) -> None:
        """Take a larger brush of the same kind."""
        self._post("step_brush", 1)

    def do_smoothing(self, on: bool) -> None:
        """Switch the steadying of strokes by a string."""
        self._panels.hand.set_smoothing(_STEADY if on else 0.0)

    def do_ruler(self, on: bool) -> None:
        """Switch the ruler that strokes follow."""
        self._panels.hand.set_ruler(on)

    def do_number(self, k: int) -> None:
        """Take the k-th brush."""
        self._post("set_brush", brush_names()[k - 1])

    # -- ink --------------------------------------------------------------------------------

    def do_dip(self) -> None:
        """Load the brush again."""
        self._workspace.dip()

    def do_dip_tip(self) -> None:
        """Load its tip again."""
        self._workspace.dip(None, TIP_REACH)

    def do_dip_water(self) -> None:
        """Dip the brush in clear water: a water brush."""
        self._workspace.dip({WATER.name: 1.0})

    def do_erase(self, on: bool) -> None:
        """Take paint off with the brush, or put ink on again."""
        self._workspace.hand.erases = on
        self._workspace.canvas.update()  # its plate says so
        self._workspace.tell(
            say("The brush takes paint off the layer; E puts ink on again")
            if on
            else say("The brush puts ink on again")
        )

    def do_pick_colour(self) -> None:
        """Take the ink that lies under the pointer."""
        vertex = self._look_up(nearest_vertex)
        if vertex is not None:
            self._post("pick_colour", vertex)

    def do_wet(self, on: bool) -> None:
        """Switch whether ink spreads in real time; a setting for later paintings, too."""
        self._workspace.update_settings(wet=on)
        if self._workspace.stage.paint_thread is not None:
            self._workspace.stage.paint_thread.wet = on

    # -- stroke -----------------------------------------------------------------------------

    def do_mirror(self, on: bool) -> None:
        """Paint left and right at once, or not."""
        self._set_symmetry(mirror=on)

    def do_radial(self, on: bool) -> None:
        """Paint all around at once, or not."""
        self._set_symmetry(radial=on)

    def _set_symmetry(self, mirror: bool | None = None, radial: bool | None = None) -> None:
        points = self._workspace.stage.points
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        middle = tuple(float(x) for x in middle)
        actions = self._workspace.actions
        mirror = actions["mirror"].isChecked() if mirror is None else mirror
        radial = actions["radial"].isChecked() if radial is None else radial
        planes = (MirrorPlane(middle, (1.0, 0.0, 0.0)),) if mirror else ()
        turned = RadialSymmetry(self._turns, middle) if radial else None
        self._post("set_symmetry", Symmetry(planes, turned))

    def set_turns(self, turns: int) -> None:
        """Set how often a stroke is painted around the axis."""
        self._turns = turns
        if self._workspace.actions["radial"].isChecked():
            self.do_radial(True)

    def do_mask(self, on: bool) -> None:
        """Take paint only where the surface faces the viewer, or everywhere again."""
        angle = None
        if on:
            back = picture_axes(self._workspace.hand.open_camera)[2]
            angle = AngleMask((float(back[0]), float(back[1]), float(back[2])), self._mask_degrees)
        mask = self._painting.mask
        self._post("set_mask", Mask(angle, mask.regions, mask.inverted))

    def set_mask_degrees(self, degrees: float) -> None:
        """Set the angle to the viewer up to which the surface takes paint, degrees."""
        self._mask_degrees = degrees
        if self._workspace.actions["mask"].isChecked():
            self.do_mask(True)

    def do_pick_region(self) -> None:
        """Take paint only in the region under the pointer, and in those picked before."""
        face = self._look_up(lambda mesh, place: face_at(mesh, nearest_vertex(mesh, place)))
        if face is None:
            return
        mask = self._painting.mask
        regions = (*mask.regions, RegionPick(face))
        self._post("set_mask", Mask(mask.angle, regions, mask.inverted))
        self._workspace.tell(say("Regions that take paint: {n}", n=len(regions)))

    def _look_up(self, what: Callable[[PaintMesh, AnyArray], int]) -> int | None:
        """Look up something under the pointer; None beside the object, or while painting."""
        point = self._workspace.hand.place()
        if point is None:
            return None
        with self._workspace.paint_thread.paused(_PATIENCE_S) as document:
            if document is not None:
                return what(document.surface.paint_mesh, point)
        self._workspace.tell(say("Still painting; try again in a moment"), state="slow")
        return None

    def do_clear_mask(self) -> None:
        """Take paint everywhere."""
        self._workspace.actions["mask"].setChecked(False)
        self._post("set_mask", Mask())
        self._workspace.tell(say("Paint is taken everywhere"))

    def do_refine(self) -> None:
        """Refine the whole surface now, with a bar; if it is stopped, it is as it was."""
        workspace = self._workspace
        paint_thread = workspace.paint_thread

        def work(progress: JobProgress) -> None:
            result_of(
                paint_thread.post(lambda document: document.surface.refine_all(progress)), progress
            )

        if workspace.went_well(workspace.run(say("Refining the surface…"), work)):
            count = self._painting.n_vertices
            workspace.tell(say("{count:,} vertices", count=count), state="good")

    # -- layers -----------------------------------------------------------------------------

    def do_remove_layer(self) -> None:
        """Remove the active layer, or the chosen group."""
        self._panels.layers.remove()

    def do_duplicate_layer(self) -> None:
        """Put a copy of the active layer, or of the chosen group, above it."""
        self._panels.layers.duplicate()

    def do_merge_layer(self) -> None:
        """Merge the active layer with the one below."""
        self._post("merge_layer", self._painting.active_layer)

    def do_add_group(self) -> None:
        """Make a group of the chosen layers."""
        self._panels.layers.group()

    def do_ungroup(self) -> None:
        """Dissolve the chosen group, or that of the layer that is painted on."""
        self._panels.layers.ungroup()

    def do_rename_layer(self) -> None:
        """Edit the layer's name."""
        self._panels.layers.rename()

    def do_layer_above(self) -> None:
        """Paint on the layer above."""
        self._select(1)

    def do_layer_below(self) -> None:
        """Paint on the layer below."""
        self._select(-1)

    def _select(self, by: int) -> None:
        index = self._painting.active_layer + by
        if 0 <= index < len(self._painting.layers):
            self._post("select_layer", index)

    def do_raise_layer(self) -> None:
        """Move the layer above the next one, or into a group or out of it."""
        self._panels.layers.step(1)

    def do_lower_layer(self) -> None:
        """Move the layer below the next one, or into a group or out of it."""
        self._panels.layers.step(-1)

    def do_hide_layer(self) -> None:
        """Show or hide the layer, or the chosen group."""
        self._panels.layers.hide_or_show()

    def do_lock_layer(self) -> None:
        """Lock or unlock the layer."""
        self._panels.layers.lock_or_unlock()


for _k in range(1, 1 + len(brush_names())):
    setattr(
        PaintActions,
        f"do_brush_{_k}",
        lambda self, k=_k: self.do_number(k),
    )

"""The brush in the live scene: tuft, ink, handle, shadow and footprint outline."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.bristles.bend import Bristles
from paint3d.brush_engine.tuft import Tuft
from paint3d.core.arrays import AnyArray, cross
from paint3d.core.polyline import arc_lengths, interpolate
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.view.brush_shape import (
    AROUND,
    BrushStand,
    SingleHairs,
    grid_faces,
    grid_normals,
    handle_rings,
    torn_faces,
    tuft_rings,
)
from paint3d.view.camera import Camera, picture_axes
from paint3d.view.kernels.drape import drape_points
from paint3d.view.live_layers import Box
from paint3d.view.live_scene import LiveScene
from paint3d.view.vtk_parts import DrawnMesh

__all__ = ["HAIR_COLOURS", "LiveBrush", "fade_along", "laid_rings"]

HAIR_COLOURS = {"goat": (232, 224, 204), "weasel": (164, 106, 58), "mixed": (205, 172, 124)}
_SHADOW_FALL = np.array([0.45, 0.40, -0.80])  # studio axes: away from the key light
_GRAZING = 0.45  # cosine of incidence below which the shadow fades
_SHADOW_LIFT = 0.10  # mm above the surface
_OUTLINE_LIFT = 0.16
_HAIR_LIFT = 0.12
_LYING = 0.45  # height, in tuft lengths, up to which rings follow the surface
_STEEPEST = 0.2  # least cosine of the surface's slope under a ring
_ABOVE = 0.6  # height, in tuft lengths, that rays to the surface start from
_BELOW = 2.3  # times that height: how far below the plane they end
_DARKEST = 140  # of 255: opacity of the shadow where the brush is pressed hardest
_DENSE = {
    "handle": (40.0, 150.0, 255.0), "tuft": (105.0, 215.0, 255.0), "hairs": (26.0, 130.0, 255.0),
}  # fmt: skip
"""Of 255: how dense a part is over what was painted just now, else while painting, and lifted."""
_CLEAR, _FADE = 1.5, 3.0  # radii of a section beside what was painted: clear up to, dense from
_SOLID = 254.0
_SECTION = 0.05  # tuft lengths between two sections of the handle that fade by themselves
_SHADOW_REACH = 220.0  # mm
_SOFT = np.array([-1.6, -0.9, 0.0, 0.9, 1.6])  # radii across the shadow
_SOFT_SHARE = np.array([0.0, 0.75, 1.0, 0.75, 0.0])
_PARTS = ("tuft", "hairs", "handle", "shadow", "outline")
_LINE_WIDTHS = (1.0, 24.0)  # pixels
_OUTLINE = (198, 60, 40, 235)  # seal red
_HOVER = (60, 60, 60, 200)
_NOTHING = np.empty((0, 3))


class LiveBrush:
    """The model of one brush in a scene; hidden until `show`.

    Parameters
    ----------
    scene : LiveScene
    tuft : Tuft
    hair : str
        Kind of hair: a key of `HAIR_COLOURS`.
    bristles : Bristles, optional
        Its single hairs, to be drawn as lines; without them the tuft is drawn as a solid.
    as_filmed : bool
        Draw it as somebody who looks on sees it: dense wherever it stands, and without its outline.
    """

    def __init__(
        self,
        scene: LiveScene,
        tuft: Tuft,
        hair: str = "mixed",
        bristles: Bristles | None = None,
        as_filmed: bool = False,
    ) -> None:
        self._tuft, self._as_filmed = tuft, as_filmed
        self.hairs = None if bristles is None else SingleHairs(tuft, bristles, AROUND)
        self._hair = np.array(HAIR_COLOURS.get(hair, HAIR_COLOURS["mixed"]), np.float64)
        self._parts = {name: DrawnMesh() for name in _PARTS}
        self._scene = scene
        self._seen: list[AnyArray] = []
        self._seen_from: Camera | None = None
        self._seen_in = (0, 0)
        self._box: Box | None = None
        for name, part in self._parts.items():
            _set_appearance(part, name)
            scene.add(part, front=True)
        self.hide()

    def remove(self) -> None:
        """Remove the brush from the scene."""
        for part in self._parts.values():
            self._scene.remove(part)

    def hide(self) -> None:
        """Hide the brush."""
        self._seen, self._seen_from = [], None
        for part in self._parts.values():
            part.show(False)

    def screen_box(self) -> Box | None:
        """Return the screen bounding box of the brush with its shadow and outline."""
        if not self._seen:
            return None
        scene = self._scene
        if self._seen_from is not scene.camera or self._seen_in != scene.size:
            self._seen_from, self._seen_in = scene.camera, scene.size
            self._box = scene.screen_box(np.concatenate(self._seen))
        return self._box

    def show(
        self,
        stand: BrushStand,
        tree: ContactTree,
        up: AnyArray,
        ink: tuple[int, int, int] | None,
        fill: float,
        painted: AnyArray = _NOTHING,
    ) -> None:
        """Draw the brush, seen through where it stands before what was painted just now.

        Parameters
        ----------
        stand : BrushStand
        tree : ContactTree
            Of the surface that the shadow falls on.
        up : (3, 3)
            Rows: the studio's axes in the object's frame.
        ink : (3,) of 0 to 255, or None
            sRGB of the ink that it holds.
        fill : float
            Ink over the most that it holds, 0 to 1.
        painted : (N, 3)
            Places along what was painted just now, mm.
        """
        self._seen, self._seen_from = [], None
        rings, arc = tuft_rings(self._tuft, stand)
        if stand.touches:  # the model bends the tuft on a plane; the surface may be curved
            rings = laid_rings(self._tuft, rings, stand, tree)
        if self.hairs is not None:
            dense = np.interp(self.hairs.arc, arc, self._density("hairs", rings, painted, stand))
            self._draw_hairs(self.hairs, rings, stand.root, up, (ink, fill), dense)
        else:
            torn = torn_faces(self._tuft, stand.pressed) if stand.pressed is not None else None
            colours = self._tuft_colours(arc, _hair_shades(), ink, fill)
            self._draw_faded("tuft", rings, colours, painted, stand, torn)
            wet = 0.15 + 0.55 * min(1.0, 2.0 * fill) if ink is not None else 0.08
            self._parts["tuft"].actor.GetProperty().SetSpecular(wet)
        points, colours = handle_rings(self._tuft, stand)
        self._draw_faded(
            "handle", *_in_sections(points, colours, self._tuft.length), painted, stand
        )
        self._draw_shadow(stand, rings, points, tree, up)
        if not self._as_filmed:
            self._draw_outline(stand, tree)

    def _draw_faded(
        self,
        name: str,
        rings: AnyArray,
        colours: AnyArray,
        painted: AnyArray,
        stand: BrushStand,
        faces: AnyArray | None = None,
    ) -> None:
        """Draw one part so dense, section by section, that it hides nothing that was painted."""
        dense = self._density(name, rings, painted, stand)
        is_solid = self._set_solid(name, dense)
        if name == "tuft":  # its far side would show through the near one; split, it shows inside
            self._parts[name].actor.GetProperty().SetBackfaceCulling(not is_solid)
        columns = np.broadcast_to(dense[:, None, None], (*rings.shape[:2], 1))
        self._draw(name, rings, np.concatenate([colours, columns], axis=2), faces)

    def _set_solid(self, name: str, dense: AnyArray) -> bool:
        """Draw a part as solid if all of it is; return whether it is."""
        is_solid = bool(dense.min() > _SOLID)
        actor = self._parts[name].actor
        actor.SetForceOpaque(is_solid)
        actor.SetForceTranslucent(not is_solid)
        return is_solid

    def _density(
        self, name: str, rings: AnyArray, painted: AnyArray, stand: BrushStand
    ) -> AnyArray:
        """Return how dense (R,), 0 to 255, each section of a part is drawn."""
        if self._as_filmed:
            return np.full(len(rings), 255.0)
        over, painting, lifted = _DENSE[name]
        most = painting if stand.touches else lifted
        off = self._off_in_picture(rings, painted)
        share = np.clip((off - _CLEAR) / (_FADE - _CLEAR), 0.0, 1.0)
        result: AnyArray = over + (most - over) * share * share * (3.0 - 2.0 * share)
        return result

    def _off_in_picture(self, rings: AnyArray, painted: AnyArray) -> AnyArray:
        """Return how far (R,) sections are from painted places in the picture, in their radii."""
        if not len(painted):
            return np.full(len(rings), np.inf)
        camera = self._scene.camera
        axes = np.stack(picture_axes(camera))
        centres = rings.mean(axis=1)
        radii = np.linalg.norm(rings - centres[:, None], axis=2).max(axis=1)
        seen, there = ((points - camera.position) @ axes.T for points in (centres, painted))
        depth = np.maximum(-seen[:, 2], 1e-3)
        there = there[there[:, 2] < 0.0]
        if not len(there):
            return np.full(len(rings), np.inf)
        apart = seen[:, None, :2] / depth[:, None, None] - there[:, :2] / -there[:, 2:]
        nearest = np.sqrt((apart**2).sum(axis=2).min(axis=1))
        result: AnyArray = nearest * depth / np.maximum(radii, 0.5 * radii.max())
        return result

    def _draw(
        self, name: str, rings: AnyArray, colours: AnyArray, faces: AnyArray | None = None
    ) -> None:
        """Draw one part as a grid of rings (R, AROUND, 3)."""
        part = self._parts[name]
        faces = grid_faces(len(rings)) if faces is None else faces
        part.set_shape(rings.reshape(-1, 3), faces, grid_normals(rings).reshape(-1, 3))
        self._seen.append(rings.reshape(-1, 3))
        part.set_colours(np.clip(colours, 0, 255).reshape(-1, colours.shape[-1]).astype(np.uint8))
        part.show(True)

    def _draw_hairs(
        self,
        hairs: SingleHairs,
        rings: AnyArray,
        root: AnyArray,
        up: AnyArray,
        ink_and_fill: tuple[tuple[int, int, int] | None, float],
        dense: AnyArray,
    ) -> None:
        """Draw the hairs as lines of their projected width, lit by the key light.

        `dense` is how dense each is, 0 to 255, as long as `hairs.arc`.
        """
        part = self._parts["hairs"]
        points, outward = hairs.points(rings)
        light = -_SHADOW_FALL @ up
        lit = outward @ (light / np.linalg.norm(light))
        shades = _line_shades(hairs.count)
        colours = np.empty((*points.shape[:2], 3))
        colours[:] = np.swapaxes(self._tuft_colours(hairs.arc.T, shades, *ink_and_fill), 0, 1)
        colours *= (0.82 + 0.3 * np.clip(lit, -0.6, 1.0))[..., None]
        part.set_strands(points)
        self._set_solid("hairs", dense)
        colours = np.concatenate([colours, dense[..., None]], axis=2)
        part.set_colours(np.clip(colours, 0, 255).reshape(-1, 4).astype(np.uint8))
        camera = self._scene.camera
        ahead = float((camera.position - root) @ picture_axes(camera)[2])
        seen = 2.0 * max(ahead, 1e-3) * np.tan(0.5 * camera.view_angle)  # picture height, mm
        width = hairs.line_mm * self._scene.size[1] / seen
        part.actor.GetProperty().SetLineWidth(float(np.clip(width, *_LINE_WIDTHS)))
        part.show(True)
        self._seen.append(rings.reshape(-1, 3))

    def _tuft_colours(
        self, arc: AnyArray, hairs: AnyArray, ink: tuple[Any, ...] | None, fill: float
    ) -> AnyArray:
        """Return colours (R, H, 3): hair, darker at the root, inked up to a height set by `fill`.

        Parameters
        ----------
        arc : (R,) or (R, H)
            Arc length from the tip, 0 to 1.
        hairs : (H,)
            Lightness of each hair, about 1.
        ink : (3,) or None
        fill : float
        """
        arc = arc if arc.ndim > 1 else arc[:, None]
        shade = 0.72 + 0.28 * np.clip((1.0 - arc) / 0.25, 0.0, 1.0)
        colours = self._hair[None, None] * hairs[None, :, None] * shade[..., None]
        if ink is None or fill <= 0.0:
            return colours
        height = 0.30 + 0.55 * np.sqrt(min(fill, 1.0))
        ragged = height + 0.07 * (hairs - 1.0) / 0.14
        share = np.clip((ragged[None] - arc) / 0.10, 0.0, 1.0)
        share *= 0.45 + 0.55 * min(1.0, 3.0 * fill)
        inked = np.asarray(ink, np.float64) * (0.9 + 0.2 * (hairs - 0.86))[None, :, None]
        result: AnyArray = colours + share[..., None] * (inked - colours)
        return result

    # -- on the surface ---------------------------------------------------------------------

    def _draw_shadow(
        self, stand: BrushStand, tuft: AnyArray, handle: AnyArray, tree: ContactTree, up: AnyArray
    ) -> None:
        part = self._parts["shadow"]
        fall = _SHADOW_FALL @ up
        fall /= np.linalg.norm(fall)
        rings = np.concatenate([tuft[::6], handle[5:13]])
        centre = rings.mean(axis=1)
        across = cross(stand.handle, fall)  # the same for all rings, or the strip folds at bends
        across /= max(float(np.linalg.norm(across)), 1e-9)
        reach = np.abs((rings - centre[:, None]) @ across).max(axis=1)
        strip = centre[:, None] + (reach[:, None] * _SOFT)[..., None] * across
        hits, landed = _drape(tree, strip.reshape(-1, 3), fall, _SHADOW_REACH)
        landed = landed.reshape(len(rings), len(_SOFT))
        whole_rows = np.logical_and.accumulate(landed.all(axis=1))  # unbroken from the tip on
        landed = landed & whole_rows[:, None]
        if whole_rows.sum() < 2:
            part.show(False)
            return
        height = np.linalg.norm(hits[:, :3] - strip.reshape(-1, 3), axis=1).reshape(landed.shape)
        faint = 1.0 / (1.0 + height / 28.0)
        steep = np.clip(-(hits[:, 3:] @ fall) / _GRAZING, 0.0, 1.0).reshape(landed.shape)
        fade = fade_along(centre)[:, None]
        press = 0.6 + 0.4 * min(1.0, stand.pressure) if stand.touches else 0.6
        alpha = press * _DARKEST * _SOFT_SHARE * faint * steep**2 * fade * landed
        colours = np.zeros((landed.size, 4), np.uint8)
        colours[:, 3] = alpha.reshape(-1)
        lifted = hits[:, :3] + _SHADOW_LIFT * hits[:, 3:]
        part.set_shape(lifted, _whole_faces(landed))
        self._seen.append(lifted[landed.reshape(-1)])
        part.set_colours(colours)
        part.show(True)

    def _draw_outline(self, stand: BrushStand, tree: ContactTree) -> None:
        part = self._parts["outline"]
        line = stand.outline() if stand.touches else self._hover_ring(stand)
        fall = -stand.axes[2] if stand.touches else -stand.handle
        above = _ABOVE * self._tuft.length if stand.touches else 0.0
        hits, landed = _drape(tree, line - above * fall, fall, 140.0 + above)
        if len(line) < 3 or not landed.all():
            part.show(False)
            return
        lifted = hits[:, :3] + _OUTLINE_LIFT * hits[:, 3:]
        part.set_line(lifted, closed=True)
        self._seen.append(lifted)
        colour = _OUTLINE if stand.touches else _HOVER
        part.set_colours(np.tile(np.array(colour, np.uint8), (len(line) + 1, 1)))
        part.show(True)

    def _hover_ring(self, stand: BrushStand) -> AnyArray:
        """Return a ring (N, 3) around the straight tip, projected to where it would touch down."""
        turn = 2.0 * np.pi * np.arange(36) / 36
        radius = 0.22 * self._tuft.diameters[-1]
        ring = radius * np.stack([np.cos(turn), np.sin(turn), np.zeros(36)], axis=1)
        return stand.place(ring)


def _in_sections(rings: AnyArray, colours: AnyArray, length: float) -> tuple[AnyArray, AnyArray]:
    """Return the rings (R, AROUND, 3) of a handle and their colours with more of them between."""
    steps = np.linalg.norm(np.diff(rings.mean(axis=1), axis=0), axis=1)
    counts = np.maximum(1, np.ceil(steps / (_SECTION * length)).astype(int))
    at = np.concatenate([np.linspace(k, k + 1, n, endpoint=False) for k, n in enumerate(counts)])
    at = np.append(at, len(rings) - 1)
    low = np.minimum(at.astype(int), len(rings) - 2)
    share = (at - low)[:, None, None]
    return (
        rings[low] + share * (rings[low + 1] - rings[low]),
        colours[low] + share * (colours[low + 1] - colours[low]),
    )


def fade_along(centres: AnyArray) -> AnyArray:
    """Return the shadow's fade (R,), 1 to 0, under rings about centres (R, 3).

    It depends on arc length, not on the index: at a joint of the handle two rings coincide.
    """
    way = arc_lengths(centres)
    fraction = way / max(float(way[-1]), 1e-9)
    result: AnyArray = 1.0 - fraction * fraction
    return result


def laid_rings(tuft: Tuft, rings: AnyArray, stand: BrushStand, tree: ContactTree) -> AnyArray:
    """Return a tuft's rings (R, AROUND, 3), mm, moved up or down to lie on the surface.

    Across a ring the surface is a parabola through the points below its middle and both sides.
    """
    along, side, normal = stand.axes
    length = tuft.length
    centres = rings.mean(axis=1)
    height = (centres - stand.origin) @ normal
    lies = height < _LYING * length
    if not lies.any():
        return rings
    weight = (1.0 - height[lies] / (_LYING * length)).clip(0.0, 1.0)
    apart = rings[lies] - centres[lies][:, None]
    across, ahead = apart @ side, apart @ along
    feet = centres[lies] - height[lies, None] * normal
    half = np.abs(across).max(axis=1) + 1e-3
    rise, leans, landed = _ground_under(feet, half, stand, tree, _ABOVE * length)
    tilt, left, right = leans[:, :1], rise[:, 1], rise[:, 2]
    slope = 0.5 * (right - left) / half
    bow = 0.5 * (right + left - 2.0 * rise[:, 0]) / half**2
    under = rise[:, :1] + across * (slope[:, None] + across * bow[:, None])
    own = height[lies, None] + apart @ normal
    moved = own + weight[:, None] * under
    least = under + tilt * ahead + _HAIR_LIFT
    lifted = np.where(landed[:, None], np.maximum(moved, least), own)
    result: AnyArray = rings.copy()
    result[lies] += (lifted - own)[..., None] * normal
    return result


def _ground_under(
    feet: AnyArray, half: AnyArray, stand: BrushStand, tree: ContactTree, above: float
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return the surface under rings (R), sampled under every second and interpolated.

    Parameters
    ----------
    feet : (R, 3)
        Projections of their middles onto the stand's plane, mm.
    half : (R,)
        Their half widths, mm.
    above : float
        Height over the plane that rays start from, mm.

    Returns
    -------
    rise : (R, 3) float64
        Height of the surface over the plane under the middle and both sides, mm.
    leans : (R, 2) float64
        Slopes under the middle, along the bend and across it.
    landed : (R,) bool
        Whether there is a surface under the middle.
    """
    along, side, normal = stand.axes
    sampled = np.unique(np.append(np.arange(0, len(feet), 2), len(feet) - 1))
    across = half[sampled, None] * np.array([0.0, -1.0, 1.0])
    starts = across[..., None] * side + feet[sampled, None] + above * normal
    hits, hit = _drape(tree, starts.reshape(-1, 3), -normal, above + _BELOW * above)
    hit, ground = hit.reshape(-1, 3), hits.reshape(-1, 3, 6)[:, 0, 3:]
    rise = ((hits[:, :3] - stand.origin) @ normal).reshape(-1, 3)
    upright = np.maximum(ground @ normal, _STEEPEST)
    leans = -np.stack([ground @ along, ground @ side], axis=1) / upright[:, None]
    rise = np.where(hit, rise, rise[:, :1] + across * leans[:, 1:])
    known = np.concatenate([rise, leans, hit[:, :1]], axis=1)
    rings = np.arange(len(feet))
    every = interpolate(rings, sampled, known)
    return every[:, :3], every[:, 3:5], every[:, 5] > 0.99


@cache
def _line_shades(n: int) -> AnyArray:
    """Return the lightness (n,) of each single hair, always the same."""
    return 0.8 + 0.36 * np.random.default_rng(11).random(n)


@cache
def _hair_shades() -> AnyArray:
    """Return the lightness (AROUND,) of each column of hairs, always the same."""
    return 0.86 + 0.28 * np.random.default_rng(11).random(AROUND)


def _drape(
    tree: ContactTree, points: AnyArray, direction: AnyArray, reach: float
) -> tuple[AnyArray, AnyArray]:
    """Return where rays from points (N, 3) hit, and normals (N, 6), and which do (N,) bool."""
    out, landed = np.zeros((len(points), 6)), np.zeros(len(points), np.uint8)
    if len(points):
        drape_points(tree, np.ascontiguousarray(points, np.float64), direction, reach, out, landed)
    return out, landed.astype(bool)


def _whole_faces(landed: AnyArray) -> NDArray[np.int32]:
    """Return the triangles (L, 3) int32 of a strip (R, C) all of whose corners have landed.

    Cached by content: the same array again lets `DrawnMesh` send positions only.
    """
    return _faces_of(landed.tobytes(), landed.shape)


@lru_cache(maxsize=32)
def _faces_of(landed_bytes: bytes, shape: tuple[int, int]) -> NDArray[np.int32]:
    rows, columns = shape
    landed = np.frombuffer(landed_bytes, bool).reshape(shape)
    faces = grid_faces(rows, columns)
    result: NDArray[np.int32] = faces[landed.ravel()[faces].all(axis=1)].astype(np.int32)
    return result


def _set_appearance(part: DrawnMesh, name: str) -> None:
    look = part.actor.GetProperty()
    look.SetInterpolationToPhong()
    if name == "hairs":
        look.LightingOff()
        return
    if name in ("shadow", "outline"):
        look.LightingOff()
        look.SetLineWidth(2.0)
        part.actor.ForceTranslucentOn()
        part.draw_before()
        return
    if name == "handle":
        look.BackfaceCullingOn()  # its far side does not show through the near one
    look.SetAmbient(0.55)
    look.SetDiffuse(0.72)
    look.SetSpecular(0.15 if name == "tuft" else 0.22)
    look.SetSpecularPower(24.0)

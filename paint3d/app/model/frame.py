"""Frames from the painting thread to a view: what changed since the last one, and no more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.document import Document
from paint3d.app.model.laid_text import LaidText
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.stroke_log import Stroke
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.brush_engine.bristles.bend import Bristles
from paint3d.brush_engine.tuft import Tuft
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.materials import Material
from paint3d.colour.pigments import WATER, Pigment
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.core.arrays import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.errors import Message
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Ink, Painter
from paint3d.pose.brush_pose import object_poses
from paint3d.surface.layer_stack import Layer
from paint3d.view.pressed_tuft import PressedTuft

__all__ = [
    "HAIR",
    "BrushView",
    "HeldInk",
    "PaintingFrame",
    "Snapshot",
    "held_ink",
    "ink_srgb",
    "view_brush",
]

# ---- The ink in the brush ------------------------------------------------------------------------


_DISH = np.full(31, 0.9)
"""Reflectance of white porcelain."""

HAIR = np.linspace(0.42, 0.62, 31)
"""Reflectance of a brush's dry hair."""

_LEAST = 5e-3  # of what is held: less is not shown


@dataclass(frozen=True, eq=False)
class HeldInk:
    """Ink that a brush holds.

    Attributes
    ----------
    parts : tuple of (Pigment, float)
        Fractions of what it holds, of sum 1, the most first; empty for an empty brush.
    fraction : float
        Of a full load, 0 to 1.
    bands : tuple of (int, int, int)
        sRGB of the ink along the tuft as in a dish, the tip's first; one where it is alike.
    """

    parts: tuple[tuple[Pigment, float], ...]
    fraction: float
    bands: tuple[tuple[int, int, int], ...]


def held_ink(painter: Painter) -> HeldInk:
    """Ink that the brush of a painter holds now; may be called while it paints."""
    ink, pigments = painter.surface.ink, tuple(painter.surface.pigments)
    load, reservoirs = np.maximum(ink.load, 0.0), np.maximum(ink.reservoirs, 0.0)
    total = float(load.sum())
    if total <= 0.0 or len(load) > len(pigments):
        return HeldInk((), 0.0, ())
    along = reservoirs if len(reservoirs) > 1 else load[None]
    fractions = along / np.maximum(along.sum(axis=1, keepdims=True), 1e-30)
    bands = [ink_srgb(pigments, tuple(np.round(part, 3))) for part in fractions]
    parts = sorted(  # most first, water last
        zip(pigments, load / total, strict=False), key=lambda part: (part[0] is WATER, -part[1])
    )
    shown = tuple((pigment, float(fraction)) for pigment, fraction in parts if fraction > _LEAST)
    return HeldInk(shown, min(1.0, total / painter.tuft.load), tuple(dict.fromkeys(bands)))


@lru_cache(maxsize=256)
def ink_srgb(
    pigments: tuple[Pigment, ...], parts: Sequence[float], on_hair: bool = False
) -> tuple[int, int, int]:
    """sRGB of a coat of mixed inks in a dish, or on hair; water lets through what is behind.

    Parameters
    ----------
    pigments : tuple of Pigment (P)
    parts : tuple of float (P)
        Fractions of sum 1; all 0 for none.
    on_hair : bool
    """
    inked: dict[str | Pigment, float]
    inked = {p: w for p, w in zip(pigments, parts, strict=False) if w > 0.0 and p is not WATER}
    shown: AnyArray = HAIR if on_hair else _DISH
    if inked:
        shown = mixture_reflectance(inked, sum(inked.values()), shown, by_volume=True)
    red, green, blue = (int(code) for code in srgb_from_reflectance(shown))
    return red, green, blue


# ---- Frames --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class BrushView:
    """The brush as it is now, in the object's frame, for drawing it.

    Attributes
    ----------
    position : (3,) float64
        The tuft's root, mm.
    orientation : (4,) float64
        object_from_pen, w first.
    pressure : float or None
    pressed : PressedTuft or None
        How its tuft lies on the surface; None where it touches nothing.
    srgb : (3,) uint8
        Colour of the ink in it; of dry hair where it is empty.
    load : float
        Fraction of a full load, 0 to 1.
    painting : bool
        Whether a stroke is going on.
    """

    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    pressed: PressedTuft | None
    srgb: NDArray[np.uint8]
    load: float
    painting: bool


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The painting after a step, for whoever may not touch the document: nothing in it changes.

    Attributes
    ----------
    source : TriangleMesh
        What is painted on.
    contact_tree : ContactTree
        Of its triangles.
    material : Material
    resolution : float or None
        mm.
    n_vertices : int
    path : Path or None
        The session's file, once there is one.
    modified : bool
        Whether it is otherwise than it was saved.
    refused_history : Message or None
        Why the steps that were saved with it could not be used; empty where they could.
    brush : BrushSpec
        In hand; `tuft` and `bristles` are its shape.
    tuft : Tuft
    bristles : Bristles or None
    azimuth : str
    pickup : float
        See `Document.pickup`.
    dipped : ink
        What the brush was dipped in last; `amount` is how much of it, `dips` what it came by it.
    amount : DipAmount
    dips : sequence of (ink, float or None)
    held : HeldInk
        What is left of it.
    inks : tuple of two inks
    layers : tuple of Layer
        The lowest first.
    active_layer : int
        Position of the one that is painted on.
    mask : Mask
    stencil : Stencil or None
        The mask as it lies on the surface.
    n_seals : int
        See `Document`.
    texts : tuple of LaidText
        What lies on the object to be written after.
    strokes, undone_strokes : tuple of Stroke
        There; and to be done again, the next one first.
    n_strokes_without_undo, fewest_strokes : int
        See `Document`.
    has_steps : bool
        Whether there is a step that undo takes back at once.
    can_undo, can_redo : bool
    """

    source: TriangleMesh
    contact_tree: ContactTree
    material: Material
    resolution: float | None
    n_vertices: int
    path: Path | None
    modified: bool
    refused_history: Message | None
    brush: BrushSpec
    tuft: Tuft
    bristles: Bristles | None
    azimuth: str
    pickup: float
    dipped: Ink
    amount: DipAmount
    dips: Sequence[tuple[Ink, float | None]]
    held: HeldInk
    inks: tuple[Ink, ...]
    layers: tuple[Layer, ...]
    active_layer: int
    mask: Mask
    stencil: Stencil | None
    n_seals: int
    texts: tuple[LaidText, ...]
    strokes: tuple[Stroke, ...]
    undone_strokes: tuple[Stroke, ...]
    n_strokes_without_undo: int
    fewest_strokes: int
    has_steps: bool
    can_undo: bool
    can_redo: bool

    @classmethod
    def of(cls, document: Document) -> Snapshot:
        """The painting as it is now; nobody changes it meanwhile."""
        surface, painter = document.surface, document.painter
        return cls(
            source=surface.source,
            contact_tree=surface.contact_tree,
            material=surface.material,
            resolution=surface.resolution,
            n_vertices=surface.n_vertices,
            path=document.path,
            modified=document.modified,
            refused_history=document.refused_history,
            brush=painter.brush,
            tuft=painter.tuft,
            bristles=None if painter.hairs is None else painter.hairs.bristles,
            azimuth=painter.azimuth,
            pickup=document.pickup,
            dipped=painter.dipped,
            amount=painter.amount,
            dips=tuple(painter.dips),
            held=held_ink(painter),
            inks=tuple(document.inks),
            layers=document.layers,
            active_layer=document.active_layer,
            mask=document.mask,
            stencil=document.stencil,
            n_seals=document.n_seals,
            texts=document.texts,
            strokes=tuple(document.strokes),
            undone_strokes=tuple(document.undone_strokes),
            n_strokes_without_undo=document.n_strokes_without_undo,
            fewest_strokes=document.fewest_strokes,
            has_steps=bool(document.steps.done),
            can_undo=document.can_undo,
            can_redo=document.can_redo,
        )


@dataclass(frozen=True, eq=False)
class PaintingFrame:
    """A state of the painting: its changes since the frame before.

    Attributes
    ----------
    vertex_ids : (N,) int32
        Vertices whose colours changed.
    has_grown : bool
        Whether refinement added vertices or triangles.
    brush : BrushView or None
        None before the first sample.
    queue_length : int
        Batches of samples and commands that were asked for before it was taken and that it does not
        show yet; time for the ink is none of them.
    lag_s : float
        How long what was painted last had waited, s.
    painting : Snapshot
    """

    vertex_ids: NDArray[np.int32]
    has_grown: bool
    brush: BrushView | None
    queue_length: int
    lag_s: float
    painting: Snapshot


def view_brush(document: Document, sample: DeviceSample) -> BrushView:
    """The brush at a sample of both hands, its tuft as painting will have it there."""
    samples, painted = _unpainted_path(document, sample)
    path, painter = object_poses(samples), document.painter
    load = document.surface.ink.load
    parts = tuple(np.round(load / load.sum(), 3)) if load.sum() > 0.0 else ()
    colour = ink_srgb(tuple(document.surface.pigments), parts, on_hair=True)
    return BrushView(
        path.position[-1],
        path.orientation[-1],
        sample.pressure,
        document.tuft_follower.follow(painter, path, painted=painted),
        np.array(colour, np.uint8),
        float(min(1.0, load.sum() / painter.tuft.load)),
        document.in_stroke,
    )


def _unpainted_path(document: Document, sample: DeviceSample) -> tuple[list[DeviceSample], bool]:
    """The samples of the stroke from the one that is painted to this one; and whether that is so.

    A sample that cannot follow the stroke's is one by itself.
    """
    samples, painted = document.unpainted
    if samples and samples[-1] is sample:
        return samples, painted
    if not samples or samples[-1].time_ns >= sample.time_ns:
        return [sample], False
    if (samples[-1].pressure is None) != (sample.pressure is None):
        return [sample], False
    return [*samples, sample], painted

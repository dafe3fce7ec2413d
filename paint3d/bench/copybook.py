"""Writing a character and comparing what was painted with its copybook.

The way is the user's: glyph, plan, times, a recording of the handle, a painter that replays that
recording alone. The score is taken from the painted surface.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.frames import quaternions_from_matrices
from paint3d.kernels.tuft import Tuft
from paint3d.mesh.solids import make_plane
from paint3d.stroke.engine import Painter
from paint3d.stroke.glyphs import Glyph, load_glyph
from paint3d.stroke.ladder import build_ladder
from paint3d.stroke.likeness import Likeness, compare, copybook_mask, painted_mask
from paint3d.stroke.planning import PlanSettings, on_paper, plan_glyph
from paint3d.stroke.timing import Motion, time_courses
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Copy", "Hand", "copy_on_plane", "draw_sample", "flat_recording"]

WIDEST = 0.2
"""Width of the brush's deepest footprint, ems."""


@dataclass(frozen=True)
class Hand:
    """What a character is written with.

    Attributes
    ----------
    brush : str
        Preset.
    em_mm : float
        Side of the em square, mm.
    resolution_mm : float
        Of the painted surface, mm.
    azimuth : {"commanded", "dragged"}
    """

    brush: str
    em_mm: float
    resolution_mm: float
    azimuth: str = "commanded"


@dataclass(frozen=True, eq=False)
class Copy:
    """One character, written and compared.

    Attributes
    ----------
    text : str
    likeness : Likeness
    seconds : float
        Processor time of the planning, s.
    fastest : tuple of float
        Greatest speed (mm/s), acceleration (mm/s2), jerk (mm/s3) of the root, and turn rate
        (rad/s) of the holder, by differences of the recording.
    painted, wanted : (576, 576) bool
        The two rasters.
    """

    text: str
    likeness: Likeness
    seconds: float
    fastest: tuple[float, float, float, float]
    painted: NDArray[np.bool_]
    wanted: NDArray[np.bool_]


def draw_sample(glyphs: Path | str, n: int, seed: int, also: str = "") -> list[str]:
    """Draw n different characters of a glyph folder at random, the same for the same seed.

    Parameters
    ----------
    glyphs : path
        An unpacked `hanzi-writer-data`.
    n, seed : int
    also : str
        Characters added at the end, where they were not drawn.

    Raises
    ------
    InputError
        If the folder has fewer characters.
    """
    names = (file.stem for file in Path(glyphs).glob("*.json"))
    known = sorted(name for name in names if len(name) == 1)
    if len(known) < n:
        raise InputError(f"{glyphs} has {len(known)} characters; expected at least {n}")
    order = np.random.default_rng(seed).permutation(len(known))[:n]
    drawn = [known[i] for i in order]
    return drawn + [text for text in also if text not in drawn]


def flat_recording(motion: Motion, tuft: Tuft, corner: NDArray, brush: str) -> Recording:
    """The recording of a motion over the plane z = 0, an em square's corner (2,) at `corner`."""
    n = len(motion.time_s)
    cosine, sine, zero = np.cos(motion.azimuth), np.sin(motion.azimuth), np.zeros(n)
    x = np.stack([cosine, sine, zero], axis=1)
    y = np.stack([-sine, cosine, zero], axis=1)
    z = np.tile([0.0, 0.0, 1.0], (n, 1))
    return Recording(
        np.round(motion.time_s * 1e9).astype(np.int64),
        np.column_stack([motion.handle + corner, tuft.length + motion.height]),
        quaternions_from_matrices(np.stack([x, y, z], axis=-1)),
        np.maximum(0.0, -motion.height) / tuft.full_press,
        motion.buttons,
        header={"brush": brush},
    )


def copy_on_plane(
    glyphs: Path | str, text: str, hand: Hand, settings: PlanSettings | None = None
) -> Copy:
    """Write one character on the plane, from the plan to the paint, and compare it."""
    glyph = load_glyph(glyphs, text)
    tuft = build_tuft(load_brush(hand.brush))
    ladder = build_ladder(tuft, WIDEST * hand.em_mm)
    started = time.process_time()
    courses = plan_glyph(glyph, hand.em_mm, ladder, settings)
    seconds = time.process_time() - started
    motion = time_courses([courses], hand.em_mm)
    corner = np.full(2, -0.5 * hand.em_mm)
    recording = flat_recording(motion, tuft, corner, hand.brush)
    surface = PaintedSurface(make_plane(), hand.resolution_mm)
    Painter(surface, hand.brush, azimuth=hand.azimuth).replay(recording)
    points = surface.paint_mesh.vertices[:, :2].astype(np.float64) - corner
    painted = painted_mask(points, surface.coverage, surface.paint_mesh.leaf_faces(), hand.em_mm)
    wanted = wanted_mask(glyph, hand.em_mm)
    likeness = compare(painted, wanted)
    return Copy(text, likeness, seconds, fastest(recording), painted, wanted)


def wanted_mask(glyph: Glyph, em_mm: float) -> NDArray[np.bool_]:
    """The copybook's pixels of a glyph."""
    return copybook_mask([on_paper(stroke.outline, em_mm) for stroke in glyph.strokes], em_mm)


def fastest(recording: Recording) -> tuple[float, float, float, float]:
    """Greatest speed, acceleration, jerk and turn rate in a recording; mm, rad, s."""
    step = np.diff(recording.time_ns).mean() * 1e-9
    rates, values = [], recording.position
    for _ in range(3):
        values = np.diff(values, axis=0) / step
        rates.append(float(np.linalg.norm(values, axis=1).max()))
    q = recording.orientation
    same = np.minimum(1.0, np.abs(np.sum(q[1:] * q[:-1], axis=1)))
    return rates[0], rates[1], rates[2], float((2.0 * np.arccos(same)).max() / step)

"""How strokes are planned."""

from __future__ import annotations

import math
from dataclasses import dataclass

from paint3d.errors import InputError

__all__ = ["TECHNIQUES", "PlanSettings"]

TECHNIQUES = {"zhongfeng": math.pi, "cefeng": 0.75 * math.pi, "pianfeng": 0.5 * math.pi}
"""Angle between bend and motion, rad (Guo 2017, section 5)."""


@dataclass(frozen=True)
class PlanSettings:
    """How a stroke is planned; lengths in shares of the em.

    Attributes
    ----------
    sample_step, pose_step : float
        Distance of the samples that directions are chosen for, and of the final poses.
    margin : float
        How far a footprint may stand out of the outline.
    n_directions : int
        Bend directions tried.
    shifts : tuple of float
        Side steps tried, in shares of the narrower half of the stroke.
    trailing : float
        Cost of a leading tip (0 for a trailing one), in stroke widths left bare.
    turning, shifting : float
        Cost of a turn of one radian, and of a side step of one half width, over one stroke width.
    detours : int
        How many bare corners the line is led into, one after another.
    worth : float
        Share of the bare area that a detour must gain.
    technique : {"zhongfeng", "cefeng", "pianfeng"}, optional
        How the bend is held against the motion: the tip trails (180 degrees), lies half aside
        (135) or all aside (90), on either side. None: as covers the outline best.
    holding : float
        Cost of a bend the opposite way, in stroke widths left bare, where a technique is asked for.
    azimuth : {"commanded", "dragged"}
        Whether the holder turns the tuft, or the paper: then it trails wherever it is led.

    Raises
    ------
    InputError
        For a technique or azimuth that is not known, or a dragged tuft that shall not trail.
    """

    sample_step: float = 3.5 / 1024
    pose_step: float = 1.0 / 1024
    margin: float = 0.5 / 1024
    n_directions: int = 36
    shifts: tuple[float, ...] = (-0.4, 0.0, 0.4)
    trailing: float = 0.03
    turning: float = 0.01
    shifting: float = 0.03
    detours: int = 4
    worth: float = 0.05
    technique: str | None = None
    holding: float = 10.0
    azimuth: str = "commanded"

    def __post_init__(self) -> None:
        if self.technique is not None and self.technique not in TECHNIQUES:
            known = ", ".join(repr(name) for name in TECHNIQUES)
            raise InputError(f"technique is {self.technique!r}; expected one of {known}")
        if self.azimuth not in ("commanded", "dragged"):
            raise InputError(f"azimuth is {self.azimuth!r}; expected 'commanded' or 'dragged'")
        if self.azimuth == "dragged" and self.technique not in (None, "zhongfeng"):
            raise InputError(
                f"technique is {self.technique!r} with a dragged tuft, which trails; "
                "expected 'zhongfeng' or none"
            )

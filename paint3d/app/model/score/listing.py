"""The strokes of a score as a list: number, brush, ink, length, time, and what became of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from paint3d.app.model.brush_in_hand import BRUSH_COMMANDS, brush_after
from paint3d.app.model.persistence.saved_settings import DEFAULT_BRUSH, PURE_INKS
from paint3d.app.model.score.codecs import decode_brush
from paint3d.errors import Message, Paint3DError, RecordingError
from paint3d.pose.brush_pose import brush_poses
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.recording.score_steps import follow_steps

__all__ = ["ListedStroke", "list_strokes"]


@dataclass(frozen=True)
class ListedStroke:
    """A stroke of a score.

    Attributes
    ----------
    number : int
        From 1.
    brush, ink : str
        What it was painted with.
    length_mm : float
        Of the way of the brush while it was pressed.
    seconds : float
        From the first sample to the last.
    became : {"there", "undone", "cancelled"}
    """

    number: int
    brush: str
    ink: str
    length_mm: float
    seconds: float
    became: str


def list_strokes(score: Score) -> list[ListedStroke]:
    """The strokes of a score, in order.

    Raises
    ------
    RecordingError
        If the header names a brush that is not known.
    """
    try:
        brush = decode_brush(score.header, DEFAULT_BRUSH)
    except Paint3DError as cause:
        raise RecordingError(
            "{score}: its header: {cause}",
            score=score.name or Message("the score"),
            cause=cause,
        ) from None
    ink = score.header.get("ink", PURE_INKS[0])
    begun = {stroke.begin: stroke for stroke in follow_steps(score).strokes}
    listed = []
    for k, event in enumerate(score.events):
        if isinstance(event, Recording) or event.get("refused"):
            continue
        if event["do"] == "set_brush":
            brush = _brush_of(event, brush)
        elif event["do"] in BRUSH_COMMANDS:
            arguments = [value for key, value in event.items() if key not in ("do", "refused")]
            brush = brush_after(brush, event["do"], arguments)
        elif event["do"] == "dip":
            ink = event.get("ink", ink)
        elif k in begun:
            stroke = begun[k]
            parts = score.events[k : stroke.end]
            whole = [part for part in parts if isinstance(part, Recording)]
            became = "cancelled" if stroke.is_cancelled else "undone"
            listed.append(
                ListedStroke(
                    stroke.number,
                    _brush_of(event, brush).name,
                    _ink_text(event.get("ink", ink)),
                    sum(map(_length_mm, whole)),
                    (int(whole[-1].time_ns[-1]) - int(whole[0].time_ns[0])) * 1e-9,
                    "there" if stroke.is_there else became,
                )
            )
    return listed


def _brush_of(line: Mapping[str, Any], brush: Any) -> Any:
    """The brush that a line says, if it says one that is known."""
    try:
        return decode_brush(line, "") if "brush" in line else brush
    except Paint3DError:
        return brush


def _ink_text(ink: str | Mapping[str, float]) -> str:
    if isinstance(ink, str):
        return ink
    if len(ink) == 1:
        return next(iter(ink))
    return ",".join(f"{name}:{parts:.3g}" for name, parts in ink.items())


def _length_mm(part: Recording) -> float:
    """Length of the path along which the brush is pressed, in the object's frame."""
    path = brush_poses(part).points
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    if part.pressure is not None:
        down = part.pressure > 0.0
        steps = steps[down[1:] | down[:-1]]
    return float(steps.sum())

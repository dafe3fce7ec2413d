"""When the brush is dipped.

A planned recording presses the dip button before every character; here the presses that are not
needed are removed, so that the load of the brush falls along a column. A character that takes more
than the brush holds is dipped for again between its strokes.

What a way takes of the ink in the brush follows from eta' sum pe ds (docs/model.md, equations (10)
and (10a)), so what a character takes is known before it is painted, as far as the way of the
outline is that of the root. A brush made for a range of sizes would hold ink for dozens of the
small ones; a writer wets only the part of its tuft that he needs (`paint3d.brush.spec`).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import tuft_on
from paint3d.brush.footprint import make_footprint
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.brush_engine.ink_transfer import FADING, FILM, FILM_FRACTION
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import rotate
from paint3d.device.recorded import Recording
from paint3d.device.sample import DIP
from paint3d.errors import InputError

__all__ = ["LEAST_LOAD", "apply_dip_option", "ink_taken", "remove_dips"]

LEAST_LOAD = 0.2
"""Of what a dip gave: a writer dips before less is left; set by eye."""

_LASTS = (1.0 - LEAST_LOAD - FADING * math.log(LEAST_LOAD)) / (1.0 + FADING)
"""Sum of `ink_taken` until `LEAST_LOAD` of a dip is left, on paper; on a glaze more is."""
_MOST_TAKEN = _LASTS * (1.0 + 1e-9)  # sums of the same numbers differ in their last bits

_CHARACTERS = 4.0  # of a middle size that a dip is for
_NEW_COLUMN = 1.6  # times the usual step from character to character: there the column ends
_ROOM = 2  # characters that a load has to last for at the head of a column
_LEAST_WETTED = 0.005  # fraction of a tuft: its point


def apply_dip_option(
    recording: Recording, brush: BrushSpec, wanted: str | int, material: Material
) -> Recording:
    """A planned recording with the brush dipped as ``--dip`` says.

    Parameters
    ----------
    recording, brush, material
        As for `remove_dips`.
    wanted : {"auto", "always"} or int
        "always": the whole tuft before every character, as it was planned. A photograph's or a
        drawing's strokes may say themselves how much the brush holds, so nothing is added to it.
    """
    if wanted == "always":
        return recording
    return remove_dips(recording, brush, None if wanted == "auto" else int(wanted), material)


def remove_dips(
    recording: Recording, brush: BrushSpec, every: int | None, material: Material
) -> Recording:
    """Dip the brush before some characters only, and in so little ink as these take.

    Where a whole tuft does not last for a character, it is dipped again before the strokes of it
    that would leave less than `LEAST_LOAD`.

    Parameters
    ----------
    recording : Recording
        Its dip button goes down before every character, as in a planned text.
    brush : BrushSpec
        That it is painted with.
    every : int or None
        Dip before every so many-th character. None: where the load would fall under `LEAST_LOAD`
        before the end of the next character, or at a column's head before the end of the one after.
    material : Material
        That it is painted on, which takes more or less ink.

    Returns
    -------
    Recording
        Its header has ``"dip"``, the words of a `DipAmount`. So much of the tuft is wet that the
        load falls to `LEAST_LOAD` over that number of characters, or over four that take a
        middle amount of ink; the whole tuft where these take more.

    Raises
    ------
    InputError
        If `every` is no count of at least 1.
    """
    if every is not None and not (type(every) is int and every >= 1):
        raise InputError(
            "every is {every!r:.60}; expected a count of 1 or more, or None", every=every
        )
    down = (recording.buttons & DIP) != 0
    starts = np.concatenate([[0], np.flatnonzero(down[1:] & ~down[:-1]) + 1])
    rates = ink_taken(recording, brush, material)
    taken = np.add.reduceat(rates, starts)
    if every is None:
        most = max(_CHARACTERS * np.median(taken), float(taken.max()))
        wetted = _wetted_fraction(most / _LASTS)
        dips = _find_needed_dips(taken / wetted, _find_column_heads(recording, starts))
    else:
        dips = np.arange(len(starts)) % every == 0
        runs = np.add.reduceat(taken, np.flatnonzero(dips))
        wetted = _wetted_fraction(float(runs.max()) / _LASTS)
    buttons = np.array(recording.buttons)
    ends = np.append(starts[1:], len(buttons))
    used = 0.0  # of the wetted tuft, since the last dip
    for start, end, stays in zip(starts, ends, dips, strict=True):
        if stays:
            used = 0.0
        else:
            buttons[start:end] &= ~DIP
        for lifted, touches, leaves in _strokes_within(recording, start, end):
            takes = float(rates[touches:leaves].sum()) / wetted
            if lifted < touches and used > 0.0 and used + takes > _MOST_TAKEN:
                buttons[lifted:touches] |= DIP
                used = 0.0
            used += takes
    amount = {"dip": DipAmount(wetted).words()}
    return replace(recording, buttons=buttons, header={**recording.header, **amount})


def _strokes_within(recording: Recording, start: int, end: int) -> list[tuple[int, int, int]]:
    """Pen-up start, pen-down start and pen-up end of each stroke of a character.

    Those that the pen is not lifted before are part of the one before them.
    """
    down = np.concatenate([[False], _touches(recording)[start:end], [False]])
    begins = start + np.flatnonzero(down[1:] & ~down[:-1])
    leaves = start + np.flatnonzero(down[:-1] & ~down[1:])
    lifted = np.concatenate([[start], leaves[:-1]])
    return list(zip(lifted.tolist(), begins.tolist(), leaves.tolist(), strict=True))


def _wetted_fraction(fraction: float) -> float:
    return math.ceil(1e4 * min(1.0, max(_LEAST_WETTED, fraction))) / 1e4


def ink_taken(recording: Recording, brush: BrushSpec, material: Material) -> NDArray[np.float64]:
    """Rate at which each sample takes ink of a fully wetted brush: its eta' pe ds.

    Parameters
    ----------
    recording : Recording
        With pressures; in the world or the object's frame.
    brush : BrushSpec
    material : Material

    Returns
    -------
    (N,) float64
        What docs/model.md, equations (10) and (12a), take of a wet brush, by the root's way over
        the object and the width of the footprint under an upright handle.

    Raises
    ------
    InputError
        If the recording has no pressures.
    """
    pressure = recording.pressure
    if pressure is None:
        raise InputError("the recording has no pressure; expected one, to know what ink it takes")
    steps = np.linalg.norm(np.diff(_root_in_object(recording), axis=0), axis=1)
    mean = 0.5 * (pressure[1:] + pressure[:-1])
    touches = (pressure[1:] > 0.0) & (pressure[:-1] > 0.0)
    taken = np.zeros(len(recording))
    tuft = tuft_on(brush, material)
    known = np.linspace(0.0, 1.0, 33)
    prints = (make_footprint(tuft, p * brush.full_press_mm, 0.5 * math.pi, pe=p) for p in known)
    width = np.interp(mean, known, [footprint.width for footprint in prints])
    per_mm = (1.0 - FILM_FRACTION) * mean + FILM * width / brush.root_diameter_mm
    taken[1:] = np.where(touches, tuft.transfer_per_mm * per_mm * steps, 0.0)
    return taken


def _root_in_object(recording: Recording) -> AnyArray:
    """(N, 3) root in the object's frame, mm."""
    inverse = recording.object_orientation * np.array([1.0, -1.0, -1.0, -1.0])
    result: AnyArray = rotate(inverse, recording.position - recording.object_position)
    return result


def _touches(recording: Recording) -> NDArray[np.bool_]:
    """(N,) bool: samples that are pressed."""
    pressure = recording.pressure
    return np.zeros(len(recording), bool) if pressure is None else pressure > 0.0


def _find_column_heads(recording: Recording, starts: AnyArray) -> NDArray[np.bool_]:
    """(K,) bool: characters much farther from the one before than usual."""
    root = _root_in_object(recording)
    touches = _touches(recording)
    weights = np.add.reduceat(touches.astype(float), starts)
    sums = np.add.reduceat(np.where(touches[:, None], root, 0.0), starts, axis=0)
    middle = sums / np.maximum(weights, 1.0)[:, None]
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    heads = np.zeros(len(starts), bool)
    heads[0] = True
    if len(steps):
        heads[1:] = steps > _NEW_COLUMN * np.median(steps)
    return heads


def _find_needed_dips(taken: AnyArray, heads: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(K,) bool: characters that need a dip, by the ink that each takes from a wetted tuft."""
    dips = np.zeros(len(taken), bool)
    used = math.inf
    for k in range(len(taken)):
        ahead = taken[k : k + _ROOM].sum() if heads[k] else taken[k]
        dips[k] = used + ahead > _MOST_TAKEN
        used = taken[k] + (0.0 if dips[k] else used)
    return dips

"""Undo history of a document in a session: its steps, and what the painter remembered.

A step of the history is a stroke or a word. What a painter remembers between strokes is its brush,
its ink, and what single hairs hold; the steps say how the surface was (`surface.undo_state`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from paint3d.app.model.laid_text import pack_texts, unpack_texts
from paint3d.app.model.persistence.brush_words import brush_from_words, brush_words
from paint3d.app.model.persistence.saved_settings import saved_mixture
from paint3d.app.model.stroke_log import Stroke, weights_of
from paint3d.brush.bending import tuft_on
from paint3d.brush.spec import BristleSpec, BrushSpec, DipAmount, build_curves
from paint3d.colour.pigments import WATER, load_palette
from paint3d.core.array_state import pack_arrays, unpack_arrays
from paint3d.core.arrays import AnyArray
from paint3d.errors import Paint3DError, SessionError
from paint3d.painter.bristle_state import HairTuft, complete_memory
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import MOST_INK
from paint3d.surface.undo import UndoHistory
from paint3d.surface.undo_state import restore_undo, undo_state

__all__ = ["MOST_BYTES", "restore_history", "saved_history"]

MOST_BYTES = 48 << 20
"""Of the steps in a file; those that are farthest from now are left out."""

_STROKE, _UNFINISHED = "stroke", "unfinished stroke"
_MOST_BRUSHES = 1000
_MOST_HAIRS = 1_000_000  # of all brushes together
_LONGEST_LABEL = 100

PainterState = Mapping[str, Any]


def saved_history(
    surface: PaintedSurface,
    history: UndoHistory,
    current: Stroke | None,
    most_bytes: int,
) -> tuple[dict[str, Any], list[Stroke]]:
    """Return the steps as a session holds them, and the strokes that were undone.

    Parameters
    ----------
    surface : PaintedSurface
    history : UndoHistory
    current : Stroke or None
        One that is going on: without its end it is no stroke of the painting yet.
    most_bytes : int

    Returns
    -------
    state : dict
        What `undo_state` says, and: done and undone, a word for each step, the last of undone is
        the next; brushes, as `brush_words` has them; painters, what was remembered: place of its
        brush, hairs (their properties or None), ink, what it was dipped in, weights by name, and
        amount, as `DipAmount.words`, where that is not the preset's; texts, as `pack_texts` has
        them.
        Of the K paintings painter, text (K,) int32, loaded (K,) float64, dipped (K,) uint8, and the
        columns hair_loads (B, P) and hair_memory float64, empty without hairs.
    undone : list of Stroke
        As their words in undone come.
    """
    saved = undo_state(surface, history, most_bytes)
    words = [[_label_word(label, current) for label in own] for own in (saved.done, saved.undone)]
    state = {"steps": saved.state, "done": words[0], "undone": words[1]}
    undone = [label for label in saved.undone if isinstance(label, Stroke)]
    return {**state, **_pack_painters(saved.kept, len(surface.pigments))}, undone


def _label_word(label: object, current: Stroke | None) -> str:
    if isinstance(label, Stroke):
        return _UNFINISHED if label is current else _STROKE
    return str(label)


def _pack_painters(states: Sequence[PainterState], n_pigments: int) -> dict[str, Any]:
    brushes: dict[BrushSpec, int] = {}
    painters: dict[str, dict[str, Any]] = {}
    numbers: dict[str, int] = {}
    of = np.empty(len(states), np.int32)
    for k, one in enumerate(states):
        painter = one["painter"]
        hairs = painter["hairs"]
        words = {
            "brush": brushes.setdefault(painter["brush"], len(brushes)),
            "hairs": None if hairs is None else asdict(hairs.spec),
            "ink": painter["ink"].name,
            "dipped": weights_of(painter["_dipped"]),
        }
        if painter["amount"] != DipAmount():
            words["amount"] = painter["amount"].words()
        key = json.dumps(words)
        painters.setdefault(key, words)
        of[k] = numbers.setdefault(key, len(numbers))
    texts: dict[str, int] = {}
    for one in states:
        texts.setdefault(one["texts"], len(texts))
    of_hairs = [one["painter"]["of_hairs"] or _NO_HAIRS for one in states]
    loads = [np.pad(h["load"], ((0, 0), (0, n_pigments - h["load"].shape[1]))) for h in of_hairs]
    return {
        "brushes": [brush_words(brush) for brush in brushes],
        "painters": list(painters.values()),
        "painter": of,
        "loaded": np.array([one["painter"]["loaded"] for one in states], np.float64),
        "dipped": np.array([one["dipped"] for one in states], np.uint8),
        "texts": list(texts),
        "text": np.array([texts[one["texts"]] for one in states], np.int32),
        **pack_arrays("hair_loads", loads, np.float64, (n_pigments,)),
        **pack_arrays("hair_memory", [h["memory"] for h in of_hairs], np.float64),
    }


_NO_HAIRS = {"load": np.empty((0, 0)), "memory": np.empty(0)}


def restore_history(
    surface: PaintedSurface,
    history: UndoHistory,
    state: Mapping[str, Any],
    strokes: Sequence[Stroke],
    undone: Sequence[Stroke],
) -> int:
    """Restore the undo steps that were saved with a document.

    Parameters
    ----------
    surface : PaintedSurface
    history : UndoHistory
        A new one.
    state : mapping
        Of `saved_history`; it may come from a stranger.
    strokes, undone : sequence of Stroke
        Those that are there, and those that were undone, the next one last.

    Returns
    -------
    int
        How many of the strokes are steps now.

    Raises
    ------
    SessionError
        If the steps are none of this painting; nothing has happened then.
    """
    try:
        words = state["done"], state["undone"]
        n_done, n_undone = (list(own).count(_STROKE) for own in words)
        if n_done > len(strokes) or n_undone != len(undone):
            raise SessionError(
                "{n_done} strokes are done and {n_undone} undone; expected {n} and {undone}",
                n_done=n_done,
                n_undone=n_undone,
                n=len(strokes),
                undone=len(undone),
            )
        done_labels = _unpack_labels(words[0], iter(strokes[len(strokes) - n_done :]))
        undone_labels = _unpack_labels(words[1], iter(undone))
        states = _unpack_states(surface, state)
        restore_undo(surface, history, state["steps"], done_labels, undone_labels, states)
    except SessionError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as cause:
        raise SessionError("they are incomplete near {cause}", cause=cause) from None
    except Paint3DError as cause:
        raise SessionError(cause) from None
    result: int = n_done
    return result


def _unpack_labels(words: Sequence[Any], strokes: Iterator[Stroke]) -> list[object]:
    for word in words:
        if not isinstance(word, str) or len(word) > _LONGEST_LABEL:
            raise SessionError("a step is {word!r:.60}; expected a word", word=word)
    return [next(strokes) if word == _STROKE else word for word in words]


def _unpack_states(surface: PaintedSurface, state: Mapping[str, Any]) -> list[PainterState]:
    """Unpack what the painter remembered, as `Document` restores it."""
    of = np.asarray(state["painter"])
    count, p = len(of), len(surface.pigments)
    makers = _painter_factories(surface, state)
    if of.dtype != np.int32 or (count and not 0 <= of.min() <= of.max() < len(makers)):
        raise SessionError(
            "painters are numbered as {of_dtype}; expected int32 below {n}",
            of_dtype=of.dtype,
            n=len(makers),
        )
    loaded, dipped = np.asarray(state["loaded"]), np.asarray(state["dipped"])
    if loaded.dtype != np.float64 or not (np.abs(loaded) <= MOST_INK).all():
        raise SessionError("ink that was loaded is out of range")
    if loaded.shape != of.shape or dipped.shape != of.shape or dipped.dtype != np.uint8:
        raise SessionError(
            "loads have shape {loaded_shape}; expected one for each of {count} painters",
            count=count,
            loaded_shape=loaded.shape,
        )
    loads = unpack_arrays(state, "hair_loads", count, np.float64, (p,))
    memories = unpack_arrays(state, "hair_memory", count, np.float64)
    texts = [pack_texts(unpack_texts(packed)) for packed in state["texts"]]
    of_texts = np.asarray(state["text"])
    if of_texts.shape != of.shape or of_texts.dtype != np.int32:
        raise SessionError(
            "texts are numbered in shape {shape}; expected one number for each of {count} steps",
            count=count,
            shape=of_texts.shape,
        )
    if count and not 0 <= of_texts.min() <= of_texts.max() < len(texts):
        raise SessionError("a text has a number beyond {count}", count=len(texts))
    column = np.asarray(state["hair_loads"])
    if column.size and not 0.0 <= column.min() <= column.max() <= MOST_INK:
        raise SessionError("ink of single hairs is out of range")
    rows = zip(of, loaded, dipped, of_texts, loads, memories, strict=True)
    return [
        {
            "painter": makers[k](float(load), hair_load, memory),
            "dipped": bool(was),
            "texts": texts[text],
        }
        for k, load, was, text, hair_load, memory in rows
    ]


def _painter_factories(
    surface: PaintedSurface, state: Mapping[str, Any]
) -> list[Callable[..., PainterState]]:
    """For each painter what makes what it remembers from loads and hairs."""
    if len(state["brushes"]) > _MOST_BRUSHES or len(state["painters"]) > 10 * _MOST_BRUSHES:
        raise SessionError(
            "they use {n} brushes; expected {most}",
            n=len(state["brushes"]),
            most=_MOST_BRUSHES,
        )
    brushes = [_unpack_brush(words, surface) for words in state["brushes"]]
    inks = {**load_palette(), WATER.name: WATER} | {ink.name: ink for ink in surface.pigments}
    tufts: dict[tuple[int, BristleSpec | None], HairTuft | None] = {}
    makers, n_hairs = [], 0
    for words in state["painters"]:
        number, hairs = words["brush"], words["hairs"]
        if type(number) is not int or not 0 <= number < len(brushes):
            raise SessionError(
                "a painter has brush {place!r:.20}; expected a number below {n}",
                place=number,
                n=len(brushes),
            )
        spec = None if hairs is None else BristleSpec(**hairs)
        key = number, spec
        if key not in tufts:
            n_hairs += 0 if spec is None else spec.n_hairs
            if n_hairs > _MOST_HAIRS:
                raise SessionError(
                    "they use {n_hairs:,} hairs; expected {most:,}",
                    n_hairs=n_hairs,
                    most=_MOST_HAIRS,
                )
            tufts[key] = None if spec is None else HairTuft(brushes[number]["brush"], spec)
        amount = DipAmount.of(words.get("amount", {}))
        about = {
            **brushes[number],
            "amount": amount,
            "tuft": amount.of_tuft(brushes[number]["tuft"]),
            "ink": inks[words["ink"]],
            "_dipped": saved_mixture(words["dipped"], surface),
            "hairs": tufts[key],
        }
        makers.append(_painter_factory(about))
    return makers


def _unpack_brush(words: Mapping[str, Any], surface: PaintedSurface) -> dict[str, Any]:
    brush = brush_from_words(words)
    tuft = tuft_on(brush, surface.material)
    return {"brush": brush, "tuft": tuft, "curves": build_curves(brush.inputs)}


def _painter_factory(about: Mapping[str, Any]) -> Callable[..., PainterState]:
    def make(loaded: float, load: AnyArray, memory: AnyArray) -> PainterState:
        of_hairs, hairs = None, about["hairs"]
        if hairs is not None:
            memory = complete_memory(memory)
            if len(load) != hairs.spec.n_hairs or memory.shape != hairs.memory.shape:
                raise SessionError(
                    "{n} hairs hold ink; expected {n_hairs}",
                    n=len(load),
                    n_hairs=hairs.spec.n_hairs,
                )
            of_hairs = {"load": load, "memory": memory}
        return {**about, "loaded": loaded, "of_hairs": of_hairs}

    return make

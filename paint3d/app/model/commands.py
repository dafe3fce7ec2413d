"""What can be asked of a document, as words: for the journal, and to do it again after a crash."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick
from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.colour.pigments import Pigment
from paint3d.errors import SessionError

__all__ = ["COMMANDS", "decode_command", "do_again", "encode_command"]

COMMANDS = frozenset(
    {
        "add_layer", "begin_stroke", "cancel_stroke", "dip", "dry", "edit_stroke", "end_stroke",
        "follow_time", "let_time_pass", "lift", "move_layer", "pick_colour", "press_seal", "redo",
        "remove_layer",
        "rename_layer", "replay_history", "resize_brush", "rinse", "scale_brush", "select_layer",
        "set_azimuth", "set_brush", "set_locked", "set_mask", "set_pickup", "set_symmetry",
        "set_tags",
        "set_visible", "step_brush", "swap_inks", "undo", "wipe",
    }
)  # fmt: skip
"""Methods of `Document` that change the painting: what a journal must know."""

_CLASSES = (
    BrushSpec, BristleSpec, Pigment, Symmetry, MirrorPlane, RadialSymmetry, Mask, AngleMask,
    RegionPick,
)  # fmt: skip
_KINDS: dict[str, type[Any]] = {kind.__name__: kind for kind in _CLASSES}
_KIND = "@"


def encode_command(
    name: str, arguments: Sequence[object], options: Mapping[str, Any]
) -> dict[str, object]:
    """A command as JSON can hold it.

    Raises
    ------
    SessionError
        If an argument is nothing that can be written down.
    """
    note: dict[str, object] = {"do": name}
    if arguments:
        note["with"] = [_plain(value) for value in arguments]
    if options:
        note["options"] = {key: _plain(value) for key, value in options.items()}
    return note


def decode_command(note: Mapping[str, Any]) -> tuple[str, list[Any], dict[str, Any]]:
    """The name, arguments and options of a command that was written down.

    Raises
    ------
    SessionError
        If it is none of `COMMANDS`, or not whole.
    """
    name = note.get("do")
    if name not in COMMANDS:
        raise SessionError(f"the journal asks for {name!r:.40}; expected what a document can do")
    try:
        arguments = [_rich(value) for value in note.get("with", [])]
        return name, arguments, {k: _rich(v) for k, v in note.get("options", {}).items()}
    except (TypeError, AttributeError, KeyError) as cause:
        raise SessionError(f"the journal's {name} cannot be used: {cause}") from None


def do_again(document: Document, note: Mapping[str, Any]) -> None:
    """Do what was written down.

    Raises
    ------
    Paint3DError
        As when it was asked for first.
    """
    name, arguments, options = decode_command(note)
    getattr(document, name)(*arguments, **options)


def _plain(value: object) -> object:
    if is_dataclass(value) and type(value).__name__ in _KINDS:
        own = {f.name: _plain(getattr(value, f.name)) for f in fields(value) if f.init}
        return {_KIND: type(value).__name__, **own}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        if all(isinstance(key, str) for key in value):
            return {key: _plain(item) for key, item in value.items()}
        return {_KIND: "pairs", "pairs": [[_plain(k), _plain(v)] for k, v in value.items()]}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, str | int | float | bool):
        return value
    raise SessionError(f"{type(value).__name__} cannot be written down; expected plain values")


def _rich(value: object) -> object:
    if isinstance(value, list):
        return tuple(_rich(item) for item in value)
    if not isinstance(value, Mapping):
        return value
    if value.get(_KIND) == "pairs":
        return {_rich(key): _rich(item) for key, item in value["pairs"]}
    own = {key: _rich(item) for key, item in value.items() if key != _KIND}
    return _KINDS[value[_KIND]](**own) if _KIND in value else own

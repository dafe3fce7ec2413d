"""List the strokes of a whole painting (a recording of version 2), and edit them afterwards.

Strokes have the numbers that --list says, whatever else is asked for in the same command: N is one
(3), several (2,5) or a row of them (3-6). What comes after an edited stroke is painted anew by
paint3d replay.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.options import (
    add_force_option,
    add_quiet_option,
    add_unit_option,
    check_input_file,
    check_output_file,
    check_overwriting,
)
from paint3d.cli.progress import ProgressBar
from paint3d.errors import InputError, Paint3DError, RecordingError

if TYPE_CHECKING:
    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.recording.score import Score

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d score flower.score.jsonl --list
paint3d score flower.score.jsonl --move 3:5,0 --ink 4:cinnabar --out again.score.jsonl
"""

_MOST = 100_000  # numbers in a row


@dataclass(frozen=True)
class _Edit:
    """An edit of an option: its name, the strokes, and the text after the colon."""

    kind: str
    numbers: tuple[int, ...]
    text: str


class _EditAction(argparse.Action):
    """Collects edits of several options in the order in which they are given."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        numbers, colon, text = str(values).partition(":")
        kind = self.dest
        try:
            if (kind == "delete") == bool(colon) or (colon and not text.strip()):
                raise argparse.ArgumentTypeError(f"{values!r}; expected {self.metavar}")
            _CHECKS.get(kind, str)(text)
            edit = _Edit(kind, _parse_numbers(numbers), text.strip())
        except argparse.ArgumentTypeError as cause:
            raise argparse.ArgumentError(self, str(cause)) from None
        namespace.edits = [*(namespace.edits or ()), edit]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("score", metavar="SCORE", type=Path, help="a recording of version 2")
    parser.add_argument("--list", action="store_true", help="print the strokes with their numbers")
    edits: Sequence[tuple[str, str, str]] = (
        ("delete", "N", "take strokes out"),
        ("move", "N:DX,DY[,TURN]", "carry them along the surface, mm: on a lying surface along x "
         "and y, on a standing one to the right and upwards; and turn them, degrees, "
         "counter-clockwise for who looks at it"),
        ("ink", "N:MIXTURE", "another ink, as in replay --ink: 3:cinnabar, "
         '"3:pine soot:0.2,water:0.8"'),
        ("brush", "N:NAME|FILE", "another brush, dipped in the same ink, for these strokes alone"),
        ("time", "N:FACTOR|SECONDSs", "so many times as long (3:1.5), or so long (3:2s)"),
        ("shift", "N:SECONDS", "begin so much later, or (below 0) earlier"),
    )  # fmt: skip
    for name, metavar, about in edits:
        parser.add_argument(f"--{name}", metavar=metavar, action=_EditAction, help=about)
    parser.add_argument(
        "--on",
        metavar="MESH",
        help="the object that strokes are moved on (default: the one that the score names, where "
        "it is a built-in one)",
    )
    add_unit_option(parser)
    parser.add_argument("--out", metavar="FILE", type=Path, help="where the edited score goes")
    add_force_option(parser)
    add_quiet_option(parser)
    parser.set_defaults(edits=None)


def run(options: argparse.Namespace) -> None:
    """List the strokes, or write the edited score.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    edits: list[_Edit] = options.edits or []
    if not edits and not options.list:
        raise InputError("nothing is asked for; expected --list or an edit, such as --delete 3")
    if edits and options.out is None and not options.list:
        raise InputError("no --out is given; expected where the edited score goes")
    if options.out is not None:
        if not edits:
            raise InputError("--out is given without an edit; expected one, such as --delete 3")
        check_output_file(options.out, (".jsonl", ".json", ".jsonl.gz", ".json.gz"))
        check_overwriting((options.out,), (options.score,), force=options.force)
    check_input_file(options.score, "a whole painting (.score.jsonl)")
    from paint3d.recording.score import is_score, load_score, save_score

    if not is_score(options.score):
        raise RecordingError(
            "{score}: this is no recording of version 2; expected a whole painting, as the studio "
            "saves one under Whole painting",
            score=options.score,
        )
    with ProgressBar("reading", enabled=not options.quiet) as progress:
        score = load_score(options.score, progress)
    if edits:
        score = _apply_edits(score, edits, options)
    if options.list:
        sys.stdout.write(_table(score))
    if options.out is not None:
        save_score(score, options.out)
        if not options.quiet:
            n = len(score.strokes())
            sys.stdout.write(f"{options.out}: {n} stroke{'s' if n != 1 else ''}\n")


def _apply_edits(score: Score, edits: Sequence[_Edit], options: argparse.Namespace) -> Score:
    """Apply all edits, by the numbers that strokes have in the file: so deleting comes last."""
    from paint3d.recording.score_edits import apply_stroke_edit

    count = len(score.strokes())
    for edit in edits:
        for number in edit.numbers:
            if not 1 <= number <= count:
                raise RecordingError(
                    "{score}: --{kind} stroke {number}; expected 1 to {count}",
                    score=options.score,
                    kind=edit.kind,
                    number=number,
                    count=count,
                )
    ground = _ground(score, options) if any(edit.kind == "move" for edit in edits) else None
    for edit in edits:
        if edit.kind == "delete":
            continue
        try:
            words = _words(edit, score)
        except Paint3DError as cause:
            raise InputError(
                "--{kind} of stroke {numbers}: {cause}",
                kind=edit.kind,
                numbers=edit.numbers[0],
                cause=cause,
            ) from None
        for number in edit.numbers:
            score = apply_stroke_edit(score, [number], words, ground)
    gone = {number for edit in edits if edit.kind == "delete" for number in edit.numbers}
    return apply_stroke_edit(score, sorted(gone), {"do": "delete"})


def _words(edit: _Edit, score: Score) -> dict[str, Any]:
    """Return an edit as `score_edits.apply_stroke_edit` takes it."""
    text = edit.text
    if edit.kind == "move":
        x, y, *turn = _parse_move(text)
        return {"do": "move", "along": (x, y), "turn_deg": turn[0] if turn else 0.0}
    if edit.kind == "shift":
        return {"do": "time", "shift_s": float(text)}
    if edit.kind == "time":
        is_length = text.endswith("s")
        return {"do": "time", "seconds" if is_length else "factor": float(text.rstrip("s"))}
    if edit.kind == "brush":
        from paint3d.app.model.score.codecs import encode_brush
        from paint3d.brush.presets import load_brush

        return {"do": "brush", "brush": encode_brush(load_brush(text))}
    from paint3d.app.model.score.codecs import InkTable
    from paint3d.colour.inks import load_ink

    own = dict(score.header.get("pigments", {}))
    if text in own:
        return {"do": "ink", "ink": text}
    inks = InkTable(own)
    stirred = load_ink(text)
    name = inks.encode(next(iter(stirred)) if len(stirred) == 1 else stirred)
    return {"do": "ink", "ink": name, "pigments": inks.table}


def _ground(score: Score, options: argparse.Namespace) -> ClosestPoints:
    """Return the surface of the object that strokes are moved on."""
    from paint3d.files.load import is_built_in, load_mesh
    from paint3d.mesh.bvh import ClosestPoints

    name = options.on or score.header.get("object")
    if options.on is None and not (isinstance(name, str) and is_built_in(name)):
        raise InputError(
            "the score's object is {name!s}; expected --on MESH for strokes to be moved on",
            name=name or "not said",
        )
    with ProgressBar("reading the object", enabled=not options.quiet):
        return ClosestPoints(load_mesh(name, options.unit))


def _table(score: Score) -> str:
    from paint3d.app.model.score.listing import list_strokes

    rows = [("stroke", "brush", "ink", "mm", "s", "")]
    for stroke in list_strokes(score):
        became = "" if stroke.became == "there" else stroke.became
        length, seconds = f"{stroke.length_mm:.1f}", f"{stroke.seconds:.2f}"
        rows.append((str(stroke.number), stroke.brush, stroke.ink, length, seconds, became))
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    return "".join(
        "  ".join(
            (row[0].rjust(widths[0]), row[1].ljust(widths[1]), row[2].ljust(widths[2]),
             row[3].rjust(widths[3]), row[4].rjust(widths[4]), row[5])
        ).rstrip() + "\n"
        for row in rows
    )  # fmt: skip


# -- values of the options ----------------------------------------------------------------------


def _parse_numbers(text: str) -> tuple[int, ...]:
    numbers: list[int] = []
    for piece in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,6})(?:-(\d{1,6}))?\s*", piece, re.ASCII)
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if last < first or last - first > _MOST:
            raise argparse.ArgumentTypeError(
                f"{text!r} numbers no strokes; expected one (3), several (2,5) or a row (3-6)"
            )
        numbers += range(first, last + 1)
    return tuple(dict.fromkeys(numbers))


def _parse_finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no number")
    return value


def _parse_move(text: str) -> list[float]:
    values = [_parse_finite(part) for part in text.split(",")]
    if len(values) not in (2, 3):
        raise argparse.ArgumentTypeError(f"{text!r}; expected DX,DY in mm, or DX,DY,TURN")
    return values


def _parse_time(text: str) -> float:
    value = _parse_finite(text.strip().removesuffix("s"))
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}; expected a factor (1.5) or seconds (2s)")
    return value


_CHECKS = {"move": _parse_move, "time": _parse_time, "shift": _parse_finite}

"""Paint several things on one object: texts, drawings and seals, as a table lists them.

TABLE.csv has a piece a row. One of its columns text, svg, strokes or seal says what it is; others
are options of `paint3d write` (of `paint3d seal`, for a seal), without dashes: at, size, font, ink,
layer and so on. Pieces are painted in the table's order, each as a step that can be undone.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli import seal, write
from paint3d.cli.batches.table import (
    PIECES,
    check_columns,
    option_words,
    piece_columns,
    read_cells,
)
from paint3d.cli.options import (
    DIPS,
    add_force_option,
    add_quiet_option,
    add_report_option,
    check_input_file,
    check_output_file,
    check_overwriting,
)
from paint3d.cli.painting import (
    Before,
    PaintingOptions,
    add_out_option,
    fraction_over,
    new_document,
    open_document,
    paint_onto,
    take_layer,
)
from paint3d.cli.results import PaintingResult, finish, result_suffixes, say_if_over
from paint3d.cli.sources import check_source
from paint3d.errors import InputError, Paint3DError

if TYPE_CHECKING:
    from paint3d.app.model.document import Document

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d compose mug.csv --on mug.glb --out mug.p3d
paint3d compose --on bowl --out b.glb --piece '{"text": "永", "size": 30}' --piece '{"seal": "和"}'
"""

_LOG = logging.getLogger("paint3d")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "table", metavar="TABLE.csv", nargs="?", type=Path, help="a piece a row (see above)"
    )
    parser.add_argument(
        "--piece",
        metavar="JSON",
        action="append",
        default=[],
        type=_parse_piece,
        help='another piece, by its columns: \'{"text": "Anna", "at": "0.5,0.3", "size": 12}\'',
    )
    PaintingOptions.add_to(
        parser, "on", "material", "resolution", "unit", "up", "from_points", "texture"
    )
    add_out_option(parser)
    add_report_option(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def _parse_piece(text: str) -> dict[str, str]:
    """Parse a piece as JSON: columns and their cells."""
    try:
        piece = json.loads(text)
    except ValueError:
        piece = None
    if not isinstance(piece, dict) or not all(
        isinstance(cell, str | int | float) for cell in piece.values()
    ):
        raise argparse.ArgumentTypeError(
            f"{text!r:.60} is not a piece; expected JSON such as "
            '{"text": "Anna", "at": "0.5,0.3", "size": 12}'
        )
    return {
        name: ("yes" if cell else "no") if isinstance(cell, bool) else str(cell)
        for name, cell in piece.items()
    }


def run(options: argparse.Namespace) -> None:
    """Check all pieces, paint them, write: nothing is written unless all of it went well.

    Raises
    ------
    Paint3DError
        If a piece cannot be used, which is named, or the result cannot be written.
    """
    wanted = PaintingOptions.of(options)
    check_output_file(options.out, result_suffixes())
    if options.report is not None:
        check_output_file(options.report, (".json",))
    check_input_file(options.table, "a table of pieces (.csv)")
    wanted.check_object()
    pieces = _pieces(options)
    check_overwriting(
        (options.out, options.report),
        (*wanted.files(), options.table, *(file for _, one in pieces for file in _files(one))),
        force=options.force,
    )
    from paint3d.files.project.session import is_session_path

    seconds: dict[str, float] = {}
    is_session = is_session_path(wanted.on)
    document = open_document(wanted, options) if is_session else new_document(wanted)
    counts: list[dict[str, object]] = []
    for name, piece in pieces:
        try:
            counts.append({"piece": name, **_paint(document, name, piece, seconds)})
        except Paint3DError as cause:
            raise InputError("{name}: {cause}", name=name, cause=cause) from None
    painted = document.painter.report()
    painting = PaintingResult(
        document.surface, {**painted, "pieces": counts}, seconds, document=document
    )
    finish(painting, options)
    if not options.quiet:
        n = len(pieces)
        sys.stdout.write(f"{options.out}: {n} piece{'s' if n != 1 else ''}\n")


def _pieces(options: argparse.Namespace) -> list[tuple[str, argparse.Namespace]]:
    """Return each piece with its name for errors, as options of `write` or `seal`.

    Raises
    ------
    InputError
        If there is none, or one cannot be used.
    """
    named: list[tuple[str, Mapping[str, str]]] = []
    if options.table is not None:
        header, rows = read_cells(options.table)
        check_columns(f"{options.table}:1", header, piece_columns())
        for line, cells in rows:
            if len(cells) != len(header):
                raise InputError(
                    "{table}:{line}: it has {n} cells; expected {header}",
                    table=options.table,
                    line=line,
                    n=len(cells),
                    header=len(header),
                )
            named.append((f"{options.table}:{line}", dict(zip(header, cells, strict=True))))
    for number, piece in enumerate(options.piece, 1):
        check_columns(f"piece {number}", list(piece), piece_columns())
        named.append((f"piece {number}", piece))
    if not named:
        raise InputError("there is nothing to paint; expected TABLE.csv or --piece JSON")
    return [(name, _asked(name, piece, quiet=options.quiet)) for name, piece in named]


def _asked(name: str, piece: Mapping[str, str], *, quiet: bool) -> argparse.Namespace:
    from paint3d.cli.batches.rows import command_parser
    from paint3d.cli.options import UsageError

    given = {column: cell.strip() for column, cell in piece.items() if cell.strip()}
    what = [column for column in PIECES if column in given]
    if len(what) != 1:
        got = " and ".join(what) or "none of them"
        raise InputError(
            "{name}: it has {got}; expected one of {pieces}",
            name=name,
            got=got,
            pieces=", ".join(PIECES),
        )
    command = "seal" if what[0] == "seal" else "write"
    text = given.pop("seal") if command == "seal" else given.pop("text", None)
    try:
        words = option_words(command, given)
        rest = ["--quiet"] if quiet else []
        if text is not None:
            rest += ["--", piece[what[0]]]
        asked: argparse.Namespace = command_parser(command).parse_args(
            ["--on=plane", "--out=a.p3d", *words, *rest]
        )
        if command == "seal":
            seal.check_seal(asked)
        else:
            check_source(asked)
            write.settle_size(asked, "")
    except (UsageError, InputError) as cause:
        raise InputError(
            "{name}: {cause}", name=name, cause=str(cause).partition(" (see ")[0]
        ) from None
    if command == "write":
        try:
            PaintingOptions.of(asked).check()
        except Paint3DError as cause:
            raise InputError("{name}: {cause}", name=name, cause=cause) from None
    for file in (asked.svg, getattr(asked, "strokes", None)):
        try:
            check_input_file(file, "a file to read")
        except InputError as cause:
            raise InputError("{name}: {cause}", name=name, cause=cause) from None
    return asked


def _files(piece: argparse.Namespace) -> list[str | Path | None]:
    """Return the files that a piece is read from."""
    own = PaintingOptions.of(piece).files()[1:]
    return [*own, piece.svg, piece.font, getattr(piece, "strokes", None)]


def _paint(
    document: Document, name: str, piece: argparse.Namespace, seconds: dict[str, float]
) -> dict[str, object]:
    """Paint a piece, and warn of what lies over earlier paint."""
    take_layer(document, piece.layer)
    if "coats" in piece:
        before = Before.of(document)
        summary = seal.press(document, piece)
        counts: dict[str, object] = {"seal": summary}
        over = fraction_over(document, before)
    else:
        wanted = PaintingOptions.of(piece)
        make, source = write.planner(piece)
        pen = write.settings_of(piece)
        signature = write.signature_of(piece) if piece.sign else None
        dips = piece.dip or (DIPS if piece.text is not None else "always")
        surface = document.surface
        written = write.plan(piece, surface, make, pen, source, dips, seconds)
        painted = paint_onto(document, write.inked(written, surface), wanted, seconds)
        if signature is not None:
            write.sign(document, signature, wanted, written, seconds)
        counts = {"characters": written.characters, "brush": painted.counts["brush"]}
        over = float(painted.counts["over_paint"])
    say_if_over(over, name)
    return {**counts, "over_paint": round(over, 4)}

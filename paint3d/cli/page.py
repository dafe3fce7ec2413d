"""The studio as a page: a folder of static files, in which any browser paints with our brushes."""

from __future__ import annotations

import argparse
import functools
import http.server
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import (
    add_actions,
    add_quiet_option,
    check_output_folder,
    parse_number,
    parse_resolution_mm,
)
from paint3d.cli.progress import ProgressBar
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.page.folder import PageObject

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d page build studio
paint3d page serve studio
"""

_BUILD_EXAMPLES = """
paint3d page build studio
paint3d page build studio --on vase --on a4 --resolution 0.3 --brush langhao
"""
_SERVE_EXAMPLES = """
paint3d page serve studio --port 8000
"""


def _parse_port(text: str) -> int:
    return int(
        parse_number(text, "a port", "a whole number, 0 to 65535", lambda n: n in range(65536))
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    add = add_actions(parser)
    build = add("build", "write the page, with what it paints on and with", _BUILD_EXAMPLES)
    build.add_argument("out", metavar="DIR", type=Path, help="folder to write; made where missing")
    build.add_argument(
        "--on",
        metavar="OBJECT",
        action="append",
        help="an object to paint on, by name or file; given several times, there is a choice "
        "(default: scroll, square, fan and bowl)",
    )
    build.add_argument(
        "--resolution",
        metavar="MM",
        type=parse_resolution_mm,
        help="longest edge where there is paint, mm (default: what suits a sheet, else 0.4)",
    )
    build.add_argument(
        "--brush", metavar="NAME", action="append", help="a preset; given several times, a choice"
    )
    build.add_argument(
        "--ink",
        metavar="INK",
        action="append",
        help="an ink of fine pigments; given several times, a choice",
    )
    build.add_argument(
        "--material",
        metavar="NAME",
        action="append",
        help="what objects may be made of, beside what suits them; given several times, a choice",
    )
    build.add_argument(
        "--copybook",
        metavar="TEXT",
        action="append",
        help="a text to write after, as large as fills each sheet; given several times, a choice "
        "(default: two poems, a saying and 永)",
    )
    build.add_argument(
        "--seals",
        metavar="TEXT",
        default="all",
        help="characters that seals can be cut from in the page (default: all that are known, "
        "some 20 s)",
    )
    add_quiet_option(build)
    serve = add("serve", "hand a built page out to browsers of this machine", _SERVE_EXAMPLES)
    serve.add_argument("folder", metavar="DIR", type=Path, help="what `build` has written")
    serve.add_argument(
        "--port",
        metavar="N",
        type=_parse_port,
        default=8000,
        help="the port to listen at (default: 8000; 0: any)",
    )


def run(options: argparse.Namespace) -> None:
    """Build or serve.

    Raises
    ------
    ExportError
        If the page or its kernels are not built, or the folder cannot be written.
    InputError, UnknownNameError, MeshError
        If an object, a brush, an ink or a character is not known, or is one that a page cannot
        have; or the folder to be served holds no page.
    """
    if options.action == "build":
        _build(options)
    else:
        _serve(options.folder, options.port)


def _build(options: argparse.Namespace) -> None:
    check_output_folder(options.out)
    from paint3d.page import folder
    from paint3d.page.folder import PageObject

    objects: list[PageObject] = [
        PageObject(name, options.resolution or folder.resolution_for(name))
        for name in options.on or [one.name for one in folder.OBJECTS]
    ]
    with ProgressBar("building", enabled=not options.quiet) as progress:
        folder.build_page(
            options.out,
            objects,
            options.brush or folder.BRUSHES,
            options.ink or folder.INKS,
            progress,
            materials=options.material or folder.MATERIALS,
            copybook=[
                text for text in options.copybook or folder.available_texts() if text.strip()
            ],
            signed=True,
            seals=options.seals,
            page=folder.BUILT,
        )
    if not options.quiet:
        size = sum(path.stat().st_size for path in options.out.rglob("*") if path.is_file())
        sys.stdout.write(f"wrote {options.out}, {size / 1e6:.1f} MB: paint3d page serve it\n")


class _Handler(http.server.SimpleHTTPRequestHandler):
    """Serves files without a log, and makes browsers ask again for changed ones."""

    def log_message(self, *_: object) -> None:
        """Log nothing."""

    def end_headers(self) -> None:
        """Forbid caching without asking again."""
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()


def _serve(folder: Path, port: int) -> None:
    if not (folder / "contents.json").is_file() or not (folder / "index.html").is_file():
        raise InputError(
            "{folder} holds no page; expected what paint3d page build has written", folder=folder
        )
    handler = functools.partial(_Handler, directory=os.fspath(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", port), handler) as server:
        sys.stdout.write(f"http://127.0.0.1:{server.server_address[1]}/ (Ctrl+C ends it)\n")
        sys.stdout.flush()
        server.serve_forever()

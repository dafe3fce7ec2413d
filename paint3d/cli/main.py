"""The ``paint3d`` command: parse, run one command, turn every failure into one line.

Exit status: 0 done, 2 for bad input, usage or anything else that went wrong, 130 when
interrupted, 143 when asked to end (129 when its terminal is gone). With ``PAINT3D_DEBUG=1`` in
the environment the traceback is shown as well.
"""

from __future__ import annotations

import argparse
import atexit
import codecs
import gc
import io
import logging
import os
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from importlib import import_module

from paint3d.cli.options import Parser, UsageError
from paint3d.core.ending import TerminationHandler, remove_unfinished
from paint3d.core.machine import discard_output
from paint3d.errors import Paint3DError

__all__ = ["COMMANDS", "main", "make_parser"]

COMMANDS = {  # each by its module, which is imported when the command is asked for
    "demo": (
        "paint3d.cli.demo",
        "paint the shipped recording on the bowl: pictures, meshes, a session, a report",
    ),
    "replay": ("paint3d.cli.replay", "paint a recording"),
    "write": ("paint3d.cli.write", "write a text or a drawing: plan the strokes, then replay them"),
    "copy": (
        "paint3d.cli.copy",
        "copy writing from a photograph: find its strokes, then write them",
    ),
    "seal": ("paint3d.cli.seal", "press a seal, of text or a drawing"),
    "paint": ("paint3d.cli.paint", "the desktop studio (also: paint3d studio)"),
    "score": (
        "paint3d.cli.score",
        "a whole painting's strokes: list, delete, move, re-ink, re-time",
    ),
    "export": ("paint3d.cli.export", "a saved painting to any format, by suffix"),
    "picture": ("paint3d.cli.picture", "a picture of a painting, or a film of it turning"),
    "compose": ("paint3d.cli.compose", "several texts, drawings and seals on one object"),
    "batch": ("paint3d.cli.batch", "one painting a row of a table"),
    "page": ("paint3d.cli.page", "the studio as a page that any browser paints in"),
    "devices": (
        "paint3d.cli.devices",
        "6-DOF mice and styli: what is plugged in, live values, a recording, settings",
    ),
    "info": ("paint3d.cli.info", "an object's size, and where --at U,V is on it, in mm"),
    "inks": ("paint3d.cli.lists.inks", "the palette with sources and swatches"),
    "brushes": (
        "paint3d.cli.lists.brushes",
        "the brushes with parameters and pictures; a file to start your own from",
    ),
    "materials": (
        "paint3d.cli.lists.materials",
        "what surfaces are made of, with numbers and sources; a file to start your own from",
    ),
    "fonts": ("paint3d.cli.lists.fonts", "list the fonts that can be written with"),
    "study": ("paint3d.cli.study", "the papers' timing experiment"),
    "bench": ("paint3d.cli.bench", "speed on this machine, as tables and ratios"),
    "report": ("paint3d.cli.report", "versions, renderer, devices: to paste into a bug report"),
    "completion": ("paint3d.cli.completion", "let a shell complete commands and options"),
}
# Linear algebra in threads of its own gains nothing here: they would only wait, at full load.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_EXAMPLES = """
paint3d demo --out demo
paint3d write 永和九年 --on vase --size 60 --out vase.glb
paint3d COMMAND --help
"""
_ALIASES = {"studio": "paint"}
_BY_ITSELF = "paint"  # ends at once on a signal: the painting is recovered at the next start
_FAILED = 2
_INTERRUPTED = 130
_AGAIN_S = 0.01  # after an interrupt that was dropped


class _Version(argparse.Action):
    """Print the version, which is looked up only when it is asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from paint3d import __version__

        sys.stdout.write(f"paint3d {__version__}\n")
        parser.exit()


def make_parser(asked: str | None = None) -> Parser:
    """Return the parser of the command line.

    Parameters
    ----------
    asked : str, optional
        The command that will be run: no other is loaded. By default all are.
    """
    parser = Parser(
        prog="paint3d",
        description="Paint calligraphy and brushwork on 3-D objects.",
        examples=_EXAMPLES,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, dest="command")
    for name, (home, about) in COMMANDS.items():
        if asked is not None and asked != name:
            commands.add_parser(name, help=about)  # to be listed, and for what is mistyped
            continue
        module = import_module(home)
        command = commands.add_parser(
            name, help=about, description=module.__doc__, examples=module.EXAMPLES
        )
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser


def _print_error(message: str) -> None:
    """Write an error to stderr, in one line, if anybody can read it."""
    line = " ".join(message.split())
    try:
        sys.stderr.write(f"paint3d: error: {line}\n")
    except OSError:  # a pipe that nobody reads, a terminal that is gone; the exit status remains
        discard_output(sys.stderr)


def _report_failure(message: str) -> int:
    _print_error(message)
    return _FAILED


def _print_warnings(*, quiet: bool) -> None:
    """Print the library's warnings to stderr, a line each; none with ``--quiet``."""
    log = logging.getLogger("paint3d")
    log.propagate = False
    log.handlers = [logging.NullHandler() if quiet else logging.StreamHandler()]
    log.handlers[0].setFormatter(logging.Formatter("paint3d: note: %(message)s"))


def _run(words: Sequence[str]) -> int:
    try:
        options = make_parser(words[0] if words else "").parse_args(words or ["--help"])
        _print_warnings(quiet=getattr(options, "quiet", False))
        options.run(options)
        sys.stdout.flush()
    except (UsageError, Paint3DError) as error:
        return _report_failure(str(error))
    except BrokenPipeError:  # the reader of our output has gone
        discard_output(sys.stdout)
    except OSError as error:
        reason = error.strerror or str(error) or type(error).__name__
        return _report_failure(f"{error.filename}: {reason}" if error.filename else reason)
    except MemoryError:
        return _report_failure("out of memory; try a coarser --resolution or a smaller mesh")
    return 0


def _print_any_name() -> None:
    """Print file names that are no UTF-8 as their bytes, so that printing never fails."""

    def encode(error: UnicodeError) -> tuple[str | bytes, int]:
        if not isinstance(error, UnicodeEncodeError):
            raise error
        code, after = ord(error.object[error.start]), error.start + 1
        if 0xDC80 <= code <= 0xDCFF:  # how Python holds such a byte
            return bytes([code - 0xDC00]), after
        return error.object[error.start : after].encode("ascii", "backslashreplace"), after

    codecs.register_error("paint3d", encode)
    for stream, errors in ((sys.stdout, "paint3d"), (sys.stderr, "backslashreplace")):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors=errors)


@contextmanager
def _repeating_interrupts() -> Iterator[None]:
    """Interrupt again when Python has dropped an interrupt meanwhile.

    It does so when one comes in a callback, as of an import or of an object's finalizer.
    """
    others, again = sys.unraisablehook, list[threading.Timer]()

    def interrupt_again() -> None:
        from paint3d.core.machine import interrupt  # here, or it may be just half imported

        interrupt()

    def hear(dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            others(dropped)
            return
        again.append(threading.Timer(_AGAIN_S, interrupt_again))
        again[-1].daemon = True
        again[-1].start()

    sys.unraisablehook = hear
    try:
        yield
    finally:
        sys.unraisablehook = others
        for one in again:  # it would interrupt the caller
            one.cancel()
            one.join()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Instead of ``sys.argv[1:]``.

    Returns
    -------
    int
        The exit status: 0, 2, 129, 130 or 143.
    """
    for name in _ONE_THREAD:
        os.environ.setdefault(name, "1")
    _print_any_name()
    atexit.register(gc.freeze)  # or the interpreter collects all objects as it exits: 50 ms
    debug = os.environ.get("PAINT3D_DEBUG", "") not in ("", "0")
    if not debug and not sys.warnoptions:
        warnings.simplefilter("ignore")
        logging.getLogger().addHandler(logging.NullHandler())
    words = list(sys.argv[1:] if arguments is None else arguments)
    words[:1] = [_ALIASES.get(word, word) for word in words[:1]]
    termination = TerminationHandler()
    try:
        with _repeating_interrupts(), nullcontext() if words[:1] == [_BY_ITSELF] else termination:
            return _run(words)
    except KeyboardInterrupt:
        remove_unfinished()
        _print_error("asked to end" if termination.status else "interrupted")
        return termination.status or _INTERRUPTED
    except Exception as error:
        if debug:
            traceback.print_exc()
        kind = type(error).__name__
        return _report_failure(
            f"internal error, {kind}: {error} (set PAINT3D_DEBUG=1 to see where)"
        )

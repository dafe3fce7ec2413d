"""Options that several commands share, and the checks made before the work starts."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Never

from paint3d.cli.progress import ProgressBar
from paint3d.errors import ExportError

if TYPE_CHECKING:
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "DIPS",
    "Parser",
    "UsageError",
    "add_dip_option",
    "add_force_option",
    "add_ink_options",
    "add_on_and_out",
    "add_painting_options",
    "add_quiet_option",
    "add_spread_option",
    "add_stylus_option",
    "add_surface_options",
    "add_up_option",
    "check_output_file",
    "check_output_folder",
    "check_overwriting",
    "load_object",
    "own_file",
    "parse_count",
    "parse_hairs",
    "parse_length_mm",
    "parse_number",
    "parse_place",
    "parse_resolution_mm",
    "parse_seconds",
    "parse_share",
]

# ---- Parsing -------------------------------------------------------------------------------------
# An argument parser that raises instead of printing its usage over several lines.


class UsageError(Exception):
    """A command line that argparse refused."""


class Parser(argparse.ArgumentParser):
    """Raises `UsageError` with one line."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse's, but that what is not known is told with the command that it stands at."""
        found, unknown = self.parse_known_args(args, namespace)
        if unknown:
            at = getattr(found, "command", None)
            prog = f"{self.prog} {at}" if at else self.prog
            raise UsageError(f"unrecognized arguments: {' '.join(unknown)} (see {prog} --help)")
        return found

    def error(self, message: str) -> Never:
        """Refuse the command line."""
        raise UsageError(f"{message} (see {self.prog} --help)")


# --------------------------------------------------------------------------------------------------


UNITS = ("mm", "cm", "m", "in")
MATERIALS = (  # known before NumPy is
    "porcelain", "bisque", "xuan", "plaster", "terracotta", "sized xuan", "tinted xuan", "silk",
)  # fmt: skip
_UP_AXES = ("x", "y", "z", "-x", "-y", "-z")  # as `mesh.upright`, known here before NumPy is
_MOST_HAIRS = 10_000  # as `brush.spec.MOST_HAIRS`, known here before NumPy is loaded
DIPS = "auto"  # of texts
TIP_REACH = 0.35  # as in the studio
_FINEST_MM, _COARSEST_MM = 0.005, 1e6  # that `PaintedSurface` takes, known here before NumPy is


def parse_number(text: str, what: str, expected: str, fits: Callable[[float], bool]) -> float:
    """A number from the command line; what does not fit, and NaN never does, is refused."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not fits(number):
        raise argparse.ArgumentTypeError(f"{text!r} is not {what}; expected {expected}")
    return number


def parse_length_mm(text: str) -> float:
    """A positive length in mm from the command line."""
    return parse_number(text, "a length", "a number above 0, mm", lambda n: 0.0 < n < math.inf)


def parse_seconds(text: str) -> float:
    """A time in seconds from the command line, 0 or more."""
    return parse_number(text, "a time", "seconds, 0 or more", lambda n: 0.0 <= n < math.inf)


def parse_resolution_mm(text: str) -> float:
    """A vertex spacing in mm that a surface can have."""
    resolution = parse_length_mm(text)
    if resolution < _FINEST_MM:
        raise argparse.ArgumentTypeError(f"{text} is too fine; expected at least {_FINEST_MM:g} mm")
    if resolution > _COARSEST_MM:
        raise argparse.ArgumentTypeError(
            f"{text} is too coarse; expected at most {_COARSEST_MM:g} mm"
        )
    return resolution


def parse_count(text: str) -> int:
    """How many, 1 or more."""
    count = int(text) if text.isascii() and text.isdigit() and len(text) < 10 else 0
    if count < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a count; expected 1 or more")
    return count


def parse_hairs(text: str) -> int:
    """How many hairs a tuft has; 0 for a solid one."""
    count = int(text) if text.isdecimal() and len(text) < 9 else -1
    if not 0 <= count <= _MOST_HAIRS:
        raise argparse.ArgumentTypeError(f"{text!r} hairs; expected 0 to {_MOST_HAIRS}")
    return count


def parse_share(text: str) -> float:
    """A share from the command line, above 0 to 1."""
    return parse_number(text, "a share", "above 0 to 1", lambda n: 0.0 < n <= 1.0)


def _parse_dips(text: str) -> str | int:
    """When the brush is dipped: ``auto``, ``always``, or before every so many characters."""
    if text in ("auto", "always"):
        return text
    count = text.removeprefix("every").strip()
    if not (count.isascii() and count.isdigit() and len(count) < 6 and int(count) > 0):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not when to dip; expected auto, always, or a count of characters such as "
            "3 or 'every 3'"
        )
    return int(count)


def _parse_rate(text: str) -> float:
    """A rate from the command line, 1/mm, 0 or more."""
    return parse_number(text, "a rate", "1/mm, 0 or more", lambda n: 0.0 <= n < math.inf)


def parse_place(text: str) -> tuple[float, float]:
    """A place on the object, ``U,V``, each 0 to 1."""
    try:
        u, v = (float(part) for part in text.split(","))
    except ValueError:
        u = v = math.nan
    if not (0 <= u <= 1 and 0 <= v <= 1):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a place; expected U,V with both from 0 to 1, such as 0.5,0.5"
        )
    return u, v


def add_quiet_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--quiet``."""
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def own_file(name: str | None) -> str | None:
    """The file that a brush or a material is read from; None for what comes with the program."""
    return name if (name or "").lower().endswith((".toml", ".json")) else None


def add_force_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--force``."""
    parser.add_argument(
        "--force",
        action="store_true",
        help="write even over a file that is read from, or that the object's file refers to",
    )


def add_on_and_out(parser: argparse.ArgumentParser, *, needs_out: bool = True) -> None:
    """Add what is painted on, and where the painting goes."""
    parser.add_argument(
        "--on",
        metavar="MESH",
        required=True,
        help="a mesh file, or bowl, plate, vase, sphere, plane",
    )
    parser.add_argument(
        "--out", metavar="FILE", type=Path, required=needs_out, help="where to write the painting"
    )


def add_surface_options(parser: argparse.ArgumentParser) -> None:
    """Add what a surface is made of, and how fine."""
    parser.add_argument(
        "--material",
        metavar="NAME|FILE",
        default=MATERIALS[0],
        help=f"of the surface: {', '.join(MATERIALS)}, or a file of your own, mine.toml or "
        f"mine.json (default: {MATERIALS[0]})",
    )
    parser.add_argument(
        "--resolution",
        metavar="MM",
        type=parse_resolution_mm,
        default=0.4,
        help="vertex spacing wanted where paint is (default: 0.4)",
    )


def add_painting_options(
    parser: argparse.ArgumentParser,
    brush: str = "the recording's",
    ink: str = "the recording's",
) -> None:
    """Add what describes brush, ink and surface; `brush` and `ink` say what None stands for."""
    parser.add_argument(
        "--brush",
        metavar="NAME|FILE",
        help="brush: a name of `paint3d brushes`, or a file of your own, mine.toml or mine.json "
        f"(default: {brush})",
    )
    parser.add_argument(
        "--hairs",
        metavar="N",
        type=parse_hairs,
        help="paint with so many single hairs, 1 to 10000; 0: a solid tuft (default: the brush's)",
    )
    add_ink_options(parser, ink)
    add_surface_options(parser)
    parser.add_argument(
        "--unit",
        choices=UNITS,
        help="length of one unit in the mesh file (default: as the file says, else mm)",
    )
    parser.add_argument(
        "--from-points",
        action="store_true",
        default=None,
        help="build a surface through the points of a mesh file that holds no triangles, even if "
        "it is not a point cloud",
    )
    parser.add_argument(
        "--texture",
        action="store_true",
        help="show the materials and pictures of the object's file, on a mesh that is refined "
        "until they can be seen",
    )
    add_up_option(parser)


def add_ink_options(parser: argparse.ArgumentParser, ink: str) -> None:
    """Add what the brush is dipped in, and what the ink does; `ink` says what None stands for."""
    parser.add_argument(
        "--ink",
        metavar="INK",
        help="NAME, FILE.csv:NAME or several with their parts, such as 'pine soot:0.2,water:0.8'; "
        f"burnt, thick, heavy, light or clear, alone or before a name (default: {ink})",
    )
    parser.add_argument(
        "--tip", metavar="INK", help="dip the tip in this ink afterwards (default: all in one)"
    )
    parser.add_argument(
        "--reach",
        metavar="SHARE",
        type=parse_share,
        default=TIP_REACH,
        help=f"of the tuft's length that --tip dips (default: {TIP_REACH:g})",
    )
    parser.add_argument(
        "--pickup",
        metavar="RATE",
        type=_parse_rate,
        default=0.0,
        help="share of the wet ink below it that the brush takes up per mm of travel; .05 is a "
        "thirsty brush (default: 0, it stays clean)",
    )
    add_spread_option(parser)


def add_spread_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--spread``."""
    parser.add_argument(
        "--spread",
        metavar="S",
        type=parse_seconds,
        help="let the ink spread and dry while it is painted, and S seconds more",
    )


def add_dip_option(parser: argparse.ArgumentParser, default: str = DIPS) -> None:
    """Add ``--dip``; `default` says what None stands for."""
    parser.add_argument(
        "--dip",
        metavar="'every N'|auto|always",
        type=_parse_dips,
        help="when the brush is dipped: before every N-th character; auto: where it would run dry "
        "within the next, about every fourth; always: fully, before each of them (default: "
        f"{default})",
    )


def add_up_option(
    parser: argparse.ArgumentParser, otherwise: str = "as the format says, else z"
) -> None:
    """Add ``--up``; `otherwise` says what is up without it."""
    parser.add_argument(
        "--up",
        metavar="AXIS",
        choices=(*_UP_AXES, "auto"),
        help="axis of the mesh file that points up: x, y, z, or --up=-x and so on; auto: guess it "
        f"where the format does not say and it is sure (default: {otherwise})",
    )


def check_output_folder(folder: Path) -> None:
    """Refuse a folder that could not be written to.

    Raises
    ------
    ExportError
        If it (or, where it is yet to be made, its nearest parent) is not a writable folder.
    """
    there = folder
    while not there.exists() and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise ExportError(f"{there} is not a folder; {folder} cannot be made")
    if not os.access(there, os.W_OK | os.X_OK):
        raise ExportError(f"{there}: no permission to write there")


def check_output_file(file: Path, suffixes: tuple[str, ...]) -> None:
    """Refuse, before any work, an output file that could not be written at the end.

    Raises
    ------
    ExportError
        If the suffix is unknown, the folder is missing or closed, or the path is a folder, a pipe
        or a device.
    """
    name = file.name.lower()
    if not any(name.endswith(suffix) and name != suffix for suffix in suffixes):
        raise ExportError(
            f"{file}: unknown kind of file; expected a name ending in {', '.join(suffixes)}"
        )
    if file.is_dir():
        raise ExportError(f"{file} is a folder; expected a file name")
    if file.exists() and not file.is_file():
        raise ExportError(f"{file} is a pipe or a device; expected a file name")
    if not file.parent.is_dir():
        raise ExportError(f"{file}: there is no folder {file.parent}")
    check_output_folder(file.parent)


def check_overwriting(
    written: Iterable[Path | None], read: Iterable[str | Path | None], *, force: bool
) -> None:
    """Refuse to write over a file that is read from, or that a mesh which is read refers to.

    Nor is one file written twice.

    Parameters
    ----------
    written, read : iterable of path-like or None
        None stands for an option that was not given. What is read may also be the name of
        something else than a file.
    force : bool
        Whether what is read from may be replaced.

    Raises
    ------
    ExportError
        If a file that is written is, under whatever name, one of those, a picture, a material
        library or a buffer of one of them, or another one written.
    """
    files = [file for file in written if file is not None]
    for k, file in enumerate(files):
        for other in files[:k]:
            if _same_file(file, other):
                raise ExportError(f"{file} is {other}; expected a file for each of them")
        for source in () if force else [source for source in read if source]:
            if _same_file(file, source):
                raise ExportError(
                    f"{file} would be replaced, and {source} is read from it; "
                    "expected another name, or --force"
                )
            if _refers_to(source, file):
                raise ExportError(
                    f"{file} would be replaced, and {source} refers to it; "
                    "expected another name, or --force"
                )


def _refers_to(source: str | Path, file: Path) -> bool:
    """Whether a mesh that is read speaks of a file that would be replaced."""
    if not file.exists() or not os.path.isfile(source):
        return False
    from paint3d.files.references import refers_to_apart

    return refers_to_apart(Path(source), file)


def _same_file(one: str | Path, other: str | Path) -> bool:
    """Whether two paths lead to one file, through links or not; it need not be there yet."""
    try:
        return os.path.samefile(one, other)
    except FileNotFoundError:
        return os.path.realpath(one) == os.path.realpath(other)
    except (OSError, ValueError):  # one of them is no file name
        return False


# ---- The object ----------------------------------------------------------------------------------
# The object that a command paints on: read once for all the rows of a batch that name it.


_last: dict[tuple[Any, ...], TriangleMesh] = {}  # the one that was read last


def load_object(options: argparse.Namespace) -> TriangleMesh:
    """Load the mesh that ``--on`` names, as the other options say.

    Raises
    ------
    MeshError
        If the file cannot be read or holds no usable surface.
    """
    path = os.path.abspath(options.on)  # a name means another file in another folder
    how = (options.unit, options.from_points, options.texture, options.up)
    key = (options.on, path, _state(path), *how)
    if key not in _last:
        from paint3d.files.load import load_mesh

        unit, from_points, texture, up = how
        with ProgressBar("reading", enabled=not options.quiet) as progress:
            mesh = load_mesh(
                options.on, unit, from_points=from_points, texture=texture, up=up,
                progress=progress,
            )  # fmt: skip
        _last.clear()
        _last[key] = mesh
    return _last[key]


def _state(path: str) -> tuple[int, int] | None:
    """What tells a file's versions apart; None where there is no file, but a name."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_size, found.st_mtime_ns


# ---- Devices -------------------------------------------------------------------------------------
# Options about the hands' devices.


def add_stylus_option(parser: argparse.ArgumentParser, default: str) -> None:
    """Let the stylus be chosen; None where it is not."""
    parser.add_argument(
        "--stylus",
        metavar="KIND",
        type=_parse_stylus,
        help="auto, hid, openhaptics (Touch, Phantom; =/PATH/libHD.so), inverse3 "
        f"(Haply; =ws://HOST:PORT) or none{default}",
    )


def _parse_stylus(text: str) -> str:
    from paint3d.errors import InputError
    from paint3d.haptics.stylus_choice import check_stylus

    try:
        return check_stylus(text)
    except InputError as cause:
        raise argparse.ArgumentTypeError(str(cause)) from None

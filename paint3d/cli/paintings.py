"""The painting that a command shows: a session, or any mesh with its colours."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import UNITS, add_up_option
from paint3d.cli.progress import ProgressBar

if TYPE_CHECKING:
    from paint3d.files.project.session import Session
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["add_painting_argument", "is_recording", "open_painting"]

_RECORDINGS = (".jsonl", ".inkml", ".csv", ".json")


def add_painting_argument(parser: argparse.ArgumentParser, unit: str = "--unit") -> None:
    """Add PAINTING, and how a mesh is to be read; `unit` names the option for its unit."""
    parser.add_argument(
        "painting",
        metavar="PAINTING",
        help="a session (.p3d), any mesh that is read, with its colours and pictures, or bowl, "
        "plate, vase, sphere, plane",
    )
    parser.add_argument(
        unit,
        dest="mesh_unit",
        choices=UNITS,
        help="length of one unit in a mesh file (default: as the file says, else mm)",
    )
    add_up_option(parser)


def is_recording(name: str) -> bool:
    """Whether a file's name is that of a recording."""
    plain = name.lower().removesuffix(".gz")
    return plain.endswith(_RECORDINGS)


def open_painting(options: argparse.Namespace) -> Session | TriangleMesh:
    """Open what PAINTING names.

    Raises
    ------
    SessionError, MeshError
        If it cannot be read.
    """
    from paint3d.files.load import load_mesh
    from paint3d.files.project.session import is_session_path, load_session

    with ProgressBar("opening", enabled=not options.quiet) as progress:
        if is_session_path(options.painting):
            return load_session(Path(options.painting), progress)
        return load_mesh(
            options.painting, options.mesh_unit, texture=True, up=options.up, progress=progress
        )

"""XYZ: a point a line, as scanners write them, with or without a colour."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError, Message
from paint3d.files.colours import colour_codes
from paint3d.files.contents import plain_text
from paint3d.files.raw_mesh import RawMesh, parse_numbers

__all__ = ["read_xyz"]

COLOURED = (6, 7)  # numbers of a line: x y z, red green blue, alpha


def read_xyz(data: bytes) -> RawMesh:
    """Read points x y z, or x y z red green blue [alpha], between blanks or commas.

    Raises
    ------
    MeshError
        If a line has fewer than three numbers, or not as many as the first.
    """
    lines = [line.partition(b"#")[0] for line in plain_text(data).replace(b",", b" ").split(b"\n")]
    lines = [line for line in lines if line.strip()]
    width = len(lines[0].split()) if lines else 0
    for k, line in enumerate(lines):
        if width < 3 or len(line.split()) != width:
            expected = "three numbers or more" if width < 3 else f"{width} numbers, as in the first"
            shown = line.strip()[:40].decode("latin-1")
            raise MeshError(
                "point {k} is {shown!r}; expected {expected}",
                k=k,
                shown=shown,
                expected=expected,
            )
    table = parse_numbers(b"\n".join(lines), Message("a point")).reshape(len(lines), width)
    colours: NDArray[np.uint8] | None = None
    notes: tuple[Message, ...] = ()
    if width in COLOURED:
        rgb = table[:, 3:6]
        whole = bool((rgb == np.floor(rgb)).all())
        colours, notes = colour_codes(rgb, 255 if whole else 1)
    none = np.empty((0, 3), np.int64)
    return RawMesh.of_triangles(table[:, :3], none, colours=colours, notes=notes)

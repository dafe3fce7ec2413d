"""XYZ: a point a line, as scanners write them, with or without a colour and a normal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError, Message
from paint3d.files.colours import colour_codes
from paint3d.files.contents import plain_text
from paint3d.files.raw_mesh import RawMesh, left_out, parse_numbers

__all__ = ["read_xyz"]

COLOURED = (6, 7)  # numbers of a line: x y z, red green blue, alpha
BOTH = (9, 10)  # with a normal besides, before the colour or after it
UNIT = 1e-2  # that the length of a normal may differ from 1


def read_xyz(data: bytes) -> RawMesh:
    """Read points x y z, between blanks or commas, with their normal and red green blue [alpha].

    Numbers of length 1, some of them below 0, are a normal's. What else stands in a line is left
    out, and noted.

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
    normals: NDArray[np.float64] | None = None
    colours: NDArray[np.uint8] | None = None
    notes: tuple[Message, ...] = ()
    at = [3] if width in COLOURED else [3, width - 3] if width in BOTH else []
    of_normal = next((k for k in reversed(at) if _are_normals(table[:, k : k + 3])), None)
    if of_normal is not None:
        normals = table[:, of_normal : of_normal + 3]
        at = [6 if k == width - 3 and of_normal == 3 else k for k in at if k != of_normal]
    if at:
        rgb = table[:, at[0] : at[0] + 3]
        whole = bool((rgb == np.floor(rgb)).all())
        colours, notes = colour_codes(rgb, 255 if whole else 1)
    if width > 3 and of_normal is None and (not at or width in BOTH):
        notes += left_out([Message("numbers after the places of points")])
    none = np.empty((0, 3), np.int64)
    return RawMesh.of_triangles(table[:, :3], none, colours=colours, normals=normals, notes=notes)


def _are_normals(rows: NDArray[np.float64]) -> bool:
    length = np.linalg.norm(rows, axis=1)
    return bool((rows < 0.0).any() and np.mean(np.abs(length - 1.0) < UNIT) > 0.5)

"""The child process in which one file of a stranger is read: `python -m` with a request.

It limits itself before it looks at the file, so that whatever the file does to a reader, it ends
here: memory, processor time and the size of what is handed back.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from paint3d.core.arrays import AnyArray
from paint3d.core.machine import from_parent, limit_process

__all__ = ["main"]


def main() -> None:
    """Read the file of the request (JSON in the first argument) and hand over what it holds."""
    request = json.loads(sys.argv[1])
    limit_process(int(request["memory"]), int(request["seconds"]))

    from paint3d.errors import InputError
    from paint3d.files.sandbox.handover import send

    path = Path(os.fsdecode(bytes.fromhex(request["path"])))
    descriptor = from_parent(int(request["file"]))
    read = _READERS[request["kind"]]
    try:
        arrays, facts = read(path, request["wanted"])
    except InputError as cause:
        send(descriptor, {}, {"error": str(cause)})
        return
    send(descriptor, arrays, facts)


def _photograph(path: Path, wanted: list[Any]) -> tuple[dict[str, AnyArray], dict[str, object]]:
    from paint3d.files.photographs import read_photograph

    pixels, full = read_photograph(path, *wanted)
    facts: dict[str, object] = {"size": pixels.shape[:2], "full": full}
    return {"pixels": pixels.reshape(-1, 3)}, facts


def _mesh(path: Path, wanted: list[Any]) -> tuple[dict[str, AnyArray], dict[str, object]]:
    from paint3d.files.reading import Wanted, read_surface

    reading = read_surface(path, Wanted(*wanted))
    mesh = reading.mesh
    arrays: dict[str, AnyArray] = {"vertices": mesh.vertices, "faces": mesh.faces}
    arrays |= {} if mesh.normals is None else {"normals": mesh.normals}
    arrays |= {} if mesh.colours is None else {"colours": mesh.colours}
    facts: dict[str, object] = {"name": mesh.name, "notes": list(reading.notes)}
    facts |= {"knows_up": reading.knows_up, "unit_mm": reading.unit_mm, "up": reading.up}
    return arrays, facts


def _references(path: Path, wanted: list[Any]) -> tuple[dict[str, AnyArray], dict[str, object]]:
    from paint3d.files.references import refers_to

    return {}, {"refers": refers_to(path, Path(os.fsdecode(bytes.fromhex(wanted[0]))))}


def _records(path: Path, wanted: list[Any]) -> tuple[dict[str, AnyArray], dict[str, object]]:
    from paint3d.files.formats.records import read_records_here

    records = read_records_here(path)
    arrays: dict[str, AnyArray] = {"positions": records.vertices, "directions": records.normals}
    arrays |= {} if records.faces is None else {"rows": records.faces}
    arrays["colours"] = records.srgb
    return arrays, {"start": records.initial_position.tolist()}


_READERS = {
    "mesh": _mesh,
    "photograph": _photograph,
    "records": _records,
    "references": _references,
}


if __name__ == "__main__":
    main()

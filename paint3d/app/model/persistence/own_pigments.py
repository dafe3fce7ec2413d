"""Tables of pigments of one's own that were opened once, and are at hand with every start.

Settings keep where each table lies and a fingerprint of its bytes: the table itself stays the
user's file, and what it says now is what counts.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from paint3d.colour.pigments import WATER, Pigment, load_palette, load_pigments_csv
from paint3d.errors import Message, Paint3DError, PigmentError

__all__ = ["OwnPigments", "check_unlike_palette", "fingerprint_of", "own_pigments"]

_DIGITS = 16  # of a fingerprint
_OUT = "none"  # in its place: the table could not be used, which was said


@dataclass
class OwnPigments:
    """Contents of the user's pigment tables now.

    Attributes
    ----------
    pigments : dict of str to Pigment
        By name; of two of one name that of the later table.
    tables : dict of str to str
        All of them, and their fingerprints as they are now, "none" where a table is gone or cannot
        be used: to be kept, for it may be back with a later start.
    problems : list of Message
        A line for each table that is gone, cannot be used, or is not as it was, since last time.
    """

    pigments: dict[str, Pigment] = field(default_factory=dict)
    tables: dict[str, str] = field(default_factory=dict)
    problems: list[Message] = field(default_factory=list)


def fingerprint_of(path: str | Path) -> str:
    """Of a table's bytes.

    Raises
    ------
    PigmentError
        If it cannot be read.
    """
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:_DIGITS]
    except OSError as cause:
        raise PigmentError("{file}: cannot be read: {cause}", file=path, cause=cause) from None


def check_unlike_palette(pigments: Iterable[Pigment], source: str) -> None:
    """Refuse pigments that are called like one of the palette.

    Raises
    ------
    PigmentError
        Naming the first.
    """
    for pigment in pigments:
        if pigment.name in load_palette() or pigment.name == WATER.name:
            raise PigmentError(
                "{source}: {pigment!r} is called like an ink of the palette; expected another name",
                source=source,
                pigment=pigment.name,
            )


def own_pigments(tables: Mapping[str, str]) -> OwnPigments:
    """Read the tables that were stored.

    Parameters
    ----------
    tables : mapping of str to str
        Paths, and the fingerprint of each when it was read last.
    """
    own = OwnPigments()
    for path, fingerprint in tables.items():
        try:
            now, pigments = _read(path)
        except Paint3DError as cause:
            own.tables[path] = _OUT
            if fingerprint != _OUT:
                own.problems.append(cause.message)
            continue
        if fingerprint not in (_OUT, now):
            own.problems.append(
                Message("{file}: has changed; its pigments are as it says now", file=path)
            )
        own.pigments.update(pigments)
        own.tables[path] = now
    return own


def _read(path: str) -> tuple[str, Mapping[str, Pigment]]:
    """A table's fingerprint and its pigments; an error says that they are left out."""
    if not os.path.exists(path):
        raise PigmentError("{file}: is gone, and its pigments with it", file=path)
    try:
        fingerprint, pigments = fingerprint_of(path), load_pigments_csv(path)
        check_unlike_palette(pigments.values(), path)
    except Paint3DError as cause:
        raise PigmentError("{cause}; its pigments are left out", cause=cause) from None
    return fingerprint, pigments

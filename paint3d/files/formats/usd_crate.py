"""USD's binary form ("crate", .usdc), as far as one painted mesh needs it, in version 0.8.

Pixar documents the format by its source (pxr/usd/sdf/crateFile.h, integerCoding.h): a header,
values one after the other, then tables of tokens, fields, sets of fields, paths and specs, and a
table of contents. The tables are compressed in the file; what is written here says "no run
repeats", which every decoder takes and which costs a few hundred bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import BinaryIO, cast

import numpy as np

from paint3d.core.arrays import AnyArray

__all__ = ["ListOp", "Spec", "SpecType", "Type", "Value", "write_crate"]

VERSION = (0, 8, 0)
HEADER_SIZE, INLINED, ARRAY = 88, 1 << 62, 1 << 63
ALIGNMENT = 8
NO_FIELD = 0xFFFFFFFF
FIRST_TOKEN = ";-)"  # a property's name is marked by a minus, so none may have place 0
PREPENDED, IS_EXPLICIT, EXPLICIT = 32, 1, 2


class SpecType(IntEnum):
    """What a path of the scene is."""

    ATTRIBUTE = 1
    PRIM = 6
    ROOT = 7
    RELATIONSHIP = 8


class Type(IntEnum):
    """Of a value."""

    BOOL = 1
    INT = 3
    FLOAT = 8
    DOUBLE = 9
    STRING = 10
    TOKEN = 11
    VEC3F = 24
    TOKEN_LIST_OP = 32
    PATH_LIST_OP = 34
    TOKEN_VECTOR = 41
    SPECIFIER = 42
    VARIABILITY = 44


@dataclass(frozen=True)
class ListOp:
    """Names or paths, put before those of weaker layers or instead of them."""

    items: Sequence[str]
    explicit: bool = True


@dataclass(frozen=True)
class Value:
    """A value and its type; an array becomes an array."""

    type: Type
    value: bool | int | float | str | Sequence[str] | ListOp | AnyArray


@dataclass(frozen=True)
class Spec:
    """A prim (``/A/B``), an attribute or a relationship (``/A/B.name``) with its fields."""

    path: str
    type: SpecType
    fields: dict[str, Value]


def write_crate(file: BinaryIO, specs: Sequence[Spec]) -> None:
    """Write a scene.

    Parameters
    ----------
    file : binary file
        At its beginning, or where the crate is to begin in a package.
    specs : sequence of Spec
        The root ``/`` first, then depth first: the properties of a prim right after it, its
        children after those.
    """
    _Crate(file).write(specs)


class _Crate:
    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.start = file.tell()
        self.tokens = {FIRST_TOKEN: 0}
        self.strings: dict[str, int] = {}
        self.paths: dict[str, int] = {}

    def token(self, name: str) -> int:
        return self.tokens.setdefault(name, len(self.tokens))

    def here(self) -> int:
        return self.file.tell() - self.start

    def write(self, specs: Sequence[Spec]) -> None:
        self.file.write(bytes(HEADER_SIZE))
        self.paths = {spec.path: k for k, spec in enumerate(specs)}
        fields: dict[tuple[int, int], int] = {}
        sets, starts = list[int](), list[int]()
        for spec in specs:
            starts.append(len(sets))
            for name, value in spec.fields.items():
                field = self.token(name), self.represent(value)
                sets.append(fields.setdefault(field, len(fields)))
            sets.append(NO_FIELD)
        tree = _encode_tree([spec.path for spec in specs], self.token)
        count = struct.pack("<Q", len(specs))
        names = [name for name, _ in fields]
        reps = struct.pack(f"<{len(fields)}Q", *(rep for _, rep in fields))
        sections = {
            "TOKENS": self.token_section(),
            "STRINGS": _counted([self.tokens[text] for text in self.strings]),
            "FIELDS": struct.pack("<Q", len(names)) + _integers(names) + _sized(_packed(reps)),
            "FIELDSETS": struct.pack("<Q", len(sets)) + _integers(sets),
            "PATHS": count + count + b"".join(map(_integers, tree)),
            "SPECS": count
            + _integers(range(len(specs)))
            + _integers(starts)
            + _integers([spec.type for spec in specs]),
        }
        self.finish(sections)

    def finish(self, sections: dict[str, bytes]) -> None:
        """Write the sections and their table, and then the header that says where that is."""
        table = struct.pack("<Q", len(sections))
        for name, data in sections.items():
            table += struct.pack("<16sQQ", name.encode("ascii"), self.here(), len(data))
            self.file.write(data)
        contents = self.here()
        self.file.write(table)
        end = self.file.tell()
        self.file.seek(self.start)
        self.file.write(struct.pack("<8s8BQ", b"PXR-USDC", *VERSION, *[0] * 5, contents))
        self.file.seek(end)

    def token_section(self) -> bytes:
        text = b"".join(name.encode("utf-8") + b"\0" for name in self.tokens)
        return struct.pack("<QQ", len(self.tokens), len(text)) + _sized(_packed(text))

    def represent(self, value: Value) -> int:
        """Return the 64 bits that stand for a value, writing what does not fit into them."""
        kind, content = value.type, value.value
        head = int(kind) << 48
        if isinstance(content, np.ndarray):
            return ARRAY | head | self.store(len(content), content.tobytes())
        if kind == Type.TOKEN_VECTOR:
            return head | self.store_bytes(
                _counted([self.token(name) for name in cast("Sequence[str]", content)])
            )
        if isinstance(content, ListOp):
            flags = (IS_EXPLICIT | EXPLICIT) if content.explicit else PREPENDED
            place = self.token if kind == Type.TOKEN_LIST_OP else self.paths.__getitem__
            items = _counted([place(item) for item in content.items])
            return head | self.store_bytes(bytes([flags]) + items)
        if kind == Type.DOUBLE:
            return head | self.store_bytes(struct.pack("<d", content))
        return INLINED | head | self.inline(kind, cast("bool | int | float | str", content))

    def inline(self, kind: Type, content: bool | int | float | str) -> int:
        if isinstance(content, str):
            token = self.token(content)
            return (
                token if kind == Type.TOKEN else self.strings.setdefault(content, len(self.strings))
            )
        if kind == Type.FLOAT:
            return int.from_bytes(struct.pack("<f", content), "little")
        return int(content)

    def store(self, count: int, data: bytes) -> int:
        self.file.write(bytes(-self.here() % ALIGNMENT))
        return self.store_bytes(struct.pack("<Q", count) + data)

    def store_bytes(self, data: bytes) -> int:
        at = self.here()
        self.file.write(data)
        return at


def _encode_tree(
    paths: Sequence[str], token: Callable[[str], int]
) -> tuple[list[int], list[int], list[int]]:
    """Return places, name tokens (negative for properties) and jumps of paths, depth first.

    A jump is -2 for a leaf, -1 where a child follows and no sibling comes, 0 where a sibling
    follows, and else the distance to the sibling after the children.
    """
    parents = [_parent(path) for path in paths]
    names, jumps = [], []
    for k, path in enumerate(paths):
        has_child = k + 1 < len(paths) and parents[k + 1] == path
        sibling = next((j for j in range(k + 1, len(paths)) if k and parents[j] == parents[k]), 0)
        jumps.append((sibling - k if sibling else -1) if has_child else (0 if sibling else -2))
        name = token(path[len(parents[k]) :].lstrip("/.")) if k else 0
        names.append(-name if "." in path else name)
    return list(range(len(paths))), names, jumps


def _parent(path: str) -> str:
    if path == "/":
        return ""
    prim, dot, _ = path.partition(".")
    return prim if dot else prim.rpartition("/")[0] or "/"


def _counted(places: Sequence[int]) -> bytes:
    return struct.pack(f"<Q{len(places)}I", len(places), *places)


def _sized(data: bytes) -> bytes:
    return struct.pack("<Q", len(data)) + data


def _integers(values: Sequence[int]) -> bytes:
    """Code integers as differences, each with the code of a full 32-bit difference."""
    deltas = np.diff(np.array([0, *values], np.int64)).astype(np.uint32, casting="unsafe")
    codes = b"\xff" * ((2 * len(deltas) + 7) // 8)
    return _sized(_packed(bytes(4) + codes + deltas.astype("<u4").tobytes()))


def _packed(data: bytes) -> bytes:
    """Return data as one LZ4 block of literals, with USD's byte before it."""
    rest = len(data) - 15
    if rest < 0:
        return bytes([0, len(data) << 4]) + data
    return bytes([0, 0xF0]) + b"\xff" * (rest // 255) + bytes([rest % 255]) + data

"""Damage done to files: bytes, numbers, words, lines, and the entries of archives."""

from __future__ import annotations

import copy
import io
import json
import random
import re
import zipfile
from collections.abc import Callable, Sequence
from typing import Any

__all__ = ["damage", "damage_archive", "damage_json"]

NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
NUMBERS = (
    b"0", b"-0", b"-1", b"1", b"2", b"255", b"256", b"65535", b"65536", b"2147483647",
    b"2147483648", b"-2147483648", b"4294967295", b"9007199254740993", b"9223372036854775807",
    b"9223372036854775808", b"18446744073709551616", b"1e-320", b"1e308", b"-1e308", b"1e999",
    b"NaN", b"nan", b"Infinity", b"-inf", b"0x10", b"1_000", b"1.", b".5", b"1e", b"", b"9" * 400,
    b"\xef\xbc\x91", b"null", b"true", b'"1"', b"[]", b"{}",
)  # fmt: skip
WORDS = (b"\x00", b"\n", b"\r", b"\r\n", b"\t", b" ", b",", b"/", b"#", b"{", b"}", b"[", b"]")
WORDS += (b"<", b">", b"&", b'"', b"'", b"\\", b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf", b"\xff")
MOST_BYTES = 1 << 16


def damage(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Return `data` with one to eight kinds of damage; `others` are files to splice with."""
    for _ in range(1 + min(int(chance.expovariate(1.5)), 7)):
        data = chance.choice(KINDS)(data, chance, others)
        data = data[:MOST_BYTES]
    return data


def damage_archive(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Return a zip archive of which an entry is damaged, missing, doubled or renamed.

    Damage from outside would hardly ever get past the entries' checksums.
    """
    if chance.random() < 0.1:
        return damage(data, chance, others)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        kinds = {entry.filename: entry.compress_type for entry in archive.infolist()}
        entries = [(name, archive.read(name)) for name in archive.namelist()]
    for _ in range(1 + min(int(chance.expovariate(1.0)), 3)):
        k = chance.randrange(len(entries))
        name, content = entries[k]
        way = chance.random()
        if way < 0.9:
            entries[k] = (name, damage(content, chance, [c for _, c in entries]))
        elif way < 0.94:
            entries[k] = (name, chance.choice(entries)[1])
        elif way < 0.97 and len(entries) > 1:
            del entries[k]
        else:
            entries[k] = (damage(name.encode(), chance, others).decode("latin-1"), content)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in dict(entries).items():
            info = zipfile.ZipInfo((name or "x")[:60000], (1980, 1, 1, 0, 0, 0))
            info.compress_type = kinds.get(name, zipfile.ZIP_STORED)
            archive.writestr(info, content)
    return file.getvalue()


_VALUES: tuple[Any, ...] = (
    0, 1, 2, -1, 3, 255, 256, 65536, 2**31, 2**32, 2**63, 2**64, 0.5, 1e300, -1e-300, None, True,
    "", "x", "\ud800", "NONE", "VEC3", "SCALAR", [], {}, [0], [[0]], {"a": 0}, 5120, 5121, 5126,
)  # fmt: skip


def damage_json(text: bytes, chance: random.Random) -> bytes:
    """Return a JSON document in which one to three values are changed, missing or doubled."""
    document = json.loads(text)
    for _ in range(chance.choice((1, 1, 2, 3))):
        _damage_value(document, chance)
    return json.dumps(document).encode("utf-8", "surrogatepass")


def _damage_value(document: Any, chance: random.Random) -> None:
    """Change, drop or double one value somewhere in a document."""
    places: list[tuple[Any, Any]] = []
    waiting = [document]
    while waiting:
        one = waiting.pop()
        keys = list(one) if isinstance(one, dict) else range(len(one))
        for key in keys:
            places.append((one, key))
            if isinstance(one[key], dict | list):
                waiting.append(one[key])
    if not places:
        return
    holder, key = chance.choice(places)
    way = chance.random()
    if way < 0.6:
        holder[key] = copy.deepcopy(chance.choice(_VALUES))  # or the next damage is done to it, too
    elif way < 0.8:
        del holder[key]
    else:
        other, its = chance.choice(places)
        taken = json.dumps(other[its])  # by value: a document must not hold itself
        holder[key] = json.loads(taken)


def _flip(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    if not data:
        return data
    at = chance.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1 :]


def _set_bytes(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    at, n = chance.randrange(len(data) + 1), chance.choice((1, 1, 2, 4, 8))
    kinds = (bytes(n), b"\xff" * n, b"\x7f" + b"\xff" * (n - 1), chance.randbytes(n))
    return data[:at] + chance.choice(kinds) + data[at + n :]


def _cut(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    return data[: chance.randrange(len(data) + 1)]


def _remove(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    at = chance.randrange(len(data) + 1)
    return data[:at] + data[at + chance.choice((1, 2, 4, 16, 100)) :]


def _repeat(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    at = chance.randrange(len(data) + 1)
    piece = data[at : at + chance.choice((1, 4, 20, 100))]
    return data[:at] + piece * chance.choice((2, 3, 10, 1000)) + data[at + len(piece) :]


def _insert(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    at = chance.randrange(len(data) + 1)
    return data[:at] + chance.choice(WORDS + NUMBERS) + data[at:]


def _number(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    """Replace a number that is written out."""
    found = NUMBER.search(data, chance.randrange(len(data) + 1))
    if found is None:
        return data
    return data[: found.start()] + chance.choice(NUMBERS) + data[found.end() :]


def _lines(data: bytes, chance: random.Random, _: Sequence[bytes]) -> bytes:
    lines = data.split(b"\n")
    k, j = chance.randrange(len(lines)), chance.randrange(len(lines))
    way = chance.randrange(3)
    if way == 0:
        del lines[k]
    elif way == 1:
        lines.insert(k, lines[j])
    else:
        lines[k], lines[j] = lines[j], lines[k]
    return b"\n".join(lines)


def _splice(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    other = chance.choice(others) if others else data
    at, start = chance.randrange(len(data) + 1), chance.randrange(len(other) + 1)
    return data[:at] + other[start : start + chance.choice((4, 32, 1000))] + data[at:]


KINDS: tuple[Callable[[bytes, random.Random, Sequence[bytes]], bytes], ...] = (
    _flip, _set_bytes, _cut, _remove, _repeat, _insert, _number, _number, _lines, _splice,
)  # fmt: skip

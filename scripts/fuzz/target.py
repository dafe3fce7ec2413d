"""Target of the fuzzer, and files for its reader."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from scripts.fuzz.mutation import damage

__all__ = ["Target", "file_of", "written"]

Damage = Callable[[bytes, random.Random, Sequence[bytes]], bytes]


@dataclass(frozen=True)
class Target:
    """A kind of input with its reader.

    Attributes
    ----------
    about : str
    seeds : callable
        Returns good inputs as (suffix, content), made afresh.
    check : callable
        Takes a suffix and a content; raises a Paint3DError for what it refuses, and an
        AssertionError if something that it accepts breaks its promises.
    damage : callable
    """

    about: str
    seeds: Callable[[], list[tuple[str, bytes]]]
    check: Callable[[str, bytes], None]
    damage: Damage = damage


_folder = tempfile.TemporaryDirectory(
    prefix="fuzz", dir="/dev/shm" if Path("/dev/shm").is_dir() else None
)


def file_of(suffix: str, content: bytes) -> Path:
    """A file with these bytes; the next one takes its place."""
    path = Path(_folder.name) / f"a{suffix}"
    path.write_bytes(content)
    return path


def written(suffix: str, write: Callable[[Path], object]) -> tuple[str, bytes]:
    """Write a file with a writer, as a seed."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / f"a{suffix}"
        write(path)
        return suffix, path.read_bytes()

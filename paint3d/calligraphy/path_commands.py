"""The commands of an SVG path."""

from __future__ import annotations

import re
from collections.abc import Mapping

from paint3d.errors import InputError

__all__ = ["split_path"]

_TOKEN = re.compile(r"([A-Za-z])|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|[\s,]+")


def split_path(path: str, name: str, sizes: Mapping[str, int]) -> list[tuple[str, list[float]]]:
    """Split a path into its commands with their numbers.

    Parameters
    ----------
    path : str
    name : str
        Of the path, for messages.
    sizes : mapping
        Of each command that may come, how many numbers it takes; some may take several times as
        many.

    Raises
    ------
    InputError
        If there is anything else in the path, or a command has not its numbers.
    """
    if not isinstance(path, str):
        raise InputError(f"{name} is {path!r}; expected an SVG path")
    commands: list[tuple[str, list[float]]] = []
    at = 0
    while at < len(path):
        match = _TOKEN.match(path, at)
        if match is None or (match[1] or "M") not in sizes or (match[2] and not commands):
            raise InputError(
                f"{name}: cannot read {path[at : at + 12].strip()!r}; expected {' '.join(sizes)}"
            )
        if match[1]:
            commands.append((match[1], []))
        elif match[2]:
            commands[-1][1].append(float(match[2]))
        at = match.end()
    for command, numbers in commands:
        size = sizes[command]
        if (size == 0 and numbers) or (size and (not numbers or len(numbers) % size)):
            raise InputError(f"{name}: {command} has {len(numbers)} numbers; expected {size}")
    return commands

"""Files of named parameters in TOML or JSON, as for users' own brushes and materials."""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from paint3d.errors import Paint3DError, UnknownNameError

__all__ = ["check_known", "find_or_read", "is_parameter_file", "read_object"]

_SUFFIXES = (".toml", ".json")
_MOST_BYTES = 1 << 20

_Object = TypeVar("_Object")


def is_parameter_file(name: str) -> bool:
    """Return whether a name is that of a parameter file.

    Examples
    --------
    >>> is_parameter_file("mine.toml"), is_parameter_file("full")
    (True, False)
    """
    return name.lower().endswith(_SUFFIXES)


def _read_parameters(path: Path, what: str, error: type[Paint3DError]) -> dict[str, Any]:
    """Read the parameters of a file, by name, unchecked.

    Parameters
    ----------
    path : Path
        ``.json``, or else TOML, in UTF-8, at most 1 MiB.
    what : str
        What the file describes, for messages: "a brush".
    error : type
        Of the exception that is raised.

    Raises
    ------
    error
        Naming the file, if it cannot be read or holds no parameters by name.
    """
    try:
        if not path.is_file():
            raise error(
                "{file}: there is no such file; expected {what} in .toml or .json",
                file=path,
                what=what,
            )
        with path.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise error("{file}: is over 1 MiB; expected {what}", file=path, what=what)
        text = data.decode("utf-8-sig")
        values: Any
        if path.suffix.lower() == ".json":
            values = json.loads(text)
        else:
            from tomllib import loads  # most runs read no such file

            values = loads(text)
    except OSError as cause:
        raise error("{file}: {cause}", file=path, cause=cause) from None
    except (ValueError, RecursionError) as cause:
        if isinstance(cause, Paint3DError):
            raise
        raise error(
            "{file}: cannot be read as {kind}: {cause}",
            file=path,
            kind=path.suffix[1:].upper(),
            cause=cause,
        ) from None
    if not isinstance(values, dict):
        raise error(
            "{file}: holds {values!r:.40}; expected parameters by name", file=path, values=values
        )
    return values


def read_object(
    path: str | Path,
    what: str,
    error: type[Paint3DError],
    make: Callable[[dict[str, Any], str], _Object],
) -> _Object:
    """Read the object that a parameter file describes.

    Parameters
    ----------
    path, what, error
        As for `_read_parameters`.
    make : callable
        Makes it from the parameters, and from its name where they give none.

    Raises
    ------
    error
        Naming the file; also what `make` raises.
    """
    path = Path(path)
    values = _read_parameters(path, what, error)
    try:
        return make(values, path.stem)
    except error as cause:
        raise error("{file}: {cause}", file=path, cause=cause) from None


def find_or_read(
    name: str,
    shipped: Mapping[str, _Object],
    what: str,
    error: type[Paint3DError],
    read: Callable[[str], _Object] | None,
) -> _Object:
    """Return the shipped object of that name, or read it from a file of that name.

    Parameters
    ----------
    name : str
    shipped : mapping
        By name.
    what : str
        The kind of object, for messages: "brush".
    error : type
        Of the exception that is raised for a file.
    read : callable or None
        Reads a file. None where the name comes from a file, which may not name another.

    Raises
    ------
    UnknownNameError
        If there is none; the message lists them.
    error
        If the file cannot be used, or may not be read.
    """
    if name in shipped:
        return shipped[name]
    if isinstance(name, str) and is_parameter_file(name):
        if read is None:
            raise error(
                "the {what} {name!r} is a file of this machine, which a file may not name; "
                "expected a {what} that comes with the program",
                what=what,
                name=name[-100:],
            )
        return read(name)
    raise UnknownNameError(what, str(name), shipped)


def check_known(
    values: Mapping[str, Any], known: Iterable[str], error: type[Paint3DError], what: str = ""
) -> None:
    """Refuse unknown parameters, suggesting the nearest known one.

    Parameters
    ----------
    values : mapping
        By name.
    known : iterable of str
        Known names.
    error : type
        Of the exception that is raised.
    what : str
        Beginning of the message: "bristles: ".

    Raises
    ------
    error
    """
    known = list(known)
    for name in values:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
            if near:
                raise error(
                    "{what}there is no {name!r:.60}: did you mean {near!r}? expected {known}",
                    what=what,
                    name=name,
                    near=near[0],
                    known=", ".join(known),
                )
            raise error(
                "{what}there is no {name!r:.60}: expected {known}",
                what=what,
                name=name,
                known=", ".join(known),
            )

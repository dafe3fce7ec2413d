"""Every exception that paint3d raises on purpose.

    Paint3DError                 catch this to catch them all
    |-- InputError               an argument or a file is wrong: what, where, what was expected
    |   |-- MeshError            a mesh file or mesh arrays
    |   |-- RecordingError       a recording
    |   |-- SessionError         a saved session, or a journal
    |   |-- PigmentError         a pigment, ink or material table
    |   |-- BrushError           a brush preset or parameter
    |   |-- GlyphError           characters of which no form is known
    |   |-- LayerError           a layer that takes no paint as it is
    |   `-- UnknownNameError     a name that is not among the known ones
    |-- DeviceError              a device, its reports or its driver
    |   `-- PermissionNeededError   it is plugged in and may not be opened; the udev rule to add
    |-- ExportError              a result that could not be written
    `-- KernelError              a hot loop that is not compiled, and cannot be

The command line turns each of them into one line on stderr and exit status 2. An error's text is a
`Message`: a template and its fields, which the studio's window shows in the language of its user.
"""

from __future__ import annotations

import copyreg
import difflib
from collections.abc import Iterable, Mapping
from typing import Any, Self

__all__ = [
    "BrushError",
    "DeviceError",
    "ExportError",
    "GlyphError",
    "InputError",
    "KernelError",
    "LayerError",
    "MeshError",
    "Message",
    "Paint3DError",
    "PermissionNeededError",
    "PigmentError",
    "RecordingError",
    "SessionError",
    "UnknownNameError",
]


class Message(str):
    """An English text that keeps its template and fields, so that it can be translated.

    Parameters
    ----------
    text : str
        A template, as `str.format` takes it; without fields it is taken as it is.
    plural : str, optional
        The template for a field `n` other than 1.
    **fields
        What the template names. An exception stands for its message, one of the system for its
        reason; what is neither text, number nor message is stored as text.

    Attributes
    ----------
    text, plural : str
        Its keys in the catalogues of translations.
    fields : dict
        Texts, numbers and messages by name.

    Examples
    --------
    >>> str(Message("{n} face", "{n} faces", n=2))
    '2 faces'
    """

    text: str
    plural: str
    fields: dict[str, Any]

    def __new__(cls, text: str, plural: str = "", /, **fields: object) -> Self:
        """Format the template with its fields."""
        values = {name: _printable(value) for name, value in fields.items()}
        template = plural if plural and values["n"] != 1 else text
        self = super().__new__(cls, template.format(**values) if values else template)
        self.text, self.plural = text, plural
        self.fields = {name: _storable(value) for name, value in values.items()}
        return self

    def to_json(self) -> dict[str, Any]:
        """Return template, fields and text, ready for JSON."""
        fields = {k: v.to_json() if isinstance(v, Message) else v for k, v in self.fields.items()}
        return {"text": self.text, "plural": self.plural, "fields": fields, "said": str(self)}

    @classmethod
    def from_json(cls, stored: Mapping[str, Any]) -> Message:
        """Make the message that `to_json` returned."""
        self = cls(stored["said"])
        self.text, self.plural = stored["text"], stored["plural"]
        self.fields = {
            name: cls.from_json(value) if isinstance(value, dict) else value
            for name, value in stored["fields"].items()
        }
        return self


def _printable(value: object) -> object:
    """Return a field's value as it is formatted: of an exception its message, on one line."""
    if isinstance(value, Paint3DError):
        return value.message
    if isinstance(value, OSError):
        return Message(value.strerror or str(value))
    return " ".join(str(value).split()) if isinstance(value, BaseException) else value


def _storable(value: Any) -> object:
    """Return a field's value as a number, text or message."""
    if getattr(value, "shape", None) == () and hasattr(value, "dtype"):  # a scalar of NumPy
        value = value.item()
    return value if isinstance(value, Message | str | int | float | None) else str(value)


class Paint3DError(Exception):
    """Base of all exceptions raised by paint3d.

    Parameters
    ----------
    text : str or Paint3DError
        A template, or an error whose message this one takes over.
    plural : str, optional
    hint : str
        What to do about it on the command line: an option, a package to install. By default that of
        an error among the fields.
    **fields
        See `Message`.
    """

    def __init__(
        self,
        text: str | Paint3DError = "",
        plural: str = "",
        /,
        *,
        hint: str = "",
        **fields: object,
    ) -> None:
        template = text.message if isinstance(text, Paint3DError) else text
        is_formatted = isinstance(template, Message) and not fields
        super().__init__(template if is_formatted else Message(template, plural, **fields))
        causes = [one for one in (text, *fields.values()) if isinstance(one, Paint3DError)]
        self.hint: str = hint or next((cause.hint for cause in causes if cause.hint), "")

    def __str__(self) -> str:
        return f"{self.message} ({self.hint})" if self.hint else str(self.message)

    def __reduce__(self) -> tuple[Any, ...]:
        return copyreg.__newobj__, (type(self), self.message), self.__dict__  # type: ignore[attr-defined]

    @property
    def message(self) -> Message:
        """The text: what happened, where, and what was expected."""
        message: Message = self.args[0]
        return message


class InputError(Paint3DError, ValueError):
    """Input that cannot be used; the message says what was got, where, and what was expected."""


class MeshError(InputError):
    """A mesh that is empty, broken, or in a form that cannot be read."""


class RecordingError(InputError):
    """A recording that is broken; the message starts with ``file:line:`` where there is one."""


class SessionError(InputError):
    """A saved session or a journal that is damaged, or newer than this program."""


class PigmentError(InputError):
    """A pigment, palette or material with values that light cannot have."""


class BrushError(InputError):
    """A brush parameter outside the range in which the model holds."""


class GlyphError(InputError):
    """Characters of which no form is known: the field `characters` has each once."""


class LayerError(InputError):
    """A layer that takes no paint as it is: the field `layer` is its name."""


class UnknownNameError(InputError):
    """A name that is not known; the message lists the known ones, the nearest first."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        near = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
        fields = {
            "kind": kind if isinstance(kind, Message) else Message(kind),
            "name": name,
            "known": ", ".join(names),
        }
        super().__init__(
            Message(
                "unknown {kind} {name!r}: did you mean {near!r}? expected one of {known}",
                near=near[0],
                **fields,
            )
            if near
            else Message("unknown {kind} {name!r}: expected one of {known}", **fields)
        )


class DeviceError(Paint3DError):
    """A device that is not there, cannot be opened, has gone, or sends what cannot be."""


class PermissionNeededError(DeviceError):
    """A device is plugged in and may not be opened; the message holds the udev rule to add."""


class ExportError(Paint3DError):
    """A result that could not be written; nothing half-written is left behind."""


class KernelError(Paint3DError, RuntimeError):
    """A hot loop that was not compiled ahead for this machine, where numba is not installed."""

"""Every exception that paint3d raises on purpose.

    Paint3DError                 catch this to catch them all
    |-- InputError               something handed in is wrong: what, where, what was expected
    |   |-- MeshError            a mesh file or mesh arrays
    |   |-- RecordingError       a recording
    |   |-- SessionError         a saved session, or a journal
    |   |-- PigmentError         a pigment, ink or material table
    |   |-- BrushError           a brush preset or parameter
    |   |-- GlyphError           characters of which no form is known
    |   |-- LayerError           a layer that takes no paint as it is
    |   `-- UnknownNameError     a name that is not among the known ones
    |-- DeviceError              a device, its reports or its driver
    |   `-- PermissionNeededError   it is plugged in and may not be opened: which node, and the rule
    |-- ExportError              a result that could not be written
    `-- KernelError              a hot loop that is not compiled, and cannot be

The command line turns each of them into one line on stderr and exit status 2. What an error says is
a `Message`: a template and its fields, which the studio's window says in the language of its user.
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
    """English for people, which keeps what it was made of, so that it can be said in a language.

    Parameters
    ----------
    text : str
        A template, as `str.format` takes it; without fields it is taken as it is.
    plural : str, optional
        The template for a field `n` other than 1.
    **fields
        What the template names. An error stands for its own message, one of the system for its
        reason; of what is neither text, number nor message, the text is kept.

    Attributes
    ----------
    text, plural : str
        By which catalogues know it.
    fields : dict
        Of texts, numbers and messages.

    Examples
    --------
    >>> str(Message("{n} face", "{n} faces", n=2))
    '2 faces'
    """

    text: str
    plural: str
    fields: dict[str, Any]

    def __new__(cls, text: str, plural: str = "", /, **fields: object) -> Self:
        """Put the fields in."""
        told = {name: _told(value) for name, value in fields.items()}
        template = plural if plural and told["n"] != 1 else text
        self = super().__new__(cls, template.format(**told) if told else template)
        self.text, self.plural = text, plural
        self.fields = {name: _plain(value) for name, value in told.items()}
        return self

    def to_words(self) -> dict[str, Any]:
        """All that it is made of, as JSON can hold it."""
        fields = {k: v.to_words() if isinstance(v, Message) else v for k, v in self.fields.items()}
        return {"text": self.text, "plural": self.plural, "fields": fields, "said": str(self)}

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Message:
        """What `to_words` wrote down."""
        self = cls(words["said"])
        self.text, self.plural = words["text"], words["plural"]
        self.fields = {
            name: cls.from_words(value) if isinstance(value, dict) else value
            for name, value in words["fields"].items()
        }
        return self


def _told(value: object) -> object:
    """What a field says: of errors their message."""
    if isinstance(value, Paint3DError):
        return value.message
    if isinstance(value, OSError):
        return Message(value.strerror or str(value))
    return " ".join(str(value).split()) if isinstance(value, BaseException) else value


def _plain(value: Any) -> object:
    """The same as a number, text or message."""
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
        What to do about it, for whoever types commands: an option, a package to install. By default
        that of an error among the fields.
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
        told = text.message if isinstance(text, Paint3DError) else text
        is_made = isinstance(told, Message) and not fields
        super().__init__(told if is_made else Message(told, plural, **fields))
        causes = [one for one in (text, *fields.values()) if isinstance(one, Paint3DError)]
        self.hint: str = hint or next((cause.hint for cause in causes if cause.hint), "")

    def __str__(self) -> str:
        return f"{self.message} ({self.hint})" if self.hint else str(self.message)

    def __reduce__(self) -> tuple[Any, ...]:
        return copyreg.__newobj__, (type(self), self.message), self.__dict__  # type: ignore[attr-defined]

    @property
    def message(self) -> Message:
        """What happened, where, and what was expected."""
        said: Message = self.args[0]
        return said


class InputError(Paint3DError, ValueError):
    """Input that cannot be used: what was got, where, and what was expected."""


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
        kind, every = kind if isinstance(kind, Message) else Message(kind), ", ".join(names)
        super().__init__(
            Message(
                "unknown {kind} {name!r}: did you mean {near!r}? expected one of {known}",
                kind=kind,
                name=name,
                near=near[0],
                known=every,
            )
            if near
            else Message(
                "unknown {kind} {name!r}: expected one of {known}",
                kind=kind,
                name=name,
                known=every,
            )
        )


class DeviceError(Paint3DError):
    """A device that is not there, cannot be opened, has gone, or sends what cannot be."""


class PermissionNeededError(DeviceError):
    """A device is plugged in and may not be opened; the message holds the udev rule to add."""


class ExportError(Paint3DError):
    """A result that could not be written; nothing half-written is left behind."""


class KernelError(Paint3DError, RuntimeError):
    """A hot loop that was not compiled ahead for this machine, where numba is not installed."""

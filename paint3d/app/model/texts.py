"""Everything the interface says, in English and Chinese, from one table (data/texts.json)."""

from __future__ import annotations

import functools
import importlib.resources
import json
import os
from collections.abc import Mapping

from paint3d.errors import UnknownNameError

__all__ = ["LANGUAGES", "Texts", "load_texts", "system_language"]

LANGUAGES = ("en", "zh")


@functools.lru_cache(maxsize=1)
def load_texts() -> dict[str, dict[str, str]]:
    """All texts: by key, then by language."""
    file = importlib.resources.files("paint3d.app.model").joinpath("data/texts.json")
    result: dict[str, dict[str, str]] = json.loads(file.read_text("utf-8"))
    return result


def system_language(environment: Mapping[str, str] | None = None) -> str:
    """The language of the user's system, as far as it is one of `LANGUAGES`; else English."""
    environment = os.environ if environment is None else environment
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        value = environment.get(name, "").split(":")[0].split(".")[0].lower()
        if value:
            return value[:2] if value[:2] in LANGUAGES else "en"
    return "en"


class Texts:
    """What the interface says in one language.

    Parameters
    ----------
    language : {"system", "en", "zh"}

    Raises
    ------
    UnknownNameError
        For another language.

    Examples
    --------
    >>> Texts("en")("device.lost", count=3)
    '3 lost'
    """

    def __init__(self, language: str = "system") -> None:
        if language == "system":
            language = system_language()
        if language not in LANGUAGES:
            raise UnknownNameError("language", str(language), LANGUAGES)
        self.language = language

    def __call__(self, key: str, **values: object) -> str:
        """The text of a key, with values put in.

        Raises
        ------
        UnknownNameError
            If there is no such key.
        KeyError
            If a value that the text names is not given.
        """
        texts = load_texts()
        if key not in texts:
            raise UnknownNameError("text", str(key), texts)
        return texts[key][self.language].format(**values)

"""``python -m tools.texts``: check the window's texts against their catalogues of translations.

All that may be said there stands in English in the package's sources: in calls of `say` and
`Message`, in the table of commands, and in errors. Each language has a catalogue of gettext
(``locale/LANGUAGE/LC_MESSAGES/paint3d.po``), which is compiled into the ``.mo`` that the studio
reads.
"""

from __future__ import annotations

import argparse
import ast
import os
import string
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import polib

__all__ = ["CATALOGUES", "Text", "compile_all", "faults_of", "find_texts", "update"]

ROOT = Path(__file__).parents[1]  # of the checkout
CATALOGUES = sorted((ROOT / "paint3d/app/window/locale").glob("*/LC_MESSAGES/paint3d.po"))

_UNSEEN = ("paint3d/api/", "paint3d/app/model/studies/", "paint3d/bench/", "paint3d/cli/")
"""What these say comes into no window."""
_PLACES = {
    "say": (0, 1),
    "Message": (0, 1),
    "Command": (1,),
    "UnknownNameError": (0,),
    "error": (0, 1),
}
"""Which arguments of a call are texts, and the plural of one; of other errors the first two.

A class of errors that is handed in is called `error`.
"""


class Text(NamedTuple):
    """A text, and its plural if it has one."""

    text: str
    plural: str


def _literal(node: ast.expr) -> str | None:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def _texts_in(path: Path) -> Iterator[Text]:
    """Yield the texts of a source.

    Raises
    ------
    ValueError
        If an error's text is put together where it is raised, so that no catalogue can have it.
    """
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
            continue
        name = node.func.id
        places = _PLACES.get(name, (0, 1) if name in _ERRORS else ())
        given = [node.args[k] for k in places if k < len(node.args)]
        if any(isinstance(one, ast.JoinedStr) for one in given):
            raise ValueError(f"{path}:{node.lineno}: a text is put together; expected fields")
        words = [_literal(one) for one in given]
        if words and words[0]:
            yield Text(words[0], words[1] or "" if len(words) > 1 else "")


def _error_names() -> frozenset[str]:
    tree = ast.parse((ROOT / "paint3d/errors.py").read_text("utf-8"))
    return frozenset(
        node.name for node in tree.body
        if isinstance(node, ast.ClassDef) and node.name.endswith("Error")
    )  # fmt: skip


_ERRORS = _error_names()


def find_texts() -> dict[Text, list[str]]:
    """Collect all texts, each with the sources that use it, as paths from the root."""
    found: dict[Text, list[str]] = {}
    for path in sorted((ROOT / "paint3d").rglob("*.py")):
        place = path.relative_to(ROOT)
        if place.as_posix().startswith(_UNSEEN):
            continue
        for text in _texts_in(path):
            said_in = found.setdefault(text, [])
            if place.as_posix() not in said_in:
                said_in.append(place.as_posix())
    return found


def fields_of(text: str) -> set[str]:
    """Return the names of a text's fields."""
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


def _text_of(entry: polib.POEntry) -> Text:
    return Text(entry.msgid, entry.msgid_plural)


def faults_of(catalogue: Path, texts: dict[Text, list[str]]) -> list[str]:
    """List the faults of a catalogue, a line each."""
    entries = {_text_of(entry): entry for entry in polib.pofile(os.fspath(catalogue))}
    faults = []
    for text, said_in in texts.items():
        if text not in entries or not entries[text].translated():
            faults.append(f"no translation of {text.text!r} ({said_in[0]})")
    for text, entry in entries.items():
        if text not in texts:
            faults.append(f"nothing says {text.text!r}")
        for translation in entry.msgstr_plural.values() or [entry.msgstr]:
            wanted = fields_of(text.plural or text.text)
            if translation and fields_of(translation) != wanted:
                faults.append(f"{translation!r} has other fields than {text.text!r}")
    return faults


def update(catalogue: Path, texts: dict[Text, list[str]]) -> None:
    """Add new texts to a catalogue, and remove those that no source uses."""
    file = polib.pofile(os.fspath(catalogue), wrapwidth=100)
    known = {_text_of(entry): entry for entry in file}
    file.clear()
    for text, said_in in sorted(texts.items(), key=lambda item: (item[1][0], item[0])):
        entry = known.get(text) or polib.POEntry(
            msgid=text.text, msgid_plural=text.plural, msgstr_plural={0: ""} if text.plural else {}
        )
        entry.occurrences = [(place, "") for place in said_in]
        file.append(entry)
    file.save()


def compile_all() -> None:
    """Write the ``.mo`` beside each catalogue that is newer."""
    for catalogue in CATALOGUES:
        compiled = catalogue.with_suffix(".mo")
        if compiled.exists() and compiled.stat().st_mtime >= catalogue.stat().st_mtime:
            continue
        beside = compiled.with_name(f".{compiled.name}.{os.getpid()}")
        polib.pofile(os.fspath(catalogue)).save_as_mofile(os.fspath(beside))
        beside.replace(compiled)


def main() -> int:
    """Compile the catalogues, and print their faults."""
    parser = argparse.ArgumentParser(prog="python -m tools.texts", description=__doc__)
    parser.add_argument(
        "--compile", action="store_true", help="only compile them, whatever is wrong"
    )
    parser.add_argument(
        "--update",
        action="store_true",
        help="first take new texts into them, and out what nothing says",
    )
    asked = parser.parse_args()
    faults: list[str] = []
    if not asked.compile:
        texts = find_texts()
        for catalogue in CATALOGUES:
            if asked.update:
                update(catalogue, texts)
            name = catalogue.relative_to(ROOT)
            faults += [f"{name}: {fault}" for fault in faults_of(catalogue, texts)]
    compile_all()
    print("\n".join(faults), file=sys.stderr, end="\n" if faults else "")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

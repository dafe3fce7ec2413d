"""What a line of a recording of version 2 may say: its JSON Schema, and the check of a line.

The schema is `data/score.schema.json`. Of JSON Schema (2020-12) it uses a few words, which are
looked at here, so that a message says what was got and what was expected.
"""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from paint3d.errors import RecordingError

__all__ = ["SCHEMA", "check_command", "check_header", "check_sample", "command_names", "schema"]

SCHEMA = Path(__file__).parent / "data" / "score.schema.json"

_TYPES: Mapping[str, tuple[type, ...]] = {
    "string": (str,),
    "number": (int, float),
    "integer": (int,),
    "object": (dict,),
    "array": (list,),
    "boolean": (bool,),
    "null": (type(None),),
}


@lru_cache(maxsize=1)
def schema() -> Mapping[str, Any]:
    """The schema of a line."""
    found: Mapping[str, Any] = json.loads(SCHEMA.read_text(encoding="utf-8"))
    return found


@lru_cache(maxsize=1)
def command_names() -> tuple[str, ...]:
    """What a line can ask for."""
    definitions = schema()["$defs"]
    return tuple(name for name, rule in definitions.items() if "do" in rule.get("required", ()))


def check_header(line: Mapping[str, Any]) -> None:
    """Refuse a line that is no header.

    Raises
    ------
    RecordingError
        What is what, and what was expected.
    """
    _check(line, _rule("header"), "the header")


def check_sample(line: Mapping[str, Any]) -> None:
    """Refuse a line that is no sample; see `check_header`."""
    _check(line, _rule("sample"), "a sample")


def check_command(line: Mapping[str, Any]) -> None:
    """Refuse a line that is no command; see `check_header`."""
    name, known = line.get("do"), command_names()
    if name not in known:
        near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.6)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise RecordingError(f"do is {name!r:.60}; {hint}expected one of {', '.join(known)}")
    _check(line, _rule(str(name)), str(name))


def _rule(name: str) -> Mapping[str, Any]:
    rule: Mapping[str, Any] = schema()["$defs"][name]
    return rule


def _check(value: object, rule: Mapping[str, Any] | bool, where: str) -> None:
    if isinstance(rule, bool):
        if not rule:
            raise RecordingError(f"{where} is {value!r:.60}; expected none")
        return
    if "$ref" in rule:
        rule = _rule(rule["$ref"].rpartition("/")[2])
    if "anyOf" in rule:
        _check_any(value, rule["anyOf"], where)
    if "const" in rule and (value != rule["const"] or type(value) is not type(rule["const"])):
        raise RecordingError(f"{where} is {value!r:.60}; expected {rule['const']!r}")
    if "enum" in rule and value not in rule["enum"]:
        words = " or ".join(map(repr, rule["enum"]))
        raise RecordingError(f"{where} is {value!r:.60}; expected {words}")
    if "type" in rule and not _is(value, rule["type"]):
        raise RecordingError(f"{where} is {value!r:.60}; expected {_word(rule)}")
    if isinstance(value, dict):
        _check_object(value, rule, where)
    elif isinstance(value, list):
        _check_array(value, rule, where)
    elif isinstance(value, str):
        least, most = rule.get("minLength", 0), rule.get("maxLength", math.inf)
        if not least <= len(value) <= most:
            raise RecordingError(f"{where} is {value!r:.60}; expected {least} to {most} letters")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        least, most = rule.get("minimum", -math.inf), rule.get("maximum", math.inf)
        if not least <= value <= most:
            raise RecordingError(f"{where} is {value!r:.60}; expected {least:g} to {most:g}")


def _check_any(value: object, rules: list[Mapping[str, Any]], where: str) -> None:
    """Of several rules the one that is for such a value counts."""
    own = [rule for rule in map(_followed, rules) if _is(value, rule["type"])]
    if not own:
        words = " or ".join(_word(_followed(rule)) for rule in rules)
        raise RecordingError(f"{where} is {value!r:.60}; expected {words}")
    _check(value, own[0], where)


def _followed(rule: Mapping[str, Any]) -> Mapping[str, Any]:
    return _rule(rule["$ref"].rpartition("/")[2]) if "$ref" in rule else rule


def _check_object(value: dict[str, Any], rule: Mapping[str, Any], where: str) -> None:
    own: Mapping[str, Any] = rule.get("properties", {})
    others = rule.get("additionalProperties", True)
    for key in rule.get("required", ()):
        if key not in value:
            raise RecordingError(f"{where} has no {key!r}; expected one")
    if len(value) < rule.get("minProperties", 0):
        raise RecordingError(f"{where} is empty; expected at least one entry")
    for key, item in value.items():
        if key in own:
            _check(item, own[key], f"{where}: {key}")
        elif others is False:
            known = ", ".join(k for k in own if k not in ("do", "refused")) or "nothing else"
            raise RecordingError(f"{where} has {key!r:.60}; expected {known}")
        else:
            _check(item, others, f"{where}: {key}")


def _check_array(value: list[Any], rule: Mapping[str, Any], where: str) -> None:
    least, most = rule.get("minItems", 0), rule.get("maxItems", math.inf)
    if not least <= len(value) <= most:
        wanted = f"{least}" if least == most else f"{least} to {most}"
        raise RecordingError(f"{where} has {len(value)} entries; expected {wanted}")
    for item in value:
        _check(item, rule.get("items", True), where)


def _is(value: object, kind: str) -> bool:
    if isinstance(value, bool):
        return kind == "boolean"
    if isinstance(value, float) and kind == "number":
        return math.isfinite(value)
    return isinstance(value, _TYPES[kind])


def _word(rule: Mapping[str, Any]) -> str:
    kind = rule["type"]
    if kind == "array" and rule.get("minItems") == rule.get("maxItems", math.nan):
        return f"{rule['minItems']} numbers"
    words = {
        "string": "a text", "object": "an object", "array": "a list", "null": "null",
        "boolean": "true or false", "number": "a number", "integer": "a whole number",
    }  # fmt: skip
    return words[kind]

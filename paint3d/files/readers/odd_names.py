"""Text from names that may hold anything: half of a UTF-16 pair, control characters, no UTF-8.

A file name is bytes, and Python tells those that are no UTF-8 as lone surrogates; a stranger's
session may name its material as it likes. Neither fits into most files.
"""

from __future__ import annotations

import json
import re
from typing import Any

__all__ = ["json_text", "plain_name"]

SURROGATE = re.compile("[\ud800-\udfff]")
NOWHERE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef\ufffe\uffff]")


def plain_name(text: str) -> str:
    """Return a name as every text format can hold it: what none can is marked by U+FFFD.

    Examples
    --------
    >>> plain_name("碗\\x01\\ud800") == "碗\\ufffd\\ufffd"
    True
    """
    return NOWHERE.sub("\ufffd", text)


def json_text(value: object, **options: Any) -> str:
    """Return JSON for people to read; what UTF-8 cannot hold is escaped and comes back the same.

    Parameters
    ----------
    value : object
    **options
        As `json.dumps` takes them.

    Examples
    --------
    >>> print(json_text({"碗": "\\udcff"}))
    {"碗": "\\udcff"}
    """
    text = json.dumps(value, ensure_ascii=False, **options)
    return SURROGATE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)

"""Devices as WebHID says them to a page."""

from __future__ import annotations

import warnings
from typing import Any

import hid_parser

__all__ = ["as_a_browser_has_it"]


def as_a_browser_has_it(descriptor: bytes) -> list[dict[str, Any]]:
    """The collections of WebHID, by somebody else's parser: numbers alike stand in one item."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        parsed = hid_parser.ReportDescriptor(list(descriptor))
    reports = []
    for number in parsed.input_report_ids:
        items: list[dict[str, Any]] = []
        for one in parsed.get_input_items(number):
            usage = getattr(one, "usage", None)
            item = {
                "isConstant": usage is None, "isArray": False, "isRange": False,
                "reportSize": int(one.size), "reportCount": 1,
                "logicalMinimum": getattr(one, "logical_min", 0),
                "logicalMaximum": getattr(one, "logical_max", 0),
                "usages": [] if usage is None else [int(usage.page) << 16 | int(usage.usage)],
            }  # fmt: skip
            same = [key for key in item if key not in ("reportCount", "usages")]
            if items and all(items[-1][key] == item[key] for key in same):
                items[-1]["reportCount"] += 1
                items[-1]["usages"] += item["usages"]
            else:
                items.append(item)
        reports.append({"reportId": number, "items": items})
    return [{"usagePage": 1, "usage": 8, "type": 1, "children": [], "inputReports": reports}]

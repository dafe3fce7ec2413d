"""The results of a timing study as one page of HTML: box plots, tests, answers and all trials.

Nothing is loaded from elsewhere; the plots are drawn as SVG. A box reaches from the first to the
third quartile (interpolated linearly), its line is the median, whiskers go to the last value within
1.5 times the box's height (Tukey 1977); points of one participant are joined.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from html import escape

import numpy as np

from paint3d.app.model.studies.study import Measured, StudyTable, Summary

__all__ = ["page_of"]

_WIDE, _TALL, _LEFT, _BELOW, _ABOVE = 360, 260, 52, 34, 14  # pixels
_BOX = 46
_FEW_TICKS = 5
_STYLE = """
body { font: 15px/1.5 sans-serif; color: #222; background: #fff; max-width: 60rem;
       margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse; margin: 1rem 0 } th { text-align: left }
td, th { padding: .2rem .9rem .2rem 0; border-bottom: 1px solid #ddd; vertical-align: top }
figure { display: inline-block; margin: 0 1rem 1rem 0 } figcaption { font-weight: bold }
.box { fill: #f1e0d8; stroke: #8a2f25 } .whisker, .median { stroke: #8a2f25; fill: none }
.median { stroke-width: 2.5 } .pair { stroke: #bbb; fill: none } .point { fill: #222; opacity: .75 }
.axis { stroke: #888 } text { font: 12px sans-serif; fill: #444 } .bar { fill: #8a2f25 }
"""
_SHOWN: Sequence[tuple[str, str, Callable[[Measured], float | None]]] = (
    ("Drawing time", "s", lambda m: m.seconds),
    ("Time with the pen down", "s", lambda m: m.pen_down_seconds),
    ("Strokes", "", lambda m: float(len(m.stroke_seconds))),
    ("Likeness to the copybook", "IoU", lambda m: m.likeness),
)


def page_of(table: StudyTable) -> str:
    """The page, UTF-8."""
    plan = table.plan
    title = f"{plan.character} on {plan.object}: the timing study"
    parts = [
        f"<h1>{escape(title)}</h1>",
        f"<p>{len(plan.participants)} participants, device sets {escape(', '.join(plan.devices))}, "
        f"{plan.trials} of each, {plan.em_mm:g} mm. Mean over each participant's trials.</p>",
    ]
    for name, unit, value in _SHOWN:
        by_devices = {devices: table.by_participant(devices, value) for devices in plan.devices}
        if any(by_devices.values()):
            parts.append(_figure(name, unit, by_devices))
    parts += [_summaries(table), _tests(table), _answers(table), _trials(table), _left_out(table)]
    body = "\n".join(part for part in parts if part)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head>\n<body>\n{body}\n"
        "</body></html>\n"
    )


# -- box plots ------------------------------------------------------------------------------


def _figure(name: str, unit: str, by_devices: Mapping[str, Mapping[str, float]]) -> str:
    values = [value for own in by_devices.values() for value in own.values()]
    ticks = _ticks(max(max(values), 1e-9))
    top = ticks[-1]
    low = _TALL - _BELOW

    def y(value: float) -> float:
        return low - (low - _ABOVE) * value / top

    step = (_WIDE - _LEFT) / len(by_devices)
    middles = {devices: _LEFT + step * (k + 0.5) for k, devices in enumerate(by_devices)}
    drawn = [f'<line class="axis" x1="{_LEFT}" x2="{_LEFT}" y1="{_ABOVE}" y2="{low}"/>']
    for tick in ticks:
        drawn.append(
            f'<text x="{_LEFT - 6}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>'
        )
    for devices, own in by_devices.items():
        drawn += _box(middles[devices], list(own.values()), y)
        drawn.append(
            f'<text x="{middles[devices]:.1f}" y="{_TALL - 10}" text-anchor="middle">'
            f"{escape(devices)}</text>"
        )
    drawn += _pairs(by_devices, middles, y)
    title = escape(name + (f", {unit}" if unit else ""))
    return (
        f'<figure><figcaption>{title}</figcaption><svg role="img" aria-label="{title}" '
        f'width="{_WIDE}" height="{_TALL}" viewBox="0 0 {_WIDE} {_TALL}">'
        f"{''.join(drawn)}</svg></figure>"
    )


def _ticks(most: float) -> list[float]:
    """Round numbers from 0 to no less than the most."""
    rough = most / _FEW_TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * n for n in (1.0, 2.0, 5.0, 10.0) if power * n >= rough)
    return [step * k for k in range(math.ceil(most / step - 1e-9) + 1)]


def _box(x: float, values: Sequence[float], y: Callable[[float], float]) -> list[str]:
    if not values:
        return []
    first, median, third = np.percentile(values, (25, 50, 75)).tolist()
    reach = 1.5 * (third - first)
    inside = [v for v in values if first - reach <= v <= third + reach]
    left = x - _BOX / 2
    drawn = [
        f'<path class="whisker" d="M{x:.1f} {y(end):.1f}V{y(box):.1f}"/>'
        for end, box in ((min(inside), first), (max(inside), third))
    ]
    drawn.append(
        f'<rect class="box" x="{left:.1f}" y="{y(third):.1f}" width="{_BOX}" '
        f'height="{max(y(first) - y(third), 0.5):.1f}"/>'
    )
    drawn.append(f'<path class="median" d="M{left:.1f} {y(median):.1f}h{_BOX}"/>')
    return drawn


def _pairs(
    by_devices: Mapping[str, Mapping[str, float]],
    middles: Mapping[str, float],
    y: Callable[[float], float],
) -> list[str]:
    """The points of every participant, joined."""
    names = dict.fromkeys(name for own in by_devices.values() for name in own)
    drawn = []
    for name in names:
        points = [(middles[d], y(own[name])) for d, own in by_devices.items() if name in own]
        line = " ".join(f"{x:.1f},{height:.1f}" for x, height in points)
        drawn.append(f'<polyline class="pair" points="{line}"/>')
        drawn += [
            f'<circle class="point" cx="{x:.1f}" cy="{height:.1f}" r="3">'
            f"<title>{escape(name)}</title></circle>"
            for x, height in points
        ]
    return drawn


# -- tables ---------------------------------------------------------------------------------


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{cells}</tr>{lines}</table>"


def _summaries(table: StudyTable) -> str:
    rows = []
    for devices in table.plan.devices:
        summaries = [table.summary(devices, value) for _, _, value in _SHOWN]
        rows.append([devices, str(summaries[0].n), *map(_mean_sd, summaries)])
    head = ["devices", "people", *(f"{name}{unit and ', ' + unit}" for name, unit, _ in _SHOWN)]
    return "<h2>Mean (standard deviation)</h2>" + _table(head, rows)


def _mean_sd(summary: Summary) -> str:
    return f"{_number(summary.mean, '.3g')} ({_number(summary.sd, '.2g')})" if summary.n else "-"


def _tests(table: StudyTable) -> str:
    rows = [
        [
            f"{test.second} : {test.first}", str(test.n), _number(test.ratio, ".2f"),
            _number(test.t, ".2f"), _number(test.p, ".3g"), _number(test.wilcoxon_p, ".3g"),
        ]
        for test in table.tests()
    ]  # fmt: skip
    head = ["times compared", "people", "ratio", "paired t", "p", "Wilcoxon p"]
    return "<h2>Drawing times compared within participants</h2>" + _table(head, rows)


def _answers(table: StudyTable) -> str:
    if not table.answers:
        return ""
    counts = table.preferences()
    most = max(max(counts.values()), 1)
    bars = "".join(
        f'<text x="70" y="{22 * k + 17}" text-anchor="end">{escape(name)}</text>'
        f'<rect class="bar" x="80" y="{22 * k + 4}" width="{200 * n / most:.1f}" height="16"/>'
        f'<text x="{86 + 200 * n / most:.1f}" y="{22 * k + 17}">{n}</text>'
        for k, (name, n) in enumerate(counts.items())
    )
    height = 22 * len(counts) + 8
    p = table.preference_p()
    sign_test = "" if math.isnan(p) else f"<p>Sign test, two-sided: p = {p:.3g}</p>"
    rows = [[name, answer.prefers, answer.comment] for name, answer in table.answers.items()]
    return (
        f'<h2>Which devices they prefer</h2><svg role="img" aria-label="preferences" '
        f'width="{_WIDE}" height="{height}" viewBox="0 0 {_WIDE} {height}">{bars}</svg>{sign_test}'
        + _table(["participant", "prefers", "comment"], rows)
    )


def _trials(table: StudyTable) -> str:
    rows = [
        [
            one.trial.participant, one.trial.devices, str(one.trial.number),
            f"{one.seconds:.2f}", f"{one.pen_down_seconds:.2f}", str(len(one.stroke_seconds)),
            "-" if one.likeness is None else f"{one.likeness:.3f}", one.file,
        ]
        for one in table.measured
    ]  # fmt: skip
    head = ["participant", "devices", "trial", "time s", "pen down s", "strokes", "IoU", "file"]
    return "<h2>Trials</h2>" + _table(head, rows)


def _left_out(table: StudyTable) -> str:
    lines = [f"missing: {name}" for name in table.missing]
    lines += [f"not usable: {file}: {why}" for file, why in table.faulty]
    shown = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f"<h2>Left out</h2><ul>{shown}</ul>" if lines else ""


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)

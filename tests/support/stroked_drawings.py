"""Random drawings of stroked paths whose strokes are known, and how exactly they are read.

What is true is computed here by the formulas of SVG 1.1 (chapters 8 and 9, appendix F.6), without
the package that the drawings are read with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import EM_UNITS
from paint3d.calligraphy.page.page import Page
from paint3d.calligraphy.page.svg_drawing import load_svg
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length

__all__ = ["Drawing", "Read", "draw_strokes", "drawings_table", "lines_of", "read_drawing"]

_SIDE = 1000.0
_DENSE = 200  # points of a curve
_POINTS = 64  # that lines are compared at
_APART = 0.002  # of the side: nearer lines are the same, as one that goes there and back
_ELSEWHERE = 0.005  # of the side: a stroke whose line is farther off is not that one
_SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
_KEPT = "fill:none;stroke:#000"


@dataclass
class Drawing:
    """A drawing's text, and its strokes in the order and direction in which they are drawn.

    Attributes
    ----------
    text : str
    lines : list of (N, 2) float64
        Closed ones end where they begin; a dot is one point twice. The user's unit, y downwards.
    """

    text: str = ""
    lines: list[NDArray[np.float64]] = field(default_factory=list)


@dataclass(frozen=True)
class Read:
    """Result of reading a drawing.

    Attributes
    ----------
    too_many : int
        Strokes that it has not.
    out_of_order : int
        Strokes that stand where another one should, or whose line lies elsewhere.
    turned : int
        Strokes that run backwards or begin elsewhere on their ring.
    off : float
        The farthest that a stroke's line is from the true one, shares of the drawing's side.
    strokes : int
    """

    too_many: int
    out_of_order: int
    turned: int
    off: float
    strokes: int


def draw_strokes(seed: int, n: int = 12) -> Drawing:
    """A drawing of n elements: basic shapes, paths, groups, uses, transforms, dashes, dots."""
    rng = np.random.default_rng(seed)
    drawing = Drawing()
    defined: list[str] = []
    width = rng.uniform(1.0, 8.0)
    body = []
    for k in range(n):
        kind = rng.choice(["shape", "group", "use", "hidden"], p=[0.6, 0.2, 0.15, 0.05])
        style = _style(rng)
        if kind == "shape":
            element, lines = _element(rng, style)
            turn, words = _transform(rng)
            body.append(element.replace("/>", f"{words}/>"))
        elif kind == "group":
            inner = [_element(rng, "") for _ in range(int(rng.integers(1, 4)))]
            turn, words = _transform(rng)
            body.append(f"<g{words}{style}>" + "".join(one for one, _ in inner) + "</g>")
            lines = [line for _, some in inner for line in some]
        elif kind == "use":
            inner = [_element(rng, style) for _ in range(int(rng.integers(1, 3)))]
            defined.append(f'<g id="d{k}">' + "".join(one for one, _ in inner) + "</g>")
            turn, words = _transform(rng)
            x, y = np.round(rng.uniform(-100.0, 100.0, 2), 2)
            turn = turn @ _matrix(1.0, 0.0, 0.0, 1.0, x, y)
            body.append(f'<use xlink:href="#d{k}" x="{x}" y="{y}"{words}/>')
            lines = [line for _, some in inner for line in some]
        else:
            element, lines = _element(rng, "")
            body.append(f'<g display="none">{element}</g>')
            continue
        drawing.lines += [_moved(line, turn) for line in lines]
    drawing.text = (
        f'{_SVG} viewBox="0 0 {_SIDE:g} {_SIDE:g}"><style>.s{{{_KEPT}}}</style>'
        f"<defs>{''.join(defined)}</defs>"
        f'<g class="s" fill="none" stroke="#000" stroke-width="{width:.2f}">{"".join(body)}</g>'
        "</svg>"
    )
    return drawing


def _style(rng: np.random.Generator) -> str:
    """Words that change how a line looks, but not how many there are nor where they run."""
    some = [
        "",
        ' stroke-dasharray="12 7"',
        ' stroke-dasharray="3,9,1" stroke-dashoffset="4"',
        ' stroke-linecap="round"',
        ' stroke-linejoin="bevel"',
        ' stroke="#832"',
    ]
    return str(rng.choice(some))


def _element(rng: np.random.Generator, style: str) -> tuple[str, list[AnyArray]]:
    kinds = {
        "line": _line,
        "polyline": _polyline,
        "polygon": _polygon,
        "rect": _rect,
        "circle": _circle,
        "ellipse": _ellipse,
        "path": _path,
        "dot": _dot,
    }
    share = [0.12, 0.12, 0.1, 0.06, 0.06, 0.06, 0.42, 0.06]
    words, lines = kinds[str(rng.choice(list(kinds), p=share))](rng)
    return f"<{words}{style}/>", lines


def _somewhere(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    """Points near each other, with few digits, so that what is written is what is meant."""
    middle = rng.uniform(0.1 * _SIDE, 0.9 * _SIDE, 2)
    points: NDArray[np.float64] = np.round(middle + rng.normal(0.0, 0.08 * _SIDE, (n, 2)), 2)
    return points


def _words_of(points: AnyArray) -> str:
    return " ".join(f"{x:g},{y:g}" for x, y in points)


def _line(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    a, b = _somewhere(rng, 2)
    return f'line x1="{a[0]:g}" y1="{a[1]:g}" x2="{b[0]:g}" y2="{b[1]:g}"', [np.array([a, b])]


def _polyline(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    points = _somewhere(rng, int(rng.integers(2, 7)))
    return f'polyline points="{_words_of(points)}"', [points]


def _polygon(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    points = _somewhere(rng, int(rng.integers(3, 7)))
    return f'polygon points="{_words_of(points)}"', [_closed(points)]


def _rect(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    (x, y), size = _somewhere(rng, 1)[0], np.round(rng.uniform(20.0, 160.0, 2), 2)
    w, h = size
    ring = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
    return f'rect x="{x:g}" y="{y:g}" width="{w:g}" height="{h:g}"', [_closed(ring)]


def _circle(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    (x, y), r = _somewhere(rng, 1)[0], round(float(rng.uniform(10.0, 90.0)), 2)
    return f'circle cx="{x:g}" cy="{y:g}" r="{r:g}"', [_around((x, y), (r, r))]


def _ellipse(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    (x, y), r = _somewhere(rng, 1)[0], np.round(rng.uniform(10.0, 90.0, 2), 2)
    words = f'ellipse cx="{x:g}" cy="{y:g}" rx="{r[0]:g}" ry="{r[1]:g}"'
    return words, [_around((x, y), (r[0], r[1]))]


def _dot(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    """A path without length: a dot where its cap is round or square, else nothing."""
    (x, y) = _somewhere(rng, 1)[0]
    cap = str(rng.choice(["round", "square", "butt"]))
    way = str(rng.choice([f"L{x:g} {y:g}", "h0", "z", f"C{x:g} {y:g} {x:g} {y:g} {x:g} {y:g}"]))
    lines = [] if cap == "butt" else [np.array([[x, y], [x, y]])]
    return f'path style="stroke-linecap:{cap}" d="M{x:g} {y:g}{way}"', lines


def _around(
    centre: tuple[float, float], radii: tuple[float, float], start: float = 0.0, sweep: float = 6.0
) -> NDArray[np.float64]:
    """An ellipse from an angle on, with the clock as it is seen (y downwards); whole by default."""
    whole = sweep == 6.0
    angles = start + np.linspace(0.0, math.tau if whole else sweep, 4 * _DENSE)
    return np.array(centre) + np.array(radii) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _closed(points: AnyArray) -> NDArray[np.float64]:
    return np.concatenate([points, points[:1]])


def _path(rng: np.random.Generator) -> tuple[str, list[AnyArray]]:
    """A path of up to three lines, of all commands, absolute and relative."""
    words, lines = [], []
    for _ in range(int(rng.integers(1, 4))):
        pen = _Pen(rng, _somewhere(rng, 1)[0])
        for _ in range(int(rng.integers(1, 6))):
            pen.go_on()
        if rng.random() < 0.3:
            pen.close()
        words.append(" ".join(pen.words))
        lines.append(np.concatenate(pen.points))
    return f'path d="{" ".join(words)}"', lines


class _Pen:
    """A line of a path while it is drawn: its commands, and the points that they mean."""

    def __init__(self, rng: np.random.Generator, start: AnyArray) -> None:
        self.rng, self.start, self.at = rng, start, start
        self.words = [f"M{start[0]:g} {start[1]:g}"]
        self.points: list[AnyArray] = [start[None]]
        self._cubic: AnyArray | None = None  # the control before, which S and T mirror
        self._quadratic: AnyArray | None = None

    def go_on(self) -> None:
        """Draw one more segment."""
        kind = str(self.rng.choice(list("LHVCSQTA")))
        end = np.round(self.at + self.rng.normal(0.0, 0.08 * _SIDE, 2), 2)
        controls = np.round(self.at + self.rng.normal(0.0, 0.08 * _SIDE, (2, 2)), 2)
        cubic, quadratic, self._cubic, self._quadratic = self._cubic, self._quadratic, None, None
        if kind in "HV":
            end = np.where([kind == "H", kind == "V"], end, self.at)
            value = end[0] if kind == "H" else end[1]
            self._say(kind, [value], [value - (self.at[0] if kind == "H" else self.at[1])])
            self._along([self.at, end])
        elif kind == "L":
            self._points_of(kind, [end])
            self._along([self.at, end])
        elif kind in "CS":
            first = controls[0] if kind == "C" else self._mirrored(cubic)
            self._points_of(kind, [*controls, end] if kind == "C" else [controls[1], end])
            self._along([self.at, first, controls[1], end])
            self._cubic = controls[1]
        elif kind in "QT":
            first = controls[0] if kind == "Q" else self._mirrored(quadratic)
            self._points_of(kind, [first, end] if kind == "Q" else [end])
            self._along([self.at, first, end])
            self._quadratic = first
        else:
            self._arc()
            return
        self.at = end

    def close(self) -> None:
        """Back to where it began."""
        self.words.append(str(self.rng.choice(["Z", "z"])))
        self.points.append(self.start[None])

    def _mirrored(self, control: AnyArray | None) -> AnyArray:
        return self.at if control is None else 2.0 * self.at - control

    def _points_of(self, kind: str, points: list[AnyArray]) -> None:
        self._say(kind, np.concatenate(points), np.concatenate([one - self.at for one in points]))

    def _say(self, kind: str, numbers: AnyArray, relative: AnyArray) -> None:
        small = self.rng.random() < 0.5
        said = relative if small else numbers
        self.words.append(
            (kind.lower() if small else kind) + " ".join(f"{value:.8g}" for value in said)
        )

    def _along(self, controls: list[AnyArray]) -> None:
        """A Bezier curve by Bernstein's polynomials."""
        n = len(controls) - 1
        t = np.linspace(0.0, 1.0, _DENSE)[1:, None]
        share = [math.comb(n, k) * t**k * (1.0 - t) ** (n - k) for k in range(n + 1)]
        self.points.append(sum(s * c for s, c in zip(share, controls, strict=True)))

    def _arc(self) -> None:
        """An arc from its centre, angle and sweep to its end and flags (F.6)."""
        radii = self.rng.uniform(20.0, 120.0, 2)
        lean, start = self.rng.uniform(0.0, math.pi), self.rng.uniform(0.0, math.tau)
        sweep = self.rng.uniform(0.4, 5.8) * self.rng.choice([-1.0, 1.0])
        angles = start + np.linspace(0.0, sweep, 4 * _DENSE)
        round_ = radii * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        turn = np.array([[math.cos(lean), math.sin(lean)], [-math.sin(lean), math.cos(lean)]])
        arc = self.at + (round_ - round_[0]) @ turn
        flags = f"{int(abs(sweep) > math.pi)} {int(sweep > 0.0)}"
        end = " ".join(f"{value:.10g}" for value in arc[-1])
        self.words.append(
            f"A{radii[0]:.10g} {radii[1]:.10g} {math.degrees(lean):.10g} {flags} {end}"
        )
        self.points.append(arc[1:])
        self.at = arc[-1]


def _matrix(a: float, b: float, c: float, d: float, e: float, f: float) -> NDArray[np.float64]:
    return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])


def _transform(rng: np.random.Generator) -> tuple[NDArray[np.float64], str]:
    """A list of up to two transforms, and their product: the last is the first that is done."""
    turn, words = np.eye(3), []
    for _ in range(int(rng.integers(0, 3))):
        kind = str(rng.choice(["translate", "rotate", "scale", "skewX", "matrix", "about"]))
        x, y = np.round(rng.uniform(-80.0, 80.0, 2), 2)
        angle = round(float(rng.uniform(-60.0, 60.0)), 2)
        cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        spin = _matrix(cos, sin, -sin, cos, 0.0, 0.0)
        if kind == "translate":
            one, said = _matrix(1.0, 0.0, 0.0, 1.0, x, y), f"translate({x:g},{y:g})"
        elif kind == "rotate":
            one, said = spin, f"rotate({angle:g})"
        elif kind == "about":
            there = _matrix(1.0, 0.0, 0.0, 1.0, x, y)
            one = there @ spin @ np.linalg.inv(there)
            said = f"rotate({angle:g} {x:g} {y:g})"
        elif kind == "scale":
            p, q = np.round(rng.uniform(0.6, 1.6, 2) * rng.choice([-1.0, 1.0], 2), 3)
            one, said = _matrix(p, 0.0, 0.0, q, 0.0, 0.0), f"scale({p:g} {q:g})"
        elif kind == "skewX":
            tan = math.tan(math.radians(0.5 * angle))
            one, said = _matrix(1.0, 0.0, tan, 1.0, 0.0, 0.0), f"skewX({0.5 * angle:g})"
        else:
            numbers = np.round([cos, sin, -0.7 * sin, 0.7 * cos, x, y], 4)
            one, said = _matrix(*numbers), "matrix(" + " ".join(f"{v:g}" for v in numbers) + ")"
        turn = turn @ one
        words.append(said)
    return turn, f' transform="{" ".join(words)}"' if words else ""


def _moved(line: AnyArray, turn: AnyArray) -> NDArray[np.float64]:
    moved: NDArray[np.float64] = line @ turn[:2, :2].T + turn[:2, 2]
    return moved


def lines_of(page: Page) -> list[NDArray[np.float64]]:
    """The strokes of a page in the order in which they are written, where they lie on it."""
    return [
        stroke.median - np.array(piece.glyph.middle) + np.array(piece.at)
        for piece in page.pieces
        for stroke in piece.glyph.strokes
    ]


def read_drawing(drawing: Drawing) -> Read:
    """Read a drawing as `paint3d write --svg` does, and compare its strokes with what they are."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "drawing.svg"
        file.write_text(drawing.text, encoding="utf-8")
        found = lines_of(load_svg(file))
    wanted = _on_the_page(drawing.lines, found)
    n = min(len(wanted), len(found))
    away = np.array([[_off(line, true) for true in wanted] for line in found])
    order = away.min(axis=2).argmin(axis=1)[:n]
    there = away.min(axis=2).min(axis=1) < _ELSEWHERE * EM_UNITS
    right = [(k, int(j)) for k, j in enumerate(order) if j == k and there[k]]
    turned = sum(away[k, j, 0] > max(away[k, j, 1], _APART * EM_UNITS) for k, j in right)
    off = max((float(away[k, j].min()) for k, j in right), default=0.0)
    return Read(len(found) - len(wanted), n - len(right), int(turned), off / EM_UNITS, len(wanted))


def _on_the_page(lines: list[AnyArray], found: list[AnyArray]) -> list[NDArray[np.float64]]:
    """True lines in the page's frame: its scale and place are those that fit all strokes best.

    A page leaves room for widths and caps, so where the lines lie on it is not told by them alone.
    """
    flipped = [line * np.array([1.0, -1.0]) for line in lines]
    ours, theirs = (
        np.array([np.concatenate(some).min(axis=0), np.concatenate(some).max(axis=0)])
        for some in (flipped, found)
    )
    scale = float(np.ptp(theirs, axis=0).max() / np.ptp(ours, axis=0).max())
    return [scale * (line - ours.mean(axis=0)) + theirs.mean(axis=0) for line in flipped]


def _off(line: AnyArray, true: AnyArray) -> tuple[float, float]:
    """Measure the greatest distance of a stroke from a true one, along it and against it.

    What closes is led over its beginning, and counts as far as the true one goes.
    """
    if line_length(true) == 0.0:
        away = float(np.linalg.norm(line.mean(axis=0) - true[0]))
        return away, away
    wanted = _evenly(true, line_length(true))
    ways = [line, line[::-1]]
    if np.array_equal(true[0], true[-1]):
        ways = [ways[0], line[: _closes(line)][::-1]]
    both = [
        float(np.linalg.norm(_evenly(way, line_length(true)) - wanted, axis=1).max())
        for way in ways
    ]
    return both[0], both[1]


def _closes(line: AnyArray) -> int:
    """Up to where a line goes that is led over its own beginning."""
    again = np.flatnonzero((np.abs(line[1:] - line[0]) < 1e-9).all(axis=1))
    return int(again[-1]) + 2 if len(again) else len(line)


def _evenly(line: AnyArray, length: float) -> NDArray[np.float64]:
    """Points at even stations along a line, up to a length."""
    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    at = np.linspace(0.0, length, _POINTS)
    return np.stack([np.interp(at, way, line[:, k]) for k in range(2)], axis=1)


def drawings_table(n: int, seed: int) -> str:
    """Read n drawings; how exact their strokes are, as Markdown."""
    rows = [read_drawing(draw_strokes(k)) for k in range(seed, seed + n)]
    lines = [
        f"{n} drawings of {sum(row.strokes for row in rows)} strokes, seeds {seed} to "
        f"{seed + n - 1}",
        "",
        "| | strokes | drawings without a fault |",
        "|---|---|---|",
    ]
    for name, values in {
        "too many or too few": [abs(row.too_many) for row in rows],
        "out of order, or elsewhere": [row.out_of_order for row in rows],
        "turned round": [row.turned for row in rows],
    }.items():
        lines.append(f"| {name} | {sum(values)} | {sum(v == 0 for v in values)} |")
    lines.append(f"\nlines off by {100.0 * max(row.off for row in rows):.4f} % of the side at most")
    wrong = [
        k for k, row in enumerate(rows, seed) if row.too_many or row.out_of_order or row.turned
    ]
    return "\n".join(lines + ([f"wrong: {wrong}"] if wrong else []))

"""Writer of a painting as one HTML file, which shows it, how it grew, and lets one continue it.

The page is that of `build_page`, with every file that it would load packed into it. It paints what
it shows by the painting's score, so a painting can be exported only if a page plays its score to
the bit: `page_score` raises for those that it cannot.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from paint3d.app.model.persistence.saved_settings import (
    DEFAULT_BRUSH,
    PURE_INKS,
    saved_brush,
    saved_mixture,
)
from paint3d.app.model.score.codecs import InkTable, make_header
from paint3d.app.model.score.playing import begun, play
from paint3d.app.model.seal_press import PASTE
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush.spec import DipAmount
from paint3d.colour.inks import load_ink
from paint3d.colour.pigments import load_pigment
from paint3d.colour.spectra import N_BANDS
from paint3d.core.atomic import write_atomically
from paint3d.device.recorded import Recording
from paint3d.device.sample import ERASER
from paint3d.errors import ExportError, InputError
from paint3d.files.progress import Progress, part_of
from paint3d.files.project.session import Session
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.page.folder import BUILT, INKS, KERNELS, PageObject, build_page, check_grains
from paint3d.painter.ink_time import INK_STEP_S
from paint3d.recording.score import Event, Score, write_score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["bare_score", "page_score", "page_text", "write_single_file"]

MOST_TRIANGLES = 500_000
"""Limit of an object that a page has memory for, also of one that a user opens in it."""
MOST_STEPS, MOST_BYTES = 30, 1 << 28
"""Undo steps that a page keeps, and their bytes; the last one is kept in any case."""
_SCORE = "painting.score.jsonl"
_HEAD = {"format": "paint3d-recording", "version": 2}
_PLAYED: Mapping[str, Sequence[str]] = json.loads(
    Path(__file__).with_name("played.json").read_text("utf-8")
)
"""Commands that a page plays (`Document.repeat`, web/src/page/document.ts), and their arguments."""
_NO_STEPS = {"end_stroke", "set_brush", "dip", "follow_time", "select_layer", "set_visible",
             "rename_layer"}  # fmt: skip
"""Commands among these that are no undo steps."""
_N_SPECTRA = 4
"""Spectra kept of dried paint: as it lies, and over three grounds."""
_IGNORED = {"time_s"}
"""Arguments without effect on what is painted."""


def page_score(session: Session, progress: Progress | None = None) -> Score:
    """Return the score by which a page paints the painting to the bit; it is played to see.

    Parameters
    ----------
    session : Session
    progress : callable, optional
        Called with the fraction done; what it raises stops it.

    Raises
    ------
    InputError
        Why a page cannot paint it.
    """
    surface = session.surface
    _check_object(surface)
    score = session.score if session.score is not None else _of_recordings(session)
    played = _as_played(score, surface)
    again = _play(played, surface.source, progress)
    if again.n_vertices != surface.n_vertices or not np.array_equal(again.srgb, surface.srgb):
        raise InputError("its recording gives another painting")
    return played


def bare_score(surface: PaintedSurface, brush: str, ink: str) -> Score:
    """Return the score of a bare surface, without events.

    Raises
    ------
    InputError, UnknownNameError
        If it is painted, or a page cannot paint on it with this brush and ink.
    """
    if surface.painted.any():
        raise InputError(
            "it is not recorded how this surface was painted; expected a bare one, or a session"
        )
    _check_object(surface)
    header = make_header(surface, load_brush(brush), load_ink(ink), InkTable({}))
    return _as_played(Score({**_HEAD, **header}, ()), surface)


def _check_object(surface: PaintedSurface) -> None:
    """Refuse objects that a page cannot paint on.

    Raises
    ------
    InputError
        With the reason.
    """
    n = len(surface.source.faces)
    if n > MOST_TRIANGLES:
        raise InputError(
            "its object has {n:,} triangles; a page takes {most:,} at most",
            n=n,
            most=MOST_TRIANGLES,
        )
    if surface.original is not None:
        raise InputError("its object was remeshed after it was first painted")
    if surface.resolution is None:
        raise InputError("its object is painted without a resolution; expected one")


def _play(score: Score, mesh: TriangleMesh, progress: Progress | None) -> PaintedSurface:
    """Play a page's score; InputError if it undoes more than a page has memory for."""
    document, steps = begun(score, mesh), _Steps()
    size = _bytes_of(document.surface)
    for step in play(document, score):
        if step.command:
            steps.follow(step.command, size)
        size = _bytes_of(document.surface)
        if progress is not None:
            progress(step.fraction)
    if document.in_stroke:
        document.end_stroke()
    return document.surface


class _Steps:
    """Undo steps that a page would keep, by their bytes (web/src/page/document.ts)."""

    def __init__(self) -> None:
        self._done: list[int] = []
        self._undone: list[int] = []

    def follow(self, command: str, size: int = 0) -> None:
        """Follow a command before which the painting has this size, bytes.

        Raises
        ------
        InputError
            If it undoes or redoes a step that a page does not keep.
        """
        if command in ("undo", "redo"):
            stacks = [self._done, self._undone]
            source, target = stacks if command == "undo" else reversed(stacks)
            if not source:
                raise InputError(
                    "it undoes more than the {most} steps, {mib} MiB together, that a page keeps",
                    most=MOST_STEPS,
                    mib=MOST_BYTES >> 20,
                )
            target.append(source.pop())
        elif command not in _NO_STEPS:
            self._undone = []
            self._done.append(size)
            while len(self._done) > 1 and (
                len(self._done) > MOST_STEPS or sum(self._done) > MOST_BYTES
            ):
                del self._done[0]


def _bytes_of(surface: PaintedSurface) -> int:
    """Bound the bytes that a page stores of a painting for a step (`PaintedSurface.keep` there)."""
    n_pigments, dried = len(surface.pigments), surface.dry_layers.count
    size = 4 * surface.n_vertices * (n_pigments + 1)
    size += dried * (4 * n_pigments + 8 + _N_SPECTRA * 2 * N_BANDS)
    if len(surface.open_blocks()):
        graph = surface.flow_graph
        size += graph.n_nodes * (24 * n_pigments + 16) + graph.n_places * 4 * n_pigments
        size += 8 * graph.n_blocks + 4 * surface.n_vertices
    return size


def _of_recordings(session: Session) -> Score:
    """Make the score of a painting by recordings, each a stroke, and of what followed.

    Raises
    ------
    InputError
        If the session does not record what it was painted with, or what was done to it since.
    """
    surface, later = session.surface, session.later
    settings = session.settings if later is None else later.header
    if not session.recordings or not {"brush", "ink"} <= set(settings):
        raise InputError("it is not recorded how it was painted")
    steps = session.history or {}
    if later is None and (session.strokes or steps.get("done") or steps.get("undone")):
        raise InputError("what was done to it after it was painted whole is not recorded")
    dips = settings.get("dips")
    if isinstance(dips, list) and len(dips) > 1:
        raise InputError("its brush had another ink at the tip, which a page does not dip it in")
    inks = InkTable({}, own_tables=False)
    ink: object = settings["ink"]
    dipped = settings.get("dipped", {ink: 1.0} if isinstance(ink, str) else ink)
    brush = saved_brush(settings["brush"])
    header = make_header(surface, brush, saved_mixture(dipped, surface), inks)
    header["azimuth"] = settings.get("azimuth", "commanded")
    header["pickup"] = settings.get("pickup", float(surface.ink.transfer["pickup"].item()))
    own = {**inks.table, **(later.header.get("pigments", {}) if later is not None else {})}
    if own:
        header["pigments"] = own
    amount = DipAmount.of(settings.get("amount", {}))
    events: list[Event] = []
    if amount != DipAmount():
        events.append({"do": "dip", "amount": amount.words()})
    for recording in session.recordings:
        events += [{"do": "begin_stroke"}, recording, {"do": "end_stroke"}]
    return Score({**_HEAD, **header}, (*events, *(later.events if later is not None else ())))


def _as_played(score: Score, surface: PaintedSurface) -> Score:
    """Convert a score to the commands and arguments that a page plays.

    Raises
    ------
    InputError
        If it has others.
    """
    given = score.header
    if given.get("pigments"):
        raise InputError("it has inks of somebody's own")
    brush, ink = given.get("brush", DEFAULT_BRUSH), _parts(given.get("ink", PURE_INKS[0]))
    own = make_header(surface, load_brush(DEFAULT_BRUSH), {}, InkTable({}))
    if brush not in brush_names() or {"length_mm", "hairs"} & set(given):
        raise InputError("its brush is none of the presets")
    if not isinstance(own["material"], str):
        raise InputError("its material is one of somebody's own")
    header = {name: own[name] for name in ("object", "mesh", "resolution_mm", "material")}
    header |= {"brush": brush, "ink": ink, "azimuth": given.get("azimuth", "commanded")}
    if given.get("pickup"):
        header["pickup"] = given["pickup"]
    units = {"position": "mm", "time": "ns", "force": "N"}
    events = tuple(_events(score.events, header))
    return Score({**_HEAD, **header, "space": "world", "units": units}, events)


def _parts(ink: str | Mapping[str, float]) -> dict[str, float]:
    """Resolve an ink to its parts by the names of its pigments."""
    parts = load_ink(ink if isinstance(ink, str) else _ink_text(ink), own_tables=False)
    check_grains(parts)
    return {pigment.name: part for pigment, part in parts.items()}


def _ink_text(parts: Mapping[str, float]) -> str:
    """Format parts as `load_ink` takes them."""
    return ",".join(f"{name}:{part!r}" for name, part in parts.items())


def _events(events: Sequence[Event], header: Mapping[str, Any]) -> Iterator[Event]:
    """Yield the events in a page's words; InputError for one that a page does not play."""
    ink: Mapping[str, float] = header["ink"]
    unchanged = {"set_azimuth": {"azimuth": header["azimuth"]},
            "set_pickup": {"pickup": header.get("pickup", 0.0)}}  # fmt: skip
    steps = _Steps()
    for event in events:
        if isinstance(event, Recording):
            if {"loads", "strengths"} & set(event.header) or (event.buttons & ERASER).any():
                raise InputError("a stroke changes its load, or erases by the pen's other end")
            yield event
            continue
        name = str(event["do"])
        if event.get("refused") or name == "set_tags":
            continue
        line = {key: value for key, value in event.items() if key not in _IGNORED}
        if name == "add_layer" and isinstance(line.get("place"), int) and "name" in line:
            place, layer = line.pop("place"), line.pop("name")
            steps.follow(name)
            yield line
            line = {"do": "rename_layer", "place": place, "name": layer}
            name = "rename_layer"
        if name == "set_symmetry" and set(line) == {"do"}:
            continue  # no symmetry
        if name in unchanged and line == {"do": name, **unchanged[name]}:
            continue
        others = sorted(set(line) - {"do", *_PLAYED.get(name, ())})
        if name not in _PLAYED or others:
            what = name if name not in _PLAYED else f"{name} with {others[0]}"
            raise InputError("its recording has {what}, which a page does not play", what=what)
        if name == "follow_time" and line["seconds"] != INK_STEP_S:
            raise InputError(
                "its ink flows in steps of {seconds:g} s; in a page these are {expected:g} s",
                seconds=line["seconds"],
                expected=INK_STEP_S,
            )
        if name == "set_brush" and line["brush"] not in brush_names():
            raise InputError("one of its brushes is none of the presets")
        if name == "lay_text" and line["text"].get("font"):
            raise InputError("a text on it is in a font; expected characters of the page")
        if name in ("dip", "press_seal"):
            line["ink"] = _parts(line.get("ink", ink if name == "dip" else PASTE))
            ink = line["ink"] if name == "dip" else ink
        steps.follow(name)
        yield line


def write_single_file(
    session: Session,
    score: Score,
    path: Path,
    progress: Progress | None = None,
    *,
    title: str = "",
    page: Path = BUILT,
    kernels: Path = KERNELS,
) -> None:
    """Write a painting, and the studio to continue it, as one HTML file.

    The file loads nothing from any host; its content policy forbids it.

    Parameters
    ----------
    session : Session
    score : Score
        From `page_score`.
    path : Path
    progress : callable, optional
        Called with the fraction done; what it raises leaves everything as it was.
    title : str
        Of the page; by default the file's name.
    page, kernels : Path
        As for `build_page`.

    Raises
    ------
    ExportError
        If the page or its kernels are not built, or the file cannot be written.
    """
    text = page_text(
        session.surface, score, title or path.stem, part_of(progress, 0.0, 0.9), page=page,
        kernels=kernels,
    )  # fmt: skip
    with write_atomically(path, progress) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def page_text(
    surface: PaintedSurface,
    score: Score,
    title: str,
    progress: Progress | None = None,
    *,
    brushes: Sequence[str] = (),
    inks: Sequence[str] = (),
    is_hosted: bool = False,
    page: Path = BUILT,
    kernels: Path = KERNELS,
) -> str:
    """Make the HTML of a painting and the studio to continue it.

    Parameters
    ----------
    surface, score, title, progress, page, kernels
        As for `write_single_file`.
    brushes, inks : sequence of str
        To continue with, besides those in the score.
    is_hosted : bool
        Whether the program that shows it in a frame stores the painting, not the browser.

    Raises
    ------
    ExportError
        If the page or its kernels are not built.
    """
    used_brushes, used_inks = [str(score.header["brush"])], [score.header["ink"]]
    for event in score.events:
        if not isinstance(event, Recording):
            used_brushes += [event["brush"]] if event["do"] == "set_brush" else []
            used_inks += [event["ink"]] if "ink" in event else []
    one = PageObject(surface.source.name, float(surface.resolution or 0.0), surface.source)
    all_brushes = list(dict.fromkeys([*used_brushes, *brushes]))
    all_inks = list(dict.fromkeys([*_named_inks(used_inks), *inks]))
    with TemporaryDirectory() as folder:
        built = Path(folder)
        build_page(
            built, [one], all_brushes, all_inks, progress or (lambda fraction: None),
            materials=[surface.material.name], page=page, kernels=kernels,
        )  # fmt: skip
        text = "".join(write_score(score))
        digest = hashlib.sha256(text.encode()).hexdigest()
        contents = json.loads((built / "contents.json").read_text("utf-8"))
        if score.events:
            contents["painting"] = {"title": title, "id": digest[:16]}
            (built / _SCORE).write_text(text, "utf-8")
        if is_hosted:
            contents["hosted"] = True
        for ink in contents["inks"]:
            if ":" in ink["name"]:  # a mixture without a name of its own
                parts = [
                    (load_pigment(name), f"{100.0 * part:.3g} %")
                    for name, part in ink["parts"].items()
                ]
                ink["name"] = ", ".join(f"{one.name} {percent}" for one, percent in parts)
                ink["chinese"] = "、".join(f"{one.chinese} {percent}" for one, percent in parts)
        (built / "contents.json").write_text(json.dumps(contents, ensure_ascii=False), "utf-8")
        return _join_files(built, title)


def _named_inks(used: Sequence[Mapping[str, float]]) -> list[str]:
    """List the names of the inks used, and of the page's usual ones of the same pigments."""
    usual = {name: _parts(name) for name in INKS}
    names = []
    for parts in used:
        same = [name for name, of in usual.items() if list(of.items()) == list(parts.items())]
        names += same[:1] or [_ink_text(parts)]
    pigments = {pigment for parts in used for pigment in parts}
    return list(
        dict.fromkeys([*names, *(n for n, of in usual.items() if set(of) <= pigments | {"water"})])
    )


def _join_files(built: Path, title: str) -> str:
    """Join a built page and all that it loads into one HTML text.

    Raises
    ------
    ExportError
        If the page is not as web/ builds it.
    """
    page = (built / "index.html").read_text("utf-8")
    scripts, styles = ([*(built / "assets").glob(f"index-*.{kind}")] for kind in ("js", "css"))
    if len(scripts) != 1 or len(styles) != 1:
        raise _not_one_file("index-*.js, index-*.css")
    script, style = scripts[0], styles[0]
    code = re.sub(r"</(?=script)", r"<\\/", script.read_text("utf-8"), flags=re.IGNORECASE)
    if "<!--" in code:  # HTML would begin a comment there
        raise _not_one_file("<!--")
    look = style.read_text("utf-8")
    blocks = []
    for file in sorted(built.rglob("*")):
        if file.is_dir() or file in (script, style) or file.name == "index.html":
            continue
        is_asset = file.parent.name == "assets"
        name = file.name if is_asset else file.relative_to(built).as_posix()
        data = file.read_bytes()
        packed = data if file.suffix == ".gz" else gzip.compress(data, 9, mtime=0)
        blocks.append(
            f'<script type="application/gzip" id="file:{html.escape(name)}">'
            f"{base64.b64encode(packed).decode('ascii')}</script>\n"
        )
    policy = (
        f"default-src 'none'; script-src 'sha256-{_digest(code)}' 'wasm-unsafe-eval'; "
        f"style-src 'sha256-{_digest(look)}'; worker-src blob:; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    for pattern, by in (
        (r'(?<=http-equiv="Content-Security-Policy")(\s+content=")[^"]*', rf"\g<1>{policy}"),
        (r"<script type=\"module\"[^>]*></script>\s*", ""),
        (r"<link rel=\"stylesheet\"[^>]*>", lambda _: f"<style>{look}</style>"),
        (r"<title>[^<]*", lambda _: f"<title>{html.escape(title)}"),
        (
            r'(?<=<div id="message" role="status">)[^<]*',
            "The painting is being loaded. 正在载入画作。",
        ),
        (r"(?=</body>)", lambda _: f'{"".join(blocks)}<script type="module">{code}</script>\n'),
    ):
        page, n = re.subn(pattern, by, page, count=1)
        if n != 1:
            raise _not_one_file(pattern)
    return page


def _not_one_file(what: str) -> ExportError:
    return ExportError(
        "the built page cannot be made one file, by {what}; expected it as web/ builds it",
        what=what,
        hint="npm run build, in web/",
    )


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")

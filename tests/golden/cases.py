"""Paintings whose bytes may not change while the code is only moved or renamed.

Every case paints something and gives its outcome as named bytes. Together they pass through the
demo, planned text on the bowl and the vase, single hairs, wet ink, layers, every format that is
exported, and a session.
"""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Callable, Iterator
from operator import attrgetter
from pathlib import Path

import numpy as np

from paint3d.app.model.document import Document
from paint3d.cli.main import main
from paint3d.files.export import EXPORT_SUFFIXES
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import line, small_plane

__all__ = ["CASES", "outcome"]

Outcome = Iterator[tuple[str, bytes]]
_PICTURES = {".png", ".html"}  # drawn by a renderer, or holding what is
_OTHERS = {
    ".p3d",
    ".usdz",
}  # a session has a time in it; USDZ's bytes are those of a version of usd-core


def _run(*words: object) -> None:
    with contextlib.redirect_stdout(io.StringIO()):
        status = main([*map(str, words), "--quiet"])
    assert status == 0, words


def _surface(surface: PaintedSurface) -> Outcome:
    """What is on a surface, and where."""
    surface.refresh()
    for name in ("mesh.vertices", "mesh.faces", "amounts", "coverage", "srgb"):
        yield name, np.ascontiguousarray(attrgetter(name)(surface)).tobytes()


def _session(path: Path) -> Outcome:
    """The members of a session's archive; its own bytes hold when it was written."""
    with zipfile.ZipFile(path) as archive:
        for name in sorted(archive.namelist()):
            yield name, archive.read(name)


def _exports(session: Path, suffixes: tuple[str, ...]) -> Outcome:
    for suffix in suffixes:
        target = session.with_name(f"{session.stem}-out{suffix}")
        _run("export", session, target)
        if suffix == ".3mf":
            yield from ((f"3mf {name}", data) for name, data in _session(target))
        else:
            yield suffix, target.read_bytes()


def demo(folder: Path) -> Outcome:
    """The demo's characters on the bowl, in the formats it writes."""
    _run("demo", "--out", folder, "--no-view")
    for suffix in (".ply", ".glb", ".p3d.txt"):
        yield suffix, (folder / f"bowl{suffix}").read_bytes()


def _written(folder: Path, on: str, *options: object) -> Outcome:
    target = folder / "written.p3d"
    _run("write", "永", "--on", on, "--size", 24, "--out", target, *options)
    yield from _exports(target, (".ply",))


def bowl(folder: Path) -> Outcome:
    """A character that is planned for the bowl, and every format it can be exported in."""
    target = folder / "written.p3d"
    _run("write", "永", "--on", "bowl", "--size", 24, "--out", target)
    yield from _exports(target, tuple(s for s in EXPORT_SUFFIXES if s not in _PICTURES | _OTHERS))


def vase(folder: Path) -> Outcome:
    """A character on the vase."""
    yield from _written(folder, "vase")


def hairs(folder: Path) -> Outcome:
    """A character by a tuft of single hairs."""
    yield from _written(folder, "bowl", "--hairs", 200)


def wet(folder: Path) -> Outcome:
    """A character in ink that spreads and dries while it is written, and after."""
    recording, target = folder / "strokes.jsonl", folder / "wet.p3d"
    _run("write", "永", "--on", "plane", "--size", 24, "--out", target, "--recording", recording)
    _run("replay", recording, "--on", "plane", "--material", "xuan", "--spread", 3, "--out", target)
    yield from _exports(target, (".ply",))


def _layered() -> Document:
    """Two layers, three inks, a tip that is dipped, hairs, undo, wet ink that is left to flow."""
    document = small_plane(0.8)
    for k, (ink, start, end) in enumerate(
        (("pine soot", (-20, 0), (20, 3)), ("cinnabar", (0, -20), (2, 20)))
    ):
        document.dip(ink)
        document.begin_stroke()
        document.feed(line(start, end, n=60, t0=1 + k * 10_000_000_000))
        document.end_stroke()
        document.let_time_pass(0.4)
        document.add_layer()
    document.dip({"pine soot": 0.2, "water": 0.8})
    document.dip("pine soot", reach=0.4)
    for k in range(3):
        document.begin_stroke()
        document.feed(line((-20, 6 * k), (20, 5 * k - 12), n=40, t0=(30 + 10 * k) * 1_000_000_000))
        document.end_stroke()
    document.undo()
    document.let_time_pass(0.7)
    document.dry()
    document.select_layer(0)
    document.set_brush("feibai")
    document.begin_stroke()
    document.feed(line((-18, -14), (18, -10), n=50, pressure=0.6, t0=90_000_000_000))
    document.end_stroke()
    return document


def layers(folder: Path) -> Outcome:
    """A sitting with layers and wet ink; what is saved of it, opened and saved again."""
    document = _layered()
    yield from _surface(document.surface)
    first = folder / "layers.p3d"
    document.save(first)
    opened = Document.open(first)
    yield from ((f"opened {name}", data) for name, data in _surface(opened.surface))
    yield from _exports(first, (".ply", ".glb"))


CASES: dict[str, Callable[[Path], Outcome]] = {
    case.__name__: case for case in (demo, bowl, vase, hairs, wet, layers)
}


def outcome(name: str, folder: Path) -> dict[str, bytes]:
    """All that a case gives, by name."""
    return dict(CASES[name](folder))

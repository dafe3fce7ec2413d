"""Seals, letters that are known, and films of what is painted, to be fuzzed."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np

from scripts.fuzz.drawings import DRAWINGS
from scripts.fuzz.mutation import NUMBERS, damage
from scripts.fuzz.target import Target, file_of

__all__ = ["LETTERING"]

_SIDE = 24.0  # mm, of the sheet that is pressed on
_MOST_PICTURES = 3

# -- seals ----------------------------------------------------------------------------------------


def _pressed(seal, **how: float) -> None:
    """Press a seal on a small sheet."""
    from paint3d.app.model.document import Document
    from paint3d.mesh.triangle_mesh import TriangleMesh

    half = 0.5 * max(seal.width_mm, seal.height_mm)
    for ring in seal.rings:
        assert np.isfinite(ring).all()
        assert np.abs(ring).max() <= half + 1e-6
    corners = _SIDE * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    sheet = TriangleMesh(corners, [(0, 1, 2), (0, 2, 3)], name="plane")
    document = Document.new(sheet, 4.0)
    touched = document.press_seal(seal.rings, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), **how)
    assert 0.0 <= touched <= 1.0 + 1e-6
    assert np.isfinite(document.surface.amounts).all()


def _check_drawn_seal(suffix: str, content: bytes) -> None:
    """Cut a drawing into a stone, one way or the other, and press it."""
    from paint3d.calligraphy.seal.stone import STYLES, cut_seal

    style = STYLES[len(content) % 2]
    _pressed(cut_seal(drawing=file_of(suffix, content), style=style))


def _seal_seeds() -> list[tuple[str, bytes]]:
    lines = (
        "seal 永 --on bowl --out o.ply --size 9 --coats 1 --wear .5 --seed 3 --rotate 5 --at 0,1",
        "seal 永和九年 --style baiwen --on plane --out o.glb --pad 2 --size 24 --wear 3",
        "seal 一 --style zhuwen --on plane --out o.ply --size 4 --coats 10 --ink indigo --wear 0",
        "seal 之印三 --on plane --out o.ply --size 30 --seed 1000000",
    )
    return [("", line.replace(" ", "\n").encode()) for line in lines]


def _damage_words(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Mostly one word that is no option's name: of others little is left to be read."""
    words = data.split(b"\n")
    if chance.random() < 0.2:
        return damage(data, chance, others)
    k = chance.choice([k for k, word in enumerate(words) if k and not word.startswith(b"--")])
    way = chance.random()
    if way < 0.4:
        words[k] = chance.choice(NUMBERS)
    elif way < 0.6:
        words[k] = chance.choice(words)
    else:
        words[k] = damage(words[k], chance, words)
    return b"\n".join(words)


def _check_seal(_: str, content: bytes) -> None:
    """Cut and press what a command line asks for."""
    from paint3d.calligraphy.seal.stone import cut_seal

    asked = _parsed(content)
    if asked is None or asked.command != "seal":
        return
    seal = cut_seal(asked.text, asked.svg, asked.style, asked.size, font=asked.font)
    names = {"coats": "coats", "pad": "pad_mm", "wear": "wear", "seed": "seed"}
    given = {said: getattr(asked, name) for name, said in names.items()}
    _pressed(seal, **{said: value for said, value in given.items() if value is not None})


def _parsed(content: bytes):
    """The options of a command line; None where it asks for help."""
    from paint3d.cli.main import make_parser
    from paint3d.cli.options import UsageError
    from paint3d.errors import InputError

    words = content.decode("utf-8", "surrogateescape").split("\n")
    if {"-h", "--help", "--version"} & set(words):
        return None
    try:
        return make_parser(*words[:1]).parse_args(words)
    except UsageError as cause:
        raise InputError(" ".join(str(cause).split())) from None


# -- letters --------------------------------------------------------------------------------------

_LETTERS = ("Aaβж3", "bfkrz", "بت", "سلام", "ﻻ永", "かガ한q", "éß")


def _letter_seeds() -> list[tuple[str, bytes]]:
    return [(".txt", text.encode()) for text in _LETTERS]


def _damage_letters(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    """Other letters of the tables' blocks, too, that bytes would hardly ever hit."""
    if chance.random() < 0.3:
        return damage(data, chance, others)
    blocks = ((0x20, 0x180), (0x370, 0x530), (0x600, 0x700), (0x900, 0x980), (0x3040, 0x3100))
    text = list(data.decode("utf-8", "replace"))
    for _ in range(chance.choice((1, 1, 2, 4))):
        text.insert(chance.randrange(len(text) + 1), chr(chance.randrange(*chance.choice(blocks))))
    return "".join(text[-6:]).encode()


def _check_letters(_: str, content: bytes) -> None:
    """Look every letter up, and take the ink of one apart by the strokes of the next."""
    from shapely import LineString, MultiPolygon, get_parts, union_all

    from paint3d.calligraphy.glyph_sources import open_glyphs
    from paint3d.calligraphy.shapes.decompose import decompose
    from paint3d.calligraphy.shapes.ductus import PlacedLetter, body_strokes, form_of, known_strokes

    text, source = content.decode("utf-8", "replace")[:6], open_glyphs(None)
    known = [forms for letter in text if (forms := known_strokes(source, letter))]
    around = ["", *text, ""]
    body = body_strokes(
        [
            PlacedLetter(letter, form_of(around[k], letter, around[k + 2]), np.array([-k, 0, 1, 1]))
            for k, letter in enumerate(text)
        ]
    )
    for forms in [*known, *([(body,)] if body else [])]:
        lines = [stroke.median for form in forms for stroke in form.strokes]
        assert lines
        assert all(np.isfinite(line).all() and len(line) > 1 for line in lines)
    if not known or len(content) % 8:  # it costs a second
        return
    lines = [stroke.median for stroke in known[0][0].strokes]
    size = float(np.ptp(np.concatenate(lines), axis=0).max()) or 1.0
    ink = union_all([LineString(100.0 * line / size).buffer(3.0) for line in lines])
    shape = MultiPolygon([part for part in get_parts(ink) if part.area > 0.0])
    for stroke in decompose(shape, template=known[-1]):
        assert np.isfinite(stroke.median).all()


# -- films ----------------------------------------------------------------------------------------


def _film_seeds() -> list[tuple[str, bytes]]:
    lines = (
        "write 永 --on bowl --out o.glb --film f.webp --fps 30 --speed 4 --turn 360deg --view 3,20",
        "replay a.jsonl --on plane --film f.gif --turn 8 --pixels 64x48 --zoom 1.5 --light none",
        "replay a.csv --on bowl --out o.ply --film f.mp4 --turn 90deg --speed .5 --view front",
    )
    return [("", line.replace(" ", "\n").encode()) for line in lines]


def _check_film(_: str, content: bytes) -> None:
    """Check what is asked for, and write such a film of two or three small pictures."""
    from pathlib import Path

    from PIL import Image

    from paint3d.cli.films import film_of
    from paint3d.errors import InputError
    from paint3d.view.film import is_held_whole, write_film

    asked = _parsed(content)
    if asked is None or "film" not in asked:
        return
    try:
        film = film_of(asked)
    except OSError as cause:  # a name that no file can have: `main` says it in one line, too
        raise InputError(str(cause.strerror)) from None
    if film is None:
        return
    for n in (2, 1000):
        filmed = film.filmed(n)
        assert filmed.turn_s is None or np.isfinite(filmed.turn_s)
        filmed.check(film.file, film.shot, n)
    form = {".gif": "GIF", ".webp": "WEBP"}.get(film.file.suffix.lower(), "MP4")
    if not is_held_whole(form):  # a program of its own writes it
        return
    part: Path = file_of(".part", b"")
    count = 2 + len(content) % (_MOST_PICTURES - 1)
    pictures = [Image.new("RGB", (16, 9), (40 * k, 9, 99)) for k in range(count)]
    write_film(part, iter(pictures), count, form, film.rate)
    with Image.open(part) as written:
        assert written.size == (16, 9)


LETTERING: dict[str, Target] = {
    "seal": Target("seals of a text, cut and pressed", _seal_seeds, _check_seal,
                   _damage_words),
    "drawn_seal": Target(
        "seals of a drawing, cut and pressed", DRAWINGS["svg"].seeds, _check_drawn_seal
    ),
    "letters": Target("letters whose strokes are listed", _letter_seeds, _check_letters,
                      _damage_letters),
    "film": Target("films of what is painted", _film_seeds, _check_film, _damage_words),
}  # fmt: skip

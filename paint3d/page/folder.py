"""Writer of the page as a folder of static files."""

from __future__ import annotations

import json
import logging
import math
import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from paint3d import __version__
from paint3d.app.window.wording import (
    choose_language,
    language,
    say,
    say_brush,
    say_object,
)
from paint3d.brush.presets import load_brush
from paint3d.colour.inks import load_ink
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, Pigment, load_pigment
from paint3d.core.atomic import write_atomically
from paint3d.core.kernel_library import FORMAT, INDEX, is_unchanged
from paint3d.errors import ExportError, InputError, Paint3DError
from paint3d.files.load import load_mesh
from paint3d.mesh.sheet_mesh import sheet_of
from paint3d.mesh.sheets import is_sheet, parse_sheet
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.page.bundle import write_bundle
from paint3d.page.copybook import (
    EM_MM,
    SCALED,
    SIGNED,
    glyphs_for,
    hand_table,
    hands_for,
    lay_out,
    outline_table,
)
from paint3d.page.seals import seal_table
from paint3d.page.tables import (
    Table,
    brush_table,
    common_table,
    material_table,
    object_table,
)
from paint3d.surface.granulation import COARSE_UM

__all__ = [
    "BRUSHES",
    "INKS",
    "MATERIALS",
    "OBJECTS",
    "PageObject",
    "available_texts",
    "build_page",
    "check_built",
    "check_grains",
    "resolution_for",
]

_LOG = logging.getLogger(__name__)
KERNELS: Path = Path(__file__).with_name("machine_code")
"""Where ``python -m tools.kernels --for wasm32`` puts the kernels."""
BUILT: Path = Path(__file__).with_name("built")
"""Where ``npm run build`` in web/ puts the page."""


class PageObject(NamedTuple):
    """An object by name, its longest edge under paint, mm, and its mesh if it has no file."""

    name: str
    resolution: float
    mesh: TriangleMesh | None = None


BRUSHES: tuple[str, ...] = (
    "zhongkai",
    "full",
    "xiaokai",
    "zhongbaiyun",
    "dabaiyun",
    "tidou",
    "gongbi",
    "feibai",
)
INKS: tuple[str, ...] = (
    "pine soot",
    "heavy",
    "light",
    "clear",
    "cinnabar",
    "indigo",
    "gamboge",
    "carmine",
)
MATERIALS = ("porcelain", "bisque", "xuan", "sized xuan", "silk")
COPYBOOK = (
    "牀前明月光\n疑是地上霜\n舉頭望明月\n低頭思故鄉",
    "行到水窮處\n坐看雲起時",
    "寧靜致遠",
    "永",
)
"""Poems of Li Bai (靜夜思) and Wang Wei, a saying of Zhuge Liang, and a beginner's character."""
_LITERALS = re.compile(r"""(?=(["'`])((?:(?!\1)[^\\\n]|\\.){4,300})\1)""")
"""Possible texts in a script: all between two equal quotation marks."""
_CHINESE_OF_TONES = {"heavy": "重墨", "light": "淡墨", "clear": "清墨"}


def resolution_for(name: str) -> float:
    """Return the resolution that suits a sheet of this name, mm; 0.4 for other objects."""
    return parse_sheet(name).detail_mm if is_sheet(name) else 0.4


OBJECTS = tuple(
    PageObject(name, resolution_for(name)) for name in ("scroll", "square", "fan", "bowl")
)


def available_texts() -> list[str]:
    """List the texts of `COPYBOOK` for whose characters there are glyphs."""
    available = []
    for text in COPYBOOK:
        try:
            glyphs_for(text)
        except Paint3DError as cause:
            _LOG.warning("%.5s is left out: %s", text, cause)
        else:
            available.append(text)
    return available


def build_page(
    out: Path,
    objects: Sequence[PageObject] = OBJECTS,
    brushes: Sequence[str] = BRUSHES,
    inks: Sequence[str] = INKS,
    progress: Callable[[float], None] = lambda fraction: None,
    *,
    materials: Sequence[str] = (),
    copybook: Sequence[str] = (),
    signed: bool = False,
    seals: str = "",
    page: Path | None = BUILT,
    kernels: Path = KERNELS,
) -> None:
    """Write the studio as a page into a folder, which any web server can serve.

    Parameters
    ----------
    out : Path
        Made if missing; files of an earlier build are replaced.
    objects : sequence of PageObject
        By the names that `load_mesh` takes, built-in ones or files.
    brushes : sequence of str
        Presets.
    inks : sequence of str
        As `load_ink` takes them; no coarse pigments, whose grains a page does not show.
    progress : callable
        Called with the fraction done.
    materials : sequence of str
        Besides those that suit the objects.
    copybook : sequence of str
        Texts, laid out for each sheet and planned for the brushes that suit their sizes; if empty
        there is no copybook.
    signed : bool
        Whether signatures with years are planned, too.
    seals : str
        Characters that seals can be cut from, or `seals.EVERY`; if empty there are no seals.
    page, kernels : Path
        Output folders of ``npm run build`` and ``python -m tools.kernels --for wasm32``; None:
        only the page's data are written.

    Raises
    ------
    ExportError
        If the page or its kernels are not built, the kernels were built from other sources, or
        the folder cannot be written.
    InputError, UnknownNameError, MeshError
        If an object, a brush, an ink or a character is not known, or cannot be used in a page.
    """
    glyphs = glyphs_for("".join(copybook))  # raises for an unknown character
    index = check_built(page, kernels)
    parts_of = {name: load_ink(name) for name in inks}
    pigments = list(dict.fromkeys(p for parts in parts_of.values() for p in parts))
    check_grains(pigments)
    pigments = list(dict.fromkeys([*pigments, load_pigment(WATER.name)]))
    loaded = [(one, load_mesh(one.name) if one.mesh is None else one.mesh) for one in objects]
    sheets = [sheet_of(mesh) for _, mesh in loaded]
    usual = ["porcelain" if sheet is None else sheet.usual.material for sheet in sheets]
    made_of = [load_material(name) for name in dict.fromkeys([*usual, *materials])]
    for name in brushes:
        load_brush(name)  # raises for an unknown brush before anything is written
    files: dict[str, Callable[[], Table]] = {"common.bin.gz": partial(common_table, pigments)}
    contents: dict[str, Any] = {"version": __version__, "objects": [], "brushes": []}
    with _in_chinese():
        for (one, mesh), suits in zip(loaded, usual, strict=True):
            file = f"objects/{_plain(one.name)}-{one.resolution:g}.bin.gz"
            if file in files:  # two files of one name, or names without Latin letters
                file = f"objects/{len(files)}-{_plain(one.name)}-{one.resolution:g}.bin.gz"
            contents["objects"].append(
                {"name": one.name, "chinese": say_object(one.name), "file": file}
                | {"resolution": one.resolution, "material": suits}
            )
            files[file] = partial(object_table, mesh, one.resolution)
        for name in brushes:
            file, chinese = f"brushes/{_plain(name)}.bin.gz", say_brush(name)
            contents["brushes"].append({"name": name, "chinese": chinese, "file": file})
            files[file] = partial(brush_table, name, chinese)
    contents["materials"] = []
    for material in made_of:
        file = f"materials/{_plain(material.name)}.bin.gz"
        words = {"name": material.name, "chinese": material.chinese, "file": file}
        contents["materials"].append(words)
        files[file] = partial(material_table, material, pigments)
    if copybook:
        sizes: list[tuple[float, str]] = []
        for words, (_, mesh) in zip(contents["objects"], loaded, strict=True):
            laid = [lay_out(mesh, text) for text in copybook]
            words["texts"] = [one._asdict() for one in laid]
            sizes += [(one.text["em_mm"], one.text["text"]) for one in laid]
            sizes += [(one.signature["em_mm"], SIGNED) for one in laid if signed]
        contents["copybook"] = {
            "file": "copybook.bin.gz",
            "texts": list(copybook),
            "scaled": SCALED,
            "hands": [],
        }
        files["copybook.bin.gz"] = partial(outline_table, "".join(copybook), glyphs)
        for hand in hands_for([*sizes, *[(EM_MM, text) for text in copybook]], brushes):
            file = f"hands/{_plain(hand.brush)}-{hand.em_mm:g}.bin.gz"
            contents["copybook"]["hands"].append({**hand._asdict(), "file": file})
            files[file] = partial(hand_table, hand, glyphs)
    if seals:
        contents["seals"] = {"file": "seals.bin.gz"}
        lines = seal_table(seals)
        files["seals.bin.gz"] = lambda: lines
    contents["inks"] = [
        {
            "name": name,
            "chinese": _CHINESE_OF_TONES.get(name)
            or "、".join(p.chinese or p.name for p in parts if p is not WATER),
            "parts": {pigment.name: part for pigment, part in parts.items()},
        }
        for name, parts in parts_of.items()
    ]
    try:
        out.mkdir(parents=True, exist_ok=True)
        for done, (file, make) in enumerate(files.items()):
            (out / file).parent.mkdir(exist_ok=True)
            write_bundle(out / file, *make())
            progress((done + 1) / (len(files) + 1))
        _copy(kernels / index["code"]["wasm32"], out / "kernels.wasm")
        _write_json(out / "kernels.json", _page_index(index))
        _write_json(out / "contents.json", contents)
        if page is not None:
            _copy_page(page, out)
            _write_json(out / "notes.zh.json", _chinese_notes(page))
    except OSError as cause:
        raise ExportError("{file}: cannot write the page: {cause}", file=out, cause=cause) from None
    progress(1.0)


def check_built(page: Path | None, kernels: Path) -> dict[str, Any]:
    """Read the index of the page's kernels; see that the page is built, unless it is None.

    Raises
    ------
    ExportError
        If the kernels are not compiled, or from other sources, or the page is not built.
    """
    try:
        index: dict[str, Any] = json.loads((kernels / INDEX).read_text("utf-8"))
        is_there = index["format"] == FORMAT and (kernels / index["code"]["wasm32"]).is_file()
    except (OSError, ValueError, LookupError):
        is_there = False
    if not is_there:
        raise ExportError(
            "the kernels of the page are not compiled: {kernels} has none; expected them to be",
            kernels=kernels,
            hint="./scripts/page",
        )
    changed = [path for path, digest in index["sources"] if not is_unchanged(path, digest)]
    if changed:
        raise ExportError(
            "the kernels of the page in {kernels} are out of date: {path} has changed since; "
            "expected them to be compiled again",
            kernels=kernels,
            path=changed[0],
            hint="./scripts/page",
        )
    if page is not None and not (page / "index.html").is_file():
        raise ExportError(
            "the page is not built: {page} has no index.html; expected it to be",
            page=page,
            hint="npm ci && npm run build, in web/",
        )
    return index


def _page_index(index: Mapping[str, Any]) -> dict[str, Any]:
    """Make the page's index of kernels: how each is called, and the records that they take."""
    kernels: dict[str, Any] = {}
    records: dict[str, Any] = {}
    for name, kernel in index["kernels"].items():
        kernels[name] = []
        for code in kernel["codes"]:
            kernels[name].append({key: code[key] for key in ("symbol", "gives", "n_takes",
                                                              "n_gives", "expected")})  # fmt: skip
            arrays = re.findall(r"[\[{](.)\d", code["takes"])
            kinds = re.findall(r"[\[{]", code["takes"])
            leaves = [leaf for leaf in _leaves(code["expected"]) if "[" in leaf]
            for letter, kind, leaf in zip(arrays, kinds, leaves, strict=True):
                if kind == "{":
                    records[leaf.split("[")[0]] = _record(code["records"][ord(letter) - ord("A")])
    return {"kernels": kernels, "records": records}


def _leaves(expected: Mapping[str, Any]) -> Iterator[str]:
    """Yield the types of an index's arguments, tuples flattened."""
    for value in expected.values():
        if isinstance(value, str):
            yield value
        else:
            yield from _leaves(value)


def _record(record: Mapping[str, Any]) -> dict[str, Any]:
    """Describe a record of float64 fields: its size, and each field's offset and count."""
    fields = {}
    for name, kind, offset in zip(
        record["names"], record["formats"], record["offsets"], strict=True
    ):
        of, shape = (kind, [1]) if isinstance(kind, str) else kind
        assert of == "<f8", f"{name} is {of}"
        fields[name] = {"offset": offset, "count": math.prod(shape)}
    return {"itemsize": record["itemsize"], "fields": fields}


def check_grains(pigments: Iterable[Pigment]) -> None:
    """Refuse pigments with visible grains.

    Raises
    ------
    InputError
        Naming the first.
    """
    coarse = [p.name for p in pigments if p.grain_um >= COARSE_UM]
    if coarse:
        raise InputError(
            "the grains of {pigment} are visible, which a page does not show; expected a finer "
            "pigment",
            pigment=coarse[0],
        )


def _chinese_notes(page: Path) -> dict[str, str]:
    """Collect the Chinese of the catalogue's texts that occur in the page's scripts."""
    scripts = [path.read_text("utf-8") for path in sorted((page / "assets").glob("*.js"))]
    literals = {literal for script in scripts for _, literal in _LITERALS.findall(script)}
    texts = {re.sub(r"\\(.)", r"\1", literal) for literal in literals}
    with _in_chinese():
        return {text: say(text) for text in sorted(texts) if say(text) != text}


@contextmanager
def _in_chinese() -> Iterator[None]:
    """Say names in Chinese within the ``with`` block."""
    before = language()
    choose_language("zh")
    try:
        yield
    finally:
        choose_language(before)


def _plain(name: str) -> str:
    """Make a name usable in a file name."""
    return re.sub(r"[^0-9A-Za-z._-]+", "-", Path(name).stem if "/" in name else name)


def _copy_page(page: Path, out: Path) -> None:
    for name in ("index-*", "*_worker-*"):
        for path in (out / "assets").glob(name):
            path.unlink()  # of an earlier page
    for path in sorted(page.rglob("*")):
        if path.is_file():
            (out / path.relative_to(page)).parent.mkdir(exist_ok=True, parents=True)
            _copy(path, out / path.relative_to(page))


def _copy(source: Path, target: Path) -> None:
    with write_atomically(target) as temporary:
        shutil.copyfile(source, temporary)


def _write_json(path: Path, words: Mapping[str, Any]) -> None:
    with write_atomically(path) as temporary:
        temporary.write_text(json.dumps(words, ensure_ascii=False), "utf-8")

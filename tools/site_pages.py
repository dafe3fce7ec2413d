"""Pages of the site that are generated, and links between the site and the repository.

Hooks of MkDocs (`mkdocs.yml`): the command line from its parsers, brushes, inks and materials from
their tables, the gallery from the pictures and where they are shown; README, CHANGELOG,
CONTRIBUTING and the examples as they stand.
"""

from __future__ import annotations

import argparse
import posixpath
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from paint3d.brush.presets import brush_note, load_presets
from paint3d.brush.spec import BrushSpec
from paint3d.cli.main import make_parser
from paint3d.cli.options import Parser
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.materials import load_materials
from paint3d.colour.pigments import load_palette
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.core.arrays import AnyArray

ROOT = Path(__file__).parents[1]
TAKEN = {  # pages from beside docs/, by where they are in the site
    "index.md": "README.md",
    "CHANGELOG.md": "CHANGELOG.md",
    "CONTRIBUTING.md": "CONTRIBUTING.md",
    "LICENSE": "LICENSE",
} | {
    f"examples/{one.name}": f"examples/{one.name}"
    for one in sorted((ROOT / "examples").iterdir())
    if one.is_file()
}
COATS = (0.1, 0.3, 1.0)
_LINK = re.compile(r"(?<=\]\()(?!\w+:|#)([^)\s#]+)")
_SHOWN = re.compile(r"!\[([^\]]*)\]\(gallery/([^)]+)\)")
_NAMED = re.compile(r"(?<!!)\[([^\]]*)\]\(gallery/([^)]+)\)")
_CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.MULTILINE | re.DOTALL)

# ---- Hooks ---------------------------------------------------------------------------------------


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are not in docs/."""
    made = {
        "gallery.md": gallery_page(),
        "reference/commands.md": commands_page(),
        "reference/brushes.md": brushes_page(),
        "reference/inks.md": inks_page(),
        "reference/materials.md": materials_page(),
    }
    for place, text in made.items():
        files.append(File.generated(config, place, content=text))
    for place, path in TAKEN.items():
        files.append(File.generated(config, place, abs_src_path=str(ROOT / path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Rewrite links of the repository to links of the site."""
    here = page.file.src_uri
    real = TAKEN.get(here, f"docs/{here}")
    return _outside_code(markdown, lambda text: _LINK.sub(lambda m: _moved(m[1], real, here), text))


def _outside_code(markdown: str, change: Callable[[str], str]) -> str:
    parts, end = [], 0
    for code in _CODE.finditer(markdown):
        parts += [change(markdown[end : code.start()]), code[0]]
        end = code.end()
    return "".join([*parts, change(markdown[end:])])


def _moved(target: str, real: str, here: str) -> str:
    """Translate a link of the file `real` of the repository to one from the page `here`."""
    path = posixpath.normpath(posixpath.join(posixpath.dirname(real), target))
    if (ROOT / path).is_dir():
        path += "/README.md"
    places = {one: place for place, one in TAKEN.items()}
    place = places.get(path, path.removeprefix("docs/"))
    return posixpath.relpath(place, posixpath.dirname(here) or ".")


# ---- The command line ----------------------------------------------------------------------------


def commands_page() -> str:
    """Make the page of every command's `--help`."""
    parts = [
        "# Command line",
        "What `paint3d COMMAND --help` says, of all commands. "
        "[A line for each task](../commands.md) shows them at work.",
    ]
    for name, parser in make_parser().actions().items():
        parts += _command(f"paint3d {name}", parser, "##")
        for action, one in parser.actions().items():
            parts += _command(f"paint3d {name} {action}", one, "###")
    return "\n\n".join(parts) + "\n"


def _command(name: str, parser: Parser, level: str) -> Iterator[str]:
    yield f"{level} {name}"
    yield _prose(parser.description or "")
    rows = [
        (f"`{word}`", _prose(told))
        for group in parser._action_groups
        for action in group._group_actions
        if not isinstance(action, argparse._SubParsersAction | argparse._HelpAction)
        for word, told in [(_words(action), _told(action, parser))]
    ]
    if rows:
        yield table(("option", "meaning"), rows)
    examples = [line.strip() for line in parser.examples.strip().splitlines()]
    yield "\n".join(["```sh", *examples, "```"])


def _words(action: argparse.Action) -> str:
    value = action.metavar or ",".join(map(str, action.choices or ()))
    value = " ".join(value) if isinstance(value, tuple) else value
    names = ", ".join(action.option_strings)
    if not names:
        return value or action.dest
    return names if action.nargs == 0 else f"{names} {value or action.dest.upper()}"


def _told(action: argparse.Action, parser: Parser) -> str:
    return (action.help or "") % {**vars(action), "prog": parser.prog}


def _prose(text: str) -> str:
    """Escape characters of a help text that Markdown would interpret."""
    return re.sub(r"([<>*_|\[\]])", r"\\\1", text)


# ---- Brushes, inks, materials --------------------------------------------------------------------

_BRUSH = {
    "hair": "hair", "length_mm": "length, mm", "root_diameter_mm": "root, mm",
    "hardness": "hardness", "taper": "taper", "friction": "friction",
    "full_press_mm": "full press, mm",
}  # fmt: skip
_MATERIAL = {
    "roughness": "roughness", "coat": "glaze", "absorbency": "drinks", "tooth_mm": "tooth, mm",
    "friction": "friction", "spread_mm2_s": "spread, mm²/s", "drying_mm_s": "drying, mm/s",
}  # fmt: skip


def brushes_page() -> str:
    """Make the page of the brushes that come with the program."""
    rows = [
        (f"`{one.name}`", *(_number(getattr(one, field)) for field in _BRUSH), _hairs(one),
         _prose(brush_note(one.name)))
        for one in load_presets().values()
    ]  # fmt: skip
    return (
        "# Brushes\n\n`--brush NAME` takes one of these; `paint3d brushes show NAME > mine.toml` "
        "makes a file of it, to start one of your own from "
        "([brushes of one's own](../brushes.md)).\n\n"
        + table(("name", *_BRUSH.values(), "hairs", "for"), rows)
    )


def _hairs(brush: BrushSpec) -> str:
    return "solid" if brush.bristles is None else str(brush.bristles.n_hairs)


def inks_page() -> str:
    """Make the page of the palette: colours and sources."""
    ground = load_materials()["porcelain"].reflectance
    rows = [
        (f"`{one.name}` {one.chinese}",
         *(swatch(mixture_reflectance({one: 1.0}, coats, ground)) for coats in COATS),
         _prose(f"{one.basis}; {one.source} ({one.licence})"))
        for one in load_palette().values()
    ]  # fmt: skip
    heads = [f"{coats:g} coat{'s' * (coats != 1)}" for coats in COATS]
    return (
        '# Inks\n\n`--ink NAME` takes one of these, `--ink "NAME:0.3,water:0.7"` a mixture; '
        "a table of K and S makes one of your own ([inks](../ink.md)). The colours are those of a "
        "film on porcelain in daylight.\n\n" + table(("name", *heads, "from"), rows)
    )


def materials_page() -> str:
    """Make the page of surface materials."""
    rows = [
        (f"`{one.name}` {one.chinese}", swatch(one.reflectance),
         *(_number(getattr(one, field)) for field in _MATERIAL), _prose(one.basis))
        for one in load_materials().values()
    ]  # fmt: skip
    return (
        "# Materials\n\n`--material NAME` takes one of these; `paint3d materials show NAME > "
        "mine.toml` makes a file of it, to start one of your own from "
        "([surfaces and sheets](../materials.md)).\n\n"
        + table(("name", "", *_MATERIAL.values(), "reflectance"), rows)
    )


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Format a table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def swatch(reflectance: AnyArray) -> str:
    """Format a coloured cell with its code as title."""
    shown = "#" + "".join(f"{value:02x}" for value in srgb_from_reflectance(reflectance))
    return f'<span style="background:{shown};padding:0 1.2em" title="{shown}"></span>'


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


# ---- Gallery -------------------------------------------------------------------------------------

_SCREEN = 'xvfb-run -a -s "-screen 0 1400x900x24" python'
BY_OTHERS = (  # the pictures that build_gallery.py does not draw
    {
        "stroke.webp": "python scripts/gallery/film.py",
        "bowl.html": "paint3d write 春江潮水連海平海上明月 --on bowl --around --size 30 "
        "--out bowl.p3d\n"
        "paint3d export bowl.p3d bowl.html --view-only",
        "palette.png": "python scripts/gallery/palette.py",
        "ink_flowers.png": "python scripts/gallery/ink.py flowers",
        "brush_editor.png": f"{_SCREEN} scripts/gallery/brush_editor.py",
        "colour.png": f"{_SCREEN} scripts/gallery/brush_editor.py",
    }
    | {
        f"{name}.png": f"python scripts/gallery/ink.py {name}"
        for name in ("wet_in_wet", "feathering", "bloom", "lotus", "vermilion", "petals")
    }
    | {
        f"{name}.png": f"{_SCREEN} scripts/gallery/studio.py --only {name}.png"
        for name in ("studio", "studio_copybook", "studio_strokes")
    }
    | {
        f"hand_{name}.png": f"{_SCREEN} -m scripts.gallery.hand {name}"
        for name in ("yong_on_paper", "yong_in_bowl", "tilt_chart", "bamboo")
    }
)


def gallery_page() -> str:
    """Make the page of the pictures of docs/gallery, by the pages that show them."""
    parts = [
        "# Gallery",
        "What draws each picture stands below it. It is run in a checkout of the repository, where "
        "`package` is the unpacked `npm pack hanzi-writer-data`.",
    ]
    met: set[str] = set()
    pages = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    for pattern in (_SHOWN, _NAMED):  # one that a page names and another shows is the other's
        for path in pages:
            text = path.read_text("utf-8")
            found = {name: alt for alt, name in pattern.findall(text.replace("](docs/", "]("))}
            new = {name: alt for name, alt in found.items() if name not in met}
            met |= set(new)
            if new:
                parts.append(
                    f"## [{_title(text)}]({'index.md' if path.name == 'README.md' else path.name})"
                )
            for name, alt in new.items():
                command = f"```sh\n{drawn_by(name)}\n```"
                picture = "" if name.endswith(".html") else "!"  # a page is opened, not shown
                parts += [f"{picture}[{alt}](gallery/{name})", f"{alt[:1].upper()}{alt[1:]}:"]
                parts.append(command)
    return "\n\n".join(parts) + "\n"


def _title(text: str) -> str:
    found = re.search(r"^# (.+)$", text, re.MULTILINE)
    assert found, "a page begins with its title"
    return found[1]


def drawn_by(picture: str) -> str:
    """Return the command that draws a picture of docs/gallery."""
    return BY_OTHERS.get(picture, f"python scripts/build_gallery.py --glyphs package {picture}")

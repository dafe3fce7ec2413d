#!/usr/bin/env python3
"""Draw the pictures of docs/gallery. Each module of scripts/gallery has a dict PICTURES: the names
of files, and functions that draw them. A new picture is a new function, or a new module.

    scripts/build_gallery.py --glyphs package           # all
    scripts/build_gallery.py --glyphs package techniques.png
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path

from PIL import Image

from paint3d.errors import Paint3DError

HERE = Path(__file__).parent
MOST_BYTES = 1_500_000


def main(arguments: list[str] | None = None) -> int:
    """Draw the wanted pictures and make them small enough."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", metavar="NAME", nargs="*", help="which (default: all)")
    parser.add_argument("--glyphs", type=Path, required=True, help="unpacked hanzi-writer-data")
    parser.add_argument("--out", type=Path, default=HERE.parent / "docs/gallery")
    options = parser.parse_args(arguments)
    pictures = find_pictures()
    unknown = set(options.names) - set(pictures)
    if unknown:
        parser.error(f"unknown: {', '.join(sorted(unknown))}; expected of {', '.join(pictures)}")
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.names or pictures:
        file = options.out / name
        try:
            pictures[name](file, options.glyphs)
        except Paint3DError as error:
            print(f"{parser.prog}: {name}: {error}", file=sys.stderr)
            return 2
        shrink(file)
        print(f"{file}: {file.stat().st_size} bytes")
    return 0


def find_pictures() -> dict[str, Callable[[Path, Path], None]]:
    """Functions (file to write, folder of glyphs) by the names of their pictures."""
    sys.path.insert(0, str(HERE / "gallery"))
    pictures = {}
    for file in sorted((HERE / "gallery").glob("[a-z]*.py")):
        spec = importlib.util.spec_from_file_location(file.stem, file)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        pictures.update(getattr(module, "PICTURES", {}))
    return pictures


def shrink(file: Path) -> None:
    """Pack a picture in true colour, with fewer pixels until it is small enough."""
    picture = Image.open(file).convert("RGB")
    while True:
        picture.save(file, optimize=True)
        if file.stat().st_size <= MOST_BYTES:
            return
        picture = picture.resize((picture.width * 3 // 4, picture.height * 3 // 4), Image.LANCZOS)


if __name__ == "__main__":
    raise SystemExit(main())

"""Texts that fill their sheets, signed and sealed, each by one command."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from paint3d.cli.main import main

POEM = "床前明月光，疑是地上霜。舉頭望明月，低頭思故鄉。"


def run(*arguments: object) -> None:
    """Run a command as from the shell."""
    code = main([*map(str, arguments), "--quiet"])
    if code:
        raise SystemExit(code)


def draw(file: Path, pixels: str, *asked: object) -> None:
    """Write, and save the sheet from above."""
    with TemporaryDirectory() as folder:
        painting, picture = Path(folder, "a.p3d"), Path(folder, "a.png")
        run("write", *asked, "--out", painting)
        run("picture", painting, "--view", "flat", "--pixels", pixels, "--out", picture)
        Image.open(picture).convert("RGB").save(file, quality=85, method=6)


def draw_signed_scroll(file: Path, _: Path) -> None:
    """A quatrain on a hanging scroll."""
    draw(file, "800x2000", POEM, "--on", "scroll:mounted",
         "--sign", "李白詩石山書", "--seal", "石山")  # fmt: skip


def draw_running_script(file: Path, _: Path) -> None:
    """Half a poem in running script; the font is Debian's fonts-kouzan-mouhitsu, free of rights."""
    lines = "空山新雨後\n天気晩来秋\n明月松間照\n清泉石上流"
    draw(file, "1440x1320", lines, "--on", "sheet:360x330", "--size", 54, "--layout", "columns",
         "--font", "KouzanBrushFontGyousyo", "--dip", "every 7", "--sign", "石山",
         "--seal", "石山")  # fmt: skip


PICTURES = {
    "signed_scroll.webp": draw_signed_scroll,
    "running_script.webp": draw_running_script,
}

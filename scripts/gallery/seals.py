"""A poem with its seal, and seals of both styles, as they are pressed."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from paint3d.cli.main import main

POEM = "春眠不覺曉\n處處聞啼鳥\n夜來風雨聲\n花落知多少"
SIDE = 420  # pixels of an enlarged seal


def run(*arguments: object) -> None:
    """Run a command as from the shell."""
    code = main([*map(str, arguments), "--quiet"])
    if code:
        raise SystemExit(code)


def draw_poem_with_seal(file: Path, _: Path) -> None:
    """The sheet, and beside it the seal enlarged, and another one in white lines."""
    with TemporaryDirectory() as folder:
        at = partial(Path, folder)
        run("write", POEM, "--on", "plane", "--material", "xuan", "--size", 22, "--at",
            "0.55,0.52", "--resolution", 0.15, "--out", at("poem.p3d"))  # fmt: skip
        for name, on, words, style, place in (
            ("sealed", "poem", "浩然", "zhuwen", "0.25,0.3"),
            ("both", "sealed", "永和九年", "baiwen", "0.25,0.2"),
        ):
            run("seal", words, "--style", style, "--on", at(f"{on}.p3d"), "--size", 13, "--at",
                place, "--layer", "seal", "--out", at(f"{name}.p3d"))  # fmt: skip
        run("picture", at("both.p3d"), "--view", "flat", "--pixels", "2400x2400",
            "--out", at("a.png"))  # fmt: skip
        whole = Image.open(at("a.png")).convert("RGB")
    n = whole.width
    sheet = whole.crop((int(0.18 * n), int(0.17 * n), int(0.86 * n), int(0.86 * n)))
    sheet = sheet.resize((2 * SIDE, 2 * SIDE), Image.LANCZOS)
    picture = Image.new("RGB", (3 * SIDE, 2 * SIDE))
    picture.paste(sheet, (0, 0))
    half = int(0.038 * n)
    for k, (u, v) in enumerate(((0.25, 0.3), (0.25, 0.2))):
        x, y = int(u * n), int((1.0 - v) * n)
        near = whole.crop((x - half, y - half, x + half, y + half))
        picture.paste(near.resize((SIDE, SIDE), Image.BICUBIC), (2 * SIDE, k * SIDE))
    picture.save(file)


PICTURES = {"poem_with_seal.png": draw_poem_with_seal}

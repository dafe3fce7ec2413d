"""Whole pieces: a fan with bamboo in wet ink, and a cup with a name around it and plum inside.

Painted by a free hand's strokes; text, signature and seal by the commands, on what was painted.
"""

from __future__ import annotations

import itertools
import sys
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from trimesh.creation import revolve

sys.path.insert(0, str(Path(__file__).parent))
from ink import hand
from papers import blossom, petal, twig
from sheets import run
from writing import beside

from paint3d.brush.spec import DipAmount
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import make_chart
from paint3d.mesh.placement import place
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

CUP = (  # mm: radius and height, up the outside, over the rim and down the inside
    (0, 2), (19, 2), (20, 0), (23, 0), (24, 4), (34, 12), (43, 28), (48, 48), (50.5, 63),
    (50, 64.5), (48.8, 64), (46, 48), (41, 29), (32, 14), (20, 8), (0, 7),
)  # fmt: skip


class Flat:
    """The sheet in z = 0, as `hand` asks for a chart."""

    @staticmethod
    def points(xy: NDArray) -> NDArray:
        """Points (N, 3) at x and y, mm."""
        return np.column_stack([xy, np.zeros(len(xy))])

    @staticmethod
    def normals(xy: NDArray) -> NDArray:
        """All upwards."""
        return np.tile([0.0, 0.0, 1.0], (len(xy), 1))


def culm(painter: Painter, knots: NDArray, press: float, inks: tuple[str, str]) -> None:
    """A cane from node to node (N, 2), mm: each length by one stroke that rests at both ends."""
    painter.dip(inks[0])
    painter.dip(inks[1], reach=0.3)
    painter.wipe(0.35)
    for low, high in itertools.pairwise(knots):
        along = (high - low) / np.linalg.norm(high - low)
        bow = 0.012 * np.linalg.norm(high - low) * np.array([-along[1], along[0]])
        shares = np.array([0.0, 0.04, 0.15, 0.5, 0.85, 0.96, 1.0])
        gap = 0.9 * along
        way = (
            low
            + gap
            + np.outer(shares, high - low - 2.0 * gap)
            + np.outer(np.sin(np.pi * shares), bow)
        )
        firm = press * np.array([0.6, 1.1, 0.95, 0.88, 0.95, 1.12, 0.6])
        hand(Flat, painter, np.c_[way, firm], 0.0, 160.0, wet=False)


def node(painter: Painter, at: NDArray, along: NDArray, half: float) -> None:
    """The dark line between two lengths, its ends turned up."""
    across = np.array([along[1], -along[0]])
    ways = np.array([[-1.1, 0.16], [-0.75, -0.05], [0.0, -0.14], [0.75, -0.05], [1.1, 0.2]])
    points = at + half * (ways[:, :1] * across + ways[:, 1:] * along)
    hand(Flat, painter, np.c_[points, [0.04, 0.12, 0.05, 0.11, 0.01]], 0.2, 90.0, wet=False)


def leaf(painter: Painter, root: NDArray, degrees: float, long: float, press: float) -> None:
    """One stroke: laid down, filled, and drawn out to a point."""
    bow = np.array([0.1, 0.06, 0.0, -0.05, -0.12])
    way = np.radians(degrees) + bow * (1.0 if np.cos(np.radians(degrees)) > 0.0 else -1.0)
    away = long * np.array([0.0, 0.14, 0.4, 0.75, 1.0])
    knots = root + np.c_[away * np.cos(way), away * np.sin(way)]
    hand(Flat, painter, np.c_[knots, press * np.array([0.1, 0.62, 1.0, 0.5, 0.01])], 0.3, 120.0)


def draw_bamboo_fan(file: Path, _: Path) -> None:
    """Two canes, leaves in three tones into one another while they are wet; signed and sealed."""
    surface = PaintedSurface(load_mesh("fan"), 0.3, "xuan")
    wide = Painter(surface, "dakai", "light", amount=DipAmount(fullness=0.5))
    back = np.array([(132, -112), (118, -66), (106, -22), (96, 22), (88, 62), (83, 84)], float)
    front = np.array([(70, -79), (64, -48), (52, 0), (44, 48), (39, 92), (36, 109)], float)
    culm(wide, back, 0.13, ("clear", "light"))
    culm(wide, front, 0.22, ("light", "heavy"))
    fine = Painter(surface, "langhao", "thick")
    for knots, half, ink in ((back, 2.6, "heavy"), (front, 4.4, "burnt")):
        for k in range(1, len(knots) - 1):
            fine.dip(ink)
            along = knots[k + 1] - knots[k - 1]
            node(fine, knots[k], along / np.linalg.norm(along), half)
    for knots, ink in (
        ([(42, 48, 0.2), (20, 62, 0.13), (-8, 70, 0.11), (-42, 66, 0.08)], "thick"),
        ([(14, 65, 0.13), (-4, 54, 0.1), (-20, 42, 0.06)], "thick"),
        ([(-16, 69, 0.12), (-40, 80, 0.1), (-70, 80, 0.06)], "thick"),
        ([(50, 0, 0.2), (34, 16, 0.13), (12, 22, 0.11), (-10, 18, 0.07)], "thick"),
        ([(42, 92, 0.14), (60, 98, 0.1), (74, 92, 0.05)], "thick"),
        ([(90, 60, 0.16), (112, 72, 0.1), (136, 70, 0.06)], "heavy"),
        ([(98, 20, 0.16), (122, 32, 0.1), (150, 28, 0.05)], "heavy"),
    ):
        fine.dip(ink)
        hand(Flat, fine, np.array(knots, float), 0.1, 130.0, wet=False)
    brush = Painter(surface, "full", "light", amount=DipAmount(fullness=0.22))
    for belly, tip, groups in (
        ("clear", "clear", (((136, 70), (-70, -42, -18), 36), ((150, 28), (-96, -64, -36), 40),
                            ((112, 72), (-100, -72), 32), ((-60, 80), (-112, -136), 42))),
        ("clear", "heavy", (((-18, 44), (-118, -94, -146), 42), ((-10, 18), (-128, -100, -160), 44),
                            ((124, 32), (-112, -84), 36), ((-84, 78), (-118, -98), 40),
                            ((74, 92), (-38, -70), 28))),
        ("heavy", "burnt", (((-42, 66), (-136, -110, -84, -162), 52), ((-4, 60), (-122, -92), 46),
                            ((-70, 80), (-152, -176, -124), 46), ((16, 22), (-116, -80), 46),
                            ((36, 14), (-128, -100), 36), ((24, 62), (-70, -104), 42),
                            ((-24, 68), (-96, -66), 40))),
    ):  # fmt: skip
        for root, turns, long in groups:
            for k, degrees in enumerate(turns):
                brush.dip(belly)
                brush.dip(tip, reach=0.25)
                start = np.array(root) + 1.5 * np.array([np.sin(5.0 * k), np.cos(3.0 * k)])
                leaf(brush, start, degrees, long * (1.0 - 0.12 * (k % 3)), 0.32 - 0.02 * k)
    surface.diffuse(30.0)
    surface.dry()
    with TemporaryDirectory() as folder:
        at = partial(Path, folder)
        save_session(Session(surface), at("bamboo.p3d"))
        for words, size, place, on, out in (
            ("未出土時\n先有節", 21, "0.2,0.44", "bamboo", "poem"),
            ("山人寫竹", 10, "0.178,0.25", "poem", "signed"),
        ):
            run("write", words, "--on", at(f"{on}.p3d"), "--size", size, "--at", place,
                "--out", at(f"{out}.p3d"))  # fmt: skip
        run("seal", "山人", "--on", at("signed.p3d"), "--size", 13, "--at", "0.24,0.165",
            "--rotate", 60, "--out", at("fan.p3d"))  # fmt: skip
        run("picture", at("fan.p3d"), "--view", "flat", "--pixels", "2400x1130", "--out", file)


def draw_named_cup(file: Path, _: Path) -> None:
    """From the side, and from above."""
    with TemporaryDirectory() as folder:
        painting, picture = named_cup(Path(folder)), Path(folder, "a.png")
        pictures = []
        for view, zoom, light in (("0,16", 1.15, "studio"), ("8,60", 1.15, "soft")):
            run("picture", painting, "--view", view, "--pixels", "1200x1100", "--zoom", zoom,
                "--light", light, "--out", picture)  # fmt: skip
            pictures.append(Image.open(picture).convert("RGB"))
    beside(pictures).save(file, quality=90, method=6)


def named_cup(folder: Path) -> Path:
    """Paint the cup into a folder; the painting."""
    at = partial(Path, folder)
    revolve(np.array(CUP, float), sections=192).export(at("cup.stl"))
    run("write", "西湖林和靖先生", "--on", at("cup.stl"), "--up", "z", "--unit", "mm",
        "--around", "--size", 27, "--layout", "row", "--at", "0.5,0.62", "--resolution", 0.2,
        "--out", at("named.p3d"))  # fmt: skip
    surface = load_session(at("named.p3d")).surface
    plum(surface)
    save_session(Session(surface), at("cup.p3d"))
    return at("cup.p3d")


def plum(surface: PaintedSurface) -> None:
    """A branch in the cup's bottom, lifted where blossoms sit, then those."""
    closest = ClosestPoints(surface.source)
    chart = make_chart(closest, place(closest, (0.5, 0.5), side="top"), 46.0, 46.0)
    painter = Painter(surface, "xiaobaiyun", "heavy")
    blossoms = (
        (16, 3, 1.2, 0.2), (-10, 14, 1.3, 0.9), (-17.5, 0, 1.1, 0.6), (2, -9.5, 1.0, 1.3),
    )  # fmt: skip
    kept = [(x, y, 4.6 * size) for x, y, size, _ in blossoms]
    for points, presses in (
        ([(-34, -26), (-24, -19), (-15, -10), (-4, -6), (6, 2), (13, 9), (22, 22)],
         (0.34, 0.5, 0.4, 0.44, 0.3, 0.2, 0.02)),
        ([(-12, -9), (-11.5, 1), (-8, 9), (-7, 20), (-2, 29)], (0.3, 0.22, 0.16, 0.12, 0.02)),
        ([(4, 0), (13, -5), (20, -7), (27, -6)], (0.26, 0.17, 0.12, 0.02)),
        ([(8.5, 4), (7, 14), (10, 24)], (0.18, 0.13, 0.02)),
        ([(-24, -19), (-27, -10), (-33, -4)], (0.22, 0.14, 0.02)),
    ):  # fmt: skip
        painter.dip("heavy")
        painter.dip("burnt", reach=0.4)
        painter.wipe(0.25)
        twig(chart, painter, points, presses, kept, "xiaobaiyun")
    surface.dry()
    for x, y, size, turn in blossoms:
        blossom(chart, painter, np.array([x, y]), size, turn)
    for x, y, turn in (
        (27.4, -5.6, 0.1), (10.6, 24.6, 1.2), (-1.6, 29.4, 1.1), (22.4, 22.4, 0.7), (14, 11, 2.2),
        (-33.4, -3.2, 2.2), (-7, 21, 2.6),
    ):  # fmt: skip
        petal(chart, painter, np.array([x, y]), turn, 0.75, 0.2)
    surface.dry()
    painter.rinse()
    painter.dip("burnt")
    for x, y, size, turn in blossoms:
        for k in range(7):
            angle = turn + 0.3 + k * 2.0 * np.pi / 7.0
            reach = size * (2.2 + 0.4 * np.cos(5.0 * k))
            out = np.array([np.cos(angle), np.sin(angle)])
            way = np.array([x, y]) + np.outer([0.3, reach, reach + 0.3], out)
            hand(chart, painter, np.c_[way, [0.01, 0.02, 0.07]], 0.0, 40.0, wet=False)
    surface.dry()


PICTURES = {"bamboo_fan.webp": draw_bamboo_fan, "named_cup.webp": draw_named_cup}

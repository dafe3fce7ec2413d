"""The photographer's studio: softboxes, dome and floor, and the gloss of materials.

Studio axes: x to the camera's right, y away from the camera, z up. Radiance is relative; the
exposure is set in `paint3d.view.picture`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import Material, glazed_roughness, load_materials
from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import UnknownNameError

__all__ = [
    "DOME",
    "LIGHTS",
    "NO_PAPER",
    "SOFTBOXES",
    "Gloss",
    "Softbox",
    "Studio",
    "Sun",
    "light_samples",
    "linear_to_srgb",
    "make_panorama",
    "srgb_to_linear",
]

GOLDEN = (np.sqrt(5) - 1) / 2
NO_PAPER = (0.0, 0.0)


@dataclass(frozen=True)
class Gloss:
    """The specular reflection of a material.

    Parameters
    ----------
    roughness : float
        Microfacet roughness of the body, 0 (mirror) to 1 (chalk).
    coat : float
        Strength of the clear glaze over it, 0 (none) to 1.
    grain : float
        Coarseness, 0 (smooth) to 1: its bumps are lighter and its pits darker.
    wave_mm : float
        Distance between bumps.
    paper : (2,) of float
        How much is seen of the paper where it is bare, its clouds and fibres, and of its grain in
        ink; (1, 1) for raw xuan, (0, 0) where it is none.
    each : (V,) float32, optional
        Visible roughness of each vertex, if they differ: where wet, or under dried ink.
    """

    roughness: float
    coat: float
    grain: float = 0.0
    wave_mm: float = 1.0
    paper: tuple[float, float] = NO_PAPER
    each: NDArray[np.float32] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        as_number(self.grain, "grain", 0.0, 1.0)
        as_number(self.wave_mm, "wave_mm", 0.01, 100.0)
        as_number(self.roughness, "roughness", 0.0, 1.0)
        as_number(self.coat, "coat", 0.0, 1.0)
        for amount in self.paper:
            as_number(amount, "paper", 0.0, 4.0)

    @classmethod
    def of(cls, material: str | Material) -> Gloss:
        """Return the gloss of a material; UnknownNameError lists the known names.

        Some materials have values tuned by eye for pictures, others those of their own.
        """
        name = material if isinstance(material, str) else material.name
        if name in _GLOSSES:
            return _GLOSSES[name]
        if isinstance(material, str):
            known = load_materials()
            if name not in known:
                raise UnknownNameError("material", name, known)
            material = known[name]
        paper = _PAPERS.get(name, (1.0, 1.0) if material.is_felted else NO_PAPER)
        return cls(material.roughness, material.coat, paper=paper)

    @property
    def seen_roughness(self) -> float:
        """Roughness of the reflecting surface: the body, or the glaze over it."""
        return glazed_roughness(self.roughness, self.coat)


_GLOSSES = {
    "porcelain": Gloss(0.30, 0.90),
    "bisque": Gloss(0.75, 0.0),
    "xuan": Gloss(0.95, 0.0, paper=(1.0, 1.0)),
    "plaster": Gloss(0.9, 0.0),
    "terracotta": Gloss(0.8, 0.0),
}


# Glue fills pores: in washes on album leaves the L* of what is finer than .25 mm varies by .5 to .8
# where edges are crisp, by 1.1 to 2 where the sheet drinks. Silk is woven.
_PAPERS = {"sized xuan": (0.8, 0.5), "tinted xuan": (1.2, 0.8), "silk": NO_PAPER}


@dataclass(frozen=True)
class Softbox:
    """A soft-edged rectangle of light: centre direction, half-angles (rad), linear RGB radiance.

    One that is not `mirrored` stands for polarised light, whose reflection a filter on the camera
    removes lest it veil the ink; it lights all the same. Its light comes from `samples` directions.
    """

    centre: tuple[float, float, float]
    half_width: float
    half_height: float
    radiance: tuple[float, float, float]
    mirrored: bool = True
    samples: int = 40

    def axes(self) -> NDArray[np.float64]:
        """Return rows: to its right, its own up, and the direction of its centre, all unit."""
        towards = np.asarray(self.centre) / np.linalg.norm(self.centre)
        right = np.cross((0.0, 0.0, 1.0), towards)
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(towards, right), towards])

    def radiance_at(self, directions: AnyArray) -> NDArray[np.float64]:
        """Return the (N, 3) radiance along unit `directions` (N, 3), soft at the edges."""
        u, v, w = (directions @ self.axes().T).T
        ahead = np.maximum(w, 1e-3)
        inside_u = _soft_step((self.half_width - np.abs(np.arctan(u / ahead))) / 0.05)
        inside_v = _soft_step((self.half_height - np.abs(np.arctan(v / ahead))) / 0.05)
        result: NDArray[np.float64] = ((w > 0) * inside_u * inside_v)[:, None] * np.asarray(
            self.radiance
        )
        return result

    def suns(self) -> list[Sun]:
        """Return the box as equal parallel lights, on a golden lattice."""
        n = self.samples
        right, up, towards = self.axes()
        k = np.arange(n) + 0.5
        us = np.tan(self.half_width * (2 * k / n - 1))
        vs = np.tan(self.half_height * (2 * (k * GOLDEN % 1) - 1))
        light = np.asarray(self.radiance) * (4 * self.half_width * self.half_height / n)
        directions = [towards + u * right + v * up for u, v in zip(us, vs, strict=True)]
        return [Sun(d / np.linalg.norm(d), light) for d in directions]


@dataclass(frozen=True)
class Sun:
    """A parallel light standing for a part of the studio.

    Parameters
    ----------
    direction : (3,) array
        Unit vector toward it.
    irradiance : (3,) array
        On a surface that faces it, linear RGB.
    share : float
        The fraction of the sphere of directions that it samples evenly; 0 for extra lights.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    share: float = 0.0


@dataclass(frozen=True)
class Dome:
    """The surrounding room: radiance at the horizon, overhead, and of the lit floor below."""

    horizon: tuple[float, float, float]
    zenith: tuple[float, float, float]
    floor: tuple[float, float, float]

    def radiance_at(self, directions: AnyArray) -> NDArray[np.float64]:
        """Return the (N, 3) radiance along unit `directions` (N, 3)."""
        height = directions[:, 2:3]
        sky = np.asarray(self.horizon) + np.maximum(height, 0) * (
            np.asarray(self.zenith) - np.asarray(self.horizon)
        )
        result: NDArray[np.float64] = sky + _soft_step(-height / 0.03) * (
            np.asarray(self.floor) - sky
        )
        return result


DOME = Dome(horizon=(0.40, 0.41, 0.43), zenith=(0.62, 0.63, 0.65), floor=(0.50, 0.48, 0.455))
MIRRORED_SHADE = 0.65
SOFTBOXES = (
    Softbox(
        (-0.74, -0.78, 0.74), 0.25, 0.19, (15.0, 14.2, 13.2), samples=60
    ),  # warm key, front left
    Softbox((0.96, -0.12, 0.42), 0.09, 0.48, (4.0, 4.4, 5.0), samples=20),  # cool strip, right
    Softbox(
        (0.20, -1.00, 0.26), 0.60, 0.32, (1.15, 1.13, 1.10), mirrored=False
    ),  # broad fill, by the camera
    Softbox(
        (0.10, 0.85, 0.80), 0.60, 0.14, (3.0, 3.0, 3.0), samples=30
    ),  # rim light, behind and above
)


@dataclass(frozen=True)
class Studio:
    """The surrounding room and the softboxes in it."""

    dome: Dome
    softboxes: tuple[Softbox, ...] = ()


LIGHTS = {
    "studio": Studio(DOME, SOFTBOXES),
    # an overcast sky, three times as bright overhead as at the horizon (Moon and Spencer 1942)
    "soft": Studio(Dome((0.30, 0.30, 0.30), (0.90, 0.90, 0.90), (0.36, 0.35, 0.34))),
    # from low on the left: every unevenness of the shape casts a shadow
    "raking": Studio(
        Dome((0.10, 0.10, 0.11), (0.14, 0.14, 0.15), (0.10, 0.10, 0.10)),
        (Softbox((-1.0, -0.25, 0.30), 0.20, 0.14, (22.0, 21.0, 19.5), samples=60),),
    ),
}
"""Studios by name; "studio" is that of product pictures."""


def light_samples(n_dome: int = 96, studio: Studio = LIGHTS["studio"]) -> list[Sun]:
    """Return a studio as parallel lights, `n_dome` of them evenly over the whole sphere."""
    k = np.arange(n_dome) + 0.5
    height = 1 - 2 * k / n_dome
    turn = 2 * np.pi * GOLDEN * k
    level = np.sqrt(1 - height**2)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), height], axis=1)
    radiance = studio.dome.radiance_at(directions) * (4 * np.pi / n_dome)
    suns = [Sun(d, e, 1 / n_dome) for d, e in zip(directions, radiance, strict=True)]
    for box in studio.softboxes:
        suns += box.suns()
    return suns


def make_panorama(height: int = 256, studio: Studio = LIGHTS["studio"]) -> NDArray[np.float32]:
    """Return the panorama that the glaze reflects, (height, 2 height, 3) linear RGB.

    The floor is darker than in `light_samples`: the part that a wall reflects lies in the object's
    own shadow. Rows go from straight down to straight up; columns turn from -x over the camera's
    side.
    """
    elevation = ((np.arange(height) + 0.5) / height - 0.5) * np.pi
    turn = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2 * np.pi
    level = np.cos(elevation)[:, None]
    grid = np.broadcast_arrays(
        level * np.cos(turn), -level * np.sin(turn), np.sin(elevation)[:, None]
    )
    directions = np.stack(grid, axis=-1).reshape(-1, 3)
    radiance = studio.dome.radiance_at(directions)
    radiance *= 1 - MIRRORED_SHADE * _soft_step(-directions[:, 2:3] / 0.2)
    for box in filter(lambda box: box.mirrored, studio.softboxes):
        radiance += box.radiance_at(directions)
    return radiance.reshape(height, 2 * height, 3).astype(np.float32)


def _soft_step(x: AnyArray) -> NDArray[np.float64]:
    t = np.clip(0.5 + 0.5 * x, 0.0, 1.0)
    return t * t * (3 - 2 * t)


# ---- Tone ----------------------------------------------------------------------------------------
# Conversion between sRGB bytes and linear light (IEC 61966-2-1).


_LINEAR = decode_srgb(np.arange(256, dtype=np.uint8)).astype(np.float32)


def srgb_to_linear(srgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return linear light in [0, 1] for sRGB bytes of any shape."""
    return _LINEAR[srgb]


def linear_to_srgb(linear: AnyArray) -> AnyArray:
    """Return sRGB in [0, 1] for linear light in [0, 1] of any shape."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)

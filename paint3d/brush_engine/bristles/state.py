"""What a tuft of hairs remembers, and the scratch arrays that its kernels work in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.bristles import bend as bt
from paint3d.brush_engine.bristles.contact import CONTACT_SIZE, FINDINGS, LANDING_SIZE
from paint3d.brush_engine.bristles.ground_fit import PATCH_SIZE
from paint3d.brush_engine.bristles.imprint import Imprint, make_imprint
from paint3d.brush_engine.bristles.ink_transfer import LEVEL_BINS
from paint3d.brush_engine.footprint import PROFILE_CELLS
from paint3d.core.arrays import zeros_on_lines

__all__ = [
    "CAUSES",
    "KEPT",
    "MEMORY",
    "MEMORY_SIZE",
    "PARTED",
    "SPLIT",
    "TRACKED",
    "TRACKED_POINTS",
    "WAY",
    "Hairs",
    "make_hairs",
]

MEMORY = np.dtype(
    [
        ("set_x", "f8"),  # bend that stays, along the handle's axes: where it carries the tip, mm
        ("set_y", "f8"),
        ("parted", "f8"),  # how far clumps have parted, 0 to 1
        ("way", "f8"),  # since the last dip, mm
        ("unlevelled", "f8"),  # since hairs last shared their ink, mm
        ("split", "f8"),  # how far the tuft has split into points, 0 to 1
    ]
)
"""What a tuft of hairs remembers."""

CAUSES = 16  # numbers that hairs are bent by

KEPT = np.dtype(
    [
        ("touching", "f8"),  # hairs that touch, as they were bent last; 0: nothing is kept
        ("drawn", "f8"),  # 1.0 where they are also drawn so
        ("way", "f8"),  # of the tuft to where they were bent, mm
        ("cause", "f8", CAUSES),  # what they were bent by, in mm at the tuft's border
        ("now", "f8", CAUSES),  # and that of the stamp in hand
        ("heel", "f8"),  # of the outline drawn last, as of a stamp
        ("tip", "f8"),
        ("widest", "f8"),
        ("widest_at", "f8"),
        ("area", "f8"),
        ("half_widths", "f8", PROFILE_CELLS + 2),
    ],
    align=True,
)
"""How the hairs were bent and drawn last."""

MEMORY_SIZE = len(MEMORY.names)
PARTED, WAY, SPLIT = (MEMORY.names.index(name) for name in ("parted", "way", "split"))
TRACKED = 48  # hairs whose motion is watched: the outermost ones, all around
TRACKED_POINTS = 5  # of each, from the tip


class Hairs(NamedTuple):
    """Hairs of one painter (B hairs, P pigments)."""

    bristles: bt.Bristles
    load: NDArray  # (B, P) float64, ink in each, coats x mm2
    memory: NDArray  # (1,) of MEMORY
    pace: NDArray  # (2,) float64: how far between two samples, and the next step's fraction of it
    roll: NDArray  # (2,) float64, direction of the bend in the handle's axes, of `turned`
    turned: NDArray  # of `turn_hairs`
    bend: NDArray  # (1,) of BEND
    block: NDArray  # (BLOCK_SIZE,) float32
    points: NDArray  # (B / BLOCK, SAMPLES, 3 BLOCK) float32
    landing: NDArray  # (LANDING_SIZE,), where hairs come down, see `find_landings`
    slopes: NDArray  # (SAMPLES,) float32
    patch: NDArray  # (6,)
    patch_work: NDArray  # (12, 6)
    hair_contacts: NDArray  # (B / BLOCK, FINDINGS BLOCK) float32, see `contact`
    depths: NDArray  # (B / BLOCK,) float32, how far up the hairs of a block touch, in points
    clear: NDArray  # (CONTACT_SIZE,) float32
    known: NDArray  # (3,), see `know_hairs`
    kept: NDArray  # (1,) of KEPT
    kept_lines: NDArray  # as of a stamp
    sums: NDArray  # (3 BLOCK,) float32
    whole_sums: NDArray  # (BLOCK,)
    bins: NDArray  # (LEVEL_BINS, P + 1)
    released: NDArray  # (P,)
    left: NDArray  # (P,)
    track: NDArray  # (2, TRACKED, TRACKED_POINTS, 4): where outer hairs were and are; near the
    # surface the sum of their clumps' middles, else NaN
    imprint: Imprint


def make_hairs(bristles: bt.Bristles, load: NDArray, memory: NDArray) -> Hairs:
    """Arrays for painting with these hairs."""
    n_pigments = load.shape[1]
    blocks = len(bristles.lengths)
    return Hairs(
        bristles=bristles,
        load=load,
        memory=memory.view(MEMORY),
        pace=np.array([0.0, 1.0]),
        roll=np.full(2, np.nan),
        turned=bt.make_turned(blocks),
        bend=np.zeros(1, bt.BEND),
        block=bt.make_block(),
        points=bt.make_points(blocks),
        landing=np.zeros(LANDING_SIZE),
        slopes=np.zeros(bt.SAMPLES, np.float32),
        patch=np.zeros(PATCH_SIZE),
        patch_work=np.zeros((12, PATCH_SIZE)),
        hair_contacts=zeros_on_lines((blocks, FINDINGS * bt.BLOCK), np.float32),
        depths=np.zeros(blocks, np.float32),
        clear=zeros_on_lines(CONTACT_SIZE, np.float32),
        known=np.full(3, np.nan),
        kept=np.zeros(1, KEPT),
        kept_lines=np.zeros((2, PROFILE_CELLS), np.float32),
        sums=zeros_on_lines(3 * bt.BLOCK, np.float32),
        whole_sums=np.zeros(bt.BLOCK),
        bins=np.zeros((LEVEL_BINS, n_pigments + 1)),
        released=np.zeros(n_pigments),
        left=np.zeros(n_pigments),
        track=np.full((2, TRACKED, TRACKED_POINTS, 4), np.nan),
        imprint=make_imprint(n_pigments),
    )

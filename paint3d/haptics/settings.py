"""Settings of the force: the brush's, the device's limits, and the user's choices."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.spec import BrushSpec
from paint3d.colour.materials import WAVE_RANGE_MM, Material
from paint3d.core.array_state import known_fields
from paint3d.core.arrays import as_number
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import DeviceError
from paint3d.haptics.kernels import state as hs

__all__ = ["PHANTOM_DESKTOP", "TOUCH", "DeviceLimits", "Feel", "HapticSettings"]

_LOWEST_TILT = math.radians(30.0)  # limit of the model of the bent brush
_SAME_NAMES = (  # in HapticSettings and the kernels' record
    "length", "spring", "friction", "user_limit", "stick", "ramp_s", "slew", "max_pose_age_s",
    "max_snapshot_age_s", "start_force", "rise_s", "follow_s", "ahead_n", "click_n",
)  # fmt: skip
_TEXTURE = 0.25  # relative variation of the friction on the coarsest grain
_PATCH = 0.08  # radius over which the surface's normal is averaged, over the tuft's length


@dataclass(frozen=True, slots=True)
class DeviceLimits:
    """Limits of a force device: greatest force N, greatest stable stiffness N/mm."""

    max_force: float
    max_stiffness: float

    def __post_init__(self) -> None:
        as_number(self.max_force, "max_force", 0.0, 100.0, DeviceError)
        as_number(self.max_stiffness, "max_stiffness", 0.01, 20.0, DeviceError)


PHANTOM_DESKTOP = DeviceLimits(MAX_FORCE_N, 1.0)
"""The papers' device, on which paint3d's own stylus is modelled."""
TOUCH = DeviceLimits(3.3, 0.4)


@dataclass(frozen=True, slots=True)
class HapticSettings:
    """Settings of the force servo; times in s, forces in N, lengths in mm.

    Parameters
    ----------
    length, spring : float
        Of the brush: tuft length, lambda_c S in N/mm.
    friction : float
        mu, of brush and surface.
    limits : DeviceLimits
    user_limit : float
        The user's limit of the force.
    ramp_s : float
        Time over which a contact fades in, 0.010 to 0.020.
    slew : float
        Fastest change of the force, N/s.
    max_pose_age_s, max_snapshot_age_s : float
        If a pose or snapshot is older, the force is zero.
    start_force, rise_s : float
        At the start the force stays zero until the wanted one is below `start_force`, then rises
        over `rise_s`.
    stick : float
        Stiffness with which friction holds the foot before it slips, N/mm.
    follow_s : float
        Time constant with which the servo follows the object between two snapshots.
    grain : float
        Of the surface, 0 to 1: friction varies over it by up to a quarter, times this.
    wave_mm : float
        Wavelength of the grain.
    texture : float
        Fraction of the grain that is felt, 0 to 1.
    ahead_mm, ahead_n : float
        Anticipation: a force that begins at distance `ahead_mm` from the surface and grows to
        `ahead_n` at contact; 0 mm: none.
    click_n : float
        Greatest force of the click at a dip.

    Raises
    ------
    DeviceError
        If a value is out of range.
    """

    length: float
    spring: float
    friction: float
    limits: DeviceLimits = PHANTOM_DESKTOP
    user_limit: float = MAX_FORCE_N
    ramp_s: float = 0.015
    slew: float = 500.0
    max_pose_age_s: float = 0.005
    max_snapshot_age_s: float = 0.2
    start_force: float = 0.2
    rise_s: float = 2.0
    stick: float = 0.3
    follow_s: float = 0.02
    grain: float = 0.0
    wave_mm: float = 1.0
    texture: float = 1.0
    ahead_mm: float = 0.0
    ahead_n: float = 0.3
    click_n: float = 0.0

    def __post_init__(self) -> None:
        for name, low, high in (
            ("length", 1.0, 500.0),
            ("spring", 0.0, 20.0),
            ("friction", 0.0, 1.0),
            ("user_limit", 0.0, 100.0),
            ("ramp_s", 0.010, 0.020),
            ("slew", 1.0, 5000.0),
            ("max_pose_age_s", 0.001, 0.005),
            ("max_snapshot_age_s", 0.01, 0.2),
            ("start_force", 0.0, 0.2),
            ("rise_s", 0.1, 60.0),
            ("stick", 0.0, 20.0),
            ("follow_s", 0.0005, 0.2),
            ("grain", 0.0, 1.0),
            ("wave_mm", *WAVE_RANGE_MM),
            ("texture", 0.0, 1.0),
            ("ahead_mm", 0.0, 20.0),
            ("ahead_n", 0.0, 1.0),
            ("click_n", 0.0, 1.0),
        ):
            as_number(getattr(self, name), name, low, high, DeviceError)

    @classmethod
    def for_brush(
        cls,
        brush: BrushSpec,
        limits: DeviceLimits = PHANTOM_DESKTOP,
        material: Material | None = None,
        **more: float,
    ) -> HapticSettings:
        """Make the settings for a brush on a device; at pe = 1 the force is the device's greatest.

        Guo 2017 divides by the maximum output force of the device at hand, so a weaker device
        pushes back more softly instead of reaching its limit sooner. With a `material` the
        friction is that of brush and surface (Guo 2015, Eq. 5), and the surface's grain is felt;
        without, it is that of raw xuan, which has none.
        """
        spring = brush.spring * min(1.0, limits.max_force / brush.max_force)
        friction = brush.friction
        if material is not None:
            friction *= material.friction
            more = {
                "grain": material.grain if material.tooth_mm > 0.0 else 0.0,
                "wave_mm": material.wave_mm,
                **more,
            }
        return cls(brush.length_mm, spring, friction, limits, **more)

    @property
    def limit(self) -> float:
        """The smaller of the device's and the user's limit, N."""
        return min(self.limits.max_force, self.user_limit)

    def as_record(self) -> NDArray[np.void]:
        """Return the settings as the kernels take them, (1,) SETTINGS."""
        out = np.zeros(1, hs.SETTINGS)
        limits = self.limits
        out["device_limit"], out["stiffest"] = limits.max_force, limits.max_stiffness
        out["lowest_sine"] = math.sin(_LOWEST_TILT)
        out["patch"] = _PATCH * self.length
        out["texture"] = _TEXTURE * self.grain * self.texture
        out["wave"] = self.wave_mm
        out["ahead"] = self.ahead_mm
        for name in _SAME_NAMES:
            out[name] = getattr(self, name)
        return out


# ---- The user's choices --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Feel:
    """A user's choices for a haptic stylus.

    Parameters
    ----------
    limit_n : float
        Limit of the force, N, 0 to 7.9.
    anticipation_mm : float
        Distance at which the surface is felt before contact (Guo 2017, section 6), 0 to 20; 0: not.
    click_n : float
        Force of the click when the brush is dipped, N, 0 to 1; 0: none.
    texture : float
        Fraction of the surface's grain that is felt, 0 to 1.

    Raises
    ------
    DeviceError
        Naming what is out of range.
    """

    limit_n: float = MAX_FORCE_N
    anticipation_mm: float = 0.0
    click_n: float = 0.0
    texture: float = 1.0

    def __post_init__(self) -> None:
        as_number(self.limit_n, "limit_n", 0.0, MAX_FORCE_N, DeviceError)
        as_number(self.anticipation_mm, "anticipation_mm", 0.0, 20.0, DeviceError)
        as_number(self.click_n, "click_n", 0.0, 1.0, DeviceError)
        as_number(self.texture, "texture", 0.0, 1.0, DeviceError)

    @classmethod
    def from_dict(cls, stored: Mapping[str, float]) -> Feel:
        """Read the choices from a file's entries; unknown ones are ignored."""
        return cls(**known_fields(cls, stored))

    def as_dict(self) -> dict[str, float]:
        """Return all choices, ready for a file."""
        return dataclasses.asdict(self)

    def settings(
        self, brush: BrushSpec, limits: DeviceLimits, material: Material | None = None
    ) -> HapticSettings:
        """Make the servo's settings from the brush, the device, the surface and these choices."""
        return HapticSettings.for_brush(
            brush,
            limits,
            material,
            texture=self.texture,
            user_limit=self.limit_n,
            ahead_mm=self.anticipation_mm,
            click_n=self.click_n,
        )

"""What of a haptic stylus is the user's own choice, and the settings that follow from all of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import as_number
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import DeviceError
from paint3d.haptics.settings import DeviceLimits, HapticSettings

__all__ = ["Feel"]


@dataclass(frozen=True, slots=True)
class Feel:
    """A user's choices.

    Parameters
    ----------
    limit_n : float
        The stylus never pushes harder, N, 0 to 7.9.

    Raises
    ------
    DeviceError
        Naming what is out of range.
    """

    limit_n: float = MAX_FORCE_N

    def __post_init__(self) -> None:
        as_number(self.limit_n, "limit_n", 0.0, MAX_FORCE_N, DeviceError)

    @classmethod
    def from_words(cls, words: Mapping[str, float]) -> Feel:
        """Choices out of a file; what it does not know it passes over."""
        known = {own.name for own in dataclasses.fields(cls)}
        return cls(**{name: value for name, value in words.items() if name in known})

    def as_words(self) -> dict[str, float]:
        """Everything, ready for a file."""
        return dataclasses.asdict(self)

    def settings(self, brush: BrushSpec, limits: DeviceLimits) -> HapticSettings:
        """What the servo works with: of the brush, the device and these choices."""
        return HapticSettings.for_brush(brush, limits, user_limit=self.limit_n)

"""Points of light, such as stars or distant pinholes, described by their total light."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camsim.core.arrays import F64
from camsim.core.typed import Number, Place, Point, Positive, refusal, validate
from camsim.scene.primitives import Shape
from camsim.scene.raster import Field
from camsim.scene.shapes import Group
from camsim.spectra.curve import NumberOrCurve, Reflectance, Spectrum, spectrum_at

NOTHING = Group(shapes=())
"""Outline of a point: none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PointSource(Field):
    """A point of light. It has no area and hides nothing; what is painted after it and covers it hides it.

    electrons   : what all photosites together would collect of the point in one frame if all had the channel that
                  collects most (if they do not fill their pitch, the mean over positions), whatever the exposure
    photosites  : instead: number of photosites that a surface of this reflectance would cover to send as much light
    centre_um   : place of the point, anywhere between the photosites
    reflectance : colour of the point, as that of a surface in the scene's light

    >>> star = PointSource(electrons=2e4, centre_um=(0.3, -1.1))
    >>> star.electrons, star.reflectance
    (20000.0, 1.0)
    """

    electrons: Positive | None = None
    photosites: Positive | None = None
    centre_um: Point = (0.0, 0.0)
    reflectance: Reflectance = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            electrons: Number | None = None,
            photosites: Number | None = None,
            centre_um: Place = (0.0, 0.0),
            reflectance: NumberOrCurve = 1.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        if (self.electrons is None) == (self.photosites is None):
            twice = "given together with photosites; leave one out"
            missing = "missing; give one of electrons and photosites"
            raise refusal(self, "electrons", missing if self.electrons is None else twice)

    def exposed(self, wavelength_nm: F64, electrons: F64) -> PointSource:
        """Return the point in units of photosites; electrons: (channels, n) of a perfect diffuser, by wavelength."""
        if self.electrons is None:
            return self
        most = float((electrons @ spectrum_at(self.reflectance, wavelength_nm)).max())
        # Light without response in any channel counts as none.
        return dataclasses.replace(self, electrons=None, photosites=self.electrons / most if most > 0.0 else 1.0)

    @property
    def surfaces(self) -> tuple[Spectrum, ...]:
        """The spectrum of the point."""
        return (self.reflectance,)

    def frame(self, reflectance: Spectrum) -> Shape:
        """Return nothing, as a point has no outline."""
        return NOTHING

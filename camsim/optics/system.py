"""The optical system: the only place where transfer functions of stages are multiplied."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from camsim.core.arrays import F64
from camsim.core.custom import is_custom
from camsim.core.typed import check
from camsim.errors import UnsupportedError
from camsim.optics.photosite import SquarePhotosite
from camsim.optics.protocols import (
    KnowsBlur,
    KnowsCutoff,
    KnowsSize,
    KnowsWavelengths,
    LowPass,
    OpticalStage,
    PhotositeShape,
    Tilts,
)
from camsim.optics.sampled import sampled_otf

PLACES: dict[str, type] = {"lens": object, "olpf": LowPass, "photosite": PhotositeShape}
"""Roles of a stage, and the protocol that each requires; a stage that does not satisfy it is an additional blur."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticalSystem:
    """A lens, an optional OLPF and a photosite; ``more``: additional custom blurs.

    >>> from camsim.optics import Airy
    >>> system = OpticalSystem.of([Airy(f_number=8.0), SquarePhotosite(side_um=4.88)])
    >>> float(system.otf(np.array(0.0), np.array(0.0), 550.0))
    1.0
    """

    lens: OpticalStage
    olpf: LowPass | None = None
    photosite: PhotositeShape = field(default_factory=lambda: SquarePhotosite(side_um=0.0))
    more: tuple[OpticalStage, ...] = ()

    @classmethod
    def of(cls, stages: Sequence[OpticalStage]) -> OpticalSystem:
        """Return the system of a list of stages, with at most one stage for each role."""
        stages = check(stages, tuple[Any, ...], "optics")
        places: dict[str, Any] = {}
        more: list[OpticalStage] = []
        for stage in stages:
            if not callable(getattr(stage, "otf", None)):
                raise UnsupportedError(
                    f"{type(stage).__name__} has no otf(fx_per_um, fy_per_um, wavelength_nm); a stage needs that much",
                    key="optics",
                )
            place = getattr(stage, "place", None)
            if place is not None and place not in PLACES:
                raise UnsupportedError(
                    f"{type(stage).__name__}.place is {place!r}; it is one of {', '.join(PLACES)}", key="optics"
                )
            if place is None or not isinstance(stage, PLACES[place]):
                more.append(stage)
                continue
            if place in places:
                raise UnsupportedError(f"two stages for the {place}; give one", key="optics")
            places[place] = stage
        if "lens" not in places and more:
            places["lens"] = more.pop(0)
        if "lens" not in places:
            raise UnsupportedError("no lens; add camsim.Airy(f_number=…)", key="optics")
        return cls(**places, more=tuple(more))

    @property
    def stages(self) -> tuple[OpticalStage, ...]:
        """The stages present, in the order in which light passes them."""
        return tuple(stage for stage in (self.lens, *self.more, self.olpf, self.photosite) if stage is not None)

    def spots_um(self) -> F64:
        """Offsets (n, 2) of the OLPF's images of a point, of equal light, µm; one at 0 without an OLPF."""
        if self.olpf is None:
            return np.zeros((1, 2))
        spots: F64 = self.olpf.spots_um()
        return spots

    @property
    def extent_um(self) -> float:
        """Upper bound, µm, of how far the photosite, repeated at the OLPF's spots, reaches from its centre."""
        return float(np.hypot(*self.spots_um().T).max() + np.hypot(*self.photosite.half_extent_um))

    def footprint_otf(self, fx_per_um: F64, fy_per_um: F64) -> F64:
        """OTF of OLPF and photosite, which does not depend on the wavelength."""
        otf: F64 = self.photosite.otf(fx_per_um, fy_per_um, 0.0)
        return otf if self.olpf is None else otf * self.olpf.otf(fx_per_um, fy_per_um, 0.0)

    def point_otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float, *, sampled: bool = False) -> F64:
        """OTF of the lens and of every custom blur, which may depend on the wavelength.

        sampled : accurate to 1e-3 only, but in milliseconds, for a lens whose OTF is an integral at every frequency
        """
        otf_of_lens: Any = functools.partial(sampled_otf, self.lens) if sampled else self.lens.otf
        otf: F64 = otf_of_lens(fx_per_um, fy_per_um, wavelength_nm)
        for stage in self.more:
            otf = otf * stage.otf(fx_per_um, fy_per_um, wavelength_nm)
        return otf

    def point_otf_size(self, frequency_per_um: F64, direction: tuple[float, float], wavelength_nm: float) -> F64:
        """Absolute value of ``point_otf`` at frequencies along a unit vector, accurate enough for bounds."""
        fx, fy = frequency_per_um * direction[0], frequency_per_um * direction[1]
        if isinstance(self.lens, KnowsSize) and not self.more:
            return self.lens.otf_size(frequency_per_um, direction, wavelength_nm)
        return np.abs(self.point_otf(fx, fy, wavelength_nm))

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """OTF of the whole system."""
        product: F64 = self.point_otf(fx_per_um, fy_per_um, wavelength_nm) * self.footprint_otf(fx_per_um, fy_per_um)
        return product

    def ring_share(self, wavelength_nm: F64, of_cutoff: float = 1.0) -> float:
        """Largest transfer of OLPF and photosite at the frequency of a PSF's ringing, 1/λN, over all directions.

        of_cutoff : factor of that frequency
        """
        angle = np.pi * np.arange(RING_DIRECTIONS) / RING_DIRECTIONS
        some = np.linspace(0, wavelength_nm.size - 1, min(wavelength_nm.size, RING_WAVELENGTHS)).astype(int)
        frequency = of_cutoff / self.blurs_um(wavelength_nm[some])
        passes = self.footprint_otf(np.outer(np.cos(angle), frequency), np.outer(np.sin(angle), frequency))
        return float(np.abs(passes).max())

    @property
    def chromatic(self) -> bool:
        """Whether the transfer may change with the wavelength."""
        return bool(self.more) or not isinstance(self.lens, KnowsWavelengths) or self.lens.chromatic

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The cut-off frequency of the lens, cycles/µm; searched for if the lens does not declare it."""
        if isinstance(self.lens, KnowsCutoff):
            return float(self.lens.cutoff_per_um(wavelength_nm))
        return _cutoff(self.lens, wavelength_nm)

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the lens's PSF, µm; the inverse of the cut-off if the lens does not declare it."""
        if isinstance(self.lens, KnowsBlur):
            return float(self.lens.blur_um(wavelength_nm))
        return 1.0 / self.cutoff_per_um(wavelength_nm)

    def highest_per_um(self, wavelength_nm: F64) -> float:
        """The frequency beyond which nothing passes the lens at any of these wavelengths, cycles/µm."""
        cutoff_per_um = self.lens.cutoff_per_um if isinstance(self.lens, KnowsCutoff) else self.cutoff_per_um
        return max(float(cutoff_per_um(nm)) for nm in wavelength_nm.tolist())

    def blurs_um(self, wavelength_nm: F64) -> F64:
        """Scale of the lens's PSF (n,) at wavelengths (n,), µm."""
        blur_um = self.lens.blur_um if isinstance(self.lens, KnowsBlur) else self.blur_um
        return np.array([float(blur_um(nm)) for nm in wavelength_nm.tolist()])

    def without_tilt(self) -> tuple[OpticalSystem, tuple[float, float]]:
        """Return the system without the lens's tilt, and the displacement (x, y) of the PSF by that tilt, µm.

        For a custom lens only its ``otf`` counts, whatever it inherits.
        """
        if is_custom(self.lens) or not isinstance(self.lens, Tilts):
            return self, (0.0, 0.0)
        lens, moved_um = self.lens.without_tilt()
        return replace(self, lens=lens), moved_um


RING_DIRECTIONS, RING_WAVELENGTHS = 180, 24  # of ``ring_share``: it is smooth in both
NOTHING = 1e-14  # transfers below this are rounding
HIGHEST_PER_UM = 2.0**12


def _cutoff(lens: OpticalStage, wavelength_nm: float) -> float:
    """Return the cut-off frequency of a transfer over all directions, to 1 in 1000, cycles/µm."""
    angle = np.pi * np.arange(24) / 24.0
    cos, sin = np.cos(angle), np.sin(angle)

    def passes(radius: F64) -> bool:
        otf = lens.otf(np.multiply.outer(radius, cos), np.multiply.outer(radius, sin), wavelength_nm)
        return bool((np.abs(otf) > NOTHING).any())

    # Search from high frequencies down: a transfer may vanish within its band.
    high = HIGHEST_PER_UM
    if passes(np.array([high])):
        raise UnsupportedError(
            f"the transfer of {type(lens).__name__} does not end by {high:g} cycles/µm; "
            "give the stage a cutoff_per_um(wavelength_nm), or put a lens before it",
            key="optics",
        )
    while high > 1.0 / HIGHEST_PER_UM and not passes(np.linspace(0.5 * high, high, 64)):
        high *= 0.5
    low = 0.5 * high
    while high - low > 1e-3 * high:
        middle = 0.5 * (low + high)
        if passes(np.linspace(middle, high, 16)):
            low = middle
        else:
            high = middle
    return math.nextafter(high, math.inf)

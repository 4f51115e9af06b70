"""The stages as one: the only place where transfer functions are multiplied."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics.airy import Airy
from camsim.optics.gaussian import Gaussian
from camsim.optics.olpf import FourSpotOlpf
from camsim.optics.photosite import SquarePhotosite


class OpticalStage(Protocol):
    """Anything with a transfer function: a stage of the user's own needs no more than this."""

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticalSystem:
    """A lens, then perhaps an OLPF, then a photosite.

    >>> system = OpticalSystem.of([Airy(f_number=8.0), SquarePhotosite(side_um=4.88)])
    >>> float(system.otf(np.array(0.0), np.array(0.0), 550.0))
    1.0
    """

    lens: Airy | Gaussian
    olpf: FourSpotOlpf | None = None
    photosite: SquarePhotosite = field(default_factory=lambda: SquarePhotosite(side_um=0.0))

    @classmethod
    def of(cls, stages: Sequence[OpticalStage]) -> OpticalSystem:
        """Sort a list of stages into their places; each place holds one at the most."""
        places: dict[str, OpticalStage] = {}
        kinds = {Airy: "lens", Gaussian: "lens", FourSpotOlpf: "olpf", SquarePhotosite: "photosite"}
        for stage in stages:
            place = kinds.get(type(stage))
            if place is None:
                raise UnsupportedError(
                    f"optics: {type(stage).__name__} is not a stage the boundary engine knows; "
                    f"it takes {', '.join(kind.__name__ for kind in kinds)}"
                )
            if place in places:
                raise UnsupportedError(f"optics: two stages for the {place}; give one")
            places[place] = stage
        if "lens" not in places:
            raise UnsupportedError("optics: no lens; add camsim.Airy(f_number=…)")
        return cls(**places)  # type: ignore[arg-type]

    @property
    def stages(self) -> tuple[OpticalStage, ...]:
        """The stages that are there, in the order light meets them."""
        return tuple(stage for stage in (self.lens, self.olpf, self.photosite) if stage is not None)

    def spots_um(self) -> F64:
        """Offsets (n, 2) of the images that the OLPF makes of a point, equal in light; one at 0 without it."""
        return np.zeros((1, 2)) if self.olpf is None else self.olpf.spots_um()

    def footprint_otf(self, fx_per_um: F64, fy_per_um: F64) -> F64:
        """OTF of OLPF and photosite, the part that no wavelength changes."""
        otf = self.photosite.otf(fx_per_um, fy_per_um, 0.0)
        return otf if self.olpf is None else otf * self.olpf.otf(fx_per_um, fy_per_um, 0.0)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """OTF of the whole system."""
        product: F64 = self.lens.otf(fx_per_um, fy_per_um, wavelength_nm) * self.footprint_otf(fx_per_um, fy_per_um)
        return product

"""What stands in a lens's place on a sensor alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.core.arrays import F64


@dataclass(frozen=True, slots=True)
class NoLens:
    """No lens: light is given as it lies on the photosites (``Sensor``), and nothing blurs or dims it.

    >>> NoLens().transmission
    1.0
    """

    place: ClassVar[str] = "lens"
    f_number: ClassVar[float] = 1.0  # of a lens that dims and blurs nothing; frames say 0, as cameras do without one
    transmission: ClassVar[float] = 1.0

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Return 1: every frequency passes."""
        return np.ones(np.broadcast(fx_per_um, fy_per_um).shape)


NO_LENS = NoLens()

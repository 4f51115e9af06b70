"""Placeholder for the lens of a sensor without one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.core.arrays import F64


@dataclass(frozen=True, slots=True)
class NoLens:
    """No lens: light is given on the photosites (``Sensor``), and nothing blurs or dims it.

    >>> NoLens().transmission
    1.0
    """

    place: ClassVar[str] = "lens"
    f_number: ClassVar[float] = 1.0  # a neutral value; frames report 0, as cameras do without a lens
    transmission: ClassVar[float] = 1.0

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Return 1: every frequency passes."""
        return np.ones(np.broadcast(fx_per_um, fy_per_um).shape)


NO_LENS = NoLens()

"""Limits of the engines for edges and transforms: a PSF neither far finer nor far wider than a photosite.

Tables, tiles and boxes grow with either ratio; values beyond the limits suggest a length in a wrong unit.
"""

from __future__ import annotations

from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsBlur
from camsim.rendering.grid import Grid

LEAST_BLUR, MOST_BLUR = 1e-3, 1e4  # pitches
MOST_EXTENT = 1e3  # of OLPF and photosite from their centre, pitches


def check_scales(system: OpticalSystem, grid: Grid, wavelength_nm: F64) -> None:
    """Refuse a lens, an OLPF or a photosite whose size does not suit the pitch.

    >>> import numpy as np
    >>> from camsim.optics import Gaussian
    >>> check_scales(OpticalSystem(lens=Gaussian(sigma_um=1e-9)), Grid(rows=1, cols=1, pitch_um=4.0), np.ones(1))
    Traceback (most recent call last):
        ...
    camsim.errors.UnsupportedError: lens: its pattern is 2.5e-10 pitches of 4 µm wide; 0.001 to 10000 are \
rendered: look at the units of both
    """
    if isinstance(system.lens, KnowsBlur):
        for nm in (float(wavelength_nm.min()), float(wavelength_nm.max())):
            pitches = system.lens.blur_um(nm) / grid.pitch_um
            if not LEAST_BLUR <= pitches <= MOST_BLUR:
                raise UnsupportedError(
                    f"its pattern is {pitches:.3g} pitches of {grid.pitch_um:g} µm wide; {LEAST_BLUR:g} to "
                    f"{MOST_BLUR:g} are rendered: look at the units of both",
                    key="lens",
                )
    pitches = system.extent_um / grid.pitch_um
    if pitches > MOST_EXTENT:
        raise UnsupportedError(
            f"OLPF and photosite reach {pitches:.3g} pitches of {grid.pitch_um:g} µm from their middle; up to "
            f"{MOST_EXTENT:g} are rendered: look at the units of both",
            key="optics",
        )

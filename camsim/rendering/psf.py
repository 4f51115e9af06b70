"""The pattern of a lens on a lattice: from the lens itself where it knows it, else from its transfer function.

A transfer function has a cone at zero frequency, and its slope ends at the cut-off like (1 − u)^{3/2}. Along a ray it
is smooth in between, so a polar Gauss rule with u = 1 − s² integrates it as exactly as one likes.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator

import numpy as np

from camsim.arrays import F64
from camsim.kernels import shared
from camsim.kernels.round import add_round
from camsim.nonuniform import modes
from camsim.optics import OpticalSystem
from camsim.optics.protocols import InRows, OnLattice, Round
from camsim.quadrature import gauss_legendre
from camsim.radial_profile import MIDDLE, on_lattice

# All of the light is wrong by less than a hundredth of what the largest amplitude is wrong by (measured).
OF_LIGHT = 30.0
SPARE = 40  # nodes along a ray, and rays of a quarter of the plane, beyond what the fastest wave takes


def rule_of(waves: float) -> tuple[int, int]:
    """Return nodes along a ray and rays of half a plane, for waves out to a distance of so many of their lengths.

    On a circle n rays in each half of the plane are right for all orders below 2n, and a wave has those up to 2π·waves.
    As many more are for a blur of one's own, whose transfer goes round as fast as its own length asks for.
    """
    fastest = math.ceil(math.pi * waves)
    return fastest + SPARE, 2 * (fastest + SPARE)


def is_summed(system: OpticalSystem) -> bool:
    """Whether the pattern is summed from the transfer, as nobody knows it."""
    return bool(system.more) or not isinstance(system.lens, Round | OnLattice | InRows)


def point_spread_rows(
    system: OpticalSystem, x_um: F64, y_um: F64, wavelength_nm: float, *, precision: float
) -> Iterator[tuple[slice, F64]]:
    """Yield rows of the irradiance (y, x) per µm² on a lattice, of unit power: each once, and what is there.

    x_um, y_um : evenly spaced
    precision  : relative, of all of the light
    """
    lens = system.lens
    if is_summed(system):
        yield slice(0, y_um.size), _summed(system, x_um, y_um, wavelength_nm, precision)
    elif isinstance(lens, Round):
        yield slice(0, y_um.size), _round(lens, system.blur_um(wavelength_nm), x_um, y_um, wavelength_nm)
    elif isinstance(lens, InRows):
        yield from lens.point_spread_rows(x_um, y_um, wavelength_nm, OF_LIGHT * precision)
    elif isinstance(lens, OnLattice):
        yield slice(0, y_um.size), lens.point_spread_on(x_um, y_um, wavelength_nm, OF_LIGHT * precision)


def _round(lens: Round, blur_um: float, x_um: F64, y_um: F64, wavelength_nm: float) -> F64:
    """Return a round pattern (y, x), from what it is along its radius; 6e-14 of its peak."""
    along = functools.partial(lens.point_spread, wavelength_nm=wavelength_nm)
    powers, x, y = on_lattice(along, blur_um, x_um, y_um)
    pattern = np.zeros((y.size, x.size))

    def fill(begin: int, stop: int) -> None:
        add_round(pattern[begin:stop], powers, MIDDLE, x, y[begin:stop])

    shared(y.size, fill)
    return pattern


def _summed(system: OpticalSystem, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64:
    """Return the pattern (y, x) of the lens with every stage of the user's own, from its transfer."""
    cutoff = system.cutoff_per_um(wavelength_nm)
    reach_um = math.hypot(float(np.abs(x_um).max()), float(np.abs(y_um).max()))
    nodes, turns = rule_of(cutoff * reach_um)
    s, w = gauss_legendre(nodes)
    s, w = 0.5 * (1.0 + s), 0.5 * w
    angle = np.pi * np.arange(turns) / turns  # the other half of the plane is the conjugate
    radius = cutoff * (1.0 - s * s)
    fx, fy = np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle))
    rings = radius * cutoff * 2.0 * s * w * (2.0 * np.pi / turns)
    strengths = (rings[:, None] * system.point_otf(fx, fy, wavelength_nm)).astype(complex).ravel()
    steps = [float(axis[1] - axis[0]) if axis.size > 1 else 0.0 for axis in (y_um, x_um)]
    # The integers of a sum run about 0: the lattice's middle is moved there.
    middle = [float(axis[axis.size // 2]) for axis in (x_um, y_um)]
    if any(middle):
        strengths *= np.exp(2j * np.pi * (fx.ravel() * middle[0] + fy.ravel() * middle[1]))
    pattern = modes(
        (2.0 * np.pi * steps[0] * fy.ravel(), 2.0 * np.pi * steps[1] * fx.ravel()),
        strengths,
        (y_um.size, x_um.size),
        precision=max(precision, 1e-13),
        sign=1,
    )
    real: F64 = np.ascontiguousarray(pattern.real)
    return real

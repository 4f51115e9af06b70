"""A lens with aberrations as a round lens, moved, and what it has besides: a pattern of no light in all, and short.

A pattern's tail comes from the pupil's rim. Where that is a circle, so is the tail, moved by the wavefront's slope there.
With f in units of 1/λN the transfer along u begins 1 − (4/π)·f·⟨exp(4πi·f·s)⟩, s the slope ∂W/∂u on the rim in waves per
radius and ⟨⟩ its mean, weighed by |normal·u|. Terms that are even and smooth in f leave nothing far away. So, x λN from a
straight edge and with the mean slope taken as a move of 2·⟨s⟩·λN, what is left falls as

    (4/π³)·⟨s⟩/x² + (8/π³)·⟨s²⟩/x³        (s about the move)

where the first term is what no move can take (three-leaved and higher odd aberrations), and the rings' phase and size
differ by no more than ``rings`` says. Nearer than the geometric pattern, 2·max|s|, all may differ.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from camsim.arrays import F64
from camsim.optics.protocols import Round, RoundLens

RIM_POINTS, DIRECTIONS = 720, 36
STEP = 1e-4  # of a slope's difference, in radii
SQUARE, CUBE = 4.0 / math.pi**3, 8.0 / math.pi**3
RING = 1.0 / (2.0 * math.pi**4)  # what a line hears of an Airy pattern's rings, times x^(−5/2) (boundary/settings.py)
STEEPER = 30.0  # rings · waves of slope / x: what amplitudes at the rim differ by; 27 was measured of coma
NEAREST = 0.05  # of the cube's size that is left: as near the geometric pattern as it is taken to hold
FARTHEST, PER_DECADE = 1e7, 200  # where a reach is looked for, λN


class Bent(Protocol):
    """A lens of one pupil whose wavefront is known."""

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64: ...  # noqa: D102

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102

    def waves_across(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def blur_um(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def cutoff_per_um(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def point_spread_on(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64: ...  # noqa: D102

    def pupil_nodes(self, wavelength_nm: float) -> Callable[[float], float]: ...  # noqa: D102


class Core(RoundLens, Round, Protocol):
    """A round lens that knows its pattern."""


class Split(NamedTuple):
    """A lens as two: ``core`` with its pattern moved by ``moved_um`` (x, y), and ``rest``, None where that is nothing."""

    core: Core
    moved_um: tuple[float, float]
    rest: Difference | None


class Rim(NamedTuple):
    """Slopes on a pupil's rim or rims, waves per radius at one wavelength.

    move   : (2,) the mean slope, as far as it is one direction's;  square, cube: the largest over all directions of
             |⟨s⟩| and ⟨s²⟩ about it;  steepest: the largest slope about it
    rings  : how far the phases of opposite points of the rim differ, radians, the move apart
    """

    move: F64
    square: float
    cube: float
    steepest: float
    rings: float


def rim_of(lens: Bent, obstruction: float, wavelength_nm: float) -> Rim:
    """Measure the wavefront on the rim of a round pupil, and on that of its obstruction."""
    angle = 2.0 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    cos, sin = np.cos(angle), np.sin(angle)
    direction = np.stack([cos, sin], axis=1)[:: RIM_POINTS // DIRECTIONS]
    slopes, weights, odd = [], [], []
    for radius in (1.0, obstruction) if obstruction else (1.0,):
        x, y = radius * cos, radius * sin
        gx = lens.waves(x + STEP, y, wavelength_nm) - lens.waves(x - STEP, y, wavelength_nm)
        gy = lens.waves(x, y + STEP, wavelength_nm) - lens.waves(x, y - STEP, wavelength_nm)
        slopes.append(np.stack([gx, gy]) / (2.0 * STEP))
        weights.append(radius * np.abs(direction @ np.stack([cos, sin])))
        waves = lens.waves(x, y, wavelength_nm)
        odd.append((waves - np.roll(waves, RIM_POINTS // 2), x, y))
    slope, weight = np.concatenate(slopes, axis=1), np.concatenate(weights, axis=1)
    weight = weight / weight.sum(axis=1, keepdims=True)
    mean = np.einsum("dp,da,ap->d", weight, direction, slope)
    move = 2.0 * np.einsum("d,da->a", mean, direction) / len(direction)
    about = np.einsum("da,ap->dp", direction, slope - move[:, None])
    phase = [float(np.abs(w - 2.0 * (move[0] * x + move[1] * y)).max()) for w, x, y in odd]
    return Rim(
        move=move,
        square=float(np.abs(np.einsum("dp,dp->d", weight, about)).max()),
        cube=float(np.einsum("dp,dp->d", weight, about**2).max()),
        steepest=float(np.hypot(*(slope - move[:, None])).max()),
        rings=2.0 * math.pi * max(phase),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """What a lens has besides a round one that is moved: a transfer that is 0 at 0, a pattern of either sign.

    lens        : the whole;  core: the round part;  obstruction: of both, 0 … 1
    moved_um    : where the core's pattern has its centre
    """

    place: ClassVar[str] = "lens"

    lens: Bent
    core: Core
    obstruction: float
    moved_um: tuple[float, float]

    def blur_um(self, wavelength_nm: float) -> float:
        """The length of the pattern without aberrations, µm: λN."""
        return self.lens.blur_um(wavelength_nm)

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes, cycles/µm."""
        return self.lens.cutoff_per_um(wavelength_nm)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer of the whole less that of the core."""
        turn = np.exp(-2j * np.pi * (fx_per_um * self.moved_um[0] + fy_per_um * self.moved_um[1]))
        difference: F64 = self.lens.otf(fx_per_um, fy_per_um, wavelength_nm) - turn * self.core.otf(
            fx_per_um, fy_per_um, wavelength_nm
        )
        return difference

    def point_spread_on(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64:
        """Irradiance (y, x) per µm² of unit power, less the core's."""
        pattern = self.lens.point_spread_on(x_um, y_um, wavelength_nm, precision)
        radius = np.hypot(x_um - self.moved_um[0], (y_um - self.moved_um[1])[:, None])
        pattern -= self.core.point_spread(radius, wavelength_nm)
        return pattern

    def pupil_nodes(self, wavelength_nm: float) -> Callable[[float], float]:
        """Return what tells how many nodes the pattern takes out to a distance in µm."""
        return self.lens.pupil_nodes(wavelength_nm)

    def waves_across(self, wavelength_nm: float) -> float:
        """Return how far the wavefront goes up and down over the pupil, but for a plane, waves."""
        return self.lens.waves_across(wavelength_nm)

    def light_beyond(self, distance_um: F64, wavelength_nm: float, rings: float = 1.0) -> F64:
        """Return how much a straight edge of contrast 1 may show at distances and beyond; 1 where nothing is known.

        rings : what is left of the rings by what else stands in the light's way
        """
        rim = _rim_of(self, wavelength_nm)
        x = np.maximum(np.asarray(distance_um, float) / self.blur_um(wavelength_nm), 1e-3)
        inside = 1.0 - (2.0 * rim.steepest / x) ** 2
        swing = rings * RING * (min(2.0, rim.rings) + STEEPER * rim.steepest / x) * x**-2.5
        light = SQUARE * rim.square / x**2 + CUBE * rim.cube / (x**3 * np.maximum(inside, NEAREST)) + swing
        bound: F64 = np.where(inside > NEAREST, np.minimum(light / (1.0 - self.obstruction), 1.0), 1.0)
        return bound

    def reach_um(self, lost_fraction: float, wavelength_nm: float, rings: float = 1.0) -> float:
        """Return a distance beyond which ``light_beyond`` is at most that, µm."""
        x = np.geomspace(0.5, FARTHEST, math.ceil(PER_DECADE * math.log10(2.0 * FARTHEST)))
        light = self.light_beyond(x * self.blur_um(wavelength_nm), wavelength_nm, rings)
        loud = np.flatnonzero(light > lost_fraction)
        return float(x[min(loud[-1] + 1, x.size - 1)] if loud.size else x[0]) * self.blur_um(wavelength_nm)


@functools.lru_cache(maxsize=256)
def _rim_of(rest: Difference, wavelength_nm: float) -> Rim:
    return rim_of(rest.lens, rest.obstruction, wavelength_nm)
